//! The chain Z(α) P Z(−β) P Z(γ) on one vector, four coefficients of a degree side by side.
//!
//! Quad k holds the orders 2k, 2k + 1, −2k, −(2k + 1). A turn about z mixes its halves, and P, a block for each
//! combination of parity and sign, takes one block a lane: row r of P v is Σ_c P_rc v_c, lane by lane, where v's lanes
//! are exchanged first as P wants it. What is no coefficient, −0 and orders above l, is 0 in v and in P.
//!
//! Sums run in the order of [`chain`](super::chain): the same bits, but for the sign of a zero. It is for degrees from
//! 6 on, and builds the plan of a [`Rotation`](super::Rotation).

use std::hint::black_box;
use std::ops::Range;

use super::sizes::MAX_BANDS;
use super::swap::{QUAD, Swap, quads};
use super::turns::Turns;
use crate::Real;

type Quad<T> = [T; QUAD];

/// cos mθ and ± sin mθ (− for m ≥ 0) of the three turns, in quads; α, −β, γ.
type Powers<T, const K: usize> = [[[Quad<T>; 2]; K]; 3];

/// a b of complex numbers [re, im].
#[inline(always)]
fn multiply<T: Real>(a: &[Quad<T>; 2], b: &[Quad<T>; 2]) -> [Quad<T>; 2] {
    let mut out = [[T::zero(); QUAD]; 2];
    for i in 0..QUAD {
        out[0][i] = a[0][i] * b[0][i] - a[1][i] * b[1][i];
        out[1][i] = a[0][i] * b[1][i] + a[1][i] * b[0][i];
    }
    out
}

/// The powers that `bands` ≤ 2K want.
#[inline(always)]
fn powers<T: Real, const K: usize>(bands: usize, turns: &Turns<T, 1>) -> Powers<T, K> {
    let (zero, one) = (T::zero(), T::one());
    let mut out = [[[[zero; QUAD]; 2]; K]; 3];
    let mut squares = [[[zero; QUAD]; 2]; 3];
    let [[back], [up]] = turns.beta;
    for (turn, [[c], [s]]) in [turns.alpha, [[back], [-up]], turns.gamma].into_iter().enumerate() {
        out[turn][0] = [[one, c, one, c], [zero, -s, zero, s]];
        let (re, im) = (c * c - s * s, c * s + s * c);
        squares[turn] = [[re; QUAD], [-im, -im, im, im]];
    }
    settle(&out);
    settle(&squares);
    let size = quads(bands - 1);
    for k in 1..size {
        for turn in 0..3 {
            out[turn][k] = multiply(&out[turn][k - 1], &squares[turn]);
        }
    }
    settle(&out);
    out
}

/// Has what is borrowed written to memory, quad by quad. Otherwise LLVM takes the quads apart into scalars and joins
/// them anew in other ways, from build to build a quarter faster or a fifth slower.
#[inline(always)]
fn settle<T>(quads: &[T]) {
    black_box(quads.as_ptr());
}

#[inline(always)]
fn turn<T: Real>(powers: &[[Quad<T>; 2]], v: &mut [Quad<T>]) {
    for k in 0..v.len() {
        let ([c, s], a) = (&powers[k], v[k]);
        for i in 0..QUAD {
            v[k][i] = c[i] * a[i] + s[i] * a[i ^ 2];
        }
    }
}

/// u = P v.
#[inline(always)]
fn swap<T: Real>(l: usize, entries: &[Quad<T>], v: &[Quad<T>], u: &mut [Quad<T>]) {
    let size = v.len();
    let met = |[a, b, c, d]: Quad<T>| if l % 2 == 0 { [a, c, b, d] } else { [d, b, c, a] };
    for r in 0..size {
        let row = &entries[r * size..][..size];
        let mut sum = [T::zero(); QUAD];
        for c in 0..size {
            let v = met(v[c]);
            for i in 0..QUAD {
                let term = row[c][i] * v[i];
                sum[i] = if c == 0 { term } else { sum[i] + term };
            }
        }
        u[r] = sum;
    }
}

/// Some degrees, not the lowest, of one vector.
pub(super) fn rotate<T: Real>(table: &Swap<T>, degrees: Range<usize>, turns: &Turns<T, 1>, f: &[T], out: &mut [T]) {
    if degrees.end <= 16 {
        rotate_within::<T, 8>(table, degrees, turns, f, out);
    } else {
        rotate_within::<T, { MAX_BANDS / 2 }>(table, degrees, turns, f, out);
    }
}

/// Degrees below 2K.
fn rotate_within<T: Real, const K: usize>(
    table: &Swap<T>,
    degrees: Range<usize>,
    turns: &Turns<T, 1>,
    f: &[T],
    out: &mut [T],
) {
    let single = Single { table, powers: powers::<T, K>(degrees.end, turns) };
    let [mut v, mut u] = [[[T::zero(); QUAD]; K]; 2];
    for l in degrees {
        single.rotate(l, f, out, [&mut v, &mut u]);
    }
}

/// One vector's plan and powers.
struct Single<'a, T, const K: usize> {
    table: &'a Swap<T>,
    powers: Powers<T, K>,
}

impl<T: Real, const K: usize> Single<'_, T, K> {
    /// Degree l of `f`; v and u hold its quads.
    #[inline(always)]
    fn rotate(&self, l: usize, f: &[T], out: &mut [T], [v, u]: [&mut [Quad<T>]; 2]) {
        let (size, zero) = (quads(l), T::zero());
        let (v, u) = (&mut v[..size], &mut u[..size]);
        let (f, out) = (&f[l * l..][..2 * l + 1], &mut out[l * l..][..2 * l + 1]);
        let entries = &self.table.quads(l)[..size * size];
        let [alpha, back, gamma] = self.powers.each_ref().map(|p| &p[..size]);
        for k in 0..size {
            let m = 2 * k;
            let beyond = m + 1 > l;
            v[k][0] = f[l + m];
            v[k][1] = if beyond { zero } else { f[l + m + 1] };
            v[k][2] = if k == 0 { zero } else { f[l - m] };
            v[k][3] = if beyond { zero } else { f[l - m - 1] };
        }
        turn(gamma, v);
        settle(v);
        swap(l, entries, v, u);
        settle(u);
        turn(back, u);
        settle(u);
        swap(l, entries, u, v);
        settle(v);
        turn(alpha, v);
        settle(v);
        for k in 0..size {
            let m = 2 * k;
            out[l + m] = v[k][0];
            if m < l {
                out[l + m + 1] = v[k][1];
                out[l - m - 1] = v[k][3];
            }
            if k > 0 {
                out[l - m] = v[k][2];
            }
        }
    }
}
