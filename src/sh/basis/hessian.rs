//! The walk with second derivatives.
//!
//! For Y = q(z) {Re, Im} (x + iy)^m, which agrees with y on the sphere, the Hessian on the sphere is
//!
//! ```math
//! Hess y = Π D²Y Π − (∇Y · ω) Π,  Π = 1 − ωωᵀ
//! ```
//!
//! the second term because great circles bend towards −ω. With p = D²Y ω and n = ∇Y · ω that is
//! D²Y − ωpᵀ − pωᵀ + (ω·p + n) ωωᵀ − n 1. D²Y follows from derivatives of (x + iy)^m and
//!
//! ```text
//! q''_l = a (2 q'_{l−1} + z q''_{l−1}) − b q''_{l−2}
//! ```
//!
//! Polynomials throughout, as in [`gradient`](super::gradient).

use super::kernel::{Table, climb, turn};
use crate::Real;

/// Value, tangent gradient, and Hessian xx, xy, xz, yy, yz, zz of a coefficient at L points.
pub(super) struct Jet<T, const L: usize> {
    pub value: [T; L],
    pub gradient: [[T; L]; 3],
    pub hessian: [[T; L]; 6],
}

/// Receives the jet of each coefficient.
pub(super) trait HessianVisitor<T, const L: usize> {
    fn visit(&mut self, index: usize, jet: &Jet<T, L>);
}

/// (x + iy)^m and its first two derivatives m (x + iy)^{m−1}, m(m−1) (x + iy)^{m−2}: [re, im].
type Ring<T, const L: usize> = [[[T; L]; 2]; 3];

/// [`walk`](super::kernel::walk) with gradients and Hessians.
#[inline(always)]
pub(super) fn walk_hessian<T: Real, const L: usize, V: HessianVisitor<T, L>>(
    table: &Table<T>,
    bands: usize,
    d: [&[T; L]; 3],
    visitor: &mut V,
) {
    let (diagonal, mut steps) = table.parts(bands);
    let zero = [T::zero(); L];
    let two = T::of(2.0);
    let mut ring: Ring<T, L> = [[[T::one(); L], zero], [zero; 2], [zero; 2]];
    for m in 0..bands {
        let (column, rest) = steps.split_at(bands - 1 - m);
        steps = rest;
        let (mut below, mut below2) = ([diagonal[m]; L], zero);
        let (mut slope, mut slope2) = (zero, zero);
        let (mut bend, mut bend2) = (zero, zero);
        for l in m..bands {
            if l > m {
                let [a, b] = column[l - m - 1];
                for i in 0..L {
                    let up = a * (two * slope[i] + d[2][i] * bend[i]) - b * bend2[i];
                    (bend2[i], bend[i]) = (bend[i], up);
                    let up = a * (below[i] + d[2][i] * slope[i]) - b * slope2[i];
                    (slope2[i], slope[i]) = (slope[i], up);
                }
                climb(d[2], [a, b], &mut below, &mut below2);
            }
            let (centre, q) = (l * (l + 1), [&below, &slope, &bend]);
            let [re, first_re, second_re] = ring.each_ref().map(|power| &power[0]);
            let [im, first_im, second_im] = ring.each_ref().map(|power| &power[1]);
            visitor.visit(centre + m, &jet(d, q, [re, first_re, first_im, second_re, second_im], -T::one()));
            if m > 0 {
                visitor.visit(centre - m, &jet(d, q, [im, first_im, first_re, second_im, second_re], T::one()));
            }
        }
        let next = T::of((m + 1) as f64);
        for part in 0..2 {
            for i in 0..L {
                ring[2][part][i] = next * ring[1][part][i];
                ring[1][part][i] = next * ring[0][part][i];
            }
        }
        let [c, s] = &mut ring[0];
        turn(m, [d[0], d[1]], c, s);
    }
}

/// The jet of q·ring, where ring has ∂_x = along, ∂_y = sign·across, and so on for the second derivatives.
#[inline(always)]
fn jet<T: Real, const L: usize>(
    d: [&[T; L]; 3],
    [q, slope, bend]: [&[T; L]; 3],
    [ring, along, across, along2, across2]: [&[T; L]; 5],
    sign: T,
) -> Jet<T, L> {
    let zero = [T::zero(); L];
    let mut out = Jet { value: zero, gradient: [zero; 3], hessian: [zero; 6] };
    for i in 0..L {
        let (x, y, z) = (d[0][i], d[1][i], d[2][i]);
        out.value[i] = q[i] * ring[i];
        let g = [q[i] * along[i], sign * (q[i] * across[i]), slope[i] * ring[i]];
        let radial = g[0] * x + g[1] * y + g[2] * z;
        for k in 0..3 {
            out.gradient[k][i] = g[k] - radial * d[k][i];
        }
        let (xx, xy) = (q[i] * along2[i], sign * (q[i] * across2[i]));
        let (xz, yz, zz) = (slope[i] * along[i], sign * (slope[i] * across[i]), bend[i] * ring[i]);
        let p = [xx * x + xy * y + xz * z, xy * x - xx * y + yz * z, xz * x + yz * y + zz * z];
        let whole = p[0] * x + p[1] * y + p[2] * z + radial;
        let second = [xx, xy, xz, -xx, yz, zz];
        let pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
        for (k, (a, b)) in pairs.into_iter().enumerate() {
            let (da, db) = (d[a][i], d[b][i]);
            let tangent = second[k] - (da * p[b] + p[a] * db) + whole * (da * db);
            out.hessian[k][i] = if a == b { tangent - radial } else { tangent };
        }
    }
    out
}

/// A row for each coefficient, of the value and of each component.
pub(super) struct HessianRows<'a, T> {
    pub values: &'a mut [T],
    pub gradients: [&'a mut [T]; 3],
    pub hessians: [&'a mut [T]; 6],
    pub stride: usize,
    pub first: usize,
    pub count: usize,
}

impl<T: Real, const L: usize> HessianVisitor<T, L> for HessianRows<'_, T> {
    #[inline(always)]
    fn visit(&mut self, index: usize, jet: &Jet<T, L>) {
        let at = index * self.stride + self.first;
        self.values[at..at + self.count].copy_from_slice(&jet.value[..self.count]);
        for (out, g) in self.gradients.iter_mut().zip(&jet.gradient) {
            out[at..at + self.count].copy_from_slice(&g[..self.count]);
        }
        for (out, h) in self.hessians.iter_mut().zip(&jet.hessian) {
            out[at..at + self.count].copy_from_slice(&h[..self.count]);
        }
    }
}

/// One point.
pub(super) struct HessianPoint<'a, T> {
    pub values: &'a mut [T],
    pub gradients: &'a mut [nalgebra::Vector3<T>],
    pub hessians: &'a mut [nalgebra::Matrix3<T>],
}

impl<T: Real> HessianVisitor<T, 1> for HessianPoint<'_, T> {
    #[inline(always)]
    fn visit(&mut self, index: usize, jet: &Jet<T, 1>) {
        self.values[index] = jet.value[0];
        self.gradients[index] = nalgebra::Vector3::from(jet.gradient.map(|g| g[0]));
        let [xx, xy, xz, yy, yz, zz] = jet.hessian.map(|h| h[0]);
        self.hessians[index] = nalgebra::Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    }
}
