//! Products of pictures: masks.

use super::route::ImageRoute;
use super::wavelet_image::WaveletImage;
use crate::haar::{StandardProduct, multiply_sparse_standard};
use crate::{Real, Result};

impl<T: Real, const C: usize> WaveletImage<T, C> {
    /// Pixel by pixel this picture times a mask of the same size, whose one channel meets all of them.
    ///
    /// By the pairs of their terms where those are few ([`multiply_sparse_standard`]), by way of pixels otherwise
    /// ([`StandardProduct`]): a choice by counts alone.
    ///
    /// # Errors
    /// [`Error::Length`](crate::Error::Length) if a side differs.
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::WaveletImage;
    /// use haarmonic::haar::Keep;
    /// let image = WaveletImage::from_pixels([4, 1], [&[1.0, 2.0, 3.0, 4.0]], Keep::Fraction(1.0))?;
    /// let mask = WaveletImage::from_separable(&[0.0, 1.0, 1.0, 0.5], &[1.0])?;
    /// assert_eq!(image.masked(&mask)?.to_pixels(), [[0.0, 2.0, 3.0, 2.0]]);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn masked(&self, mask: &WaveletImage<T, 1>) -> Result<Self> {
        let [across, down] = self.grid();
        // In nanoseconds of one core (Zen 5); only their ratio matters.
        let pairs = 1.5 * self.terms() as f64 * mask.terms() as f64;
        let pixels = 3.0 * (across * down) as f64;
        self.masked_by(if pairs <= pixels { ImageRoute::Wavelets } else { ImageRoute::Pixels }, mask)
    }

    /// As [`masked`](Self::masked), by a given route.
    ///
    /// # Errors
    /// As [`masked`](Self::masked).
    pub fn masked_by(&self, route: ImageRoute, mask: &WaveletImage<T, 1>) -> Result<Self> {
        self.check_size(mask.size)?;
        let [across, down] = self.grid();
        match route {
            ImageRoute::Wavelets => {
                let mask = mask.channel(0);
                let mut products: [_; C] = std::array::from_fn(|_| Default::default());
                for (c, product) in products.iter_mut().enumerate() {
                    *product = multiply_sparse_standard(&self.channel(c), &mask, across, down)?;
                }
                Self::from_sparse(self.size, products.each_ref())
            }
            ImageRoute::Pixels => {
                let plan = StandardProduct::new(across, down)?;
                let mut memory = vec![T::zero(); plan.scratch_len()];
                let mut factors = [(); 2].map(|()| vec![T::zero(); across * down]);
                mask.write_channel(0, &mut factors[1]);
                let products: [Vec<T>; C] = std::array::from_fn(|c| {
                    let mut product = vec![T::zero(); across * down];
                    self.write_channel(c, &mut factors[0]);
                    plan.apply(&factors[0], &factors[1], &mut product, &mut memory);
                    product
                });
                Ok(Self::from_dense(self.size, products.each_ref().map(Vec::as_slice)))
            }
        }
    }

    /// Another picture where the mask is 0, this one where it is 1, and between them the weighted mean: `other` + mask
    /// × (this − `other`).
    ///
    /// # Errors
    /// [`Error::Length`](crate::Error::Length) if a side differs.
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::WaveletImage;
    /// let [day, night] = [1.0, 0.25].map(|light| WaveletImage::<f64>::from_separable(&[light; 4], &[1.0]));
    /// let mask = WaveletImage::from_separable(&[1.0, 1.0, 0.5, 0.0], &[1.0])?;
    /// assert_eq!(day?.blended(&night?, &mask)?.to_pixels(), [[1.0, 1.0, 0.625, 0.25]]);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn blended(&self, other: &Self, mask: &WaveletImage<T, 1>) -> Result<Self> {
        self.combined(T::one(), other, -T::one())?.masked(mask)?.plus(other)
    }
}
