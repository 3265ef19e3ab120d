//! Functions whose argument may leave their domain by a rounding error.

use crate::Real;

/// √max(x, 0): a square root for arguments that are non-negative but for rounding. NaN gives NaN.
#[inline(always)]
pub fn safe_sqrt<T: Real>(x: T) -> T {
    if x < T::zero() { T::zero() } else { x.sqrt() }
}

/// acos of `x` clamped to [−1, 1]: in [0, π]. NaN gives NaN.
#[inline(always)]
pub fn safe_acos<T: Real>(x: T) -> T {
    clamp_unit(x).acos()
}

/// asin of `x` clamped to [−1, 1]: in [−π/2, π/2]. NaN gives NaN.
#[inline(always)]
pub fn safe_asin<T: Real>(x: T) -> T {
    clamp_unit(x).asin()
}

/// Clamps to [−1, 1] and lets NaN pass.
#[inline(always)]
fn clamp_unit<T: Real>(x: T) -> T {
    if x > T::one() {
        T::one()
    } else if x < -T::one() {
        -T::one()
    } else {
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_outside_the_domain_give_the_border_value() {
        assert_eq!(safe_sqrt(-1e-300), 0.0);
        assert_eq!(safe_sqrt(4.0f32), 2.0);
        assert_eq!(safe_acos(1.0 + 1e-15), 0.0);
        assert_eq!(safe_acos(-1.0f32 - 1e-6), std::f32::consts::PI);
        assert_eq!(safe_asin(f64::INFINITY), std::f64::consts::FRAC_PI_2);
        assert_eq!(safe_asin(-2.0), -std::f64::consts::FRAC_PI_2);
        assert_eq!(safe_acos(0.5), 0.5f64.acos());
    }

    #[test]
    fn nan_stays_nan() {
        assert!(safe_sqrt(f64::NAN).is_nan() && safe_acos(f32::NAN).is_nan() && safe_asin(f64::NAN).is_nan());
    }
}
