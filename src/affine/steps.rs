//! A transformed atom, held as a piecewise constant function of at most three breakpoints.
//!
//! A function f of compact support with jumps h_k at b_k has, against an atom g_{l,t} = 2^{l/2} g(2^l v − t) with
//! primitive G of g,
//!
//! ```math
//! ∫ f g_{l,t} dv = −2^{−l/2} Σ_k h_k G(2^l b_k − t):
//! ```
//!
//! integrate from each jump to +∞; the terms G(∞) cancel because the jumps add to 0. Λ, the primitive of ψ, vanishes
//! outside its own cell, so a wavelet of level l is met only where a breakpoint falls into its cell: three at most,
//! whatever the size of the signal. Where one cell has all three breakpoints of a wavelet in one of its halves, the sum
//! is zero (the wavelet lies inside a constant piece); that is decided by comparison, so that no rounding leaves a
//! spurious term.

use super::atom::{Atom, power, root_power};
use super::zero::vanishes;
use super::{AffineMap, Mother, Parameter};
use crate::Real;

/// A source atom seen through a map: −h_k at b_k, ascending, times `amplitude`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    source: Atom,
    map: AffineMap,
    at: [f64; 3],
    weight: [f64; 3],
    amplitude: f64,
    grid: Grid,
}

/// The breakpoints as integers: clamped to [0, 1], in units of 2^−62.
///
/// In this form the cell of a breakpoint is a shift and sums are exact, so that a sum that is not zero is a coupling
/// that is not zero. What is lost by the unit is far below the rounding of the breakpoints. No function of the basis
/// reaches outside of [0, 1], so that clamping changes no coupling.
#[derive(Debug, Clone, Copy)]
struct Grid {
    at: [i64; 3],
    weight: [i64; 3],
    /// Wavelets of levels coarser than this are not met.
    first: u32,
}

const BITS: u32 = 62;
const UNIT: i64 = 1 << BITS;

/// The room for a row that [`Steps::write_basis`] writes: three functions a level, the mean, and a place beyond the
/// end.
#[inline(always)]
pub(super) fn row_room(levels: u32) -> usize {
    3 * levels as usize + 2
}

impl Grid {
    #[inline(always)]
    fn new(mother: Mother, at: [f64; 3], weight: [f64; 3]) -> Self {
        let [low, _, high] = at;
        let at = at.map(|b| (clamp(b, 0.0, 1.0) * UNIT as f64) as i64);
        let mut first = 0;
        if low >= 1.0 || high <= 0.0 {
            first = u32::MAX;
        } else if mother == Mother::Wavelet && low >= 0.0 && high <= 1.0 {
            // The whole wavelet lies in one constant piece, a half cell, of coarser levels. The half cell of level l
            // that holds a position is its first l + 1 bits, and the end of the wavelet is open.
            let apart = at[0] ^ (at[2] - 1).max(at[0]);
            first = apart.leading_zeros() - (i64::BITS - BITS);
        }
        Self { at, weight: weight.map(|w| w as i64), first }
    }

    /// The wavelets of a level that are met: (t, 2^62 Σ w_k Λ(2^l b_k − t)/2^l), the sum 0 where there is none.
    ///
    /// Breakpoints of one cell are gathered into the last of them. No branch on the data.
    #[inline(always)]
    fn met(&self, level: u32) -> [(i64, i64); 3] {
        let shift = BITS - level;
        let width = 1i64 << shift;
        let cell = self.at.map(|p| p >> shift);
        let g: [i64; 3] = std::array::from_fn(|k| {
            let within = self.at[k] & (width - 1);
            self.weight[k] * within.min(width - within)
        });
        let (joined_low, joined_high) = (cell[0] == cell[1], cell[1] == cell[2]);
        let low = if joined_low { g[0] + g[1] } else { g[1] };
        let high = if joined_high { low + g[2] } else { g[2] };
        let first = if joined_low { 0 } else { g[0] };
        let second = if joined_high { 0 } else { low };
        [(cell[0], first), (cell[1], second), (cell[2], high)]
    }

    /// 2^{l/2}/2^62: the factor of 2^{−l/2} and 2^l of a sum.
    #[inline(always)]
    fn scale(level: u32) -> f64 {
        root_power(level as i32) / UNIT as f64
    }
}

#[inline(always)]
fn clamp(x: f64, low: f64, high: f64) -> f64 {
    let x = if x < low { low } else { x };
    if x > high { high } else { x }
}

impl Steps {
    /// f(s v + o) of a source atom, as a function of v.
    #[inline(always)]
    pub(super) fn of_source(atom: Atom, map: AffineMap) -> Self {
        let [low, middle, high] = atom.breakpoints().map(|x| map.solve(x));
        let mirrored = map.scale() < 0.0;
        let sign = if mirrored { -1.0 } else { 1.0 };
        let weight = match atom.mother {
            Mother::Wavelet => [-sign, 2.0 * sign, -sign],
            Mother::Scaling => [-1.0, 0.0, 1.0],
        };
        let at = if mirrored { [high, middle, low] } else { [low, middle, high] };
        let amplitude = root_power(atom.level as i32);
        Self { source: atom, map, at, weight, amplitude, grid: Grid::new(atom.mother, at, weight) }
    }

    /// Visits the wavelets of a level that are met, by ascending offset: (t, ∫ f ψ_{l,t}).
    #[inline(always)]
    pub(super) fn wavelets(&self, level: u32, mut visit: impl FnMut(usize, f64)) {
        if level >= self.grid.first {
            for (cell, sum) in self.grid.met(level) {
                if sum != 0 {
                    visit(cell as usize, self.amplitude * Grid::scale(level) * sum as f64);
                }
            }
        }
    }

    /// Writes the functions of the 1D basis of `levels` levels that are met, by ascending flat index, to the front of
    /// `index` and `value`; returns the number. Both have at least [`row_room`] places.
    #[inline(always)]
    pub(super) fn write_basis<T: Real>(&self, levels: u32, index: &mut [u32], value: &mut [T]) -> usize {
        let room = row_room(levels);
        let (index, value) = (&mut index[..room], &mut value[..room]);
        let mean = self.mean();
        (index[0], value[0]) = (0, T::of(mean));
        let mut len = usize::from(mean != 0.0 && !self.vanishes(Atom::from_flat(0), mean));
        // What rounding of the breakpoints can make of a sum that is zero by cancellation.
        let doubtful =
            (16.0 * f64::EPSILON * UNIT as f64 * (1.0 + (self.map.offset() / self.map.scale()).abs())) as u64;
        for level in self.grid.first..levels {
            let scale = self.amplitude * Grid::scale(level);
            for (cell, sum) in self.grid.met(level) {
                (index[len], value[len]) = ((1 << level) + cell as u32, T::of(scale * sum as f64));
                len +=
                    usize::from(sum != 0 && (sum.unsigned_abs() > doubtful || !self.cancels(level, cell, scale, sum)));
            }
        }
        len
    }

    /// Whether the coupling with an atom, rounded to `value`, is exactly zero.
    #[inline(always)]
    pub(super) fn vanishes(&self, target: Atom, value: f64) -> bool {
        vanishes(self.source, target, self.map, value)
    }

    #[cold]
    fn cancels(&self, level: u32, cell: i64, scale: f64, sum: i64) -> bool {
        self.vanishes(Atom { mother: Mother::Wavelet, level, offset: cell as usize }, scale * sum as f64)
    }

    /// ∫ f φ over [0, 1).
    #[inline(always)]
    fn mean(&self) -> f64 {
        let inside = self.at[0] >= 0.0 && self.at[2] <= 1.0;
        if inside && self.source.mother == Mother::Wavelet {
            return 0.0;
        }
        let g: [f64; 3] = std::array::from_fn(|k| self.weight[k] * clamp(self.at[k], 0.0, 1.0));
        self.amplitude * ((g[0] + 0.5 * g[1]) + (0.5 * g[1] + g[2]))
    }

    /// Visits the scaling functions of a level that are met, by ascending offset: (t, ∫ f φ_{l,t}).
    #[inline(always)]
    pub(super) fn scalings(&self, level: u32, mut visit: impl FnMut(usize, f64)) {
        let factor = self.amplitude * root_power(-(level as i32));
        let count = power(level as i32);
        let y = self.at.map(|b| b * count);
        let (first, last) = (y[0].floor(), y[2].floor());
        if first == last && self.source.mother == Mother::Wavelet {
            return; // the whole wavelet inside one cell: its mean is zero
        }
        let mut t = first.max(0.0);
        while t <= last && t < count {
            let value = self.share(y, t);
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
        self.amplitude * root_power(-(level as i32)) * self.share(y, t as f64)
    }

    /// Σ w_k B(y_k − t): what cell t has of the breakpoints y, in cells.
    #[inline(always)]
    fn share(&self, y: [f64; 3], t: f64) -> f64 {
        let g = |k: usize| self.weight[k] * Mother::Scaling.primitive(y[k] - t);
        (g(0) + 0.5 * g(1)) + (g(2) + 0.5 * g(1))
    }

    /// Breakpoints, ascending, and minus the jumps there.
    #[inline(always)]
    pub(super) fn jumps(&self) -> ([f64; 3], [f64; 3]) {
        (self.at, self.weight.map(|w| w * self.amplitude))
    }

    /// Visits the atoms of a level whose coupling changes with a parameter: (t, its right-hand derivative).
    ///
    /// `velocity` is db_k/dp. A breakpoint moves Σ w_k G(2^l b_k − t) by w_k 2^l velocity_k g(…), g the value of the
    /// atom's mother on the side to which the breakpoint moves; so only cells that a breakpoint lies in, or enters, are
    /// met.
    #[inline(always)]
    fn slopes(&self, mother: Mother, level: u32, velocity: [f64; 3], mut visit: impl FnMut(usize, f64)) {
        let factor = self.amplitude * root_power(level as i32);
        let count = power(level as i32);
        let y = self.at.map(|b| b * count);
        let cell: [f64; 3] = std::array::from_fn(|k| if velocity[k] < 0.0 { y[k].ceil() - 1.0 } else { y[k].floor() });
        if cell[0] == cell[2] && self.source.mother == Mother::Wavelet {
            // One constant piece of the atom holds the whole wavelet: it stays there.
            let (low, high) = (y[0] - cell[0], y[2] - cell[0]);
            let first = mother.slope(low, velocity[0]);
            if mother == Mother::Scaling || first == mother.slope(high, velocity[2]) {
                return;
            }
        }
        let g: [f64; 3] =
            std::array::from_fn(|k| self.weight[k] * velocity[k] * mother.slope(y[k] - cell[k], velocity[k]));
        let mut emit = |cell: f64, value: f64| {
            if value != 0.0 && cell >= 0.0 && cell < count {
                visit(cell as usize, factor * value);
            }
        };
        // Breakpoints ascend, and so do their cells but where one moves left and its neighbour right.
        match (cell[0] == cell[1], cell[1] == cell[2]) {
            (true, true) => emit(cell[0], (g[0] + 0.5 * g[1]) + (g[2] + 0.5 * g[1])),
            (true, false) => [(cell[0], g[0] + g[1]), (cell[2], g[2])].into_iter().for_each(|(c, g)| emit(c, g)),
            (false, true) => [(cell[0], g[0]), (cell[1], g[1] + g[2])].into_iter().for_each(|(c, g)| emit(c, g)),
            (false, false) => (0..3).for_each(|k| emit(cell[k], g[k])),
        }
    }

    /// Visits the functions of the 1D basis whose coupling changes with a parameter: (flat index, right-hand
    /// derivative).
    #[inline(always)]
    pub(super) fn basis_slopes(&self, levels: u32, velocity: [f64; 3], mut visit: impl FnMut(usize, f64)) {
        self.slopes(Mother::Scaling, 0, velocity, |_, value| visit(0, value));
        for level in 0..levels {
            self.slopes(Mother::Wavelet, level, velocity, |t, value| visit((1 << level) + t, value));
        }
    }

    /// db_k/ds or db_k/do of a transformed source atom: b = (x − o)/s.
    #[inline(always)]
    pub(super) fn source_velocity(&self, map: AffineMap, parameter: Parameter) -> [f64; 3] {
        match parameter {
            Parameter::Scale => self.at.map(|b| -b / map.scale()),
            Parameter::Offset => [-map.scale().recip(); 3],
        }
    }
}
