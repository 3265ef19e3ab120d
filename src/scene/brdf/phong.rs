//! Cosine lobes: Phong's about the mirror direction, Blinn's about the half vector.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::kernel::{self, Kernel, Local, exp2, log2_1p, narrow};
use super::lobe::{self, KernelVisitor, Lobe, LobeModel, Shape};
use super::{
    Axes, Brdf, DirectionTable, Structure, check_albedo, check_exponent, half_vector, off_surface, split_colour,
};
use crate::Result;
use crate::scene::LocalFrame;

/// The modified, normalised Phong lobe about the mirror direction.
///
/// ```math
/// f = albedo (n + 2)/2π max(r·wi, 0)^n,  r = the mirror image of wo          [Lewis 1994; Lafortune & Willems 1994]
/// ```
///
/// Without the maximum [Sun 2008, eq. 2.19] an even n would give a second lobe. Reciprocal. The directional albedo is
/// `albedo` at normal incidence, for ∫ cosⁿ⁺¹ dω = 2π/(n + 2) over the hemisphere, and less elsewhere.
///
/// Accuracy of `add_cos`: |error| ≤ 4e-7 + 2e-7 √n of the lobe's peak, against `eval` (measured, 1 ≤ n ≤ 1e4). For
/// 0 < n < 1 the lobe is vertical at its rim: 1e-7ⁿ there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phong {
    albedo: Vector3<f64>,
    exponent: f64,
}

impl Phong {
    /// A lobe of RGB `albedo` and of `exponent` n; n = 0 is albedo/π up to 90° from the mirror direction and 0 beyond.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless every channel is in [0, 1] and the exponent in [0, 1e7].
    pub fn new(albedo: impl Into<Vector3<f64>>, exponent: f64) -> Result<Self> {
        let albedo = albedo.into();
        check_albedo("Phong albedo", &albedo)?;
        check_exponent("Phong exponent", exponent)?;
        Ok(Self { albedo, exponent })
    }

    /// The exponent n.
    pub fn exponent(&self) -> f64 {
        self.exponent
    }

    /// The albedo.
    pub fn albedo(&self) -> Vector3<f64> {
        self.albedo
    }
}

impl Brdf for Phong {
    fn eval(&self, wi: &Vector3<f64>, wo: &Vector3<f64>) -> Vector3<f64> {
        if let Some(value) = off_surface(wi, wo) {
            return value;
        }
        let cosine = wi.z * wo.z - wi.x * wo.x - wi.y * wo.y;
        if cosine <= 0.0 {
            return Vector3::zeros();
        }
        self.albedo * (self.constant() * cosine.min(1.0).powf(self.exponent))
    }

    fn colour(&self) -> Option<Vector3<f64>> {
        Some(split_colour(&self.albedo).0)
    }

    fn structure(&self) -> Structure<'_> {
        Structure::Lobe(self.lobe())
    }

    fn is_isotropic(&self) -> bool {
        true
    }

    fn add_cos(&self, frame: &LocalFrame, wo: &Vector3<f64>, directions: &DirectionTable, scale: f64, out: &mut [f32]) {
        lobe::add_cos(self, frame, wo, directions, scale, out);
    }
}

impl LobeModel for Phong {
    fn lobe(self) -> Lobe {
        Lobe::Phong(self)
    }

    fn tint(&self) -> Vector3<f64> {
        self.albedo
    }

    fn constant(&self) -> f64 {
        (self.exponent + 2.0) / TAU
    }

    fn shape(&self) -> Shape {
        Shape::Mirror { exponent: self.exponent }
    }

    fn reshaped(&self, shape: Shape) -> Result<Self> {
        match shape {
            Shape::Mirror { exponent } => Self::new(self.albedo, exponent),
            _ => lobe::foreign("a Phong lobe", shape),
        }
    }

    fn visit<V: KernelVisitor>(&self, axes: &Axes, wo: &Vector3<f64>, visitor: V) -> Option<V::Output> {
        let local = axes.to_local(wo);
        let mirror = axes.to_world(&Vector3::new(-local.x, -local.y, local.z));
        let kernel = MirrorLobe { mirror: narrow(&mirror.normalize()), exponent: self.exponent as f32 };
        (local.z > 0.0).then(|| visitor.visit(kernel))
    }
}

/// max(r·d, 0)^n z with 1 − r·d = |d − r|²/2, which keeps its relative precision in a narrow lobe.
#[derive(Clone, Copy)]
struct MirrorLobe {
    mirror: [f32; 3],
    exponent: f32,
}

impl Kernel<1> for MirrorLobe {
    const SMOOTH: bool = true;

    #[inline(always)]
    fn at(&self, d: [f32; 3], _: f32, z: f32) -> [f32; 1] {
        let e = [d[0] - self.mirror[0], d[1] - self.mirror[1], d[2] - self.mirror[2]];
        let q = 0.5 * kernel::dot(e, e);
        let lobe = exp2(self.exponent * log2_1p(-q));
        [if q < 1.0 { lobe * z } else { 0.0 }]
    }
}

/// The normalised Blinn–Phong lobe about the half vector.
///
/// ```math
/// f = albedo (n + 2)(n + 4) / (8π (n + 2^(−n/2))) (h·n)^n
/// ```
///
/// The constant makes the directional albedo at normal incidence equal to `albedo`: with c = cos(θ/2) = h·n, 2π ∫ cⁿ
/// cos θ sin θ dθ = 8π ∫ cⁿ⁺¹ (2c² − 1) dc from √½ to 1 = 8π (n + 2^(−n/2)) / ((n + 2)(n + 4)); Giesen (2009) has the
/// same. Away from it the albedo is smaller (tested). Reciprocal.
///
/// Accuracy of `add_cos`: |error| ≤ (4e-7 + 1e-8/cos θ_o)(1 + √n) of the lobe's peak, against `eval` (measured, n ≤
/// 1e4).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlinnPhong {
    albedo: Vector3<f64>,
    exponent: f64,
}

impl BlinnPhong {
    /// A lobe of RGB `albedo` and of `exponent` n; n = 0 is Lambert's law.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless every channel is in [0, 1] and the exponent in [0, 1e7].
    pub fn new(albedo: impl Into<Vector3<f64>>, exponent: f64) -> Result<Self> {
        let albedo = albedo.into();
        check_albedo("Blinn–Phong albedo", &albedo)?;
        check_exponent("Blinn–Phong exponent", exponent)?;
        Ok(Self { albedo, exponent })
    }

    /// The exponent n.
    pub fn exponent(&self) -> f64 {
        self.exponent
    }

    /// The albedo.
    pub fn albedo(&self) -> Vector3<f64> {
        self.albedo
    }
}

impl Brdf for BlinnPhong {
    fn eval(&self, wi: &Vector3<f64>, wo: &Vector3<f64>) -> Vector3<f64> {
        if let Some(value) = off_surface(wi, wo) {
            return value;
        }
        self.albedo * (self.constant() * half_vector(wi, wo).0.z.min(1.0).powf(self.exponent))
    }

    fn colour(&self) -> Option<Vector3<f64>> {
        Some(split_colour(&self.albedo).0)
    }

    fn structure(&self) -> Structure<'_> {
        Structure::Lobe(self.lobe())
    }

    fn is_isotropic(&self) -> bool {
        true
    }

    fn add_cos(&self, frame: &LocalFrame, wo: &Vector3<f64>, directions: &DirectionTable, scale: f64, out: &mut [f32]) {
        lobe::add_cos(self, frame, wo, directions, scale, out);
    }
}

impl LobeModel for BlinnPhong {
    fn lobe(self) -> Lobe {
        Lobe::BlinnPhong(self)
    }

    fn tint(&self) -> Vector3<f64> {
        self.albedo
    }

    fn constant(&self) -> f64 {
        let n = self.exponent;
        (n + 2.0) * (n + 4.0) / (8.0 * PI * (n + (-0.5 * n).exp2()))
    }

    fn shape(&self) -> Shape {
        Shape::Half { exponent: self.exponent }
    }

    fn reshaped(&self, shape: Shape) -> Result<Self> {
        match shape {
            Shape::Half { exponent } => Self::new(self.albedo, exponent),
            _ => lobe::foreign("a Blinn–Phong lobe", shape),
        }
    }

    fn visit<V: KernelVisitor>(&self, axes: &Axes, wo: &Vector3<f64>, visitor: V) -> Option<V::Output> {
        let half_exponent = (-0.5 * self.exponent) as f32;
        Local::new(axes, wo).map(|local| visitor.visit(HalfLobe { local, half_exponent }))
    }
}

/// (h·n)^n z = (1 + tan² θ_h)^(−n/2) z: the tangent keeps its relative precision in a narrow lobe.
#[derive(Clone, Copy)]
struct HalfLobe {
    local: Local,
    half_exponent: f32,
}

impl Kernel<1> for HalfLobe {
    #[inline(always)]
    fn at(&self, d: [f32; 3], up: f32, z: f32) -> [f32; 1] {
        let h = self.local.half(d, up);
        let tan2 = (h[0] * h[0] + h[1] * h[1]) / (h[2] * h[2]);
        [exp2(self.half_exponent * log2_1p(tan2)) * z]
    }
}
