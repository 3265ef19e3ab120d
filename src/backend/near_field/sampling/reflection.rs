//! What is integrated, and estimates of it.

use nalgebra::Vector3;

use super::DirectionSampler;
use super::light::LightSampler;
use crate::scene::{Axes, Brdf, LocalFrame, Occluders};

/// A place of a surface and who looks at it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadingPoint {
    /// Where it is, in world coordinates.
    pub position: Vector3<f64>,
    /// The surface's frame, in which its BRDF is given.
    pub frame: LocalFrame,
    /// The unit direction to the viewer, in world coordinates.
    pub wo: Vector3<f64>,
}

/// The light that a point reflects, as an integral over directions to be estimated: true light, true BRDF, shadows.
///
/// ```math
/// L_o = ∫ L(ω) V(ω) f(ω, wo) max(cos θ, 0) dω
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Reflection<'a> {
    /// The light.
    pub light: &'a LightSampler,
    /// The surface's BRDF.
    pub brdf: &'a dyn Brdf,
    /// The place.
    pub point: ShadingPoint,
    /// What casts shadows.
    pub occluders: Option<&'a Occluders>,
    /// Where shadow rays start: the place, a little off its own surface.
    pub start: Vector3<f64>,
}

/// Shadow rays end a little before the light, which may be part of what they meet.
const SHORT_OF_THE_LIGHT: f64 = 1.0 - 1e-6;

impl Reflection<'_> {
    /// The integrand at a unit direction: 0 where the light is not hit, or hidden.
    pub fn radiance(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.radiance_in(&Axes::new(&self.point.frame), direction)
    }

    /// The mean of integrand over density for the samples of uniform numbers, pairs in [0, 1); 0 without a pair.
    ///
    /// Its expectation is the integral if the density is positive wherever the integrand is not 0, as it is for the
    /// mixture of [`ProductSampler::density`](super::ProductSampler::density) and for [`LightSampler::density`] of a
    /// light without black texels or by radiance. A sample that the density has none for counts as 0.
    ///
    /// Cost: a sample, a value of the BRDF and a shadow ray a pair.
    pub fn estimate(
        &self,
        sampler: &impl DirectionSampler,
        uniforms: impl IntoIterator<Item = [f64; 2]>,
    ) -> Vector3<f64> {
        let (axes, mut sum, mut count) = (Axes::new(&self.point.frame), Vector3::zeros(), 0_usize);
        for uniform in uniforms {
            count += 1;
            if let Some(sample) = sampler.sample(uniform) {
                sum += self.radiance_in(&axes, &sample.direction) / sample.pdf;
            }
        }
        sum / count.max(1) as f64
    }

    fn radiance_in(&self, axes: &Axes, direction: &Vector3<f64>) -> Vector3<f64> {
        let wi = axes.to_local(direction);
        let Some(hit) = self.light.hit(&self.point.position, direction).filter(|_| !(wi.z <= 0.0)) else {
            return Vector3::zeros();
        };
        let value = self.brdf.eval(&wi, &axes.to_local(&self.point.wo)).component_mul(&hit.radiance) * wi.z;
        if value == Vector3::zeros() || self.is_hidden(direction, hit.distance) { Vector3::zeros() } else { value }
    }

    fn is_hidden(&self, direction: &Vector3<f64>, distance: f64) -> bool {
        let off = 2.0 * (self.start - self.point.position).norm();
        let ends = (distance - off) * SHORT_OF_THE_LIGHT;
        self.occluders.is_some_and(|o| o.any_hit_within(&self.start, direction, ends))
    }
}
