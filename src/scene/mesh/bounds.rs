//! Boxes around things.

use nalgebra::Vector3;

use crate::approx_eq::approx_by_parts;
/// The smallest axis-aligned box around something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates.
    pub min: Vector3<f32>,
    /// Largest coordinates.
    pub max: Vector3<f32>,
}

impl Bounds {
    /// The centre of the box.
    pub fn centre(&self) -> Vector3<f64> {
        (self.min.cast::<f64>() + self.max.cast::<f64>()) * 0.5
    }

    /// The edge lengths of the box.
    pub fn size(&self) -> Vector3<f64> {
        self.max.cast::<f64>() - self.min.cast::<f64>()
    }

    /// Half of the box's diagonal: the radius of the ball around [`centre`](Self::centre) that holds it.
    pub fn radius(&self) -> f64 {
        self.size().norm() * 0.5
    }
}

approx_by_parts!([] Bounds, f32, |b| close [[b.min, b.max]] same []);
