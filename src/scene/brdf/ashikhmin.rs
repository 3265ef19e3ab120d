//! Ashikhmin and Shirley's anisotropic Phong model.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::{Brdf, check_albedo, check_exponent, half_vector, off_surface, split_colour};
use crate::Result;

/// The anisotropic Phong model of Ashikhmin and Shirley (2000), with its diffuse term.
///
/// ```math
/// specular = √((n_u + 1)(n_v + 1))/8π · (h·n)^((n_u h_x² + n_v h_y²)/(1 − h_z²))
///   / (wo·h max(cos θ_i, cos θ_o)) · F(wo·h)
/// diffuse  = 28/23π · R_d (1 − R_s)(1 − (1 − cos θ_i/2)⁵)(1 − (1 − cos θ_o/2)⁵)
/// F = R_s + (1 − R_s)(1 − wo·h)⁵
/// ```
///
/// Reciprocal. ∫ specular cos ≤ F, for cos θ_i ≤ max(…) and the lobe integrates to one over the half vectors. f itself
/// grows without bound as wi → −wo along the horizon; it is held at the largest finite number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AshikhminShirley {
    diffuse: Vector3<f64>,
    specular: Vector3<f64>,
    exponents: [f64; 2],
}

impl AshikhminShirley {
    /// A surface of diffuse and specular reflectance R_d, R_s and of exponents along the tangent and the bitangent.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless every channel is in [0, 1] and both exponents in [0,
    /// 1e7].
    pub fn new(
        diffuse: impl Into<Vector3<f64>>,
        specular: impl Into<Vector3<f64>>,
        exponent_x: f64,
        exponent_y: f64,
    ) -> Result<Self> {
        let (diffuse, specular) = (diffuse.into(), specular.into());
        check_albedo("Ashikhmin–Shirley diffuse reflectance", &diffuse)?;
        check_albedo("Ashikhmin–Shirley specular reflectance", &specular)?;
        check_exponent("Ashikhmin–Shirley exponent_x", exponent_x)?;
        check_exponent("Ashikhmin–Shirley exponent_y", exponent_y)?;
        Ok(Self { diffuse, specular, exponents: [exponent_x, exponent_y] })
    }
}

impl Brdf for AshikhminShirley {
    fn is_isotropic(&self) -> bool {
        self.exponents[0] == self.exponents[1]
    }

    fn eval(&self, wi: &Vector3<f64>, wo: &Vector3<f64>) -> Vector3<f64> {
        if let Some(value) = off_surface(wi, wo) {
            return value;
        }
        let [nu, nv] = self.exponents;
        let (h, k) = half_vector(wi, wo);
        let (hx2, hy2) = (h.x * h.x, h.y * h.y);
        let sin2 = hx2 + hy2;
        let exponent = if sin2 > 0.0 { (nu * hx2 + nv * hy2) / sin2 } else { 0.0 };
        let lobe = ((nu + 1.0) * (nv + 1.0)).sqrt() / (8.0 * PI) * h.z.min(1.0).powf(exponent);
        // k = wo·h is at least the smaller cosine, which may be denormal.
        let lobe = if lobe > 0.0 { (lobe / k / wi.z.max(wo.z)).min(f64::MAX) } else { 0.0 };
        let grazing = (1.0 - k).powi(5);
        let side = |cos: f64| 1.0 - (1.0 - 0.5 * cos).powi(5);
        let matt = 28.0 / (23.0 * PI) * side(wi.z) * side(wo.z);
        self.specular.zip_map(&self.diffuse, |rs, rd| {
            let gloss = lobe * (rs + (1.0 - rs) * grazing);
            (gloss + matt * rd * (1.0 - rs)).min(f64::MAX)
        })
    }

    fn colour(&self) -> Option<Vector3<f64>> {
        let grey = |v: &Vector3<f64>| v.x == v.y && v.x == v.z;
        (grey(&self.specular) && (grey(&self.diffuse) || self.specular.x == 1.0))
            .then(|| split_colour(&self.specular).0)
    }
}
