//! The 1D transform.

use pulp::{Arch, Simd, WithSimd};

use super::transform_kernels as kernels;
use crate::error::check_length;
use crate::{Error, Real, Result};

/// The direction of a transform.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    /// Samples → coefficients.
    Forward,
    /// Coefficients → samples.
    Inverse,
}

/// Orthonormal 1D Haar transform of one length, planned once, applied many times.
/// ```math
/// c_0 = mean x,  c_{2^l + t} = ∫ f ψ_{l,t} = 2^{−l/2} (mean of the left half − mean of the right half)/2
/// ```
///
/// f is the function on [0, 1] whose value on [k/N, (k + 1)/N) is x_k. Because the inner product is that of the unit
/// interval, coefficients do not depend on the resolution, and Σ c² = mean x².
/// [`to_pywavelets_1d`](crate::haar::to_pywavelets_1d) leads to the convention of inner products of samples.
///
/// Shapes: samples and coefficients are `len` long, coefficient order of [`Index1d`](crate::haar::Index1d).
/// Accuracy: at most (log2 len + 2)·ε of max |x|, each coefficient.  Cost: 2·len multiplications and as many additions.
/// The same bits on every machine.
///
/// # Example
/// ```
/// # fn main() -> Result<(), haarmonic::Error> {
/// let plan = haarmonic::haar::Transform1d::<f64>::new(4)?;
/// let (mut coefs, mut scratch) = ([5.0, 3.0, 1.0, -1.0], vec![0.0; plan.scratch_len()]);
/// plan.forward_in_place(&mut coefs, &mut scratch);
/// assert_eq!(coefs[..2], [2.0, 2.0]);
/// assert!((coefs[2] - 0.5_f64.sqrt()).abs() < 1e-15);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Transform1d<T> {
    levels: u32,
    arch: Arch,
    scalar: std::marker::PhantomData<T>,
}

impl<T: Real> Transform1d<T> {
    /// Plans transforms of `len` samples.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `len` is 1, 2, 4, …
    pub fn new(len: usize) -> Result<Self> {
        if !len.is_power_of_two() {
            return Err(Error::NotPowerOfTwo { what: "signal length", got: len });
        }
        Ok(Self { levels: len.ilog2(), arch: Arch::new(), scalar: std::marker::PhantomData })
    }

    /// The number of samples.
    #[inline]
    #[expect(clippy::len_without_is_empty, reason = "a plan's length is never 0")]
    pub fn len(&self) -> usize {
        1 << self.levels
    }

    /// How much scratch every method wants, at least.
    #[inline]
    pub fn scratch_len(&self) -> usize {
        if self.levels == 0 { 0 } else { self.len() - 1 + self.len() / 2 }
    }

    /// Samples `src` → coefficients `dst`.
    ///
    /// # Panics
    /// If `src.len()` or `dst.len()` is not [`len`](Self::len), or `scratch` is shorter than
    /// [`scratch_len`](Self::scratch_len).
    #[track_caller]
    pub fn forward(&self, src: &[T], dst: &mut [T], scratch: &mut [T]) {
        check_length("samples", self.len(), src.len());
        self.forward_batch(src, dst, scratch);
    }

    /// Coefficients `src` → samples `dst`.
    ///
    /// # Panics
    /// As [`forward`](Self::forward).
    #[track_caller]
    pub fn inverse(&self, src: &[T], dst: &mut [T], scratch: &mut [T]) {
        check_length("coefficients", self.len(), src.len());
        self.inverse_batch(src, dst, scratch);
    }

    /// Replaces samples by coefficients.
    ///
    /// # Panics
    /// If `data.len()` is not [`len`](Self::len), or `scratch` is shorter than [`scratch_len`](Self::scratch_len).
    #[track_caller]
    pub fn forward_in_place(&self, data: &mut [T], scratch: &mut [T]) {
        check_length("samples", self.len(), data.len());
        self.forward_batch_in_place(data, scratch);
    }

    /// Replaces coefficients by samples.
    ///
    /// # Panics
    /// As [`forward_in_place`](Self::forward_in_place).
    #[track_caller]
    pub fn inverse_in_place(&self, data: &mut [T], scratch: &mut [T]) {
        check_length("coefficients", self.len(), data.len());
        self.inverse_batch_in_place(data, scratch);
    }

    /// [`forward`](Self::forward) of signals that lie one after another.
    ///
    /// # Panics
    /// If `src.len()` is not a multiple of [`len`](Self::len), `dst.len() != src.len()`, or `scratch` is shorter than
    /// [`scratch_len`](Self::scratch_len).
    #[track_caller]
    pub fn forward_batch(&self, src: &[T], dst: &mut [T], scratch: &mut [T]) {
        self.run(Direction::Forward, Some(src), dst, scratch);
    }

    /// [`inverse`](Self::inverse) of signals that lie one after another.
    ///
    /// # Panics
    /// As [`forward_batch`](Self::forward_batch).
    #[track_caller]
    pub fn inverse_batch(&self, src: &[T], dst: &mut [T], scratch: &mut [T]) {
        self.run(Direction::Inverse, Some(src), dst, scratch);
    }

    /// [`forward_in_place`](Self::forward_in_place) of signals that lie one after another.
    ///
    /// # Panics
    /// If `data.len()` is not a multiple of [`len`](Self::len), or `scratch` is shorter than
    /// [`scratch_len`](Self::scratch_len).
    #[track_caller]
    pub fn forward_batch_in_place(&self, data: &mut [T], scratch: &mut [T]) {
        self.run(Direction::Forward, None, data, scratch);
    }

    /// [`inverse_in_place`](Self::inverse_in_place) of signals that lie one after another.
    ///
    /// # Panics
    /// As [`forward_batch_in_place`](Self::forward_batch_in_place).
    #[track_caller]
    pub fn inverse_batch_in_place(&self, data: &mut [T], scratch: &mut [T]) {
        self.run(Direction::Inverse, None, data, scratch);
    }

    #[track_caller]
    fn run(&self, direction: Direction, src: Option<&[T]>, dst: &mut [T], scratch: &mut [T]) {
        check_batch(self.len(), src, dst);
        let scratch = take_scratch(self.scratch_len(), scratch);
        self.arch.dispatch(Lines { levels: self.levels, direction, src, dst, scratch });
    }
}

/// Checks the lengths of a batch.
#[track_caller]
pub(super) fn check_batch<T>(len: usize, src: Option<&[T]>, dst: &[T]) {
    if let Some(src) = src {
        check_length("output", src.len(), dst.len());
    }
    check_length("batch, in whole signals,", dst.len() / len * len, dst.len());
}

/// The first `len` elements of the caller's scratch.
#[track_caller]
pub(super) fn take_scratch<T>(len: usize, scratch: &mut [T]) -> &mut [T] {
    if scratch.len() < len {
        crate::error::length_mismatch("scratch (at least)", len, scratch.len());
    }
    &mut scratch[..len]
}

/// A batch of 1D transforms, in place without `src`.
struct Lines<'a, T> {
    levels: u32,
    direction: Direction,
    src: Option<&'a [T]>,
    dst: &'a mut [T],
    scratch: &'a mut [T],
}

impl<T: Real> WithSimd for Lines<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { levels, direction, src, dst, scratch } = self;
        let len = 1 << levels;
        let (means, details) = scratch.split_at_mut(if levels == 0 { 0 } else { len - 1 });
        let Some(src) = src else {
            for data in dst.chunks_exact_mut(len) {
                match direction {
                    Direction::Forward => kernels::line_forward_in_place(levels, data, means, details),
                    Direction::Inverse => kernels::line_inverse_in_place(levels, data, means, details),
                }
            }
            return;
        };
        for (src, dst) in src.chunks_exact(len).zip(dst.chunks_exact_mut(len)) {
            match direction {
                Direction::Forward => kernels::line_forward(levels, src, dst, means),
                Direction::Inverse => kernels::line_inverse(levels, src, dst, means),
            }
        }
    }
}

/// Coefficients of one signal; a convenience that plans and allocates, see [`Transform1d`].
///
/// # Errors
/// [`Error::NotPowerOfTwo`] unless `samples.len()` is 1, 2, 4, …
pub fn forward_1d<T: Real>(samples: &[T]) -> Result<Vec<T>> {
    let plan = Transform1d::new(samples.len())?;
    let (mut coefs, mut scratch) = (vec![T::zero(); samples.len()], vec![T::zero(); plan.scratch_len()]);
    plan.forward(samples, &mut coefs, &mut scratch);
    Ok(coefs)
}

/// Samples of one coefficient vector; a convenience that plans and allocates, see [`Transform1d`].
///
/// # Errors
/// [`Error::NotPowerOfTwo`] unless `coefs.len()` is 1, 2, 4, …
pub fn inverse_1d<T: Real>(coefs: &[T]) -> Result<Vec<T>> {
    let plan = Transform1d::new(coefs.len())?;
    let (mut samples, mut scratch) = (vec![T::zero(); coefs.len()], vec![T::zero(); plan.scratch_len()]);
    plan.inverse(coefs, &mut samples, &mut scratch);
    Ok(samples)
}
