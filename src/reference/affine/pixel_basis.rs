//! Affine couplings and triplings of the pixel basis, to compare those of Haar wavelets with.

use crate::affine::AffineMap;
use crate::affine::pixel::Grid;
pub use crate::affine::pixel::pixel_coupling_slope;

/// Affine coupling of two functions Φ_k = √N · 1 on [k/N, (k + 1)/N) of the orthonormal pixel basis.
///
/// ```math
/// D_ij(s, o) = ∫ Φ_i(sv + o) Φ_j(v) dv = |[b_i, b_{i+1}] ∩ [j, j + 1]|,    b_k = (k − No)/s       [Sun 2008, §4.4.1]
/// ```
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
/// use haarmonic::affine::AffineMap;
/// use haarmonic::reference::affine::pixel_basis::pixel_coupling;
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
/// ```math
/// D_ijk = ∫ Φ_i(sv + o) Φ_j(v) Φ_k(v) dv = √N δ_jk D_ij
/// ```
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

/// [∂D/∂s, ∂D/∂o] of [`pixel_coupling`], each the right-hand derivative at a kink; other directions:
/// [`pixel_coupling_slope`].
///
/// # Panics
/// If i or j is not below `size`.
///
/// # Example
/// ```
/// use haarmonic::affine::AffineMap;
/// use haarmonic::reference::affine::pixel_basis::pixel_coupling_gradient;
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
/// use haarmonic::affine::AffineMap;
/// use haarmonic::reference::affine::pixel_basis::pixel_coupling_nonzeros;
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
/// ```math
/// N + min(⌈N·min(|s|, 1/|s|)⌉, N − 1)
/// ```
///
/// The pieces between all pixel ends of source and target inside what they have in common: an open interval of length w
/// holds at most ⌈w⌉ ends of a grid of step 1. [Sun 2008, §4.4.1] has min((s + 1)N, (1/s + 1)N), "tight", which the
/// true number can exceed by less than 1 (s = 3/2, N = 8: 14 against 13.3) and never reaches at s = 1 (docs/errata.md).
pub fn pixel_coupling_bound(size: usize, map: AffineMap) -> usize {
    let ratio = map.scale().abs().min(map.scale().abs().recip());
    size.saturating_add(((size as f64 * ratio).ceil() as usize).min(size.saturating_sub(1)))
}
