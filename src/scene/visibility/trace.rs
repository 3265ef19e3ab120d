//! All rays of one cube face at once, from one origin.
//!
//! Rays that share an origin are the pixels of a picture, so the face is rasterised instead of traced: boxes and
//! triangles are projected to ranges of texels, and whatever covers no living ray is passed over. Boxes are visited
//! front to back, so that near faces kill the rays of the far ones. One ray and all rays use the same predicate (E ≥ 0
//! for the three edges, within the triangle's range of texels); the walk only leaves out triangles that cannot cover a
//! living ray, so that it gives exactly the bits of testing every triangle against every ray.

use super::super::bvh::{Bvh, EDGE_TOLERANCE, LEAF, Leaf, WIDTH, WideNode, edge, norm_squared, volume};
use super::BackFaces;
use super::lanes::{Lanes, Reg, parts};
use super::live::LiveRays;
use crate::sphere::Face;
use pulp::Simd;

/// A projected triangle is searched this much beyond its corners, in face coordinates a unit of side: covers the
/// rounding of the projection (2^-22 · side texels) and the tips of triangles widened by the edge tolerance.
const RANGE_PAD: f32 = 1e-6;

/// Boxes whose far side is no farther than this, in the scale of the hierarchy, are behind the origin's face: the least
/// number whose reciprocal is finite.
const NEAREST: f32 = f32::MIN_POSITIVE;

/// One face of the cube around one origin: how world axes become right, down, outward.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    axis: [usize; 3],
    sign: [f32; 3],
    /// Along right, down, outward, with the sign of the world axis.
    origin: [f32; 3],
    side: f32,
    back_faces: BackFaces,
}

/// Ranges of texels, [first, end) in columns and rows, of eight boxes or triangles.
struct Ranges {
    /// First column, end column, first row, end row; each is [`INTEGER`] plus a whole number.
    bounds: [Lanes; 4],
    /// 1 where the range holds a texel, 0 elsewhere.
    some: Lanes,
}

/// 1.5 · 2²³: what is added to it is rounded to a whole number, in the low bits.
const INTEGER: f32 = 12_582_912.0;

/// The whole number in the low bits.
#[inline(always)]
fn whole(x: f32) -> u32 {
    x.to_bits().wrapping_sub(INTEGER.to_bits())
}

impl Ranges {
    #[inline(always)]
    fn x(&self, i: usize) -> [u32; 2] {
        [whole(self.bounds[0][i]), whole(self.bounds[1][i])]
    }

    #[inline(always)]
    fn y(&self, i: usize) -> [u32; 2] {
        [whole(self.bounds[2][i]), whole(self.bounds[3][i])]
    }
}

impl View {
    pub(super) fn new(face: Face, origin: [f32; 3], side: usize, back_faces: BackFaces) -> Self {
        let axes = face.axes();
        let axis = axes.map(|a| {
            if a[0] != 0.0 {
                0
            } else if a[1] != 0.0 {
                1
            } else {
                2
            }
        });
        let sign = [0, 1, 2].map(|k: usize| axes[k][axis[k]] as f32);
        Self { axis, sign, origin: axis.map(|a| origin[a]), side: side as f32, back_faces }
    }

    /// The ranges of a node's children and their sort keys, near before far.
    #[inline(always)]
    fn project_boxes<S: Simd>(&self, simd: S, node: &WideNode) -> (Ranges, Lanes) {
        let mut ranges = Ranges { bounds: [[INTEGER; WIDTH]; 4], some: [0.0; WIDTH] };
        let mut keys = [0.0; WIDTH];
        for part in 0..parts::<S>() {
            let zero = Reg::splat(simd, 0.0);
            let (mut low, mut high) = ([zero; 3], [zero; 3]);
            for k in 0..3 {
                let axis = self.axis[k];
                let (sign, origin) = (Reg::splat(simd, self.sign[k]), Reg::splat(simd, self.origin[k]));
                let (a, b) = if self.sign[k] > 0.0 { (axis, axis + 3) } else { (axis + 3, axis) };
                low[k] = sign * (Reg::load(simd, &node.bounds[a], part) - origin);
                high[k] = sign * (Reg::load(simd, &node.bounds[b], part) - origin);
            }
            (low[2] + high[2]).store(&mut keys, part);
            self.box_ranges(simd, low, high).store(&mut ranges, part);
        }
        (ranges, keys)
    }

    /// Texel ranges of boxes given in the face's axes; none for those behind it.
    ///
    /// A box with z in [z₀, z₁], z₁ > 0 has its smallest x/z at z₀ if x₀ < 0 and at z₁ otherwise; −∞ if z₀ ≤ 0.
    #[inline(always)]
    fn box_ranges<S: Simd>(&self, simd: S, low: [Reg<S>; 3], high: [Reg<S>; 3]) -> Ends<S> {
        let [zero, one, nearest, infinity] = [0.0, 1.0, NEAREST, f32::INFINITY].map(
            #[inline(always)]
            |x| Reg::splat(simd, x),
        );
        let near = nearest.less(low[2]).select(one / low[2], infinity);
        let far = one / high[2].max(nearest);
        let least = |k: usize| low[k] * low[k].less(zero).select(near, far);
        let most = |k: usize| high[k] * zero.less(high[k]).select(near, far);
        let (x, y) = (self.range(simd, least(0), most(0)), self.range(simd, least(1), most(1)));
        let some = nearest.less(high[2]).and(x[0].less(x[1])).and(y[0].less(y[1])).select(one, zero);
        Ends { bounds: [x[0], x[1], y[0], y[1]], some }
    }

    /// The texels [first, end) whose centre is in [least, most], a little widened.
    ///
    /// The centre of texel i is at (2i + 1)/side − 1, so the first i ≥ (least + 1) side/2 − ½ is the nearest integer of
    /// (least + 1) side/2; likewise the end.
    #[inline(always)]
    fn range<S: Simd>(&self, simd: S, least: Reg<S>, most: Reg<S>) -> [Reg<S>; 2] {
        let (half, pad) = (0.5 * self.side, RANGE_PAD * self.side);
        let scale = Reg::splat(simd, half);
        let (zero, side) = (Reg::splat(simd, 0.0), Reg::splat(simd, self.side));
        let first = least * scale + Reg::splat(simd, half - pad);
        let end = most * scale + Reg::splat(simd, half + pad);
        let integer = Reg::splat(simd, INTEGER);
        [first.max(zero).min(side) + integer, end.max(zero).min(side) + integer]
    }
}

impl View {
    /// The centres of the first column and row of each range, to the bit as in the table of centres.
    #[inline(always)]
    fn first_centre<S: Simd>(&self, simd: S, ranges: &Ranges, part: usize) -> [Reg<S>; 2] {
        let [integer, half, step, one] = [INTEGER, 0.5, 2.0 / self.side, 1.0].map(
            #[inline(always)]
            |x| Reg::splat(simd, x),
        );
        let x = Reg::load(simd, &ranges.bounds[0], part) - integer;
        let y = Reg::load(simd, &ranges.bounds[2], part) - integer;
        [(x + half) * step - one, (y + half) * step - one]
    }
}

/// The centre of a column or row as all rays of a face use it: (i + ½)(2/side) − 1 in `f32`.
///
/// Exact where the side is a power of two, elsewhere within 2⁻²³.
pub(super) fn centre(side: usize, i: usize) -> f32 {
    (i as f32 + 0.5) * (2.0 / side as f32) - 1.0
}

/// One register of [`Ranges`].
struct Ends<S: Simd> {
    bounds: [Reg<S>; 4],
    some: Reg<S>,
}

impl<S: Simd> Ends<S> {
    #[inline(always)]
    fn store(self, ranges: &mut Ranges, part: usize) {
        for k in 0..4 {
            self.bounds[k].store(&mut ranges.bounds[k], part);
        }
        self.some.store(&mut ranges.some, part);
    }
}

/// Eight triangles relative to the origin in the face's axes: `corners[corner][component]`.
type Corners = [[Lanes; 3]; 3];

/// A leaf's triangles and their texel ranges.
#[inline(always)]
fn project_leaf<S: Simd>(simd: S, view: &View, leaf: &Leaf) -> (Corners, Ranges) {
    let mut corners = [[[0.0; WIDTH]; 3]; 3];
    let mut ranges = Ranges { bounds: [[INTEGER; WIDTH]; 4], some: [0.0; WIDTH] };
    for part in 0..parts::<S>() {
        let zero = Reg::splat(simd, 0.0);
        let mut p = [[zero; 3]; 3];
        for c in 0..3 {
            for k in 0..3 {
                let position = Reg::load(simd, &leaf.corners[c][view.axis[k]], part);
                p[c][k] = Reg::splat(simd, view.sign[k]) * (position - Reg::splat(simd, view.origin[k]));
                p[c][k].store(&mut corners[c][k], part);
            }
        }
        let (mut low, mut high) = ([zero; 3], [zero; 3]);
        for k in 0..3 {
            low[k] = p[0][k].min(p[1][k]).min(p[2][k]);
            high[k] = p[0][k].max(p[1][k]).max(p[2][k]);
        }
        let mut ends = view.box_ranges(simd, low, high);
        // In front as a whole: the corners' own projections are tighter than the box's.
        let (one, nearest) = (Reg::splat(simd, 1.0), Reg::splat(simd, NEAREST));
        let in_front = nearest.less(low[2]);
        let mut inverse = [one; 3];
        for c in 0..3 {
            inverse[c] = in_front.select(one / p[c][2], one);
        }
        for k in 0..2 {
            let (a, b, c) = (p[0][k] * inverse[0], p[1][k] * inverse[1], p[2][k] * inverse[2]);
            let tight = view.range(simd, a.min(b).min(c), a.max(b).max(c));
            ends.bounds[2 * k] = in_front.select(tight[0], ends.bounds[2 * k]);
            ends.bounds[2 * k + 1] = in_front.select(tight[1], ends.bounds[2 * k + 1]);
        }
        let [x0, x1, y0, y1] = ends.bounds;
        let reached = nearest.less(high[2]).and(x0.less(x1)).and(y0.less(y1));
        ends.some = reached.select(one, zero);
        ends.store(&mut ranges, part);
    }
    (corners, ranges)
}

/// The edges of eight triangles, turned so that n · (u, v, 1) ≥ 0 inside, and the error bounds that widen them.
struct Edges {
    /// `normals[edge][component][lane]`.
    normals: [[Lanes; 3]; 3],
    tolerances: [Lanes; 3],
    /// Positive if the origin sees the front, negative if the back, 0 if it is in the plane to the rounding error.
    facing: Lanes,
    /// The least of the three edge functions, widened, at the first texel of each range.
    first: Lanes,
}

impl Edges {
    #[inline(always)]
    fn new<S: Simd>(simd: S, view: &View, leaf: &Leaf, corners: &Corners, ranges: &Ranges) -> Self {
        let zeros = [0.0; WIDTH];
        let mut out = Self { normals: [[zeros; 3]; 3], tolerances: [zeros; 3], facing: zeros, first: zeros };
        for part in 0..parts::<S>() {
            let [zero, one, minus, tolerance] = [0.0, 1.0, -1.0, EDGE_TOLERANCE].map(
                #[inline(always)]
                |x| Reg::splat(simd, x),
            );
            let (mut p, mut e) = ([[zero; 3]; 3], [[zero; 3]; 3]);
            for c in 0..3 {
                for k in 0..3 {
                    p[c][k] = Reg::load(simd, &corners[c][k], part);
                    let [from, to] = [Reg::load(simd, &leaf.corners[c][view.axis[k]], part), {
                        Reg::load(simd, &leaf.corners[(c + 1) % 3][view.axis[k]], part)
                    }];
                    e[c][k] = Reg::splat(simd, view.sign[k]) * (to - from);
                }
            }
            let distances = [norm_squared(p[0]), norm_squared(p[1]), norm_squared(p[2])];
            // The nearest corner: an origin just above a face is far from its other corners, and the sum's rounding
            // with them.
            let (second, third) = (distances[1].less(distances[0]), distances[2].less(distances[0].min(distances[1])));
            let mut nearest = p[0];
            for c in 0..3 {
                nearest[c] = third.select(p[2][c], second.select(p[1][c], p[0][c]));
            }
            let (six_volume, terms) = volume(nearest, e[0], e[1], Reg::abs);
            let side = six_volume.less(zero).select(minus, one);
            let certain = (terms * tolerance).less(six_volume.abs());
            // Right, down, outward is left-handed: a positive volume faces the origin.
            certain.select(side, zero).store(&mut out.facing, part);
            let [u, v] = view.first_centre(simd, ranges, part);
            let mut least = Reg::splat(simd, f32::INFINITY);
            for k in 0..3 {
                let (a, b) = (p[k], p[(k + 1) % 3]);
                let nearer = distances[(k + 1) % 3].less(distances[k]);
                let m = [nearer.select(b[0], a[0]), nearer.select(b[1], a[1]), nearer.select(b[2], a[2])];
                let (n, terms) = edge(m, e[k], Reg::abs);
                let (n, widened) = ([side * n[0], side * n[1], side * n[2]], terms * tolerance);
                for c in 0..3 {
                    n[c].store(&mut out.normals[k][c], part);
                }
                widened.store(&mut out.tolerances[k], part);
                least = least.min(n[0] * u + (n[1] * v + (n[2] + widened)));
            }
            least.store(&mut out.first, part);
        }
        out
    }

    /// One triangle of the eight.
    #[inline(always)]
    fn triangle(&self, i: usize, x: [u32; 2], y: [u32; 2]) -> Triangle {
        let mut edges = [[0.0; 3]; 3];
        for k in 0..3 {
            let n = &self.normals[k];
            edges[k] = [n[0][i], n[1][i], n[2][i] + self.tolerances[k][i]];
        }
        Triangle { edges, x, y }
    }

    /// The same turned around.
    #[cold]
    fn turned(&self, i: usize, x: [u32; 2], y: [u32; 2]) -> Triangle {
        let mut edges = [[0.0; 3]; 3];
        for k in 0..3 {
            let n = &self.normals[k];
            edges[k] = [-n[0][i], -n[1][i], -n[2][i] + self.tolerances[k][i]];
        }
        Triangle { edges, x, y }
    }
}

/// A triangle ready to be tested against the rays of a face.
#[derive(Debug, Clone, Copy)]
struct Triangle {
    /// E(u, v) = n₀u + (n₁v + n₂) ≥ 0 inside, for each edge, widened by the error bound.
    edges: [[f32; 3]; 3],
    x: [u32; 2],
    y: [u32; 2],
}

impl Triangle {
    /// Whether the ray through the centre of texel (x, y) meets the triangle.
    fn covers(&self, x: usize, y: usize, centres: &[f32]) -> bool {
        let within = |range: [u32; 2], i: usize| (range[0] as usize..range[1] as usize).contains(&i);
        within(self.x, x)
            && within(self.y, y)
            && self.edges.iter().all(|n| n[0] * centres[x] + (n[1] * centres[y] + n[2]) >= 0.0)
    }

    /// Kills the rays that meet the triangle.
    ///
    /// As computed, E is monotone along a row, so the inner texels of a row are a run. Its ends are guessed from the
    /// root of the line and set right with the predicate itself.
    #[inline(always)]
    fn occlude(&self, live: &mut LiveRays, centres: &[f32]) {
        let (x0, x1) = (self.x[0] as usize, self.x[1] as usize);
        let half = 0.5 * centres.len() as f32;
        let e = &self.edges;
        let roots = [-half / e[0][0], -half / e[1][0], -half / e[2][0]];
        for y in self.y[0] as usize..self.y[1] as usize {
            if !live.any([self.x[0], self.x[1]], [y as u32, y as u32 + 1]) {
                continue;
            }
            let v = centres[y];
            let base = [e[0][1] * v + e[0][2], e[1][1] * v + e[1][2], e[2][1] * v + e[2][2]];
            let (mut first, mut end) = (x0, x1);
            for k in 0..3 {
                let (n, base) = (e[k][0], base[k]);
                let guess = ((base * roots[k] + half) as i32).max(0) as usize;
                if n > 0.0 {
                    let mut from = guess.min(end).max(first);
                    while from > first && n * centres[from - 1] + base >= 0.0 {
                        from -= 1;
                    }
                    while from < end && n * centres[from] + base < 0.0 {
                        from += 1;
                    }
                    first = from;
                } else if n < 0.0 {
                    let mut to = guess.min(end).max(first);
                    while to > first && n * centres[to - 1] + base < 0.0 {
                        to -= 1;
                    }
                    while to < end && n * centres[to] + base >= 0.0 {
                        to += 1;
                    }
                    end = to;
                } else if base < 0.0 {
                    end = first;
                }
                if first >= end {
                    break;
                }
            }
            if first < end {
                live.kill(y, first, end);
            }
        }
    }
}

/// A node or leaf that waits, and the texels it may cover.
#[derive(Debug, Clone, Copy)]
pub(super) struct Waiting {
    child: u32,
    x: [u16; 2],
    y: [u16; 2],
}

/// Kills the rays of a face that meet the mesh; run by `pulp` with the instructions that the machine has.
///
/// A struct, not a closure: a closure is called through a shim that is not inlined, and loses the dispatch.
pub(super) struct TraceFace<'a> {
    pub(super) bvh: &'a Bvh,
    pub(super) view: View,
    pub(super) live: &'a mut LiveRays,
    pub(super) centres: &'a [f32],
    pub(super) stack: &'a mut Vec<Waiting>,
}

impl pulp::WithSimd for TraceFace<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        trace_face(simd, self);
    }
}

#[inline(always)]
fn trace_face<S: Simd>(simd: S, job: TraceFace<'_>) {
    let TraceFace { bvh, view, live, centres, stack } = job;
    let side = centres.len() as u16;
    stack.clear();
    if bvh.leaves().is_empty() {
        return;
    }
    let root = if bvh.nodes().is_empty() { LEAF } else { 0 };
    stack.push(Waiting { child: root, x: [0, side], y: [0, side] });
    while let Some(Waiting { child, x, y }) = stack.pop() {
        if !live.any([x[0].into(), x[1].into()], [y[0].into(), y[1].into()]) {
            continue;
        }
        if child & LEAF != 0 {
            trace_leaf(simd, &bvh.leaves()[(child & !LEAF) as usize], &view, live, centres);
            continue;
        }
        let node = &bvh.nodes()[child as usize];
        let (ranges, keys) = view.project_boxes(simd, node);
        let bottom = stack.len();
        for i in 0..WIDTH {
            if ranges.some[i] > 0.0 && live.any(ranges.x(i), ranges.y(i)) {
                // Insertion sort, far to near, so that the nearest is popped first; until the end `child` is the lane.
                let (x, y) = (ranges.x(i), ranges.y(i));
                stack.push(Waiting { child: i as u32, x: [x[0] as u16, x[1] as u16], y: [y[0] as u16, y[1] as u16] });
                let mut at = stack.len() - 1;
                while at > bottom && keys[stack[at - 1].child as usize % WIDTH] < keys[i] {
                    stack.swap(at, at - 1);
                    at -= 1;
                }
            }
        }
        for waiting in &mut stack[bottom..] {
            waiting.child = node.children[waiting.child as usize % WIDTH];
        }
    }
}

#[inline(always)]
fn trace_leaf<S: Simd>(simd: S, leaf: &Leaf, view: &View, live: &mut LiveRays, centres: &[f32]) {
    let (corners, ranges) = project_leaf(simd, view, leaf);
    let mut open = 0_u32;
    for i in 0..leaf.len.min(WIDTH) {
        if ranges.some[i] > 0.0 && live.any(ranges.x(i), ranges.y(i)) {
            open |= 1 << i;
        }
    }
    if open == 0 {
        return;
    }
    let edges = Edges::new(simd, view, leaf, &corners, &ranges);
    while open != 0 {
        let i = open.trailing_zeros() as usize % WIDTH;
        open &= open - 1;
        if view.back_faces == BackFaces::Ignore && edges.facing[i] <= 0.0 {
            continue;
        }
        let (x, y) = (ranges.x(i), ranges.y(i));
        if x[0] + 1 == x[1] && y[0] + 1 == y[1] {
            // Most triangles of a fine mesh reach one texel: that one was tested for all eight at once.
            if edges.first[i] >= 0.0 {
                live.kill(y[0] as usize, x[0] as usize, x[1] as usize);
            }
        } else {
            edges.triangle(i, x, y).occlude(live, centres);
        }
        if edges.facing[i] == 0.0 {
            edges.turned(i, x, y).occlude(live, centres);
        }
    }
}

/// Whether the ray through the centre of texel (x, y) meets any triangle of the mesh: every triangle is tested.
///
/// The bits of [`TraceFace`] by a road without boxes, order or runs.
pub(super) fn occluded(bvh: &Bvh, view: &View, x: usize, y: usize, centres: &[f32]) -> bool {
    bvh.leaves().iter().any(|leaf| {
        let simd = pulp::Scalar;
        let (corners, ranges) = project_leaf(simd, view, leaf);
        let edges = Edges::new(simd, view, leaf, &corners, &ranges);
        (0..leaf.len).any(|i| {
            let (columns, rows) = (ranges.x(i), ranges.y(i));
            ranges.some[i] > 0.0
                && (view.back_faces == BackFaces::Occlude || edges.facing[i] > 0.0)
                && (edges.triangle(i, columns, rows).covers(x, y, centres)
                    || edges.facing[i] == 0.0 && edges.turned(i, columns, rows).covers(x, y, centres))
        })
    })
}
