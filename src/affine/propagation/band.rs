//! Area resampling of one axis: the couplings of the pixel basis as a band of weights.
//!
//! Of M source and N target cells, and in cells of the target, source cell m lies between b_m and b_{m+1}, b_m = (m − M
//! o)/s', with s' = s M/N the source cells of a target cell. Its weight in target cell k is the overlap of the two: the
//! average of F(s v + o) over the cell is the weighted sum, exactly. A target cell meets at most ⌈|s'|⌉ + 1 source
//! cells.

use std::ops::Range;

use crate::Real;
use crate::affine::exact_sum::{exact_product, exact_sum};
use crate::affine::pixel::Grid;
use crate::affine::{AffineMap, Parameter};

/// What the weights are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::affine) enum Weights {
    /// Those of the map.
    Value,
    /// Their right-hand derivatives.
    Slope(Parameter),
}

/// `count` weights for each target cell, of the source cells from `base[k]` on.
#[derive(Debug, Clone)]
pub(in crate::affine) struct Band<T> {
    count: usize,
    active: Range<usize>,
    base: Vec<u32>,
    weight: Vec<T>,
}

impl<T: Real> Band<T> {
    pub(in crate::affine) fn new() -> Self {
        Self { count: 0, active: 0..0, base: Vec::new(), weight: Vec::new() }
    }

    /// Sets the weights of `sources` cells in `targets` cells, powers of two.
    #[inline(always)]
    pub(in crate::affine) fn set(&mut self, sources: usize, targets: usize, map: AffineMap, weights: Weights) {
        let (n, ratio) = (sources as f64, sources as f64 / targets as f64);
        let map = map.stretched(ratio);
        let (s, o) = (map.scale(), map.offset() * n);
        // A cell that is about to be met counts for a slope.
        let margin = usize::from(weights != Weights::Value);
        self.count = ((s.abs().ceil().min(n)) as usize + 1 + 2 * margin).min(sources);
        let (first, last) = (-o / s, (n - o) / s);
        let clip = |y: f64| y.clamp(0.0, targets as f64) as usize;
        let (low, high) = (first.min(last).floor() - margin as f64, first.max(last).ceil() + margin as f64);
        self.active = clip(low)..clip(high);
        self.base.resize(targets, 0);
        self.weight.resize(targets * self.count, T::zero());
        let room = (sources - self.count) as f64;
        // In f32 the sliver that rounding may miss of a cell does not show, unless it is all that is seen.
        let is_short = size_of::<T>() == 4;
        let is_plain = is_short && s.abs() > 1e-4;
        let step = f64::from(u8::from(s < 0.0));
        for (k, base) in self.base[self.active.clone()].iter_mut().enumerate() {
            let lower_end = (self.active.start + k) as f64 + step;
            let cell = if is_plain { (s * lower_end + o).floor() } else { image_cell(s, lower_end, o) };
            *base = (cell - margin as f64).clamp(0.0, room) as u32;
        }
        // In f32 the rounding of the reciprocal does not show.
        let inverse = 1.0 / s;
        let edge = |m: f64| if is_short { (m - o) * inverse } else { (m - o) / s };
        for k in self.active.clone() {
            let (base, k0) = (f64::from(self.base[k]), k as f64);
            let row = &mut self.weight[k * self.count..][..self.count];
            let mut before = edge(base);
            for (q, w) in row.iter_mut().enumerate() {
                let after = edge(base + (q + 1) as f64);
                *w = T::of(match weights {
                    Weights::Value => overlap(before, after, k0),
                    Weights::Slope(parameter) => {
                        let velocity = |b: f64| match parameter {
                            Parameter::Scale => -b / s * ratio,
                            Parameter::Offset => -n / s,
                        };
                        if at_border(before, k0) || at_border(after, k0) {
                            slope_at_border([sources, targets], base as usize + q, k, map, parameter)
                        } else {
                            overlap_slope([before, after], [velocity(before), velocity(after)], k0)
                        }
                    }
                });
                before = after;
            }
        }
    }

    /// Rows of `width`: dst[k] = Σ_q weight · src[base[k] + q].
    #[inline(always)]
    pub(in crate::affine) fn combine(&self, width: usize, src: &[T], dst: &mut [T]) {
        dst[..self.active.start * width].fill(T::zero());
        dst[self.active.end * width..].fill(T::zero());
        for k in self.active.clone() {
            let rows = &src[self.base[k] as usize * width..][..self.count * width];
            let weights = &self.weight[k * self.count..][..self.count];
            let row = &mut dst[k * width..][..width];
            match *weights {
                [] => row.fill(T::zero()),
                [a, b] => combine_rows([a, b], width, rows, row),
                [a, b, c] => combine_rows([a, b, c], width, rows, row),
                _ => combine_any(weights, width, rows, row),
            }
        }
    }

    /// The target cells that see any source.
    #[inline(always)]
    pub(super) fn active(&self) -> Range<usize> {
        self.active.clone()
    }

    /// The source cells, of so many, that any of those may see.
    #[inline(always)]
    pub(super) fn reached(&self, sources: usize) -> Range<usize> {
        let bases = &self.base[self.active.clone()];
        match (bases.first(), bases.last()) {
            // Bases rise or fall.
            (Some(&a), Some(&b)) => a.min(b) as usize..(a.max(b) as usize + self.count).min(sources),
            _ => 0..0,
        }
    }

    /// The transpose of [`combine`](Self::combine), in the `rows` that are reached (or more) and some `columns`: dst =
    /// Σ_k weight · src[k]; what is elsewhere stays.
    ///
    /// Shapes: src and dst have rows of `width`.
    #[inline(always)]
    pub(super) fn scatter(&self, rows: Range<usize>, columns: Range<usize>, width: usize, src: &[T], dst: &mut [T]) {
        if self.active.is_empty() {
            return rows.for_each(|row| dst[row * width..][columns.clone()].fill(T::zero()));
        }
        // By source cell, so that sums stay in registers: the target cells that reach it follow one another.
        let rises = self.base[self.active.start] <= self.base[self.active.end - 1];
        let (mut first, mut end) = (self.active.start, self.active.start);
        for place in 0..rows.len() {
            let row = if rises { rows.start + place } else { rows.end - 1 - place };
            let reaches = |k: usize| (self.base[k] as usize..self.base[k] as usize + self.count).contains(&row);
            let is_past = |k: usize| match rises {
                true => self.base[k] as usize + self.count <= row,
                false => self.base[k] as usize > row,
            };
            while first < self.active.end && is_past(first) {
                first += 1;
            }
            end = end.max(first);
            while end < self.active.end && reaches(end) {
                end += 1;
            }
            let sources = (first..end).map(|k| (self.weight[k * self.count + row - self.base[k] as usize], k * width));
            let out = &mut dst[row * width..][columns.clone()];
            match columns.len() {
                n if n.is_multiple_of(16) => sum_rows::<T, 16>(sources, columns.start, src, out),
                n if n.is_multiple_of(8) => sum_rows::<T, 8>(sources, columns.start, src, out),
                _ => sum_rows::<T, 1>(sources, columns.start, src, out),
            }
        }
    }
}

/// ⌊s k + o⌋: where rounding s k + o would cross the end of a cell, the cell below it would be missed, which at a small
/// |s| is all that target cell k sees.
#[inline(always)]
fn image_cell(s: f64, k: f64, o: f64) -> f64 {
    let (product, product_low) = exact_product(s, k);
    let (sum, sum_low) = exact_sum(product, o);
    let (high, low) = exact_sum(sum, sum_low + product_low);
    let cell = high.floor();
    if cell == high && low < 0.0 { cell - 1.0 } else { cell }
}

/// Whether an end may, but for its rounding, lie on an end of target cell k.
#[inline(always)]
fn at_border(end: f64, k: f64) -> bool {
    let near = 4.0 * f64::EPSILON * (k + 1.0);
    (end - k).abs() <= near || (end - k - 1.0).abs() <= near
}

/// The slope of the weight of source cell i in target cell k, with the sides of all ends decided without rounding;
/// `map` takes cells to cells.
#[cold]
fn slope_at_border([sources, targets]: [usize; 2], i: usize, k: usize, map: AffineMap, parameter: Parameter) -> f64 {
    let along = match parameter {
        Parameter::Scale => [sources as f64 / targets as f64, 0.0],
        Parameter::Offset => [0.0, 1.0],
    };
    Grid::new(sources, map).slope(i, k, along)
}

/// |[b, a) ∩ [k, k + 1)| of the ends b and a in either order.
#[inline(always)]
fn overlap(b: f64, a: f64, k: f64) -> f64 {
    let (low, high) = if b < a { (b, a) } else { (a, b) };
    let (low, high) = (if low > k { low } else { k }, if high < k + 1.0 { high } else { k + 1.0 });
    if high > low { high - low } else { 0.0 }
}

/// The right-hand derivative of [`overlap`], its ends moving with the velocities: an end counts while it is inside, or
/// enters.
#[inline(always)]
fn overlap_slope(ends: [f64; 2], velocities: [f64; 2], k: f64) -> f64 {
    let moves = |e: usize| {
        let (x, v) = (ends[e], velocities[e]);
        let inside = if v < 0.0 { x > k && x <= k + 1.0 } else { x >= k && x < k + 1.0 };
        if inside { v } else { 0.0 }
    };
    if ends[0] <= ends[1] { moves(1) - moves(0) } else { moves(0) - moves(1) }
}

/// out = Σ weight · src[start + column…], LANES columns at a time.
#[inline(always)]
fn sum_rows<T: Real, const LANES: usize>(
    sources: impl Iterator<Item = (T, usize)> + Clone,
    column: usize,
    src: &[T],
    out: &mut [T],
) {
    for (i, out) in out.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
        let mut sum = [T::zero(); LANES];
        for (w, start) in sources.clone() {
            let row = &src[start + column + i * LANES..].as_chunks::<LANES>().0[0];
            for x in 0..LANES {
                sum[x] += w * row[x];
            }
        }
        *out = sum;
    }
}

#[inline(always)]
fn combine_rows<T: Real, const K: usize>(weights: [T; K], width: usize, rows: &[T], out: &mut [T]) {
    let rows: [&[T]; K] = std::array::from_fn(|q| &rows[q * width..][..width]);
    const STEP: usize = 8;
    let blocks = rows.map(|row| row.as_chunks::<STEP>().0);
    let (out_blocks, rest) = out[..width].as_chunks_mut::<STEP>();
    for (b, out) in out_blocks.iter_mut().enumerate() {
        let mut sum = [T::zero(); STEP];
        for q in 0..K {
            for x in 0..STEP {
                sum[x] += weights[q] * blocks[q][b][x];
            }
        }
        *out = sum;
    }
    let done = width - rest.len();
    for (x, out) in rest.iter_mut().enumerate() {
        *out = (0..K).map(|q| weights[q] * rows[q][done + x]).sum();
    }
}

#[inline(always)]
fn combine_any<T: Real>(weights: &[T], width: usize, rows: &[T], out: &mut [T]) {
    out.fill(T::zero());
    for (&w, row) in weights.iter().zip(rows.chunks_exact(width)) {
        for (out, &x) in out.iter_mut().zip(row) {
            *out += w * x;
        }
    }
}
