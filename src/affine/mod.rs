//! Affine wavelets: what a Haar signal becomes when it is scaled and moved, without leaving the wavelet basis.

mod canonical;
mod map;

pub use canonical::{Mother, canonical, canonical_batch, canonical_gradient, canonical_slope};
pub use map::AffineMap;
