//! Errors of few samples, eight pixels at a time.

use crate::backend::block_product::interpolation::NODES;
use crate::backend::block_product::samples::above;
use crate::backend::block_product::tiles::{Eight, TILE};
use crate::scene::Kernel;

/// A number of each of eight pixels.
pub(super) type Lanes = [f32; TILE];

/// Eights of pixels of the largest probe.
pub(super) const MOST: usize = 32;

/// Every fourth pixel or so of a block and its nodes, eight by eight, about its centre on +z.
#[derive(Debug, Clone)]
pub(super) struct Probe {
    pub(super) pixels: Vec<Eight<3>>,
    /// The nodes of 1, 4 and 16 samples; the last lanes repeat the last.
    pub(super) nodes: [Eight<3>; NODES.div_ceil(TILE)],
    /// [eight pixels][node] of 4 and 16 samples.
    pub(super) four: Vec<[Lanes; 4]>,
    pub(super) sixteen: Vec<[Lanes; 16]>,
    pub(super) radius: f64,
}

/// Σ e², Σ e and Σ |e| of 0, 1, 4 and 16 samples over the probed pixels of a block that are above the horizon, each the
/// largest of all channels. The normal is +z.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    pub(super) squares: [f32; 4],
    pub(super) signed: [f32; 4],
    pub(super) sizes: [f32; 4],
}

impl Sums {
    #[inline(always)]
    fn set(&mut self, k: usize, [squares, signed, sizes]: [f32; 3]) {
        self.squares[k] = larger(self.squares[k], squares);
        self.signed[k] = larger(self.signed[k], signed.abs());
        self.sizes[k] = larger(self.sizes[k], sizes);
    }
}

/// The sums for a block whose centre is where `turn`, row by row, takes +z.
#[inline(always)]
pub(super) fn sums<const N: usize, K: Kernel<N>>(kernel: K, turn: &[[f32; 3]; 3], probe: &Probe) -> Sums {
    let mut nodes = [[0.0_f32; NODES.next_multiple_of(TILE)]; N];
    for (k, node) in probe.nodes.iter().enumerate() {
        let values = shade(kernel, &turned(turn, node));
        (0..N).for_each(|c| nodes[c][k * TILE..][..TILE].copy_from_slice(&values[c]));
    }
    if K::APART {
        let [x, y, z] = turned(turn, &probe.nodes[0]);
        let values = kernel.at([x[0], y[0], z[0]], above(z[0]), 1.0);
        (0..N).for_each(|c| nodes[c][0] = values[c]);
    }
    let mut values = [[[0.0_f32; TILE]; MOST]; N];
    let mut mask = [[0.0_f32; TILE]; MOST];
    // What a single sample is multiplied with at each pixel.
    let mut first = [[[1.0_f32; TILE]; 1]; MOST];
    for (g, pixels) in probe.pixels.iter().enumerate() {
        let d = turned(turn, pixels);
        let shaded = shade(kernel, &d);
        (0..N).for_each(|c| values[c][g] = shaded[c]);
        for lane in 0..TILE {
            mask[g][lane] = if d[2][lane] > 0.0 { 1.0 } else { 0.0 };
        }
        if K::APART {
            first[g][0] = d[2];
        }
    }
    let (count, mut all) = (probe.pixels.len(), Sums::default());
    for c in 0..N {
        let (values, nodes) = (&values[c][..count], &nodes[c]);
        all.set(0, level::<0>(values, &mask, &[], &[[]; MOST]));
        all.set(1, level::<1>(values, &mask, &[nodes[0]], &first));
        all.set(2, level::<4>(values, &mask, nodes[1..].first_chunk().expect("24 nodes"), &probe.four));
        all.set(3, level::<16>(values, &mask, nodes[5..].first_chunk().expect("24 nodes"), &probe.sixteen));
    }
    all
}

/// The sums of one channel and number of samples.
#[inline(always)]
fn level<const COUNT: usize>(
    values: &[Lanes],
    mask: &[Lanes],
    nodes: &[f32; COUNT],
    cardinals: &[[Lanes; COUNT]],
) -> [f32; 3] {
    let (mut squares, mut signed, mut sizes) = ([0.0; TILE], [0.0; TILE], [0.0; TILE]);
    for ((values, mask), cardinals) in values.iter().zip(mask).zip(cardinals) {
        let mut error = *values;
        for node in 0..COUNT {
            for lane in 0..TILE {
                error[lane] -= nodes[node] * cardinals[node][lane];
            }
        }
        for lane in 0..TILE {
            let error = error[lane] * mask[lane];
            squares[lane] += error * error;
            signed[lane] += error;
            sizes[lane] += error.abs();
        }
    }
    totals(&[squares, signed, sizes])
}

// Not inlined: seen together with the loop, sums of single lanes make the compiler keep all lanes apart.
#[inline(never)]
fn totals(lanes: &[Lanes; 3]) -> [f32; 3] {
    lanes.map(|lanes| lanes.iter().sum())
}

/// The larger, or infinity for what is not a number: no number of samples is enough for that.
#[inline(always)]
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if b.is_nan() { f32::INFINITY } else { a.max(b) }
}

#[inline(always)]
fn shade<const N: usize, K: Kernel<N>>(kernel: K, [x, y, z]: &Eight<3>) -> Eight<N> {
    let mut values = [[0.0_f32; TILE]; N];
    for lane in 0..TILE {
        let value = kernel.at([x[lane], y[lane], z[lane]], above(z[lane]), z[lane]);
        for c in 0..N {
            values[c][lane] = value[c];
        }
    }
    values
}

#[inline(always)]
fn turned(turn: &[[f32; 3]; 3], [x, y, z]: &Eight<3>) -> Eight<3> {
    let mut to = [[0.0; TILE]; 3];
    for axis in 0..3 {
        let row = turn[axis];
        for lane in 0..TILE {
            to[axis][lane] = row[0] * x[lane] + row[1] * y[lane] + row[2] * z[lane];
        }
    }
    to
}
