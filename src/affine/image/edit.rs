//! Sums and contrast: what is done term by term.

use super::wavelet_image::WaveletImage;
use crate::{Error, Real, Result};

impl<T: Real, const C: usize> WaveletImage<T, C> {
    /// The sum of two pictures of one size.
    ///
    /// Cost: the terms of both.
    ///
    /// # Errors
    /// [`Error::Length`] if a side differs.
    pub fn plus(&self, other: &Self) -> Result<Self> {
        self.combined(T::one(), other, T::one())
    }

    /// `a` times this picture and `b` times another of the same size: with weights that add up to 1 a cross-fade, with
    /// 1 and −1 a difference.
    ///
    /// # Errors
    /// [`Error::Length`] if a side differs.
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::WaveletImage;
    /// let [left, down] = [[[0.0, 1.0], [1.0, 1.0]], [[1.0, 1.0], [0.0, 1.0]]]
    ///     .map(|[f, g]| WaveletImage::<f64>::from_separable(&f, &g));
    /// let between = left?.combined(0.75, &down?, 0.25)?;
    /// assert_eq!(between.to_pixels(), [[0.0, 0.75, 0.25, 1.0]]);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn combined(&self, a: T, other: &Self, b: T) -> Result<Self> {
        self.check_size(other.size)?;
        let mut out = Self::empty(self.size);
        let (mut ours, mut theirs) = (0, 0);
        let at = |image: &Self, k: usize| image.indices.get(k).map_or(u64::MAX, |&i| u64::from(i));
        loop {
            let (i, j) = (at(self, ours), at(other, theirs));
            let next = i.min(j);
            let Ok(index) = u32::try_from(next) else { return Ok(out) };
            let mut value = [T::zero(); C];
            for c in 0..C {
                match (i == next, j == next) {
                    (true, true) => value[c] = a * self.values[ours][c] + b * other.values[theirs][c],
                    (true, false) => value[c] = a * self.values[ours][c],
                    _ => value[c] = b * other.values[theirs][c],
                }
            }
            ours += usize::from(i == next);
            theirs += usize::from(j == next);
            out.push(index, value);
        }
    }

    /// Every pixel times `gain`, then plus `bias`, each channel with its own: contrast and brightness.
    ///
    /// A gain scales all terms; a bias is added to the mean alone, and so to the whole grid: to what lies beside the
    /// frame, too.
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::WaveletImage;
    /// let image = WaveletImage::<f64>::from_separable(&[0.25, 0.75], &[1.0])?;
    /// // Twice the contrast around ½.
    /// assert_eq!(image.adjusted([2.0], [-0.5]).to_pixels(), [[0.0, 1.0]]);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn adjusted(&self, gain: [T; C], bias: [T; C]) -> Self {
        let mut out = Self::empty(self.size);
        let has_mean = self.indices.first() == Some(&0);
        if !has_mean {
            out.push(0, bias);
        }
        for (&i, value) in self.indices.iter().zip(&self.values) {
            let bias = if i == 0 { bias } else { [T::zero(); C] };
            out.push(i, std::array::from_fn(|c| gain[c] * value[c] + bias[c]));
        }
        out
    }

    pub(super) fn check_size(&self, other: [usize; 2]) -> Result<()> {
        for (what, axis) in [("width of an image", 0), ("height of an image", 1)] {
            if other[axis] != self.size[axis] {
                return Err(Error::Length { what, expected: self.size[axis], got: other[axis] });
            }
        }
        Ok(())
    }
}
