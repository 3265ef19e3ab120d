//! Eigenvalues and eigenvectors of a symmetric matrix.

use nalgebra::{DMatrix, SymmetricEigen};

/// Eigenvalues, descending, and orthonormal eigenvectors, one a row.
#[derive(Debug, Clone)]
pub(in super::super) struct Eigen {
    pub values: Vec<f64>,
    pub vectors: Vec<f64>,
}

/// Sides up to which Jacobi's rotations are taken: there they cost little and cannot fail.
const SMALL: usize = 64;

/// The decomposition of the symmetric matrix whose lower triangle is `lower` (row-major, n × n; the rest is not read).
///
/// Beyond [`SMALL`] by nalgebra, with bounded iterations and the result checked; what fails the check is done by
/// rotations.
pub(in super::super) fn symmetric_eigen(lower: &[f64], n: usize) -> Eigen {
    let mut matrix = lower.to_vec();
    for i in 0..n {
        (0..i).for_each(|j| matrix[j * n + i] = matrix[i * n + j]);
    }
    let (values, vectors) = match if n > SMALL { tridiagonal(&matrix, n) } else { None } {
        Some(found) => found,
        None => jacobi(matrix, n),
    };
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| values[j].total_cmp(&values[i]));
    Eigen {
        values: order.iter().map(|&i| values[i]).collect(),
        vectors: order.iter().flat_map(|&i| &vectors[i * n..][..n]).copied().collect(),
    }
}

/// nalgebra's, `None` unless it ended and V Λ Vᵀ is the matrix, V Vᵀ the identity, on a vector without structure.
fn tridiagonal(matrix: &[f64], n: usize) -> Option<(Vec<f64>, Vec<f64>)> {
    // QR takes about two steps an eigenvalue.
    let found = SymmetricEigen::try_new(DMatrix::from_row_slice(n, n, matrix), f64::EPSILON, 40 * n)?;
    // Columns of a column-major matrix: eigenvectors one after the other.
    let (values, vectors) = (found.eigenvalues.as_slice().to_vec(), found.eigenvectors.as_slice().to_vec());
    let x: Vec<f64> = (0..n).map(|i| ((i as f64 + 0.5) * 0.618_033_988_749_895).fract() - 0.5).collect();
    let shares: Vec<f64> = vectors.chunks_exact(n).map(|v| super::dot(v, &x)).collect();
    let scaled: Vec<f64> = shares.iter().zip(&values).map(|(share, value)| share * value).collect();
    let (same, image) = (super::combine(&shares, &vectors, n), super::combine(&scaled, &vectors, n));
    let largest = values.iter().fold(0.0f64, |max, v| max.max(v.abs()));
    let tolerance = 1e-13 * n as f64;
    let right = |i: usize| {
        let product = super::dot(&matrix[i * n..][..n], &x);
        (same[i] - x[i]).abs() <= tolerance && (image[i] - product).abs() <= tolerance * largest
    };
    (0..n).all(right).then_some((values, vectors))
}

/// Cyclic Jacobi rotations [Golub & Van Loan §8.5]: each annihilates one element, and the sum of the squares off the
/// diagonal falls, in the end quadratically.
fn jacobi(mut a: Vec<f64>, n: usize) -> (Vec<f64>, Vec<f64>) {
    /// Six to ten are usual.
    const SWEEPS: usize = 60;
    let mut vectors = vec![0.0; n * n];
    (0..n).for_each(|i| vectors[i * n + i] = 1.0);
    let norm = a.iter().map(|x| x * x).sum::<f64>().sqrt();
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..n {
            for q in p + 1..n {
                let off = a[p * n + q];
                // What is left out moves an eigenvalue by less than ε of the largest.
                if off.abs() > 1e-2 * f64::EPSILON * norm / n as f64 {
                    rotate(&mut a, &mut vectors, n, (p, q));
                    rotated = true;
                }
            }
        }
        if !rotated {
            break;
        }
    }
    ((0..n).map(|i| a[i * n + i]).collect(), vectors)
}

/// The rotation of axes p and q after which a_pq is 0.
fn rotate(a: &mut [f64], vectors: &mut [f64], n: usize, (p, q): (usize, usize)) {
    let off = a[p * n + q];
    let cot = (a[q * n + q] - a[p * n + p]) / (2.0 * off); // of twice the angle
    let tan = cot.signum() / (cot.abs() + cot.hypot(1.0)); // the smaller of both angles
    let cos = 1.0 / tan.hypot(1.0);
    let sin = tan * cos;
    for k in 0..n {
        let (x, y) = (a[k * n + p], a[k * n + q]);
        (a[k * n + p], a[k * n + q]) = (cos * x - sin * y, sin * x + cos * y);
    }
    let turn = |rows: &mut [f64]| {
        let (head, tail) = rows.split_at_mut(q * n);
        for (x, y) in head[p * n..][..n].iter_mut().zip(&mut tail[..n]) {
            (*x, *y) = (cos * *x - sin * *y, sin * *x + cos * *y);
        }
    };
    turn(a);
    turn(vectors);
    (a[p * n + q], a[q * n + p]) = (0.0, 0.0);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(n: usize) -> Vec<f64> {
        let entry = |i: usize, j: usize| {
            (((i.max(j) * 31 + i.min(j)) as f64 + 0.3) * 0.618_033_988_749_895).fract() - 0.5
                + f64::from(i == j) * i as f64
        };
        (0..n * n).map(|at| entry(at / n, at % n)).collect()
    }

    /// On both sides of the change of methods, and both methods on the same.
    #[test]
    fn vectors_are_orthonormal_and_diagonalise() {
        for n in [0, 1, 2, 3, 17, SMALL, SMALL + 1, 100] {
            let a = matrix(n);
            let found = symmetric_eigen(&a, n);
            assert!(found.values.is_sorted_by(|a, b| a >= b));
            let rows = |i: usize| &found.vectors[i * n..][..n];
            for i in 0..n {
                for j in 0..n {
                    let product = super::super::dot(rows(i), rows(j));
                    assert!((product - f64::from(i == j)).abs() < 1e-13, "n {n}: v{i} v{j} = {product}");
                    let image: f64 = (0..n).map(|k| a[j * n + k] * rows(i)[k]).sum();
                    assert!((image - found.values[i] * rows(i)[j]).abs() < 1e-13 * (n as f64 + 1.0), "n {n}, {i}");
                }
            }
            let (mut slow, _) = jacobi(a, n);
            slow.sort_by(|a, b| b.total_cmp(a));
            for (a, b) in found.values.iter().zip(&slow) {
                assert!((a - b).abs() < 1e-13 * (n as f64 + 1.0), "n {n}: {a} {b}");
            }
        }
    }

    #[test]
    fn multiple_and_zero_eigenvalues() {
        let found = symmetric_eigen(&[0.0; 9], 3);
        assert_eq!(found.values, [0.0; 3]);
        assert_eq!(found.vectors, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        // All ones, beyond SMALL: one eigenvalue n, the others 0.
        let found = symmetric_eigen(&[1.0; 80 * 80], 80);
        assert!((found.values[0] - 80.0).abs() < 1e-12 && found.values[1..].iter().all(|v| v.abs() < 1e-12));
    }
}
