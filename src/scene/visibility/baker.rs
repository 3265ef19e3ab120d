//! Visibility of every texel from every vertex.

use std::sync::Arc;

use nalgebra::Vector3;

use super::fractional::check_samples;
use super::live::LiveRays;
use super::origin::origins;
use super::trace::{TraceFace, View, Waiting, centre, occluded};
use super::{BinaryVisibility, FractionalVisibility};
use crate::error::check_length;
use crate::parallel::{self, Watch};
use crate::scene::bvh::FARTHEST_ORIGIN;
use crate::scene::{Bvh, Mesh};
use crate::sphere::{CubeGrid, Face};
use crate::{Error, Progress, Result};

/// Whether a face stops light that comes from behind it.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum BackFaces {
    /// Faces occlude from both sides.
    #[default]
    Occlude,
    /// Only faces that turn their front (counter-clockwise) to the vertex occlude. A closed surface then occludes what
    /// is outside of it only: a vertex inside one sees through its wall.
    Ignore,
}

/// How visibility is baked.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct VisibilitySettings {
    /// Which sides of a face occlude.
    pub back_faces: BackFaces,
    /// How far rays start from the surface, as a share of the shortest edge from the vertex; default 2⁻¹⁶.
    ///
    /// Whatever it is, rays start at least four roundings of the vertex's own coordinates away. Nothing else in the
    /// mesh matters.
    ///
    /// Too small and a vertex that only touches another surface, without sharing its vertices, may start on that one's
    /// wrong side by rounding. Too large and contact shadows begin late, and rays of vertices near a thin wall start
    /// behind it.
    pub offset: f64,
}

impl Default for VisibilitySettings {
    fn default() -> Self {
        Self { back_faces: BackFaces::default(), offset: 1.0 / 65536.0 }
    }
}

impl VisibilitySettings {
    /// The same with another treatment of back faces.
    #[must_use]
    pub fn with_back_faces(self, back_faces: BackFaces) -> Self {
        Self { back_faces, ..self }
    }

    /// The same with another offset.
    #[must_use]
    pub fn with_offset(self, offset: f64) -> Self {
        Self { offset, ..self }
    }
}

/// A plan that finds which texels of a cube map each vertex of a mesh sees.
///
/// A texel is seen if the direction through its centre is above the vertex's horizon (n·ω > 0 with the shading normal;
/// reflectance is zero below, so no ray is sent there) and meets no face.
///
/// **Where rays start.** At the vertex, moved by the offset δ along its shading normal, so that it does not meet its
/// own faces, and by up to δ along the surface towards the middle of its own faces. The second move is zero inside a
/// smooth surface; at a hard edge, where vertices are split, it takes the origin off the neighbouring wall's plane, so
/// that no light leaks through the corner of a room. δ is [`VisibilitySettings::offset`] times the shortest edge from
/// the vertex, and at least four roundings of the vertex's own coordinates (those along which it is moved). So it
/// follows what is there, not the size of the scene: a face far away, or a wide ground, changes nothing near. A convex
/// mesh sees its whole upper hemisphere: texels that rise less than 10⁻³ rad above the horizon may be lost to rounding,
/// none above.
///
/// **What occludes.** All rays of a vertex share an origin, so each face of the cube is rasterised front to back
/// through a hierarchy of boxes. A ray meets a triangle if it is on the inner side of its three edges, each widened by
/// the bound of its `f32` rounding error: a ray that meets a triangle in exact arithmetic is always occluded, so that
/// nothing leaks through the edges and corners that faces share. A ray is occluded wrongly only within 20 roundings of
/// an edge function's terms: about 2·10⁻⁶ rad beside an edge seen from its side. Faces without area occlude nothing.
/// Holes and open borders are what they are: light passes.
///
/// The same bits for any number of threads, with and without `rayon`.
///
/// Cost: 12 to 30 million rays a second a core at 64² texels a face and 200,000 faces (Zen 3, portable build), or 0.4
/// to 1 ms a vertex. Memory: 3 KiB a vertex at 64², and about 115 B a face of the mesh.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Vector3, scene::{Mesh, VisibilityBaker, VisibilitySettings}, sphere::CubeGrid};
/// let corners = [[0., 0., 0.], [0., 0., 1.], [1., 0., 0.]].map(Vector3::from);
/// let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2]])?;
/// let baker = VisibilityBaker::new(&mesh, CubeGrid::new(16)?, VisibilitySettings::default())?;
/// let visibility = baker.bake(&())?;
/// // A single triangle shadows nothing: half of all directions are above it.
/// assert_eq!(visibility.count_ones(0), 6 * 16 * 16 / 2);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct VisibilityBaker {
    scene: Arc<Scene>,
    grid: CubeGrid,
    centres: Vec<f64>,
    centres_f32: Vec<f32>,
    arch: pulp::Arch,
}

/// What does not depend on the grid.
#[derive(Debug)]
struct Scene {
    bvh: Bvh,
    /// In the scale of the hierarchy.
    origins: Vec<[f32; 3]>,
    normals: Vec<Vector3<f32>>,
    back_faces: BackFaces,
}

/// Work space of one thread for [`VisibilityBaker::bake_vertex`].
#[derive(Debug, Clone)]
pub struct VisibilityScratch {
    live: LiveRays,
    stack: Vec<Waiting>,
}

impl VisibilityBaker {
    /// A plan for every vertex of a mesh.
    ///
    /// Cost: about 1 µs a face.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 0 ≤ `settings.offset` ≤ 1.
    pub fn new(mesh: &Mesh, grid: CubeGrid, settings: VisibilitySettings) -> Result<Self> {
        if !(0.0..=1.0).contains(&settings.offset) {
            return Err(Error::OutOfRange { what: "visibility offset", got: settings.offset, allowed: "in [0, 1]" });
        }
        let bvh = Bvh::new(mesh);
        let origins = origins(mesh, bvh.scale(), settings.offset);
        let scene = Scene { bvh, origins, normals: mesh.normals().to_vec(), back_faces: settings.back_faces };
        Ok(Self::on(Arc::new(scene), grid))
    }

    /// The same plan on another grid; the hierarchy is shared, not built again.
    #[must_use]
    pub fn with_grid(&self, grid: CubeGrid) -> Self {
        Self::on(Arc::clone(&self.scene), grid)
    }

    fn on(scene: Arc<Scene>, grid: CubeGrid) -> Self {
        let centres: Vec<f64> = (0..grid.side()).map(|i| grid.centre(i)).collect();
        let centres_f32 = (0..grid.side()).map(|i| centre(grid.side(), i)).collect();
        Self { scene, grid, centres, centres_f32, arch: pulp::Arch::new() }
    }

    /// The grid of the maps.
    pub fn grid(&self) -> CubeGrid {
        self.grid
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.scene.origins.len()
    }

    /// The hierarchy over the mesh, for other rays.
    pub fn bvh(&self) -> &Bvh {
        &self.scene.bvh
    }

    /// Where the rays of a vertex start, in the world.
    ///
    /// # Panics
    /// If `vertex` is out of range.
    #[track_caller]
    pub fn origin(&self, vertex: usize) -> Vector3<f64> {
        Vector3::from(self.scene.origins[vertex]).cast() / self.scene.bvh.scale()
    }

    /// Work space for one thread.
    pub fn scratch(&self) -> VisibilityScratch {
        VisibilityScratch {
            live: LiveRays::new(self.grid.side()),
            stack: Vec::with_capacity(self.scene.bvh.stack_len()),
        }
    }

    /// Words of one vertex in the layout of [`BinaryVisibility`].
    pub fn words_per_vertex(&self) -> usize {
        6 * BinaryVisibility::words_per_face(self.grid)
    }

    /// The visibility of one vertex, into the caller's words (whatever they held before).
    ///
    /// Returns how many texels are above the horizon: the rays that were traced.
    ///
    /// # Panics
    /// If `vertex` is out of range, `words` has another length than [`words_per_vertex`](Self::words_per_vertex), or
    /// `scratch` is of a baker with another grid.
    #[track_caller]
    pub fn bake_vertex(&self, vertex: usize, words: &mut [u64], scratch: &mut VisibilityScratch) -> u64 {
        check_length("visibility words of a vertex", self.words_per_vertex(), words.len());
        words.fill(0);
        let per_face = BinaryVisibility::words_per_face(self.grid);
        self.trace(vertex, scratch, |face, live| live.pack(&mut words[face * per_face..][..per_face]))
    }

    /// Traces the six faces of a vertex and hands over those with a ray above the horizon.
    fn trace(&self, vertex: usize, scratch: &mut VisibilityScratch, mut done: impl FnMut(usize, &LiveRays)) -> u64 {
        let scene = &*self.scene;
        let (origin, normal) = (scene.origins[vertex], scene.normals[vertex].cast::<f64>());
        // Seen from so far away the mesh is smaller than any texel.
        let far = !origin.iter().all(|c| c.abs() < FARTHEST_ORIGIN);
        let VisibilityScratch { live, stack } = scratch;
        check_length("side of the scratch's grid", self.grid.side(), live.side());
        let mut rays = 0;
        for face in Face::ALL {
            let normal = face.axes().map(|axis| Vector3::from(axis).dot(&normal));
            let above = live.keep_above(normal, &self.centres);
            if above == 0 {
                continue;
            }
            rays += above;
            if !far {
                let view = View::new(face, origin, self.grid.side(), scene.back_faces);
                self.arch.dispatch(TraceFace { bvh: &scene.bvh, view, live, centres: &self.centres_f32, stack });
            }
            done(face as usize, live);
        }
        rays
    }

    /// One texel of one vertex by testing every face of the mesh: the same bit as the fast path, slowly.
    ///
    /// # Panics
    /// If `vertex` or `texel` is out of range.
    #[track_caller]
    pub fn sees_brute_force(&self, vertex: usize, texel: usize) -> bool {
        let (face, x, y) = self.grid.texel(texel);
        let direction = face.point(self.centres[x], self.centres[y]);
        if self.scene.normals[vertex].cast::<f64>().dot(&direction) <= 0.0 {
            return false;
        }
        let origin = self.scene.origins[vertex];
        if !origin.iter().all(|c| c.abs() < FARTHEST_ORIGIN) {
            return true;
        }
        let view = View::new(face, origin, self.grid.side(), self.scene.back_faces);
        !occluded(&self.scene.bvh, &view, x, y, &self.centres_f32)
    }

    /// The visibility of all vertices, in parallel.
    ///
    /// `progress` counts vertices.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if `progress` asked to stop, [`Error::OutOfRange`] if the result does not fit in memory.
    pub fn bake(&self, progress: &dyn Progress) -> Result<BinaryVisibility> {
        let per_vertex = self.words_per_vertex();
        let words = self.fill(per_vertex, progress, |vertex, words, scratch| {
            self.bake_vertex(vertex, words, scratch);
        })?;
        Ok(BinaryVisibility::from_parts(self.grid, words))
    }

    /// The visibility of all vertices with `samples` × `samples` rays a texel, in parallel.
    ///
    /// `progress` counts vertices. Cost: that of binary visibility at `samples` times the side.
    ///
    /// # Errors
    /// Those of [`bake`](Self::bake), and [`Error::OutOfRange`] unless 1 ≤ `samples` ≤ 15 and the side times `samples`
    /// is at most [`CubeGrid::MAX_SIDE`].
    pub fn bake_fractional(&self, samples: usize, progress: &dyn Progress) -> Result<FractionalVisibility> {
        check_samples(samples)?;
        let fine = self.with_grid(CubeGrid::new(self.grid.side() * samples)?);
        let counts = fine.fill(self.grid.len(), progress, |vertex, counts, scratch| {
            let per_face = self.grid.face_len();
            fine.trace(vertex, scratch, |face, live| live.count(samples, &mut counts[face * per_face..][..per_face]));
        })?;
        Ok(FractionalVisibility::from_parts(self.grid, samples, counts))
    }

    /// Runs `one` for every vertex on its `per_vertex` elements of one zeroed list.
    fn fill<T: Copy + Default + Send>(
        &self,
        per_vertex: usize,
        progress: &dyn Progress,
        one: impl Fn(usize, &mut [T], &mut VisibilityScratch) + Sync,
    ) -> Result<Vec<T>> {
        let vertices = self.vertices();
        let mut all = Vec::new();
        let too_large = || Error::OutOfRange {
            what: "bytes of visibility",
            got: vertices as f64 * per_vertex as f64 * size_of::<T>() as f64,
            allowed: "what fits in memory",
        };
        let len = vertices.checked_mul(per_vertex).ok_or_else(too_large)?;
        all.try_reserve_exact(len).map_err(|_| too_large())?;
        all.resize(len, T::default());
        // A few hundred pieces: enough to balance threads, few enough to report each.
        let piece = vertices.div_ceil(256);
        let watch = Watch::new(progress, vertices);
        parallel::try_chunks(
            &mut all,
            piece * per_vertex,
            || self.scratch(),
            |index, part, scratch| {
                for (k, values) in part.chunks_exact_mut(per_vertex).enumerate() {
                    if k % 8 == 0 {
                        watch.check()?;
                    }
                    one(index * piece + k, values, scratch);
                }
                watch.advance(part.len() / per_vertex);
                Ok(())
            },
        )?;
        Ok(all)
    }
}
