//! A light in the Haar basis of each face of its cube map.

use nalgebra::Vector3;

use super::{Decomposition, Keep, Selection, SparseVector, Transform2d, Weighting};
use crate::Result;
use crate::sphere::{CubeGrid, CubeMap};

/// Radiance weighted for product integrals, as texels and in the Haar basis of each face, three channels.
///
/// ```math
/// L'(texel) = L(texel) · side² · Ω(texel),  Σ_texels L V B Ω = Σ_faces mean(L' V B)
/// ```
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
    /// [`Error::NotPowerOfTwo`](crate::Error::NotPowerOfTwo) for a side that is none.
    pub fn new(grid: CubeGrid) -> Result<Self> {
        let transform = Transform2d::new(grid.side(), grid.side(), Decomposition::Nonstandard)?;
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
    /// [`Error::Length`](crate::Error::Length) for a light on another grid,
    /// [`Error::NotFinite`](crate::Error::NotFinite) for a texel that is NaN or infinite; the light from before stays.
    pub fn set(&mut self, light: &CubeMap<Vector3<f32>>) -> Result<()> {
        light.check_light_on(self.grid)?;
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
    #[track_caller]
    pub fn texels(&self, channel: usize) -> &[f32] {
        &self.texels[channel]
    }

    /// The coefficients of one channel: six faces of side² coefficients.
    ///
    /// # Panics
    /// If `channel` > 2.
    #[track_caller]
    pub fn coefficients(&self, channel: usize) -> &[f32] {
        &self.coefficients[channel]
    }

    /// The R, G and B of one coefficient; `index` = face · side² + flat index.
    ///
    /// # Panics
    /// If `index` is out of range.
    #[track_caller]
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
