//! The source as a table of its primitive: an integral over a cell is a difference of a few look-ups, whatever the
//! source holds.
//!
//! The primitive of pixels is (bi)linear on each of them, so one record a pixel, of the corner's value and its
//! differences, is all that an evaluation reads.

use super::walk::{Cell, Seen, Source};
use crate::affine::AffineMap;

/// [P, ΔP] of each pixel: P(x) = ∫₀^x F.
#[derive(Debug, Clone)]
pub(super) struct Table1d {
    records: Vec<[f64; 2]>,
}

/// [P, Δ_x P, Δ_y P, Δ_x Δ_y P] of each pixel and channel: P(x, y) = ∫₀^x ∫₀^y F.
#[derive(Debug, Clone)]
pub(super) struct Table2d<const C: usize> {
    records: Vec<[[f64; 4]; C]>,
    side: usize,
}

impl Table1d {
    pub(super) fn new(pixels: &[f64]) -> Self {
        let weight = (pixels.len() as f64).recip();
        let mut sum = 0.0;
        let records = pixels.iter().map(|&f| {
            let before = sum;
            sum += f * weight;
            [before, f * weight]
        });
        Self { records: records.collect() }
    }
}

impl<const C: usize> Table2d<C> {
    /// Of the pixels of each channel.
    pub(super) fn new(side: usize, channels: &[Vec<f64>; C]) -> Self {
        let weight = ((side * side) as f64).recip();
        let mut records = vec![[[0.0; 4]; C]; side * side];
        for (channel, pixels) in channels.iter().enumerate() {
            // Σ of the pixels above, by column.
            let mut above = vec![0.0; side];
            for (y, row) in pixels.chunks_exact(side).enumerate() {
                let (mut corner, mut left) = (0.0, 0.0);
                for (x, &f) in row.iter().enumerate() {
                    let f = f * weight;
                    records[y * side + x][channel] = [corner, above[x], left, f];
                    corner += above[x];
                    left += f;
                    above[x] += f;
                }
            }
        }
        Self { records, side }
    }
}

/// A point of an axis: its pixel, how far it is into it, and whether it moves with s and o (else it is held at 0 or 1).
#[derive(Debug, Clone, Copy)]
struct Point {
    pixel: usize,
    fraction: f64,
    free: bool,
}

/// The three cuts of a cell, seen in the source; `None` if the cell sees nothing of it.
#[inline(always)]
fn points(map: AffineMap, cuts: [f64; 3], size: usize) -> Option<[Point; 3]> {
    let x = cuts.map(|v| map.apply(v));
    let (low, high) = if map.scale() > 0.0 { (x[0], x[2]) } else { (x[2], x[0]) };
    // A cell that ends at 0 is about to enter.
    if high < 0.0 || low >= 1.0 {
        return None;
    }
    Some(x.map(|x| {
        let y = x.clamp(0.0, 1.0) * size as f64;
        let pixel = (y as usize).min(size - 1);
        Point { pixel, fraction: y - pixel as f64, free: (0.0..1.0).contains(&x) }
    }))
}

/// The source seen through maps: integrals.
pub(super) struct Values<'a, R, M> {
    pub(super) table: &'a R,
    pub(super) maps: M,
}

/// The source seen through maps: integrals and their derivatives.
pub(super) struct Slopes<'a, R, M> {
    pub(super) table: &'a R,
    pub(super) maps: M,
}

impl Source<2> for Values<'_, Table1d, [AffineMap; 1]> {
    type Sum = [[f64; 1]; 1];

    #[inline(always)]
    fn seen(&self, cell: Cell) -> Seen<[[f64; 1]; 1], 2> {
        let [map] = self.maps;
        let Some(points) = points(map, cell.cuts(0), self.table.records.len()) else { return Seen::Nothing };
        let p = points.map(|at| {
            let [p, slope] = self.table.records[at.pixel];
            p + at.fraction * slope
        });
        let inverse = map.scale().recip();
        Seen::Parts([[[(p[1] - p[0]) * inverse]], [[(p[2] - p[1]) * inverse]]])
    }
}

impl Source<2> for Slopes<'_, Table1d, [AffineMap; 1]> {
    type Sum = [[f64; 1]; 3];

    fn seen(&self, cell: Cell) -> Seen<[[f64; 1]; 3], 2> {
        let [map] = self.maps;
        let (cuts, size) = (cell.cuts(0), self.table.records.len());
        let Some(points) = points(map, cuts, size) else { return Seen::Nothing };
        let inverse = map.scale().recip();
        // [P, ∂P/∂s, ∂P/∂o] at each cut, over s; of 1/s below.
        let p: [[f64; 3]; 3] = std::array::from_fn(|k| {
            let [p, slope] = self.table.records[points[k].pixel];
            let f = if points[k].free { slope * size as f64 } else { 0.0 };
            [p + points[k].fraction * slope, cuts[k] * f, f].map(|x| x * inverse)
        });
        Seen::Parts([0, 1].map(|half| {
            let [value, scale, offset]: [f64; 3] = std::array::from_fn(|n| p[half + 1][n] - p[half][n]);
            [[value], [scale - value * inverse], [offset]]
        }))
    }
}

impl<const C: usize> Source<4> for Values<'_, Table2d<C>, [AffineMap; 2]> {
    type Sum = [[f64; C]; 1];

    #[inline(always)]
    fn seen(&self, cell: Cell) -> Seen<[[f64; C]; 1], 4> {
        let [map_x, map_y] = self.maps;
        let side = self.table.side;
        let Some(x) = points(map_x, cell.cuts(0), side) else { return Seen::Nothing };
        let Some(y) = points(map_y, cell.cuts(1), side) else { return Seen::Nothing };
        let inverse = (map_x.scale() * map_y.scale()).recip();
        // Rows of P at the three cuts in y, differenced along x.
        let rows: [[[f64; C]; 2]; 3] = y.map(|y| {
            let p: [[f64; C]; 3] = x.map(|x| {
                self.table.records[y.pixel * side + x.pixel]
                    .map(|[p, dx, dy, dxy]| (p + x.fraction * dx) + y.fraction * (dy + x.fraction * dxy))
            });
            [0, 1].map(|half| std::array::from_fn(|c| p[half + 1][c] - p[half][c]))
        });
        Seen::Parts(std::array::from_fn(|child| {
            let (right, low) = (child & 1, child >> 1);
            [std::array::from_fn(|c| (rows[low + 1][right][c] - rows[low][right][c]) * inverse)]
        }))
    }
}

impl<const C: usize> Source<4> for Slopes<'_, Table2d<C>, [AffineMap; 2]> {
    type Sum = [[f64; C]; 5];

    fn seen(&self, cell: Cell) -> Seen<[[f64; C]; 5], 4> {
        let [map_x, map_y] = self.maps;
        let side = self.table.side;
        let cuts = [cell.cuts(0), cell.cuts(1)];
        let Some(x) = points(map_x, cuts[0], side) else { return Seen::Nothing };
        let Some(y) = points(map_y, cuts[1], side) else { return Seen::Nothing };
        let [over_x, over_y] = [map_x, map_y].map(|map| map.scale().recip());
        let inverse = over_x * over_y;
        // [P, ∂/∂s_x, ∂/∂o_x, ∂/∂s_y, ∂/∂o_y] at the nine corners, without the factor 1/(s_x s_y).
        let corner = |ky: usize, kx: usize, c: usize| -> [f64; 5] {
            let (x, y) = (x[kx], y[ky]);
            let [p, dx, dy, dxy] = self.table.records[y.pixel * side + x.pixel][c];
            let f_x = if x.free { (dx + y.fraction * dxy) * side as f64 } else { 0.0 };
            let f_y = if y.free { (dy + x.fraction * dxy) * side as f64 } else { 0.0 };
            let value = (p + x.fraction * dx) + y.fraction * (dy + x.fraction * dxy);
            [value, cuts[0][kx] * f_x, f_x, cuts[1][ky] * f_y, f_y]
        };
        let corners: [[[[f64; 5]; C]; 3]; 3] =
            std::array::from_fn(|ky| std::array::from_fn(|kx| std::array::from_fn(|c| corner(ky, kx, c))));
        Seen::Parts(std::array::from_fn(|child| {
            let (right, low) = (child & 1, child >> 1);
            let mut sums = [[0.0; C]; 5];
            for c in 0..C {
                let part = |n: usize| {
                    let at = |ky: usize, kx: usize| corners[low + ky][right + kx][c][n];
                    ((at(1, 1) - at(1, 0)) - (at(0, 1) - at(0, 0))) * inverse
                };
                let value = part(0);
                let all = [value, part(1) - value * over_x, part(2), part(3) - value * over_y, part(4)];
                (0..5).for_each(|n| sums[n][c] = all[n]);
            }
            sums
        }))
    }
}
