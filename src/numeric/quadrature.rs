//! Gauss–Legendre quadrature on an interval.

use crate::{Error, Result};

/// The `n`-point Gauss–Legendre rule on [−1, 1]: exact for polynomials up to degree 2n − 1.
#[derive(Debug, Clone, PartialEq)]
pub struct GaussLegendre {
    nodes: Vec<f64>,
    weights: Vec<f64>,
}

impl GaussLegendre {
    /// The rule of `n` points.
    ///
    /// Newton iteration on P_n from Tricomi's first guess, with the three-term recurrence for P_n and its derivative.
    ///
    /// # Errors
    /// [`Error::Empty`] for `n` = 0.
    pub fn new(n: usize) -> Result<Self> {
        if n == 0 {
            return Err(Error::Empty { what: "Gauss–Legendre rule" });
        }
        let mut nodes = vec![0.0; n];
        let mut weights = vec![0.0; n];
        let order = n as f64;
        for i in 0..n.div_ceil(2) {
            let theta = std::f64::consts::PI * (i as f64 + 0.75) / (order + 0.5);
            let mut x = theta.cos() * (1.0 - (1.0 - 1.0 / order) / (8.0 * order * order));
            let mut slope = 1.0;
            for _ in 0..16 {
                let (value, derivative) = legendre(n, x);
                slope = derivative;
                let step = value / derivative;
                x -= step;
                if step.abs() <= 2.0 * f64::EPSILON * x.abs().max(0.1) {
                    slope = legendre(n, x).1;
                    break;
                }
            }
            if 2 * i + 1 == n {
                x = 0.0;
                slope = legendre(n, x).1;
            }
            let weight = 2.0 / ((1.0 - x * x) * slope * slope);
            nodes[i] = -x;
            nodes[n - 1 - i] = x;
            weights[i] = weight;
            weights[n - 1 - i] = weight;
        }
        Ok(Self { nodes, weights })
    }

    /// The nodes, ascending in (−1, 1).
    pub fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// The weights; they sum to 2.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }
}

/// P_n(x) and its derivative, |x| < 1.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut current) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        (before, current) = (current, ((2.0 * k - 1.0) * x * current - (k - 1.0) * before) / k);
    }
    (current, n as f64 * (x * current - before) / (x * x - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrates_every_monomial_up_to_its_degree() {
        for n in [1, 2, 3, 5, 16, 33, 64] {
            let rule = GaussLegendre::new(n).unwrap();
            for degree in 0..2 * n {
                let sum: f64 = rule.nodes().iter().zip(rule.weights()).map(|(x, w)| w * x.powi(degree as i32)).sum();
                let exact = if degree % 2 == 0 { 2.0 / (degree as f64 + 1.0) } else { 0.0 };
                assert!((sum - exact).abs() < 1e-13, "n {n}, degree {degree}: {sum} against {exact}");
            }
        }
    }

    #[test]
    fn no_points_is_an_error() {
        assert!(GaussLegendre::new(0).is_err());
    }
}
