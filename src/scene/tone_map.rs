//! Linear radiance to the 8-bit sRGB of pictures.

use nalgebra::Vector3;

/// Exposure and the sRGB transfer function: for pictures to look at, never for measuring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToneMap {
    exposure: f32,
}

impl Default for ToneMap {
    /// Radiance 1 is white.
    fn default() -> Self {
        Self { exposure: 1.0 }
    }
}

impl ToneMap {
    /// Radiance is multiplied by `exposure`; what then exceeds 1 is white. A factor that is NaN or negative counts as
    /// 0.
    pub fn with_exposure(exposure: f32) -> Self {
        Self { exposure: exposure.max(0.0) }
    }

    /// An exposure that shows `peak` as white; 1 if `peak` is not a positive finite number.
    ///
    /// Give it [`percentile_peak`](crate::scene::percentile_peak) of the reference, and every picture of a comparison
    /// the same one.
    pub fn with_white(peak: f64) -> Self {
        let exposure = (1.0 / peak) as f32;
        Self { exposure: if peak > 0.0 && exposure.is_finite() && exposure > 0.0 { exposure } else { 1.0 } }
    }

    /// What radiance is multiplied by.
    pub fn exposure(self) -> f32 {
        self.exposure
    }

    /// The picture's bytes of one linear colour; negative and NaN channels are 0, infinite ones 255.
    ///
    /// # Example
    /// ```
    /// use haarmonic::{nalgebra::Vector3, scene::ToneMap};
    /// assert_eq!(ToneMap::default().apply(&Vector3::new(0.0, 0.214_041_14, 7.0)), [0, 128, 255]);
    /// ```
    #[inline]
    pub fn apply(self, linear: &Vector3<f32>) -> [u8; 3] {
        [0, 1, 2].map(|c| {
            // The cast makes 0 of NaN.
            (linear_to_srgb((linear[c] * self.exposure).clamp(0.0, 1.0)) * 255.0 + 0.5) as u8
        })
    }
}

/// The sRGB transfer function of a linear value in [0, 1]      [IEC 61966-2-1]
///
/// ```math
/// 12.92 x for x ≤ 0.0031308, else 1.055 x^{1/2.4} − 0.055
/// ```
#[inline]
pub fn linear_to_srgb(x: f32) -> f32 {
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`linear_to_srgb`]      [IEC 61966-2-1]
///
/// ```math
/// x / 12.92 for x ≤ 0.04045, else ((x + 0.055)/1.055)^2.4
/// ```
#[inline]
pub fn srgb_to_linear(x: f32) -> f32 {
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_survives_the_round_trip() {
        for byte in 0..=255u8 {
            let linear = srgb_to_linear(f32::from(byte) / 255.0);
            assert_eq!(ToneMap::default().apply(&Vector3::repeat(linear)), [byte; 3]);
        }
    }

    #[test]
    fn published_values_of_the_transfer_function() {
        // The two branches meet at 0.04045, and mid-grey 0.5 is 0.21404 linear.
        assert!((linear_to_srgb(0.003_130_8) - 0.040_449_94).abs() < 1e-7);
        assert!((srgb_to_linear(0.5) - 0.214_041_14).abs() < 1e-7);
        assert!((linear_to_srgb(1.0) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn values_outside_the_range_are_clamped() {
        let map = ToneMap::default();
        assert_eq!(map.apply(&Vector3::new(-1.0, f32::NAN, f32::INFINITY)), [0, 0, 255]);
        assert_eq!(map.apply(&Vector3::new(f32::NEG_INFINITY, 1.0, 1e30)), [0, 255, 255]);
    }

    #[test]
    fn the_peak_becomes_white_and_a_useless_peak_changes_nothing() {
        assert_eq!(ToneMap::with_white(4.0).apply(&Vector3::repeat(4.0)), [255; 3]);
        assert_eq!(ToneMap::with_exposure(0.5).apply(&Vector3::repeat(2.0)), [255; 3]);
        for peak in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-300] {
            assert_eq!(ToneMap::with_white(peak), ToneMap::default(), "peak {peak}");
        }
        assert_eq!(ToneMap::with_exposure(f32::NAN).exposure(), 0.0);
    }
}
