//! Legendre polynomials.

use crate::Real;
use crate::error::check_length;

/// P_l(x), l ≥ 0. For many degrees at one x use [`legendre_all`]; the bits are the same.
///
/// # Example
/// ```
/// assert_eq!(haarmonic::numeric::legendre(2, 0.5), -0.125); // (3x² − 1)/2
/// ```
pub fn legendre<T: Real>(l: usize, x: T) -> T {
    let (mut value, mut before) = (T::one(), T::zero());
    for k in 0..l {
        (value, before) = (next(k, x, value, before), value);
    }
    value
}

/// P_0(x), P_1(x), … for as many degrees as `out` holds.
///
///   P_{l+1} = x P_l + l/(l+1) (x P_l − P_{l−1})                         [Abramowitz & Stegun 22.7.10, rearranged]
///
/// Exact at x = ±1. Accuracy, absolute, on [−1, 1]: 1e-15 below degree 16, 4e-15 below 64, 2e-14 below 1024 in `f64`. NaN gives NaN from
/// P_1 on.
pub fn legendre_all<T: Real>(x: T, out: &mut [T]) {
    let (mut value, mut before) = (T::one(), T::zero());
    for (l, out) in out.iter_mut().enumerate() {
        *out = value;
        (value, before) = (next(l, x, value, before), value);
    }
}

/// P_l(x) and P_l′(x) for as many degrees as the slices hold.
///
///   P′_{l+1} = P′_{l−1} + (2l+1) P_l                                    [Abramowitz & Stegun 8.5.4 and 8.5.3]
///
/// No division by 1 − x²: exact at the ends, where P_l′(1) = l(l+1)/2. Accuracy: 2e-15 of l(l+1)/2 below degree 64 in `f64`.
///
/// # Panics
/// If the slices differ in length.
#[track_caller]
pub fn legendre_slopes<T: Real>(x: T, values: &mut [T], slopes: &mut [T]) {
    check_length("Legendre slopes", values.len(), slopes.len());
    let (mut value, mut before) = (T::one(), T::zero());
    let (mut slope, mut slope_before) = (T::zero(), T::zero());
    for (l, (v, s)) in values.iter_mut().zip(slopes).enumerate() {
        (*v, *s) = (value, slope);
        (slope, slope_before) = (slope_before + T::of((2 * l + 1) as f64) * value, slope);
        (value, before) = (next(l, x, value, before), value);
    }
}

/// P_{l+1} from P_l and P_{l−1}.
#[inline(always)]
fn next<T: Real>(l: usize, x: T, value: T, before: T) -> T {
    let up = x * value;
    up + T::of(l as f64 / (l + 1) as f64) * (up - before)
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
