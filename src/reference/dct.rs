//! Twins of [`dct`](crate::dct): sums over basis functions written out from their definition, and a plain linear solve.

use crate::numeric::CompensatedSum;

/// √((2 − δ_u0)/n) cos((2x + 1)uπ/2n) at any real x.
pub fn basis(n: usize, u: usize, x: f64) -> f64 {
    let scale = if u == 0 { 1.0 } else { 2.0 };
    let n = n as f64;
    // Whole turns off first, while the number is exact: 200 radians would cost two digits.
    let quarters = ((2.0 * x + 1.0) * u as f64) % (4.0 * n);
    (scale / n).sqrt() * (quarters * std::f64::consts::PI / (2.0 * n)).cos()
}

/// The coefficients C\[v\]\[u\] with u, v < `low` of a square block.
pub fn forward(low: usize, block: &[f64]) -> Vec<f64> {
    let n = block.len().isqrt();
    let coef = |v, u| {
        let terms = (0..n * n).map(|i| block[i] * basis(n, v, (i / n) as f64) * basis(n, u, (i % n) as f64));
        terms.collect::<CompensatedSum>().total()
    };
    (0..low * low).map(|i| coef(i / low, i % low)).collect()
}

/// The block of side `n` that has the square of coefficients `coefs`, and 0 beyond.
pub fn inverse(n: usize, coefs: &[f64]) -> Vec<f64> {
    let low = coefs.len().isqrt();
    let sample = |y: usize, x: usize| {
        let terms = (0..low * low).map(|i| coefs[i] * basis(n, i / low, y as f64) * basis(n, i % low, x as f64));
        terms.collect::<CompensatedSum>().total()
    };
    (0..n * n).map(|i| sample(i / n, i % n)).collect()
}

/// The coefficients of a function of these l × l `samples` and no higher frequencies: the l² equations of eq. 4 of
/// [Inger 2013] by Gaussian elimination. NaN where they are singular.
pub fn project(n: usize, positions: &[f64], samples: &[f64]) -> Vec<f64> {
    let low = positions.len();
    let size = low * low;
    let mut rows: Vec<Vec<f64>> = (0..size)
        .map(|s| {
            let (y, x) = (positions[s / low], positions[s % low]);
            let equation = (0..size).map(|c| basis(n, c / low, y) * basis(n, c % low, x));
            equation.chain([samples[s]]).collect()
        })
        .collect();
    for column in 0..size {
        let pivot = (column..size).max_by(|&a, &b| rows[a][column].abs().total_cmp(&rows[b][column].abs())).unwrap();
        rows.swap(column, pivot);
        let pivot = rows[column].clone();
        for (i, row) in rows.iter_mut().enumerate() {
            if i != column {
                let factor = row[column] / pivot[column];
                row.iter_mut().zip(&pivot).for_each(|(x, p)| *x -= factor * p);
            }
        }
    }
    (0..size).map(|c| rows[c][size] / rows[c][c]).collect()
}
