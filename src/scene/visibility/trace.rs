//! All rays of one patch of directions at once, from one origin.
//!
//! Rays that share an origin are the pixels of a picture, so the patch is rasterised instead of traced: boxes and
//! triangles are projected to ranges of cells, and whatever covers no living ray is passed over. Boxes are visited
//! front to back, so that near faces kill the rays of the far ones. One ray and all rays use the same predicate (E ≥ 0
//! for the three edges, within the triangle's range of cells); the walk only leaves out triangles that cannot cover a
//! living ray, so that it gives exactly the bits of testing every triangle against every ray.

use pulp::Simd;

use super::chart::Chart;
use super::orientation::Orientation;
use super::triangle::{Edges, Triangle};
use super::view::View;
use crate::scene::BackFaces;
use crate::scene::bvh::{Bvh, LEAF, Leaf, WIDTH};

/// The rays of a patch that have met nothing yet.
pub(super) trait Rays {
    /// Cells along the patch.
    fn side(&self) -> usize;

    /// Whether each cell has one ray, (u, v, 1) through its centre.
    const CENTRES: bool;

    /// Whether any ray in the cells of columns x.0..x.1 and rows y.0..y.1 lives.
    fn any(&self, x: [u32; 2], y: [u32; 2]) -> bool;

    /// Kills the rays that meet the triangle.
    fn occlude(&mut self, triangle: &Triangle);

    /// Kills the ray through the centre of a cell; asked only of rays with [`CENTRES`](Self::CENTRES).
    fn kill(&mut self, x: u32, y: u32);
}

/// A node or leaf that waits, and the cells it may cover.
#[derive(Debug, Clone, Copy)]
pub(super) struct Waiting {
    child: u32,
    x: [u16; 2],
    y: [u16; 2],
}

/// Kills the rays of a patch that meet the mesh; run by `pulp` with the instructions that the machine has.
///
/// A struct, not a closure: a closure is called through a shim that is not inlined, and loses the dispatch.
pub(super) struct TracePatch<'a, O, C, R> {
    pub(super) bvh: &'a Bvh,
    pub(super) view: View<O, C>,
    pub(super) rays: R,
    pub(super) stack: &'a mut Vec<Waiting>,
}

impl<O: Orientation, C: Chart, R: Rays> pulp::WithSimd for TracePatch<'_, O, C, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        trace_patch(simd, self);
    }
}

#[inline(always)]
fn trace_patch<S: Simd, O: Orientation, C: Chart, R: Rays>(simd: S, job: TracePatch<'_, O, C, R>) {
    let TracePatch { bvh, view, mut rays, stack } = job;
    let side = rays.side() as u16;
    stack.clear();
    if bvh.leaves().is_empty() {
        return;
    }
    let root = if bvh.nodes().is_empty() { LEAF } else { 0 };
    stack.push(Waiting { child: root, x: [0, side], y: [0, side] });
    while let Some(Waiting { child, x, y }) = stack.pop() {
        if !rays.any([x[0].into(), x[1].into()], [y[0].into(), y[1].into()]) {
            continue;
        }
        if child & LEAF != 0 {
            trace_leaf(simd, &bvh.leaves()[(child & !LEAF) as usize], &view, &mut rays);
            continue;
        }
        let node = &bvh.nodes()[child as usize];
        let (ranges, keys) = view.project_boxes(simd, node);
        let bottom = stack.len();
        let mut some = ranges.some();
        while some != 0 {
            let i = some.trailing_zeros() as usize % WIDTH;
            some &= some - 1;
            if rays.any(ranges.x(i), ranges.y(i)) {
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
fn trace_leaf<S: Simd, O: Orientation, C: Chart, R: Rays>(simd: S, leaf: &Leaf, view: &View<O, C>, rays: &mut R) {
    let (corners, ranges) = view.project_leaf(simd, leaf);
    let (mut some, mut open) = (ranges.some() & ((1 << leaf.len) - 1), 0_u32);
    while some != 0 {
        let i = some.trailing_zeros() as usize % WIDTH;
        some &= some - 1;
        open |= u32::from(rays.any(ranges.x(i), ranges.y(i))) << i;
    }
    if open == 0 {
        return;
    }
    let side = if R::CENTRES { Some(rays.side()) } else { None };
    let edges = Edges::new(simd, view, leaf, &corners, &ranges, side);
    while open != 0 {
        let i = open.trailing_zeros() as usize % WIDTH;
        open &= open - 1;
        if view.back_faces == BackFaces::Ignore && edges.facing[i] <= 0.0 {
            continue;
        }
        let (x, y) = (ranges.x(i), ranges.y(i));
        if R::CENTRES && x[0] + 1 == x[1] && y[0] + 1 == y[1] {
            // Most triangles of a fine mesh reach one cell: that one was tested for all eight at once.
            if edges.first[i] >= 0.0 {
                rays.kill(x[0], y[0]);
            }
        } else {
            rays.occlude(&edges.triangle(i, x, y));
        }
        if edges.facing[i] == 0.0 {
            rays.occlude(&edges.turned(i, x, y));
        }
    }
}

/// Whether a ray, in a cell of the patch, meets any triangle of the mesh: every triangle is tested.
///
/// The bits of [`TracePatch`] by a road without boxes, order or runs.
pub(super) fn occluded<O: Orientation, C: Chart>(
    bvh: &Bvh,
    view: &View<O, C>,
    cell: [usize; 2],
    is_inside: impl Fn(&Triangle) -> bool,
) -> bool {
    let covers = |triangle: &Triangle| triangle.reaches(cell) && is_inside(triangle);
    bvh.leaves().iter().any(|leaf| {
        let simd = pulp::Scalar;
        let (corners, ranges) = view.project_leaf(simd, leaf);
        let edges = Edges::new(simd, view, leaf, &corners, &ranges, None);
        (0..leaf.len).any(|i| {
            let (columns, rows) = (ranges.x(i), ranges.y(i));
            ranges.some() >> i & 1 == 1
                && (view.back_faces == BackFaces::Occlude || edges.facing[i] > 0.0)
                && (covers(&edges.triangle(i, columns, rows))
                    || edges.facing[i] == 0.0 && covers(&edges.turned(i, columns, rows)))
        })
    })
}
