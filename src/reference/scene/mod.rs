//! Twins of `scene`.

pub mod brdf;
pub mod ground_truth;
