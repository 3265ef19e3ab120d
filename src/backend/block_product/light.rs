//! The light of a frame in the forms that the cases of a block read.

use nalgebra::Vector3;

use super::bounds::Norms;
use super::interpolation::{Basis, Interpolation};
use super::layout::BlockLayout;
use super::suffix::{Lanes, NodeSums};
use super::tables::{Eight, GROUP};
use crate::sphere::{CubeGrid, CubeMap};
use crate::{Error, Result};

/// Radiance × solid angle of every texel, in three forms a block [Inger 2013, §4.3], for blocks along the paths of a layout:
///
/// | form | what for | bytes a texel |
/// |---|---|---|
/// | weights of 1, 4 and 16 samples | nothing hidden | 1 |
/// | suffix sums of light × each of the four cardinal functions | partly hidden, BRDF of 1 or 4 samples | 48 |
/// | suffix sums of light × direction | partly hidden or not, cosine: exact | 36 |
/// | texels | anything | 12 |
///
/// A cosine is linear in direction, so that Σ L V n·ω = n · Σ L V ω: a diffuse surface needs no sample and no horizon.
#[derive(Debug, Clone)]
pub struct LightForms {
    layout: BlockLayout,
    interpolation: Interpolation,
    /// Solid angle and direction of each place, [block][place].
    omega: Vec<[f64; 4]>,
    /// Row-major pixel of each place.
    pixels: Vec<u32>,
    /// [block][node of 1, 4, 16] R, then G, then B.
    pub(super) weights: [Vec<f32>; 3],
    /// [block][place]
    pub(super) nodes: Vec<NodeSums>,
    /// [block][place] x, y, z for R, for G, x and y for B
    pub(super) moments: Vec<Lanes>,
    /// [block][place] z for B
    pub(super) ninths: Vec<f32>,
    /// [block][group of eight places] R, G, B
    pub(super) texels: Vec<Eight<3>>,
    /// [block]
    pub(super) norms: Vec<Norms>,
    /// Σ L Ω / 4π of the brightest channel.
    pub(super) mean: f64,
    is_dark: bool,
}

/// Nodes of all levels.
pub(super) const NODES: usize = 1 + 4 + 16;

impl LightForms {
    /// Darkness.
    ///
    /// # Errors
    /// None for a layout that exists; those of the transforms' plans.
    pub fn new(layout: &BlockLayout, basis: Basis) -> Result<Self> {
        let interpolation = Interpolation::new(layout.side(), basis)?;
        let (grid, len) = (layout.grid(), layout.grid().len());
        let solid_angles = grid.face_solid_angles();
        let omega = (0..layout.blocks())
            .flat_map(|block| layout.texels(block))
            .map(|&texel| {
                let d = grid.direction(texel as usize);
                [solid_angles[texel as usize % grid.face_len()], d.x, d.y, d.z]
            })
            .collect();
        Ok(Self {
            omega,
            pixels: layout.scan().pixels().to_vec(),
            weights: [(); 3].map(|()| vec![0.0; layout.blocks() * NODES]),
            nodes: vec![[0.0; 12]; len],
            moments: vec![Lanes::default(); len],
            ninths: vec![0.0; len],
            texels: vec![[[0.0; GROUP]; 3]; len / GROUP],
            norms: vec![Norms::default(); layout.blocks()],
            mean: 0.0,
            is_dark: true,
            layout: layout.clone(),
            interpolation,
        })
    }

    /// The layout.
    pub fn layout(&self) -> &BlockLayout {
        &self.layout
    }

    /// The grid of the light.
    pub fn grid(&self) -> CubeGrid {
        self.layout.grid()
    }

    pub(super) fn interpolation(&self) -> &Interpolation {
        &self.interpolation
    }

    pub(super) fn is_dark(&self) -> bool {
        self.is_dark
    }

    /// Bytes of all forms.
    pub fn bytes(&self) -> usize {
        let weights: usize = self.weights.iter().map(|plane| size_of_val(&plane[..])).sum();
        let moments = size_of_val(&self.moments[..]) + size_of_val(&self.ninths[..]);
        weights + size_of_val(&self.texels[..]) + size_of_val(&self.nodes[..]) + moments
    }

    /// Weights of the 1, 4 and 16 samples of a block, of one channel.
    ///
    /// # Panics
    /// If `channel` > 2 or `block` is out of range.
    pub fn weights(&self, channel: usize, block: usize) -> &[f32] {
        &self.weights[channel][block * NODES..][..NODES]
    }

    /// Sets the light, radiance in linear RGB; a light that is refused leaves the one before.
    ///
    /// Sums are taken in `f64` and rounded once.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a light on another grid, [`Error::NotFinite`] for a texel that is NaN or infinite.
    pub fn set(&mut self, light: &CubeMap<Vector3<f32>>) -> Result<()> {
        if light.grid() != self.grid() {
            let got = light.grid().side() as f64;
            let what = "side of the light's cube map";
            return Err(Error::OutOfRange { what, got, allowed: "that of the transport" });
        }
        if let Some(index) = light.texels().iter().position(|t| !t.iter().all(|c| c.is_finite())) {
            return Err(Error::NotFinite { what: "texel of the light", index });
        }
        let len = self.layout.block_len();
        let mut pixels = [(); 3].map(|()| vec![0.0; len]);
        let mut total = [0.0; 3];
        for block in 0..self.layout.blocks() {
            self.set_block(block, light.texels(), &mut pixels);
            for (pixels, total) in pixels.iter().zip(&mut total) {
                *total += pixels.iter().map(|x| x.abs()).sum::<f64>();
            }
            self.norms[block] = pixels.iter().map(|p| Norms::new(p)).fold(Norms::default(), Norms::larger);
            self.set_weights(block, &pixels);
        }
        self.mean = total.into_iter().fold(0.0, f64::max) / (4.0 * std::f64::consts::PI);
        self.is_dark = self.mean == 0.0;
        Ok(())
    }

    /// Texels and suffix sums of a block; leaves radiance × solid angle in `pixels`, row after row.
    fn set_block(&mut self, block: usize, light: &[Vector3<f32>], pixels: &mut [Vec<f64>; 3]) {
        let len = self.layout.block_len();
        let range = block * len..(block + 1) * len;
        let cardinals = &self.interpolation.levels()[1].cardinals;
        let (mut nodes, mut moments) = ([0.0_f64; 12], [0.0_f64; 9]);
        let texels = self.layout.texels(block);
        let omega = &self.omega[range.clone()];
        for place in (0..len).rev() {
            let pixel = self.pixels[place] as usize;
            let radiance = light[texels[place] as usize];
            let [solid, x, y, z] = omega[place];
            let at = range.start + place;
            let four = [cardinals[0][pixel], cardinals[1][pixel], cardinals[2][pixel], cardinals[3][pixel]];
            for channel in 0..3 {
                let value = f64::from(radiance[channel]) * solid;
                pixels[channel][pixel] = value;
                self.texels[at / GROUP][channel][at % GROUP] = value as f32;
                for k in 0..4 {
                    nodes[4 * channel + k] += value * four[k];
                }
                for (k, axis) in [x, y, z].into_iter().enumerate() {
                    moments[3 * channel + k] += value * axis;
                }
            }
            self.nodes[at] = nodes.map(|x| x as f32);
            self.moments[at] = Lanes(std::array::from_fn(|k| moments[k] as f32));
            self.ninths[at] = moments[8] as f32;
        }
    }

    fn set_weights(&mut self, block: usize, pixels: &[Vec<f64>; 3]) {
        let cardinals = self.interpolation.levels().iter().flat_map(|level| &level.cardinals);
        for (node, cardinal) in cardinals.enumerate() {
            for (weights, pixels) in self.weights.iter_mut().zip(pixels) {
                weights[block * NODES + node] = dot(pixels, cardinal) as f32;
            }
        }
    }
}

/// Eight sums side by side, which vectorise.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (a.as_chunks::<8>().0, b.as_chunks::<8>().0);
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum()
}
