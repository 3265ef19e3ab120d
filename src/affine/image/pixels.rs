//! The same operators on pixels: decompression, weights, transform, one axis after the other.

use pulp::{Simd, WithSimd};

use super::kernel::Kernel;
use crate::Real;
use crate::affine::propagation::band::Band;
use crate::affine::propagation::pixels::transpose;
use crate::haar::transform_kernels as kernels;

/// What is done to the pixels of one axis.
#[derive(Debug, Clone)]
pub(super) enum AxisWeights<'a, T> {
    /// Area resampling.
    Band(&'a Band<T>),
    /// A convolution.
    Kernel(&'a Kernel),
}

impl<T: Real> AxisWeights<'_, T> {
    /// Rows of `width`: as many target rows as `dst` has room for.
    #[inline(always)]
    fn apply(&self, width: usize, src: &[T], dst: &mut [T]) {
        match self {
            Self::Band(band) => band.combine(width, src, dst),
            Self::Kernel(kernel) => {
                let rows = src.len() / width;
                for (p, out) in dst.chunks_exact_mut(width).enumerate() {
                    out.fill(T::zero());
                    for (m, tap) in kernel.iter() {
                        let Some(from) = (p as i64 - m).try_into().ok().filter(|&from: &usize| from < rows) else {
                            continue;
                        };
                        let tap = T::of(tap);
                        for (out, &x) in out.iter_mut().zip(&src[from * width..][..width]) {
                            *out += tap * x;
                        }
                    }
                }
            }
        }
    }
}

/// One channel: coefficients of the grid `from` to those of the grid `to`.
///
/// `planes[0]` begins with the source and ends with the result; both have room for the largest of the images between.
pub(super) struct Resample<'a, T> {
    pub(super) from: [usize; 2],
    pub(super) to: [usize; 2],
    pub(super) weights: [AxisWeights<'a, T>; 2],
    pub(super) planes: [&'a mut [T]; 2],
}

/// The room that each plane of [`Resample`] needs.
pub(super) fn plane_len(from: [usize; 2], to: [usize; 2]) -> usize {
    from[0].max(to[0]) * from[1].max(to[1])
}

impl<T: Real> WithSimd for Resample<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { from, to, weights: [x, y], planes: [first, second] } = self;
        // Along y, where whole rows are added, then along x with the image lying on its side.
        axis(from[1], to[1], from[0], &y, first, second);
        let half = from[0] * to[1];
        transpose([to[1], from[0]], &second[..half], &mut first[..half]);
        axis(from[0], to[0], to[1], &x, first, second);
        let area = to[0] * to[1];
        transpose([to[0], to[1]], &second[..area], &mut first[..area]);
    }
}

/// The slow axis of an image, coefficients to coefficients, from `data` (destroyed) to `out`.
#[inline(always)]
fn axis<T: Real>(from: usize, to: usize, width: usize, weights: &AxisWeights<'_, T>, data: &mut [T], out: &mut [T]) {
    let (source, target) = (from * width, to * width);
    kernels::columns_inverse(from.ilog2(), width, &data[..source], &mut out[..source]);
    weights.apply(width, &out[..source], &mut data[..target]);
    kernels::columns_forward(to.ilog2(), width, &mut data[..target], &mut out[..target]);
}
