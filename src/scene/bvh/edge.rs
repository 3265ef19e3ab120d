//! Where a ray passes an edge: the predicates under every ray.

use std::ops::{Add, Mul, Sub};

/// The unit roundoff of `f32` times twelve: the bound of the edge functions' error (see [`edge`]), relative to the sum
/// of the absolute values of their terms.
pub(in crate::scene) const EDGE_TOLERANCE: f32 = 12.0 * 0.5 * f32::EPSILON;

/// The edge function of the edge a → b seen from the origin, and the sum of its terms' absolute values.
///
/// ```math
/// n = m × (b − a) = a × b,  m the nearer of a and b;  a direction d is on the inner side of the edge if n · d ≥ 0
/// ```
///
/// `a`, `b` are relative to the ray's origin; `e` = b − a is from the positions themselves, which keeps it exact where
/// the edge is short and far. The nearer end keeps n exact where the edge is long and near, as a vertex's own edges
/// are.
///
/// Error: with u the unit roundoff, |δm| ≤ u|m|, |δe| ≤ u|e|; each product adds u, the difference u, the product with
/// |d| ≤ 1 u, and the two sums 2u; altogether |δ(n · d)| ≤ 7u Q to first order with Q the second result, 8u with the
/// rounding of the tolerance itself; [`EDGE_TOLERANCE`] is 12u.
#[inline(always)]
pub(in crate::scene) fn edge<T: Number>(m: [T; 3], e: [T; 3], abs: impl Fn(T) -> T) -> ([T; 3], T) {
    let n = [m[1] * e[2] - m[2] * e[1], m[2] * e[0] - m[0] * e[2], m[0] * e[1] - m[1] * e[0]];
    let (mx, my, mz) = (abs(m[0]), abs(m[1]), abs(m[2]));
    let (ex, ey, ez) = (abs(e[0]), abs(e[1]), abs(e[2]));
    (n, (my * ez + mz * ey) + (mz * ex + mx * ez) + (mx * ey + my * ex))
}

/// Squared length.
#[inline(always)]
pub(in crate::scene) fn norm_squared<T: Number>(a: [T; 3]) -> T {
    a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
}

/// Six times the signed volume of origin and triangle (a is any corner relative to the origin, e and f the edges from
/// the first to the second and from there to the third), and the same sum as in [`edge`].
///
/// Positive if the face turns its back to the origin in a right-handed frame.
#[inline(always)]
pub(in crate::scene) fn volume<T: Number>(a: [T; 3], e: [T; 3], f: [T; 3], abs: impl Fn(T) -> T) -> (T, T) {
    let (x0, x1) = (e[1] * f[2], e[2] * f[1]);
    let (y0, y1) = (e[2] * f[0], e[0] * f[2]);
    let (z0, z1) = (e[0] * f[1], e[1] * f[0]);
    let v = (x0 - x1) * a[0] + (y0 - y1) * a[1] + (z0 - z1) * a[2];
    let q = (abs(x0) + abs(x1)) * abs(a[0]) + (abs(y0) + abs(y1)) * abs(a[1]) + (abs(z0) + abs(z1)) * abs(a[2]);
    (v, q)
}

/// One `f32` or a register of them.
pub(in crate::scene) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>> Number for T {}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    /// The widening of the edges is as large as the error can be, and not many times larger.
    #[test]
    fn edge_functions_err_by_less_than_their_tolerance() {
        let mut state = 1_u64;
        let mut number = |size: f32| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 40) as f32 / (1 << 23) as f32 - 1.0) * size
        };
        let mut worst = 0.0_f64;
        for i in 0..200_000 {
            let size = [1.0, 1e-2, 1e-4][i % 3];
            let origin = [0; 3].map(|_| number(1.0));
            let from = origin.map(|o| o + number(0.5));
            let to = from.map(|p| p + number(size));
            let d = [number(1.0), number(1.0), 1.0];
            let [a, b] = [from, to].map(|p| [0, 1, 2].map(|k: usize| p[k] - origin[k]));
            let e = [0, 1, 2].map(|k: usize| to[k] - from[k]);
            let nearer = if norm_squared(b) < norm_squared(a) { b } else { a };
            let (n, terms) = edge(nearer, e, f32::abs);
            let value = n[0] * d[0] + (n[1] * d[1] + n[2]);
            let [o, p, q, d] = [origin, from, to, d].map(|v| Vector3::from(v).cast::<f64>());
            let exact = (p - o).cross(&(q - o)).dot(&d);
            worst = worst.max((f64::from(value) - exact).abs() / f64::from(EDGE_TOLERANCE * terms));
        }
        // 8 of the tolerance's 12 roundings by the analysis; chance reaches about a quarter of that.
        assert!((0.05..8.0 / 12.0).contains(&worst), "{worst}");
    }
}
