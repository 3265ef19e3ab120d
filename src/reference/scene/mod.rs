//! Naive twins of [`scene`](crate::scene).

pub mod brdf;
mod expansion;
pub mod ground_truth;
mod visibility;

pub use expansion::brdf_expansion;
pub use visibility::{closest_hit, is_free, occluded, sees};
