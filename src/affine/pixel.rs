//! Affine couplings and triplings of the pixel basis, for comparison with Haar.

use super::AffineMap;
use super::exact_sum::{exact_product, separation};

/// Affine coupling of two functions Φ_k = √N · 1 on [k/N, (k + 1)/N) of the orthonormal pixel basis.
///
///   D_ij(s, o) = ∫ Φ_i(sv + o) Φ_j(v) dv = |[b_i, b_{i+1}] ∩ [j, j + 1]|,    b_k = (k − No)/s                  [Sun 2008, §4.4.1]
///
/// the part of the source pixel, seen from the target, that lies in target pixel j, in pixels. Whether two pixels
/// overlap is decided exactly for the numbers that `map` holds.
///
/// Accuracy: a few ε relative to D. All of them: [`pixel_coupling_nonzeros`].
///
/// # Panics
/// If i or j is not below `size`.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, pixel_coupling};
/// let right = AffineMap::new(1.0, 0.25)?;
/// assert_eq!(pixel_coupling(2, 1, 0, right), 0.5); // half of the right pixel moves to the left one
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[track_caller]
pub fn pixel_coupling(size: usize, i: usize, j: usize, map: AffineMap) -> f64 {
    check(size, [i, j]);
    Grid::new(size, map).overlap(i, j).unwrap_or(0.0)
}

/// Affine tripling of three functions of the orthonormal pixel basis.
///
///   D_ijk = ∫ Φ_i(sv + o) Φ_j(v) Φ_k(v) dv = √N δ_jk D_ij
///
/// by [Sun 2008, eq. 4.14] with C_jjj = √N: the text has 1, for pixels that are not orthonormal (docs/errata.md).
///
/// # Panics
/// If i, j or k is not below `size`.
#[track_caller]
pub fn pixel_tripling(size: usize, i: usize, j: usize, k: usize, map: AffineMap) -> f64 {
    check(size, [i, j, k]);
    if j == k { (size as f64).sqrt() * pixel_coupling(size, i, j, map) } else { 0.0 }
}

#[track_caller]
fn check<const K: usize>(size: usize, indices: [usize; K]) {
    assert!(indices.iter().all(|&i| i < size), "pixels {indices:?} of {size}");
}

/// The one-sided derivative of [`pixel_coupling`] at (s, o) along `along` = (ds, do): lim (D(s + ε ds, o + ε do) − D)/ε
/// for ε → 0 from above.
///
/// Exact up to rounding, kinks included: where an end of the source pixel lies on an end of the target pixel, the
/// direction decides which of the two bounds the overlap.
///
/// # Panics
/// If i or j is not below `size`.
#[track_caller]
pub fn pixel_coupling_slope(size: usize, i: usize, j: usize, map: AffineMap, along: [f64; 2]) -> f64 {
    check(size, [i, j]);
    let grid = Grid::new(size, map);
    if !grid.touches(i, j) {
        return 0.0;
    }
    let [low, high] = grid.ends(i);
    // (position relative to that end of pixel j, velocity) of what bounds the overlap; of two that coincide, the one
    // that will.
    let velocity = |end: usize| grid.velocity(end, j, along);
    let left = last((0.0, 0.0), (grid.distance(low, j), velocity(low)));
    let right = first((0.0, 0.0), (grid.distance(high, j + 1), velocity(high)));
    let growth = right.1 - left.1;
    if grid.overlap(i, j).is_some() { growth } else { growth.max(0.0) }
}

fn first(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    if b < a { b } else { a }
}

fn last(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    if a < b { b } else { a }
}

/// [∂D/∂s, ∂D/∂o] of [`pixel_coupling`], each the right-hand derivative at a kink; other directions:
/// [`pixel_coupling_slope`].
///
/// # Panics
/// If i or j is not below `size`.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, pixel_coupling_gradient};
/// let right = AffineMap::new(1.0, 0.25)?;
/// assert_eq!(pixel_coupling_gradient(2, 1, 0, right), [0.5, 2.0]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[track_caller]
pub fn pixel_coupling_gradient(size: usize, i: usize, j: usize, map: AffineMap) -> [f64; 2] {
    [[1.0, 0.0], [0.0, 1.0]].map(|along| pixel_coupling_slope(size, i, j, map, along))
}

/// Every (i, j, D_ij ≠ 0) of the pixel basis, by j.
///
/// Exactly those that are not zero for the numbers that `map` holds: pixels that only touch are left out. At most
/// [`pixel_coupling_bound`] of them. Cost: proportional to the output; no table.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, pixel_coupling_nonzeros};
/// let half = AffineMap::new(0.5, 0.5)?; // the right half, drawn twice as large
/// let all: Vec<_> = pixel_coupling_nonzeros(4, half).collect();
/// assert_eq!(all, [(2, 0, 1.0), (2, 1, 1.0), (3, 2, 1.0), (3, 3, 1.0)]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
pub fn pixel_coupling_nonzeros(size: usize, map: AffineMap) -> impl Iterator<Item = (usize, usize, f64)> {
    let grid = Grid::new(size, map);
    let (mut step, mut j) = grid.start();
    std::iter::from_fn(move || {
        if step >= size || j >= size {
            return None;
        }
        let i = grid.pixel(step);
        let value = grid.overlap(i, j).expect("pixels on the way overlap");
        let here = j;
        // On with whichever pixel ends first, or both.
        let order = grid.distance(grid.ends(i)[1], j + 1);
        step += usize::from(order <= 0.0);
        j += usize::from(order >= 0.0);
        Some((i, here, value))
    })
}

/// Every (i, j, j, D_ijj ≠ 0) of the pixel basis, by j: [`pixel_coupling_nonzeros`] times √N.
pub fn pixel_tripling_nonzeros(size: usize, map: AffineMap) -> impl Iterator<Item = ([usize; 3], f64)> {
    let height = (size as f64).sqrt();
    pixel_coupling_nonzeros(size, map).map(move |(i, j, value)| ([i, j, j], height * value))
}

/// The most non-zero couplings that N pixels can have at this scale, whatever the offset.
///
///   N + min(⌈N·min(|s|, 1/|s|)⌉, N − 1)
///
/// The pieces between all pixel ends of source and target inside what they have in common: an open interval of length w
/// holds at most ⌈w⌉ ends of a grid of step 1. [Sun 2008, §4.4.1] has min((s + 1)N, (1/s + 1)N), "tight", which the
/// true number can exceed by less than 1 (s = 3/2, N = 8: 14 against 13.3) and never reaches at s = 1 (docs/errata.md).
pub fn pixel_coupling_bound(size: usize, map: AffineMap) -> usize {
    let ratio = map.scale().abs().min(map.scale().abs().recip());
    size.saturating_add(((size as f64 * ratio).ceil() as usize).min(size.saturating_sub(1)))
}

/// The ends b_k = (k − No)/s of the source pixels against those of the target, j = 0 … N.
#[derive(Clone, Copy)]
struct Grid {
    size: usize,
    scale: f64,
    /// No = high + low, exactly.
    offset: (f64, f64),
}

impl Grid {
    fn new(size: usize, map: AffineMap) -> Self {
        Self { size, scale: map.scale(), offset: exact_product(map.offset(), size as f64) }
    }

    /// b_k − j, in pixels: its sign is exact, its error a few ε of itself.
    fn distance(&self, k: usize, j: usize) -> f64 {
        separation(k as f64, exact_product(self.scale, j as f64), self.offset) / self.scale
    }

    /// The ends of source pixel i as the target sees them, the lower first.
    fn ends(&self, i: usize) -> [usize; 2] {
        if self.scale > 0.0 { [i, i + 1] } else { [i + 1, i] }
    }

    /// The source pixel that is number `step` along the target.
    fn pixel(&self, step: usize) -> usize {
        if self.scale > 0.0 { step } else { self.size - 1 - step }
    }

    /// |[b_i, b_{i+1}] ∩ [j, j + 1]| if it is not 0: of the four differences of an upper and a lower end, the least.
    fn overlap(&self, i: usize, j: usize) -> Option<f64> {
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

    /// The first pair that overlaps, as (step along the source, target pixel); N for one past the end if none does.
    fn start(&self) -> (usize, usize) {
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
