//! Convolution as a sum of translations.

use super::kernel::Kernel;
use super::pixels::AxisWeights;
use super::route::ImageRoute;
use super::wavelet_image::WaveletImage;
use super::zoom::{ZoomScratch, result_cost};
use crate::Real;

impl<T: Real, const C: usize> WaveletImage<T, C> {
    /// The convolution with a kernel along x and one along y, in the wavelet domain:
    ///
    /// ```math
    /// (F ∗ g)_k = Σ_i F_i Σ_m t_m D_ik(1, −m/N)
    /// ```
    ///
    /// along each axis: translations are affine maps with s = 1, and their weighted sum is one sparse operator, made
    /// once for all terms. It is exact, the L² projection of the continuous convolution (see [`Kernel`]). The picture
    /// is 0 beyond its grid, so that borders darken; what goes beyond the grid is lost.
    ///
    /// Cost: an axis' operator is made of taps × functions; then as a zoom, with about as many couplings a function as
    /// the kernel is long and levels there are. Where the terms are too many for that, the taps are applied to pixels.
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::{Kernel, WaveletImage};
    /// use haarmonic::haar::Keep;
    /// let image = WaveletImage::from_pixels([4, 1], [&[0.0, 8.0, 0.0, 4.0]], Keep::Fraction(1.0))?;
    /// let blur = Kernel::from_taps(-1, &[0.25, 0.5, 0.25])?;
    /// assert_eq!(image.convolve([&blur, &Kernel::identity()]).to_pixels(), [[2.0, 4.0, 3.0, 2.0]]);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn convolve(&self, kernels: [&Kernel; 2]) -> Self {
        let mut scratch = self.couple(kernels);
        let grid = self.grid();
        let taps: usize = kernels.iter().map(|kernel| kernel.taps().len()).sum();
        // As the estimate of the passes: in nanoseconds.
        let pixels = (grid[0] * grid[1] * C) as f64 * (2.5 + 0.1 * taps as f64) + result_cost(grid[0] * grid[1]);
        if scratch.cost(self, grid) <= pixels {
            self.convolve_wavelets(&mut scratch)
        } else {
            self.convolve_pixels(kernels)
        }
    }

    /// As [`convolve`](Self::convolve), by a given route.
    pub fn convolve_by(&self, route: ImageRoute, kernels: [&Kernel; 2]) -> Self {
        match route {
            ImageRoute::Wavelets => self.convolve_wavelets(&mut self.couple(kernels)),
            ImageRoute::Pixels => self.convolve_pixels(kernels),
        }
    }

    fn couple(&self, kernels: [&Kernel; 2]) -> ZoomScratch<T, C> {
        let mut scratch = ZoomScratch::new();
        scratch.set_occurs(self);
        for axis in 0..2 {
            scratch.couplings[axis].set_kernel(&scratch.occurs[axis], kernels[axis]);
        }
        scratch
    }

    fn convolve_wavelets(&self, scratch: &mut ZoomScratch<T, C>) -> Self {
        let (grid, mut out) = (self.grid(), Self::empty(self.size));
        scratch.passes.set(self, &scratch.couplings, grid);
        scratch.passes.write([0..grid[0], 0..grid[1]], None, &mut out);
        out
    }

    fn convolve_pixels(&self, kernels: [&Kernel; 2]) -> Self {
        let mut result: [Vec<T>; C] = std::array::from_fn(|_| Vec::new());
        let mut planes = Default::default();
        let weights = kernels.map(AxisWeights::Kernel);
        ZoomScratch::resample(&mut planes, self, self.grid(), weights, |c, plane| result[c].extend_from_slice(plane));
        Self::from_dense(self.size, result.each_ref().map(Vec::as_slice))
    }
}
