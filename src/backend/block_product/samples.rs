//! Sums of reflectance × weights over directions.

use super::tiles::{Eight, TILE};
use crate::scene::Kernel;

/// Directions and RGB weights, structure of arrays.
#[derive(Debug, Clone)]
pub(super) struct Samples {
    /// x, y, z, R, G, B.
    planes: [Vec<f32>; 6],
    len: usize,
}

/// Samples that a list holds before it is summed up.
const CAPACITY: usize = 1024;

impl Samples {
    pub(super) fn new() -> Self {
        // Directions of lanes past the end are summed with weight 0: any finite numbers do.
        Self { planes: [(); 6].map(|()| vec![0.0; CAPACITY + TILE]), len: 0 }
    }

    /// Whether `more` samples fit; if not, sum up first.
    #[inline(always)]
    pub(super) fn has_room(&self, more: usize) -> bool {
        self.len + more <= CAPACITY
    }

    /// Appends N samples.
    #[inline(always)]
    pub(super) fn push<const N: usize>(&mut self, from: [&[f32; N]; 6]) {
        for (plane, from) in self.planes.iter_mut().zip(from) {
            plane[self.len..self.len + N].copy_from_slice(from);
        }
        self.len += N;
    }

    /// Σ reflectance × weights of the list, which is empty then: eight running sums in `f32` of at most 128 terms each,
    /// then `f64`.
    #[inline(always)]
    pub(super) fn drain<const N: usize, K: Kernel<N>>(&mut self, kernel: K, normal: [f32; 3]) -> [f64; 3] {
        let len = self.len.next_multiple_of(TILE);
        for plane in &mut self.planes[3..] {
            plane[self.len..len].fill(0.0);
        }
        self.len = 0;
        let mut sums = Sums::default();
        let eight = |plane: usize, at: usize| -> &[f32; TILE] {
            self.planes[plane][at..].first_chunk().expect("planes are longer than any list")
        };
        for at in (0..len).step_by(TILE) {
            let values = reflect(kernel, normal, &[*eight(0, at), *eight(1, at), *eight(2, at)]);
            sums.add(&values, [eight(3, at), eight(4, at), eight(5, at)]);
        }
        sums.total()
    }
}

/// Eight running sums of each channel.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    r: [f32; TILE],
    g: [f32; TILE],
    b: [f32; TILE],
}

impl Sums {
    /// Adds values × weights, one plane of values for all channels or one each.
    #[inline(always)]
    pub(super) fn add<const N: usize>(&mut self, values: &Eight<N>, weights: [&[f32; TILE]; 3]) {
        let add = |sum: &mut [f32; TILE], a: &[f32; TILE], b: &[f32; TILE]| {
            for lane in 0..TILE {
                sum[lane] += a[lane] * b[lane];
            }
        };
        add(&mut self.r, &values[0], weights[0]);
        add(&mut self.g, &values[1 % N], weights[1]);
        add(&mut self.b, &values[2 % N], weights[2]);
    }

    // Not inlined: seen together with the loop, sums of single lanes make the compiler keep all lanes apart.
    #[inline(never)]
    pub(super) fn total(&self) -> [f64; 3] {
        [self.r, self.g, self.b].map(|lanes| lanes.iter().map(|&x| f64::from(x)).sum())
    }
}

/// z, or 0 below the horizon: one instruction, as NaN does not matter.
#[inline(always)]
pub(super) fn above(z: f32) -> f32 {
    if z > 0.0 { z } else { 0.0 }
}

/// Reflectance × cosine of eight directions; 0 below the horizon unless it goes on smoothly.
#[inline(always)]
pub(super) fn reflect<const N: usize, K: Kernel<N>>(kernel: K, normal: [f32; 3], [x, y, z]: &Eight<3>) -> Eight<N> {
    let mut values = [[0.0_f32; TILE]; N];
    for lane in 0..TILE {
        let d = [x[lane], y[lane], z[lane]];
        let cosine = normal[0] * d[0] + normal[1] * d[1] + normal[2] * d[2];
        let value = kernel.at(d, cosine, cosine);
        for c in 0..N {
            values[c][lane] = if K::SMOOTH || cosine > 0.0 { value[c] } else { 0.0 };
        }
    }
    values
}
