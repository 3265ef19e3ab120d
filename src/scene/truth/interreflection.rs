//! What surfaces reflect to each other.

use nalgebra::Vector3;

use super::Convergence;
use super::distant::Shading;
use super::{check_samples, hemisphere};
use crate::parallel::{self, Watch};
use crate::scene::{Bvh, Materials, Mesh, View, Viewpoint, VisibilitySettings};
use crate::sphere::{CubeGrid, CubeMap};
use crate::{Error, Progress, Result};

/// The radiance of every vertex that has been reflected by 1…n other places of the mesh first.
///
/// ```math
/// L_k(v, wo) = ∫ L_{k−1}(h(v, ω), −ω) f(ω, wo) cos θ dω,  h the place that the ray from v along ω meets
/// ```
///
/// with L_0 the light that the mesh reflects directly, from any truth. Each integral is a sum over `samples`² equal
/// solid angles of the hemisphere, scaled so that their cosines sum to π as they should; radiance is interpolated over
/// the face that is met. Between two reflections, outgoing radiance is kept for every vertex: one value where no BRDF
/// depends on the view, else a cube map of it, looked up bilinearly. Faces are seen from their front only: the back of
/// one is black.
///
/// Instances and several objects are merged into one mesh first ([`Mesh::merge`]).
#[derive(Debug, Clone, Copy)]
pub struct Interreflection<'a> {
    /// The vertices.
    pub mesh: &'a Mesh,
    /// The hierarchy over the mesh.
    pub bvh: &'a Bvh,
    /// The vertices' BRDFs.
    pub materials: &'a Materials,
    /// The viewer.
    pub view: &'a View,
}

/// The radiance that leaves every vertex, before it reaches the viewer.
#[derive(Debug, Clone, PartialEq)]
pub enum Outgoing {
    /// The same in all directions, one a vertex.
    Diffuse(Vec<Vector3<f64>>),
    /// By the direction in the world that it leaves in, one map a vertex.
    Directional(Vec<CubeMap<Vector3<f64>>>),
}

impl Outgoing {
    /// Radiance by direction: `radiance(ω)` is that of all vertices into the unit direction ω, as a truth has it for
    /// the view [`View::towards`] ω.
    ///
    /// # Errors
    /// Those of `radiance`; [`Error::Length`] unless all its lists are equally long.
    pub fn by_direction(
        grid: CubeGrid,
        mut radiance: impl FnMut(&Vector3<f64>) -> Result<Vec<Vector3<f64>>>,
    ) -> Result<Self> {
        let lists = grid.directions().iter().map(|direction| radiance(direction)).collect::<Result<Vec<_>>>()?;
        let vertices = lists[0].len();
        if let Some(list) = lists.iter().find(|list| list.len() != vertices) {
            return Err(Error::Length { what: "vertices with radiance", expected: vertices, got: list.len() });
        }
        let map = |vertex: usize| CubeMap::new(grid, lists.iter().map(|list| list[vertex]).collect());
        Ok(Self::Directional((0..vertices).map(map).collect::<Result<_>>()?))
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        match self {
            Self::Diffuse(values) => values.len(),
            Self::Directional(maps) => maps.len(),
        }
    }

    fn towards(&self, vertex: usize, direction: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Diffuse(values) => values[vertex],
            Self::Directional(maps) => maps[vertex].bilinear(direction),
        }
    }
}

/// Vertices that a thread takes at a time.
const CHUNK: usize = 16;

impl Interreflection<'_> {
    /// The radiance of every vertex after 1, 2, … `bounces` further reflections, added up; `direct` itself is not part
    /// of it.
    ///
    /// `progress` counts vertices, once for every bounce.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless `samples` is in 1…4096; [`Error::Length`] if `direct` or the materials do not fit
    /// the mesh; [`Error::OutOfRange`] for [`Outgoing::Diffuse`] where a BRDF depends on the view; [`Error::NotFinite`]
    /// for a BRDF with values that are NaN or infinite; [`Error::Cancelled`].
    pub fn radiance(
        &self,
        direct: &Outgoing,
        bounces: usize,
        samples: usize,
        progress: &dyn Progress,
    ) -> Result<Vec<Vector3<f64>>> {
        let vertices = self.mesh.positions().len();
        check_samples(samples)?;
        self.materials.check(vertices)?;
        if direct.vertices() != vertices {
            let what = "vertices with direct light";
            return Err(Error::Length { what, expected: vertices, got: direct.vertices() });
        }
        if matches!(direct, Outgoing::Diffuse(_)) && !self.materials.is_view_independent() {
            let what = "directions of outgoing radiance";
            return Err(Error::OutOfRange {
                what,
                got: 1.0,
                allowed: "those of a map, for BRDFs that depend on the view",
            });
        }
        let starts = Viewpoint::of_vertices(self.mesh, VisibilitySettings::default().offset)?;
        let starts: Vec<Vector3<f64>> = starts.iter().map(Viewpoint::position).collect();
        let hemisphere = hemisphere(samples);
        let omega = std::f64::consts::PI / hemisphere.iter().map(|d| d.z).sum::<f64>();
        let watch = Watch::new(progress, vertices.saturating_mul(bounces));
        let (mut sum, mut before) = (vec![Vector3::zeros(); vertices], direct.clone());
        for bounce in 0..bounces {
            let is_last = bounce + 1 == bounces;
            let mut next: Vec<(Vector3<f64>, Option<Vertex>)> = vec![(Vector3::zeros(), None); vertices];
            parallel::try_chunks(&mut next, CHUNK, Vec::new, |index, chunk, incident| {
                for (i, out) in chunk.iter_mut().enumerate() {
                    watch.check()?;
                    let vertex = index * CHUNK + i;
                    self.gather(vertex, &starts[vertex], &before, (&hemisphere, omega), incident);
                    *out = self.reflect(vertex, incident, &before, is_last);
                    if !out.0.iter().all(|c| c.is_finite()) {
                        return Err(self.materials.not_finite(vertex));
                    }
                }
                watch.advance(chunk.len());
                Ok(())
            })?;
            sum.iter_mut().zip(&next).for_each(|(sum, (seen, _))| *sum += seen);
            if !is_last {
                before = match &before {
                    Outgoing::Diffuse(_) => Outgoing::Diffuse(next.into_iter().map(|(seen, _)| seen).collect()),
                    Outgoing::Directional(_) => Outgoing::Directional(next.into_iter().filter_map(|n| n.1).collect()),
                };
            }
        }
        Ok(sum)
    }

    /// The same for twice as many samples again and again, from `first` to at most `most`, until the result moves by no
    /// more than `tolerance` (relative L2).
    ///
    /// # Errors
    /// Those of [`radiance`](Self::radiance) and [`Convergence::by_doubling`].
    pub fn converged(
        &self,
        direct: &Outgoing,
        bounces: usize,
        [first, most]: [usize; 2],
        tolerance: f64,
        progress: &dyn Progress,
    ) -> Result<Convergence> {
        Convergence::by_doubling(first, most, tolerance, |n| self.radiance(direct, bounces, n, progress))
    }

    /// Directions of the world and L dω of what a vertex sees of the mesh, in solid angles `omega` about local
    /// directions.
    fn gather(
        &self,
        vertex: usize,
        start: &Vector3<f64>,
        outgoing: &Outgoing,
        (hemisphere, omega): (&[Vector3<f64>], f64),
        incident: &mut Vec<(Vector3<f64>, Vector3<f64>)>,
    ) {
        let frame = self.mesh.local_frame(vertex);
        incident.clear();
        for local in hemisphere {
            let direction = frame.to_world(local);
            let Some(hit) = self.bvh.closest_hit(start, &direction) else { continue };
            let [a, b, c] = self.mesh.corners(hit.face as usize).map(|p| p.cast::<f64>());
            if (b - a).cross(&(c - a)).dot(&direction) >= 0.0 {
                continue;
            }
            let corners = self.mesh.faces()[hit.face as usize];
            let radiance: Vector3<f64> = (0..3)
                .map(|k| outgoing.towards(corners[k] as usize, &-direction) * f64::from(hit.barycentric[k]))
                .sum();
            incident.push((direction, radiance * omega));
        }
    }

    /// What of it a vertex reflects to the viewer and, for a further bounce, in all directions.
    fn reflect(
        &self,
        vertex: usize,
        incident: &[(Vector3<f64>, Vector3<f64>)],
        before: &Outgoing,
        is_last: bool,
    ) -> (Vector3<f64>, Option<Vertex>) {
        let mut shading = Shading::new(self.mesh, self.materials, self.view, vertex);
        let sum = |shading: &Shading| -> Vector3<f64> {
            if shading.wo.z <= 0.0 {
                return Vector3::zeros();
            }
            incident.iter().map(|(direction, irradiance)| shading.reflect(direction, irradiance)).sum()
        };
        let seen = sum(&shading);
        let map = match before {
            Outgoing::Directional(maps) if !is_last => Some(CubeMap::from_fn(maps[vertex].grid(), |direction| {
                shading.wo = shading.axes.to_local(&direction);
                sum(&shading)
            })),
            _ => None,
        };
        (seen, map)
    }
}

/// Outgoing radiance of one vertex by direction.
type Vertex = CubeMap<Vector3<f64>>;
