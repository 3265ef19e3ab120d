//! Lanes of caps for one receiver, or of receivers for one cap each.
//!
//! No fused multiply-add and no sum across lanes but in the order of the caps: every entry point returns the same bits.

use pulp::{Simd, WithSimd};

use super::discs::{Disc, Discs};
use super::table::{CapTable, MAX_BANDS};
use crate::Real;
use crate::numeric::align_stack;
use crate::sh::basis::is_narrow;
use crate::sh::basis::kernel::{Visitor, walk_fixed};

/// The factors k_l of L caps, from the solid angles and whether degrees above 0 count.
#[inline(always)]
pub(super) fn factors<T: Real, const L: usize>(
    table: &CapTable<T>,
    bands: usize,
    versine: &[T; L],
    directed: &[T; L],
    out: &mut [[T; L]],
) {
    let (mut u, mut x) = (*versine, [T::zero(); L]);
    for i in 0..L {
        u[i] = if u[i] > table.largest { table.largest } else { u[i] };
    }
    for &[start, length, slope] in &table.pieces {
        for i in 0..L {
            let inside = u[i] - start;
            let inside = if inside < T::zero() { T::zero() } else { inside };
            x[i] += slope * if inside > length { length } else { inside };
        }
    }
    let (last, mut cell) = (table.cells - T::one(), [T::zero(); L]);
    for i in 0..L {
        cell[i] = x[i].floor();
        cell[i] = if cell[i] > last { last } else { cell[i] };
        x[i] -= cell[i];
    }
    for i in 0..L {
        // NaN is in cell 0, from which it comes out as NaN.
        let first = cell[i].to_usize().unwrap_or(0) * bands;
        let (low, high) = table.nodes[first..first + 2 * bands].split_at(bands);
        for l in 0..bands {
            out[l][i] = low[l] + x[i] * (high[l] - low[l]);
        }
    }
    for (l, out) in out[..bands].iter_mut().enumerate() {
        for i in 0..L {
            out[i] *= if l == 0 { u[i] } else { u[i] * directed[i] };
        }
    }
}

/// The k_l y_lm of a place in the walk: those of m and of −m, the same twice where m is 0.
#[inline(always)]
fn weighted<T: Real, const L: usize>(k: &[T; L], q: &[T; L], c: &[T; L], s: &[T; L]) -> [[T; L]; 2] {
    let (mut even, mut odd) = ([T::zero(); L], [T::zero(); L]);
    for i in 0..L {
        let value = k[i] * q[i];
        even[i] = value * c[i];
        odd[i] = value * s[i];
    }
    [even, odd]
}

/// Where the terms of L caps or receivers go.
trait Sink<T, const L: usize> {
    /// Adds to coefficient `at`.
    fn add(&mut self, at: usize, value: &[T; L]);
}

/// Hands the terms of the walk to a sink.
struct Add<'a, T, const L: usize, A> {
    k: &'a [[T; L]],
    sink: A,
}

impl<T: Real, const L: usize, A: Sink<T, L>> Visitor<T, L> for Add<'_, T, L, A> {
    #[inline(always)]
    fn visit(&mut self, l: usize, m: usize, q: &[T; L], c: &[T; L], s: &[T; L]) {
        let centre = l * (l + 1);
        let [even, odd] = weighted(&self.k[l], q, c, s);
        self.sink.add(centre + m, &even);
        if m > 0 {
            self.sink.add(centre - m, &odd);
        }
    }
}

/// The sums of L receivers, a row for each coefficient.
struct Lanes<'a, T, const L: usize>(&'a mut [[T; L]]);

impl<T: Real, const L: usize> Sink<T, L> for Lanes<'_, T, L> {
    #[inline(always)]
    fn add(&mut self, at: usize, value: &[T; L]) {
        for i in 0..L {
            self.0[at][i] += value[i];
        }
    }
}

/// Rows of the output, of which `count` of L places from `first` are there.
struct Rows<'a, T> {
    out: &'a mut [T],
    stride: usize,
    first: usize,
    count: usize,
}

impl<T: Real, const L: usize> Sink<T, L> for Rows<'_, T> {
    #[inline(always)]
    fn add(&mut self, at: usize, value: &[T; L]) {
        let out = &mut self.out[at * self.stride + self.first..][..self.count];
        out.iter_mut().zip(value).for_each(|(out, value)| *out += *value);
    }
}

/// The sums of one receiver, to which L caps are added one after the other; `count` of them are there.
struct InOrder<'a, T> {
    out: &'a mut [T],
    count: usize,
}

impl<T: Real, const L: usize> Sink<T, L> for InOrder<'_, T> {
    #[inline(always)]
    fn add(&mut self, at: usize, value: &[T; L]) {
        let mut sum = self.out[at];
        value[..self.count].iter().for_each(|value| sum += *value);
        self.out[at] = sum;
    }
}

/// Sums of all discs; one receiver, or `receivers` of them, coefficient-major.
pub(super) struct Job<'a, T, D> {
    pub table: &'a CapTable<T>,
    pub discs: D,
    /// `None` for one receiver, whose caps are in lanes.
    pub receivers: Option<usize>,
    pub out: &'a mut [T],
}

impl<T: Real, D: Discs<T>> WithSimd for Job<'_, T, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        align_stack();
        // As many lanes as the basis has.
        if is_narrow::<T>() { self.run::<16>() } else { self.run::<8>() }
    }
}

impl<T: Real, D: Discs<T>> Job<'_, T, D> {
    #[inline(always)]
    fn run<const L: usize>(self) {
        match (self.receivers, self.table.bands) {
            (None, 1) => self.caps::<L, 1, 1>(),
            (None, 2) => self.caps::<L, 2, 2>(),
            (None, 3) => self.caps::<L, 3, 3>(),
            (None, 4) => self.caps::<L, 4, 4>(),
            (None, 5) => self.caps::<L, 5, 5>(),
            (None, 6) => self.caps::<L, 6, 6>(),
            (None, _) => self.caps::<L, 0, MAX_BANDS>(),
            (Some(count), 1) => self.receivers::<L, 1, 1>(count),
            (Some(count), 2) => self.receivers::<L, 2, 4>(count),
            (Some(count), 3) => self.receivers::<L, 3, 9>(count),
            (Some(count), 4) => self.receivers::<L, 4, 16>(count),
            (Some(count), 5) => self.receivers::<L, 5, 25>(count),
            (Some(count), 6) => self.receivers::<L, 6, 36>(count),
            (Some(count), _) => self.many_bands::<L>(count),
        }
    }

    /// One receiver. B bands, or any number where B is 0; K factors.
    #[inline(always)]
    fn caps<const L: usize, const B: usize, const K: usize>(self) {
        let Self { table, discs, out, .. } = self;
        let (bands, mut k) = (if B == 0 { table.bands } else { B }, [[T::zero(); L]; K]);
        for first in (0..discs.len()).step_by(L) {
            let count = L.min(discs.len() - first);
            let Disc { direction: [x, y, z], versine, directed } = discs.caps(first);
            factors(table, bands, &versine, &directed, &mut k);
            // A number that is known unrolls.
            if count == L {
                let mut add = Add { k: &k, sink: InOrder { out: &mut *out, count: L } };
                walk_fixed::<T, L, B, _>(&table.basis, bands, [&x, &y, &z], &mut add);
            } else {
                let mut add = Add { k: &k, sink: InOrder { out: &mut *out, count } };
                walk_fixed::<T, L, B, _>(&table.basis, bands, [&x, &y, &z], &mut add);
            }
        }
    }

    /// L receivers at a time. B bands, N = B² sums.
    #[inline(always)]
    fn receivers<const L: usize, const B: usize, const N: usize>(self, stride: usize) {
        let Self { table, discs, out, .. } = self;
        for first in (0..stride).step_by(L) {
            let count = L.min(stride - first);
            let (mut sums, mut k) = ([[T::zero(); L]; N], [[T::zero(); L]; B]);
            for (row, sums) in sums.iter_mut().enumerate() {
                sums[..count].copy_from_slice(&out[row * stride + first..][..count]);
            }
            for disc in 0..discs.len() {
                let Disc { direction: [x, y, z], versine, directed } = discs.receivers(disc, first);
                factors(table, B, &versine, &directed, &mut k);
                let mut add = Add { k: &k, sink: Lanes(&mut sums) };
                walk_fixed::<T, L, B, _>(&table.basis, B, [&x, &y, &z], &mut add);
            }
            for (row, sums) in sums.iter().enumerate() {
                out[row * stride + first..][..count].copy_from_slice(&sums[..count]);
            }
        }
    }

    /// L receivers at a time, any number of bands: sums stay in the output.
    #[inline(always)]
    fn many_bands<const L: usize>(self, stride: usize) {
        let Self { table, discs, out, .. } = self;
        let mut k = [[T::zero(); L]; MAX_BANDS];
        for first in (0..stride).step_by(L) {
            let count = L.min(stride - first);
            for disc in 0..discs.len() {
                let Disc { direction: [x, y, z], versine, directed } = discs.receivers(disc, first);
                factors(table, table.bands, &versine, &directed, &mut k);
                let mut add = Add { k: &k, sink: Rows { out: &mut *out, stride, first, count } };
                walk_fixed::<T, L, 0, _>(&table.basis, table.bands, [&x, &y, &z], &mut add);
            }
        }
    }
}
