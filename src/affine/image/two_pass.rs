//! Sparse operators of both axes on sparse terms.
//!
//! ```math
//! Z[i₂][k₁] = Σ_{i₁} F[i₂][i₁] D[i₁][k₁],   L[k₂][k₁] = Σ_{i₂} D[i₂][k₂] Z[i₂][k₁]          [Sun 2008, §4.5.5]
//! ```
//!
//! as in [`Propagation`](crate::affine::Propagation), but with rows of Z that hold no more than they have, and a result
//! that is a list: nothing is as large as an image. A row of Z of which much is there is held whole, and added whole.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::couplings::Couplings;
use super::wavelet_image::WaveletImage;
use crate::Real;

/// A row of Z is held whole if a sixth of it is there (measured: an entry that is looked up costs six that lie in
/// order).
const WHOLE: usize = 6;

/// The rows of Z, and which targets they reach.
#[derive(Debug, Clone)]
pub(super) struct TwoPass<T, const C: usize> {
    /// Sides of the target's grid.
    grid: [usize; 2],
    rows: Vec<Row>,
    index: Vec<u32>,
    value: Vec<[T; C]>,
    /// Which k₁ each row of Z has: a bit each.
    there: Vec<u64>,
    /// By target row k₂: the rows of Z that reach it, and how; `reach_end[k₂]` is where they end.
    reach: Vec<(u32, T)>,
    reach_end: Vec<u32>,
    sums: Vec<[T; C]>,
    bits: Vec<u64>,
    arch: Arch,
}

/// One row of Z: its entries, and whether they are those of all k₁.
#[derive(Debug, Clone)]
struct Row {
    source: u32,
    entries: Range<u32>,
    is_whole: bool,
}

impl<T: Real, const C: usize> TwoPass<T, C> {
    pub(super) fn new() -> Self {
        Self {
            grid: [1; 2],
            rows: Vec::new(),
            index: Vec::new(),
            value: Vec::new(),
            there: Vec::new(),
            reach: Vec::new(),
            reach_end: Vec::new(),
            sums: Vec::new(),
            bits: Vec::new(),
            arch: Arch::new(),
        }
    }

    /// The first pass: Z of an image, for a target of the given grid.
    pub(super) fn set(&mut self, image: &WaveletImage<T, C>, couplings: &[Couplings<T>; 2], grid: [usize; 2]) {
        let arch = self.arch;
        arch.dispatch(First { image, couplings, grid, to: self });
    }

    /// The second pass: the coefficients of rows `down` and columns `across` of the target, in flat order.
    ///
    /// `wanted`, if there is one, lists the flat indices that are.
    pub(super) fn write(
        &mut self,
        [across, down]: [Range<usize>; 2],
        wanted: Option<&[u32]>,
        out: &mut WaveletImage<T, C>,
    ) {
        let arch = self.arch;
        arch.dispatch(Second { across, down, wanted, from: self, out });
    }

    fn words(&self) -> usize {
        self.grid[0].div_ceil(64)
    }
}

struct First<'a, T, const C: usize> {
    image: &'a WaveletImage<T, C>,
    couplings: &'a [Couplings<T>; 2],
    grid: [usize; 2],
    to: &'a mut TwoPass<T, C>,
}

impl<T: Real, const C: usize> WithSimd for First<'_, T, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { image, couplings: [x, y], grid, to } = self;
        to.grid = grid;
        let (words, log_across) = (to.words(), image.grid()[0].ilog2());
        to.rows.clear();
        to.index.clear();
        to.value.clear();
        to.there.clear();
        to.sums.clear();
        to.bits.clear();
        to.sums.resize(grid[0], [T::zero(); C]);
        to.bits.resize(words, 0);
        let mask = (1u32 << log_across) - 1;
        let mut begin = 0;
        while begin < image.indices.len() {
            let source = image.indices[begin] >> log_across;
            let len = image.indices[begin..].partition_point(|&i| i >> log_across == source);
            let range = begin..begin + len;
            begin += len;
            if y.count(source as usize) == 0 {
                continue;
            }
            for (&i, value) in image.indices[range.clone()].iter().zip(&image.values[range]) {
                let (index, couplings) = x.row((i & mask) as usize);
                for (&k, &d) in index.iter().zip(couplings) {
                    let sum = &mut to.sums[k as usize];
                    for c in 0..C {
                        sum[c] += value[c] * d;
                    }
                    to.bits[k as usize / 64] |= 1 << (k % 64);
                }
            }
            let count: u32 = to.bits.iter().map(|word| word.count_ones()).sum();
            if count == 0 {
                continue;
            }
            let is_whole = count as usize * WHOLE >= grid[0];
            let first = to.value.len() as u32;
            to.there.extend_from_slice(&to.bits);
            if is_whole {
                // Rows that are not whole have no use for the indices of those that are, but share their count.
                to.index.resize(to.value.len() + grid[0], 0);
                to.value.extend_from_slice(&to.sums);
                to.sums.fill([T::zero(); C]);
                to.bits.fill(0);
            } else {
                take_bits(&mut to.bits, |k| {
                    to.index.push(k as u32);
                    to.value.push(std::mem::replace(&mut to.sums[k], [T::zero(); C]));
                });
            }
            to.rows.push(Row { source, entries: first..to.value.len() as u32, is_whole });
        }
        // Turns the couplings of the rows that there are into lists by target.
        to.reach_end.clear();
        to.reach_end.resize(grid[1] + 1, 0);
        for row in &to.rows {
            y.row(row.source as usize).0.iter().for_each(|&k| to.reach_end[k as usize + 1] += 1);
        }
        for k in 0..grid[1] {
            to.reach_end[k + 1] += to.reach_end[k];
        }
        to.reach.clear();
        to.reach.resize(to.reach_end[grid[1]] as usize, (0, T::zero()));
        for (slot, row) in to.rows.iter().enumerate() {
            let (index, couplings) = y.row(row.source as usize);
            for (&k, &d) in index.iter().zip(couplings) {
                to.reach[to.reach_end[k as usize] as usize] = (slot as u32, d);
                to.reach_end[k as usize] += 1;
            }
        }
    }
}

struct Second<'a, T, const C: usize> {
    across: Range<usize>,
    down: Range<usize>,
    wanted: Option<&'a [u32]>,
    from: &'a mut TwoPass<T, C>,
    out: &'a mut WaveletImage<T, C>,
}

impl<T: Real, const C: usize> WithSimd for Second<'_, T, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { across, down, wanted, from, out } = self;
        let (words, log_across, all) = (from.words(), from.grid[0].ilog2(), across == (0..from.grid[0]));
        let TwoPass { rows, index, value, there, reach, reach_end, sums, bits, .. } = from;
        for k2 in down {
            let first = if k2 == 0 { 0 } else { reach_end[k2 - 1] as usize };
            let list = &reach[first..reach_end[k2] as usize];
            let listed = wanted.map(|wanted| {
                let at = |k: usize| wanted.partition_point(|&i| (i as usize) < k << log_across);
                &wanted[at(k2)..at(k2 + 1)]
            });
            if list.is_empty() || listed.is_some_and(<[u32]>::is_empty) {
                continue;
            }
            for &(slot, d) in list {
                let row = &rows[slot as usize];
                let entries = row.entries.start as usize..row.entries.end as usize;
                let here = &there[slot as usize * words..][..words];
                bits.iter_mut().zip(here).for_each(|(bits, here)| *bits |= here);
                if row.is_whole {
                    let values = value[entries][across.clone()].as_flattened();
                    let sums = sums[across.clone()].as_flattened_mut();
                    sums.iter_mut().zip(values).for_each(|(sum, &z)| *sum += d * z);
                    continue;
                }
                let (mut index, mut value) = (&index[entries.clone()], &value[entries]);
                if !all {
                    let at = |k: usize| index.partition_point(|&i| (i as usize) < k);
                    let part = at(across.start)..at(across.end);
                    (index, value) = (&index[part.clone()], &value[part]);
                }
                for (&k, z) in index.iter().zip(value) {
                    let sum = &mut sums[k as usize];
                    for c in 0..C {
                        sum[c] += d * z[c];
                    }
                }
            }
            let row = (k2 << log_across) as u32;
            // Columns that are there but not asked for have the sum 0, which is not pushed.
            match listed {
                None => take_bits(bits, |k| {
                    out.push(row + k as u32, std::mem::replace(&mut sums[k], [T::zero(); C]));
                }),
                Some(listed) => {
                    listed.iter().for_each(|&i| out.push(i, sums[(i - row) as usize]));
                    take_bits(bits, |k| sums[k] = [T::zero(); C]);
                }
            }
        }
    }
}

/// Visits the bits that are set, ascending, and clears them.
#[inline(always)]
fn take_bits(bits: &mut [u64], mut visit: impl FnMut(usize)) {
    for (at, word) in bits.iter_mut().enumerate() {
        let mut left = std::mem::take(word);
        while left != 0 {
            visit(64 * at + left.trailing_zeros() as usize);
            left &= left - 1;
        }
    }
}
