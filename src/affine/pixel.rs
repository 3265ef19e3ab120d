//! Where the pixels of a moved image meet those of another: what propagation through pixels stands on, and the
//! couplings of `reference::affine::pixel_basis`.
#![allow(dead_code, reason = "some of it is for `reference` alone")]

use super::AffineMap;
use super::exact_sum::{exact_product, separation};

/// The one-sided derivative of the overlap of two pixels at (s, o) along `along` = (ds, do): lim (D(s + ε ds, o + ε do)
/// − D)/ε for ε → 0 from above.
///
/// Exact up to rounding, kinks included: where an end of the source pixel lies on an end of the target pixel, the
/// direction decides which of the two bounds the overlap.
///
/// # Panics
/// If i or j is not below `size`.
#[track_caller]
pub fn pixel_coupling_slope(size: usize, i: usize, j: usize, map: AffineMap, along: [f64; 2]) -> f64 {
    assert!(i < size && j < size, "pixels {:?} of {size}", [i, j]);
    Grid::new(size, map).slope(i, j, along)
}

fn first(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    if b < a { b } else { a }
}

fn last(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    if a < b { b } else { a }
}

/// The ends b_k = (k − No)/s of the source pixels against those of the target, j = 0 … N.
#[derive(Clone, Copy)]
pub(crate) struct Grid {
    size: usize,
    scale: f64,
    /// No = high + low, exactly.
    offset: (f64, f64),
}

impl Grid {
    pub(crate) fn new(size: usize, map: AffineMap) -> Self {
        Self { size, scale: map.scale(), offset: exact_product(map.offset(), size as f64) }
    }

    /// b_k − j, in pixels: its sign is exact, its error a few ε of itself.
    pub(crate) fn distance(&self, k: usize, j: usize) -> f64 {
        separation(k as f64, exact_product(self.scale, j as f64), self.offset) / self.scale
    }

    /// The ends of source pixel i as the target sees them, the lower first.
    pub(crate) fn ends(&self, i: usize) -> [usize; 2] {
        if self.scale > 0.0 { [i, i + 1] } else { [i + 1, i] }
    }

    /// The source pixel that is number `step` along the target.
    pub(crate) fn pixel(&self, step: usize) -> usize {
        if self.scale > 0.0 { step } else { self.size - 1 - step }
    }

    /// |[b_i, b_{i+1}] ∩ [j, j + 1]| if it is not 0: of the four differences of an upper and a lower end, the least.
    pub(crate) fn overlap(&self, i: usize, j: usize) -> Option<f64> {
        let [low, high] = self.ends(i);
        let (to_end, to_start) = (-self.distance(low, j + 1), self.distance(high, j));
        if to_end <= 0.0 || to_start <= 0.0 {
            return None;
        }
        Some(to_end.min(to_start).min(self.scale.abs().recip()).min(1.0))
    }

    /// Whether [b_i, b_{i+1}] and [j, j + 1] have a point in common.
    fn touches(&self, i: usize, j: usize) -> bool {
        let [low, high] = self.ends(i);
        self.distance(low, j + 1) <= 0.0 && self.distance(high, j) >= 0.0
    }

    /// The one-sided derivative of the overlap of source pixel i and target pixel j along (ds, do).
    pub(crate) fn slope(&self, i: usize, j: usize, along: [f64; 2]) -> f64 {
        if !self.touches(i, j) {
            return 0.0;
        }
        let [low, high] = self.ends(i);
        // (position relative to that end of pixel j, velocity) of what bounds the overlap; of two that coincide, the
        // one that will.
        let velocity = |end: usize| self.velocity(end, j, along);
        let left = last((0.0, 0.0), (self.distance(low, j), velocity(low)));
        let right = first((0.0, 0.0), (self.distance(high, j + 1), velocity(high)));
        let growth = right.1 - left.1;
        if self.overlap(i, j).is_some() { growth } else { growth.max(0.0) }
    }

    /// The first pair that overlaps, as (step along the source, target pixel); N for one past the end if none does.
    pub(crate) fn start(&self) -> (usize, usize) {
        if self.size == 0 {
            return (0, 0);
        }
        let first = self.ends(self.pixel(0))[0];
        // The largest j ≤ b of the first source end b, and the first step that ends after it: a guess in `f64`, then
        // exactly.
        let mut j = (self.distance(first, 0).max(0.0) as usize).min(self.size);
        while j > 0 && self.distance(first, j) < 0.0 {
            j -= 1;
        }
        while j < self.size && self.distance(first, j + 1) >= 0.0 {
            j += 1;
        }
        let end = |step: usize| self.distance(self.ends(self.pixel(step))[1], j);
        let guess = (-self.distance(first, j)).max(0.0) * self.scale.abs();
        let mut step = (guess as usize).min(self.size - 1);
        while step > 0 && end(step - 1) > 0.0 {
            step -= 1;
        }
        while step < self.size && end(step) <= 0.0 {
            step += 1;
        }
        (step, j)
    }

    /// The velocity of b_k − j along (ds, do), for target pixel j near it: ∂b/∂s = −b/s, ∂b/∂o = −N/s.
    fn velocity(&self, k: usize, j: usize, [ds, d_o]: [f64; 2]) -> f64 {
        let at = j as f64 + self.distance(k, j);
        let along = |direction: f64, slope: f64| if direction == 0.0 { 0.0 } else { direction * slope };
        -(along(ds, at) + along(d_o, self.size as f64)) / self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_far_below_the_rounding_of_their_terms_are_right() {
        // k − s·j − No = 2^−107 and −11·2^−106, as rationals have it: two roundings more lose the one and a tenth of
        // the other.
        let mantissa = |m: u64, exponent: i32| m as f64 * 2f64.powi(exponent);
        for (size, k, j, s, o, source) in [
            (3, 2, 3, mantissa(6004799503160661, -107), 2.0 / 3.0, mantissa(1, -107)),
            (11, 5, 9, -mantissa(8006399337547546, -107), 0.4545454545454546, -mantissa(11, -106)),
        ] {
            let got = Grid::new(size, AffineMap::new(s, o).unwrap()).distance(k, j);
            assert_eq!(got, source / s, "{s:e} {o}");
        }
    }
}
