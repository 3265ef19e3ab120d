//! The chain Z(α) P Z(−β) P Z(γ) on W vectors at once, degree by degree.

use std::ops::Range;

use super::swap::{CLASSES, Comb, Swap};
use super::turns::{Flat, Turns};
use crate::Real;

/// cos mθ, sin mθ of the three turns, m = 1…; α, −β, γ.
pub(super) type Powers<T, const W: usize, const CAP: usize> = [[[[T; W]; 2]; CAP]; 3];

/// a b of complex numbers [re, im].
#[inline(always)]
fn multiply<T: Real, const W: usize>(a: &[[T; W]; 2], b: &[[T; W]; 2]) -> [[T; W]; 2] {
    let mut out = [[T::zero(); W]; 2];
    for i in 0..W {
        out[0][i] = a[0][i] * b[0][i] - a[1][i] * b[1][i];
        out[1][i] = a[0][i] * b[1][i] + a[1][i] * b[0][i];
    }
    out
}

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
        out[0] = *first;
        if bands > 2 {
            out[1] = multiply(first, first);
        }
        // By the square: two chains, half as long.
        for m in 3..bands {
            out[m - 1] = multiply(&out[m - 3], &out[1]);
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

/// Vectors first..first + W of `count`, in and out.
pub(super) struct Columns<'a, T> {
    pub f: &'a [T],
    pub out: &'a mut [T],
    pub count: usize,
    pub first: usize,
}

impl<T: Real> Columns<'_, T> {
    #[inline(always)]
    fn load<const W: usize>(&self, row: usize) -> [T; W] {
        *self.f[row * self.count + self.first..].first_chunk::<W>().expect("W vectors")
    }

    #[inline(always)]
    fn store<const W: usize>(&mut self, row: usize, value: &[T; W]) {
        self.out[row * self.count + self.first..][..W].copy_from_slice(value);
    }
}

/// A dense block of P, R rows of C, of a comb of v to a comb of out.
#[inline(always)]
fn block<T: Real, const W: usize, const R: usize, const C: usize>(
    entries: &[T],
    v: &[[T; W]],
    out: &mut [[T; W]],
    (l, [rows, columns]): (usize, [Comb; 2]),
) {
    for r in 0..R {
        let mut sum = [T::zero(); W];
        for c in 0..C {
            let p = entries[r * C + c];
            let v = &v[columns.at(l, c)];
            for i in 0..W {
                let term = p * v[i];
                sum[i] = if c == 0 { term } else { sum[i] + term };
            }
        }
        out[rows.at(l, r)] = sum;
    }
}

/// The degrees that are unrolled, with the sizes of the combs: upper even, upper odd, lower even, lower odd.
macro_rules! unrolled {
    ($($name:ident $l:literal $a:literal $b:literal $c:literal $d:literal)*) => {$(
        /// Degree $l of W vectors.
        #[inline(always)]
        pub(super) fn $name<T: Real, const W: usize, const CAP: usize>(
            table: &Swap<T>,
            powers: &Powers<T, W, CAP>,
            io: &mut Columns<'_, T>,
        ) {
            const N: usize = 2 * $l + 1;
            const CENTRE: usize = $l * $l;
            const _: () = assert!($a + $b + $c + $d == N && $a == CLASSES[0][0].count($l) && $b == CLASSES[1][0].count($l));
            let entries = &table.degree($l)[..$a * $a + 2 * $b * $c + $d * $d];
            let (mut v, mut u) = ([[T::zero(); W]; N], [[T::zero(); W]; N]);
            for i in 0..N {
                v[i] = io.load(CENTRE + i);
            }
            #[inline(always)]
            fn swap<T: Real, const W: usize>(entries: &[T], v: &[[T; W]; N], u: &mut [[T; W]; N]) {
                block::<T, W, $a, $a>(entries, v, u, ($l, CLASSES[0]));
                block::<T, W, $b, $c>(&entries[$a * $a..], v, u, ($l, CLASSES[1]));
                block::<T, W, $c, $b>(&entries[$a * $a + $b * $c..], v, u, ($l, CLASSES[2]));
                block::<T, W, $d, $d>(&entries[$a * $a + 2 * $b * $c..], v, u, ($l, CLASSES[3]));
            }
            turn($l, &powers[2], &mut v);
            swap(entries, &v, &mut u);
            turn($l, &powers[1], &mut u);
            swap(entries, &u, &mut v);
            turn($l, &powers[0], &mut v);
            for i in 0..N {
                io.store(CENTRE + i, &v[i]);
            }
        }
    )*};
}

unrolled! {
    degree_1 1 1 1 1 0
    degree_2 2 2 1 1 1
    degree_3 3 2 2 2 1
    degree_4 4 3 2 2 2
    degree_5 5 3 3 3 2
}

/// R rows of a block of P, from `first` on.
#[inline(always)]
fn tile<T: Real, const W: usize, const R: usize>(
    entries: &[T],
    v: &[[T; W]],
    out: &mut [[T; W]],
    (l, first, [rows, columns]): (usize, usize, [Comb; 2]),
) {
    let size = entries.len() / R;
    let entries: [&[T]; R] = std::array::from_fn(|r| &entries[r * size..][..size]);
    let mut sums = [[T::zero(); W]; R];
    for c in 0..size {
        let v = &v[columns.at(l, c)];
        for r in 0..R {
            let p = entries[r][c];
            for i in 0..W {
                sums[r][i] += p * v[i];
            }
        }
    }
    for r in 0..R {
        out[rows.at(l, first + r)] = sums[r];
    }
}

/// out = P v.
#[inline(always)]
fn swap<T: Real, const W: usize>(l: usize, entries: &[T], v: &[[T; W]], out: &mut [[T; W]]) {
    let mut rest = entries;
    for class @ [rows, columns] in CLASSES {
        let (count, size) = (rows.count(l), columns.count(l));
        let mut r = 0;
        while r < count {
            let height = if count - r >= 4 { 4 } else { 1 };
            let (head, tail) = rest.split_at(height * size);
            if height == 4 {
                tile::<T, W, 4>(head, v, out, (l, r, class));
            } else {
                tile::<T, W, 1>(head, v, out, (l, r, class));
            }
            rest = tail;
            r += height;
        }
    }
}

/// Degree l of W vectors; `v` and `spare` hold 2l + 1 rows.
#[inline(always)]
pub(super) fn rotate_degree<T: Real, const W: usize, const CAP: usize>(
    l: usize,
    table: &Swap<T>,
    powers: &Powers<T, W, CAP>,
    io: &mut Columns<'_, T>,
    [v, spare]: [&mut [[T; W]]; 2],
) {
    let (v, spare) = (&mut v[..2 * l + 1], &mut spare[..2 * l + 1]);
    for (i, v) in v.iter_mut().enumerate() {
        *v = io.load(l * l + i);
    }
    let entries = table.degree(l);
    turn(l, &powers[2], v);
    swap(l, entries, v, spare);
    turn(l, &powers[1], spare);
    swap(l, entries, spare, v);
    turn(l, &powers[0], v);
    for (i, v) in v.iter().enumerate() {
        io.store(l * l + i, v);
    }
}

/// A rotation that keeps or reverses the z axis, on vector `at` of `count`: no rounding where it is a half turn or
/// none.
#[cold]
#[inline(never)]
pub(super) fn rotate_flat<T: Real>(
    degrees: Range<usize>,
    flat: &Flat<T>,
    f: &[T],
    out: &mut [T],
    [count, at]: [usize; 2],
) {
    let [c1, s1] = flat.turn;
    for l in degrees {
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
