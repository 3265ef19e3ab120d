//! 16-bit floats (IEEE 754 binary16): 1 sign bit, 5 exponent bits, 10 fraction bits.

/// 2¹¹²: what takes a half's exponent, in the place of a float's, to the float's bias (127 − 15 = 112).
const REBIAS: f32 = f32::from_bits((127 + 112) << 23);

/// The value of a half; exact. Infinities and NaN stay what they are.
pub(super) fn to_f32(half: u16) -> f32 {
    let sign = u32::from(half & 0x8000) << 16;
    let magnitude = u32::from(half & 0x7fff) << 13;
    let bits = if magnitude >= 0x1f << 23 {
        magnitude | 0xff << 23
    } else {
        // Subnormals included: the product is exact and normalises them.
        (f32::from_bits(magnitude) * REBIAS).to_bits()
    };
    f32::from_bits(sign | bits)
}

/// The half nearest to a value, ties to even; beyond the largest half infinity.
pub(super) fn from_f32(value: f32) -> u16 {
    let sign = ((value.to_bits() >> 16) & 0x8000) as u16;
    let magnitude = value.abs();
    let half = if magnitude.is_nan() {
        0x7e00
    } else if magnitude >= 65520.0 {
        // Half-way between the largest half and what would be the next.
        0x7c00
    } else if magnitude < 1.0 / 16384.0 {
        // Below the smallest normal half the step is 2⁻²⁴; rounding up to 1024 steps gives that half's bits.
        (magnitude * 16777216.0).round_ties_even() as u16
    } else {
        let bits = magnitude.to_bits() - (112 << 23);
        ((bits + 0xfff + ((bits >> 13) & 1)) >> 13) as u16
    };
    sign | half
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition, in f64: (1 + fraction / 1024) · 2^(exponent − 15), without the 1 where the exponent is 0.
    fn value(half: u16) -> f64 {
        let (exponent, fraction) = (i32::from(half >> 10 & 31), f64::from(half & 1023) / 1024.0);
        let magnitude = match exponent {
            0 => fraction * 2f64.powi(-14),
            31 if fraction == 0.0 => f64::INFINITY,
            31 => f64::NAN,
            e => (1.0 + fraction) * 2f64.powi(e - 15),
        };
        if half & 0x8000 == 0 { magnitude } else { -magnitude }
    }

    #[test]
    fn every_half_is_exact_both_ways() {
        for half in 0..=u16::MAX {
            let (expected, got) = (value(half), to_f32(half));
            if expected.is_nan() {
                assert!(got.is_nan() && to_f32(from_f32(got)).is_nan(), "{half:#x}");
            } else {
                assert_eq!(f64::from(got), expected, "{half:#x}");
                assert_eq!(from_f32(got), half);
            }
        }
    }

    #[test]
    fn halves_round_to_nearest_even() {
        // Half-way between neighbours the even one, one float to either side the nearer one.
        for half in (0..0x7bff_u16).chain(0x8000..0xfbff) {
            let middle = ((value(half) + value(half + 1)) / 2.0) as f32;
            assert_eq!(from_f32(middle), half + (half & 1), "{half:#x}");
            let towards_zero = f32::from_bits(middle.to_bits() - 1);
            let away = f32::from_bits(middle.to_bits() + 1);
            assert_eq!((from_f32(towards_zero), from_f32(away)), (half, half + 1), "{half:#x}");
        }
        for (value, half) in [(65519.996, 0x7bff), (65520.0, 0x7c00), (f32::MAX, 0x7c00), (-f32::INFINITY, 0xfc00)] {
            assert_eq!(from_f32(value), half, "{value}");
        }
        assert_eq!(from_f32(f32::from_bits(1)), 0);
    }
}
