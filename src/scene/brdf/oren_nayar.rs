//! Rough diffuse surfaces.

use std::f64::consts::FRAC_1_PI;

use nalgebra::Vector3;

use super::{Brdf, check_albedo, off_surface, split_colour};
use crate::{Error, Result};

/// Oren and Nayar's qualitative model of diffuse facets, whose slopes spread by an angle σ (1994).
///
/// ```math
/// f = albedo/π · (A + B max(0, cos(φ_i − φ_o)) sin α tan β),  α, β the larger and the smaller of θ_i, θ_o
/// A = 1 − ½ σ²/(σ² + 0.33),  B = 0.45 σ²/(σ² + 0.09)
/// ```
///
/// With σ = 0 it is [`Lambert`](super::Lambert)'s law. Reciprocal; isotropic. The directional albedo is at most the
/// albedo times 1.03 (measured over σ and θ_o; the fit's constants are the paper's), and below it but for grazing
/// angles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrenNayar {
    albedo: Vector3<f64>,
    sigma: f64,
    a: f64,
    b: f64,
}

impl OrenNayar {
    /// A surface of RGB `albedo` whose facets' slopes have the standard deviation `sigma` in radians.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless every channel is in [0, 1] and `sigma` in [0, π/2].
    pub fn new(albedo: impl Into<Vector3<f64>>, sigma: f64) -> Result<Self> {
        let albedo = albedo.into();
        check_albedo("Oren–Nayar albedo", &albedo)?;
        if !(0.0..=std::f64::consts::FRAC_PI_2).contains(&sigma) {
            return Err(Error::OutOfRange { what: "Oren–Nayar sigma", got: sigma, allowed: "in [0, π/2]" });
        }
        let square = sigma * sigma;
        let (a, b) = (1.0 - 0.5 * square / (square + 0.33), 0.45 * square / (square + 0.09));
        Ok(Self { albedo, sigma, a, b })
    }

    /// The standard deviation of the facets' slopes, in radians.
    pub fn sigma(&self) -> f64 {
        self.sigma
    }
}

impl Brdf for OrenNayar {
    fn eval(&self, wi: &Vector3<f64>, wo: &Vector3<f64>) -> Vector3<f64> {
        if let Some(value) = off_surface(wi, wo) {
            return value;
        }
        // sin θ_i sin θ_o cos(φ_i − φ_o), and sin α tan β = sin θ_i sin θ_o / the larger cosine.
        let along = wi.x * wo.x + wi.y * wo.y;
        self.albedo * (FRAC_1_PI * (self.a + self.b * (along.max(0.0) / wi.z.max(wo.z)).min(f64::MAX)))
    }

    fn colour(&self) -> Option<Vector3<f64>> {
        Some(split_colour(&self.albedo).0)
    }

    fn is_isotropic(&self) -> bool {
        true
    }

    fn is_view_independent(&self) -> bool {
        self.b == 0.0
    }
}
