//! The kernel of every product: a tile of 6 rows and two registers of columns, summed over at most [`DEPTH`] terms.
//!
//! Both factors are packed: rows of the left one lie one after the other, `DEPTH` numbers each; the right one has the
//! numbers of a tile's columns side by side. A sum runs over ascending terms, one multiplication and one addition each,
//! so that neither the machine nor the place of an element in a tile changes its bits. Tiles beyond the first `DEPTH`
//! terms are added to what is there: a sum of n terms has an error of (256 + n/256) ε at most.

use pulp::{Arch, Simd, WithSimd};

use crate::Real;

/// Terms that a tile sums in registers. Too small and sums travel to memory and back; too large and a tile's factors
/// (6 · 256 + 16 · 256 numbers) leave the fastest cache.
pub(super) const DEPTH: usize = 256;

/// Rows of a tile: six rows of two registers, two for the right factor, one for the left, one for a product are all 16
/// registers.
pub(super) const TILE_ROWS: usize = 6;

/// Numbers of a left tile.
pub(super) const LEFT_TILE: usize = TILE_ROWS * DEPTH;

/// Columns of a tile: two registers of 8 `f32` or 4 `f64`.
pub(super) const fn tile_columns<E: Real>() -> usize {
    if size_of::<E>() == 4 { 16 } else { 8 }
}

/// Sums of a tile, row-major, [`tile_columns`] a row.
pub(super) type TileSums<E> = [E; TILE_ROWS * 16];

/// Calls `with` for the tile of each left tile and right panel that `wanted` says.
///
/// `left`: tiles of [`LEFT_TILE`]; `right`: panels of `depth` · [`tile_columns`].
pub(super) struct Tiles<'a, E, W, F> {
    pub left: &'a [E],
    pub right: &'a [E],
    pub depth: usize,
    /// (left tile, right panel) → whether to compute it.
    pub wanted: W,
    /// (left tile, right panel, sums).
    pub with: F,
}

impl<E: Real, W: Fn(usize, usize) -> bool, F: FnMut(usize, usize, &TileSums<E>)> Tiles<'_, E, W, F> {
    pub(super) fn run(self, arch: Arch) {
        arch.dispatch(self);
    }

    #[inline(always)]
    fn run_lanes<const L: usize>(mut self) {
        let (left, _) = self.left.as_chunks::<DEPTH>();
        let (left, _) = left.as_chunks::<TILE_ROWS>();
        for (panel, right) in self.right.chunks_exact(self.depth * 2 * L).enumerate() {
            let (right, _) = right.as_chunks::<L>();
            let (right, _) = right.as_chunks::<2>();
            for (tile, rows) in left.iter().enumerate() {
                if !(self.wanted)(tile, panel) {
                    continue;
                }
                let mut sums = [[[E::zero(); L]; 2]; TILE_ROWS];
                add_terms(rows, right, &mut sums);
                let mut flat = [E::zero(); TILE_ROWS * 16];
                flat[..TILE_ROWS * 2 * L].copy_from_slice(sums.as_flattened().as_flattened());
                (self.with)(tile, panel, &flat);
            }
        }
    }
}

impl<E: Real, W: Fn(usize, usize) -> bool, F: FnMut(usize, usize, &TileSums<E>)> WithSimd for Tiles<'_, E, W, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        if size_of::<E>() == 4 { self.run_lanes::<8>() } else { self.run_lanes::<4>() }
    }
}

/// Each lane is one expression that ends in a store: LLVM keeps the sums in registers.
#[inline(always)]
fn add_terms<E: Real, const L: usize>(
    rows: &[[E; DEPTH]; TILE_ROWS],
    right: &[[[E; L]; 2]],
    out: &mut [[[E; L]; 2]; TILE_ROWS],
) {
    let mut sums = [[[E::zero(); L]; 2]; TILE_ROWS];
    for (k, right) in right.iter().take(DEPTH).enumerate() {
        for r in 0..TILE_ROWS {
            let x = rows[r][k];
            for v in 0..2 {
                for l in 0..L {
                    sums[r][v][l] += x * right[v][l];
                }
            }
        }
    }
    *out = sums;
}
