//! How a disc of the sky is shared out among the texels of a cube.

use nalgebra::{UnitVector3, Vector3};

use crate::sphere::{CubeGrid, Face};

/// The solid angle of a disc of angular radius r, 2π(1 − cos r), without cancellation.
pub(super) fn disc_solid_angle(radius: f64) -> f64 {
    4.0 * std::f64::consts::PI * (0.5 * radius).sin().powi(2)
}

/// The texels that a disc touches and the solid angle it has on each; they sum to the disc's exactly.
///
/// Texels are quartered until a piece lies inside, outside, or is smaller than radius/64; such a piece is cut by the
/// rim as by a straight line. The remaining error is spread by normalising the sum.
pub(super) fn disc_shares(grid: CubeGrid, centre: &UnitVector3<f64>, radius: f64) -> Vec<(usize, f64)> {
    let disc = Disc { centre: **centre, radius, finest: radius / 64.0 };
    let mut shares: Vec<(usize, f64)> = (0..grid.len())
        .filter_map(|i| {
            let (face, x, y) = grid.texel(i);
            let share = disc.share(face, [grid.line(x), grid.line(x + 1)], [grid.line(y), grid.line(y + 1)]);
            (share > 0.0).then_some((i, share))
        })
        .collect();
    let sum: f64 = shares.iter().map(|(_, share)| share).sum();
    if sum > 0.0 {
        let scale = disc_solid_angle(radius) / sum;
        shares.iter_mut().for_each(|(_, share)| *share *= scale);
    }
    shares
}

struct Disc {
    centre: Vector3<f64>,
    radius: f64,
    finest: f64,
}

impl Disc {
    /// The solid angle that the disc and a rectangle of a face share.
    fn share(&self, face: Face, u: [f64; 2], v: [f64; 2]) -> f64 {
        let (mid_u, mid_v) = (0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1]));
        let middle = face.point(mid_u, mid_v);
        // The corner farthest from the middle in angle bounds the piece: a convex piece lies in the cone through it.
        let reach = [(u[0], v[0]), (u[1], v[0]), (u[0], v[1]), (u[1], v[1])]
            .map(|(u, v)| angle(&face.point(u, v), &middle))
            .into_iter()
            .fold(0.0, f64::max);
        let distance = angle(&self.centre, &middle);
        if distance >= self.radius + reach {
            return 0.0;
        }
        let whole = || {
            let corner = |x: f64, y: f64| (x * y).atan2((x * x + y * y + 1.0).sqrt());
            corner(u[1], v[1]) - corner(u[0], v[1]) - corner(u[1], v[0]) + corner(u[0], v[0])
        };
        if distance + reach <= self.radius {
            return whole();
        }
        if reach <= self.finest {
            // A straight rim across a square of half-diagonal `reach` seen along its side.
            let half_side = reach * std::f64::consts::FRAC_1_SQRT_2;
            return whole() * (0.5 + (self.radius - distance) / (2.0 * half_side)).clamp(0.0, 1.0);
        }
        let halves = |t: [f64; 2], mid: f64| [[t[0], mid], [mid, t[1]]];
        let quarters = halves(v, mid_v).map(|v| halves(u, mid_u).map(|u| self.share(face, u, v)));
        quarters.iter().flatten().sum()
    }
}

/// The angle between two vectors, accurate also where it is small.
pub(super) fn angle(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}
