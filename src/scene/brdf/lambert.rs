//! Lambert's law.

use std::f64::consts::FRAC_1_PI;

use nalgebra::Vector3;

use super::kernel::{self, Cosine};
use super::{Axes, Brdf, DirectionTable, Structure, check_albedo, is_poisoned, off_surface, split_colour};
use crate::Result;
use crate::scene::Frame;

/// The ideal diffuse surface.
///
///   f = albedo / π
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

    /// Albedo/π.
    pub(crate) fn factor(&self) -> Vector3<f64> {
        self.albedo * FRAC_1_PI
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
        Structure::Lambert(self)
    }

    fn is_isotropic(&self) -> bool {
        true
    }

    fn is_view_independent(&self) -> bool {
        true
    }

    fn add_cos(&self, frame: &Frame, wo: &Vector3<f64>, directions: &DirectionTable, scale: f64, out: &mut [f32]) {
        if is_poisoned(frame, wo, out) {
            return;
        }
        let axes = Axes::new(frame);
        let factor = kernel::scaled(&self.albedo, scale, FRAC_1_PI);
        let factor = if axes.to_local(wo).z > 0.0 { factor } else { (factor.0, 0.0) };
        kernel::add_scalar(Cosine, &axes, directions, factor, out);
    }
}
