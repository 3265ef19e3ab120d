//! Triple-product integrals ∫ L B V over one square (a face of a cube map): light, BRDF, visibility.
//!
//! | route | reads | nodes or texels | when |
//! |---|---|---|---|
//! | flat merge | [`Factor`] of L and B, V's means or bits | 3 cycles a kept node (means), 8 (bits) | few terms |
//! | masked pixels | texels of L and B, V's bits | 1 cycle for 4 to 6 texels | many terms |
//! | Ng's recursion (`reference::haar::NgTripleProduct`) | quadtrees of L and B, V's coefficients | 40 cycles a kept node or ancestor | to compare with the paper |
//!
//! Everything is stored in quadtree (Morton) order: squares of the tree are then runs of texels and bits. Bits instead
//! of means of V cost twice the time of a merge and a 25th of the memory. Measured with AVX2 by the bench
//! `triple_product`.
//!
//! [`TripleProduct`] picks between the first two.

mod bits;
mod engine;
mod masked;
mod mean_tree;
mod merge;
mod nodes;

pub use bits::{BitPyramid, BitPyramidRef};
pub use engine::{Factor, Route, TripleProduct, Visibility};
pub use masked::MaskedSum;
pub use mean_tree::MeanTree;

use crate::{Error, Result};

/// The first node of a level; for the level of the texels, the number of nodes.
#[inline]
pub(crate) const fn first_node(level: u32) -> usize {
    ((1 << (2 * level)) - 1) / 3
}

/// log₂ of a side.
pub(crate) fn levels_of(side: usize) -> Result<u32> {
    if !side.is_power_of_two() {
        return Err(Error::NotPowerOfTwo { what: "side", got: side });
    }
    if side > 1 << 14 {
        return Err(Error::OutOfRange { what: "side", got: side as f64, allowed: "at most 16384" });
    }
    Ok(side.ilog2())
}
