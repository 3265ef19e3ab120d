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

/// Σ x² of numbers of any size: those whose squares would leave the range are summed apart, scaled by a power of two
/// [Blue 1978].
///
/// The same bits as a plain sum where no square comes near the ends of the range. NaN makes it NaN.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct SquareSum {
    /// Of numbers below 2^−480, times 2^600.
    small: f64,
    normal: f64,
    /// Of numbers above 2^480, times 2^−600.
    large: f64,
}

/// 2^e.
const fn power(e: i32) -> f64 {
    f64::from_bits(((1023 + e) as u64) << 52)
}

impl SquareSum {
    const SHIFT: i32 = 600;

    /// A sum that was made by other means and is well inside the range, or 0.
    pub(crate) fn plain(sum: f64) -> Self {
        Self { normal: sum, ..Self::default() }
    }

    /// Whether a plain sum of squares, the largest of them that of `largest`, is as good as this.
    pub(crate) fn is_plain(sum: f64, largest: f64) -> bool {
        sum.is_finite() && (largest >= power(-480) || largest == 0.0)
    }

    /// Adds x².
    #[inline]
    pub(crate) fn add(&mut self, x: f64) {
        if x.abs() > power(480) {
            self.large += (x * power(-Self::SHIFT)).powi(2);
        } else if x.abs() < power(-480) {
            self.small += (x * power(Self::SHIFT)).powi(2);
        } else {
            self.normal += x * x;
        }
    }

    /// Adds another sum.
    pub(crate) fn merge(self, other: Self) -> Self {
        Self { small: self.small + other.small, normal: self.normal + other.normal, large: self.large + other.large }
    }

    /// (m, e) with Σ x² = m · 2^{2e}.
    fn parts(self) -> (f64, i32) {
        // 2^−1200 in two steps.
        let down = |sum: f64| sum * power(-Self::SHIFT) * power(-Self::SHIFT);
        if self.large != 0.0 {
            (self.large + down(self.normal), Self::SHIFT)
        } else if self.normal != 0.0 {
            (self.normal + down(self.small), 0)
        } else {
            (self.small, -Self::SHIFT)
        }
    }

    /// Σ x² over a count (1 for 0), its root; of finite numbers at most the largest.
    pub(crate) fn root_mean(self, count: f64) -> f64 {
        let (m, e) = self.parts();
        let root = (m / count.max(1.0)).sqrt() * power(e);
        if m.is_finite() { root.min(f64::MAX) } else { root }
    }

    /// √(Σ x²).
    pub(crate) fn root(self) -> f64 {
        self.root_mean(1.0)
    }

    /// √(Σ x² / Σ y²): 0 if the first is 0.
    pub(crate) fn root_ratio(self, other: Self) -> f64 {
        let ((m, e), (n, f)) = (self.parts(), other.parts());
        if m == 0.0 {
            return 0.0;
        }
        let half = power((e - f) / 2);
        (m / n).sqrt() * half * half
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_of_any_size() {
        let sum = |terms: &[f64]| {
            let mut sum = SquareSum::default();
            terms.iter().for_each(|&x| sum.add(x));
            sum
        };
        for unit in [0, 660, -660, 1000, -1074, 500, -500].map(|e: i32| 2f64.powi(e / 2) * 2f64.powi(e - e / 2)) {
            let five = sum(&[3.0 * unit, -4.0 * unit]);
            assert_eq!(five.root(), 5.0 * unit, "{unit:e}");
            assert_eq!(five.root_ratio(sum(&[unit])), 5.0, "{unit:e}");
            assert_eq!(sum(&[3.0 * unit, 0.0, -4.0 * unit, 0.0]).root_mean(4.0), 2.5 * unit, "{unit:e}");
        }
        assert_eq!(sum(&[1e-200, 3.0, 4.0]).root(), 5.0);
        assert_eq!(sum(&[1e200, 3.0, 1e-200]).root(), 1e200);
        assert_eq!(sum(&[power(660)]).root_ratio(sum(&[power(-330)])), power(990));
        assert_eq!(sum(&[1e-200]).root_ratio(sum(&[1e200])), 0.0);
        assert_eq!((sum(&[f64::MAX]).root(), sum(&[f64::MAX; 2]).root()), (f64::MAX, f64::MAX));
        assert_eq!(sum(&[]).root_ratio(sum(&[])), 0.0);
        assert_eq!(sum(&[f64::INFINITY]).root(), f64::INFINITY);
        assert!(sum(&[1e200, f64::NAN]).root().is_nan() && sum(&[f64::NAN]).root_ratio(sum(&[1.0])).is_nan());
        assert_eq!(sum(&[3.0 * power(660)]).merge(sum(&[4.0 * power(660)])).root(), 5.0 * power(660));
    }

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
