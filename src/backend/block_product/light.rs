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
    /// Radiance × solid angle of a block, row after row: R, G, B.
    rows: [Vec<f64>; 3],
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
            rows: [(); 3].map(|()| vec![0.0; layout.block_len()]),
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
        let total = self.total(light.texels());
        for block in 0..self.layout.blocks() {
            self.set_texels(block, light.texels());
            self.set_moments(block);
            self.set_norms(block, light.texels());
            self.set_nodes(block);
            self.set_weights(block);
        }
        self.mean = total.into_iter().fold(0.0, f64::max) / (4.0 * std::f64::consts::PI);
        self.is_dark = self.mean == 0.0;
        Ok(())
    }

    /// Σ |L| Ω of R, G and B.
    fn total(&self, light: &[Vector3<f32>]) -> [f64; 3] {
        let mut total = [0.0; 3];
        for (&texel, [solid, ..]) in self.layout.all_texels().iter().zip(&self.omega) {
            let radiance = light[texel as usize];
            for channel in 0..3 {
                total[channel] += f64::from(radiance[channel].abs()) * solid;
            }
        }
        total
    }

    /// The larger norms of R, G and B.
    fn set_norms(&mut self, block: usize, light: &[Vector3<f32>]) {
        let peak = self.layout.texels(block).iter().map(|&texel| light[texel as usize].amax()).fold(0.0, f32::max);
        let norms = self.rows.iter().map(|row| Norms::new(row, f64::from(peak)));
        self.norms[block] = norms.fold(Norms::default(), Norms::larger);
    }

    /// Texels of a block; leaves radiance × solid angle in the rows, row after row.
    fn set_texels(&mut self, block: usize, light: &[Vector3<f32>]) {
        let len = self.layout.block_len();
        let range = block * len..(block + 1) * len;
        let [r, g, b] = &mut self.rows;
        let places = self.layout.texels(block).iter().zip(&self.omega[range.clone()]).zip(&self.pixels);
        for (at, ((&texel, [solid, ..]), &pixel)) in range.zip(places) {
            let (radiance, pixel) = (light[texel as usize], pixel as usize);
            (r[pixel], g[pixel], b[pixel]) =
                (f64::from(radiance.x) * solid, f64::from(radiance.y) * solid, f64::from(radiance.z) * solid);
            let texels = &mut self.texels[at / GROUP];
            (texels[0][at % GROUP], texels[1][at % GROUP], texels[2][at % GROUP]) =
                (r[pixel] as f32, g[pixel] as f32, b[pixel] as f32);
        }
    }

    /// Suffix sums of the rows × directions.
    fn set_moments(&mut self, block: usize) {
        let len = self.layout.block_len();
        let range = block * len..(block + 1) * len;
        let [r, g, b] = &self.rows;
        let mut sums = [0.0_f64; 9];
        let places = self.omega[range.clone()].iter().zip(&self.pixels);
        let tables = self.moments[range.clone()].iter_mut().zip(&mut self.ninths[range]);
        for (([_, x, y, z], &pixel), (eight, ninth)) in places.zip(tables).rev() {
            let pixel = pixel as usize;
            let (r, g, b) = (r[pixel], g[pixel], b[pixel]);
            let terms = [r * x, r * y, r * z, g * x, g * y, g * z, b * x, b * y, b * z];
            for k in 0..9 {
                sums[k] += terms[k];
            }
            *eight = Lanes(std::array::from_fn(|k| sums[k] as f32));
            *ninth = sums[8] as f32;
        }
    }

    /// Suffix sums of the rows × cardinal functions.
    fn set_nodes(&mut self, block: usize) {
        let len = self.layout.block_len();
        let ([r, g, b], cardinals) = (&self.rows, &self.interpolation.levels()[1].cardinals);
        let mut sums = [0.0_f64; 12];
        for (row, &pixel) in self.nodes[block * len..][..len].iter_mut().zip(&self.pixels).rev() {
            let pixel = pixel as usize;
            for k in 0..4 {
                let cardinal = cardinals[k][pixel];
                sums[k] += r[pixel] * cardinal;
                sums[4 + k] += g[pixel] * cardinal;
                sums[8 + k] += b[pixel] * cardinal;
            }
            *row = sums.map(|x| x as f32);
        }
    }

    fn set_weights(&mut self, block: usize) {
        let cardinals = self.interpolation.levels().iter().flat_map(|level| &level.cardinals);
        for (node, cardinal) in cardinals.enumerate() {
            for (weights, row) in self.weights.iter_mut().zip(&self.rows) {
                weights[block * NODES + node] = dot(row, cardinal) as f32;
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
