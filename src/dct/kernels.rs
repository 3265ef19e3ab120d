//! The passes over one block. Everything here is `#[inline(always)]`, so that it is compiled for the vector unit of the
//! caller, which `pulp` picks once for a batch, and for the constant sides of the dispatch.
//!
//! Derivation. c_u(n−1−x) = (−1)^u c_u(x), so with s[x] = f[x] + f[n−1−x] and d[x] = f[x] − f[n−1−x], x < n/2, the odd
//! coefficients need only d and the even ones only s, which is the same problem at n/2: n = 16 costs 8² + 4² + 2² +
//! 1² + 1 multiplications a line instead of 16². That is done down the columns, a register of columns at a time. Along
//! the rows, whose samples lie in one register, a sample is broadcast and multiplies a row of the matrix: no shuffles,
//! no fold. Inverse: the transpose, in the opposite order. The first `low` frequencies alone: the same with the others
//! left out.

use super::tables::Tables;
use crate::Real;

/// What a pass needs beside its data.
#[derive(Clone, Copy)]
pub(super) struct Pass<'a, T> {
    pub tables: &'a Tables<T>,
    /// Frequencies kept on each axis.
    pub low: usize,
    /// Distance of the rows of the samples.
    pub stride: usize,
}

/// Memory for one block: L columns before and after a pass, and the block between the passes.
pub(super) struct Work<T, const N: usize, const L: usize> {
    x: [[T; L]; N],
    coefs: [[T; L]; N],
    rows: [[T; N]; N],
}

impl<T: Real, const N: usize, const L: usize> Work<T, N, L> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self { x: [[T::zero(); L]; N], coefs: [[T::zero(); L]; N], rows: [[T::zero(); N]; N] }
    }
}

/// Σ_i weights\[i\]·rows\[i\] over C terms. Each lane is one expression that ends in a store: LLVM makes a vector of
/// it.
#[inline(always)]
fn sum_of<T: Real, const C: usize, const L: usize>(weights: &[T], rows: &[[T; L]], out: &mut [T; L]) {
    let (Some(weights), Some(rows)) = (weights.first_chunk::<C>(), rows.first_chunk::<C>()) else { return };
    for j in 0..L {
        let mut sum = weights[0] * rows[0][j];
        for i in 1..C {
            sum += weights[i] * rows[i][j];
        }
        out[j] = sum;
    }
}

/// Σ_i weights\[i\]·rows\[i\] over the first `count` of K terms, in that order.
#[inline(always)]
fn sum_first<T: Real, const K: usize, const L: usize>(
    count: usize,
    weights: &[T; K],
    rows: &[[T; L]; K],
    out: &mut [T; L],
) {
    match count {
        1 => sum_of::<T, 1, L>(weights, rows, out),
        2 => sum_of::<T, 2, L>(weights, rows, out),
        4 => sum_of::<T, 4, L>(weights, rows, out),
        8 => sum_of::<T, 8, L>(weights, rows, out),
        16 => sum_of::<T, 16, L>(weights, rows, out),
        _ => {
            // Eight terms between a load and a store of the sum.
            let ((weights, last_weights), (rows, last_rows)) =
                (weights[..count].as_chunks::<8>(), rows[..count].as_chunks::<8>());
            *out = [T::zero(); L];
            for (weights, rows) in weights.iter().zip(rows) {
                for j in 0..L {
                    let mut sum = out[j];
                    for i in 0..8 {
                        sum += weights[i] * rows[i][j];
                    }
                    out[j] = sum;
                }
            }
            for (&weight, row) in last_weights.iter().zip(last_rows) {
                for j in 0..L {
                    out[j] += weight * row[j];
                }
            }
        }
    }
}

/// How many of the frequencies (2k + 1)·step are below `low`.
#[inline(always)]
fn odd_below(low: usize, step: usize) -> usize {
    (low.div_ceil(step)) / 2
}

/// One level of the fold: `x[..2H]` → its odd coefficients in `coefs`, its sums in `x[..H]`.
#[inline(always)]
fn analyse_level<T: Real, const N: usize, const H: usize, const L: usize>(
    low: usize,
    odd: &mut &[T],
    x: &mut [[T; L]; N],
    coefs: &mut [[T; L]; N],
) {
    if H >= N {
        return;
    }
    let step = N / 2 / H;
    let (level, rest) = odd.split_at(H * H);
    *odd = rest;
    let mut difference = [[T::zero(); L]; H];
    for i in 0..H {
        for j in 0..L {
            let (a, b) = (x[i][j], x[2 * H - 1 - i][j]);
            x[i][j] = a + b;
            difference[i][j] = a - b;
        }
    }
    let (matrix, _) = level.as_chunks::<H>();
    for (k, weights) in matrix[..odd_below(low, step)].iter().enumerate() {
        sum_first(H, weights, &difference, &mut coefs[(2 * k + 1) * step]);
    }
}

/// L columns: samples `x` (destroyed) → the first `low` coefficients.
#[inline(always)]
fn analyse<T: Real, const N: usize, const L: usize>(
    tables: &Tables<T>,
    low: usize,
    x: &mut [[T; L]; N],
    coefs: &mut [[T; L]; N],
) {
    let odd = &mut &tables.odd[..];
    analyse_level::<T, N, 32, L>(low, odd, x, coefs);
    analyse_level::<T, N, 16, L>(low, odd, x, coefs);
    analyse_level::<T, N, 8, L>(low, odd, x, coefs);
    analyse_level::<T, N, 4, L>(low, odd, x, coefs);
    analyse_level::<T, N, 2, L>(low, odd, x, coefs);
    analyse_level::<T, N, 1, L>(low, odd, x, coefs);
    for j in 0..L {
        coefs[0][j] = tables.dc * x[0][j];
    }
}

/// The transpose of [`analyse_level`]; `odd` is cut from its end.
#[inline(always)]
fn synthesise_level<T: Real, const N: usize, const H: usize, const L: usize>(
    low: usize,
    odd: &mut &[T],
    coefs: &[[T; L]; N],
    x: &mut [[T; L]; N],
) {
    if H >= N {
        return;
    }
    let step = N / 2 / H;
    let (rest, level) = odd.split_at(odd.len() - H * H);
    *odd = rest;
    let count = odd_below(low, step);
    let (mut rows, mut difference) = ([[T::zero(); L]; H], [[T::zero(); L]; H]);
    if count > 0 {
        for k in 0..count {
            rows[k] = coefs[(2 * k + 1) * step];
        }
        // The matrix is symmetric.
        let (matrix, _) = level.as_chunks::<H>();
        for i in 0..H {
            sum_first(count, &matrix[i], &rows, &mut difference[i]);
        }
    }
    for i in 0..H {
        for j in 0..L {
            let (even, odd) = (x[i][j], difference[i][j]);
            x[i][j] = even + odd;
            x[2 * H - 1 - i][j] = even - odd;
        }
    }
}

/// L columns: the first `low` coefficients → samples `x`.
#[inline(always)]
fn synthesise<T: Real, const N: usize, const L: usize>(
    tables: &Tables<T>,
    low: usize,
    coefs: &[[T; L]; N],
    x: &mut [[T; L]; N],
) {
    for j in 0..L {
        x[0][j] = tables.dc * coefs[0][j];
    }
    let odd = &mut &tables.odd[..];
    synthesise_level::<T, N, 1, L>(low, odd, coefs, x);
    synthesise_level::<T, N, 2, L>(low, odd, coefs, x);
    synthesise_level::<T, N, 4, L>(low, odd, coefs, x);
    synthesise_level::<T, N, 8, L>(low, odd, coefs, x);
    synthesise_level::<T, N, 16, L>(low, odd, coefs, x);
    synthesise_level::<T, N, 32, L>(low, odd, coefs, x);
}

/// A matrix in columns of L: the first chunk of each row, the second of each, …
#[inline(always)]
fn columns<T, const N: usize, const L: usize>(matrix: &[T], first: usize) -> &[[T; L]; N] {
    let (rows, _) = matrix[first * N..].as_chunks::<L>();
    rows.first_chunk::<N>().expect("a matrix is N × N")
}

/// Samples of one block → `low`² coefficients. `L` divides N.
#[inline(always)]
pub(super) fn forward<T: Real, const N: usize, const L: usize>(
    pass: Pass<'_, T>,
    samples: &[T],
    coefs: &mut [T],
    work: &mut Work<T, N, L>,
) {
    let Pass { tables, low, stride } = pass;
    for first in (0..N).step_by(L) {
        if stride == N {
            let (rows, _) = samples.as_chunks::<N>();
            for (x, row) in work.x.iter_mut().zip(rows) {
                x.copy_from_slice(&row[first..first + L]);
            }
        } else {
            let rows = samples.chunks(stride);
            for (x, row) in work.x.iter_mut().zip(rows) {
                x.copy_from_slice(&row[first..first + L]);
            }
        }
        analyse(tables, low, &mut work.x, &mut work.coefs);
        for v in 0..low {
            work.rows[v][first..first + L].copy_from_slice(&work.coefs[v]);
        }
    }
    for first in (0..low).step_by(L) {
        let (matrix, count) = (columns::<T, N, L>(&tables.by_sample, first), L.min(low - first));
        for v in 0..low {
            let mut out = [T::zero(); L];
            sum_first(N, &work.rows[v], matrix, &mut out);
            coefs[v * low + first..][..count].copy_from_slice(&out[..count]);
        }
    }
}

/// `low`² coefficients → samples of one block. `L` divides N.
#[inline(always)]
pub(super) fn inverse<T: Real, const N: usize, const L: usize>(
    pass: Pass<'_, T>,
    coefs: &[T],
    samples: &mut [T],
    work: &mut Work<T, N, L>,
) {
    let Pass { tables, low, stride } = pass;
    let mut row = [T::zero(); N];
    for first in (0..N).step_by(L) {
        let matrix = columns::<T, N, L>(&tables.by_frequency, first);
        for v in 0..low {
            row[..low].copy_from_slice(&coefs[v * low..][..low]);
            sum_first(low, &row, matrix, &mut work.coefs[v]);
        }
        synthesise(tables, low, &work.coefs, &mut work.x);
        if stride == N {
            let (rows, _) = samples.as_chunks_mut::<N>();
            for (x, row) in work.x.iter().zip(rows) {
                row[first..first + L].copy_from_slice(x);
            }
        } else {
            let rows = samples.chunks_mut(stride);
            for (x, row) in work.x.iter().zip(rows) {
                row[first..first + L].copy_from_slice(x);
            }
        }
    }
}
