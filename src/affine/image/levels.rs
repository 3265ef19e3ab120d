//! Pictures that come level by level, coarse first.

use super::two_pass::TwoPass;
use super::wavelet_image::WaveletImage;
use super::zoom::{Zoom, ZoomScratch};
use crate::Real;

/// The terms of a picture by level, coarse first: what a server sends. Made by [`WaveletImage::levels`].
#[derive(Debug, Clone)]
pub struct ImageLevels<'a, T, const C: usize> {
    image: &'a WaveletImage<T, C>,
    next: u32,
}

/// The terms of a zoom by level, coarse first. Made by [`Zoom::levels`].
#[derive(Debug, Clone)]
pub struct ZoomLevels<T, const C: usize> {
    passes: TwoPass<T, C>,
    size: [usize; 2],
    next: u32,
}

/// How many levels a grid has, the mean counted.
fn count(grid: [usize; 2]) -> u32 {
    grid[0].max(grid[1]).ilog2() + 1
}

/// The functions of an axis that levels below the given one have, of those that there are.
fn below(level: u32, side: usize) -> usize {
    (1 << level).min(side)
}

impl<T: Real, const C: usize> WaveletImage<T, C> {
    /// The terms level by level, coarse first. Step 0 is the mean, and step l has the terms whose finer axis is at
    /// level l − 1, so that the sum of the first l + 1 steps has the detail of 2^l × 2^l pixels.
    ///
    /// Since zooms are linear, the zoom of a picture that arrives in steps is the sum of theirs
    /// ([`plus`](Self::plus)).
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::WaveletImage;
    /// use haarmonic::haar::Keep;
    /// let image = WaveletImage::from_pixels([4, 1], [&[1.0, 3.0, 4.0, 8.0]], Keep::Fraction(1.0))?;
    /// let mut sum = WaveletImage::zero([4, 1])?;
    /// let pictures = image.levels().map(|level| {
    ///     sum = sum.plus(&level)?;
    ///     Ok(sum.to_pixels())
    /// });
    /// let pictures = pictures.collect::<haarmonic::Result<Vec<_>>>()?;
    /// assert_eq!(pictures, [[[4.0, 4.0, 4.0, 4.0]], [[2.0, 2.0, 6.0, 6.0]], [[1.0, 3.0, 4.0, 8.0]]]);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn levels(&self) -> ImageLevels<'_, T, C> {
        ImageLevels { image: self, next: 0 }
    }
}

impl<T: Real, const C: usize> Iterator for ImageLevels<'_, T, C> {
    type Item = WaveletImage<T, C>;

    fn next(&mut self) -> Option<Self::Item> {
        let grid = self.image.grid();
        if self.next >= count(grid) {
            return None;
        }
        let (image, log, mask) = (self.image, grid[0].ilog2(), grid[0] as u32 - 1);
        let mut out = WaveletImage::empty(image.size);
        for (&i, &value) in image.indices.iter().zip(&image.values) {
            // The level of the finer axis: of functions 2^{l−1} to 2^l − 1 it is step l.
            let step = ((i & mask) | (i >> log)).checked_ilog2().map_or(0, |level| level + 1);
            if step == self.next {
                out.push(i, value);
            }
        }
        self.next += 1;
        Some(out)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = (count(self.image.grid()) - self.next) as usize;
        (left, Some(left))
    }
}

impl<T: Real, const C: usize> ExactSizeIterator for ImageLevels<'_, T, C> {}

impl Zoom<'_> {
    /// The zoom level by level of the result, coarse first: step 0 is the mean, and the sum of the first l + 1 steps is
    /// the zoom at 2^l × 2^l pixels, its exact area averages. Each step is computed when it is asked for; together they
    /// cost about what [`apply`](Self::apply) does by way of wavelets.
    ///
    /// All terms come; targets and route that were asked for do not count here.
    ///
    /// # Panics
    /// Unless the picture's size is the plan's.
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::{WaveletImage, ZoomWindow, Zoom};
    /// use haarmonic::haar::Keep;
    /// let image = WaveletImage::from_pixels([4, 1], [&[1.0, 3.0, 4.0, 8.0]], Keep::Fraction(1.0))?;
    /// let zoom = Zoom::new(ZoomWindow::new([0.75, 0.5], [2.0, 1.0])?, [4, 1], [4, 1])?;
    /// let steps: Vec<_> = zoom.levels(&image).collect();
    /// assert_eq!(steps.iter().map(|step| step.terms()).collect::<Vec<_>>(), [1, 1, 0]);
    /// assert_eq!(steps[0].plus(&steps[1])?, zoom.apply(&image)?);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    #[track_caller]
    pub fn levels<T: Real, const C: usize>(&self, image: &WaveletImage<T, C>) -> ZoomLevels<T, C> {
        self.check(image);
        let mut scratch = ZoomScratch::new();
        self.couple(image, &mut scratch);
        let ZoomScratch { mut passes, couplings, .. } = scratch;
        passes.set(image, &couplings, self.grid());
        ZoomLevels { passes, size: self.size, next: 0 }
    }
}

impl<T: Real, const C: usize> Iterator for ZoomLevels<T, C> {
    type Item = WaveletImage<T, C>;

    fn next(&mut self) -> Option<Self::Item> {
        let grid = self.size.map(usize::next_power_of_two);
        let level = self.next;
        if level >= count(grid) {
            return None;
        }
        self.next += 1;
        let mut out = WaveletImage::empty(self.size);
        let now = grid.map(|side| below(level, side));
        let before = if level == 0 { [0; 2] } else { grid.map(|side| below(level - 1, side)) };
        // Rows that there have been, in their new columns; then new rows, in all columns.
        self.passes.write([before[0]..now[0], 0..before[1]], None, &mut out);
        self.passes.write([0..now[0], before[1]..now[1]], None, &mut out);
        Some(out)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = (count(self.size.map(usize::next_power_of_two)) - self.next) as usize;
        (left, Some(left))
    }
}

impl<T: Real, const C: usize> ExactSizeIterator for ZoomLevels<T, C> {}
