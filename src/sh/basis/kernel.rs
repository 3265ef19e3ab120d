//! The walk over all (l, m) for a few points at once, and what can be done with the values on the way.
//!
//! y_{l,±m} = q_{l,m}(z) · {Re, Im} (x + iy)^m with q the normalised Legendre function over (1 − z²)^{m/2}, √2 included
//! for m > 0, a polynomial in z. At fixed m:
//!
//! ```math
//! q_{m,m} = const,  q_{l,m} = a z q_{l−1,m} − b q_{l−2,m}
//! a² = (4l² − 1)/(l² − m²),  b² = (2l+1)((l−1)² − m²) / ((2l−3)(l² − m²))
//! ```
//!
//! Upwards in l is the stable direction for |z| ≤ 1. q grows no faster than ((1+√5)/2)^l: max over m of
//! √((l+m)!/(l−m)!)/(2^m m!) at z = 1, which peaks at m = l/√5.
//!
//! No fused multiply-add, and each lane is computed as a single point would be: every entry point returns the same bits
//! on every machine.

use crate::Real;

/// Constants of the walk, computed in `f64`.
#[derive(Debug, Clone)]
pub(in crate::sh) struct Table<T> {
    /// q_{m,m}.
    diagonal: Vec<T>,
    /// (a, b) for m = 0…, l = m+1…
    steps: Vec<[T; 2]>,
}

impl<T: Real> Table<T> {
    pub(in crate::sh) fn new(bands: usize) -> Self {
        let mut square = 1.0 / (4.0 * std::f64::consts::PI);
        let (mut diagonal, mut steps) = (Vec::new(), Vec::new());
        for m in 0..bands {
            // N_mm² (2m−1)!!² = Π (2k+1)/2k / 4π.
            if m > 0 {
                square *= 1.0 + 0.5 / m as f64;
            }
            diagonal.push(T::of(if m == 0 { square.sqrt() } else { (2.0 * square).sqrt() }));
            let m = m as f64;
            steps.extend((m as usize + 1..bands).map(|l| {
                let l = l as f64;
                let below = (l - m) * (l + m);
                let a = (2.0 * l - 1.0) * (2.0 * l + 1.0) / below;
                // The factor (l−1)² − m² is 0 at l = m + 1, where 2l − 3 may be negative.
                let b = ((l - 1.0 - m) * (l - 1.0 + m)) / below * ((2.0 * l + 1.0) / (2.0 * l - 3.0));
                [T::of(a.sqrt()), T::of(b.max(0.0).sqrt())]
            }));
        }
        Self { diagonal, steps }
    }

    #[inline(always)]
    pub(in crate::sh) fn parts(&self, bands: usize) -> (&[T], &[[T; 2]]) {
        (&self.diagonal[..bands], &self.steps[..bands * bands.saturating_sub(1) / 2])
    }
}

/// (x + iy)^m → (x + iy)^{m+1}.
#[inline(always)]
pub(in crate::sh) fn turn<T: Real, const L: usize>(m: usize, [x, y]: [&[T; L]; 2], c: &mut [T; L], s: &mut [T; L]) {
    if m == 0 {
        return (*c, *s) = (*x, *y);
    }
    for i in 0..L {
        (c[i], s[i]) = (x[i] * c[i] - y[i] * s[i], x[i] * s[i] + y[i] * c[i]);
    }
}

/// q_{l,m} from the two below it; `below` and `below2` move up.
#[inline(always)]
pub(in crate::sh) fn climb<T: Real, const L: usize>(
    z: &[T; L],
    [a, b]: [T; 2],
    below: &mut [T; L],
    below2: &mut [T; L],
) {
    for i in 0..L {
        let q = (a * z[i]) * below[i] - b * below2[i];
        below2[i] = below[i];
        below[i] = q;
    }
}

/// What a walk is for. For each m ≥ 0: `begin`, then `visit` for l = m…bands−1, then `end`; c + is = (x + iy)^m.
pub(in crate::sh) trait Visitor<T, const L: usize> {
    #[inline(always)]
    fn begin(&mut self, _m: usize, _c: &[T; L], _s: &[T; L]) {}
    fn visit(&mut self, l: usize, m: usize, q: &[T; L], c: &[T; L], s: &[T; L]);
    #[inline(always)]
    fn end(&mut self, _m: usize, _c: &[T; L], _s: &[T; L]) {}
}

/// Orders that [`walk_fixed`] unrolls.
pub(in crate::sh) const UNROLLED: usize = 6;

/// Walks over `bands` at L points.
#[inline(always)]
pub(in crate::sh) fn walk<T: Real, const L: usize, V: Visitor<T, L>>(
    table: &Table<T>,
    bands: usize,
    [x, y, z]: [&[T; L]; 3],
    visitor: &mut V,
) {
    let (diagonal, mut steps) = table.parts(bands);
    let (mut c, mut s) = ([T::one(); L], [T::zero(); L]);
    for m in 0..bands {
        let (steps_of, rest) = steps.split_at(bands - 1 - m);
        steps = rest;
        column(m, (diagonal[m], steps_of), z, [&c, &s], visitor);
        turn(m, [x, y], &mut c, &mut s);
    }
}

/// [`walk`] over B bands, up to 6, without a branch; over `bands` of them where B is 0.
#[inline(always)]
pub(in crate::sh) fn walk_fixed<T: Real, const L: usize, const B: usize, V: Visitor<T, L>>(
    table: &Table<T>,
    bands: usize,
    d: [&[T; L]; 3],
    visitor: &mut V,
) {
    if B == 0 {
        return walk(table, bands, d, visitor);
    }
    let [x, y, z] = d;
    let (diagonal, steps) = table.parts(B);
    let (mut c, mut s) = ([T::one(); L], [T::zero(); L]);
    // A loop over m is left to run: its bodies differ in length.
    macro_rules! columns {
        ($($m:literal)*) => {$(
            if $m < B {
                if $m > 0 {
                    turn($m - 1, [x, y], &mut c, &mut s);
                }
                let first = $m * (2 * B - 1 - $m) / 2;
                column($m, (diagonal[$m], &steps[first..first + (B - 1 - $m)]), z, [&c, &s], visitor);
            }
        )*};
    }
    columns!(0 1 2 3 4 5);
    const { assert!(B <= UNROLLED) };
}

/// Order m of a walk: q_{m,m} and the steps up.
#[inline(always)]
fn column<T: Real, const L: usize, V: Visitor<T, L>>(
    m: usize,
    (diagonal, steps): (T, &[[T; 2]]),
    z: &[T; L],
    [c, s]: [&[T; L]; 2],
    visitor: &mut V,
) {
    visitor.begin(m, c, s);
    let mut below2 = [diagonal; L];
    visitor.visit(m, m, &below2, c, s);
    if let Some((&[a, _], steps)) = steps.split_first() {
        let mut below = z.map(|z| (a * z) * diagonal);
        visitor.visit(m + 1, m, &below, c, s);
        for (k, &step) in steps.iter().enumerate() {
            climb(z, step, &mut below, &mut below2);
            visitor.visit(m + 2 + k, m, &below, c, s);
        }
    }
    visitor.end(m, c, s);
}

/// Stores a row for each coefficient: value of point `first + i` at `out[index · stride + first + i]`, i < `count`.
pub(in crate::sh) struct StoreRows<'a, T> {
    pub out: &'a mut [T],
    pub stride: usize,
    pub first: usize,
    pub count: usize,
}

impl<T: Real> StoreRows<'_, T> {
    #[inline(always)]
    fn store<const L: usize>(&mut self, row: usize, value: &[T; L]) {
        let at = row * self.stride + self.first;
        if self.count == L {
            self.out[at..at + L].copy_from_slice(value);
        } else {
            self.out[at..at + self.count].copy_from_slice(&value[..self.count]);
        }
    }
}

impl<T: Real, const L: usize> Visitor<T, L> for StoreRows<'_, T> {
    #[inline(always)]
    fn visit(&mut self, l: usize, m: usize, q: &[T; L], c: &[T; L], s: &[T; L]) {
        let centre = l * (l + 1);
        if m == 0 {
            self.store(centre, q);
        } else {
            let (mut even, mut odd) = ([T::zero(); L], [T::zero(); L]);
            for i in 0..L {
                even[i] = q[i] * c[i];
                odd[i] = q[i] * s[i];
            }
            self.store(centre + m, &even);
            self.store(centre - m, &odd);
        }
    }
}

/// The rows of N coefficients, all of one length, from point `first` on: a place that is good in one is good in all, so
/// one check serves them.
pub(in crate::sh) struct StoreFewRows<'a, T, const N: usize> {
    pub rows: [&'a mut [T]; N],
    pub first: usize,
}

impl<T: Real, const L: usize, const N: usize> Visitor<T, L> for StoreFewRows<'_, T, N> {
    #[inline(always)]
    fn visit(&mut self, l: usize, m: usize, q: &[T; L], c: &[T; L], s: &[T; L]) {
        let centre = l * (l + 1);
        let mut store = |row: usize, value: &[T; L]| self.rows[row][self.first..][..L].copy_from_slice(value);
        if m == 0 {
            return store(centre, q);
        }
        let (mut even, mut odd) = ([T::zero(); L], [T::zero(); L]);
        for i in 0..L {
            even[i] = q[i] * c[i];
            odd[i] = q[i] * s[i];
        }
        store(centre + m, &even);
        store(centre - m, &odd);
    }
}

/// Keeps the values of L points, a row for each coefficient.
pub(in crate::sh) struct Keep<'a, T, const L: usize>(pub &'a mut [[T; L]]);

impl<T: Real, const L: usize> Visitor<T, L> for Keep<'_, T, L> {
    #[inline(always)]
    fn visit(&mut self, l: usize, m: usize, q: &[T; L], c: &[T; L], s: &[T; L]) {
        let centre = l * (l + 1);
        if m == 0 {
            self.0[centre] = *q;
        } else {
            for i in 0..L {
                self.0[centre + m][i] = q[i] * c[i];
                self.0[centre - m][i] = q[i] * s[i];
            }
        }
    }
}

/// Σ c_i y_i. Sums over l first, at fixed m: Σ_m Re (x − iy)^m Σ_l (c_{l,m} + i c_{l,−m}) q_{l,m}.
pub(in crate::sh) struct Dot<'a, T, const L: usize> {
    pub coefficients: &'a [T],
    pub even: [T; L],
    pub odd: [T; L],
    pub sum: [T; L],
}

impl<'a, T: Real, const L: usize> Dot<'a, T, L> {
    #[inline(always)]
    pub(in crate::sh) fn new(coefficients: &'a [T]) -> Self {
        let zero = [T::zero(); L];
        Self { coefficients, even: zero, odd: zero, sum: zero }
    }
}

impl<T: Real, const L: usize> Visitor<T, L> for Dot<'_, T, L> {
    #[inline(always)]
    fn begin(&mut self, _: usize, _: &[T; L], _: &[T; L]) {
        self.even = [T::zero(); L];
        self.odd = [T::zero(); L];
    }

    #[inline(always)]
    fn visit(&mut self, l: usize, m: usize, q: &[T; L], _: &[T; L], _: &[T; L]) {
        let centre = l * (l + 1);
        let (even, odd) = (self.coefficients[centre + m], self.coefficients[centre - m]);
        for i in 0..L {
            self.even[i] += even * q[i];
        }
        if m > 0 {
            for i in 0..L {
                self.odd[i] += odd * q[i];
            }
        }
    }

    #[inline(always)]
    fn end(&mut self, m: usize, c: &[T; L], s: &[T; L]) {
        for i in 0..L {
            self.sum[i] += if m == 0 { self.even[i] } else { self.even[i] * c[i] + self.odd[i] * s[i] };
        }
    }
}

/// Σ_points w y_i for C channels of weights w; a sum for each lane, `lanes[index · C + channel]`.
pub(in crate::sh) struct Accumulate<'a, T, const L: usize, const C: usize> {
    pub lanes: &'a mut [[T; L]],
    pub weights: [[T; L]; C],
    pub even: [[T; L]; C],
    pub odd: [[T; L]; C],
}

impl<T: Real, const L: usize, const C: usize> Visitor<T, L> for Accumulate<'_, T, L, C> {
    #[inline(always)]
    fn begin(&mut self, _: usize, c: &[T; L], s: &[T; L]) {
        for channel in 0..C {
            for i in 0..L {
                self.even[channel][i] = self.weights[channel][i] * c[i];
                self.odd[channel][i] = self.weights[channel][i] * s[i];
            }
        }
    }

    #[inline(always)]
    fn visit(&mut self, l: usize, m: usize, q: &[T; L], _: &[T; L], _: &[T; L]) {
        let centre = l * (l + 1);
        add::<T, L, C>(&mut self.lanes[(centre + m) * C..][..C], q, &self.even);
        if m > 0 {
            add::<T, L, C>(&mut self.lanes[(centre - m) * C..][..C], q, &self.odd);
        }
    }
}

#[inline(always)]
fn add<T: Real, const L: usize, const C: usize>(lanes: &mut [[T; L]], q: &[T; L], weights: &[[T; L]; C]) {
    for channel in 0..C {
        for i in 0..L {
            lanes[channel][i] += q[i] * weights[channel][i];
        }
    }
}
