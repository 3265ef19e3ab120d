//! Shares of a square that are on one side of a line.

use crate::numeric::GaussLegendre;

/// The share of a square of edge `edge` around the origin where n·q + distance ≥ 0, by cutting the polygon; n is a unit
/// normal (cos, sin of `angle`).
pub fn half_plane_coverage(distance: f64, edge: f64, angle: f64) -> f64 {
    let h = 0.5 * edge;
    let square = [[-h, -h], [h, -h], [h, h], [-h, h]];
    let side = |q: [f64; 2]| angle.cos() * q[0] + angle.sin() * q[1] + distance;
    let mut inside = Vec::new();
    for k in 0..4 {
        let (a, b) = (square[k], square[(k + 1) % 4]);
        let (s, t) = (side(a), side(b));
        if s >= 0.0 {
            inside.push(a);
        }
        if (s >= 0.0) != (t >= 0.0) {
            let cut = s / (s - t);
            inside.push([a[0] + cut * (b[0] - a[0]), a[1] + cut * (b[1] - a[1])]);
        }
    }
    let twice = |k: usize| {
        let (a, b) = (inside[k], inside[(k + 1) % inside.len()]);
        a[0] * b[1] - a[1] * b[0]
    };
    0.5 * (0..inside.len()).map(twice).sum::<f64>() / (edge * edge)
}

/// [`half_plane_coverage`] averaged over the angle, by quadrature between the angles at which the line passes a corner.
pub fn mean_coverage(distance: f64, edge: f64) -> f64 {
    use std::f64::consts::{FRAC_PI_4, SQRT_2};
    let quarter = (2.0 * distance.abs() / (edge * SQRT_2)).min(1.0).acos() - FRAC_PI_4;
    let turn = quarter.abs().min(FRAC_PI_4);
    let rule = GaussLegendre::new(64).expect("has points");
    let part = |from, to| rule.integrate(from, to, |angle| half_plane_coverage(distance, edge, angle));
    (part(0.0, turn) + part(turn, FRAC_PI_4)) / FRAC_PI_4
}

/// Equation 9 of [Xu 2006] as it is printed, min(1, max(0, (√2 r + D)/(√2 r))), with √2 r read as the edge: 1 where the
/// centre is on the boundary.
pub fn printed_coverage(distance: f64, edge: f64) -> f64 {
    ((edge + distance) / edge).clamp(0.0, 1.0)
}
