//! Local frames of a surface.

use nalgebra::{Matrix3, UnitVector3, Vector3};

use super::normals::perpendicular;
use crate::approx_eq::approx_by_parts;
use crate::{Error, Result};

/// An orthonormal right-handed frame: x = tangent, y = bitangent, z = normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalFrame {
    /// Local +x.
    pub tangent: Vector3<f32>,
    /// Local +y, normal × tangent.
    pub bitangent: Vector3<f32>,
    /// Local +z.
    pub normal: Vector3<f32>,
}

impl LocalFrame {
    /// A frame around a normal; its tangent is arbitrary but deterministic.
    pub fn around(normal: &UnitVector3<f64>) -> Self {
        let normal = normal.cast::<f32>().into_inner();
        let tangent = perpendicular(&normal);
        Self { tangent, bitangent: normal.cross(&tangent), normal }
    }

    /// Whether the axes are those of a frame.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the axes are orthonormal to 10⁻³, as dot products of `what`.
    pub(crate) fn check(&self, what: &'static str) -> Result<()> {
        let axes = Matrix3::from_columns(&[self.tangent, self.bitangent, self.normal].map(|a| a.cast::<f64>()));
        let off = axes.transpose() * axes - Matrix3::identity();
        // Negated, so that NaN is refused.
        match off.iter().find(|off| !(off.abs() <= 1e-3)) {
            Some(&got) => Err(Error::OutOfRange { what, got, allowed: "at most 1e-3" }),
            None => Ok(()),
        }
    }

    /// World to local coordinates, in `f64`.
    #[inline]
    pub fn to_local(&self, world: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(
            self.tangent.cast::<f64>().dot(world),
            self.bitangent.cast::<f64>().dot(world),
            self.normal.cast::<f64>().dot(world),
        )
    }

    /// Local to world coordinates, in `f64`.
    #[inline]
    pub fn to_world(&self, local: &Vector3<f64>) -> Vector3<f64> {
        self.tangent.cast::<f64>() * local.x
            + self.bitangent.cast::<f64>() * local.y
            + self.normal.cast::<f64>() * local.z
    }
}

approx_by_parts!([] LocalFrame, f32, |f| close [[f.tangent, f.bitangent, f.normal]] same []);
