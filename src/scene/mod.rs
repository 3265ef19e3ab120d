//! Scenes: what is lit, by what, and what the right answer is.

mod brdf;
mod bvh;
mod camera;
mod mesh;
mod picture;
mod procedural;
pub mod visibility;

pub use brdf::Brdf;
pub use bvh::{Bvh, Hit};
pub use camera::Camera;
pub use mesh::{Bounds, Frame, Mesh, MeshRepair};
pub use picture::Picture;
pub use procedural::{Model, Procedural};
pub use visibility::{
    BackFaces, BinaryVisibility, FractionalVisibility, VisibilityBaker, VisibilityScratch, VisibilitySettings,
};
