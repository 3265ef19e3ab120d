//! The light of a frame in the forms that the cases of a block read.

use nalgebra::Vector3;

use super::bounds::Norms;
use super::interpolation::{Interpolation, NODES, SampleBasis};
use super::layout::BlockLayout;
use super::suffix::{Lanes, NodeSums};
use super::tiles::{Eight, TILE, Tiles};
use crate::Result;
use crate::sphere::{CubeGrid, CubeMap};

/// Radiance × solid angle of every texel, in three forms a block [Inger 2013, §4.3], for blocks along both paths of a
/// layout:
///
/// | form | what for | bytes a texel |
/// |---|---|---|
/// | weights of 1, 4 and 16 samples | nothing hidden | 1 |
/// | suffix sums of light × each of the four cardinal functions | partly hidden, BRDF of 1 or 4 samples | 48 × 2 |
/// | suffix sums of light × direction | partly hidden or not, cosine: exact | 36 × 2 |
/// | texels | anything | 12 |
///
/// A cosine is linear in direction, so that Σ L V n·ω = n · Σ L V ω: a diffuse surface needs no sample and no horizon.
#[derive(Debug, Clone)]
pub struct LightForms {
    layout: BlockLayout,
    interpolation: Interpolation,
    /// [block][pixel]: flat texel, solid angle and direction.
    texel: Vec<u32>,
    omega: Vec<[f64; 4]>,
    /// [block][node of 1, 4, 16] R, then G, then B.
    pub(super) weights: [Vec<f32>; 3],
    /// [course][place]
    pub(super) nodes: Vec<NodeSums>,
    /// [course][place] x, y, z for R, for G, x and y for B
    pub(super) moments: Vec<Lanes>,
    /// [course][place] z for B
    pub(super) ninths: Vec<f32>,
    tiles: Tiles,
    /// [block][tile] R, G, B
    pub(super) texels: Vec<Eight<3>>,
    /// [block]
    pub(super) norms: Vec<Norms>,
    /// Radiance × solid angle of a block, row after row: R, G, B.
    rows: [Vec<f64>; 3],
    /// Σ L Ω / 4π of the brightest channel, over the scale.
    pub(super) mean: f64,
    /// A power of two: what sums over the forms are to be multiplied with.
    pub(super) scale: f64,
    is_dark: bool,
}

/// Lights whose largest radiance is not between these powers of two are scaled until it is: below, radiance × solid
/// angle would be denormal; above, sums in `f32` could overflow although what comes of them fits.
const ORDINARY: std::ops::RangeInclusive<i32> = -40..=90;

/// The power of two that makes a light ordinary.
fn scale(largest: f32) -> f64 {
    let power = f64::from(largest).log2().floor() as i32;
    f64::from(power.clamp(*ORDINARY.start(), *ORDINARY.end()) - power).exp2()
}

impl LightForms {
    /// Darkness.
    ///
    /// # Errors
    /// None for a layout that exists; those of the transforms' plans.
    pub fn new(layout: &BlockLayout, basis: SampleBasis) -> Result<Self> {
        let interpolation = Interpolation::new(layout.side(), basis)?;
        let (grid, len) = (layout.grid(), layout.grid().len());
        let solid_angles = grid.face_solid_angles();
        let texel: Vec<u32> = (0..layout.blocks())
            .flat_map(|block| (0..layout.block_len()).map(move |pixel| layout.texel(block, pixel) as u32))
            .collect();
        let omega = |&texel: &u32| {
            let d = grid.direction(texel as usize);
            [solid_angles[texel as usize % grid.face_len()], d.x, d.y, d.z]
        };
        Ok(Self {
            omega: texel.iter().map(omega).collect(),
            texel,
            weights: [(); 3].map(|()| vec![0.0; layout.blocks() * NODES]),
            nodes: vec![[0.0; 12]; 2 * len],
            moments: vec![Lanes::default(); 2 * len],
            ninths: vec![0.0; 2 * len],
            texels: vec![[[0.0; TILE]; 3]; len / TILE],
            norms: vec![Norms::default(); layout.blocks()],
            rows: [(); 3].map(|()| vec![0.0; layout.block_len()]),
            mean: 0.0,
            scale: 1.0,
            is_dark: true,
            tiles: Tiles::new(layout),
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

    #[inline(always)]
    pub(super) fn tiles(&self) -> &Tiles {
        &self.tiles
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

    /// What all forms are to be multiplied with: 1, or a power of two if the light's largest radiance is below 2⁻⁴⁰ or
    /// above 2⁹⁰.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Weights of the 1, 4 and 16 samples of a block, of one channel, over [`scale`](Self::scale).
    ///
    /// # Panics
    /// If `channel` > 2 or `block` is out of range.
    #[track_caller]
    pub fn weights(&self, channel: usize, block: usize) -> &[f32] {
        &self.weights[channel][block * NODES..][..NODES]
    }

    /// Sets the light, radiance in linear RGB; a light that is refused leaves the one before.
    ///
    /// Sums are taken in `f64` and rounded once. Any finite light will do: see [`scale`](Self::scale).
    ///
    /// # Errors
    /// [`Error::Length`](crate::Error::Length) for a light on another grid,
    /// [`Error::NotFinite`](crate::Error::NotFinite) for a texel that is NaN or infinite.
    pub fn set(&mut self, light: &CubeMap<Vector3<f32>>) -> Result<()> {
        light.check_light_on(self.grid())?;
        let largest = light.texels().iter().map(|texel| texel.amax()).fold(0.0, f32::max);
        let scale = if largest > 0.0 { scale(largest) } else { 1.0 };
        self.scale = 1.0 / scale;
        let mut total = [0.0; 3];
        for block in 0..self.layout.blocks() {
            self.set_rows(block, light.texels(), scale);
            self.set_texels(block);
            for path in 0..2 {
                self.set_moments(block, path);
                self.set_nodes(block, path);
            }
            self.set_weights(block);
            let sums = self.rows.each_ref().map(|row| row.iter().map(|x| x.abs()).sum::<f64>());
            total.iter_mut().zip(sums).for_each(|(total, sum)| *total += sum);
        }
        self.mean = total.into_iter().fold(0.0, f64::max) / (4.0 * std::f64::consts::PI);
        self.is_dark = self.mean == 0.0;
        Ok(())
    }

    /// Radiance × solid angle of a block, and its norms.
    fn set_rows(&mut self, block: usize, light: &[Vector3<f32>], scale: f64) {
        let len = self.layout.block_len();
        let [r, g, b] = &mut self.rows;
        let mut peak = 0.0_f64;
        let texels = self.texel[block * len..].iter().zip(&self.omega[block * len..]);
        for (((&texel, [solid, ..]), r), (g, b)) in texels.zip(r).zip(g.iter_mut().zip(b)) {
            let radiance = light[texel as usize].cast::<f64>() * scale;
            (*r, *g, *b) = (radiance.x * solid, radiance.y * solid, radiance.z * solid);
            peak = peak.max(radiance.amax());
        }
        let norms = self.rows.iter().map(|row| Norms::new(row, peak));
        self.norms[block] = norms.fold(Norms::default(), Norms::larger);
    }

    /// The rows in tiles.
    fn set_texels(&mut self, block: usize) {
        let tiles = self.layout.block_len() / TILE;
        let pixels = self.tiles.pixels().chunks_exact(TILE);
        for (eight, pixels) in self.texels[block * tiles..][..tiles].iter_mut().zip(pixels) {
            for (texels, row) in eight.iter_mut().zip(&self.rows) {
                texels.iter_mut().zip(pixels).for_each(|(texel, &pixel)| *texel = row[pixel as usize] as f32);
            }
        }
    }

    /// Suffix sums of the rows × directions.
    fn set_moments(&mut self, block: usize, path: usize) {
        let len = self.layout.block_len();
        let first = (path * self.layout.blocks() + block) * len;
        let ([r, g, b], omega) = (&self.rows, &self.omega[block * len..][..len]);
        let mut sums = [0.0_f64; 9];
        let tables = self.moments[first..][..len].iter_mut().zip(&mut self.ninths[first..][..len]);
        for (&pixel, (eight, ninth)) in self.layout.scans()[path].pixels().iter().zip(tables).rev() {
            let pixel = pixel as usize;
            let ([_, x, y, z], r, g, b) = (omega[pixel], r[pixel], g[pixel], b[pixel]);
            let terms = [r * x, r * y, r * z, g * x, g * y, g * z, b * x, b * y, b * z];
            for k in 0..9 {
                sums[k] += terms[k];
            }
            *eight = Lanes(std::array::from_fn(|k| sums[k] as f32));
            *ninth = sums[8] as f32;
        }
    }

    /// Suffix sums of the rows × cardinal functions.
    fn set_nodes(&mut self, block: usize, path: usize) {
        let len = self.layout.block_len();
        let first = (path * self.layout.blocks() + block) * len;
        let ([r, g, b], cardinals) = (&self.rows, &self.interpolation.levels()[1].cardinals);
        let mut sums = [0.0_f64; 12];
        let rows = self.nodes[first..][..len].iter_mut();
        for (&pixel, row) in self.layout.scans()[path].pixels().iter().zip(rows).rev() {
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
