//! Gauss–Legendre quadrature on an interval.

use crate::{Error, Result};

/// The `n`-point Gauss–Legendre rule on [−1, 1]: exact for polynomials up to degree 2n − 1.
///
/// ```math
/// ∫ f ≈ Σ w_i f(x_i),  P_n(x_i) = 0,  w_i = 2 / ((1 − x_i²) P_n′(x_i)²)      [Abramowitz & Stegun 25.4.29]
/// ```
///
/// Accuracy: published digits to 1e-15 (n = 5, 96); the weights sum to 2 within 1e-13 up to n = 512. Cost: n²
/// multiplications to build.
#[derive(Debug, Clone, PartialEq)]
pub struct GaussLegendre {
    nodes: Vec<f64>,
    weights: Vec<f64>,
}

impl GaussLegendre {
    /// The most points that are allowed.
    pub const MAX_POINTS: usize = 1 << 14;

    /// The rule of `n` points.
    ///
    /// Newton iteration on P_n from Tricomi's first guess, with the three-term recurrence for P_n and its derivative.
    ///
    /// # Errors
    /// [`Error::Empty`] for `n` = 0; [`Error::OutOfRange`] above [`MAX_POINTS`](Self::MAX_POINTS).
    pub fn new(n: usize) -> Result<Self> {
        if n == 0 {
            return Err(Error::Empty { what: "Gauss–Legendre rule" });
        }
        if n > Self::MAX_POINTS {
            let allowed = "at most 16384";
            return Err(Error::OutOfRange { what: "points of a Gauss–Legendre rule", got: n as f64, allowed });
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

    /// ∫ f over [a, b].
    ///
    /// # Example
    /// ```
    /// let rule = haarmonic::numeric::GaussLegendre::new(3)?;
    /// assert!((rule.integrate(0.0, 2.0, |x| x.powi(5)) - 64.0 / 6.0).abs() < 1e-13);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn integrate(&self, a: f64, b: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
        // Halved before they are added, or the largest numbers would overflow.
        let (middle, half) = (0.5 * a + 0.5 * b, 0.5 * b - 0.5 * a);
        half * self.nodes.iter().zip(&self.weights).map(|(x, w)| w * f(middle + half * x)).sum::<f64>()
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
    fn nodes_and_weights_match_published_digits() {
        // Abramowitz & Stegun, table 25.4: n = 5 and the largest node of n = 96.
        let five = GaussLegendre::new(5).unwrap();
        assert!((five.nodes()[4] - 0.906_179_845_938_664).abs() < 1e-15);
        assert!((five.weights()[4] - 0.236_926_885_056_189).abs() < 1e-15);
        let many = GaussLegendre::new(96).unwrap();
        assert!((many.nodes()[95] - 0.999_689_503_883_230).abs() < 1e-15);
        assert!((many.weights()[95] - 0.000_796_792_065_552).abs() < 1e-15);
    }

    #[test]
    fn large_rules_are_symmetric_and_sum_to_two() {
        for n in [1, 2, 129, 512] {
            let rule = GaussLegendre::new(n).unwrap();
            assert!((rule.weights().iter().sum::<f64>() - 2.0).abs() < 1e-13, "n {n}");
            assert!(rule.nodes().windows(2).all(|p| p[0] < p[1]));
            assert!((0..n).all(|i| rule.nodes()[i] == -rule.nodes()[n - 1 - i]));
        }
    }

    #[test]
    fn no_points_and_too_many_are_errors() {
        assert!(GaussLegendre::new(0).is_err());
        for n in [GaussLegendre::MAX_POINTS + 1, usize::MAX] {
            assert!(matches!(GaussLegendre::new(n), Err(Error::OutOfRange { .. })));
        }
    }
}
