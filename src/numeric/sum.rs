//! Sums that keep what each addition rounds away.

/// A running sum with Neumaier's correction: the error is 2 eps·|Σx| + O(n eps²)·Σ|x|, whatever the order.
///
/// For long reductions whose terms cancel or span many magnitudes (a sun beside a night sky). An infinite or NaN term
/// makes the total NaN or infinite.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CompensatedSum {
    sum: f64,
    lost: f64,
}

impl CompensatedSum {
    /// Adds a term.
    #[inline(always)]
    pub fn add(&mut self, x: f64) {
        let total = self.sum + x;
        self.lost += if self.sum.abs() >= x.abs() { (self.sum - total) + x } else { (x - total) + self.sum };
        self.sum = total;
    }

    /// The sum so far.
    #[inline]
    pub fn total(self) -> f64 {
        if self.sum.is_finite() { self.sum + self.lost } else { self.sum }
    }
}

impl FromIterator<f64> for CompensatedSum {
    fn from_iter<I: IntoIterator<Item = f64>>(terms: I) -> Self {
        let mut sum = Self::default();
        terms.into_iter().for_each(|x| sum.add(x));
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cancels_leaves_the_rest_exact() {
        let sum: CompensatedSum = [1.0, 1e100, 1.0, -1e100].into_iter().collect();
        assert_eq!(sum.total(), 2.0);
        assert_eq!(CompensatedSum::default().total(), 0.0);
    }

    #[test]
    fn a_long_sum_of_one_tenth_is_right_to_the_last_bit() {
        let sum: CompensatedSum = std::iter::repeat_n(0.1, 10_000_000).collect();
        assert_eq!(sum.total(), 1e6);
    }

    #[test]
    fn infinity_and_nan_show() {
        let total = |terms: &[f64]| terms.iter().copied().collect::<CompensatedSum>().total();
        assert_eq!(total(&[1.0, f64::INFINITY, 2.0]), f64::INFINITY);
        assert!(total(&[f64::INFINITY, f64::NEG_INFINITY]).is_nan() && total(&[0.0, f64::NAN]).is_nan());
    }
}
