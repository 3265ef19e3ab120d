//! The walk with derivatives.
//!
//! Y(x, y, z) = q(z) {Re, Im} (x + iy)^m agrees with y on the sphere, so the tangent part of its gradient is y's
//! gradient:
//!
//! ```text
//! ∂_x Y = q m {Re, Im} (x + iy)^{m−1},  ∂_y Y = q m {−Im, Re} (x + iy)^{m−1},  ∂_z Y = q' {Re, Im} (x + iy)^m
//! q'_l = a (q_{l−1} + z q'_{l−1}) − b q'_{l−2},  ∇y = ∇Y − (∇Y · ω) ω
//! ```
//!
//! Polynomials throughout: nothing is divided by the sine that vanishes at the poles.

use super::kernel::{Table, climb, turn};
use crate::Real;

/// Receives the value and the tangent gradient of a coefficient at L points.
pub(super) trait GradientVisitor<T, const L: usize> {
    fn visit(&mut self, index: usize, value: &[T; L], gradient: &[[T; L]; 3]);
}

/// [`walk`](super::kernel::walk) with gradients.
#[inline(always)]
pub(super) fn walk_gradient<T: Real, const L: usize, V: GradientVisitor<T, L>>(
    table: &Table<T>,
    bands: usize,
    d: [&[T; L]; 3],
    visitor: &mut V,
) {
    let (diagonal, mut steps) = table.parts(bands);
    let zero = [T::zero(); L];
    let (mut c, mut s) = ([T::one(); L], zero);
    // m (x + iy)^{m−1}.
    let (mut dc, mut ds) = (zero, zero);
    for m in 0..bands {
        let (column, rest) = steps.split_at(bands - 1 - m);
        steps = rest;
        let (mut below, mut below2) = ([diagonal[m]; L], zero);
        let (mut slope, mut slope2) = (zero, zero);
        for l in m..bands {
            if l > m {
                let [a, b] = column[l - m - 1];
                for i in 0..L {
                    let up = a * (below[i] + d[2][i] * slope[i]) - b * slope2[i];
                    slope2[i] = slope[i];
                    slope[i] = up;
                }
                climb(d[2], [a, b], &mut below, &mut below2);
            }
            let centre = l * (l + 1);
            emit(visitor, centre + m, d, [&below, &slope], [&c, &dc, &ds], T::one());
            if m > 0 {
                emit(visitor, centre - m, d, [&below, &slope], [&s, &ds, &dc], -T::one());
            }
        }
        let next = T::of((m + 1) as f64);
        for i in 0..L {
            dc[i] = next * c[i];
            ds[i] = next * s[i];
        }
        turn(m, [d[0], d[1]], &mut c, &mut s);
    }
}

/// Value and tangent gradient of q·ring, where ring has ∂_x = along, ∂_y = −sign·across.
#[inline(always)]
fn emit<T: Real, const L: usize, V: GradientVisitor<T, L>>(
    visitor: &mut V,
    index: usize,
    d: [&[T; L]; 3],
    [q, slope]: [&[T; L]; 2],
    [ring, along, across]: [&[T; L]; 3],
    sign: T,
) {
    let mut value = [T::zero(); L];
    let mut gradient = [value; 3];
    for i in 0..L {
        value[i] = q[i] * ring[i];
        let g = [q[i] * along[i], -sign * (q[i] * across[i]), slope[i] * ring[i]];
        let radial = g[0] * d[0][i] + g[1] * d[1][i] + g[2] * d[2][i];
        for k in 0..3 {
            gradient[k][i] = g[k] - radial * d[k][i];
        }
    }
    visitor.visit(index, &value, &gradient);
}

/// A row for each coefficient, of the value and of each component.
pub(super) struct GradientRows<'a, T> {
    pub values: &'a mut [T],
    pub gradients: [&'a mut [T]; 3],
    pub stride: usize,
    pub first: usize,
    pub count: usize,
}

impl<T: Real, const L: usize> GradientVisitor<T, L> for GradientRows<'_, T> {
    #[inline(always)]
    fn visit(&mut self, index: usize, value: &[T; L], gradient: &[[T; L]; 3]) {
        let at = index * self.stride + self.first;
        self.values[at..at + self.count].copy_from_slice(&value[..self.count]);
        for (out, g) in self.gradients.iter_mut().zip(gradient) {
            out[at..at + self.count].copy_from_slice(&g[..self.count]);
        }
    }
}

/// One point.
pub(super) struct GradientPoint<'a, T> {
    pub values: &'a mut [T],
    pub gradients: &'a mut [nalgebra::Vector3<T>],
}

impl<T: Real> GradientVisitor<T, 1> for GradientPoint<'_, T> {
    #[inline(always)]
    fn visit(&mut self, index: usize, value: &[T; 1], gradient: &[[T; 1]; 3]) {
        self.values[index] = value[0];
        self.gradients[index] = nalgebra::Vector3::new(gradient[0][0], gradient[1][0], gradient[2][0]);
    }
}
