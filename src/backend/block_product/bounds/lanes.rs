//! Errors of few samples, eight pixels at a time.

use super::gauge::Probe;
use crate::backend::block_product::light::NODES;
use crate::backend::block_product::tiles::{Eight, GROUP};
use crate::scene::Kernel;

/// The nodes of 1, 4 and 16 samples among all.
const LEVELS: [std::ops::Range<usize>; 3] = [0..1, 1..5, 5..NODES];

/// Σ e², Σ e and Σ |e| of 0, 1, 4 and 16 samples over the probed pixels of a block that are above the horizon, each the largest
/// of N channels. The normal is +z.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    pub(super) squares: [f32; 4],
    pub(super) signed: [f32; 4],
    pub(super) sizes: [f32; 4],
}

/// The sums for a block whose centre is where `turn` (rows) takes +z.
#[inline(always)]
pub(super) fn sums<const N: usize, K: Kernel<N>>(kernel: K, turn: &[[f32; 3]; 3], probe: &Probe) -> Sums {
    let mut nodes = [[0.0_f32; NODES.next_multiple_of(GROUP)]; N];
    for (k, node) in probe.nodes.iter().enumerate() {
        let d = turned(turn, node);
        for lane in 0..GROUP {
            let values = kernel.continued([d[0][lane], d[1][lane], d[2][lane]], d[2][lane]);
            (0..N).for_each(|c| nodes[c][k * GROUP + lane] = values[c]);
        }
    }
    if K::APART {
        let [x, y, z] = turned(turn, &probe.nodes[0]).map(|axis| axis[0]);
        let values = kernel.apart([x, y, z], z);
        (0..N).for_each(|c| nodes[c][0] = values[c]);
    }
    let mut squares = [[[0.0_f32; GROUP]; 4]; N];
    let (mut signed, mut sizes) = (squares, squares);
    for (pixels, cardinals) in probe.pixels.iter().zip(&probe.cardinals) {
        let d = turned(turn, pixels);
        let mut values = [[0.0_f32; GROUP]; N];
        let (mut mask, mut first) = ([0.0_f32; GROUP], [1.0_f32; GROUP]);
        for lane in 0..GROUP {
            let z = d[2][lane];
            let value = kernel.continued([d[0][lane], d[1][lane], z], z);
            (0..N).for_each(|c| values[c][lane] = value[c]);
            mask[lane] = if z > 0.0 { 1.0 } else { 0.0 };
            if K::APART {
                first[lane] = z;
            }
        }
        for c in 0..N {
            let mut add = |k: usize, guess: &[f32; GROUP]| {
                for lane in 0..GROUP {
                    let error = (values[c][lane] - guess[lane]) * mask[lane];
                    squares[c][k][lane] += error * error;
                    signed[c][k][lane] += error;
                    sizes[c][k][lane] += error.abs();
                }
            };
            add(0, &[0.0; GROUP]);
            add(1, &first.map(|first| first * nodes[c][0]));
            for k in 2..4 {
                let mut guess = [0.0_f32; GROUP];
                for node in LEVELS[k - 1].clone() {
                    for lane in 0..GROUP {
                        guess[lane] += nodes[c][node] * cardinals[node][lane];
                    }
                }
                add(k, &guess);
            }
        }
    }
    let mut all = Sums::default();
    for c in 0..N {
        for k in 0..4 {
            let total = |lanes: &[[f32; GROUP]; 4]| lanes[k].iter().sum::<f32>();
            all.squares[k] = larger(all.squares[k], total(&squares[c]));
            all.signed[k] = larger(all.signed[k], total(&signed[c]).abs());
            all.sizes[k] = larger(all.sizes[k], total(&sizes[c]));
        }
    }
    all
}

/// The larger, or infinity for what is not a number: no number of samples is enough for that.
#[inline(always)]
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if b.is_nan() { f32::INFINITY } else { a.max(b) }
}

#[inline(always)]
fn turned(turn: &[[f32; 3]; 3], [x, y, z]: &Eight<3>) -> Eight<3> {
    turn.map(|row| std::array::from_fn(|lane| row[0] * x[lane] + row[1] * y[lane] + row[2] * z[lane]))
}
