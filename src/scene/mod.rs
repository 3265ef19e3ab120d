//! Scenes: what is lit, by what, and what the right answer is.

mod brdf;
mod mesh;
mod visibility;

pub use brdf::Brdf;
pub use mesh::{Bounds, Frame, Mesh, MeshRepair};
pub use visibility::BinaryVisibility;
