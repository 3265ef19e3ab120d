//! Triple-product integrals ∫ L B V over one square (a face of a cube map): light, BRDF, visibility.
//!
//! | route | reads | cost at side 64 | when |
//! |---|---|---|---|
//! | flat merge | [`SparseNodes`] and [`MeanTree`] of L and B, V's means or bits | per kept node | few terms |
//! | masked pixels | texels of L and B, V's bits | per texel, vectorised | many terms |
//! | Ng's recursion ([`NgTripleProduct`]) | quadtrees of L and B, V's coefficients | per kept node and ancestor | to compare with the paper |
//!
//! [`TripleProduct`] picks between the first two.

mod bits;
mod engine;
mod masked;
mod mean_tree;
mod merge;
mod ng;
mod nodes;

pub use bits::{BitPyramid, BitPyramidRef, rows_to_morton, upper_means};
pub use engine::{Factor, Route, TripleProduct, Visibility};
pub use masked::MaskedSum;
pub use mean_tree::MeanTree;
pub use ng::{NgTree, NgTripleProduct};
pub use nodes::SparseNodes;

use crate::{Error, Result};

/// log₂ of a side.
fn levels_of(side: usize) -> Result<u32> {
    if !side.is_power_of_two() {
        return Err(Error::NotPowerOfTwo { what: "side", got: side });
    }
    if side > 1 << 14 {
        return Err(Error::OutOfRange { what: "side", got: side as f64, allowed: "at most 16384" });
    }
    Ok(side.ilog2())
}
