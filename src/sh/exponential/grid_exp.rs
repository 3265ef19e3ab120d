//! e^x without calls, so that loops over it vectorise and every machine gives the same bits.

use crate::Real;

/// e^x for x in −87…85 (`f32`) or −708…705 (`f64`), with x beyond taken as the nearest of them; NaN stays NaN.
///
/// ```math
/// x = k ln 2 + r, |r| ≤ ln 2 / 2,  e^x = 2^k Σ r^i/i!  up to i = 7 (f32, 5e-9 left out) or 13 (f64, 4e-18)
/// ```
///
/// The upper ends leave a sum over the sphere room below the largest number.
#[inline(always)]
pub(super) fn exp<T: Real>(x: T) -> T {
    // The conversions cancel: one of the branches is of T's own type.
    if size_of::<T>() == 4 { T::of(f64::from(exp_f32(x.widen() as f32))) } else { T::of(exp_f64(x.widen())) }
}

/// Adding it rounds to an integer, which then stands in the lowest bits.
const ROUND_F32: f32 = 12_582_912.0; // 1.5 · 2²³
const ROUND_F64: f64 = 6_755_399_441_055_744.0; // 1.5 · 2⁵²

/// 1/i!, the highest first.
const fn reciprocal_factorials<const N: usize>() -> [f64; N] {
    let (mut out, mut i, mut factorial) = ([1.0; N], 1, 1.0);
    while i < N {
        factorial *= i as f64;
        out[N - 1 - i] = 1.0 / factorial;
        i += 1;
    }
    out
}

#[inline(always)]
fn exp_f32(x: f32) -> f32 {
    const TERMS: [f64; 8] = reciprocal_factorials();
    /// ln 2 with 9 bits to spare: k times it is exact.
    const LN2_HIGH: f32 = 0.693_359_4;
    const LN2_LOW: f32 = (std::f64::consts::LN_2 - LN2_HIGH as f64) as f32;
    let x = if x > 85.0 { 85.0 } else { x };
    let x = if x < -87.0 { -87.0 } else { x };
    let shifted = x * std::f32::consts::LOG2_E + ROUND_F32;
    let k = shifted - ROUND_F32;
    let r = (x - k * LN2_HIGH) - k * LN2_LOW;
    let mut sum = TERMS[0] as f32;
    for term in &TERMS[1..] {
        sum = sum * r + *term as f32;
    }
    sum * f32::from_bits((shifted.to_bits() << 23).wrapping_add(1f32.to_bits()))
}

#[inline(always)]
fn exp_f64(x: f64) -> f64 {
    const TERMS: [f64; 14] = reciprocal_factorials();
    /// ln 2 with its last 21 bits cleared: k times it is exact.
    const LN2_HIGH: f64 = f64::from_bits(std::f64::consts::LN_2.to_bits() & !0x1f_ffff);
    /// ln 2 − LN2_HIGH, whose digits f64 has not at its end: ln 2 = LN_2 + 2.319e-17.
    const LN2_LOW: f64 = (std::f64::consts::LN_2 - LN2_HIGH) + 2.319_046_813_846_299_6e-17;
    let x = if x > 705.0 { 705.0 } else { x };
    let x = if x < -708.0 { -708.0 } else { x };
    let shifted = x * std::f64::consts::LOG2_E + ROUND_F64;
    let k = shifted - ROUND_F64;
    let r = (x - k * LN2_HIGH) - k * LN2_LOW;
    let mut sum = TERMS[0];
    for term in &TERMS[1..] {
        sum = sum * r + *term;
    }
    sum * f64::from_bits((shifted.to_bits() << 52).wrapping_add(1f64.to_bits()))
}

#[cfg(test)]
mod tests {
    use super::exp;

    #[test]
    fn exp_is_that_of_the_standard_library() {
        for i in -7080..=7050 {
            let x = f64::from(i) * 0.1 + 0.013 * f64::from(i % 7);
            let x = x.clamp(-708.0, 705.0);
            assert!((exp(x) / x.exp() - 1.0).abs() < 5e-16, "{x}: {} {}", exp(x), x.exp());
        }
        for i in -8700..=8500 {
            let x = i as f32 * 0.01;
            let want = f64::from(x).exp();
            assert!((f64::from(exp(x)) / want - 1.0).abs() < 1.5e-7, "{x}: {} {want}", exp(x));
        }
    }

    #[test]
    fn exp_beyond_its_range_stays_at_the_ends() {
        assert_eq!((exp(1e30f32), exp(f32::INFINITY)), (exp(85.0f32), exp(85.0f32)));
        assert_eq!((exp(-1e300), exp(f64::NEG_INFINITY)), (exp(-708.0), exp(-708.0)));
        assert!(exp(705.0f64).is_finite() && exp(-708.0f64) > 0.0 && exp(-87.0f32) > 0.0);
        assert!(exp(f32::NAN).is_nan() && exp(f64::NAN).is_nan());
        assert_eq!((exp(0.0f32), exp(-0.0f64)), (1.0, 1.0));
    }
}
