//! The right answer for lamps.

use nalgebra::Vector3;

use super::Convergence;
use super::distant::Shading;
use super::fog::{Fog, SHORT_OF_THE_LAMP};
use super::{check_samples, hemisphere};
use crate::parallel::{self, Watch};
use crate::scene::{LocalLight, Materials, Mesh, Occluders, View, Viewpoint, VisibilitySettings};
use crate::{Progress, Result};

/// The radiance of every vertex under lamps, summed over parts of each lamp.
///
/// ```math
/// L_o(v) = Σ ∫ L(ω) V(v, ω) f(ω, wo(v)) max(cos θ, 0) dω
/// ```
///
/// in `f64`, by the midpoint rule over parts of the lamps ([`LocalLight::sample`]), a shadow ray to each. In fog, light
/// is dimmed on its way, and what the fog scatters once towards the surface is added, by [`Fog::airlight`] in
/// `samples`² directions of the hemisphere; what the fog does between surface and viewer is not part of it.
///
/// Rays start where those of visibility do ([`VisibilitySettings`]). A vertex seen from behind is black, unless its
/// BRDF does not depend on the view. Parallel over vertices; the same bits for any number of threads.
#[derive(Debug, Clone, Copy)]
pub struct LocalTruth<'a> {
    /// The vertices, in world coordinates.
    pub mesh: &'a Mesh,
    /// Their BRDFs.
    pub materials: &'a Materials,
    /// The viewer.
    pub view: &'a View,
    /// The lamps.
    pub lights: &'a [LocalLight],
    /// What casts shadows: nothing, the mesh, or other objects too.
    pub occluders: Option<&'a Occluders>,
    /// The fog that all of it stands in.
    pub fog: Option<&'a Fog>,
}

/// Vertices that a thread takes at a time.
const CHUNK: usize = 16;

impl LocalTruth<'_> {
    /// The radiance of every vertex, by `samples`² parts of every lamp (of every pixel of a texture).
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless `samples` is in 1…4096,
    /// [`Error::Length`](crate::Error::Length) if the materials do not fit the mesh,
    /// [`Error::NotFinite`](crate::Error::NotFinite) for a BRDF or light field with a value that is NaN or infinite
    /// (the index is then the BRDF's in [`Materials::brdfs`]), [`Error::Cancelled`](crate::Error::Cancelled).
    pub fn radiance(&self, samples: usize, progress: &dyn Progress) -> Result<Vec<Vector3<f64>>> {
        check_samples(samples)?;
        let vertices = self.mesh.positions().len();
        self.materials.check(vertices)?;
        let starts = Viewpoint::of_vertices(self.mesh, VisibilitySettings::default().offset)?;
        let hemisphere = if self.fog.is_some() { hemisphere(samples) } else { vec![] };
        let mut out = vec![Vector3::zeros(); vertices];
        let watch = Watch::new(progress, vertices);
        parallel::try_chunks(
            &mut out,
            CHUNK,
            || (),
            |index, chunk, ()| {
                for (i, radiance) in chunk.iter_mut().enumerate() {
                    watch.check()?;
                    let vertex = index * CHUNK + i;
                    *radiance = self.vertex(vertex, &starts[vertex].position(), &hemisphere, samples);
                    if !radiance.iter().all(|c| c.is_finite()) {
                        return Err(self.materials.not_finite(vertex));
                    }
                }
                watch.advance(chunk.len());
                Ok(())
            },
        )?;
        Ok(out)
    }

    /// The same for twice as many samples again and again, from `first` to at most `most`, until the result moves by no
    /// more than `tolerance` (relative L2).
    ///
    /// # Errors
    /// Those of [`radiance`](Self::radiance) and [`Convergence::by_doubling`].
    pub fn converged(&self, first: usize, most: usize, tolerance: f64, progress: &dyn Progress) -> Result<Convergence> {
        Convergence::by_doubling(first, most, tolerance, |samples| self.radiance(samples, progress))
    }

    /// `hemisphere` is looked along for what fog scatters.
    fn vertex(&self, vertex: usize, start: &Vector3<f64>, hemisphere: &[Vector3<f64>], samples: usize) -> Vector3<f64> {
        let shading = Shading::new(self.mesh, self.materials, self.view, vertex);
        if shading.wo.z <= 0.0 {
            return Vector3::zeros();
        }
        let normal = *shading.axes.normal();
        // Light is that at the vertex; only rays start a little off the surface.
        let position = self.mesh.positions()[vertex].cast::<f64>();
        let off = 2.0 * (start - position).norm();
        let mut sum = Vector3::zeros();
        for light in self.lights {
            light.sample(&position, samples, |part| {
                let is_hidden = || {
                    let ends = (part.distance - off) * SHORT_OF_THE_LAMP;
                    self.occluders.is_some_and(|o| o.any_hit_within(start, &part.direction, ends))
                };
                if normal.dot(&part.direction) <= 0.0 || is_hidden() {
                    return;
                }
                let through = self.fog.map_or(Vector3::repeat(1.0), |fog| fog.transmittance(part.distance));
                sum += shading.reflect(&part.direction, &part.irradiance.component_mul(&through));
            });
        }
        sum + self.fog.map_or(Vector3::zeros(), |fog| self.glow(fog, &shading, start, hemisphere, samples))
    }

    /// What the fog scatters towards a surface and the surface reflects.
    fn glow(
        &self,
        fog: &Fog,
        shading: &Shading,
        start: &Vector3<f64>,
        directions: &[Vector3<f64>],
        samples: usize,
    ) -> Vector3<f64> {
        let omega = std::f64::consts::TAU / directions.len() as f64;
        let mut sum = Vector3::zeros();
        for local in directions {
            let direction = shading.axes.to_world(local);
            let hit = self.occluders.and_then(|o| o.closest_hit(start, &direction));
            let length = hit.map_or(f64::INFINITY, |(_, hit)| hit.distance);
            let radiance = fog.airlight(start, &direction, length, self.lights, self.occluders, samples);
            sum += shading.reflect(&direction, &(radiance * omega));
        }
        sum
    }
}
