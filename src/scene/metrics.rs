//! How far a relit scene is from the truth: always on linear radiance.

use nalgebra::Vector3;

use crate::approx_eq::approx_by_parts;
use crate::numeric::CompensatedSum;
use crate::{Error, Real, Result};

/// One image or vertex list against its reference: the three numbers that every method reports.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// Peak signal-to-noise ratio in dB, with [`percentile_peak`] of the reference as the peak.
    pub psnr_db: f64,
    /// ‖test − reference‖₂ / ‖reference‖₂ over all channels.
    pub rel_l2: f64,
    /// The largest absolute difference of a channel; infinite where that is beyond the largest number.
    pub max_abs: f64,
}

impl Comparison {
    /// Compares `test` with `reference`, element by element.
    ///
    /// Identical lists give (+∞, 0, 0). Where they differ, a reference that is zero throughout gives `rel_l2` = +∞, and
    /// one whose peak is zero `psnr_db` = −∞.
    ///
    /// # Errors
    /// [`Error::Empty`] for empty lists, [`Error::Length`] if their lengths differ, [`Error::NotFinite`] with the first
    /// element that is NaN or infinite in either.
    ///
    /// # Example
    /// ```
    /// use haarmonic::{nalgebra::Vector3, scene::Comparison};
    /// let truth = vec![Vector3::repeat(1.0f64); 10];
    /// let test = vec![Vector3::repeat(1.01f64); 10];
    /// let c = Comparison::new(&truth, &test)?;
    /// assert!((c.psnr_db - 40.0).abs() < 1e-9 && (c.rel_l2 - 0.01).abs() < 1e-12);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn new<A: Real, B: Real>(reference: &[Vector3<A>], test: &[Vector3<B>]) -> Result<Self> {
        let difference = Difference::of(reference, test)?;
        let peak = percentile_peak(reference)?;
        Ok(Self { psnr_db: difference.psnr_db(peak), rel_l2: difference.rel_l2(), max_abs: difference.max_abs })
    }
}

/// 10 log₁₀(peak² / MSE) in dB over all channels of all elements.
///
/// Identical lists give +∞ for any peak; others −∞ if the peak is 0.
///
/// # Errors
/// As [`Comparison::new`], and [`Error::OutOfRange`] unless `peak` is finite and not negative.
pub fn psnr_db<A: Real, B: Real>(reference: &[Vector3<A>], test: &[Vector3<B>], peak: f64) -> Result<f64> {
    if !(peak.is_finite() && peak >= 0.0) {
        return Err(Error::OutOfRange { what: "PSNR peak", got: peak, allowed: "finite and not negative" });
    }
    Ok(Difference::of(reference, test)?.psnr_db(peak))
}

/// ‖test − reference‖₂ / ‖reference‖₂ over all channels; 0 for identical lists, +∞ for others if the reference is zero.
///
/// # Errors
/// As [`Comparison::new`].
pub fn rel_l2<A: Real, B: Real>(reference: &[Vector3<A>], test: &[Vector3<B>]) -> Result<f64> {
    Ok(Difference::of(reference, test)?.rel_l2())
}

/// The largest absolute difference of a channel.
///
/// # Errors
/// As [`Comparison::new`].
pub fn max_abs<A: Real, B: Real>(reference: &[Vector3<A>], test: &[Vector3<B>]) -> Result<f64> {
    Ok(Difference::of(reference, test)?.max_abs)
}

/// The peak for [`psnr_db`]: the 99.9th percentile of the reference's linear radiance over elements and channels.
///
/// By nearest rank: of the N = 3 · elements values in ascending order, number ⌈0.999 N⌉ counted from 1; so for fewer
/// than 1000 values it is the maximum. A single sun reflection therefore does not set the scale. Negative values count
/// as 0.
///
/// # Errors
/// [`Error::Empty`] for an empty list, [`Error::NotFinite`] with the first element that is NaN or infinite.
pub fn percentile_peak<T: Real>(reference: &[Vector3<T>]) -> Result<f64> {
    if reference.is_empty() {
        return Err(Error::Empty { what: "reference radiance" });
    }
    check_finite("reference radiance", reference)?;
    let mut values: Vec<f64> = reference.iter().flat_map(|v| v.iter().map(|c| c.widen())).collect();
    let rank = (values.len() * 999).div_ceil(1000);
    let (_, value, _) = values.select_nth_unstable_by(rank - 1, f64::total_cmp);
    Ok(value.max(0.0))
}

fn check_finite<T: Real>(what: &'static str, values: &[Vector3<T>]) -> Result<()> {
    match values.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
        Some(index) => Err(Error::NotFinite { what, index }),
        None => Ok(()),
    }
}

/// What all the measures are made of. Sums are of squares scaled by the largest magnitude, so that they neither
/// overflow nor vanish.
struct Difference {
    channels: f64,
    /// Σ (difference / max_abs)², 0 if they are identical.
    scaled_error: f64,
    max_abs: f64,
    /// max_abs/largest, also where max_abs is beyond the largest number.
    max_ratio: f64,
    /// Σ (reference / largest)², and that largest magnitude.
    scaled_energy: f64,
    largest: f64,
}

impl Difference {
    fn of<A: Real, B: Real>(reference: &[Vector3<A>], test: &[Vector3<B>]) -> Result<Self> {
        if reference.is_empty() {
            return Err(Error::Empty { what: "reference radiance" });
        }
        if reference.len() != test.len() {
            let (expected, got) = (reference.len(), test.len());
            return Err(Error::Length { what: "radiance to compare", expected, got });
        }
        check_finite("reference radiance", reference)?;
        check_finite("radiance to compare", test)?;
        let reference = || reference.iter().flat_map(|v| v.iter().map(|c| c.widen()));
        let differences = || reference().zip(test.iter().flat_map(|v| v.iter().map(|c| c.widen()))).map(|(r, t)| t - r);
        let (largest, scaled_energy) = scaled_squares(reference);
        let (max_abs, scaled_error) = scaled_squares(differences);
        let channels = 3.0 * test.len() as f64;
        if max_abs.is_finite() {
            return Ok(Self { channels, scaled_error, max_abs, max_ratio: max_abs / largest, scaled_energy, largest });
        }
        // A difference that overflows: the same of the halves, exactly.
        let halves = || reference().zip(test.iter().flat_map(|v| v.iter().map(|c| c.widen())));
        let (half, scaled_error) = scaled_squares(|| halves().map(|(r, t)| 0.5 * t - 0.5 * r));
        Ok(Self { channels, scaled_error, max_abs, max_ratio: half / (0.5 * largest), scaled_energy, largest })
    }

    fn psnr_db(&self, peak: f64) -> f64 {
        if self.max_abs == 0.0 {
            return f64::INFINITY;
        }
        let ratio = peak / self.max_abs;
        let level = if ratio.is_normal() {
            ratio.log10()
        } else if self.max_abs.is_finite() {
            peak.log10() - self.max_abs.log10()
        } else {
            peak.log10() - self.largest.log10() - self.max_ratio.log10()
        };
        20.0 * level - 10.0 * (self.scaled_error / self.channels).log10()
    }

    fn rel_l2(&self) -> f64 {
        if self.max_abs == 0.0 {
            0.0
        } else if self.largest == 0.0 {
            f64::INFINITY
        } else {
            self.max_ratio * (self.scaled_error / self.scaled_energy).sqrt()
        }
    }
}

/// m = max |x| and Σ (x/m)², (0, 0) if every x is 0.
fn scaled_squares<I: Iterator<Item = f64>>(values: impl Fn() -> I) -> (f64, f64) {
    let largest = values().fold(0.0, |m: f64, x| m.max(x.abs()));
    if largest == 0.0 {
        return (0.0, 0.0);
    }
    let squares: CompensatedSum = values().map(|x| (x / largest) * (x / largest)).collect();
    (largest, squares.total())
}

approx_by_parts!([] Comparison, f64, |c| close [[c.psnr_db, c.rel_l2, c.max_abs]] same []);

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: &[f64]) -> Vec<Vector3<f64>> {
        values.iter().map(|&v| Vector3::repeat(v)).collect()
    }

    #[test]
    fn known_errors_give_known_figures() {
        let truth = grey(&[1.0, 2.0, 2.0]);
        let test: Vec<Vector3<f32>> = [1.0, 2.0, 2.3].iter().map(|&v| Vector3::repeat(v)).collect();
        let c = Comparison::new(&truth, &test).unwrap();
        // Differences 0, 0, 0.3 (as f32): MSE 0.03, norm 3, peak 2.
        let d = f64::from(2.3f32) - 2.0;
        assert!((c.psnr_db - 10.0 * (4.0 / (d * d / 3.0)).log10()).abs() < 1e-12);
        assert!((c.rel_l2 - d / 3.0).abs() < 1e-15 && (c.max_abs - d).abs() < 1e-15);
        assert_eq!(psnr_db(&truth, &test, 2.0), Ok(c.psnr_db));
        assert_eq!(rel_l2(&truth, &test), Ok(c.rel_l2));
        assert_eq!(max_abs(&truth, &test), Ok(c.max_abs));
    }

    #[test]
    fn identical_lists_have_no_error() {
        for truth in [grey(&[0.0]), grey(&[0.3, 1e300]), grey(&[5e-324])] {
            let c = Comparison::new(&truth, &truth).unwrap();
            assert_eq!(c, Comparison { psnr_db: f64::INFINITY, rel_l2: 0.0, max_abs: 0.0 });
        }
    }

    #[test]
    fn a_black_reference_makes_every_error_infinite() {
        let c = Comparison::new(&grey(&[0.0, 0.0]), &grey(&[0.0, 0.1])).unwrap();
        assert_eq!((c.psnr_db, c.rel_l2, c.max_abs), (f64::NEG_INFINITY, f64::INFINITY, 0.1));
    }

    #[test]
    fn figures_do_not_depend_on_the_unit() {
        let (truth, test) = (grey(&[1.0, 0.5, 3.0]), grey(&[1.1, 0.5, 2.9]));
        let base = Comparison::new(&truth, &test).unwrap();
        for scale in [1e-200, 1e-3, 1e200] {
            let by = |v: &[Vector3<f64>]| v.iter().map(|v| v * scale).collect::<Vec<_>>();
            let c = Comparison::new(&by(&truth), &by(&test)).unwrap();
            assert!((c.psnr_db - base.psnr_db).abs() < 1e-12 && (c.rel_l2 / base.rel_l2 - 1.0).abs() < 1e-14);
            assert!((c.max_abs / (scale * base.max_abs) - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn the_peak_is_the_nearest_rank() {
        // 1000 values 1…1000 (333 elements and a third): rank ⌈0.999·N⌉.
        let ramp = |n: usize| (0..n).map(|i| Vector3::from_fn(|c, _| (3 * i + c + 1) as f64)).collect::<Vec<_>>();
        for (elements, peak) in [(1, 3.0), (333, 999.0), (334, 1001.0), (1000, 2997.0), (2000, 5994.0)] {
            assert_eq!(percentile_peak(&ramp(elements)), Ok(peak), "{elements} elements");
        }
        // One hot reflection among 1001 values does not count.
        let mut hot = grey(&vec![1.0; 400]);
        hot[17].y = 1e6;
        assert_eq!(percentile_peak(&hot), Ok(1.0));
        assert_eq!(percentile_peak(&grey(&[-1.0])), Ok(0.0));
    }

    #[test]
    fn what_cannot_be_compared_is_an_error() {
        let good = grey(&[1.0, 2.0]);
        assert_eq!(percentile_peak::<f32>(&[]), Err(Error::Empty { what: "reference radiance" }));
        assert!(matches!(Comparison::new::<f64, f64>(&[], &[]), Err(Error::Empty { .. })));
        assert!(matches!(Comparison::new(&good, &good[..1]), Err(Error::Length { expected: 2, got: 1, .. })));
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let bad = grey(&[1.0, bad]);
            assert!(matches!(Comparison::new(&good, &bad), Err(Error::NotFinite { index: 1, .. })));
            assert!(matches!(Comparison::new(&bad, &good), Err(Error::NotFinite { index: 1, .. })));
            assert!(matches!(percentile_peak(&bad), Err(Error::NotFinite { index: 1, .. })));
        }
        for peak in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(psnr_db(&good, &good, peak), Err(Error::OutOfRange { .. })));
        }
    }
}
