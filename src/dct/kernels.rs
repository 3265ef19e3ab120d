//! The passes over one block. Everything here is `#[inline(always)]`, so that it is compiled for the vector unit of the
//! caller, which `pulp` picks once for a batch, and for the constant sides of the dispatch.
//!
//! Derivation. c_u(n−1−x) = (−1)^u c_u(x), so with s[x] = f[x] + f[n−1−x] and d[x] = f[x] − f[n−1−x], x < n/2, the odd
//! coefficients need only d and the even ones only s, which is the same problem at n/2: n = 16 costs 8² + 4² + 2² + 1² + 1
//! multiplications a line instead of 16². That is done down the columns, a register of columns at a time. Along the rows,
//! whose samples lie in one register, a sample is broadcast and multiplies a row of the matrix; there one fold suffices.
//! Inverse: the transpose, in the opposite order. The first `low` frequencies alone: the same with the other rows left out.

use super::tables::Tables;
use crate::Real;

/// Columns, or outputs of a row, that are worked on at a time, and rows that share a broadcast matrix.
const ROWS: usize = 4;

/// What a pass needs beside its data.
#[derive(Clone, Copy)]
pub(super) struct Pass<'a, T> {
    pub tables: &'a Tables<T>,
    /// Frequencies kept on each axis.
    pub low: usize,
    /// Distance of the rows of the samples.
    pub stride: usize,
}

/// One level of the fold: `x[..2H]` → its odd coefficients in `out`, its sums in `x[..H]`.
#[inline(always)]
fn analyse_level<T: Real, const N: usize, const H: usize, const L: usize>(
    low: usize,
    odd: &mut &[T],
    x: &mut [[T; L]; N],
    out: &mut [[T; L]; N],
) {
    if H >= N {
        return;
    }
    let step = N / 2 / H;
    let (level, rest) = odd.split_at(H * H);
    *odd = rest;
    let mut difference = [[T::zero(); L]; H];
    for i in 0..H {
        let (a, b) = (x[i], x[2 * H - 1 - i]);
        for j in 0..L {
            x[i][j] = a[j] + b[j];
            difference[i][j] = a[j] - b[j];
        }
    }
    let (matrix, _) = level.as_chunks::<H>();
    for k in 0..H {
        if (2 * k + 1) * step >= low {
            break;
        }
        let mut sum = [T::zero(); L];
        for i in 0..H {
            for j in 0..L {
                sum[j] += matrix[k][i] * difference[i][j];
            }
        }
        out[(2 * k + 1) * step] = sum;
    }
}

/// L columns: samples `x` (destroyed) → the first `low` coefficients `out`.
#[inline(always)]
fn analyse<T: Real, const N: usize, const L: usize>(
    tables: &Tables<T>,
    low: usize,
    x: &mut [[T; L]; N],
    out: &mut [[T; L]; N],
) {
    let odd = &mut &tables.odd[..];
    analyse_level::<T, N, 32, L>(low, odd, x, out);
    analyse_level::<T, N, 16, L>(low, odd, x, out);
    analyse_level::<T, N, 8, L>(low, odd, x, out);
    analyse_level::<T, N, 4, L>(low, odd, x, out);
    analyse_level::<T, N, 2, L>(low, odd, x, out);
    analyse_level::<T, N, 1, L>(low, odd, x, out);
    for j in 0..L {
        out[0][j] = tables.dc * x[0][j];
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
    let (matrix, _) = level.as_chunks::<H>();
    let mut difference = [[T::zero(); L]; H];
    for i in 0..H {
        let mut sum = [T::zero(); L];
        for k in 0..H {
            if (2 * k + 1) * step >= low {
                break;
            }
            for j in 0..L {
                sum[j] += matrix[k][i] * coefs[(2 * k + 1) * step][j];
            }
        }
        difference[i] = sum;
    }
    for i in 0..H {
        let (even, odd) = (x[i], difference[i]);
        for j in 0..L {
            x[i][j] = even[j] + odd[j];
            x[2 * H - 1 - i][j] = even[j] - odd[j];
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

/// Samples of one block → `low`² coefficients. `L` divides N.
#[inline(always)]
pub(super) fn forward<T: Real, const N: usize, const H: usize, const L: usize>(
    pass: Pass<'_, T>,
    samples: &[T],
    coefs: &mut [T],
    work: &mut [[T; N]; N],
) {
    let Pass { tables, low, stride } = pass;
    for first in (0..N).step_by(L) {
        let (mut x, mut out) = ([[T::zero(); L]; N], [[T::zero(); L]; N]);
        for y in 0..N {
            x[y].copy_from_slice(&samples[y * stride + first..][..L]);
        }
        analyse(tables, low, &mut x, &mut out);
        for v in 0..low {
            work[v][first..first + L].copy_from_slice(&out[v]);
        }
    }
    if low == N {
        rows_forward_all::<T, N, H>(tables, work, coefs);
    } else {
        rows_forward_low::<T, N>(tables, low, work, coefs);
    }
}

/// All coefficients of the rows of `work`: even and odd ones from the sums and differences of mirrored samples.
#[inline(always)]
fn rows_forward_all<T: Real, const N: usize, const H: usize>(tables: &Tables<T>, work: &[[T; N]; N], coefs: &mut [T]) {
    let (even, _) = tables.even.as_chunks::<H>();
    let (odd, _) = tables.odd[..H * H].as_chunks::<H>();
    let (work, _) = work.as_chunks::<ROWS>();
    let (coefs, _) = coefs.as_chunks_mut::<N>();
    let (coefs, _) = coefs.as_chunks_mut::<ROWS>();
    for (rows, out) in work.iter().zip(coefs) {
        let (mut sum, mut difference) = ([[T::zero(); H]; ROWS], [[T::zero(); H]; ROWS]);
        for r in 0..ROWS {
            for i in 0..H {
                let (a, b) = (rows[r][i], rows[r][N - 1 - i]);
                (sum[r][i], difference[r][i]) = (a + b, a - b);
            }
        }
        let sum = times_matrix(&sum, even);
        let difference = times_matrix(&difference, odd);
        for r in 0..ROWS {
            for k in 0..H {
                out[r][2 * k] = sum[r][k];
                out[r][2 * k + 1] = difference[r][k];
            }
        }
    }
}

/// `x` times the matrix, whose rows belong to the elements of `x`.
#[inline(always)]
fn times_matrix<T: Real, const H: usize>(x: &[[T; H]; ROWS], matrix: &[[T; H]]) -> [[T; H]; ROWS] {
    let mut out = [[T::zero(); H]; ROWS];
    for i in 0..H {
        for r in 0..ROWS {
            for k in 0..H {
                out[r][k] += x[r][i] * matrix[i][k];
            }
        }
    }
    out
}

/// The first `low` coefficients of the first `low` rows of `work`, four at a time.
#[inline(always)]
fn rows_forward_low<T: Real, const N: usize>(tables: &Tables<T>, low: usize, work: &[[T; N]; N], coefs: &mut [T]) {
    let (matrix, _) = tables.by_sample.as_chunks::<N>();
    for u in (0..low).step_by(ROWS) {
        let count = ROWS.min(low - u);
        for v in 0..low {
            let mut sum = [T::zero(); ROWS];
            for x in 0..N {
                for j in 0..ROWS {
                    sum[j] += work[v][x] * matrix[x][u + j];
                }
            }
            coefs[v * low + u..][..count].copy_from_slice(&sum[..count]);
        }
    }
}

/// `low`² coefficients → samples of one block. `L` divides N.
#[inline(always)]
pub(super) fn inverse<T: Real, const N: usize, const H: usize, const L: usize>(
    pass: Pass<'_, T>,
    coefs: &[T],
    samples: &mut [T],
    work: &mut [[T; N]; N],
) {
    let Pass { tables, low, stride } = pass;
    let (matrix, _) = tables.by_frequency.as_chunks::<N>();
    for v in 0..low {
        let row = &coefs[v * low..][..low];
        let (mut even, mut odd) = ([T::zero(); H], [T::zero(); H]);
        for u in 0..low {
            let sum = if u % 2 == 0 { &mut even } else { &mut odd };
            for x in 0..H {
                sum[x] += row[u] * matrix[u][x];
            }
        }
        for x in 0..H {
            work[v][x] = even[x] + odd[x];
            work[v][N - 1 - x] = even[x] - odd[x];
        }
    }
    for first in (0..N).step_by(L) {
        let (mut x, mut out) = ([[T::zero(); L]; N], [[T::zero(); L]; N]);
        for v in 0..low {
            x[v].copy_from_slice(&work[v][first..first + L]);
        }
        synthesise(tables, low, &x, &mut out);
        for y in 0..N {
            samples[y * stride + first..][..L].copy_from_slice(&out[y]);
        }
    }
}
