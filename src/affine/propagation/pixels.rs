//! The route through pixels: area resampling along x, then y, then the Haar transform.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::band::{Band, Weights};
use crate::Real;
use crate::affine::AffineMap;
use crate::haar::{Decomposition, transform_kernels as kernels};

/// Image after image: transposed source pixels to coefficients.
pub(super) struct Resample<'a, T, const C: usize> {
    /// Of the source and of the target.
    pub(super) sides: [usize; 2],
    pub(super) decomposition: Decomposition,
    pub(super) maps: [AffineMap; 2],
    pub(super) weights: [Weights; 2],
    pub(super) bands: &'a mut [Band<T>; 2],
    /// Planes of the source, pixel (x, y) at x times its side + y.
    pub(super) source: &'a [T],
    pub(super) out: [&'a mut [T]; C],
    /// Two planes of the larger side, and a mean pyramid of the target.
    pub(super) scratch: (&'a mut [T], &'a mut [T]),
}

impl<T: Real, const C: usize> WithSimd for Resample<'_, T, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { sides: [from, side], decomposition, maps, weights, bands, source, out, scratch } = self;
        let (planes, pyramid) = scratch;
        let (levels, half, area) = (side.ilog2(), side * from, side * side);
        for axis in 0..2 {
            bands[axis].set(from, side, maps[axis], weights[axis]);
        }
        let (first, second) = planes.split_at_mut(planes.len() / 2);
        for (source, out) in source.chunks_exact(from * from).zip(out) {
            bands[0].combine(from, source, &mut first[..half]);
            if decomposition == Decomposition::Standard {
                // Along x while x is the slow axis: whole rows at a time.
                kernels::columns_forward(levels, from, &mut first[..half], &mut second[..half]);
                transpose([side, from], &second[..half], &mut first[..half]);
                bands[1].combine(side, &first[..half], &mut second[..area]);
                kernels::columns_forward(levels, side, &mut second[..area], out);
            } else {
                transpose([side, from], &first[..half], &mut second[..half]);
                bands[1].combine(side, &second[..half], &mut first[..area]);
                kernels::nonstandard_forward(levels, &first[..area], out, pyramid);
            }
        }
    }
}

/// The transpose of one image's resampling between pixels: row-major target to row-major source.
pub(super) struct Scatter<'a, T> {
    /// Of the source and of the target.
    pub(super) sides: [usize; 2],
    pub(super) maps: [AffineMap; 2],
    pub(super) bands: &'a mut [Band<T>; 2],
    pub(super) out: &'a mut [T],
    /// Two planes of the larger side, the first of which begins with the target.
    pub(super) planes: [&'a mut [T]; 2],
}

impl<T: Real> WithSimd for Scatter<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { sides: [from, side], maps, bands, out, planes: [first, second] } = self;
        let half = side * from;
        for axis in 0..2 {
            bands[axis].set(from, side, maps[axis], Weights::Value);
        }
        bands[1].scatter(0..from, 0..side, side, first, &mut second[..half]);
        transpose([from, side], &second[..half], &mut first[..half]);
        bands[0].scatter(0..from, 0..from, from, &first[..half], &mut second[..from * from]);
        transpose([from, from], &second[..from * from], out);
    }
}

/// dst[x][y] = src[y][x], for y < height and x < width, powers of two.
#[inline(always)]
pub(in crate::affine) fn transpose<T: Real>([height, width]: [usize; 2], src: &[T], dst: &mut [T]) {
    transpose_part([0..height, 0..width], [width, height], src, dst);
}

/// dst[x][y] = src[y][x] for the rows y and columns x of a part, whose ends are multiples of a block's or of a smaller
/// side; rows of src are `pitch[0]` long, those of dst `pitch[1]`.
#[inline(always)]
pub(super) fn transpose_part<T: Real>([rows, columns]: [Range<usize>; 2], pitch: [usize; 2], src: &[T], dst: &mut [T]) {
    const BLOCK: usize = 8;
    if rows.len().min(columns.len()) < BLOCK {
        for y in rows {
            for x in columns.clone() {
                dst[x * pitch[1] + y] = src[y * pitch[0] + x];
            }
        }
        return;
    }
    for y in rows.step_by(BLOCK) {
        for x in columns.clone().step_by(BLOCK) {
            let mut block = [[T::zero(); BLOCK]; BLOCK];
            for (k, row) in block.iter_mut().enumerate() {
                *row = src[(y + k) * pitch[0] + x..].as_chunks::<BLOCK>().0[0];
            }
            let mut turned = [[T::zero(); BLOCK]; BLOCK];
            for j in 0..BLOCK {
                for k in 0..BLOCK {
                    turned[k][j] = block[j][k];
                }
            }
            for (k, row) in turned.iter().enumerate() {
                dst[(x + k) * pitch[1] + y..].as_chunks_mut::<BLOCK>().0[0] = *row;
            }
        }
    }
}
