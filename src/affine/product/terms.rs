//! The source as a list of atoms: nothing but breakpoints, so exact for any scale.

use super::walk::{Cell, Seen, Source};
use crate::Real;
use crate::affine::steps::Steps;
use crate::affine::{AffineMap, Atom};
use crate::haar::SparseVector;

/// The atoms of a source along each axis, and their coefficients in each channel.
#[derive(Debug, Clone)]
pub(super) struct Terms<const AXES: usize, const C: usize> {
    terms: Vec<([Atom; AXES], [f64; C])>,
}

impl<const AXES: usize, const C: usize> Terms<AXES, C> {
    /// Of channels of one length.
    pub(super) fn new<T: Real>(channels: [&SparseVector<T>; C], atoms: impl Fn(usize) -> [Atom; AXES]) -> Self {
        let mut indices: Vec<u32> = channels.iter().flat_map(|c| c.indices()).copied().collect();
        indices.sort_unstable();
        indices.dedup();
        let mut terms: Vec<_> = indices.iter().map(|&i| (atoms(i as usize), [0.0; C])).collect();
        for (channel, coefficients) in channels.iter().enumerate() {
            for (i, value) in coefficients.iter() {
                let at = indices.binary_search(&(i as u32)).expect("every index is in the union");
                terms[at].1[channel] = value.widen();
            }
        }
        Self { terms }
    }

    pub(super) fn len(&self) -> usize {
        self.terms.len()
    }

    /// Σ over the terms of their coefficients times a sum made of their atoms.
    #[inline(always)]
    pub(super) fn sum<const M: usize>(
        &self,
        maps: [AffineMap; AXES],
        unit: impl Fn([Axis; AXES]) -> [f64; M],
    ) -> [[f64; C]; M] {
        let mut sums = [[0.0; C]; M];
        for (atoms, coefficients) in &self.terms {
            let unit = unit(std::array::from_fn(|q| Axis::new(atoms[q], maps[q])));
            for (sums, unit) in sums.iter_mut().zip(unit) {
                for (sum, &c) in sums.iter_mut().zip(coefficients) {
                    *sum += unit * c;
                }
            }
        }
        sums
    }
}

/// A transformed atom of one axis: minus its jumps, where they are, and how fast they move with s and with o.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    at: [f64; 3],
    weight: [f64; 3],
    inverse: f64,
}

impl Axis {
    #[inline(always)]
    fn new(atom: Atom, map: AffineMap) -> Self {
        let (at, weight) = Steps::of_source(atom, map).jumps();
        Self { at, weight, inverse: map.scale().recip() }
    }

    #[inline(always)]
    fn meets(&self, [from, _, to]: [f64; 3]) -> bool {
        self.at[0] <= to && self.at[2] >= from
    }

    #[inline(always)]
    fn constant(&self, [from, _, to]: [f64; 3]) -> bool {
        (0..3).all(|k| self.weight[k] == 0.0 || self.at[k] < from || self.at[k] > to)
    }

    /// The integral over [from, to], exact but for its breakpoints.
    #[inline(always)]
    fn value(&self, from: f64, to: f64) -> f64 {
        let part = |k: usize| self.weight[k] * (self.at[k].max(from).min(to) - from);
        (part(0) + 0.5 * part(1)) + (part(2) + 0.5 * part(1))
    }

    /// The integral over [from, to] and its right-hand derivatives with respect to s and o: w_k times the velocities
    /// −b_k/s and −1/s of the breakpoints that are, or enter, inside.
    #[inline(always)]
    fn slopes(&self, from: f64, to: f64) -> [f64; 3] {
        let mut slopes = [self.value(from, to), 0.0, 0.0];
        for k in 0..3 {
            let b = self.at[k];
            // With growing s or o breakpoints of [0, 1] move to the left if s > 0, else to the right.
            let inside = if self.inverse > 0.0 { from < b && b <= to } else { from <= b && b < to };
            if inside {
                slopes[1] -= self.weight[k] * b * self.inverse;
                slopes[2] -= self.weight[k] * self.inverse;
            }
        }
        slopes
    }
}

/// One atom in 1D: its integral.
pub(super) struct Value1d(pub(super) [Axis; 1]);
/// One atom in 1D: [integral, ∂/∂s, ∂/∂o].
pub(super) struct Slopes1d(pub(super) [Axis; 1]);
/// One atom in 2D: its integral.
pub(super) struct Value2d(pub(super) [Axis; 2]);
/// One atom in 2D: [integral, ∂/∂s_x, ∂/∂o_x, ∂/∂s_y, ∂/∂o_y].
pub(super) struct Slopes2d(pub(super) [Axis; 2]);

/// What is seen of an atom, given the integrals over an interval (or rectangle) of it.
#[inline(always)]
fn seen_1d<S>(axis: &Axis, cell: Cell, integral: impl Fn(f64, f64) -> S) -> Seen<S, 2> {
    let cuts = cell.cuts(0);
    match () {
        () if !axis.meets(cuts) => Seen::Nothing,
        () if axis.constant(cuts) => Seen::Constant(integral(cuts[0], cuts[2])),
        () => Seen::Parts([integral(cuts[0], cuts[1]), integral(cuts[1], cuts[2])]),
    }
}

#[inline(always)]
fn seen_2d<A: Copy, S>(
    axes: &[Axis; 2],
    cell: Cell,
    along: impl Fn(&Axis, f64, f64) -> A,
    product: impl Fn(A, A) -> S,
) -> Seen<S, 4> {
    let cuts = [0, 1].map(|q| cell.cuts(q));
    if !(axes[0].meets(cuts[0]) && axes[1].meets(cuts[1])) {
        return Seen::Nothing;
    }
    if axes[0].constant(cuts[0]) && axes[1].constant(cuts[1]) {
        let [x, y] = [0, 1].map(|q| along(&axes[q], cuts[q][0], cuts[q][2]));
        return Seen::Constant(product(x, y));
    }
    let [x, y] = [0, 1].map(|q| [0, 1].map(|half| along(&axes[q], cuts[q][half], cuts[q][half + 1])));
    Seen::Parts(std::array::from_fn(|child| product(x[child & 1], y[child >> 1])))
}

impl Source<2> for Value1d {
    type Sum = [f64; 1];

    #[inline(always)]
    fn seen(&self, cell: Cell) -> Seen<[f64; 1], 2> {
        seen_1d(&self.0[0], cell, |from, to| [self.0[0].value(from, to)])
    }
}

impl Source<2> for Slopes1d {
    type Sum = [f64; 3];

    #[inline(always)]
    fn seen(&self, cell: Cell) -> Seen<[f64; 3], 2> {
        seen_1d(&self.0[0], cell, |from, to| self.0[0].slopes(from, to))
    }
}

impl Source<4> for Value2d {
    type Sum = [f64; 1];

    #[inline(always)]
    fn seen(&self, cell: Cell) -> Seen<[f64; 1], 4> {
        seen_2d(&self.0, cell, |axis, from, to| axis.value(from, to), |x, y| [x * y])
    }
}

impl Source<4> for Slopes2d {
    type Sum = [f64; 5];

    #[inline(always)]
    fn seen(&self, cell: Cell) -> Seen<[f64; 5], 4> {
        seen_2d(
            &self.0,
            cell,
            |axis, from, to| axis.slopes(from, to),
            |x, y| [x[0] * y[0], x[1] * y[0], x[2] * y[0], x[0] * y[1], x[0] * y[2]],
        )
    }
}
