//! Which directions a vertex sees.
//!
//! | type | a texel holds | made by |
//! |---|---|---|
//! | [`BinaryVisibility`] | one bit: the centre direction is free | [`VisibilityBaker::bake`] |
//! | [`FractionalVisibility`] | the share of n×n directions in it that are free | [`VisibilityBaker::bake_fractional`] |

mod baker;
mod binary;
mod fractional;
mod lanes;
mod live;
mod origin;
pub mod trace;

pub use baker::{BackFaces, VisibilityBaker, VisibilityScratch, VisibilitySettings};
pub use binary::BinaryVisibility;
pub use fractional::FractionalVisibility;
