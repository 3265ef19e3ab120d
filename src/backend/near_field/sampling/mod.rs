//! Importance sampling of a near light times a BRDF, for Monte Carlo renderers [Sun 2008, §4.6.1].
//!
//! What a surface reflects of a light is an integral over directions. An estimate of it is a mean of integrand over
//! density for directions that are drawn from a density, and has the less noise the more alike the two are. Everything
//! here is a density about one point, a [`DirectionSampler`]:
//!
//! | density | directions go where | made by |
//! |---|---|---|
//! | [`ProductDensity`] | light × BRDF × cosine is large | [`ProductSampler::density`], which mixes it with the next |
//! | [`LightDensity`] | the light is, or is bright | [`LightSampler::density`] |
//! | [`BrdfDensity`] | the BRDF × cosine is large | [`BrdfTable::density`] |
//! | [`Mixture`] | one of two densities says: multiple importance sampling | [`Mixture::new`] |
//!
//! [`Reflection`] is the integrand, with the true light, the true BRDF and shadows; it makes estimates of any of them.
//!
//! # Example
//! ```
//! use haarmonic::backend::near_field::{
//!     BrdfTable, PlanarLight, ProductSampler, ProductSettings, Reflection, ShadingPoint,
//! };
//! use haarmonic::nalgebra::Vector3;
//! use haarmonic::scene::{LocalFrame, Phong};
//! // A bright and a dark half, two metres above a glossy floor.
//! let texture = vec![Vector3::repeat(8.0), Vector3::repeat(1.0)];
//! let light = PlanarLight::new(Vector3::new(0.0, 2.0, 0.0), [1.0, 1.0], 2, texture)?;
//! let up = LocalFrame::around(&Vector3::y_axis());
//! let brdf = Phong::new([0.8, 0.6, 0.3], 20.0)?;
//! // Once for each light and each BRDF.
//! let sampler = ProductSampler::new(&light, &up, ProductSettings::default())?;
//! let table = BrdfTable::new(&brdf, 32, 64)?;
//! let mut scratch = sampler.scratch();
//! // For each point.
//! let wo = Vector3::new(0.0, 0.8, 0.6);
//! let point = ShadingPoint { position: Vector3::zeros(), frame: up, wo };
//! let density = sampler.density(&point, &table, &mut scratch);
//! let reflection = Reflection { light: sampler.light(), brdf: &brdf, point, occluders: None, start: point.position };
//! let numbers = (0..8).map(|k| [(k as f64 + 0.5) / 8.0, (k as f64 * 0.618).fract()]);
//! let radiance = reflection.estimate(&density, numbers);
//! assert!(radiance.x > radiance.z && radiance.z > 0.0);
//! # Ok::<(), haarmonic::Error>(())
//! ```

mod brdf_density;
mod brdf_table;
mod hemisphere;
mod light;
mod mixture;
mod product;
mod reflection;
mod window;

use nalgebra::Vector3;

pub use brdf_density::{BrdfDensity, BrdfScratch};
pub use brdf_table::BrdfTable;
pub use light::{LightDensity, LightHit, LightSampler, LightWeight};
pub use mixture::Mixture;
pub use product::{Incidence, ProductDensity, ProductSampler, ProductScratch, ProductSettings};
pub use reflection::{Reflection, ShadingPoint};
pub use window::Window;

/// A direction, and how likely it was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionSample {
    /// The unit direction away from the surface, in world coordinates.
    pub direction: Vector3<f64>,
    /// The density of directions there, per steradian: positive.
    pub pdf: f64,
}

/// A density of directions about a point.
///
/// Directions are unit vectors of the world. The densities here integrate to 1 over the sphere, or are 0 everywhere:
/// those have no samples.
pub trait DirectionSampler {
    /// The direction of two uniform numbers in [0, 1); `None` if the density is 0 everywhere.
    fn sample(&self, uniform: [f64; 2]) -> Option<DirectionSample>;

    /// The density at a direction, per steradian.
    fn pdf(&self, direction: &Vector3<f64>) -> f64;
}

impl<S: DirectionSampler + ?Sized> DirectionSampler for &S {
    fn sample(&self, uniform: [f64; 2]) -> Option<DirectionSample> {
        (**self).sample(uniform)
    }

    fn pdf(&self, direction: &Vector3<f64>) -> f64 {
        (**self).pdf(direction)
    }
}
