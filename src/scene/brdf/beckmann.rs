//! Microfacets with Beckmann's distribution.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::{Brdf, check_albedo, check_roughness, half_vector, off_surface};
use crate::Result;

/// Cook and Torrance's microfacet model as they published it: Beckmann's distribution and grooves.
///
/// ```math
/// f = D(h) F(wo·h) G(wi, wo) / (4 cos θ_i cos θ_o)
/// D = exp(−tan² θ_h/m²) / (π m² cos⁴ θ_h)                                               [Beckmann 1963]
/// G = min(1, 2 cos θ_h cos θ_o/(wo·h), 2 cos θ_h cos θ_i/(wo·h))                        [Torrance & Sparrow 1967]
/// F = F₀ + (1 − F₀)(1 − wo·h)⁵                                                         [Schlick 1994]
/// ```
///
/// The paper's 1/π in place of 1/4 goes with a D that is not normalised. Reciprocal; isotropic; single scattering: the
/// directional albedo is at most 1. For another distribution and masking, and a kernel in `f32`, see
/// [`CookTorrance`](super::CookTorrance).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beckmann {
    f0: Vector3<f64>,
    roughness: f64,
}

impl Beckmann {
    /// A surface of reflectance `f0` at normal incidence and root mean square slope `roughness`, the m above.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless every channel is in [0, 1] and the roughness in
    /// [1e-4, 1].
    pub fn new(f0: impl Into<Vector3<f64>>, roughness: f64) -> Result<Self> {
        let f0 = f0.into();
        check_albedo("Beckmann reflectance F0", &f0)?;
        check_roughness("Beckmann roughness", roughness)?;
        Ok(Self { f0, roughness })
    }
}

impl Brdf for Beckmann {
    fn eval(&self, wi: &Vector3<f64>, wo: &Vector3<f64>) -> Vector3<f64> {
        if let Some(value) = off_surface(wi, wo) {
            return value;
        }
        let (h, cos_d) = half_vector(wi, wo);
        let (cos2, sin2) = (h.z * h.z, h.x * h.x + h.y * h.y);
        let m2 = self.roughness * self.roughness;
        let d = (-sin2 / (cos2 * m2)).exp() / (PI * m2 * cos2 * cos2);
        // G/(cos θ_i cos θ_o) without dividing by a cosine that G has: the smaller of the two cosines limits it.
        let (least, most) = (wi.z.min(wo.z), wi.z.max(wo.z));
        let masking = (1.0 / least).min(2.0 * h.z / cos_d) / most;
        // Both are 0 · ∞ where both directions graze the horizon from opposite sides: no facet stands there.
        let value = if d > 0.0 { (0.25 * d * masking).min(f64::MAX) } else { 0.0 };
        let grazing = (1.0 - cos_d).powi(5);
        self.f0.map(|f0| value * (f0 + (1.0 - f0) * grazing))
    }

    fn colour(&self) -> Option<Vector3<f64>> {
        (self.f0.x == self.f0.y && self.f0.x == self.f0.z).then(|| Vector3::repeat(1.0))
    }

    fn is_isotropic(&self) -> bool {
        true
    }
}
