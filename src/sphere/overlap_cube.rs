//! Exact solid angles that a spherical quadrilateral shares with the texels of a cube.
//!
//! Great circles are straight lines on a cube face, so the overlap is a convex polygon: the quadrilateral is clipped to
//! each face's pyramid, then to columns, then to rows, and the triangles of its fan are measured on the sphere by
//! ```math
//! tan(E/2) = p·(q × r)/(|p||q||r| + (p·q)|r| + (q·r)|p| + (r·p)|q|)          [Van Oosterom & Strackee 1983]
//! ```
//! where p·(q × r) is twice the planar area, free of cancellation.

use nalgebra::Vector3;

use super::overlap_lat_long::Quad;
use super::{CubeGrid, Face};

/// Corners that a quadrilateral can gain: one for each of the 4 + 2 + 2 cuts.
const MAX_CORNERS: usize = 12;

/// A convex polygon in homogeneous face coordinates (right, down, out).
#[derive(Debug, Clone, Copy)]
struct Polygon {
    corners: [[f64; 3]; MAX_CORNERS],
    len: usize,
}

impl Polygon {
    fn corners(&self) -> &[[f64; 3]] {
        &self.corners[..self.len]
    }

    /// The part on which `distance`, a linear form, is not negative.
    fn clip(&self, distance: impl Fn(&[f64; 3]) -> f64) -> Self {
        let corners = self.corners();
        if corners.iter().all(|c| distance(c) >= 0.0) {
            return *self;
        }
        let mut kept = Self { corners: [[0.0; 3]; MAX_CORNERS], len: 0 };
        for (k, corner) in corners.iter().enumerate() {
            let before = &corners[(k + self.len - 1) % self.len];
            let (a, b) = (distance(before), distance(corner));
            if (a < 0.0) != (b < 0.0) {
                let t = a / (a - b);
                kept.push(std::array::from_fn(|i| before[i] + t * (corner[i] - before[i])));
            }
            if b >= 0.0 {
                kept.push(*corner);
            }
        }
        kept
    }

    /// Rounding can make a convex polygon cross a line more than twice; what does not fit then has no area.
    fn push(&mut self, corner: [f64; 3]) {
        if self.len < MAX_CORNERS {
            self.corners[self.len] = corner;
            self.len += 1;
        }
    }

    /// The solid angle of a polygon with all corners at distance 1.
    fn solid_angle(&self) -> f64 {
        let corners = self.corners();
        let Some((p, rest)) = corners.split_first() else { return 0.0 };
        let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + 1.0;
        let norm_p = dot(p, p).sqrt();
        let fan = rest.windows(2).map(|pair| {
            let (q, r) = (&pair[0], &pair[1]);
            let twice_area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
            let (norm_q, norm_r) = (dot(q, q).sqrt(), dot(r, r).sqrt());
            let rest = norm_p * norm_q * norm_r + dot(p, q) * norm_r + dot(q, r) * norm_p + dot(r, p) * norm_q;
            2.0 * twice_area.atan2(rest)
        });
        fan.sum::<f64>().abs()
    }
}

/// Calls `visit` with every texel of `grid` that the quadrilateral overlaps and the solid angle they share.
pub(super) fn overlaps(grid: CubeGrid, quad: &Quad, mut visit: impl FnMut(usize, f64)) {
    for face in Face::ALL {
        let axes = face.axes().map(Vector3::from);
        let mut polygon = Polygon { corners: [[0.0; 3]; MAX_CORNERS], len: 4 };
        for (slot, corner) in polygon.corners.iter_mut().zip(&quad.corners) {
            *slot = axes.map(|axis| axis.dot(corner));
        }
        let pyramid: [fn(&[f64; 3]) -> f64; 4] = [|c| c[2] - c[0], |c| c[2] + c[0], |c| c[2] - c[1], |c| c[2] + c[1]];
        if pyramid.iter().any(|distance| polygon.corners().iter().all(|c| distance(c) <= 0.0)) {
            continue;
        }
        for distance in pyramid {
            polygon = polygon.clip(distance);
        }
        for c in &mut polygon.corners[..polygon.len] {
            *c = [c[0] / c[2], c[1] / c[2], 1.0];
        }
        for column in cells(grid, &polygon, 0) {
            let strip = polygon.clip(|c| c[0] - grid.line(column)).clip(|c| grid.line(column + 1) - c[0]);
            for row in cells(grid, &strip, 1) {
                let cell = strip.clip(|c| c[1] - grid.line(row)).clip(|c| grid.line(row + 1) - c[1]);
                let shared = cell.solid_angle();
                if shared > 0.0 {
                    visit(grid.index(face, column, row), shared);
                }
            }
        }
    }
}

/// The columns (axis 0) or rows (axis 1) that a polygon reaches.
fn cells(grid: CubeGrid, polygon: &Polygon, axis: usize) -> std::ops::Range<usize> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for c in polygon.corners() {
        low = low.min(c[axis]);
        high = high.max(c[axis]);
    }
    if low > high {
        return 0..0;
    }
    let side = grid.side() as f64;
    let position = |t: f64| ((t + 1.0) * 0.5 * side).clamp(0.0, side);
    let first = (position(low) as usize).min(grid.side() - 1);
    first..(position(high).ceil() as usize).max(first + 1)
}
