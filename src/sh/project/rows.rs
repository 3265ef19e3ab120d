//! Sums of a row of texels against cosines and sines, and such series at the texels of a row.
//!
//! Rows come in mirrored pairs and columns mirror within a row, so that four texels share a cosine. Their sums and
//! differences are the four classes (row even, odd) × (column even, odd): cosines meet only the column-even ones, sines
//! only the odd. bands cosines and sines for half a row each: a multiplication for each texel, channel and band.
//!
//! The second row of a pair and the second half of a row are the + sides: even = second + first, odd = second − first.

use pulp::{Arch, Simd, WithSimd};

use super::Channels;
use crate::numeric::arch_256;
use crate::{Real, parallel};

/// Functions are padded to a multiple of this.
const PAD: usize = 8;
/// Columns that are summed in T before they go to `f64`.
const RUN: usize = 64;

/// Functions of a row, padded.
pub(super) const fn padded(bands: usize) -> usize {
    bands.next_multiple_of(PAD)
}

/// Values at (parity of row, parity of column, function) of one channel start at `class(row, column, functions)`.
pub(super) const fn class(row: usize, column: usize, functions: usize) -> usize {
    (2 * row + column) * functions
}

const fn lanes<T>() -> usize {
    if size_of::<T>() == 4 { 8 } else { 4 }
}

/// A table of {cos, sin} k α(x) times a weight for half the columns of some rows, k < bands.
///
/// To gather, lanes are functions: `[row][block of functions][column][cos, sin][lane]`. To spread, they are columns:
/// `[row][block of columns][function][cos, sin][lane]`.
#[derive(Debug, Clone)]
pub(super) struct RowTable<T> {
    functions: usize,
    half: usize,
    /// Scalars of one row.
    stride: usize,
    values: Vec<T>,
    arch: Arch,
}

/// What a table is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Use {
    Gather,
    Spread,
}

impl<T: Real> RowTable<T> {
    /// A table of `rows`; `fill(row, column, values)` adds to the (cos, sin) of each k < bands.
    pub(super) fn new(
        use_for: Use,
        [bands, half, rows]: [usize; 3],
        mut fill: impl FnMut(usize, usize, &mut [[f64; 2]]),
    ) -> Self {
        let lanes = lanes::<T>();
        let functions = padded(bands);
        let columns = half.next_multiple_of(lanes);
        let stride = match use_for {
            Use::Gather => 2 * functions * half,
            Use::Spread => 2 * bands * columns,
        };
        let mut values = vec![T::zero(); rows * stride];
        let mut entry = vec![[0.0; 2]; bands];
        for (row, values) in values.chunks_exact_mut(stride).enumerate() {
            for x in 0..half {
                entry.fill([0.0; 2]);
                fill(row, x, &mut entry);
                for (k, &[cos, sin]) in entry.iter().enumerate() {
                    let (block, lane) = match use_for {
                        Use::Gather => (k / lanes * half + x, k % lanes),
                        Use::Spread => (x / lanes * bands + k, x % lanes),
                    };
                    values[2 * block * lanes + lane] = T::of(cos);
                    values[(2 * block + 1) * lanes + lane] = T::of(sin);
                }
            }
        }
        Self { functions, half, stride, values, arch: arch_256() }
    }

    fn row(&self, row: usize) -> &[T] {
        &self.values[row * self.stride..][..self.stride]
    }

    /// Adds the moments of a pair of rows with the table's rows `first`… to `out`: `[row][channel][class][function]`.
    ///
    /// The second row of a pair is the first where they are one.
    #[inline]
    pub(super) fn gather<P: Channels<C, Scalar = T>, const C: usize>(
        &self,
        pair: [&[P]; 2],
        first: usize,
        out: &mut [f64],
    ) {
        self.arch.dispatch(Gather::<P, T, C> { table: self, pair, first, out });
    }

    /// Writes a pair of rows: Σ over the table's rows `first`… of the series in `series`, laid out as
    /// [`gather`](Self::gather)'s moments but of T. The second row is empty where it is the first.
    #[inline]
    pub(super) fn spread<P: Channels<C, Scalar = T>, const C: usize>(
        &self,
        pair: [&mut [P]; 2],
        first: usize,
        series: &[T],
    ) {
        self.arch.dispatch(Spread::<P, T, C> { table: self, pair, first, series });
    }
}

struct Gather<'a, P, T, const C: usize> {
    table: &'a RowTable<T>,
    pair: [&'a [P]; 2],
    first: usize,
    out: &'a mut [f64],
}

impl<T: Real, P: Channels<C, Scalar = T>, const C: usize> WithSimd for Gather<'_, P, T, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        if lanes::<T>() == 8 { self.run::<8>() } else { self.run::<4>() }
    }
}

impl<T: Real, P: Channels<C, Scalar = T>, const C: usize> Gather<'_, P, T, C> {
    #[inline(always)]
    fn run<const L: usize>(self) {
        let RowTable { functions, half, .. } = *self.table;
        let mut folded = [[[T::zero(); 4]; C]; RUN];
        for start in (0..half).step_by(RUN) {
            let count = RUN.min(half - start);
            fold(self.pair, start, &mut folded[..count]);
            for (row, out) in self.out.chunks_exact_mut(4 * C * functions).enumerate() {
                let (table, _) = self.table.row(self.first + row).as_chunks::<L>();
                let (table, _) = table.as_chunks::<2>();
                for (block, table) in table.chunks_exact(half).enumerate() {
                    let sums = moments(&table[start..start + count], &folded[..count]);
                    for (c, sums) in sums.iter().enumerate() {
                        for (class, sums) in sums.iter().enumerate() {
                            let out = &mut out[(4 * c + class) * functions + block * L..][..L];
                            for i in 0..L {
                                out[i] += sums[i].widen();
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The four sums and differences of the mirrored texels of columns `start`…
#[inline(always)]
fn fold<T: Real, P: Channels<C, Scalar = T>, const C: usize>(
    [top, bottom]: [&[P]; 2],
    start: usize,
    folded: &mut [[[T; 4]; C]],
) {
    let width = top.len();
    let count = folded.len();
    let mirrored = width - start - count..width - start;
    let left = top[start..start + count].iter().zip(&bottom[start..start + count]);
    let right = top[mirrored.clone()].iter().rev().zip(bottom[mirrored].iter().rev());
    for (folded, ((&tl, &bl), (&tr, &br))) in folded.iter_mut().zip(left.zip(right)) {
        let [tl, bl, tr, br] = [tl, bl, tr, br].map(P::channels);
        for c in 0..C {
            let (even_l, odd_l) = (bl[c] + tl[c], bl[c] - tl[c]);
            let (even_r, odd_r) = (br[c] + tr[c], br[c] - tr[c]);
            folded[c] = [even_r + even_l, even_r - even_l, odd_r + odd_l, odd_r - odd_l];
        }
    }
}

#[inline(always)]
fn moments<T: Real, const L: usize, const C: usize>(table: &[[[T; L]; 2]], folded: &[[[T; 4]; C]]) -> [[[T; L]; 4]; C] {
    let mut sums = [[[T::zero(); L]; 4]; C];
    for (table, folded) in table.iter().zip(folded) {
        for c in 0..C {
            for class in 0..4 {
                for i in 0..L {
                    sums[c][class][i] += table[class % 2][i] * folded[c][class];
                }
            }
        }
    }
    sums
}

struct Spread<'a, P, T, const C: usize> {
    table: &'a RowTable<T>,
    pair: [&'a mut [P]; 2],
    first: usize,
    series: &'a [T],
}

impl<T: Real, P: Channels<C, Scalar = T>, const C: usize> WithSimd for Spread<'_, P, T, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        if lanes::<T>() == 8 { self.run::<8>() } else { self.run::<4>() }
    }
}

impl<T: Real, P: Channels<C, Scalar = T>, const C: usize> Spread<'_, P, T, C> {
    #[inline(always)]
    fn run<const L: usize>(self) {
        let RowTable { functions, half, stride, .. } = *self.table;
        let Self { pair: [top, bottom], series, .. } = self;
        let width = top.len();
        let blocks = half.div_ceil(L);
        let bands = stride / (2 * blocks * L);
        for block in 0..blocks {
            let mut sums = [[[T::zero(); L]; 4]; C];
            for (row, series) in series.chunks_exact(4 * C * functions).enumerate() {
                let (table, _) = self.table.row(self.first + row).as_chunks::<L>();
                let (table, _) = table.as_chunks::<2>();
                add_series(&table[block * bands..][..bands], series, functions, &mut sums);
            }
            for i in 0..L.min(half - block * L) {
                let x = block * L + i;
                // The texels (row, column) of sides −−, −+, +−, ++.
                let mut texels = [[T::zero(); C]; 4];
                for c in 0..C {
                    let [[ee, eo], [oe, oo]] = [[sums[c][0][i], sums[c][1][i]], [sums[c][2][i], sums[c][3][i]]];
                    let (even_l, even_r, odd_l, odd_r) = (ee - eo, ee + eo, oe - oo, oe + oo);
                    texels[0][c] = even_l - odd_l;
                    texels[1][c] = even_r - odd_r;
                    texels[2][c] = even_l + odd_l;
                    texels[3][c] = even_r + odd_r;
                }
                // Where rows or columns are their own mirrors, the + side is written last.
                if !bottom.is_empty() {
                    top[x] = P::from_channels(texels[0]);
                    top[width - 1 - x] = P::from_channels(texels[1]);
                    bottom[x] = P::from_channels(texels[2]);
                    bottom[width - 1 - x] = P::from_channels(texels[3]);
                } else {
                    top[x] = P::from_channels(texels[2]);
                    top[width - 1 - x] = P::from_channels(texels[3]);
                }
            }
        }
    }
}

#[inline(always)]
fn add_series<T: Real, const L: usize, const C: usize>(
    table: &[[[T; L]; 2]],
    series: &[T],
    functions: usize,
    sums: &mut [[[T; L]; 4]; C],
) {
    let mut local = *sums;
    // One length for all, so that the bounds are checked here.
    let mut rows = [[&series[..0]; 4]; C];
    for c in 0..C {
        for class in 0..4 {
            rows[c][class] = &series[(4 * c + class) * functions..][..table.len()];
        }
    }
    for (k, table) in table.iter().enumerate() {
        for c in 0..C {
            for class in 0..4 {
                let factor = rows[c][class][k];
                for i in 0..L {
                    local[c][class][i] += table[class % 2][i] * factor;
                }
            }
        }
    }
    *sums = local;
}

/// Runs `f(index, slot)` over slots of `stride` elements, which do not depend on each other; in parallel if each takes
/// `operations` so many that waking threads pays.
pub(super) fn for_each_slot<T: Send>(
    out: &mut [T],
    stride: usize,
    operations: usize,
    f: impl Fn(usize, &mut [T]) + Sync,
) {
    /// About a tenth of a millisecond of multiplications and additions, in vectors.
    const WORTH: usize = 1 << 20;
    if (out.len() / stride).saturating_mul(operations) > WORTH {
        parallel::chunks(out, stride, || (), |i, slot, ()| f(i, slot));
    } else {
        out.chunks_mut(stride).enumerate().for_each(|(i, slot)| f(i, slot));
    }
}

/// Pairs of mirrored rows, from the outside in; a middle row comes with an empty one.
pub(super) fn mirrored_pairs<P>(image: &mut [P], width: usize) -> Vec<[&mut [P]; 2]> {
    let mut rows = image.chunks_exact_mut(width);
    let mut pairs = Vec::new();
    while let Some(top) = rows.next() {
        pairs.push([top, rows.next_back().unwrap_or_default()]);
    }
    pairs
}
