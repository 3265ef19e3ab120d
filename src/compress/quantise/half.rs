//! IEEE 754 binary16: 1 sign bit, 5 of exponent, 10 of fraction.

use super::super::distortion::Distortion;
use crate::error::check_length;
use crate::{Error, Real, Result, parallel};

/// The number of binary16 nearest to `x`, as its bits; halfway between two the one with an even last bit.
///
/// From 65520 on infinity; below 2^−14 in steps of 2^−24 (subnormals), to ±0 at 2^−25; NaN gives a quiet NaN of the
/// same sign. `f64` is rounded once, not by way of `f32`.
///
/// # Example
/// ```
/// use haarmonic::compress::{half_to_real, real_to_half};
/// assert_eq!(real_to_half(1.0f32), 0x3c00);
/// assert_eq!(half_to_real::<f32>(real_to_half(1.0 / 3.0f64)), 0.33325195);
/// ```
#[inline]
pub fn real_to_half<T: Real>(x: T) -> u16 {
    const FRACTION: u64 = 52;
    let bits = x.widen().to_bits();
    let sign = ((bits >> 48) & 0x8000) as u16;
    let magnitude = bits & (u64::MAX >> 1);
    if magnitude > f64::INFINITY.to_bits() {
        return sign | 0x7e00;
    }
    if magnitude >= 65520f64.to_bits() {
        return sign | 0x7c00;
    }
    let exponent = (magnitude >> FRACTION) as i64 - 1023;
    if exponent < -25 {
        return sign;
    }
    // Places that are cut off: 42 of a normal number, one more for each power of two below 2^-14.
    let cut = 42 + (-14 - exponent).max(0) as u64;
    let significand = magnitude & ((1 << FRACTION) - 1) | 1 << FRACTION;
    let half = 1 << (cut - 1);
    let rounded = (significand + half - 1 + (significand >> cut & 1)) >> cut;
    // The leading 1 of a normal number adds 1 to the exponent, and so does a carry; a subnormal has neither unless it
    // becomes normal.
    sign | ((((exponent.max(-14) + 14) as u64) << 10) + rounded) as u16
}

/// What the bits of a binary16 stand for: exact.
#[inline]
pub fn half_to_real<T: Real>(bits: u16) -> T {
    let (exponent, fraction) = (u32::from(bits >> 10 & 31), u32::from(bits & 1023));
    let magnitude = match exponent {
        0 => fraction as f32 / (1 << 24) as f32,
        31 => f32::from_bits(0x7f80_0000 | fraction << 13),
        _ => f32::from_bits((exponent + 112) << 23 | fraction << 13),
    };
    T::of(f64::from(if bits >> 15 == 1 { -magnitude } else { magnitude }))
}

/// Numbers as binary16, each off by at most 2^−11 of itself (2^−25 below 2^−14).
#[derive(Debug, Clone, PartialEq)]
pub struct QuantisedHalf {
    bits: Vec<u16>,
    distortion: Distortion,
}

impl QuantisedHalf {
    /// Rounds any numbers; none is allowed.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for NaN and infinity; [`Error::OutOfRange`] from 65520 on, which would round to infinity.
    pub fn new<T: Real>(values: &[T]) -> Result<Self> {
        if let Some(index) = values.iter().position(|x| !x.is_finite()) {
            return Err(Error::NotFinite { what: "number", index });
        }
        if let Some(x) = values.iter().find(|x| x.widen().abs() >= 65520.0) {
            return Err(Error::OutOfRange { what: "number", got: x.widen(), allowed: "below 65520 in magnitude" });
        }
        let mut bits = vec![0; values.len()];
        parallel::rows(&mut bits, 1, 4096, |i, bits| bits[0] = real_to_half(values[i]));
        let distortion = Distortion::of_rows(values, 1, |first, _, out| {
            out.iter_mut().zip(&bits[first..]).for_each(|(out, &bits)| *out = half_to_real(bits));
        });
        Ok(Self { bits, distortion })
    }

    /// From the bits of numbers, and how far rounding moved them (the default, if that is not known): for those that
    /// were stored.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the bits of NaN and infinity, [`Error::OutOfRange`] for a distortion that is NaN or
    /// below 0.
    pub fn from_parts(bits: Vec<u16>, distortion: Distortion) -> Result<Self> {
        distortion.check()?;
        match bits.iter().position(|bits| bits >> 10 & 31 == 31) {
            Some(index) => Err(Error::NotFinite { what: "number", index }),
            None => Ok(Self { bits, distortion }),
        }
    }

    /// The numbers' bits.
    #[inline]
    pub fn bits(&self) -> &[u16] {
        &self.bits
    }

    /// The rounded numbers.
    ///
    /// # Panics
    /// If `out` has another length.
    #[track_caller]
    pub fn decode<T: Real>(&self, out: &mut [T]) {
        check_length("numbers", self.bits.len(), out.len());
        parallel::rows(out, 1, 4096, |i, out| out[0] = half_to_real(self.bits[i]));
    }

    /// How far rounding moved the numbers.
    #[inline]
    pub fn distortion(&self) -> Distortion {
        self.distortion
    }

    /// The bytes in memory: 2 for each number.
    #[inline]
    pub fn bytes(&self) -> usize {
        2 * self.bits.len()
    }
}
