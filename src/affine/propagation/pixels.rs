//! The route through pixels: area resampling along x, then y, then the Haar transform.

use pulp::{Simd, WithSimd};

use super::band::{Band, Weights};
use crate::Real;
use crate::affine::AffineMap;
use crate::haar::{Decomposition, transform_kernels as kernels};

/// Image after image: transposed source pixels to coefficients.
pub(super) struct Resample<'a, T, const C: usize> {
    pub(super) levels: u32,
    pub(super) decomposition: Decomposition,
    pub(super) maps: [AffineMap; 2],
    pub(super) weights: [Weights; 2],
    pub(super) bands: &'a mut [Band<T>; 2],
    /// Planes of the source, pixel (x, y) at x·side + y.
    pub(super) source: &'a [T],
    pub(super) out: [&'a mut [T]; C],
    /// Two planes, and a mean pyramid.
    pub(super) scratch: (&'a mut [T], &'a mut [T]),
}

impl<T: Real, const C: usize> WithSimd for Resample<'_, T, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { levels, decomposition, maps, weights, bands, source, out, scratch: (planes, pyramid) } = self;
        let side = 1usize << levels;
        for axis in 0..2 {
            bands[axis].set(side, maps[axis], weights[axis]);
        }
        let (first, second) = planes[..2 * side * side].split_at_mut(side * side);
        for (source, out) in source.chunks_exact(side * side).zip(out) {
            bands[0].combine(side, source, first);
            if decomposition == Decomposition::Standard {
                // Along x while x is the slow axis: whole rows at a time.
                kernels::columns_forward(levels, side, first, second);
                transpose(side, second, first);
                bands[1].combine(side, first, second);
                kernels::columns_forward(levels, side, second, out);
            } else {
                transpose(side, first, second);
                bands[1].combine(side, second, first);
                kernels::nonstandard_forward(levels, first, out, pyramid);
            }
        }
    }
}

/// The transpose of one image's resampling between pixels: row-major target to row-major source.
pub(super) struct Scatter<'a, T> {
    pub(super) levels: u32,
    pub(super) maps: [AffineMap; 2],
    pub(super) bands: &'a mut [Band<T>; 2],
    pub(super) image: &'a mut [T],
    /// Two planes.
    pub(super) scratch: &'a mut [T],
}

impl<T: Real> WithSimd for Scatter<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { levels, maps, bands, image, scratch } = self;
        let side = 1usize << levels;
        for axis in 0..2 {
            bands[axis].set(side, maps[axis], Weights::Value);
        }
        let (first, second) = scratch[..2 * side * side].split_at_mut(side * side);
        bands[1].scatter(side, image, first);
        transpose(side, first, second);
        bands[0].scatter(side, second, first);
        transpose(side, first, image);
    }
}

/// dst[x][y] = src[y][x].
#[inline(always)]
pub(super) fn transpose<T: Real>(side: usize, src: &[T], dst: &mut [T]) {
    const BLOCK: usize = 8;
    if side < BLOCK {
        for y in 0..side {
            for x in 0..side {
                dst[x * side + y] = src[y * side + x];
            }
        }
        return;
    }
    for y in (0..side).step_by(BLOCK) {
        for x in (0..side).step_by(BLOCK) {
            let mut block = [[T::zero(); BLOCK]; BLOCK];
            for (k, row) in block.iter_mut().enumerate() {
                *row = src[(y + k) * side + x..].as_chunks::<BLOCK>().0[0];
            }
            let mut turned = [[T::zero(); BLOCK]; BLOCK];
            for j in 0..BLOCK {
                for k in 0..BLOCK {
                    turned[k][j] = block[j][k];
                }
            }
            for (k, row) in turned.iter().enumerate() {
                dst[(x + k) * side + y..].as_chunks_mut::<BLOCK>().0[0] = *row;
            }
        }
    }
}
