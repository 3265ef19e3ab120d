//! Principal components from the covariance matrix, its eigenvectors by Jacobi's rotations.

/// Mean (or zeros), and all components with their variances, descending: as many as there are columns.
#[derive(Debug, Clone, PartialEq)]
pub struct NaivePca {
    /// What components pass through.
    pub mean: Vec<f64>,
    /// Orthonormal, the entry of largest magnitude (the first of equals) positive.
    pub components: Vec<Vec<f64>>,
    /// Mean squared weights.
    pub variances: Vec<f64>,
}

impl NaivePca {
    /// Of the rows' deviations from `mean`, from their mean if `None`. At least one row.
    pub fn new(rows: &[Vec<f64>], mean: Option<&[f64]>) -> Self {
        let (n, columns) = (rows.len() as f64, rows[0].len());
        let mean = match mean {
            Some(mean) => mean.to_vec(),
            None => (0..columns).map(|c| rows.iter().map(|row| row[c]).sum::<f64>() / n).collect(),
        };
        let product = |i: usize, j: usize| rows.iter().map(|x| (x[i] - mean[i]) * (x[j] - mean[j])).sum::<f64>() / n;
        let covariance = (0..columns).map(|i| (0..columns).map(|j| product(i, j)).collect()).collect();
        let mut pairs = symmetric_eigen(covariance);
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (variances, mut components): (Vec<f64>, Vec<Vec<f64>>) = pairs.into_iter().unzip();
        for component in &mut components {
            let largest = component.iter().fold(0.0f64, |m, &x| if x.abs() > m.abs() { x } else { m });
            component.iter_mut().for_each(|x| *x *= largest.signum());
        }
        Self { mean, components, variances }
    }

    /// w_j = u_j·(x − m) of the first `count` components.
    pub fn project(&self, row: &[f64], count: usize) -> Vec<f64> {
        let weight = |u: &Vec<f64>| row.iter().zip(&self.mean).zip(u).map(|((x, m), u)| (x - m) * u).sum();
        self.components.iter().take(count).map(weight).collect()
    }

    /// m + Σ w_j u_j.
    pub fn reconstruct(&self, weights: &[f64]) -> Vec<f64> {
        let entry = |c: usize| self.mean[c] + weights.iter().zip(&self.components).map(|(w, u)| w * u[c]).sum::<f64>();
        (0..self.mean.len()).map(entry).collect()
    }

    /// |x − x'|² with the first `count` components, each difference squared and added.
    pub fn squared_distance(&self, row: &[f64], count: usize) -> f64 {
        let back = self.reconstruct(&self.project(row, count));
        row.iter().zip(&back).map(|(x, y)| (x - y) * (x - y)).sum()
    }
}

/// Eigenvalues with their eigenvectors, in no order: the largest element off the diagonal is rotated away until none is
/// left [Jacobi 1846].
pub fn symmetric_eigen(mut a: Vec<Vec<f64>>) -> Vec<(f64, Vec<f64>)> {
    let n = a.len();
    let mut vectors: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| f64::from(i == j)).collect()).collect();
    let size = a.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    for _ in 0..100 * n * n {
        let pairs = (0..n).flat_map(|p| (p + 1..n).map(move |q| (p, q)));
        let Some((p, q)) = pairs.max_by(|&(i, j), &(k, l)| a[i][j].abs().total_cmp(&a[k][l].abs())) else { break };
        if a[p][q].abs() <= 1e-18 * size {
            break;
        }
        let angle = 0.5 * (2.0 * a[p][q]).atan2(a[p][p] - a[q][q]);
        let (sin, cos) = angle.sin_cos();
        for k in 0..n {
            (a[k][p], a[k][q]) = (cos * a[k][p] + sin * a[k][q], cos * a[k][q] - sin * a[k][p]);
        }
        for k in 0..n {
            (a[p][k], a[q][k]) = (cos * a[p][k] + sin * a[q][k], cos * a[q][k] - sin * a[p][k]);
            (vectors[p][k], vectors[q][k]) =
                (cos * vectors[p][k] + sin * vectors[q][k], cos * vectors[q][k] - sin * vectors[p][k]);
        }
        (a[p][q], a[q][p]) = (0.0, 0.0);
    }
    vectors.into_iter().enumerate().map(|(i, v)| (a[i][i], v)).collect()
}
