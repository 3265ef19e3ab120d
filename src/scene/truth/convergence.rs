//! Samples doubled until nothing moves.

use nalgebra::Vector3;

use crate::scene::rel_l2;
use crate::{Error, Result};

/// A result for finer and finer samples, and how far it moved from each to the next.
///
/// It prints itself as a table.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Vector3, scene::Convergence};
/// // The midpoint rule for ∫ x² dx.
/// let midpoint = |n: usize| (0..n).map(|i| ((i as f64 + 0.5) / n as f64).powi(2)).sum::<f64>() / n as f64;
/// let found = Convergence::by_doubling(2, 1024, 1e-4, |n| Ok(vec![Vector3::repeat(midpoint(n))]))?;
/// assert!(found.is_reached && (found.values[0].x - 1.0 / 3.0).abs() < 1e-4);
/// println!("{found}");
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Convergence {
    /// The result for the most samples.
    pub values: Vec<Vector3<f64>>,
    /// Samples, and the relative L2 distance of their result from that of half as many.
    pub steps: Vec<(usize, f64)>,
    /// Whether the last distance is below the tolerance.
    pub is_reached: bool,
}

impl Convergence {
    /// f(n), f(2n), f(4n), … until two results differ by less than `tolerance`, relative L2, or the samples would be
    /// more than `most`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 1 ≤ `first` ≤ `most` / 2 and the tolerance is not negative; those of `f`.
    pub fn by_doubling(
        first: usize,
        most: usize,
        tolerance: f64,
        mut f: impl FnMut(usize) -> Result<Vec<Vector3<f64>>>,
    ) -> Result<Self> {
        if first == 0 || first > most / 2 {
            let what = "first number of samples";
            return Err(Error::OutOfRange { what, got: first as f64, allowed: "from 1 to half of the most" });
        }
        if !(tolerance >= 0.0) {
            return Err(Error::OutOfRange { what: "tolerance", got: tolerance, allowed: "not negative" });
        }
        let (mut samples, mut values) = (first, f(first)?);
        let (mut steps, mut is_reached) = (vec![], false);
        while !is_reached && samples <= most / 2 {
            samples *= 2;
            let next = f(samples)?;
            let distance = rel_l2(&next, &values)?;
            steps.push((samples, distance));
            is_reached = distance <= tolerance;
            values = next;
        }
        Ok(Self { values, steps, is_reached })
    }
}

impl std::fmt::Display for Convergence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "{:>8}  {:>9}", "samples", "change")?;
        self.steps.iter().try_for_each(|(samples, distance)| writeln!(f, "{samples:>8}  {distance:>9.2e}"))
    }
}
