//! The exponential integral of complex argument, and what the sine and cosine integrals are made of.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Complex;

/// Euler's constant γ.
const EULER: f64 = 0.577_215_664_901_532_9;

/// From here on the asymptotic series, whose least term is e^{−|z|}, is exact to rounding.
const FAR: f64 = 60.0;

/// Within this parabola |z| + Re z the power series loses no more than its e^3 to cancellation, and outside of it the
/// continued fraction needs no more than 60 steps.
const PARABOLA: f64 = 3.0;

/// E₁(z), the exponential integral.
///
/// ```math
/// E₁(z) = ∫_z^∞ e^{−t}/t dt,  |arg z| < π                                       [Abramowitz & Stegun, 5.1.1]
/// ```
///
/// The branch cut is the negative real axis: with imaginary part +0 the value is the limit from above, −Ei(−x) − iπ,
/// with −0 that from below. E₁(0) = ∞, E₁(+∞) = 0, E₁(−∞) = −∞; NaN gives NaN. Beyond Re z = −709 the value overflows;
/// see [`exponential_integral_scaled`].
///
/// Accuracy: 1e-14 of |E₁| everywhere, and of the part that is smaller where that is on the cut (a test against values
/// of 80 digits). Cost: 10 to 100 complex divisions, most near the parabola |z| + Re z = 3 and far out on the cut.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Complex, numeric::exponential_integral};
/// let e1 = exponential_integral(Complex::new(1.0, 0.0));
/// assert!((e1.re - 0.219_383_934_395_520_27).abs() < 1e-15 && e1.im == 0.0);
/// ```
pub fn exponential_integral(z: Complex<f64>) -> Complex<f64> {
    match special(z) {
        Some(Special::Zero) => Complex::new(f64::INFINITY, 0.0),
        Some(Special::Infinite) if z.re == f64::NEG_INFINITY => Complex::new(f64::NEG_INFINITY, 0.0),
        Some(Special::Infinite) => Complex::new(0.0, 0.0),
        Some(Special::Nan) => Complex::new(f64::NAN, f64::NAN),
        None if is_near(z) => series(z),
        None => {
            let value = (-z).exp() * far_scaled(z);
            if is_on_cut(z) { Complex::new(value.re, -PI.copysign(z.im)) } else { value }
        }
    }
}

/// e^z E₁(z), which neither overflows nor underflows.
///
/// ```math
/// e^z E₁(z) = ∫_0^∞ e^{−t}/(z + t) dt → 1/z
/// ```
///
/// Branch cut, accuracy and cost are those of [`exponential_integral`]; ∞ at 0, 0 at infinity in any direction.
pub fn exponential_integral_scaled(z: Complex<f64>) -> Complex<f64> {
    match special(z) {
        Some(Special::Zero) => Complex::new(f64::INFINITY, 0.0),
        Some(Special::Infinite) => Complex::new(0.0, 0.0),
        Some(Special::Nan) => Complex::new(f64::NAN, f64::NAN),
        None if is_near(z) => z.exp() * series(z),
        None => {
            let value = far_scaled(z);
            if is_on_cut(z) { Complex::new(value.re, -(PI * z.re.exp()).copysign(z.im)) } else { value }
        }
    }
}

/// The auxiliary functions f and g of the sine and cosine integrals, for x ≥ 0.
///
/// ```math
/// f(x) = ∫_0^∞ sin t/(t + x) dt = Ci(x) sin x + (π/2 − Si(x)) cos x       [Abramowitz & Stegun, 5.2.6, 5.2.12]
/// g(x) = ∫_0^∞ cos t/(t + x) dt = −Ci(x) cos x + (π/2 − Si(x)) sin x      [Abramowitz & Stegun, 5.2.7, 5.2.13]
/// Si(x) = π/2 − f(x) cos x − g(x) sin x,  Ci(x) = f(x) sin x − g(x) cos x,  g − i f = e^{ix} E₁(ix)
/// ```
///
/// Both fall smoothly, f as 1/x and g as 1/x², where Si and Ci oscillate. f(0) = π/2, g(0) = ∞; a negative x or NaN
/// gives NaN. Accuracy: 1e-14 of √(f² + g²); where g is much the smaller, beyond x = 60, of g itself as well.
///
/// # Example
/// ```
/// let (f, g) = haarmonic::numeric::sine_cosine_auxiliary(1.0);
/// assert!((f - 0.621_449_624_235_813_4).abs() < 3e-15 && (g - 0.343_377_961_556_427).abs() < 3e-15);
/// ```
pub fn sine_cosine_auxiliary(x: f64) -> (f64, f64) {
    if x == 0.0 {
        return (FRAC_PI_2, f64::INFINITY);
    }
    if !(x > 0.0) {
        return (f64::NAN, f64::NAN);
    }
    let value = exponential_integral_scaled(Complex::new(0.0, x));
    (-value.im, value.re)
}

/// What no series is for.
enum Special {
    Zero,
    Infinite,
    Nan,
}

fn special(z: Complex<f64>) -> Option<Special> {
    match z {
        _ if z.re.is_nan() || z.im.is_nan() => Some(Special::Nan),
        _ if z.re.is_infinite() || z.im.is_infinite() => Some(Special::Infinite),
        _ if z.re == 0.0 && z.im == 0.0 => Some(Special::Zero),
        _ => None,
    }
}

/// Whether the power series is for it.
fn is_near(z: Complex<f64>) -> bool {
    let radius = z.re.hypot(z.im);
    radius <= FAR && radius + z.re <= PARABOLA
}

fn is_on_cut(z: Complex<f64>) -> bool {
    z.re < 0.0 && z.im == 0.0
}

/// −γ − ln z − Σ (−z)^k/(k k!).
fn series(z: Complex<f64>) -> Complex<f64> {
    let radius = z.re.hypot(z.im);
    // Terms are like those of e^|z|: centred at |z| and √|z| wide.
    let terms = (radius + 9.0 * radius.sqrt()) as usize + 24;
    let (mut sum, mut power) = (Complex::new(0.0, 0.0), Complex::new(1.0, 0.0));
    for k in 1..=terms {
        power *= -z / k as f64;
        sum -= power / k as f64;
    }
    Complex::new(-EULER, 0.0) - Complex::new(radius.ln(), z.im.atan2(z.re)) + sum
}

/// e^z E₁(z) outside of where the series is for it.
fn far_scaled(z: Complex<f64>) -> Complex<f64> {
    let radius = z.re.hypot(z.im);
    if radius > FAR {
        return asymptotic_scaled(z);
    }
    // The error of n steps is e^{−4 √n Re √z} with (Re √z)² = (|z| + Re z)/2.
    let steps = (180.0 / (radius + z.re)) as usize + 6;
    let mut denominator = z + (2 * steps + 1) as f64;
    for k in (1..=steps).rev() {
        denominator = z + (2 * k - 1) as f64 - (k * k) as f64 / denominator;
    }
    denominator.finv()
}

/// Σ (−1)^k k!/z^{k+1}, up to terms that do not count.
fn asymptotic_scaled(z: Complex<f64>) -> Complex<f64> {
    let inverse = z.finv();
    let (mut sum, mut term) = (Complex::new(1.0, 0.0), Complex::new(1.0, 0.0));
    for k in 1..=45 {
        term *= -inverse * k as f64;
        sum += term;
        if term.re.abs() + term.im.abs() < 0.01 * f64::EPSILON {
            break;
        }
    }
    sum * inverse
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;
    use crate::numeric::GaussLegendre;

    fn golden() -> Value {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/special/exponential_integral.json");
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
    }

    fn complex(pair: &Value) -> Complex<f64> {
        Complex::new(pair[0].as_f64().unwrap(), pair[1].as_f64().unwrap())
    }

    fn off(got: Complex<f64>, want: Complex<f64>) -> f64 {
        (got.re - want.re).hypot(got.im - want.im) / want.re.hypot(want.im)
    }

    #[test]
    fn golden_values_are_reproduced() {
        let golden = golden();
        let rows = golden["e1"].as_array().unwrap();
        assert!(rows.len() > 150);
        for row in rows {
            let z = complex(&row[0]);
            let error = off(exponential_integral_scaled(z), complex(&row[2]));
            assert!(error < 1e-14, "scaled at {z}: {error:e}");
            if !row[1].is_null() {
                // exp(−z) is off by |z| eps.
                let (got, want) = (exponential_integral(z), complex(&row[1]));
                let error = off(got, want);
                assert!(error < 1e-14 + f64::EPSILON * z.norm(), "at {z}: {error:e}");
                if is_on_cut(z) {
                    assert!((got.im / want.im - 1.0).abs() < 1e-15, "at {z}: {got} against {want}");
                }
            }
        }
        for row in golden["auxiliary"].as_array().unwrap() {
            let [x, f, g] = [0, 1, 2].map(|i| row[i].as_f64().unwrap());
            let (got_f, got_g) = sine_cosine_auxiliary(x);
            assert!((got_f - f).hypot(got_g - g) < 1e-14 * f.hypot(g), "{x}: {got_f}, {got_g} against {f}, {g}");
            assert!(x < 60.0 || (got_g / g - 1.0).abs() < 1e-14, "{x}: {got_g} against {g}");
        }
    }

    /// e^z E₁(z) = ∫ e^{−t}/(z + t) dt, panel by panel.
    fn by_quadrature(z: Complex<f64>) -> Complex<f64> {
        let rule = GaussLegendre::new(40).unwrap();
        let mut sum = Complex::new(0.0, 0.0);
        for panel in 0..80 {
            let (from, to) = (0.5 * f64::from(panel), 0.5 * f64::from(panel + 1));
            let part = |part: fn(Complex<f64>) -> f64| rule.integrate(from, to, |t| part((z + t).finv()) * (-t).exp());
            sum += Complex::new(part(|c| c.re), part(|c| c.im));
        }
        sum
    }

    #[test]
    fn it_is_its_integral() {
        for i in 0..400 {
            // On and off the border between series and continued fraction, away from the pole of the integrand.
            let (radius, angle) = (0.6 + 0.05 * f64::from(i), (f64::from(i) * 0.618).sin() * 2.3);
            let z = Complex::from_polar(radius, angle);
            let error = off(exponential_integral_scaled(z), by_quadrature(z));
            assert!(error < 1e-13, "{z}: {error:e}");
        }
    }

    #[test]
    fn borders_do_not_jump() {
        for angle in [0.0, 1.0, 2.0, 2.9, 3.1] {
            for radius in [FAR, PARABOLA / (1.0 + f64::cos(angle))] {
                let [below, above] = [1.0 - 1e-12, 1.0 + 1e-12]
                    .map(|s| exponential_integral_scaled(Complex::from_polar(radius * s, angle)));
                assert!(off(below, above) < 2e-11, "{radius} at {angle}: {below} and {above}");
            }
        }
    }

    #[test]
    fn ends_of_the_range() {
        let at = |re: f64, im: f64| {
            (exponential_integral(Complex::new(re, im)), exponential_integral_scaled(Complex::new(re, im)))
        };
        assert_eq!(at(0.0, 0.0).0.re, f64::INFINITY);
        assert_eq!(at(f64::INFINITY, 0.0).0, Complex::new(0.0, 0.0));
        assert_eq!(at(f64::NEG_INFINITY, 0.0), (Complex::new(f64::NEG_INFINITY, 0.0), Complex::new(0.0, 0.0)));
        assert_eq!(at(0.0, f64::INFINITY).1, Complex::new(0.0, 0.0));
        assert!(at(f64::NAN, 1.0).0.re.is_nan() && at(1.0, f64::NAN).1.im.is_nan());
        // Far out: 1/z, without overflow on the way.
        for huge in [1e10, 1e200, f64::MAX] {
            assert!((at(huge, 0.0).1.re * huge - 1.0).abs() < 1e-9, "{huge}");
            assert!((at(-huge, 1.0).1.re * huge + 1.0).abs() < 1e-9, "{huge}");
        }
        assert!((at(f64::MIN_POSITIVE, 0.0).0.re - 707.8192).abs() < 1e-3);
        assert_eq!(at(800.0, 0.0).0, Complex::new(0.0, 0.0));
        assert_eq!(sine_cosine_auxiliary(0.0), (FRAC_PI_2, f64::INFINITY));
        assert!(sine_cosine_auxiliary(-1.0).0.is_nan() && sine_cosine_auxiliary(f64::NAN).1.is_nan());
        assert_eq!(sine_cosine_auxiliary(f64::INFINITY), (0.0, 0.0));
    }
}
