//! The atoms that a transformed atom meets, from either side, without spurious ones.

use super::atom::power;
use super::exact_sum::{exact_product, separation};
use super::steps::Steps;
use super::{AffineMap, Atom, Mother, coupling};

/// The atoms of a level whose coupling with a given one is not exactly zero, by ascending offset.
pub(super) trait Met {
    /// Visits (atom, coupling) of the wavelets: three at most.
    fn wavelets(&self, level: u32, visit: impl FnMut(Atom, f64));

    /// Visits (atom, coupling) of the scaling functions.
    fn scalings(&self, level: u32, visit: impl FnMut(Atom, f64));

    /// Visits those of the 1D basis, by ascending flat index.
    #[inline(always)]
    fn basis(&self, levels: u32, mut visit: impl FnMut(usize, f64)) {
        self.scalings(0, |_, value| visit(0, value));
        for level in 0..levels {
            self.wavelets(level, |atom, value| visit((1 << level) + atom.offset, value));
        }
    }
}

/// The target atoms that a source atom meets.
pub(super) struct Row {
    steps: Steps,
}

impl Row {
    #[inline(always)]
    pub(super) fn new(source: Atom, map: AffineMap) -> Self {
        Self { steps: Steps::of_source(source, map) }
    }

    /// The coupling with one scaling function, or 0.
    #[inline(always)]
    pub(super) fn scaling(&self, level: u32, offset: usize) -> f64 {
        let value = self.steps.scaling(level, offset);
        let target = Atom { mother: Mother::Scaling, level, offset };
        if self.steps.vanishes(target, value) { 0.0 } else { value }
    }

    #[inline(always)]
    fn pass(&self, target: Atom, value: f64, mut visit: impl FnMut(Atom, f64)) {
        if !self.steps.vanishes(target, value) {
            visit(target, value);
        }
    }
}

impl Met for Row {
    #[inline(always)]
    fn wavelets(&self, level: u32, mut visit: impl FnMut(Atom, f64)) {
        let atom = |offset| Atom { mother: Mother::Wavelet, level, offset };
        self.steps.wavelets(level, |offset, value| self.pass(atom(offset), value, &mut visit));
    }

    #[inline(always)]
    fn scalings(&self, level: u32, mut visit: impl FnMut(Atom, f64)) {
        let atom = |offset| Atom { mother: Mother::Scaling, level, offset };
        self.steps.scalings(level, |offset, value| self.pass(atom(offset), value, &mut visit));
    }
}

/// The source atoms that a target atom meets.
///
/// The places where the two may meet are found from the target's image in the source, each to a few ε. Their values are
/// not: at a small scale the image is so narrow that differences of its breakpoints would be lost. A value is the
/// [`coupling`] of the pair, and a pair whose coupling is 0 is left out.
pub(super) struct Column {
    target: Atom,
    map: AffineMap,
    /// The image of the breakpoints, ascending, each to a few ε of itself.
    at: [f64; 3],
}

/// The rounding of an image and of its product with a number of cells, relative.
const BLUR: f64 = 4.0 * f64::EPSILON;

impl Column {
    #[inline(always)]
    pub(super) fn new(target: Atom, map: AffineMap) -> Self {
        let image = |v: f64| {
            let (high, low) = exact_product(map.scale(), v);
            separation(map.offset(), (-high, -low), (0.0, 0.0))
        };
        let mut at = target.breakpoints().map(image);
        if map.scale() < 0.0 {
            at.reverse();
        }
        Self { target, map, at }
    }

    #[inline(always)]
    fn pass(&self, source: Atom, mut visit: impl FnMut(Atom, f64)) {
        let value = coupling(source, self.target, self.map);
        if value != 0.0 {
            visit(source, value);
        }
    }
}

impl Met for Column {
    #[inline(always)]
    fn wavelets(&self, level: u32, mut visit: impl FnMut(Atom, f64)) {
        let count = power(level as i32);
        let mut next = 0.0;
        for x in self.at {
            let blur = BLUR * x.abs();
            let (low, high) = (((x - blur) * count).floor(), ((x + blur) * count).floor());
            let mut cell = low.max(next);
            while cell <= high && cell < count {
                self.pass(Atom { mother: Mother::Wavelet, level, offset: cell as usize }, &mut visit);
                cell += 1.0;
            }
            next = next.max(high + 1.0);
        }
    }

    #[inline(always)]
    fn scalings(&self, level: u32, mut visit: impl FnMut(Atom, f64)) {
        let count = power(level as i32);
        let [low, _, high] = self.at;
        let mut cell = ((low - BLUR * low.abs()) * count).floor().max(0.0);
        while cell <= (high + BLUR * high.abs()) * count && cell < count {
            self.pass(Atom { mother: Mother::Scaling, level, offset: cell as usize }, &mut visit);
            cell += 1.0;
        }
    }
}
