//! Integrals of products, in coefficients.

use crate::Real;
use crate::error::length_mismatch;

/// Partial sums: two registers of `f32` on AVX2.
const LANES: usize = 16;

/// Σ over the samples of a block of f·g, from the coefficients of both (Parseval).
/// ```math
/// Σ_yx f g = Σ_vu A_vu B_vu
/// ```
///
/// Line 6 of algorithm 1 [Inger 2013]: light (16 coefficients) × BRDF (1, 4 or 16). The two may keep different numbers
/// of frequencies; the smaller square of both counts.
///
/// Shapes: `a`, `b`: l² coefficients each, row-major, any l. Accuracy: (l²/16 + 5)·ε·Σ |A B| at worst.
///
/// # Panics
/// If a length is not a square.
#[inline]
#[track_caller]
pub fn product_integral<T: Real>(a: &[T], b: &[T]) -> T {
    let low = |x: &[T]| {
        let low = x.len().isqrt();
        if low * low != x.len() {
            length_mismatch("coefficients of a square", low * low, x.len());
        }
        low
    };
    if a.len() == b.len() {
        low(a);
        return dot(a, b);
    }
    let (l, m) = (low(a), low(b));
    let both = l.min(m);
    (0..both).fold(T::zero(), |sum, v| sum + dot(&a[v * l..][..both], &b[v * m..][..both]))
}

#[inline]
fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sums = [T::zero(); LANES];
    for (a, b) in a.iter().zip(b) {
        for i in 0..LANES {
            sums[i] += a[i] * b[i];
        }
    }
    let mut half = LANES / 2;
    while half > 0 {
        for i in 0..half {
            sums[i] += sums[i + half];
        }
        half /= 2;
    }
    rest_a.iter().zip(rest_b).fold(sums[0], |sum, (&a, &b)| sum + a * b)
}
