//! Scenes: what is lit, by what, and what the right answer is.

mod brdf;
mod light;
mod mesh;
mod metrics;
mod tone_map;
mod visibility;

pub use brdf::Brdf;
pub use light::{EnvironmentLight, Sky, SoftBox, Sun};
pub use mesh::{Bounds, Frame, Mesh, MeshRepair};
pub use metrics::{Comparison, max_abs, percentile_peak, psnr_db, rel_l2};
pub use tone_map::{ToneMap, linear_to_srgb, srgb_to_linear};
pub use visibility::BinaryVisibility;
