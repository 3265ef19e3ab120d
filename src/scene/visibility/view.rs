//! One patch of directions around one origin: where boxes and triangles are seen in it.

use std::marker::PhantomData;

use pulp::Simd;

use super::chart::Chart;
use super::lanes::{Lanes, Mask, Reg, parts};
use super::orientation::Orientation;
use crate::scene::BackFaces;
use crate::scene::bvh::{Leaf, WIDTH, WideNode};

/// A projected triangle is searched this much beyond its corners, in patch coordinates a unit of side: covers the
/// rounding of the projection (2^-22 · side cells) and the tips of triangles widened by the edge tolerance.
const RANGE_PAD: f32 = 1e-6;

/// 1.5 · 2²³: what is added to it is rounded to a whole number, in the low bits.
const INTEGER: f32 = 12_582_912.0;

/// The whole number in the low bits.
#[inline(always)]
fn whole(x: f32) -> u32 {
    x.to_bits().wrapping_sub(INTEGER.to_bits())
}

/// A patch of `side`² cells around an origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct View<O, C> {
    pub(super) orientation: O,
    chart: PhantomData<C>,
    pub(super) back_faces: BackFaces,
    side: f32,
    /// What is added to the ends of a range before they are rounded to cells.
    ends: [f32; 2],
}

/// Ranges of cells, [first, end) in columns and rows, of eight boxes or triangles.
pub(super) struct Ranges {
    /// First column, end column, first row, end row; each is [`INTEGER`] plus a whole number.
    bounds: [Lanes; 4],
    /// 1 where the range holds a cell, 0 elsewhere.
    some: Lanes,
}

impl Ranges {
    fn none() -> Self {
        Self { bounds: [[INTEGER; WIDTH]; 4], some: [0.0; WIDTH] }
    }

    /// A bit for each lane whose range holds a cell.
    #[inline(always)]
    pub(super) fn some(&self) -> u32 {
        // 1.0 has bit 29, 0.0 has none: no branches, of which half would be guessed wrong.
        let mut bits = 0;
        for i in 0..WIDTH {
            bits |= (self.some[i].to_bits() >> 29 & 1) << i;
        }
        bits
    }

    #[inline(always)]
    pub(super) fn x(&self, i: usize) -> [u32; 2] {
        [whole(self.bounds[0][i]), whole(self.bounds[1][i])]
    }

    #[inline(always)]
    pub(super) fn y(&self, i: usize) -> [u32; 2] {
        [whole(self.bounds[2][i]), whole(self.bounds[3][i])]
    }

    /// The centres of the first column and row of each range, to the bit as in the table of centres.
    #[inline(always)]
    pub(super) fn first_centre<S: Simd>(&self, simd: S, side: usize, part: usize) -> [Reg<S>; 2] {
        let [integer, half, step, one] = [INTEGER, 0.5, 2.0 / side as f32, 1.0].map(
            #[inline(always)]
            |x| Reg::splat(simd, x),
        );
        let x = Reg::load(simd, &self.bounds[0], part) - integer;
        let y = Reg::load(simd, &self.bounds[2], part) - integer;
        [(x + half) * step - one, (y + half) * step - one]
    }
}

/// One register of [`Ranges`].
struct Ends<S: Simd> {
    bounds: [Reg<S>; 4],
    some: Reg<S>,
}

impl<S: Simd> Ends<S> {
    #[inline(always)]
    fn new(simd: S, [x, y]: [[Reg<S>; 2]; 2], there: Mask<S>) -> Self {
        let some = there.and(x[0].less(x[1])).and(y[0].less(y[1]));
        let some = some.select(Reg::splat(simd, 1.0), Reg::splat(simd, 0.0));
        Self { bounds: [x[0], x[1], y[0], y[1]], some }
    }

    #[inline(always)]
    fn store(self, ranges: &mut Ranges, part: usize) {
        for k in 0..4 {
            self.bounds[k].store(&mut ranges.bounds[k], part);
        }
        self.some.store(&mut ranges.some, part);
    }
}

/// Eight triangles relative to the origin in the axes of the edge functions: `corners[corner][component]`.
pub(super) type Corners = [[Lanes; 3]; 3];

/// Which cells a range takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reach {
    /// Those whose centre it holds.
    Centres,
    /// All that it touches.
    Touched,
}

impl<O: Orientation, C: Chart> View<O, C> {
    /// `slack` multiplies the pad of ranges: 1 where patch coordinates are as exact as those of a cube's face.
    pub(super) fn new(orientation: O, side: usize, reach: Reach, slack: f32, back_faces: BackFaces) -> Self {
        let side = side as f32;
        let beyond = match reach {
            Reach::Centres => 0.0,
            Reach::Touched => 0.5,
        };
        let (half, pad) = (0.5 * side, RANGE_PAD * side * slack);
        Self { orientation, chart: PhantomData, back_faces, side, ends: [half - pad - beyond, half + pad + beyond] }
    }

    /// The ranges of a node's children and their sort keys, near before far.
    #[inline(always)]
    pub(super) fn project_boxes<S: Simd>(&self, simd: S, node: &WideNode) -> (Ranges, Lanes) {
        let mut ranges = Ranges::none();
        let mut keys = [0.0; WIDTH];
        for part in 0..parts::<S>() {
            let [low, high] = self.orientation.boxes(simd, node, part);
            (low[2] + high[2]).store(&mut keys, part);
            let (ends, there) = C::cover(simd, low, high);
            let ranges_along = [self.range(simd, ends[0]), self.range(simd, ends[1])];
            Ends::new(simd, ranges_along, there).store(&mut ranges, part);
        }
        (ranges, keys)
    }

    /// A leaf's triangles and their ranges of cells.
    #[inline(always)]
    pub(super) fn project_leaf<S: Simd>(&self, simd: S, leaf: &Leaf) -> (Corners, Ranges) {
        let mut corners = [[[0.0; WIDTH]; 3]; 3];
        let mut ranges = Ranges::none();
        for part in 0..parts::<S>() {
            let zero = Reg::splat(simd, 0.0);
            let mut along = [[[zero; 3]; 2]; 3];
            for c in 0..3 {
                let corner = self.orientation.corner(simd, leaf, c, part);
                for k in 0..3 {
                    corner[k].store(&mut corners[c][k], part);
                }
                along[c] = self.orientation.along(simd, corner);
            }
            // With the bounds of rounding, if there are any.
            let (mut least, mut most) = ([[zero; 3]; 3], [[zero; 3]; 3]);
            for c in 0..3 {
                for k in 0..3 {
                    let [p, bound] = [along[c][0][k], along[c][1][k]];
                    (least[c][k], most[c][k]) = if O::ROUNDED { (p - bound, p + bound) } else { (p, p) };
                }
            }
            let (mut low, mut high) = ([zero; 3], [zero; 3]);
            for k in 0..3 {
                low[k] = least[0][k].min(least[1][k]).min(least[2][k]);
                high[k] = most[0][k].max(most[1][k]).max(most[2][k]);
            }
            let (mut ends, there) = C::cover(simd, low, high);
            if C::STRAIGHT {
                ends = Self::between_corners(simd, &least, &most, low[2], ends);
            }
            let ranges_along = [self.range(simd, ends[0]), self.range(simd, ends[1])];
            Ends::new(simd, ranges_along, there).store(&mut ranges, part);
        }
        (corners, ranges)
    }

    /// The intervals of triangles that are in front as a whole, from z₀ on: the corners' own projections are tighter
    /// than those of the box, which others keep.
    #[inline(always)]
    fn between_corners<S: Simd>(
        simd: S,
        least: &[[Reg<S>; 3]; 3],
        most: &[[Reg<S>; 3]; 3],
        z0: Reg<S>,
        box_ends: [[Reg<S>; 2]; 2],
    ) -> [[Reg<S>; 2]; 2] {
        let [zero, one, nearest] = [0.0, 1.0, f32::MIN_POSITIVE].map(
            #[inline(always)]
            |x| Reg::splat(simd, x),
        );
        let in_front = nearest.less(z0);
        let mut ends = [[zero; 2]; 2];
        for c in 0..3 {
            let far = in_front.select(one / most[c][2], one);
            let near = if O::ROUNDED { in_front.select(one / least[c][2], one) } else { far };
            for k in 0..2 {
                let [a, b] = if O::ROUNDED {
                    let (a, b) = (least[c][k], most[c][k]);
                    [a * a.less(zero).select(near, far), b * zero.less(b).select(near, far)]
                } else {
                    [least[c][k] * far; 2]
                };
                ends[k] = if c == 0 { [a, b] } else { [ends[k][0].min(a), ends[k][1].max(b)] };
            }
        }
        for k in 0..2 {
            for end in 0..2 {
                ends[k][end] = in_front.select(ends[k][end], box_ends[k][end]);
            }
        }
        ends
    }

    /// The cells [first, end) of an interval, a little widened.
    ///
    /// The centre of cell i is at (2i + 1)/side − 1, so the first i ≥ (least + 1) side/2 − ½ is the nearest integer of
    /// (least + 1) side/2; likewise the end. All cells that are touched lie half a cell farther out.
    #[inline(always)]
    fn range<S: Simd>(&self, simd: S, [least, most]: [Reg<S>; 2]) -> [Reg<S>; 2] {
        let scale = Reg::splat(simd, 0.5 * self.side);
        let (zero, side) = (Reg::splat(simd, 0.0), Reg::splat(simd, self.side));
        let first = least * scale + Reg::splat(simd, self.ends[0]);
        let end = most * scale + Reg::splat(simd, self.ends[1]);
        let integer = Reg::splat(simd, INTEGER);
        [first.max(zero).min(side) + integer, end.max(zero).min(side) + integer]
    }
}
