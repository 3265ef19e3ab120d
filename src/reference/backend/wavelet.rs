//! Double and triple products of wavelets, coefficient by coefficient [Ng 2003, Ng 2004].
//!
//! A function on a cube map is six square faces, each with nonstandard Haar coefficients of its own; coefficient
//! `face · side² + flat index`. Which of them are kept is the caller's choice.

use super::super::haar::{forward_nonstandard, inverse_nonstandard};

/// The coefficients of a function on a cube map. O(side⁴).
///
/// # Panics
/// Unless `texels` are six square faces.
#[track_caller]
pub fn coefficients(texels: &[f64]) -> Vec<f64> {
    assert_eq!(texels.len() % 6, 0, "six faces");
    texels.chunks(texels.len() / 6).flat_map(forward_nonstandard).collect()
}

/// The texels of a function of which only the coefficients `kept` are left. O(side⁴).
///
/// # Panics
/// Unless `texels` are six square faces and every index is one of their coefficients.
#[track_caller]
pub fn thinned(texels: &[f64], kept: &[u32]) -> Vec<f64> {
    let all = coefficients(texels);
    let mut few = vec![0.0; all.len()];
    kept.iter().for_each(|&i| few[i as usize] = all[i as usize]);
    few.chunks(few.len() / 6).flat_map(inverse_nonstandard).collect()
}

/// Σ over the kept coefficients of light × transport, one channel.
/// ```math
/// radiance = Σ_i L_i T_i                                                                  [Ng 2003, eq. 5]
/// ```
/// Shapes: `light` radiance · side² · solid angle of every texel, `transport` visibility · brdf_cos.
///
/// # Panics
/// As [`thinned`].
#[track_caller]
pub fn double_product(light: &[f64], transport: &[f64], kept: &[u32]) -> f64 {
    let (light, transport) = (coefficients(light), coefficients(transport));
    kept.iter().map(|&i| light[i as usize] * transport[i as usize]).sum()
}

/// Σ over the faces of the mean of light × slice × visibility, one channel, with few coefficients of the first two.
/// ```math
/// radiance = Σ_ijk L_i B_j V_k C_ijk                                                      [Ng 2004, eq. 4]
/// ```
/// Shapes: `light` radiance · side² · solid angle of every texel, `slice` brdf_cos, `visible` a number a texel.
///
/// # Panics
/// As [`thinned`].
#[track_caller]
pub fn triple_product(
    (light, kept_of_light): (&[f64], &[u32]),
    (slice, kept_of_slice): (&[f64], &[u32]),
    visible: &[f64],
) -> f64 {
    let (light, slice) = (thinned(light, kept_of_light), thinned(slice, kept_of_slice));
    let face = (light.len() / 6) as f64;
    light.iter().zip(&slice).zip(visible).map(|((l, b), v)| l * b * v / face).sum()
}
