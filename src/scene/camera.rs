//! The pinhole camera.

use nalgebra::{UnitVector3, Vector3};

use super::Mesh;
use crate::approx_eq::approx_by_parts;
use crate::{Error, Result};

/// A pinhole camera in a right-handed world.
///
/// Picture coordinates: x to the right and y **up** in [−1, 1] over the picture's height; x reaches ± the aspect ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    eye: Vector3<f64>,
    right: Vector3<f64>,
    up: Vector3<f64>,
    forward: Vector3<f64>,
    fov_y: f64,
}

impl Camera {
    /// A camera at `eye` that looks at `target` with `up` upwards and a vertical field of view of `fov_y` radians.
    ///
    /// An `up` that is parallel to the view to 1e-6 is replaced by the world axis that is most across it.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for a vector that is not finite (index 0 eye, 1 target, 2 up), [`Error::OutOfRange`] if eye
    /// and target coincide or unless 0 < `fov_y` < π.
    pub fn look_at(eye: Vector3<f64>, target: Vector3<f64>, up: Vector3<f64>, fov_y: f64) -> Result<Self> {
        let finite = |v: &Vector3<f64>| v.iter().all(|c| c.is_finite());
        if let Some(index) = [eye, target, up].iter().position(|v| !finite(v)) {
            return Err(Error::NotFinite { what: "camera vector", index });
        }
        if !(fov_y > 0.0 && fov_y < std::f64::consts::PI) {
            return Err(Error::OutOfRange { what: "vertical field of view", got: fov_y, allowed: "in (0, π)" });
        }
        // Of the halves, so that it does not overflow.
        let Some(forward) = unit(&(target - eye)).or_else(|| unit(&(target * 0.5 - eye * 0.5))) else {
            return Err(Error::OutOfRange { what: "distance of the camera's target", got: 0.0, allowed: "positive" });
        };
        let across = |up: &Vector3<f64>| unit(up).and_then(|up| forward.cross(&up).try_normalize(1e-6));
        let fallback = Vector3::ith(forward.iamin(), 1.0);
        let right = across(&up).unwrap_or_else(|| forward.cross(&fallback).normalize());
        Ok(Self { eye, right, up: right.cross(&forward), forward, fov_y })
    }

    /// A camera that sees a whole mesh from the direction `view` (from the mesh to the camera).
    ///
    /// It looks at the centre of the mesh's box from as near as every vertex of every face stays in the picture of the
    /// given aspect ratio (width/height), with 4 % to spare.
    ///
    /// # Errors
    /// Those of [`look_at`](Self::look_at); [`Error::OutOfRange`] for a zero `view` or unless `aspect` is positive and
    /// finite.
    pub fn framing(mesh: &Mesh, view: &Vector3<f64>, up: &Vector3<f64>, fov_y: f64, aspect: f64) -> Result<Self> {
        if !(aspect > 0.0 && aspect.is_finite()) {
            return Err(Error::OutOfRange { what: "aspect ratio", got: aspect, allowed: "positive and finite" });
        }
        let Some(back) = unit(view) else {
            return Err(Error::OutOfRange {
                what: "length of the view direction",
                got: view.norm(),
                allowed: "positive",
            });
        };
        let bounds = mesh.bounds();
        let centre = bounds.centre();
        let radius = if bounds.radius() > 0.0 { bounds.radius() } else { 1.0 };
        let camera = Self::look_at(centre + back * radius, centre, *up, fov_y)?;
        let half = (fov_y * 0.5).tan();
        // A point at (x, y, z) from the centre, z towards the camera, is in the picture from distance d if |y| ≤ (d −
        // z) tan.
        let distance = mesh.faces().iter().flatten().fold(0.0_f64, |distance, &i| {
            let p = mesh.positions()[i as usize].cast::<f64>() - centre;
            let (x, y, z) = (camera.right.dot(&p).abs(), camera.up.dot(&p).abs(), back.dot(&p));
            distance.max(z + 1.04 * (y / half).max(x / (half * aspect)))
        });
        Self::look_at(centre + back * distance.max(radius * 1e-3), centre, *up, fov_y)
    }

    /// Where the camera stands.
    pub fn eye(&self) -> Vector3<f64> {
        self.eye
    }

    /// The direction it looks along.
    pub fn forward(&self) -> UnitVector3<f64> {
        UnitVector3::new_unchecked(self.forward)
    }

    /// The vertical field of view in radians.
    pub fn fov_y(&self) -> f64 {
        self.fov_y
    }

    /// The direction of a point of the picture.
    pub fn direction(&self, x: f64, y: f64) -> UnitVector3<f64> {
        let half = (self.fov_y * 0.5).tan();
        UnitVector3::new_normalize(self.forward + (self.right * x + self.up * y) * half)
    }

    /// The point of the picture where a point of the world is seen; None behind the camera.
    pub fn project(&self, point: &Vector3<f64>) -> Option<[f64; 2]> {
        let p = point - self.eye;
        let z = self.forward.dot(&p);
        let half = (self.fov_y * 0.5).tan();
        (z > 0.0).then(|| [self.right.dot(&p) / (z * half), self.up.dot(&p) / (z * half)])
    }
}

/// The unit vector along `v`, also where its square would overflow or underflow; None for zero and what is not finite.
fn unit(v: &Vector3<f64>) -> Option<Vector3<f64>> {
    let largest = v.amax();
    (largest > 0.0 && largest.is_finite()).then(|| (v / largest).normalize())
}

approx_by_parts!([] Camera, f64, |c| close [[c.eye, c.right, c.up, c.forward], [c.fov_y]] same []);
