//! What a caller may say about a mesh file.

use nalgebra::{Scalar, Vector3};

/// How a mesh file is to be taken, for [`load_mesh_with`](super::load_mesh_with) and the readers of bytes.
///
/// # Example
/// ```
/// use haarmonic::{io::{MeshOptions, Up, Winding, read_obj_with}, nalgebra::Vector3};
///
/// // A triangle in the plane of the ground, as a program whose z axis points up writes it.
/// let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// let options = MeshOptions::default().with_up(Up::Z).with_winding(Winding::Keep);
/// let mesh = read_obj_with(text, "a.obj", &options)?.value;
/// assert_eq!(mesh.normals()[0], Vector3::y());
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct MeshOptions {
    /// Whether faces may be turned.
    pub winding: Winding,
    /// The file's axis that points up.
    pub up: Up,
}

impl MeshOptions {
    /// The same with another treatment of winding.
    #[must_use]
    pub const fn with_winding(mut self, winding: Winding) -> Self {
        self.winding = winding;
        self
    }

    /// The same with another axis up.
    #[must_use]
    pub const fn with_up(mut self, up: Up) -> Self {
        self.up = up;
        self
    }
}

/// What is done about faces that are wound the wrong way round, which would be lit from behind.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Winding {
    /// Faces of closed surfaces are turned, with a warning, where it is clear which side is outside.
    ///
    /// Within a surface that is closed and has two sides, faces that disagree with their neighbours are turned; then
    /// the normals that the file gives say which way is out, else the volume, which must be positive. A surface without
    /// given normals that is wound inwards throughout is turned if no other closed surface is inside or around it. With
    /// others it may be a room with its furniture or the inner side of a shell: it stays, with a warning where it is
    /// the outermost. So does an open surface whose faces disagree.
    #[default]
    Repair,
    /// Faces stay as the file has them, without a word: for rooms that are seen from inside.
    Keep,
}

/// The axis of a file's coordinates that points up. The mesh is turned so that it becomes +y, the house's convention,
/// in which the light of environment maps falls from above.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Up {
    /// +x: (x, y, z) becomes (−y, x, z).
    X,
    /// +y: nothing is turned.
    #[default]
    Y,
    /// +z, as in CAD, surveying and Blender: (x, y, z) becomes (x, z, −y).
    Z,
}

impl Up {
    /// The vector, turned. No number is rounded.
    pub(super) fn turn<T: Scalar + std::ops::Neg<Output = T>>(self, v: &Vector3<T>) -> Vector3<T> {
        let [x, y, z] = v.clone().into();
        match self {
            Self::X => Vector3::new(-y, x, z),
            Self::Y => Vector3::new(x, y, z),
            Self::Z => Vector3::new(x, z, -y),
        }
    }
}
