//! The light of a frame in Haar wavelets.

use std::borrow::Cow;

use nalgebra::Vector3;

use crate::haar::{Keep, Selection, SparseVector, Transform2d, Weighting};
use crate::sphere::{CubeGrid, CubeMap};
use crate::{Error, Result};

/// A light brought to where sums of its wavelets stay finite and normal in `f32`, and the power of two that undoes it.
///
/// A coefficient of the transform is up to 4 · side times the largest texel, and is multiplied by 16-bit integers and
/// summed over all terms. Products with a power of two are exact (of what is 2¹²⁶ times darker than the brightest texel
/// bits are lost, far below the rounding of the sum). A light between 2⁻⁴⁰ and 2⁴⁰ stays as it is, and its results the
/// same bits.
pub(super) fn in_range(light: &CubeMap<Vector3<f32>>) -> (Cow<'_, CubeMap<Vector3<f32>>>, f64) {
    let largest = light.texels().iter().fold(0.0_f32, |m, t| m.max(t.amax()));
    // What is not finite is refused where the light is set.
    if largest == 0.0 || !largest.is_finite() || (2f32.powi(-40)..=2f32.powi(40)).contains(&largest) {
        return (Cow::Borrowed(light), 1.0);
    }
    // In f64 every f32 is normal: the exponent is in its bits.
    let exponent = (f64::from(largest).to_bits() >> 52) as i32 - 1023;
    let down = 2f64.powi(-exponent);
    (Cow::Owned(light.map(|t| t.map(|c| (f64::from(c) * down) as f32))), 2f64.powi(exponent))
}

/// Undoes [`in_range`] in what it has lit; beyond the largest `f32` is that.
pub(super) fn undo(factor: f64, radiance: &mut [Vector3<f32>]) {
    if factor != 1.0 {
        let limit = f64::from(f32::MAX);
        radiance.iter_mut().for_each(|l| l.apply(|c| *c = (f64::from(*c) * factor).clamp(-limit, limit) as f32));
    }
}

/// Radiance weighted for product integrals, as texels and in the Haar basis of each face, three channels.
///
///   L'(texel) = L(texel) · side² · Ω(texel),  Σ_texels L V B Ω = Σ_faces mean(L' V B)
///
/// It is not a radiance any more, hence the type of its own.
#[derive(Debug, Clone)]
pub struct ProjectedLight {
    grid: CubeGrid,
    transform: Transform2d<f32>,
    /// side² Ω of one face's texels.
    weights: Vec<f32>,
    texels: [Vec<f32>; 3],
    coefficients: [Vec<f32>; 3],
    scratch: Vec<f32>,
}

impl ProjectedLight {
    /// Darkness on a grid.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] for a side that is none.
    pub fn new(grid: CubeGrid) -> Result<Self> {
        let transform = super::face_transform(grid)?;
        let area = grid.face_len() as f64;
        let dark = || std::array::from_fn(|_| vec![0.0; grid.len()]);
        Ok(Self {
            grid,
            weights: grid.face_solid_angles().iter().map(|omega| (omega * area) as f32).collect(),
            texels: dark(),
            coefficients: dark(),
            scratch: vec![0.0; transform.scratch_len()],
            transform,
        })
    }

    /// Weights and transforms a light.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a light on another grid, [`Error::NotFinite`] for a texel that is NaN or infinite; the
    /// light from before stays.
    pub fn set(&mut self, light: &CubeMap<Vector3<f32>>) -> Result<()> {
        if light.grid() != self.grid {
            let got = light.grid().side() as f64;
            return Err(Error::OutOfRange {
                what: "side of the light's cube map",
                got,
                allowed: "that of the transport",
            });
        }
        if let Some(index) = light.texels().iter().position(|t| !t.iter().all(|c| c.is_finite())) {
            return Err(Error::NotFinite { what: "texel of the light", index });
        }
        for (channel, (texels, coefficients)) in self.texels.iter_mut().zip(&mut self.coefficients).enumerate() {
            let face = self.weights.len();
            for (out, texels) in texels.chunks_exact_mut(face).zip(light.texels().chunks_exact(face)) {
                for ((out, texel), weight) in out.iter_mut().zip(texels).zip(&self.weights) {
                    *out = texel[channel] * weight;
                }
            }
            self.transform.forward_batch(texels, coefficients, &mut self.scratch);
        }
        Ok(())
    }

    /// The grid.
    pub fn grid(&self) -> CubeGrid {
        self.grid
    }

    /// The weighted texels of one channel, in the grid's order.
    ///
    /// # Panics
    /// If `channel` > 2.
    pub fn texels(&self, channel: usize) -> &[f32] {
        &self.texels[channel]
    }

    /// The coefficients of one channel: six faces of side² coefficients.
    ///
    /// # Panics
    /// If `channel` > 2.
    pub fn coefficients(&self, channel: usize) -> &[f32] {
        &self.coefficients[channel]
    }

    /// The R, G and B of one coefficient; `index` = face · side² + flat index.
    ///
    /// # Panics
    /// If `index` is out of range.
    #[inline]
    pub fn coefficient(&self, index: usize) -> [f32; 3] {
        [self.coefficients[0][index], self.coefficients[1][index], self.coefficients[2][index]]
    }

    /// The kept coefficients of each channel, the same indices in all three: scaling functions always, then by weight.
    ///
    /// # Errors
    /// What [`Selection::apply_channels`] refuses.
    pub fn select(&self, keep: Keep, weighting: Weighting<'_, f32>) -> Result<[SparseVector<f32>; 3]> {
        let selection = Selection::new(keep).with_weighting(weighting).with_blocks_of(self.grid.face_len());
        selection.apply_channels(self.coefficients.each_ref().map(Vec::as_slice))
    }

    /// The weighted texels of a selection.
    pub fn texels_of(&self, kept: &[SparseVector<f32>; 3]) -> [Vec<f32>; 3] {
        let mut scratch = vec![0.0; self.transform.scratch_len()];
        kept.each_ref().map(|kept| {
            let mut texels = vec![0.0; self.grid.len()];
            self.transform.inverse_batch(&kept.to_dense(), &mut texels, &mut scratch);
            texels
        })
    }
}
