//! Lambert's law.

use std::f64::consts::FRAC_1_PI;

use nalgebra::Vector3;

use super::kernel::Kernel;
use super::lobe::{self, KernelVisitor, Lobe, LobeModel, Shape};
use super::{Axes, Brdf, DirectionTable, Structure, check_albedo, off_surface, split_colour};
use crate::Result;
use crate::scene::LocalFrame;

/// The ideal diffuse surface.
///
/// ```math
/// f = albedo / π
/// ```
///
/// Accuracy of `add_cos`: absolute error ≤ 4 ε_f32 · albedo/π against `eval` times the cosine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lambert {
    albedo: Vector3<f64>,
}

impl Lambert {
    /// A surface of RGB `albedo`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless every channel is in [0, 1].
    pub fn new(albedo: impl Into<Vector3<f64>>) -> Result<Self> {
        let albedo = albedo.into();
        check_albedo("Lambert albedo", &albedo)?;
        Ok(Self { albedo })
    }

    /// The albedo.
    pub fn albedo(&self) -> Vector3<f64> {
        self.albedo
    }
}

impl Brdf for Lambert {
    fn eval(&self, wi: &Vector3<f64>, wo: &Vector3<f64>) -> Vector3<f64> {
        off_surface(wi, wo).unwrap_or_else(|| self.albedo * FRAC_1_PI)
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

    fn is_view_independent(&self) -> bool {
        true
    }

    fn add_cos(&self, frame: &LocalFrame, wo: &Vector3<f64>, directions: &DirectionTable, scale: f64, out: &mut [f32]) {
        lobe::add_cos(self, frame, wo, directions, scale, out);
    }
}

impl LobeModel for Lambert {
    fn lobe(self) -> Lobe {
        Lobe::Lambert(self)
    }

    fn tint(&self) -> Vector3<f64> {
        self.albedo
    }

    fn constant(&self) -> f64 {
        FRAC_1_PI
    }

    fn shape(&self) -> Shape {
        Shape::Cosine
    }

    fn reshaped(&self, shape: Shape) -> Result<Self> {
        match shape {
            Shape::Cosine => Ok(*self),
            _ => lobe::foreign("Lambert's law", shape),
        }
    }

    fn visit<V: KernelVisitor>(&self, axes: &Axes, wo: &Vector3<f64>, visitor: V) -> Option<V::Output> {
        (axes.normal().dot(wo) > 0.0).then(|| visitor.visit(Cosine))
    }
}

/// The cosine, without albedo/π.
#[derive(Clone, Copy)]
struct Cosine;

impl Kernel<1> for Cosine {
    const SMOOTH: bool = true;

    #[inline(always)]
    fn at(&self, _: [f32; 3], _: f32, z: f32) -> [f32; 1] {
        [z]
    }
}
