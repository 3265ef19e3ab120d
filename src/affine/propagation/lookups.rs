//! Single target coefficients from a summed-area table: nine look-ups for two wavelets, six or four with scaling
//! functions.
//!
//! With P(X, Y) = ∫₀^X ∫₀^Y F the double primitive of the source, and x_a, y_b the breakpoints of the two target atoms
//! carried into the source,
//! ```math
//! L_k = 2^{(l_x + l_y)/2}/(s_x s_y) Σ_ab w_a w_b P(x_a, y_b),    w = (−1, 2, −1) of ψ, (−1, 1) of φ.
//! ```
//! F is constant on its pixels, so P between the corners of the table is bilinear, exactly.

use crate::Real;
use crate::affine::atom::root_power;
use crate::affine::{AffineMap, Atom, Mother};

/// P at the corners of the pixels, C channels together, in f64.
#[derive(Debug, Clone)]
pub(super) struct PrimitiveTable<const C: usize> {
    side: usize,
    corner: Vec<[f64; C]>,
}

/// Where a breakpoint of one axis lies in the table, and its weight.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Place {
    cell: u32,
    within: f64,
    weight: f64,
}

impl<const C: usize> PrimitiveTable<C> {
    pub(super) fn new(side: usize) -> Self {
        Self { side, corner: vec![[0.0; C]; (side + 1) * (side + 1)] }
    }

    /// Sets a channel from its pixels, row-major.
    pub(super) fn set<T: Real>(&mut self, channel: usize, pixels: &[T]) {
        let (n, pitch) = (self.side, self.side + 1);
        let area = 1.0 / (n * n) as f64;
        for y in 0..n {
            let mut row = 0.0;
            for x in 0..n {
                row += pixels[y * n + x].widen() * area;
                let above = self.corner[y * pitch + x + 1][channel];
                self.corner[(y + 1) * pitch + x + 1][channel] = above + row;
            }
        }
    }

    /// The breakpoints of a target atom on one axis; the weights carry 2^{l/2}/s.
    #[inline(always)]
    pub(super) fn places(&self, atom: Atom, map: AffineMap) -> [Place; 3] {
        let factor = root_power(atom.level as i32) / map.scale();
        let weight = match atom.mother {
            Mother::Wavelet => [-factor, 2.0 * factor, -factor],
            Mother::Scaling => [-factor, 0.0, factor],
        };
        let (breakpoints, n) = (atom.breakpoints(), self.side as f64);
        std::array::from_fn(|k| {
            let x = map.apply(breakpoints[k]).clamp(0.0, 1.0) * n;
            let cell = (x as u32).min(self.side as u32 - 1);
            Place { cell, within: x - f64::from(cell), weight: weight[k] }
        })
    }

    #[inline(always)]
    fn at(&self, x: Place, y: Place) -> [f64; C] {
        let corner = y.cell as usize * (self.side + 1) + x.cell as usize;
        let (top, bottom) = (&self.corner[corner..][..2], &self.corner[corner + self.side + 1..][..2]);
        std::array::from_fn(|c| {
            let upper = top[0][c] + x.within * (top[1][c] - top[0][c]);
            let lower = bottom[0][c] + x.within * (bottom[1][c] - bottom[0][c]);
            upper + y.within * (lower - upper)
        })
    }

    /// Σ_ab w_a w_b P(x_a, y_b).
    #[inline(always)]
    pub(super) fn coefficient(&self, x: &[Place; 3], y: &[Place; 3]) -> [f64; C] {
        let mut sum = [0.0; C];
        for b in y.iter().filter(|b| b.weight != 0.0) {
            let mut row = [0.0; C];
            for a in x.iter().filter(|a| a.weight != 0.0) {
                let p = self.at(*a, *b);
                for c in 0..C {
                    row[c] += a.weight * p[c];
                }
            }
            for c in 0..C {
                sum[c] += b.weight * row[c];
            }
        }
        sum
    }
}
