//! Scenes: what is lit, by what, and what the right answer is.

mod brdf;
mod mesh;
mod visibility;

pub use brdf::Brdf;
pub use mesh::{Frame, Mesh};
pub use visibility::BinaryVisibility;
