//! Triangles as the rays of a patch meet them: three edge functions and a range of cells.

use pulp::Simd;

use super::chart::Chart;
use super::lanes::{Lanes, Reg, parts};
use super::orientation::Orientation;
use super::view::{Corners, Ranges, View};
use crate::scene::bvh::{EDGE_TOLERANCE, Leaf, WIDTH, edge, norm_squared, volume};

/// A triangle ready to be tested against the rays of a patch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    /// n · d + w ≥ 0 inside for each edge (n, w), d along right, down and out of the patch, w the error bound.
    pub(super) edges: [[f32; 4]; 3],
    /// Columns and rows of cells [first, end) that it may reach.
    pub(super) x: [u32; 2],
    pub(super) y: [u32; 2],
}

impl Triangle {
    /// The edges as functions of (u, v), d = (u, v, 1): n₀u + (n₁v + n₂) ≥ 0 inside.
    #[inline(always)]
    pub(super) fn along_patch(&self) -> [[f32; 3]; 3] {
        self.edges.map(|[x, y, z, w]| [x, y, z + w])
    }

    /// Whether a cell is in the range.
    pub(super) fn reaches(&self, [x, y]: [usize; 2]) -> bool {
        let within = |range: [u32; 2], i: usize| (range[0] as usize..range[1] as usize).contains(&i);
        within(self.x, x) && within(self.y, y)
    }

    /// Whether the direction d is on the inner side of all three edges.
    #[inline(always)]
    pub(super) fn is_inside(&self, d: [f32; 3]) -> bool {
        self.edges.iter().all(|n| n[0] * d[0] + (n[1] * d[1] + (n[2] * d[2] + n[3])) >= 0.0)
    }
}

/// The edges of eight triangles, turned so that n · (u, v, 1) ≥ 0 inside, and the error bounds that widen them.
pub(super) struct Edges {
    /// `normals[edge][component][lane]`.
    normals: [[Lanes; 3]; 3],
    tolerances: [Lanes; 3],
    /// Positive if the origin sees the front, negative if the back, 0 if it is in the plane to the rounding error.
    pub(super) facing: Lanes,
    /// The least of the three edge functions, widened, at the centre of the first cell of each range.
    pub(super) first: Lanes,
}

impl Edges {
    /// `side`: the cells along the patch if rays pass through their centres; else `first` is not worked out.
    #[inline(always)]
    pub(super) fn new<S: Simd, O: Orientation, C: Chart>(
        simd: S,
        view: &View<O, C>,
        leaf: &Leaf,
        corners: &Corners,
        ranges: &Ranges,
        side: Option<usize>,
    ) -> Self {
        let zeros = [0.0; WIDTH];
        let mut out = Self { normals: [[zeros; 3]; 3], tolerances: [zeros; 3], facing: zeros, first: zeros };
        let orientation = view.orientation;
        for part in 0..parts::<S>() {
            let [zero, hand, tolerance] = [0.0, O::HAND, EDGE_TOLERANCE * orientation.widening()].map(
                #[inline(always)]
                |x| Reg::splat(simd, x),
            );
            let [one, minus] = [1.0, -1.0].map(
                #[inline(always)]
                |x| Reg::splat(simd, x),
            );
            let (mut p, mut e) = ([[zero; 3]; 3], [[zero; 3]; 3]);
            for c in 0..3 {
                for k in 0..3 {
                    p[c][k] = Reg::load(simd, &corners[c][k], part);
                }
                e[c] = orientation.edge(simd, leaf, [c, (c + 1) % 3], part);
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
            let inner = six_volume.less(zero).select(minus, one);
            let certain = (terms * Reg::splat(simd, EDGE_TOLERANCE)).less(six_volume.abs());
            certain.select(inner * hand, zero).store(&mut out.facing, part);
            let mut least = Reg::splat(simd, f32::INFINITY);
            for k in 0..3 {
                let (a, b) = (p[k], p[(k + 1) % 3]);
                let nearer = distances[(k + 1) % 3].less(distances[k]);
                let m = [nearer.select(b[0], a[0]), nearer.select(b[1], a[1]), nearer.select(b[2], a[2])];
                let (n, terms) = edge(m, e[k], Reg::abs);
                let (n, widened) =
                    (orientation.turn(simd, [inner * n[0], inner * n[1], inner * n[2]]), terms * tolerance);
                for c in 0..3 {
                    n[c].store(&mut out.normals[k][c], part);
                }
                widened.store(&mut out.tolerances[k], part);
                if let Some(side) = side {
                    let [u, v] = ranges.first_centre(simd, side, part);
                    least = least.min(n[0] * u + (n[1] * v + (n[2] + widened)));
                }
            }
            least.store(&mut out.first, part);
        }
        out
    }

    /// One triangle of the eight.
    #[inline(always)]
    pub(super) fn triangle(&self, i: usize, x: [u32; 2], y: [u32; 2]) -> Triangle {
        let mut edges = [[0.0; 4]; 3];
        for k in 0..3 {
            let n = &self.normals[k];
            edges[k] = [n[0][i], n[1][i], n[2][i], self.tolerances[k][i]];
        }
        Triangle { edges, x, y }
    }

    /// The same turned around.
    #[cold]
    pub(super) fn turned(&self, i: usize, x: [u32; 2], y: [u32; 2]) -> Triangle {
        let mut edges = [[0.0; 4]; 3];
        for k in 0..3 {
            let n = &self.normals[k];
            edges[k] = [-n[0][i], -n[1][i], -n[2][i], self.tolerances[k][i]];
        }
        Triangle { edges, x, y }
    }
}
