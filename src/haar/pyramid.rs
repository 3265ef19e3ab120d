//! Mean pyramids.

use pulp::{Arch, Simd, WithSimd};

use super::transform_kernels as kernels;
use crate::approx_eq::approx_by_parts;
use crate::{Error, Real, Result};

/// The mean of an image over every node of its quadtree, from the whole (level 0) to the pixels (level log2 size).
///
/// Shapes: level l holds 2^l × 2^l means, row-major; levels lie one after another, so that node (x, y) of level l is at
/// (4^l − 1)/3 + y·2^l + x. A node's children are (2x, 2y) … (2x + 1, 2y + 1) of level l + 1.
/// Cost: a third more memory than the pixels; time of one transform.
///
/// # Example
/// ```
/// # fn main() -> Result<(), haarmonic::Error> {
/// let pyramid = haarmonic::haar::Pyramid::from_pixels(2, &[1.0, 2.0, 3.0, 6.0])?;
/// assert_eq!(pyramid.values(), [3.0, 1.0, 2.0, 3.0, 6.0]);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Pyramid<T> {
    levels: u32,
    values: Vec<T>,
}

impl<T: Real> Pyramid<T> {
    /// The largest size that is allowed.
    pub const MAX_SIZE: usize = 1 << 15;

    /// A pyramid of zeros over `size` × `size` pixels.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `size` is 1, 2, 4, …; [`Error::OutOfRange`] above [`MAX_SIZE`](Self::MAX_SIZE).
    pub fn new(size: usize) -> Result<Self> {
        let levels = Self::levels_of(size)?;
        Ok(Self { levels, values: vec![T::zero(); kernels::pyramid_offset(levels + 1)] })
    }

    fn levels_of(size: usize) -> Result<u32> {
        if !size.is_power_of_two() {
            return Err(Error::NotPowerOfTwo { what: "pyramid size", got: size });
        }
        if size > Self::MAX_SIZE {
            return Err(Error::OutOfRange { what: "pyramid size", got: size as f64, allowed: "at most 32768" });
        }
        Ok(size.ilog2())
    }

    /// The pyramid of row-major pixels.
    ///
    /// # Errors
    /// Those of [`new`](Self::new); [`Error::Length`] unless there are size² pixels.
    pub fn from_pixels(size: usize, pixels: &[T]) -> Result<Self> {
        Self::check("pixels", size, pixels)?;
        let mut pyramid = Self::new(size)?;
        pyramid.set_pixels(pixels);
        Ok(pyramid)
    }

    /// The pyramid of an image given by its nonstandard coefficients, in the order of
    /// [`Index2d`](crate::haar::Index2d).
    ///
    /// # Errors
    /// Those of [`new`](Self::new); [`Error::Length`] unless there are size² coefficients.
    pub fn from_coefficients(size: usize, coefs: &[T]) -> Result<Self> {
        Self::check("coefficients", size, coefs)?;
        let mut pyramid = Self::new(size)?;
        pyramid.set_coefficients(coefs);
        Ok(pyramid)
    }

    /// Checks a length before anything of the size is allocated.
    fn check(what: &'static str, size: usize, slice: &[T]) -> Result<()> {
        Self::levels_of(size)?;
        let expected = size * size;
        if slice.len() == expected { Ok(()) } else { Err(Error::Length { what, expected, got: slice.len() }) }
    }

    /// Refills the pyramid from pixels, without allocating.
    ///
    /// # Panics
    /// If `pixels.len()` is not size².
    #[track_caller]
    pub fn set_pixels(&mut self, pixels: &[T]) {
        crate::error::check_length("pixels", self.size() * self.size(), pixels.len());
        let finest = kernels::pyramid_offset(self.levels);
        self.values[finest..].copy_from_slice(pixels);
        Arch::new().dispatch(FromPixels { levels: self.levels, values: &mut self.values });
    }

    /// Refills the pyramid from nonstandard coefficients, without allocating.
    ///
    /// # Panics
    /// If `coefs.len()` is not size².
    #[track_caller]
    pub fn set_coefficients(&mut self, coefs: &[T]) {
        crate::error::check_length("coefficients", self.size() * self.size(), coefs.len());
        Arch::new().dispatch(FromCoefficients { levels: self.levels, coefs, values: &mut self.values });
    }

    /// The side of the image.
    #[inline]
    pub fn size(&self) -> usize {
        1 << self.levels
    }

    /// log2 of the side: the level of the pixels.
    #[inline]
    pub fn finest(&self) -> u32 {
        self.levels
    }

    /// Where a level starts in [`values`](Self::values): (4^level − 1)/3.
    #[inline]
    pub const fn offset(level: u32) -> usize {
        kernels::pyramid_offset(level)
    }

    /// All means, level after level.
    #[inline]
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// The means of one level, row-major, 2^level a side.
    ///
    /// # Panics
    /// If `level` is above [`finest`](Self::finest).
    #[inline]
    #[track_caller]
    pub fn level(&self, level: u32) -> &[T] {
        assert!(level <= self.levels, "pyramid level {level} is above the finest, {}", self.levels);
        &self.values[Self::offset(level)..Self::offset(level + 1)]
    }

    /// The mean over node (x, y) of a level.
    ///
    /// # Panics
    /// If `level` is above [`finest`](Self::finest), or x or y is not below 2^level.
    #[inline]
    #[track_caller]
    pub fn at(&self, level: u32, x: usize, y: usize) -> T {
        assert!(x >> level == 0 && y >> level == 0, "node ({x}, {y}) is outside pyramid level {level}");
        self.level(level)[(y << level) + x]
    }
}

approx_by_parts!([T] Pyramid<T>, T, |p| close [&p.values] same []);

struct FromPixels<'a, T> {
    levels: u32,
    values: &'a mut [T],
}

impl<T: Real> WithSimd for FromPixels<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        kernels::mean_pyramid(self.levels, self.values);
    }
}

struct FromCoefficients<'a, T> {
    levels: u32,
    coefs: &'a [T],
    values: &'a mut [T],
}

impl<T: Real> WithSimd for FromCoefficients<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let (coarse, pixels) = self.values.split_at_mut(kernels::pyramid_offset(self.levels));
        kernels::nonstandard_inverse(self.levels, self.coefs, pixels, coarse);
    }
}
