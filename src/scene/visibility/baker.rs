//! Visibility of every texel from every vertex.

use std::sync::Arc;

use nalgebra::Vector3;

use super::directions::Directions;
use super::occluders::Occluders;
use super::tracer::{VisibilityScratch, VisibilityTracer};
use super::viewpoint::Viewpoint;
use super::{BinaryVisibility, FractionalVisibility};
use crate::error::check_length;
use crate::scene::{Bvh, Mesh};
use crate::sphere::CubeGrid;
use crate::{Progress, Result};

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
    tracer: VisibilityTracer,
    grid: CubeGrid,
    viewpoints: Arc<[Viewpoint]>,
}

impl VisibilityBaker {
    /// A plan for every vertex of a mesh.
    ///
    /// Cost: about 1 µs a face.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless 0 ≤ `settings.offset` ≤ 1.
    pub fn new(mesh: &Mesh, grid: CubeGrid, settings: VisibilitySettings) -> Result<Self> {
        let viewpoints = Viewpoint::of_vertices(mesh, settings.offset)?;
        let occluders = Occluders::of_mesh(mesh).with_back_faces(settings.back_faces);
        let tracer = VisibilityTracer::new(occluders, Directions::cube(grid));
        Ok(Self { tracer, grid, viewpoints: viewpoints.into() })
    }

    /// The same plan on another grid; the hierarchy is shared, not built again.
    #[must_use]
    pub fn with_grid(&self, grid: CubeGrid) -> Self {
        self.with_directions(grid, Directions::cube(grid))
    }

    fn with_directions(&self, grid: CubeGrid, directions: Directions) -> Self {
        let tracer = VisibilityTracer::new(Arc::clone(self.tracer.occluders()), directions);
        Self { tracer, grid, viewpoints: Arc::clone(&self.viewpoints) }
    }

    /// The grid of the maps.
    pub fn grid(&self) -> CubeGrid {
        self.grid
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.viewpoints.len()
    }

    /// The hierarchy over the mesh, for other rays.
    pub fn bvh(&self) -> &Bvh {
        self.tracer.occluders().bvh(0)
    }

    /// What does the work, for other maps against the same mesh.
    pub fn tracer(&self) -> &VisibilityTracer {
        &self.tracer
    }

    /// Where the rays of a vertex start, in the world.
    ///
    /// # Panics
    /// If `vertex` is out of range.
    #[track_caller]
    pub fn origin(&self, vertex: usize) -> Vector3<f64> {
        let scale = self.bvh().scale();
        (self.viewpoints[vertex].position() * scale).map(|c| f64::from(c as f32)) / scale
    }

    /// Work space for one thread.
    pub fn scratch(&self) -> VisibilityScratch {
        self.tracer.scratch()
    }

    /// Words of one vertex in the layout of [`BinaryVisibility`].
    pub fn words_per_vertex(&self) -> usize {
        self.tracer.directions().words()
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
        self.tracer.trace(&self.viewpoints[vertex], words, scratch)
    }

    /// One texel of one vertex by testing every face of the mesh: the same bit as the fast path, slowly.
    ///
    /// # Panics
    /// If `vertex` or `texel` is out of range.
    #[track_caller]
    pub fn sees_brute_force(&self, vertex: usize, texel: usize) -> bool {
        self.tracer.sees_brute_force(&self.viewpoints[vertex], texel)
    }

    /// The visibility of all vertices, in parallel.
    ///
    /// `progress` counts vertices.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled) if `progress` asked to stop,
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) if the result does not fit in memory.
    pub fn bake(&self, progress: &dyn Progress) -> Result<BinaryVisibility> {
        Ok(BinaryVisibility::from_parts(self.grid, self.tracer.trace_batch(&self.viewpoints, progress)?))
    }

    /// The visibility of all vertices with `samples` × `samples` rays a texel, in parallel.
    ///
    /// `progress` counts vertices. Cost: that of binary visibility at `samples` times the side.
    ///
    /// # Errors
    /// Those of [`bake`](Self::bake), and [`Error::OutOfRange`](crate::Error::OutOfRange) unless 1 ≤ `samples` ≤ 15 and
    /// the side times `samples` is at most [`CubeGrid::MAX_SIDE`].
    pub fn bake_fractional(&self, samples: usize, progress: &dyn Progress) -> Result<FractionalVisibility> {
        let fine = self.with_directions(self.grid, Directions::cube(self.grid).with_samples(samples)?);
        let counts = fine.tracer.count_batch(&fine.viewpoints, progress)?;
        Ok(FractionalVisibility::from_parts(self.grid, samples, counts))
    }
}
