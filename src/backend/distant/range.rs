//! Lights within the range of sums in `f32`.

use std::borrow::Cow;

use nalgebra::Vector3;

use crate::sphere::CubeMap;

/// A light brought to where sums of its wavelets stay finite and normal in `f32`, and the power of two that undoes it.
///
/// A coefficient of the transform is up to 4 · side times the largest texel, and is multiplied by 16-bit integers and
/// summed over all terms. Products with a power of two are exact (of what is 2¹²⁶ times darker than the brightest texel
/// bits are lost, far below the rounding of the sum). A light between 2⁻⁴⁰ and 2⁴⁰ stays as it is, and its results the
/// same bits.
pub(in crate::backend) fn in_range(light: &CubeMap<Vector3<f32>>) -> (Cow<'_, CubeMap<Vector3<f32>>>, f64) {
    let largest = light.texels().iter().fold(0.0_f32, |m, t| m.max(t.amax()));
    let Some([down, up]) = factors(largest) else { return (Cow::Borrowed(light), 1.0) };
    (Cow::Owned(light.map(|t| t.map(|c| (f64::from(c) * down) as f32))), up)
}

/// The power of two that brings numbers of this largest magnitude to near 1, and its reciprocal; none where they may
/// stay as they are, or are not finite: what that is of is refused where the light is set.
pub(in crate::backend) fn factors(largest: f32) -> Option<[f64; 2]> {
    if largest == 0.0 || !largest.is_finite() || (2f32.powi(-40)..=2f32.powi(40)).contains(&largest) {
        return None;
    }
    // In f64 every f32 is normal: the exponent is in its bits.
    let exponent = (f64::from(largest).to_bits() >> 52) as i32 - 1023;
    Some([-exponent, exponent].map(|e| 2f64.powi(e)))
}

/// Undoes [`in_range`] in what it has lit; beyond the largest `f32` is that.
pub(in crate::backend) fn undo(factor: f64, radiance: &mut [Vector3<f32>]) {
    if factor != 1.0 {
        let limit = f64::from(f32::MAX);
        radiance.iter_mut().for_each(|l| l.apply(|c| *c = (f64::from(*c) * factor).clamp(-limit, limit) as f32));
    }
}
