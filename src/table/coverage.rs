//! The share of a square that is visible, from the distance of its centre to the boundary.
//!
//! [Xu 2006 eq. 9] is min(1, max(0, F)) with F = (√2 r + D)/(√2 r): it gives a square whose centre is on the boundary 1
//! where it must be ½. With e the edge of the square in the plane, F = ½ + D/e is right for a straight boundary along
//! an axis.

use std::f64::consts::{FRAC_1_PI, FRAC_1_SQRT_2, SQRT_2};

/// Ways to the visible share of a square, best first where boundaries are straight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Coverage {
    /// The boundary taken as a straight line across the gradient of the table: [`half_plane_coverage`]. Exact for
    /// straight boundaries, up to the map's pixels.
    #[default]
    Gradient,
    /// The mean over all directions of a straight boundary: [`mean_coverage`]. The best that the distance alone can
    /// say.
    Mean,
    /// A polynomial near that mean: [`smoothstep_coverage`]. The cheapest smooth one.
    Smoothstep,
    /// ½ + D/e, held in [0, 1]: [`linear_coverage`].
    Linear,
}

/// 2D/e; a square without size is on one side or the other.
#[inline(always)]
fn half_edges(distance: f64, edge: f64) -> f64 {
    if edge <= 0.0 && distance == 0.0 {
        0.0
    } else if edge <= 0.0 {
        distance * f64::INFINITY
    } else {
        2.0 * (distance / edge)
    }
}

/// min(1, max(0, ½ + D/e)), D the signed distance of the centre, e the edge: exact for boundaries along an axis.
/// [Xu 2006 eq. 9, corrected by one half]
///
/// Accuracy: off by at most .043 for straight boundaries of any direction.
/// e ≤ 0 gives 0, ½ or 1 by the sign of D; NaN gives NaN.
#[inline]
pub fn linear_coverage(distance: f64, edge: f64) -> f64 {
    (0.5 + 0.5 * half_edges(distance, edge)).clamp(0.0, 1.0)
}

/// Coverage of a square by a half-plane.
///
/// With a ≥ b ≥ 0 the absolute components of its unit normal and t = 2|D|/e,
/// ```math
/// 1 − C = ½ − t/(2a) for t ≤ a − b,  (a + b − t)²/(8ab) up to a + b,  then 0;   C(−D) = 1 − C(D).
/// ```
///
/// `normal` points to the visible side; its length and sign do not matter, and 0 gives [`mean_coverage`]. Infinite
/// components outweigh finite ones and each other not at all. A distance and an edge that are both infinite give NaN.
/// e ≤ 0 gives 0, ½ or 1 by the sign of D; NaN gives NaN. Accuracy: some ε.
#[inline]
pub fn half_plane_coverage(distance: f64, edge: f64, normal: [f64; 2]) -> f64 {
    let [x, y] = in_range(normal.map(f64::abs));
    let length = x.hypot(y);
    if length == 0.0 {
        return mean_coverage(distance, edge);
    }
    let (a, b) = (x.max(y) / length, x.min(y) / length);
    let ratio = half_edges(distance, edge);
    let t = ratio.abs();
    let beyond = if t <= a - b {
        0.5 - t / (2.0 * a)
    } else if t >= a + b {
        0.0
    } else {
        let corner = a + b - t;
        corner * corner / (8.0 * a * b)
    };
    if ratio >= 0.0 { 1.0 - beyond } else { beyond }
}

/// A vector of that direction (components at least 0) whose length neither overflows nor has lost digits.
#[inline(always)]
fn in_range([x, y]: [f64; 2]) -> [f64; 2] {
    let largest = x.max(y);
    if largest == f64::INFINITY {
        return [x, y].map(|c| if c.is_nan() { c } else { f64::from(u8::from(c == largest)) });
    }
    if largest > 0.0 && !(1e-290..=1e290).contains(&largest) {
        return [x / largest, y / largest];
    }
    [x, y]
}

/// [`half_plane_coverage`] averaged over the direction of the normal.
///
/// With t = 2|D|/e ≤ √2 and m = √(2 − t²), by integrating acos(t/ρ)/π, the share of directions in which a point at
/// distance ρ is beyond the line, over the square:
/// ```math
/// 1 − C = (acos(t/√2) − 2t ln(1 + m) + (1 + t²) ln((t + m)/√2) − ½(1 − t)² ln|1 − t²|)/π
/// ```
///
/// e ≤ 0 gives 0, ½ or 1 by the sign of D; NaN gives NaN. Accuracy: some ε.
#[inline]
pub fn mean_coverage(distance: f64, edge: f64) -> f64 {
    let ratio = half_edges(distance, edge);
    let t = ratio.abs();
    if t >= SQRT_2 {
        return if ratio > 0.0 { 1.0 } else { 0.0 };
    }
    let m = (2.0 - t * t).sqrt();
    let outer = (1.0 - t) * (1.0 - t);
    // (1 − t)² ln|1 − t²| is 0 at t = 1.
    let logarithm = if outer == 0.0 { 0.0 } else { 0.5 * outer * (1.0 - t * t).abs().ln() };
    let angle = (t * FRAC_1_SQRT_2).acos();
    let beyond = angle - 2.0 * t * m.ln_1p() + (1.0 + t * t) * ((t + m) * FRAC_1_SQRT_2).ln() - logarithm;
    // Rounding may leave less than nothing; NaN stays.
    let beyond = if beyond < 0.0 { 0.0 } else { beyond * FRAC_1_PI };
    if ratio >= 0.0 { 1.0 - beyond } else { beyond }
}

/// 3s² − 2s³ with s = min(1, max(0, ½ + D/(1.296 e))): within .007 of [`mean_coverage`], .0034 RMS.
///
/// e ≤ 0 gives 0, ½ or 1 by the sign of D; NaN gives NaN.
#[inline]
pub fn smoothstep_coverage(distance: f64, edge: f64) -> f64 {
    let s = (0.5 + 0.5 / 1.296 * half_edges(distance, edge)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}
