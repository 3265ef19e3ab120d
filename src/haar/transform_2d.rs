//! The 2D transforms.

use pulp::{Arch, Simd, WithSimd};

use super::transform_1d::{Direction, check_batch, take_scratch};
use super::transform_kernels as kernels;
use crate::error::check_length;
use crate::{Error, Real, Result, parallel};

/// One of the two Haar bases of two dimensions.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Decomposition {
    /// Square supports, three kinds of detail a level; flat index of [`Index2d`](crate::haar::Index2d). Square images.
    #[default]
    Nonstandard,
    /// Products of 1D functions ψ_{k_x}(x) ψ_{k_y}(y), flat index k_y·width + k_x. Any width and height 2^k.
    Standard,
}

/// Orthonormal 2D Haar transform of one size, planned once, applied many times.
/// ```math
/// c_i = ∫ f Ψ_i over [0, 1]²
/// ```
///
/// f is the function on the unit square whose value on pixel (x, y) is `samples[y·width + x]`. Coefficients do not
/// depend on the resolution; coefficient 0 is the mean; Σ c² = mean of the squared samples.
///
/// Shapes: samples row-major; coefficients in the order of [`Decomposition`].
/// Accuracy: at most (2 log2 width + 3)·ε of max |x|, each coefficient (standard: log2 width + log2 height + 4).
/// Cost: nonstandard reads and writes each pixel once and a third of them again; standard needs about thrice that.
/// The same bits on every machine, in place or not, alone or in a batch.
///
/// # Example
/// ```
/// # fn main() -> Result<(), haarmonic::Error> {
/// use haarmonic::haar::{Decomposition, Transform2d};
/// let plan = Transform2d::<f32>::new(2, 2, Decomposition::Nonstandard)?;
/// let (mut data, mut scratch) = ([7.0, 1.0, 3.0, 1.0], vec![0.0; plan.scratch_len()]);
/// plan.forward_in_place(&mut data, &mut scratch);
/// assert_eq!(data, [3.0, 2.0, 1.0, 1.0]); // mean, horizontal, vertical, diagonal
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Transform2d<T> {
    width_log: u32,
    height_log: u32,
    decomposition: Decomposition,
    arch: Arch,
    scalar: std::marker::PhantomData<T>,
}

impl<T: Real> Transform2d<T> {
    /// Plans transforms of `width` × `height` images.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless both sides are 1, 2, 4, …; [`Error::Length`] if the decomposition is nonstandard
    /// and they differ; [`Error::OutOfRange`] if an image and its scratch cannot be addressed.
    pub fn new(width: usize, height: usize, decomposition: Decomposition) -> Result<Self> {
        for (what, got) in [("image width", width), ("image height", height)] {
            if !got.is_power_of_two() {
                return Err(Error::NotPowerOfTwo { what, got });
            }
        }
        if decomposition == Decomposition::Nonstandard && width != height {
            return Err(Error::Length { what: "height of a nonstandard image", expected: width, got: height });
        }
        let (width_log, height_log) = (width.ilog2(), height.ilog2());
        if width_log + height_log + 2 >= usize::BITS {
            let got = width as f64 * height as f64;
            return Err(Error::OutOfRange { what: "image area", got, allowed: "addressable, with its scratch" });
        }
        Ok(Self { width_log, height_log, decomposition, arch: Arch::new(), scalar: std::marker::PhantomData })
    }

    /// The width of an image.
    #[inline]
    pub fn width(&self) -> usize {
        1 << self.width_log
    }

    /// The height of an image.
    #[inline]
    pub fn height(&self) -> usize {
        1 << self.height_log
    }

    /// The basis.
    #[inline]
    pub fn decomposition(&self) -> Decomposition {
        self.decomposition
    }

    /// The number of samples of an image, and of its coefficients.
    #[inline]
    #[expect(clippy::len_without_is_empty, reason = "a plan's length is never 0")]
    pub fn len(&self) -> usize {
        1 << (self.width_log + self.height_log)
    }

    /// How much scratch every method wants, at least: about an image's worth.
    #[inline]
    pub fn scratch_len(&self) -> usize {
        match self.decomposition {
            Decomposition::Nonstandard => kernels::pyramid_offset(self.width_log) + self.len() / 4 * 3,
            Decomposition::Standard => self.len() + self.width(),
        }
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

    /// [`forward`](Self::forward) of images that lie one after another.
    ///
    /// # Panics
    /// If `src.len()` is not a multiple of [`len`](Self::len), `dst.len() != src.len()`, or `scratch` is shorter than
    /// [`scratch_len`](Self::scratch_len).
    #[track_caller]
    pub fn forward_batch(&self, src: &[T], dst: &mut [T], scratch: &mut [T]) {
        self.run(Direction::Forward, Some(src), dst, scratch);
    }

    /// [`inverse`](Self::inverse) of images that lie one after another.
    ///
    /// # Panics
    /// As [`forward_batch`](Self::forward_batch).
    #[track_caller]
    pub fn inverse_batch(&self, src: &[T], dst: &mut [T], scratch: &mut [T]) {
        self.run(Direction::Inverse, Some(src), dst, scratch);
    }

    /// [`forward_in_place`](Self::forward_in_place) of images that lie one after another.
    ///
    /// # Panics
    /// If `data.len()` is not a multiple of [`len`](Self::len), or `scratch` is shorter than
    /// [`scratch_len`](Self::scratch_len).
    #[track_caller]
    pub fn forward_batch_in_place(&self, data: &mut [T], scratch: &mut [T]) {
        self.run(Direction::Forward, None, data, scratch);
    }

    /// [`inverse_in_place`](Self::inverse_in_place) of images that lie one after another.
    ///
    /// # Panics
    /// As [`forward_batch_in_place`](Self::forward_batch_in_place).
    #[track_caller]
    pub fn inverse_batch_in_place(&self, data: &mut [T], scratch: &mut [T]) {
        self.run(Direction::Inverse, None, data, scratch);
    }

    /// [`forward_batch`](Self::forward_batch) on all threads (feature `rayon`; on one without it), for big batches: it
    /// allocates scratch for each thread. The same bits as `forward_batch`.
    ///
    /// # Panics
    /// If `src.len()` is not a multiple of [`len`](Self::len), or `dst.len() != src.len()`.
    #[track_caller]
    pub fn forward_batch_parallel(&self, src: &[T], dst: &mut [T]) {
        self.run_parallel(Direction::Forward, src, dst);
    }

    /// [`inverse_batch`](Self::inverse_batch) on all threads, as
    /// [`forward_batch_parallel`](Self::forward_batch_parallel).
    ///
    /// # Panics
    /// As [`forward_batch_parallel`](Self::forward_batch_parallel).
    #[track_caller]
    pub fn inverse_batch_parallel(&self, src: &[T], dst: &mut [T]) {
        self.run_parallel(Direction::Inverse, src, dst);
    }

    #[track_caller]
    fn run(&self, direction: Direction, src: Option<&[T]>, dst: &mut [T], scratch: &mut [T]) {
        check_batch(self.len(), src, dst);
        let scratch = take_scratch(self.scratch_len(), scratch);
        self.dispatch(direction, src, dst, scratch);
    }

    #[track_caller]
    fn run_parallel(&self, direction: Direction, src: &[T], dst: &mut [T]) {
        check_batch(self.len(), Some(src), dst);
        let scratch = || vec![T::zero(); self.scratch_len()];
        // Some 64 KiB of samples a task: enough to hide its start, little enough to balance.
        let chunk = self.len() * ((1 << 14) / self.len()).max(1);
        parallel::chunks(dst, chunk, scratch, |k, dst, scratch| {
            self.dispatch(direction, Some(&src[k * chunk..][..dst.len()]), dst, scratch);
        });
    }

    fn dispatch(&self, direction: Direction, src: Option<&[T]>, dst: &mut [T], scratch: &mut [T]) {
        match self.decomposition {
            Decomposition::Nonstandard => {
                self.arch.dispatch(Nonstandard { levels: self.width_log, direction, src, dst, scratch });
            }
            Decomposition::Standard => {
                let levels = [self.width_log, self.height_log];
                self.arch.dispatch(Standard { levels, direction, src, dst, scratch });
            }
        }
    }
}

/// A batch of nonstandard transforms, in place without `src`.
struct Nonstandard<'a, T> {
    levels: u32,
    direction: Direction,
    src: Option<&'a [T]>,
    dst: &'a mut [T],
    scratch: &'a mut [T],
}

impl<T: Real> WithSimd for Nonstandard<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { levels, direction, src, dst, scratch } = self;
        let len = 1 << (2 * levels);
        let (pyramid, details) = scratch.split_at_mut(kernels::pyramid_offset(levels));
        let Some(src) = src else {
            for data in dst.chunks_exact_mut(len) {
                match direction {
                    Direction::Forward => kernels::nonstandard_forward_in_place(levels, data, pyramid, details),
                    Direction::Inverse => kernels::nonstandard_inverse_in_place(levels, data, pyramid, details),
                }
            }
            return;
        };
        for (src, dst) in src.chunks_exact(len).zip(dst.chunks_exact_mut(len)) {
            match direction {
                Direction::Forward => kernels::nonstandard_forward(levels, src, dst, pyramid),
                Direction::Inverse => kernels::nonstandard_inverse(levels, src, dst, pyramid),
            }
        }
    }
}

/// A batch of standard transforms, in place without `src`.
struct Standard<'a, T> {
    levels: [u32; 2],
    direction: Direction,
    src: Option<&'a [T]>,
    dst: &'a mut [T],
    scratch: &'a mut [T],
}

impl<T: Real> WithSimd for Standard<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { levels, direction, src, dst, scratch } = self;
        let len = 1usize << (levels[0] + levels[1]);
        let (work, means) = scratch.split_at_mut(len);
        // In place or not, the first axis goes to `work` and the second from there.
        for (i, dst) in dst.chunks_exact_mut(len).enumerate() {
            standard_first(levels, direction, src.map_or(&*dst, |src| &src[i * len..][..len]), work, means);
            standard_second(levels, direction, work, dst, means);
        }
    }
}

/// Rows forward, or columns inverse.
#[inline(always)]
fn standard_first<T: Real>(levels: [u32; 2], direction: Direction, src: &[T], work: &mut [T], means: &mut [T]) {
    let width = 1usize << levels[0];
    match direction {
        Direction::Inverse => kernels::columns_inverse(levels[1], width, src, work),
        Direction::Forward => {
            for (src, dst) in src.chunks_exact(width).zip(work.chunks_exact_mut(width)) {
                kernels::line_forward(levels[0], src, dst, means);
            }
        }
    }
}

/// Columns forward, or rows inverse.
#[inline(always)]
fn standard_second<T: Real>(levels: [u32; 2], direction: Direction, work: &mut [T], dst: &mut [T], means: &mut [T]) {
    let width = 1usize << levels[0];
    match direction {
        Direction::Forward => kernels::columns_forward(levels[1], width, work, dst),
        Direction::Inverse => {
            for (src, dst) in work.chunks_exact(width).zip(dst.chunks_exact_mut(width)) {
                kernels::line_inverse(levels[0], src, dst, means);
            }
        }
    }
}

/// Coefficients of one image; a convenience that plans and allocates, see [`Transform2d`].
///
/// # Errors
/// Those of [`Transform2d::new`]; [`Error::Length`] unless `samples.len() == width·height`.
pub fn forward_2d<T: Real>(samples: &[T], width: usize, height: usize, decomposition: Decomposition) -> Result<Vec<T>> {
    let mut data = samples.to_vec();
    let (plan, mut scratch) = plan_for(&data, width, height, decomposition)?;
    plan.forward_in_place(&mut data, &mut scratch);
    Ok(data)
}

/// Samples of one image's coefficients; a convenience that plans and allocates, see [`Transform2d`].
///
/// # Errors
/// Those of [`Transform2d::new`]; [`Error::Length`] unless `coefs.len() == width·height`.
pub fn inverse_2d<T: Real>(coefs: &[T], width: usize, height: usize, decomposition: Decomposition) -> Result<Vec<T>> {
    let mut data = coefs.to_vec();
    let (plan, mut scratch) = plan_for(&data, width, height, decomposition)?;
    plan.inverse_in_place(&mut data, &mut scratch);
    Ok(data)
}

fn plan_for<T: Real>(
    data: &[T],
    width: usize,
    height: usize,
    decomposition: Decomposition,
) -> Result<(Transform2d<T>, Vec<T>)> {
    let plan = Transform2d::new(width, height, decomposition)?;
    if data.len() != plan.len() {
        return Err(Error::Length { what: "image", expected: plan.len(), got: data.len() });
    }
    let scratch = vec![T::zero(); plan.scratch_len()];
    Ok((plan, scratch))
}
