//! A transformed atom as what it is: a piecewise constant function of at most three breakpoints.
//!
//! A function f of compact support with jumps h_k at b_k has, against an atom g_{l,t} = 2^{l/2} g(2^l v − t) with primitive G of g,
//!
//!   ∫ f g_{l,t} dv = −2^{−l/2} Σ_k h_k G(2^l b_k − t):
//!
//! integrate from each jump to +∞; the terms G(∞) cancel because the jumps add to 0. Λ, the primitive of ψ, vanishes outside its own
//! cell, so a wavelet of level l is met only where a breakpoint falls into its cell: three at most, whatever the size of the
//! signal. Where one cell has all three breakpoints of a wavelet in one of its halves, the sum is zero (the wavelet lies inside a constant
//! piece); that is decided by comparison, so that no rounding leaves a spurious term.

use super::atom::{Atom, power, root_power};
use super::{AffineMap, Mother};

/// An atom seen through a map (or its inverse): −h_k at b_k, ascending, times `amplitude`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    mother: Mother,
    at: [f64; 3],
    weight: [f64; 3],
    amplitude: f64,
}

/// The slots of a level: (offset, value before the factor of the level); unused ones have an offset of −1.
type Cells = [(f64, f64); 3];

const NOWHERE: (f64, f64) = (-1.0, 0.0);

impl Steps {
    /// f(s v + o) of a source atom, as a function of v.
    #[inline(always)]
    pub(super) fn of_source(atom: Atom, map: AffineMap) -> Self {
        let at = atom.breakpoints().map(|x| map.solve(x));
        Self::new(atom, at, map.scale() < 0.0, 1.0)
    }

    /// g((x − o)/s)/|s| of a target atom, as a function of x = s v + o.
    #[inline(always)]
    pub(super) fn of_target(atom: Atom, map: AffineMap) -> Self {
        let at = atom.breakpoints().map(|v| map.apply(v));
        Self::new(atom, at, map.scale() < 0.0, map.scale().abs().recip())
    }

    #[inline(always)]
    fn new(atom: Atom, [low, middle, high]: [f64; 3], mirrored: bool, amplitude: f64) -> Self {
        let sign = if mirrored { -1.0 } else { 1.0 };
        let weight = match atom.mother {
            Mother::Wavelet => [-sign, 2.0 * sign, -sign],
            Mother::Scaling => [-1.0, 0.0, 1.0],
        };
        let at = if mirrored { [high, middle, low] } else { [low, middle, high] };
        Self { mother: atom.mother, at, weight, amplitude: amplitude * root_power(atom.level as i32) }
    }

    /// Visits the wavelets of a level that are met, by ascending offset: (t, ∫ f ψ_{l,t}).
    #[inline(always)]
    pub(super) fn wavelets(&self, level: u32, mut visit: impl FnMut(usize, f64)) {
        let factor = self.amplitude * root_power(-(level as i32));
        let count = power(level as i32);
        for (cell, value) in self.cells(count) {
            if value != 0.0 && cell >= 0.0 && cell < count {
                visit(cell as usize, factor * value);
            }
        }
    }

    #[inline(always)]
    fn cells(&self, count: f64) -> Cells {
        let y = self.at.map(|b| b * count);
        let cell = y.map(f64::floor);
        let g: [f64; 3] = std::array::from_fn(|k| self.weight[k] * Mother::Wavelet.primitive(y[k] - cell[k]));
        if cell[0] == cell[2] {
            // All in one cell: a wavelet that does not straddle the middle is met by nothing.
            let one_half = y[2] - cell[0] <= 0.5 || y[0] - cell[0] >= 0.5;
            if one_half && self.mother == Mother::Wavelet {
                return [NOWHERE; 3];
            }
            return [(cell[0], (g[0] + 0.5 * g[1]) + (g[2] + 0.5 * g[1])), NOWHERE, NOWHERE];
        }
        if self.mother == Mother::Scaling {
            return [(cell[0], g[0]), (cell[2], g[2]), NOWHERE];
        }
        if cell[1] == cell[0] {
            [(cell[0], g[0] + g[1]), (cell[2], g[2]), NOWHERE]
        } else if cell[1] == cell[2] {
            [(cell[0], g[0]), (cell[2], g[1] + g[2]), NOWHERE]
        } else {
            std::array::from_fn(|k| (cell[k], g[k]))
        }
    }

    /// Visits the scaling functions of a level that are met, by ascending offset: (t, ∫ f φ_{l,t}).
    #[inline(always)]
    pub(super) fn scalings(&self, level: u32, mut visit: impl FnMut(usize, f64)) {
        let factor = self.amplitude * root_power(-(level as i32));
        let count = power(level as i32);
        let y = self.at.map(|b| b * count);
        let (first, last) = (y[0].floor(), y[2].floor());
        if first == last && self.mother == Mother::Wavelet {
            return; // the whole wavelet inside one cell: its mean is zero
        }
        let mut t = first.max(0.0);
        while t <= last && t < count {
            let g = |k: usize| self.weight[k] * Mother::Scaling.primitive(y[k] - t);
            let value = (g(0) + 0.5 * g(1)) + (g(2) + 0.5 * g(1));
            if value != 0.0 {
                visit(t as usize, factor * value);
            }
            t += 1.0;
        }
    }

    /// ∫ f φ_{l,t} of one cell, as [`scalings`](Self::scalings) finds it.
    #[inline(always)]
    pub(super) fn scaling(&self, level: u32, t: usize) -> f64 {
        let y = self.at.map(|b| b * power(level as i32));
        let g = |k: usize| self.weight[k] * Mother::Scaling.primitive(y[k] - t as f64);
        self.amplitude * root_power(-(level as i32)) * ((g(0) + 0.5 * g(1)) + (g(2) + 0.5 * g(1)))
    }

    /// Breakpoints, ascending, and minus the jumps there.
    #[inline(always)]
    pub(super) fn jumps(&self) -> ([f64; 3], [f64; 3]) {
        (self.at, self.weight.map(|w| w * self.amplitude))
    }

    /// Visits the functions of the 1D basis of `levels` levels that are met, by ascending flat index.
    #[inline(always)]
    pub(super) fn basis(&self, levels: u32, mut visit: impl FnMut(usize, f64)) {
        self.scalings(0, |_, value| visit(0, value));
        for level in 0..levels {
            self.wavelets(level, |t, value| visit((1 << level) + t, value));
        }
    }
}
