//! Products of a tall matrix A (scaled, shifted rows) with small ones, either way round, and its Gram matrices.

use pulp::{Arch, Simd, WithSimd};

use super::rows::Rows;
use super::tile::{DEPTH, LEFT_TILE, TILE_ROWS, Tiles, tile_columns};
use crate::{Real, parallel};

/// Which elements of a symmetric product are wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Part {
    All,
    /// Those with row ≥ column; others may be left 0.
    Lower,
}

/// Rows packed as the right factor of [`times_rows`]: blocks of [`DEPTH`] columns, in each the panels of a tile's
/// width.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct Factors<E> {
    data: Vec<E>,
    len: usize,
    columns: usize,
}

impl<E: Real> Factors<E> {
    pub(in super::super) fn new<T: Real>(rows: &Rows<T, E>) -> Self {
        let (width, len, columns) = (tile_columns::<E>(), rows.len(), rows.columns());
        let panels = len.div_ceil(width);
        let mut data = vec![E::zero(); panels * width * columns];
        for first in (0..columns).step_by(DEPTH) {
            let depth = DEPTH.min(columns - first);
            let block = &mut data[first * panels * width..][..depth * panels * width];
            let mut line = [E::zero(); DEPTH];
            for i in 0..len {
                rows.copy(i, first, &mut line[..depth]);
                let panel = &mut block[i / width * width * depth..];
                (0..depth).for_each(|k| panel[k * width + i % width] = line[k]);
            }
        }
        Self { data, len, columns }
    }

    /// Of rows as they are.
    pub(in super::super) fn plain(data: &[E], columns: usize) -> Self {
        let zeros = vec![E::zero(); columns];
        Self::new(&Rows::new(data, &zeros, super::rows::Scaling::of::<E>(0.0)))
    }

    pub(in super::super) fn len(&self) -> usize {
        self.len
    }
}

/// Rows of a task of [`times_rows`]: their tiles stay in the second cache while the panels pass.
const CHUNK: usize = 16 * TILE_ROWS;

/// A Qᵀ: `out[i·p + j]` = Σ_k a_ik q_jk. Each element has the same bits whatever other rows there are.
pub(in super::super) fn times_rows<T: Real, E: Real>(rows: &Rows<T, E>, q: &Factors<E>, part: Part, out: &mut [E]) {
    assert!(rows.columns() == q.columns && out.len() == rows.len() * q.len);
    let arch = Arch::new();
    parallel::chunks(
        out,
        CHUNK * q.len,
        || (),
        |chunk, out, ()| times_some_rows(arch, rows, q, (chunk * CHUNK, part), out),
    );
}

/// The part of [`times_rows`] that begins at row `start` and has as many rows as `out`, on this thread.
pub(in super::super) fn times_some_rows<T: Real, E: Real>(
    arch: Arch,
    rows: &Rows<T, E>,
    q: &Factors<E>,
    (start, part): (usize, Part),
    out: &mut [E],
) {
    let (width, count) = (tile_columns::<E>(), out.len() / q.len);
    let padded = q.len.div_ceil(width) * width;
    let mut left = vec![E::zero(); count.div_ceil(TILE_ROWS) * LEFT_TILE];
    out.fill(E::zero());
    for first in (0..q.columns).step_by(DEPTH) {
        let depth = DEPTH.min(q.columns - first);
        arch.dispatch(CopyRows { rows, start, count, first, depth, width: DEPTH, out: &mut left });
        let wanted =
            |tile: usize, panel: usize| part == Part::All || start + tile * TILE_ROWS + TILE_ROWS > panel * width;
        let right = &q.data[first * padded..][..depth * padded];
        let with = |tile: usize, panel: usize, sums: &[E; TILE_ROWS * 16]| {
            let columns = panel * width..q.len.min((panel + 1) * width);
            for (r, i) in (tile * TILE_ROWS..count.min((tile + 1) * TILE_ROWS)).enumerate() {
                let out = &mut out[i * q.len..][columns.clone()];
                out.iter_mut().zip(&sums[r * width..]).for_each(|(out, &sum)| *out += sum);
            }
        };
        Tiles { left: &left, right, depth, wanted, with }.run(arch);
    }
}

/// Copies rows `start..start + count`, columns `first..first + depth`, into panels of `width` columns, one after the
/// other.
///
/// Row by row: a row's columns lie in a run, rows may lie a page apart.
struct CopyRows<'a, 'b, T, E> {
    rows: &'a Rows<'b, T, E>,
    start: usize,
    count: usize,
    first: usize,
    depth: usize,
    width: usize,
    out: &'a mut [E],
}

impl<T: Real, E: Real> WithSimd for CopyRows<'_, '_, T, E> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { rows, start, count, first, depth, width, out } = self;
        for i in 0..count {
            for column in (0..depth).step_by(width) {
                let out = &mut out[column * count + i * width..][..width.min(depth - column)];
                rows.copy(start + i, first + column, out);
            }
        }
    }
}

/// The left factor of [`transpose_times`].
#[derive(Clone, Copy)]
pub(in super::super) enum Left<'a, E> {
    /// A matrix Y with as many rows as A, row-major, and its columns.
    Matrix(&'a [E], usize),
    /// A itself: the Gram matrix.
    Itself(Part),
}

/// Yᵀ A: `out[j·columns + c]` = Σ_i y_ij a_ic.
pub(in super::super) fn transpose_times<T: Real, E: Real>(rows: &Rows<T, E>, left: Left<E>) -> Vec<f64> {
    let (p, part) = match left {
        Left::Matrix(_, p) => (p, Part::All),
        Left::Itself(part) => (rows.columns(), part),
    };
    let mut sums = TransposeSums::new(p, part, rows.columns());
    for first in (0..rows.len()).step_by(DEPTH) {
        let left = match left {
            Left::Matrix(y, p) => Left::Matrix(&y[first * p..], p),
            Left::Itself(part) => Left::Itself(part),
        };
        sums.add(rows, first, left);
    }
    sums.finish()
}

/// Q Aᵀ A, of [`times_rows`] and [`transpose_times`] with the same bits, in one pass over A: rows come from memory once
/// for both.
pub(in super::super) fn there_and_back<T: Real, E: Real>(rows: &Rows<T, E>, q: &Factors<E>) -> Vec<f64> {
    let arch = Arch::new();
    let p = q.len;
    let mut y = vec![E::zero(); DEPTH.min(rows.len()) * p];
    let mut sums = TransposeSums::new(p, Part::All, rows.columns());
    for start in (0..rows.len()).step_by(DEPTH) {
        let y = &mut y[..DEPTH.min(rows.len() - start) * p];
        parallel::chunks(
            y,
            CHUNK * p,
            || (),
            |chunk, out, ()| times_some_rows(arch, rows, q, (start + chunk * CHUNK, Part::All), out),
        );
        sums.add(rows, start, Left::Matrix(y, p));
    }
    sums.finish()
}

/// Columns of a task, a multiple of both tiles' widths.
const BLOCK: usize = 128;

/// Yᵀ A while it is summed, [`DEPTH`] rows at a time.
struct TransposeSums<E> {
    arch: Arch,
    part: Part,
    p: usize,
    columns: usize,
    /// Blocks of columns, each p × its width.
    blocks: Vec<f64>,
    tiles: Vec<E>,
}

impl<E: Real> TransposeSums<E> {
    fn new(p: usize, part: Part, columns: usize) -> Self {
        let tiles = vec![E::zero(); p.div_ceil(TILE_ROWS) * LEFT_TILE];
        Self { arch: Arch::new(), part, p, columns, blocks: vec![0.0; p * columns], tiles }
    }

    /// Adds the terms from row `first`; a left matrix begins with them.
    fn add<T: Real>(&mut self, rows: &Rows<T, E>, first: usize, left: Left<E>) {
        let depth = DEPTH.min(rows.len() - first);
        pack_left(rows, left, (first, depth), &mut self.tiles);
        let (arch, part, p, tiles) = (self.arch, self.part, self.p, &self.tiles);
        parallel::chunks(
            &mut self.blocks,
            p * BLOCK,
            || (),
            |block, out, ()| {
                let terms = Terms { first, depth, start: block * BLOCK, width: out.len() / p, part };
                transpose_times_block(arch, rows, tiles, terms, out);
            },
        );
    }

    fn finish(self) -> Vec<f64> {
        unblock(&self.blocks, self.p, self.columns, BLOCK)
    }
}

/// The terms of a sum (rows of A) and the columns of A.
#[derive(Clone, Copy)]
struct Terms {
    first: usize,
    depth: usize,
    start: usize,
    width: usize,
    part: Part,
}

fn transpose_times_block<T: Real, E: Real>(arch: Arch, rows: &Rows<T, E>, left: &[E], terms: Terms, out: &mut [f64]) {
    let Terms { first, depth, start, width, part } = terms;
    let lanes = tile_columns::<E>();
    let p = out.len() / width;
    let mut right = vec![E::zero(); width.div_ceil(lanes) * lanes * depth];
    let copy = CopyRows { rows, start: first, count: depth, first: start, depth: width, width: lanes, out: &mut right };
    arch.dispatch(copy);
    let wanted = |tile: usize, panel: usize| part == Part::All || (tile + 1) * TILE_ROWS > start + panel * lanes;
    let with = |tile: usize, panel: usize, sums: &[E; TILE_ROWS * 16]| {
        let columns = panel * lanes..width.min((panel + 1) * lanes);
        for (r, j) in (tile * TILE_ROWS..p.min((tile + 1) * TILE_ROWS)).enumerate() {
            let out = &mut out[j * width..][columns.clone()];
            out.iter_mut().zip(&sums[r * lanes..]).for_each(|(out, sum)| *out += sum.widen());
        }
    };
    Tiles { left, right: &right, depth, wanted, with }.run(arch);
}

/// Terms `first..first + depth` of the left factor's columns, as tiles; a matrix begins with them.
fn pack_left<T: Real, E: Real>(rows: &Rows<T, E>, left: Left<E>, (first, depth): (usize, usize), tiles: &mut [E]) {
    let mut line = vec![E::zero(); rows.columns()];
    for k in 0..depth {
        let y = match left {
            Left::Matrix(y, p) => &y[k * p..][..p],
            Left::Itself(_) => {
                rows.copy(first + k, 0, &mut line);
                &line
            }
        };
        y.iter().enumerate().for_each(|(j, &y)| tiles[j * DEPTH + k] = y);
    }
}

fn unblock(blocks: &[f64], p: usize, columns: usize, block: usize) -> Vec<f64> {
    let mut out = vec![0.0; p * columns];
    for (b, part) in blocks.chunks((p * block).max(1)).enumerate() {
        let width = part.len() / p;
        for (j, part) in part.chunks_exact(width).enumerate() {
            out[j * columns + b * block..][..width].copy_from_slice(part);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::super::random::Random;
    use super::super::rows::Scaling;
    use super::*;

    /// Pseudo-random numbers in (−1, 1) that `T` holds.
    fn numbers<T: Real>(seed: u64, len: usize) -> Vec<T> {
        let mut random = Random::new(seed, 0);
        (0..len).map(|_| T::of(2.0 * random.unit() - 1.0)).collect()
    }

    /// Q Aᵀ A and Σ|q||a||a|, what its rounding is a share of, in `f64`: a = x/2 − shift.
    fn naive<T: Real>(data: &[&[T]], shift: &[T], q: &[T]) -> (Vec<f64>, Vec<f64>) {
        let columns = shift.len();
        let p = q.len() / columns.max(1);
        let (mut out, mut sizes) = (vec![0.0; p * columns], vec![0.0; p * columns]);
        for row in data {
            let a: Vec<f64> = (0..columns).map(|c| 0.5 * row[c].widen() - shift[c].widen()).collect();
            for j in 0..p {
                let (mut y, mut size) = (0.0, 0.0);
                for c in 0..columns {
                    let term = a[c] * q[j * columns + c].widen();
                    y += term;
                    size += term.abs();
                }
                for c in 0..columns {
                    out[j * columns + c] += y * a[c];
                    sizes[j * columns + c] += size * a[c].abs();
                }
            }
        }
        (out, sizes)
    }

    /// The largest error, in ε of the sum of magnitudes.
    fn error<T: Real>(rows: usize, columns: usize, p: usize) -> f64 {
        let (data, shift, q) = (numbers::<T>(1, rows * columns), numbers(2, columns), numbers::<T>(3, p * columns));
        // |x| < 1 and a "largest" of 1: half of it is taken.
        let all = Rows::new(&data, &shift, Scaling::of::<T>(1.0));
        let factors = Factors::plain(&q, columns);
        let every_other: Vec<u32> = (0..all.len() as u32).rev().step_by(2).collect();
        let mut worst = 0.0f64;
        for order in [None, Some(&every_other[..])] {
            let rows = order.map_or(all, |order| all.only(order));
            let got = there_and_back(&rows, &factors);
            let mut y = vec![T::of(f64::NAN); rows.len() * p];
            times_rows(&rows, &factors, Part::All, &mut y);
            assert_eq!(got, transpose_times(&rows, Left::Matrix(&y, p)), "{} × {columns}, {p}: two passes", rows.len());
            let row = |i: usize| &data[order.map_or(i, |order| order[i] as usize) * columns..][..columns];
            let (want, sizes) = naive(&(0..rows.len()).map(row).collect::<Vec<_>>(), &shift, &q);
            assert_eq!(got.len(), want.len());
            for ((got, want), size) in got.iter().zip(&want).zip(&sizes) {
                let error = (got - want).abs() / (T::epsilon().widen() * size.max(f64::MIN_POSITIVE));
                worst = if error > worst || error.is_nan() { error } else { worst };
            }
        }
        worst
    }

    /// At the edges of tiles (6 rows, 8 or 16 columns), of tasks (96 rows, 128 columns) and of what a tile sums (256).
    #[test]
    fn there_and_back_is_the_naive_product() {
        let sizes = [
            [0, 9, 3],
            [1, 1, 1],
            [1, 17, 5],
            [5, 7, 6],
            [6, 8, 7],
            [7, 16, 8],
            [13, 9, 9],
            [95, 15, 16],
            [97, 129, 17],
            [255, 128, 6],
            [257, 127, 33],
            [256, 256, 1],
            [600, 300, 13],
            [40, 530, 20],
        ];
        for [rows, columns, p] in sizes {
            let errors = [error::<f32>(rows, columns, p), error::<f64>(rows, columns, p)];
            // Measured: 1.6 and 1.1.
            assert!(errors.iter().all(|&error| error <= 4.0), "{rows} × {columns}, {p}: {errors:?} ε");
        }
    }
}
