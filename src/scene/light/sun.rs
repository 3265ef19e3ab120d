//! How a disc of the sky is shared out among the texels of a cube.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use nalgebra::{Rotation3, UnitVector3, Vector3};

use crate::sphere::{CubeGrid, Face};
use crate::{Error, Result};

/// A disc of constant radiance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Where its centre stands.
    pub direction: UnitVector3<f64>,
    /// Angular radius in radians, in (0, π/2], down to the smallest number; the real sun's is 0.00465. A point, of
    /// which a radiance cannot say how bright it is, comes from [`with_irradiance`](Self::with_irradiance).
    pub angular_radius: f64,
    /// Radiance of the disc, added to the sky's. Irradiance on a surface that faces it is radiance · π sin² radius.
    pub radiance: Vector3<f64>,
}

/// Below this angular radius a disc is cut as a flat one, which is off by radius² relative; from it on by quartering.
const FLAT: f64 = 1e-6;
/// Quarterings of a piece: from π/2 down to [`FLAT`]/64, which needs 28, with room.
const MAX_DEPTH: u32 = 40;

impl Sun {
    /// A disc of a given irradiance on a surface that faces it: radiance = irradiance / (π sin² angular_radius).
    ///
    /// Any disc well below a texel gives the same map, so that a point source is a disc of radius 1e-6, say. A radius
    /// of 0 is refused: no finite radiance gives a point energy.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] or [`Error::NotFinite`] unless the irradiance is finite and not negative, the radius in
    /// (0, π/2], and the radiance that follows from both finite: below a radius of 1e-154 or so it cannot be.
    ///
    /// # Example
    /// ```
    /// use haarmonic::{nalgebra::Vector3, scene::Sun};
    /// let sun = Sun::with_irradiance(Vector3::y_axis(), Vector3::repeat(3.0), 1e-6)?;
    /// assert!((sun.radiance.x * std::f64::consts::PI * 1e-12 / 3.0 - 1.0).abs() < 1e-12);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn with_irradiance(direction: UnitVector3<f64>, irradiance: Vector3<f64>, angular_radius: f64) -> Result<Self> {
        for &e in &irradiance {
            check_range("sun's irradiance", e, e >= 0.0, "not negative")?;
        }
        check_radius(angular_radius)?;
        // Two divisions: sin² underflows long before its quotient need overflow.
        let radiance = irradiance.map(|e| e / PI / angular_radius.sin() / angular_radius.sin());
        if radiance.iter().any(|l| !l.is_finite()) {
            let allowed = "large enough for a finite radiance, irradiance/(π sin² radius)";
            return Err(Error::OutOfRange { what: "sun's angular radius", got: angular_radius, allowed });
        }
        Ok(Self { direction, angular_radius, radiance })
    }

    /// ∫ L dω over the disc, radiance · 2π(1 − cos r), without cancellation and without an early underflow of r².
    pub(super) fn energy(&self) -> Vector3<f64> {
        let chord = 2.0 * PI.sqrt() * (0.5 * self.angular_radius).sin();
        self.radiance * chord * chord
    }

    /// What every texel of `grid` gets of the disc turned by `rotation`: the texel's index and its mean radiance.
    pub(super) fn texels(
        &self,
        grid: CubeGrid,
        rotation: &Rotation3<f64>,
    ) -> impl Iterator<Item = (usize, Vector3<f64>)> {
        let (energy, omega) = (self.energy(), grid.face_solid_angles());
        disc_shares(grid, &(rotation * self.direction), self.angular_radius)
            .into_iter()
            .map(move |(i, share)| (i, energy * (share / omega[i % omega.len()])))
    }
}

/// Refuses a radius outside (0, π/2].
pub(super) fn check_radius(radius: f64) -> Result<()> {
    let allowed = "in (0, π/2]; a point is given by its irradiance, see Sun::with_irradiance";
    check_range("sun's angular radius", radius, radius > 0.0 && radius <= std::f64::consts::FRAC_PI_2, allowed)
}

/// The texels that a disc touches and the part of the disc that each of them holds; the parts sum to 1.
///
/// Texels are quartered until a piece lies inside, outside, or is smaller than radius/64; such a piece is cut by the
/// rim as by a straight line. Of a disc too small for that the texels' edges are straight lines instead. The remaining
/// error is spread by normalising the sum; a disc that falls between all texels, by rounding, belongs to the nearest.
fn disc_shares(grid: CubeGrid, centre: &UnitVector3<f64>, radius: f64) -> Vec<(usize, f64)> {
    let disc = Disc { centre: **centre, radius, finest: radius / 64.0 };
    let mut shares: Vec<(usize, f64)> = (0..grid.len())
        .filter_map(|i| {
            let (face, x, y) = grid.texel(i);
            let (u, v) = ([grid.line(x), grid.line(x + 1)], [grid.line(y), grid.line(y + 1)]);
            let share = if radius < FLAT { disc.flat_share(face, u, v) } else { disc.share(face, u, v, MAX_DEPTH) };
            (share > 0.0).then_some((i, share))
        })
        .collect();
    let sum: f64 = shares.iter().map(|(_, share)| share).sum();
    if sum > 0.0 {
        shares.iter_mut().for_each(|(_, share)| *share /= sum);
        shares
    } else {
        vec![(grid.nearest(centre), 1.0)]
    }
}

struct Disc {
    centre: Vector3<f64>,
    radius: f64,
    finest: f64,
}

/// The middle of a rectangle of a face and the largest angle from it to a corner, which bounds the piece: a convex
/// piece lies in the cone through its farthest corner.
fn cone(face: Face, u: [f64; 2], v: [f64; 2]) -> (Vector3<f64>, f64) {
    let middle = face.point(0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1]));
    let reach = [(u[0], v[0]), (u[1], v[0]), (u[0], v[1]), (u[1], v[1])]
        .map(|(u, v)| angle(&face.point(u, v), &middle))
        .into_iter()
        .fold(0.0, f64::max);
    (middle, reach)
}

impl Disc {
    /// The solid angle that the disc and a rectangle of a face share, after at most `depth` quarterings.
    fn share(&self, face: Face, u: [f64; 2], v: [f64; 2], depth: u32) -> f64 {
        let (middle, reach) = cone(face, u, v);
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
        if reach <= self.finest || depth == 0 {
            // A straight rim across a square of half-diagonal `reach` seen along its side.
            let half_side = reach * FRAC_1_SQRT_2;
            return whole() * (0.5 + (self.radius - distance) / (2.0 * half_side)).clamp(0.0, 1.0);
        }
        let (mid_u, mid_v) = (0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1]));
        let halves = |t: [f64; 2], mid: f64| [[t[0], mid], [mid, t[1]]];
        let quarters = halves(v, mid_v).map(|v| halves(u, mid_u).map(|u| self.share(face, u, v, depth - 1)));
        quarters.iter().flatten().sum()
    }

    /// The part of a small disc that a rectangle of a face holds: of the unit disc in the tangent plane, cut by the
    /// four great circles of the rectangle's edges as by straight lines.
    fn flat_share(&self, face: Face, u: [f64; 2], v: [f64; 2]) -> f64 {
        let (middle, reach) = cone(face, u, v);
        // Slack for the rounding of angles: a disc at a corner must not miss all the texels that meet there.
        let slack = 1e-12;
        if angle(&self.centre, &middle) >= self.radius + reach + slack {
            return 0.0;
        }
        let right = any_perpendicular(&self.centre);
        let up = self.centre.cross(&right);
        // Below 1e-30 the edges' rounding, 1e-17, decides anyhow; the quotients stay finite.
        let scale = 1.0 / self.radius.max(1e-30);
        let corners = [(u[0], v[0]), (u[1], v[0]), (u[1], v[1]), (u[0], v[1])].map(|(u, v)| face.point(u, v));
        let mut piece = vec![[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]];
        for k in 0..4 {
            let edge = corners[k].cross(&corners[(k + 1) % 4]).normalize();
            let inward = if edge.dot(&middle) < 0.0 { -edge } else { edge };
            let (normal, offset) = ([inward.dot(&right), inward.dot(&up)], inward.dot(&self.centre) * scale);
            piece = cut(&piece, normal, offset);
        }
        (unit_disc_overlap(&piece) / PI).clamp(0.0, 1.0)
    }
}

/// The part of a convex polygon where normal·x + offset ≥ 0.
fn cut(polygon: &[[f64; 2]], normal: [f64; 2], offset: f64) -> Vec<[f64; 2]> {
    let height = |p: [f64; 2]| normal[0] * p[0] + normal[1] * p[1] + offset;
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, &p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        let (a, b) = (height(p), height(q));
        if a >= 0.0 {
            kept.push(p);
        }
        if (a >= 0.0) != (b >= 0.0) {
            let t = a / (a - b);
            kept.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
        }
    }
    kept
}

/// The area that a polygon (anticlockwise) shares with the unit disc about the origin.
///
/// Green's theorem: every edge adds the triangle it spans with the origin where it runs inside, sectors where outside.
fn unit_disc_overlap(polygon: &[[f64; 2]]) -> f64 {
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let sector = |a, b| 0.5 * cross(a, b).atan2(dot(a, b));
    let mut area = 0.0;
    for (k, &p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        let d = [q[0] - p[0], q[1] - p[1]];
        let length2 = dot(d, d);
        // |p + t d|² = 1
        let discriminant = dot(p, d).powi(2) - length2 * (dot(p, p) - 1.0);
        if length2 == 0.0 {
            continue;
        }
        if discriminant <= 0.0 {
            area += sector(p, q);
            continue;
        }
        let root = discriminant.sqrt();
        let at = |t: f64| [p[0] + t * d[0], p[1] + t * d[1]];
        let [enter, leave] = [-root, root].map(|r| ((r - dot(p, d)) / length2).clamp(0.0, 1.0));
        let (a, b) = (at(enter), at(leave));
        area += sector(p, a) + 0.5 * cross(a, b) + sector(b, q);
    }
    area
}

/// A unit vector perpendicular to a unit vector.
fn any_perpendicular(v: &Vector3<f64>) -> Vector3<f64> {
    let axis = if v.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    v.cross(&axis).normalize()
}

/// The angle between two vectors, accurate also where it is small.
pub(super) fn angle(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

pub(super) fn check_range(what: &'static str, got: f64, inside: bool, allowed: &'static str) -> Result<()> {
    if !got.is_finite() {
        Err(Error::NotFinite { what, index: 0 })
    } else if inside {
        Ok(())
    } else {
        Err(Error::OutOfRange { what, got, allowed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_cut_by_lines_has_the_area_of_its_segments() {
        let square = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]];
        assert!((unit_disc_overlap(&square) - PI).abs() < 1e-15);
        for turn in [0.0, 0.3, 1.2, 2.9] {
            for h in [-0.99_f64, -0.4, 0.0, 0.3, 0.8] {
                let normal = [f64::cos(turn), f64::sin(turn)];
                // The segment beyond a chord at distance h.
                let expected = h.acos() - h * (1.0 - h * h).sqrt();
                let got = unit_disc_overlap(&cut(&square, normal, -h));
                assert!((got - expected).abs() < 4e-15, "{turn} {h}: {got} {expected}");
            }
        }
        let quadrant = cut(&cut(&square, [1.0, 0.0], 0.0), [0.0, 1.0], 0.0);
        assert!((unit_disc_overlap(&quadrant) - PI / 4.0).abs() < 1e-15);
        assert!(cut(&square, [1.0, 0.0], -1e30).is_empty());
    }

    #[test]
    fn the_two_ways_to_cut_a_disc_agree() {
        let grid = CubeGrid::new(4).unwrap();
        for centre in [Vector3::new(1.0, 0.5, 0.5 + 4e-7), Vector3::new(1.0, 1.0 - 3e-7, 0.1), Vector3::repeat(1.0)] {
            let disc = Disc { centre: centre.normalize(), radius: 1e-6, finest: 1e-6 / 64.0 };
            for i in 0..grid.len() {
                let (face, x, y) = grid.texel(i);
                let (u, v) = ([grid.line(x), grid.line(x + 1)], [grid.line(y), grid.line(y + 1)]);
                let (flat, quartered) = (disc.flat_share(face, u, v), disc.share(face, u, v, MAX_DEPTH) / (PI * 1e-12));
                // Pieces at the rim, an 80th of the disc's area together, are each cut as if seen along a side.
                assert!((flat - quartered).abs() < 2e-4, "{i}: {flat} {quartered}");
            }
        }
    }
}
