//! Microfacets with the GGX distribution.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::kernel::{self, Kernel, Local};
use super::lobe::{self, KernelVisitor, Lobe, LobeModel, Shape};
use super::{
    Axes, Brdf, DirectionTable, Structure, check_albedo, check_roughness, half_vector, off_surface, split_colour,
};
use crate::Result;
use crate::scene::LocalFrame;

/// Cook and Torrance's microfacet model with the anisotropic GGX distribution.
///
/// ```math
/// f = D(h) F(wo·h) G₂(wi, wo) / (4 cos θ_i cos θ_o)
/// D = 1 / (π α_x α_y (h_x²/α_x² + h_y²/α_y² + h_z²)²)                                 [Walter 2007]
/// G₂/(4 cos θ_i cos θ_o) = 1 / (2 (cos θ_o λ(wi) + cos θ_i λ(wo))),
/// λ(w) = √(α_x² w_x² + α_y² w_y² + w_z²)                                               [Heitz 2014]
/// F = F₀ + (1 − F₀)(1 − wo·h)⁵                                                         [Schlick 1994]
/// ```
///
/// Reciprocal. Single scattering: the directional albedo is below 1, and the rougher the surface the further below.
/// An F₀ of three equal channels has a colour, white; another one has none, since F goes to white at grazing angles.
///
/// Accuracy of `add_cos`: |error| ≤ (7e-7 + 1e-8/cos θ_o)(1 + 1/α) of the lobe's peak, against `eval` (measured for
/// α ≥ 0.01).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CookTorrance {
    f0: Vector3<f64>,
    alpha: [f64; 2],
}

impl CookTorrance {
    /// A surface of reflectance `f0` at normal incidence and of roughnesses along the tangent and the bitangent.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless every channel is in [0, 1] and both roughnesses in
    /// [1e-4, 1].
    pub fn new(f0: impl Into<Vector3<f64>>, alpha_x: f64, alpha_y: f64) -> Result<Self> {
        let f0 = f0.into();
        check_albedo("GGX reflectance F0", &f0)?;
        check_roughness("GGX alpha_x", alpha_x)?;
        check_roughness("GGX alpha_y", alpha_y)?;
        Ok(Self { f0, alpha: [alpha_x, alpha_y] })
    }

    /// The isotropic surface.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn isotropic(f0: impl Into<Vector3<f64>>, alpha: f64) -> Result<Self> {
        Self::new(f0, alpha, alpha)
    }

    fn grey(&self) -> bool {
        self.f0.x == self.f0.y && self.f0.x == self.f0.z
    }

    fn lambda(&self, w: &Vector3<f64>) -> f64 {
        ((self.alpha[0] * w.x).powi(2) + (self.alpha[1] * w.y).powi(2) + w.z * w.z).sqrt()
    }

    /// Reflectance at normal incidence.
    pub fn f0(&self) -> Vector3<f64> {
        self.f0
    }

    /// α along the tangent and the bitangent.
    pub fn alpha(&self) -> [f64; 2] {
        self.alpha
    }
}

impl Brdf for CookTorrance {
    fn eval(&self, wi: &Vector3<f64>, wo: &Vector3<f64>) -> Vector3<f64> {
        if let Some(value) = off_surface(wi, wo) {
            return value;
        }
        let (h, cos_d) = half_vector(wi, wo);
        let q = (h.x / self.alpha[0]).powi(2) + (h.y / self.alpha[1]).powi(2) + h.z * h.z;
        let d = 1.0 / (PI * self.alpha[0] * self.alpha[1] * q * q);
        let masking = 0.5 / (wo.z * self.lambda(wi) + wi.z * self.lambda(wo));
        let grazing = (1.0 - cos_d).powi(5);
        let value = (d * masking).min(f64::MAX);
        self.f0.map(|f0| value * (f0 + (1.0 - f0) * grazing))
    }

    fn colour(&self) -> Option<Vector3<f64>> {
        self.grey().then(|| split_colour(&self.f0).0)
    }

    fn structure(&self) -> Structure<'_> {
        Structure::Lobe(self.lobe())
    }

    fn is_isotropic(&self) -> bool {
        self.alpha[0] == self.alpha[1]
    }

    fn add_cos(&self, frame: &LocalFrame, wo: &Vector3<f64>, directions: &DirectionTable, scale: f64, out: &mut [f32]) {
        lobe::add_cos(self, frame, wo, directions, scale, out);
    }
}

impl LobeModel for CookTorrance {
    fn lobe(self) -> Lobe {
        Lobe::CookTorrance(self)
    }

    fn tint(&self) -> Vector3<f64> {
        Vector3::repeat(1.0)
    }

    fn constant(&self) -> f64 {
        0.5 / (PI * self.alpha[0] * self.alpha[1])
    }

    fn shape(&self) -> Shape {
        Shape::Microfacets { alpha: self.alpha, f0: self.f0 }
    }

    fn reshaped(&self, shape: Shape) -> Result<Self> {
        match shape {
            Shape::Microfacets { alpha: [x, y], f0 } => Self::new(f0, x, y),
            _ => lobe::foreign("Cook and Torrance's model", shape),
        }
    }

    fn visit<V: KernelVisitor>(&self, axes: &Axes, wo: &Vector3<f64>, visitor: V) -> Option<V::Output> {
        let facets = Facets {
            local: Local::new(axes, wo)?,
            alpha2: self.alpha.map(|a| (a * a) as f32),
            inverse: self.alpha.map(|a| (1.0 / a) as f32),
            lambda: self.lambda(&axes.to_local(wo)) as f32,
        };
        Some(if self.grey() {
            visitor.visit(Schlick { facets, f0: [self.f0.x as f32] })
        } else {
            visitor.visit(Schlick { facets, f0: kernel::narrow(&self.f0) })
        })
    }
}

#[derive(Clone, Copy)]
struct Facets {
    local: Local,
    alpha2: [f32; 2],
    inverse: [f32; 2],
    lambda: f32,
}

impl Facets {
    /// D G₂/(4 cos θ_i cos θ_o) at cosine `up` times `z`, without its constants, and Schlick's (1 − wo·h)⁵.
    #[inline(always)]
    fn parts(&self, d: [f32; 3], up: f32, z: f32) -> (f32, f32) {
        let h = self.local.half(d, up);
        let wo = self.local.wo;
        let wi = [h[0] - wo[0], h[1] - wo[1]];
        let length2 = h[0] * h[0] + h[1] * h[1] + h[2] * h[2];
        let (sx, sy) = (h[0] * self.inverse[0], h[1] * self.inverse[1]);
        let ratio = length2 / (sx * sx + sy * sy + h[2] * h[2]);
        let lambda = (self.alpha2[0] * wi[0] * wi[0] + self.alpha2[1] * wi[1] * wi[1] + up * up).sqrt();
        // wo·h/|h| = |h|/2 for unit wi, wo.
        let rest = 1.0 - 0.5 * length2.sqrt();
        let rest2 = rest * rest;
        // The bound is reached by denormal cosines only.
        let denominator = (wo[2] * lambda + up * self.lambda).max(f32::MIN_POSITIVE);
        (ratio * ratio * z / denominator, rest2 * rest2 * rest)
    }
}

/// The facets' lobe times Schlick's reflectance, for one channel or three.
#[derive(Clone, Copy)]
struct Schlick<const N: usize> {
    facets: Facets,
    f0: [f32; N],
}

impl<const N: usize> Kernel<N> for Schlick<N> {
    #[inline(always)]
    fn at(&self, d: [f32; 3], up: f32, z: f32) -> [f32; N] {
        let (value, grazing) = self.facets.parts(d, up, z);
        self.f0.map(|f0| value * (f0 + (1.0 - f0) * grazing))
    }
}
