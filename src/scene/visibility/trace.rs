//! All rays of one cube face at once, from one origin.
//!
//! Rays that share an origin are the pixels of a picture, so the face is rasterised instead of traced: boxes and triangles are
//! projected to ranges of texels, and whatever covers no living ray is passed over. Boxes are visited front to
//! back, so that near faces kill the rays of the far ones. One ray and all rays use the same predicate
//! ([`Triangle::covers`]); the walk only leaves out triangles that cannot cover a living ray, so that it gives exactly the
//! bits of testing every triangle against every ray.

use super::super::bvh::{Bvh, EDGE_TOLERANCE, LEAF, Leaf, WIDTH, WideNode, edge, volume};
use super::BackFaces;
use super::live::{LiveRays, run};
use crate::sphere::Face;

/// A projected triangle is searched this much beyond its corners, in face coordinates a unit of side: covers the
/// rounding of the projection (2^-22 · side texels) and the tips of triangles widened by the edge tolerance.
const RANGE_PAD: f32 = 1e-6;

/// Boxes whose far side is nearer than this, in scene units, are behind the origin's face.
const NEAREST: f32 = 1e-20;

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

    /// Ranges of texels, [first, end) in columns and rows, of eight boxes, and their sort key, near before far.
    ///
    /// A box with z in [z₀, z₁], z₁ > 0 has its smallest x/z at z₀ if x₀ < 0 and at z₁ otherwise; −∞ if z₀ ≤ 0.
    #[inline(always)]
    fn project_boxes(&self, node: &WideNode) -> ([[u32; 2]; WIDTH], [[u32; 2]; WIDTH], [f32; WIDTH]) {
        let mut low = [[0.0; WIDTH]; 3];
        let mut high = [[0.0; WIDTH]; 3];
        for k in 0..3 {
            let (axis, sign, origin) = (self.axis[k], self.sign[k], self.origin[k]);
            let (a, b) = if sign > 0.0 { (axis, axis + 3) } else { (axis + 3, axis) };
            for i in 0..WIDTH {
                low[k][i] = sign * (node.bounds[a][i] - origin);
                high[k][i] = sign * (node.bounds[b][i] - origin);
            }
        }
        let mut key = [0.0; WIDTH];
        for i in 0..WIDTH {
            key[i] = low[2][i] + high[2][i];
        }
        let (x, y) = self.ranges(&low, &high);
        (x, y, key)
    }

    /// Texel ranges of eight boxes given in the face's axes; empty ranges for boxes behind it.
    #[inline(always)]
    fn ranges(&self, low: &[[f32; WIDTH]; 3], high: &[[f32; WIDTH]; 3]) -> ([[u32; 2]; WIDTH], [[u32; 2]; WIDTH]) {
        let mut inverse_near = [0.0; WIDTH];
        let mut inverse_far = [0.0; WIDTH];
        for i in 0..WIDTH {
            inverse_near[i] = if low[2][i] > NEAREST { 1.0 / low[2][i] } else { f32::INFINITY };
            inverse_far[i] = 1.0 / high[2][i].max(NEAREST);
        }
        let mut out = [[[0; 2]; WIDTH]; 2];
        for k in 0..2 {
            for i in 0..WIDTH {
                let least = low[k][i] * if low[k][i] < 0.0 { inverse_near[i] } else { inverse_far[i] };
                let most = high[k][i] * if high[k][i] > 0.0 { inverse_near[i] } else { inverse_far[i] };
                let front = high[2][i] > NEAREST;
                out[k][i] = self.range(least, if front { most } else { f32::NEG_INFINITY });
            }
        }
        let [x, y] = out;
        (x, y)
    }

    /// The texels [first, end) whose centre is in [least, most], a little widened.
    ///
    /// The centre of texel i is at (2i + 1)/side − 1, so i ≥ (least + 1) side/2 − ½ rounds to the nearest integer of
    /// (least + 1) side/2; likewise the end.
    #[inline(always)]
    fn range(&self, least: f32, most: f32) -> [u32; 2] {
        let (half, pad) = (0.5 * self.side, RANGE_PAD * self.side);
        let nearest = |t: f32| {
            // Adding 1.5 · 2^23 leaves the nearest integer in the low bits.
            (t.max(0.0).min(self.side) + 12_582_912.0).to_bits() - 0x4B40_0000
        };
        [nearest(least * half + (half - pad)), nearest(most * half + (half + pad))]
    }
}

/// A triangle ready to be tested against the rays of a face.
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    /// E(u, v) = n₀u + (n₁v + n₂) ≥ 0 inside, for each edge, widened by the error bound.
    edges: [[f32; 3]; 3],
    /// The same for the other orientation, where rounding leaves the orientation open.
    turned: Option<[[f32; 3]; 3]>,
    x: [u32; 2],
    y: [u32; 2],
}

impl Triangle {
    /// Triangle `lane` of a leaf, `corners` relative to the origin in the face's axes; None if it cannot be hit.
    #[inline(always)]
    fn new(view: &View, leaf: &Leaf, lane: usize, corners: [[f32; 3]; 3], x: [u32; 2], y: [u32; 2]) -> Option<Self> {
        let along = |k: usize, from: usize, to: usize| {
            let a = view.axis[k];
            view.sign[k] * (leaf.corners[to][a][lane] - leaf.corners[from][a][lane])
        };
        // Written out: an unnamed closure handed to `map` stays a call in the dispatched code.
        let e = [
            [along(0, 0, 1), along(1, 0, 1), along(2, 0, 1)],
            [along(0, 1, 2), along(1, 1, 2), along(2, 1, 2)],
            [along(0, 2, 0), along(1, 2, 0), along(2, 2, 0)],
        ];
        let (six_volume, terms) = volume(corners[0], e[0], e[1]);
        let certain = six_volume.abs() > EDGE_TOLERANCE * terms;
        // Right, down, outward is left-handed: a positive volume faces the origin.
        if view.back_faces == BackFaces::Ignore && !(certain && six_volume > 0.0) {
            return None;
        }
        let mut edges = [[0.0; 3]; 3];
        let mut turned = [[0.0; 3]; 3];
        let side = if six_volume < 0.0 { -1.0 } else { 1.0 };
        for k in 0..3 {
            let (n, q) = edge(corners[k], corners[(k + 1) % 3], e[k]);
            let tolerance = EDGE_TOLERANCE * q;
            edges[k] = [side * n[0], side * n[1], side * n[2] + tolerance];
            turned[k] = [-side * n[0], -side * n[1], -side * n[2] + tolerance];
        }
        Some(Self { edges, turned: (!certain).then_some(turned), x, y })
    }

    /// Whether the ray through the centre of texel (x, y) meets the triangle.
    #[inline(always)]
    fn covers(&self, x: usize, y: usize, centres: &[f32]) -> bool {
        let inside =
            |edges: &[[f32; 3]; 3]| edges.iter().all(|n| n[0] * centres[x] + (n[1] * centres[y] + n[2]) >= 0.0);
        let within = |range: [u32; 2], i: usize| (range[0] as usize..range[1] as usize).contains(&i);
        within(self.x, x) && within(self.y, y) && (inside(&self.edges) || self.turned.as_ref().is_some_and(inside))
    }

    /// Kills the rays that meet the triangle.
    #[inline(always)]
    fn occlude(&self, live: &mut LiveRays, centres: &[f32]) {
        occlude_inside(&self.edges, self.x, self.y, live, centres);
        if let Some(turned) = &self.turned {
            occlude_inside(turned, self.x, self.y, live, centres);
        }
    }
}

/// Kills the rays of a range of texels on the inner side of three edges.
///
/// As computed, E is monotone along a row, so the inner texels of a row are a run. Its ends are guessed from the root of the line and
/// set right with the predicate itself.
#[inline(always)]
fn occlude_inside(edges: &[[f32; 3]; 3], x: [u32; 2], y: [u32; 2], live: &mut LiveRays, centres: &[f32]) {
    let (x0, x1) = (x[0] as usize, x[1] as usize);
    let half = 0.5 * centres.len() as f32;
    let roots = [-half / edges[0][0], -half / edges[1][0], -half / edges[2][0]];
    for y in y[0] as usize..y[1] as usize {
        let (mut first, mut end) = (x0, x1);
        for (n, root) in edges.iter().zip(roots) {
            let base = n[1] * centres[y] + n[2];
            let inside = |x: usize| n[0] * centres[x] + base >= 0.0;
            let guess = (base * root + half) as usize;
            if n[0] > 0.0 {
                let mut from = guess.clamp(first, end);
                while from > first && inside(from - 1) {
                    from -= 1;
                }
                while from < end && !inside(from) {
                    from += 1;
                }
                first = from;
            } else if n[0] < 0.0 {
                let mut to = guess.clamp(first, end);
                while to > first && !inside(to - 1) {
                    to -= 1;
                }
                while to < end && inside(to) {
                    to += 1;
                }
                end = to;
            } else if !(base >= 0.0) {
                end = first;
            }
            if first >= end {
                break;
            }
        }
        if first < end {
            let row = live.row_mut(y);
            for w in first / 64..end.div_ceil(64) {
                row[w] &= !run(first, end, w);
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
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { bvh, view, live, centres, stack } = self;
        trace_face(bvh, &view, live, centres, stack);
    }
}

#[inline(always)]
fn trace_face(bvh: &Bvh, view: &View, live: &mut LiveRays, centres: &[f32], stack: &mut Vec<Waiting>) {
    let side = centres.len() as u16;
    stack.clear();
    let root = if bvh.nodes().is_empty() { LEAF } else { 0 };
    stack.push(Waiting { child: root, x: [0, side], y: [0, side] });
    while let Some(Waiting { child, x, y }) = stack.pop() {
        if !live.any([x[0].into(), x[1].into()], [y[0].into(), y[1].into()]) {
            continue;
        }
        if child & LEAF != 0 {
            trace_leaf(&bvh.leaves()[(child & !LEAF) as usize], view, live, centres);
            continue;
        }
        let node = &bvh.nodes()[child as usize];
        let (x, y, key) = view.project_boxes(node);
        let bottom = stack.len();
        for i in 0..WIDTH {
            if x[i][0] < x[i][1] && y[i][0] < y[i][1] && live.any(x[i], y[i]) {
                // Insertion sort, far to near, so that the nearest is popped first; the keys of what is pushed are here.
                let (x, y) = ([x[i][0] as u16, x[i][1] as u16], [y[i][0] as u16, y[i][1] as u16]);
                stack.push(Waiting { child: i as u32, x, y });
                let mut at = stack.len() - 1;
                while at > bottom && key[stack[at - 1].child as usize % WIDTH] < key[i] {
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

/// The corners of a leaf's triangles relative to the origin in the face's axes, and their texel ranges.
#[inline(always)]
fn project_leaf(view: &View, leaf: &Leaf) -> ([[[f32; WIDTH]; 3]; 3], [[u32; 2]; WIDTH], [[u32; 2]; WIDTH]) {
    let mut corners = [[[0.0; WIDTH]; 3]; 3];
    for c in 0..3 {
        for k in 0..3 {
            let (axis, sign, origin) = (view.axis[k], view.sign[k], view.origin[k]);
            for i in 0..WIDTH {
                corners[c][k][i] = sign * (leaf.corners[c][axis][i] - origin);
            }
        }
    }
    let mut low = [[0.0; WIDTH]; 3];
    let mut high = [[0.0; WIDTH]; 3];
    for k in 0..3 {
        for i in 0..WIDTH {
            let [a, b, c] = [corners[0][k][i], corners[1][k][i], corners[2][k][i]];
            low[k][i] = a.min(b).min(c);
            high[k][i] = a.max(b).max(c);
        }
    }
    let (mut x, mut y) = view.ranges(&low, &high);
    // In front as a whole: the corners' own projections are tighter than the box's.
    let mut inverse = [[0.0; WIDTH]; 3];
    for c in 0..3 {
        for i in 0..WIDTH {
            inverse[c][i] = 1.0 / corners[c][2][i];
        }
    }
    for (k, range) in [(0, &mut x), (1, &mut y)] {
        for i in 0..WIDTH {
            let (a, b) = (corners[0][k][i] * inverse[0][i], corners[1][k][i] * inverse[1][i]);
            let c = corners[2][k][i] * inverse[2][i];
            let tight = view.range(a.min(b).min(c), a.max(b).max(c));
            range[i] = if low[2][i] > NEAREST { tight } else { range[i] };
        }
    }
    (corners, x, y)
}

/// The corners of one triangle of eight.
#[inline(always)]
fn corners_of(corners: &[[[f32; WIDTH]; 3]; 3], i: usize) -> [[f32; 3]; 3] {
    let mut own = [[0.0; 3]; 3];
    for c in 0..3 {
        for k in 0..3 {
            own[c][k] = corners[c][k][i];
        }
    }
    own
}

#[inline(always)]
fn trace_leaf(leaf: &Leaf, view: &View, live: &mut LiveRays, centres: &[f32]) {
    let (corners, x, y) = project_leaf(view, leaf);
    for i in 0..WIDTH {
        if x[i][0] < x[i][1] && y[i][0] < y[i][1] && live.any(x[i], y[i]) {
            let own = corners_of(&corners, i);
            if let Some(triangle) = Triangle::new(view, leaf, i, own, x[i], y[i]) {
                triangle.occlude(live, centres);
            }
        }
    }
}

/// Whether the ray through the centre of texel (x, y) meets any triangle of the mesh: every triangle is tested.
///
/// The bits of [`TraceFace`] by a road without boxes, order or runs.
pub(super) fn occluded(bvh: &Bvh, view: &View, x: usize, y: usize, centres: &[f32]) -> bool {
    bvh.leaves().iter().any(|leaf| {
        let (corners, columns, rows) = project_leaf(view, leaf);
        (0..WIDTH).any(|i| {
            let own = corners_of(&corners, i);
            columns[i][0] < columns[i][1]
                && rows[i][0] < rows[i][1]
                && Triangle::new(view, leaf, i, own, columns[i], rows[i])
                    .is_some_and(|triangle| triangle.covers(x, y, centres))
        })
    })
}
