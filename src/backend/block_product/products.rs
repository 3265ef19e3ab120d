//! The sums of one vertex: algorithm 1 [Inger 2013] for one lobe, and the cosine of all lobes together.

use super::light::{LightForms, NODES, Record};
use super::samples::{Planes, Samples, sum};
use super::tables::Directions;
use super::visible::Visible;
use crate::compress::MapState;
use crate::scene::Kernel;

/// From how many places on a run is summed where it lies instead of being copied to the list.
const LONG_RUN: usize = 48;
/// Places copied at a time.
const PIECE: usize = 256;

/// Σ L V ω of a few vertices, block by block: a block's sums stay in the first cache while all vertices look them up.
pub(super) struct Moments<'a, V> {
    pub(super) maps: &'a V,
    pub(super) light: &'a LightForms,
    pub(super) first: usize,
    pub(super) sums: &'a mut [Record],
}

impl<V: Visible> pulp::WithSimd for Moments<'_, V> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let (blocks, len) = (self.light.layout().blocks(), self.light.layout().block_len());
        for (block, table) in self.light.moments.chunks_exact(len).enumerate() {
            for (i, sum) in self.sums.iter_mut().enumerate() {
                self.maps.add((self.first + i) * blocks + block, table, sum);
            }
        }
    }
}

/// Σ L V ρ cos of one vertex and lobe.
pub(super) struct LobeSum<'a, const N: usize, K, V> {
    pub(super) kernel: K,
    pub(super) normal: [f32; 3],
    pub(super) maps: &'a V,
    /// The vertex's map of block 0.
    pub(super) first: usize,
    /// Blocks that are not hidden.
    pub(super) live: &'a [u16],
    /// Samples of each block: none, 1, 4, 16, pixels.
    pub(super) classes: &'a [u8],
    pub(super) light: &'a LightForms,
    pub(super) directions: &'a Directions,
    pub(super) samples: &'a mut Samples,
}

impl<const N: usize, K: Kernel<N>, V: Visible> pulp::WithSimd for LobeSum<'_, N, K, V> {
    type Output = [f64; 3];

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) -> [f64; 3] {
        let mut total = [0.0; 3];
        for &block in self.live {
            let block = usize::from(block);
            let class = self.classes[block];
            if class == 0 {
                continue;
            }
            if !self.samples.has_room(PIECE) {
                add(&mut total, self.samples.drain(self.kernel, self.normal));
            }
            match (class, self.maps.state(self.first + block)) {
                (1, MapState::AllOne) => self.coefficients::<1>(block, 0),
                (2, MapState::AllOne) => self.coefficients::<4>(block, 1),
                (3, MapState::AllOne) => self.coefficients::<16>(block, 5),
                (1 | 2, _) => self.sums(block, class == 1),
                _ => self.pixels(block, &mut total),
            }
        }
        add(&mut total, self.samples.drain(self.kernel, self.normal));
        total
    }
}

impl<const N: usize, K: Kernel<N>, V: Visible> LobeSum<'_, N, K, V> {
    /// Line 6: N samples, weighted with the light of the whole block.
    #[inline(always)]
    fn coefficients<const M: usize>(&mut self, block: usize, level: usize) {
        let at = block * NODES + level;
        let ([x, y, z], [r, g, b]) = (&self.directions.nodes, &self.light.weights);
        let from =
            [x, y, z, r, g, b].map(|plane| plane[at..].first_chunk::<M>().expect("tables have all nodes of a block"));
        self.samples.push(from);
    }

    /// Line 9: one sample or four, weighted with the light that is not hidden.
    #[inline(always)]
    fn sums(&mut self, block: usize, constant: bool) {
        let len = self.light.layout().block_len();
        let mut record = [0.0; 12];
        self.maps.add(self.first + block, &self.light.nodes[block * len..][..len], &mut record);
        let weights: [&[f32; 4]; 3] =
            [0, 4, 8].map(|k| record[k..].first_chunk().expect("a record has twelve numbers"));
        let [x, y, z] = &self.directions.nodes;
        if constant {
            let at = block * NODES;
            let [r, g, b] = weights.map(|w| [w[0] + w[1] + w[2] + w[3]]);
            self.samples.push([&[x[at]], &[y[at]], &[z[at]], &r, &g, &b]);
        } else {
            let [x, y, z] =
                [x, y, z].map(|plane| plane[block * NODES + 1..].first_chunk().expect("tables have all nodes"));
            self.samples.push([x, y, z, weights[0], weights[1], weights[2]]);
        }
    }

    /// Line 11: every pixel that is not hidden.
    #[inline(always)]
    fn pixels(&mut self, block: usize, total: &mut [f64; 3]) {
        let first = block * self.light.layout().block_len();
        let mut index = 0;
        while let Some((run, level)) = self.maps.run(self.first + block, index) {
            index += 1;
            if level == 1.0 && run.len() >= LONG_RUN {
                add(
                    total,
                    sum(
                        self.kernel,
                        self.normal,
                        planes(self.light, self.directions, first + run.start, first + run.end),
                    ),
                );
            } else if level > 0.0 {
                for from in run.clone().step_by(PIECE) {
                    let to = run.end.min(from + PIECE);
                    if !self.samples.has_room(to - from) {
                        add(total, self.samples.drain(self.kernel, self.normal));
                    }
                    let (light, directions) = (self.light, self.directions);
                    self.samples.extend(planes(light, directions, first + from, first + to), level);
                }
            }
        }
    }
}

#[inline(always)]
fn add(total: &mut [f64; 3], part: [f64; 3]) {
    total.iter_mut().zip(part).for_each(|(total, part)| *total += part);
}

/// Directions and light of places.
#[inline(always)]
fn planes<'a>(light: &'a LightForms, directions: &'a Directions, start: usize, end: usize) -> Planes<'a> {
    let ([x, y, z], [r, g, b]) = (&directions.pixels, &light.texels);
    [&x[start..end], &y[start..end], &z[start..end], &r[start..end], &g[start..end], &b[start..end]]
}
