//! The chain Z(α) P Z(−β) P Z(γ) on W vectors at once, degree by degree.

use super::swap::{Swap, columns};
use super::turns::{Flat, Turns};
use crate::Real;

/// cos mθ, sin mθ of the three turns, m = 1…; α, −β, γ.
pub(super) type Powers<T, const W: usize, const CAP: usize> = [[[[T; W]; 2]; CAP]; 3];

/// The powers up to m = `bands` − 1 of each turn's unit number, at [turn][m − 1].
#[inline(always)]
pub(super) fn powers<T: Real, const W: usize, const CAP: usize>(
    bands: usize,
    turns: &Turns<T, W>,
    out: &mut Powers<T, W, CAP>,
) {
    let mut back = turns.beta;
    for i in 0..W {
        back[1][i] = -back[1][i];
    }
    for (out, first) in out.iter_mut().zip([&turns.alpha, &back, &turns.gamma]) {
        let mut power = *first;
        for m in 1..bands {
            out[m - 1] = power;
            for i in 0..W {
                let (c, s) = (power[0][i], power[1][i]);
                power[0][i] = c * first[0][i] - s * first[1][i];
                power[1][i] = c * first[1][i] + s * first[0][i];
            }
        }
    }
}

/// (v_m, v_−m) turned by mθ, m = 1…l.
#[inline(always)]
fn turn<T: Real, const W: usize>(l: usize, powers: &[[[T; W]; 2]], v: &mut [[T; W]]) {
    for m in 1..=l {
        let [c, s] = &powers[m - 1];
        let (a, b) = (v[l + m], v[l - m]);
        for i in 0..W {
            v[l + m][i] = c[i] * a[i] - s[i] * b[i];
            v[l - m][i] = s[i] * a[i] + c[i] * b[i];
        }
    }
}

/// out = P v.
#[inline(always)]
fn swap<T: Real, const W: usize>(l: usize, entries: &[T], v: &[[T; W]], out: &mut [[T; W]]) {
    let mut at = 0;
    for row in 0..2 * l + 1 {
        let (first, count) = columns(l, row);
        let mut sum = [T::zero(); W];
        for k in 0..count {
            let p = entries[at + k];
            let v = &v[first + 2 * k];
            for i in 0..W {
                sum[i] += p * v[i];
            }
        }
        at += count;
        out[row] = sum;
    }
}

/// Degree l of W vectors, 2l + 1 rows in `v`, in place; `spare` is as long.
#[inline(always)]
pub(super) fn rotate_degree<T: Real, const W: usize, const CAP: usize>(
    l: usize,
    table: &Swap<T>,
    powers: &Powers<T, W, CAP>,
    v: &mut [[T; W]],
    spare: &mut [[T; W]],
) {
    let entries = table.degree(l);
    turn(l, &powers[2], v);
    swap(l, entries, v, spare);
    turn(l, &powers[1], spare);
    swap(l, entries, spare, v);
    turn(l, &powers[0], v);
}

/// A rotation that keeps or reverses the z axis, on vector `at` of `count`: no rounding where it is a half turn or none.
pub(super) fn rotate_flat<T: Real>(bands: usize, flat: &Flat<T>, f: &[T], out: &mut [T], [count, at]: [usize; 2]) {
    let [c1, s1] = flat.turn;
    for l in 0..bands {
        let centre = l * (l + 1);
        // A half turn about y: (−1)^l for m ≥ 0, −(−1)^l for m < 0.
        let even = if flat.reverses && l % 2 == 1 { -T::one() } else { T::one() };
        let odd = if flat.reverses { -even } else { even };
        out[centre * count + at] = even * f[centre * count + at];
        let (mut c, mut s) = (c1, s1);
        for m in 1..=l {
            let (up, down) = ((centre + m) * count + at, (centre - m) * count + at);
            let (a, b) = (even * f[up], odd * f[down]);
            out[up] = c * a - s * b;
            out[down] = s * a + c * b;
            (c, s) = (c * c1 - s * s1, c * s1 + s * c1);
        }
    }
}
