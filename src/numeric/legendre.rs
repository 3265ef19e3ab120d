//! Legendre polynomials.

use crate::Real;
use crate::error::check_length;

/// P_l(x), l ≥ 0. For many degrees at one x use [`legendre_all`]; the bits are the same. Cost: l steps of the
/// recurrence.
///
/// # Example
/// ```
/// assert_eq!(haarmonic::numeric::legendre(2, 0.5), -0.125); // (3x² − 1)/2
/// ```
pub fn legendre<T: Real>(l: usize, x: T) -> T {
    let mut steps = LegendreSteps::new(x);
    for _ in 0..l {
        steps.advance();
    }
    steps.value()
}

/// P_0(x), P_1(x), … for as many degrees as `out` holds.
///
/// ```math
/// D_{l+1} = (l D_l − (2l+1)(1 − x) P_l)/(l+1),  P_{l+1} = P_l + D_{l+1},  x ≥ 0; P_l(−x) = (−1)^l P_l(x)
/// ```
///
/// which is the three-term recurrence [Abramowitz & Stegun 22.7.10] for differences: near x = ±1, where P_l changes
/// fastest, 1 − |x| is exact and rounding stays small. Exact at ±1. Accuracy, absolute, `f64`: 5e-16 below degree 64,
/// 1e-15 below 256, 2e-14 below 1024; the plain recurrence has 1e-14, 7e-14 and 1e-12. NaN gives NaN from P_1 on.
pub fn legendre_all<T: Real>(x: T, out: &mut [T]) {
    let mut steps = LegendreSteps::new(x);
    for out in out {
        *out = steps.value();
        steps.advance();
    }
}

/// P_l(x) and P_l′(x) for as many degrees as the slices hold.
///
/// ```text
/// P′_{l+1} = P′_{l−1} + (2l+1) P_l                                    [Abramowitz & Stegun 8.5.4 and 8.5.3]
/// ```
///
/// No division by 1 − x²: exact at the ends, where P_l′(1) = l(l+1)/2. Accuracy: that of [`legendre_all`] times
/// l(l+1)/2.
///
/// # Panics
/// If the slices differ in length.
#[track_caller]
pub fn legendre_slopes<T: Real>(x: T, values: &mut [T], slopes: &mut [T]) {
    check_length("Legendre slopes", values.len(), slopes.len());
    let mut steps = LegendreSteps::new(x);
    for (value, slope) in values.iter_mut().zip(slopes) {
        (*value, *slope) = (steps.value(), steps.slope());
        steps.advance();
    }
}

/// P_l and P_l′ at one x, degree after degree.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LegendreSteps<T> {
    /// 1 − |x|.
    defect: T,
    l: T,
    /// P_l(|x|) and P_l − P_{l−1}.
    value: T,
    step: T,
    /// P_l′(|x|) and P′_{l−1}.
    slope: T,
    slope_below: T,
    /// The sign of x, and its power l.
    mirror: T,
    sign: T,
}

impl<T: Real> LegendreSteps<T> {
    pub(crate) fn new(x: T) -> Self {
        Self::from_defect(T::one() - x.abs(), x < T::zero())
    }

    /// From 1 − |x|, where it is known better than x, and whether x < 0.
    pub(crate) fn from_defect(defect: T, negative: bool) -> Self {
        let (zero, one) = (T::zero(), T::one());
        let mirror = if negative { -one } else { one };
        Self { defect, l: zero, value: one, step: zero, slope: zero, slope_below: zero, mirror, sign: one }
    }

    /// P_l(x).
    #[inline(always)]
    pub(crate) fn value(&self) -> T {
        self.sign * self.value
    }

    /// P_l′(x).
    #[inline(always)]
    pub(crate) fn slope(&self) -> T {
        self.sign * self.mirror * self.slope
    }

    /// To the next degree.
    #[inline(always)]
    pub(crate) fn advance(&mut self) {
        let up = self.l + T::one();
        let both = self.l + up;
        (self.slope, self.slope_below) = (self.slope_below + both * self.value, self.slope);
        self.step = (self.l * self.step - both * (self.defect * self.value)) / up;
        self.value += self.step;
        self.l = up;
        self.sign *= self.mirror;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn low_degrees_are_their_polynomials() {
        for i in -8..=8 {
            let x = f64::from(i) / 8.0;
            let want = [
                (1.0, 0.0),
                (x, 1.0),
                (1.5 * x * x - 0.5, 3.0 * x),
                (2.5 * x * x * x - 1.5 * x, 7.5 * x * x - 1.5),
                ((35.0 * x.powi(4) - 30.0 * x * x + 3.0) / 8.0, (140.0 * x.powi(3) - 60.0 * x) / 8.0),
            ];
            let (mut values, mut slopes) = ([0.0; 5], [0.0; 5]);
            legendre_slopes(x, &mut values, &mut slopes);
            for (l, (value, slope)) in want.into_iter().enumerate() {
                assert!((values[l] - value).abs() < 4e-16 && (slopes[l] - slope).abs() < 4e-15, "l {l} x {x}");
            }
        }
    }

    #[test]
    #[expect(clippy::excessive_precision, reason = "the digits are those of the long computation")]
    fn values_and_slopes_match_forty_digits() {
        // Computed with 40 digits at numbers that have few binary ones.
        let power = |n: i32| 2f64.powi(n);
        for (l, x, value, slope) in [
            (7, 31.0 / 32.0, 0.294_221_701_891_729_03, 17.639_911_405_451_13),
            (20, -7.0 / 8.0, -0.250_679_869_327_359_3, 1.951_001_920_113_740_3),
            (45, 1.0 - power(-20), 0.999_013_190_388_945_3, 1_034.489_777_341_381_2),
            (63, 0.5, -0.103_893_925_705_911_42, 2.015_937_523_347_321),
            // The plain recurrence is off by 6e-14 here.
            (200, 1.0 - power(-12), -0.335_936_443_121_293_2, -1_921.062_036_111_122),
        ] {
            let (mut values, mut slopes) = (vec![0.0f64; l + 1], vec![0.0; l + 1]);
            legendre_slopes(x, &mut values, &mut slopes);
            let rounding = 1e-15 + 1e-17 * l as f64;
            assert!((values[l] - value).abs() < rounding, "P_{l}({x}) = {} not {value}", values[l]);
            let scale = (l * (l + 1) / 2) as f64;
            assert!((slopes[l] - slope).abs() < 1e-15 * scale, "P_{l}'({x}) = {} not {slope}", slopes[l]);
        }
    }

    #[test]
    fn the_ends_are_exact() {
        let (mut values, mut slopes) = (vec![0.0f32; 1000], vec![0.0; 1000]);
        legendre_slopes(1.0, &mut values, &mut slopes);
        for l in 0..1000 {
            assert_eq!((values[l], slopes[l]), (1.0, (l * (l + 1) / 2) as f32), "{l}");
        }
        legendre_slopes(-1.0, &mut values, &mut slopes);
        for l in 0..1000 {
            let sign = if l % 2 == 0 { 1.0 } else { -1.0 };
            assert_eq!((values[l], slopes[l]), (sign, -sign * (l * (l + 1) / 2) as f32), "{l}");
        }
    }

    #[test]
    fn values_are_those_of_laplaces_integral() {
        // P_l(cos θ) = 1/π ∫_0^π Re (cos θ + i sin θ cos φ)^l dφ: a trigonometric polynomial of degree l in φ.
        for bands in [16usize, 64, 300] {
            let tolerance = 4e-15 * (bands as f64 / 16.0).max(1.0);
            let mut all = vec![0.0; bands];
            for i in 0..23 {
                let (sin, cos) = (0.07 + 0.13 * f64::from(i)).sin_cos();
                legendre_all(cos, &mut all);
                for l in (0..bands).step_by(1 + bands / 24).chain([bands - 1]) {
                    let points = l + 2;
                    let mut sum = 0.0;
                    for k in 0..points {
                        let phi = std::f64::consts::PI * (k as f64 + 0.5) / points as f64;
                        let (re, im) = (cos, sin * phi.cos());
                        sum += re.hypot(im).powi(l as i32) * (l as f64 * im.atan2(re)).cos();
                    }
                    let want = sum / points as f64;
                    assert!((all[l] - want).abs() < tolerance, "l {l} cos {cos}: {} {want}", all[l]);
                    assert_eq!(all[l], legendre(l, cos));
                }
            }
        }
    }

    #[test]
    fn slopes_satisfy_the_identity_that_divides_by_the_sine() {
        // (1 − x²) P_l′ = l (P_{l−1} − x P_l).
        let (mut values, mut slopes) = ([0.0; 64], [0.0; 64]);
        for i in 0..41 {
            let x = -1.0 + f64::from(i) / 20.0;
            legendre_slopes(x, &mut values, &mut slopes);
            for l in 1..64 {
                let n = l as f64;
                let want = n * (values[l - 1] - x * values[l]);
                let got = (1.0 - x * x) * slopes[l];
                assert!((got - want).abs() < 4e-15 * n * (n + 1.0) / 2.0, "l {l} x {x}: {got} {want}");
            }
        }
    }

    #[test]
    fn nothing_and_nan() {
        legendre_all::<f64>(0.3, &mut []);
        let mut out = [0.0; 3];
        legendre_all(f64::NAN, &mut out);
        assert!(out[0] == 1.0 && out[1].is_nan() && out[2].is_nan());
    }
}
