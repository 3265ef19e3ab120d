//! Haar wavelets.

mod index;
mod sparse;

pub use index::{Index1d, Index2d, Kind};
pub use sparse::SparseVector;
