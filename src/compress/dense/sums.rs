//! Vectors of `f64` that are rows of small matrices: dot products, orthonormal bases, signs.

use pulp::{Arch, Simd, WithSimd};

use crate::Real;

/// Σ a b in eight interleaved sums, folded in one order: the same bits on every machine.
#[inline(always)]
pub(in super::super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    dot_wide(a, b)
}

/// [`dot`] of which one factor is widened.
#[inline(always)]
pub(in super::super) fn dot_wide<T: Real>(a: &[f64], b: &[T]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let ((a, a_last), (b, b_last)) = (a.as_chunks::<2>(), b.as_chunks::<2>());
    let mut sums = [[0.0; 4]; 2];
    for (a, b) in a.iter().zip(b) {
        for v in 0..2 {
            (0..4).for_each(|l| sums[v][l] += a[v][l] * b[v][l].widen());
        }
    }
    let mut rest = 0.0;
    for (a, b) in a_last.iter().zip(b_last) {
        (0..4).for_each(|l| rest += a[l] * b[l].widen());
    }
    a_rest.iter().zip(b_rest).for_each(|(a, b)| rest += a * b.widen());
    (0..4).map(|l| sums[0][l] + sums[1][l]).fold(rest, |sum, x| sum + x)
}

/// A row that loses all but this share of its length to the rows before it depends on them.
const DEPENDENT: f64 = 1e-12;

/// Makes the rows orthonormal, each against those before it, and drops those that depend on them; returns how many are
/// left.
///
/// Gram–Schmidt, repeated for a row until a pass takes away less than half of it: "twice is enough" (Kahan, Parlett),
/// so the rows are orthogonal to a few ε whatever they were.
pub(in super::super) fn orthonormalise(rows: &mut Vec<f64>, columns: usize) -> usize {
    let kept = if columns == 0 { 0 } else { Arch::new().dispatch(Orthonormalise { rows, columns }) };
    rows.truncate(kept * columns);
    kept
}

struct Orthonormalise<'a> {
    rows: &'a mut [f64],
    columns: usize,
}

impl WithSimd for Orthonormalise<'_> {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        let Self { rows, columns } = self;
        let mut kept = 0;
        for i in 0..rows.len() / columns {
            rows.copy_within(i * columns..(i + 1) * columns, kept * columns);
            let (basis, row) = rows.split_at_mut(kept * columns);
            let row = &mut row[..columns];
            let length = dot(row, row).sqrt();
            let mut left = length;
            loop {
                let before = left;
                for b in basis.chunks_exact(columns) {
                    let share = dot(b, row);
                    row.iter_mut().zip(b).for_each(|(x, &b)| *x -= share * b);
                }
                left = dot(row, row).sqrt();
                // The first condition fails for NaN and zero, too.
                if !(left > DEPENDENT * length) || left > 0.5 * before {
                    break;
                }
            }
            if left > DEPENDENT * length {
                row.iter_mut().for_each(|x| *x /= left);
                kept += 1;
            }
        }
        kept
    }
}

/// U B: each row of `u` (`n` numbers) says how to add up the `n` rows of `b`.
pub(in super::super) fn combine(u: &[f64], b: &[f64], n: usize) -> Vec<f64> {
    if n == 0 {
        return Vec::new();
    }
    let columns = b.len() / n;
    let mut out = vec![0.0; u.len() / n * columns];
    if columns > 0 {
        Arch::new().dispatch(|| {
            for (u, out) in u.chunks_exact(n).zip(out.chunks_exact_mut(columns)) {
                for (&u, b) in u.iter().zip(b.chunks_exact(columns)) {
                    out.iter_mut().zip(b).for_each(|(out, &b)| *out += u * b);
                }
            }
        });
    }
    out
}

/// Makes the entry of largest magnitude (the first of equals) positive.
pub(in super::super) fn largest_positive(row: &mut [f64]) {
    let mut largest = 0.0f64;
    for &x in &*row {
        if x.abs() > largest.abs() {
            largest = x;
        }
    }
    if largest < 0.0 {
        row.iter_mut().for_each(|x| *x = -*x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(len: usize) -> Vec<f64> {
        (0..len).map(|i| ((i as f64 + 0.7) * 0.618_033_988_749_895).fract() - 0.4).collect()
    }

    #[test]
    fn dot_products_of_any_length() {
        for len in 0..40 {
            let (a, b) = (numbers(len), numbers(2 * len)[len..].to_vec());
            let want: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
            assert!((dot(&a, &b) - want).abs() <= 4e-15, "{len}");
        }
    }

    #[test]
    fn dependent_rows_are_dropped_and_nearly_dependent_ones_made_orthogonal() {
        let columns = 37;
        let mut rows = numbers(3 * columns);
        let sum: Vec<f64> = (0..columns).map(|c| rows[c] + rows[columns + c] * 3.0).collect();
        let near: Vec<f64> = (0..columns).map(|c| rows[c] + 1e-9 * (c as f64).sin()).collect();
        rows.extend(sum);
        rows.extend(vec![0.0; columns]);
        rows.extend(near);
        assert_eq!(orthonormalise(&mut rows, columns), 4);
        for i in 0..4 {
            for j in 0..4 {
                let product = dot(&rows[i * columns..][..columns], &rows[j * columns..][..columns]);
                assert!((product - f64::from(i == j)).abs() < 1e-15 * 4.0, "{i} {j}: {product}");
            }
        }
    }
}
