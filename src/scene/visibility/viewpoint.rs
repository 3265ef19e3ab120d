//! Where rays start and how their directions are turned.

use nalgebra::{Matrix3, Vector3};

use super::origin::starts;
use crate::scene::{LocalFrame, Mesh};
use crate::{Error, Result};

/// An origin of rays, the frame of their directions, and the horizon below which there are none.
///
/// Without a frame, directions are those of the world. Without a horizon, all of them are looked along; with one, those
/// with n · ω > 0.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Vector3, scene::{LocalFrame, Viewpoint}};
/// let frame = LocalFrame::around(&Vector3::x_axis());
/// let probe = Viewpoint::new(Vector3::new(0.0, 1.5, 0.0))?.with_frame(frame)?;
/// assert_eq!(probe.horizon(), None);
/// assert!(Viewpoint::new(Vector3::repeat(f64::NAN)).is_err());
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewpoint {
    position: Vector3<f64>,
    frame: Option<LocalFrame>,
    horizon: Option<Vector3<f64>>,
}

impl Viewpoint {
    /// A free point that looks everywhere, along the axes of the world.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a coordinate is NaN or infinite.
    pub fn new(position: Vector3<f64>) -> Result<Self> {
        match position.iter().position(|c| !c.is_finite()) {
            Some(index) => Err(Error::NotFinite { what: "coordinate of a viewpoint", index }),
            None => Ok(Self { position, frame: None, horizon: None }),
        }
    }

    /// The vertices of a mesh with their horizons, along the axes of the world: what
    /// [`VisibilityBaker`](super::VisibilityBaker) looks from.
    ///
    /// Rays start off the surface, as told there; `offset` is that of
    /// [`VisibilitySettings`](super::VisibilitySettings::offset). For the local frames, add them with
    /// [`with_frame`](Self::with_frame).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 0 ≤ `offset` ≤ 1.
    pub fn of_vertices(mesh: &Mesh, offset: f64) -> Result<Vec<Self>> {
        if !(0.0..=1.0).contains(&offset) {
            return Err(Error::OutOfRange { what: "visibility offset", got: offset, allowed: "in [0, 1]" });
        }
        let view = |(position, normal): (Vector3<f64>, &Vector3<f32>)| Self {
            position,
            frame: None,
            horizon: Some(normal.cast()),
        };
        Ok(starts(mesh, offset).zip(mesh.normals()).map(view).collect())
    }

    /// The same point with directions in a frame.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless its axes are orthonormal to 10⁻³.
    pub fn with_frame(self, frame: LocalFrame) -> Result<Self> {
        frame.check("dot products of a viewpoint's axes, less those of orthonormal ones")?;
        Ok(Self { frame: Some(frame), ..self })
    }

    /// The same point that looks only along directions ω of the world with n · ω > 0.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a component of `normal` is NaN or infinite. Its length does not matter.
    pub fn with_horizon(self, normal: Vector3<f64>) -> Result<Self> {
        match normal.iter().position(|c| !c.is_finite()) {
            Some(index) => Err(Error::NotFinite { what: "component of a horizon's normal", index }),
            None => Ok(Self { horizon: Some(normal), ..self }),
        }
    }

    /// Where rays start.
    pub fn position(&self) -> Vector3<f64> {
        self.position
    }

    /// The frame of directions; `None` is the world's axes.
    pub fn frame(&self) -> Option<LocalFrame> {
        self.frame
    }

    /// The normal of the horizon, if there is one.
    pub fn horizon(&self) -> Option<Vector3<f64>> {
        self.horizon
    }

    /// Local directions to the world; `None` is the identity.
    pub(super) fn to_world(self) -> Option<Matrix3<f64>> {
        self.frame.map(|frame| axes(&frame))
    }
}

fn axes(frame: &LocalFrame) -> Matrix3<f64> {
    Matrix3::from_columns(&[frame.tangent, frame.bitangent, frame.normal].map(|a| a.cast()))
}
