//! A window of a picture, from its terms.

use pulp::Arch;

use super::couplings::Couplings;
use super::pixels::{AxisWeights, Resample, plane_len};
use super::route::ImageRoute;
use super::two_pass::TwoPass;
use super::wavelet_image::{WaveletImage, grid_of};
use super::window::ZoomWindow;
use crate::affine::AffineMap;
use crate::affine::propagation::band::{Band, Weights};
use crate::haar::Keep;
use crate::{Error, Real, Result};

/// Which terms of a zoom are computed, or kept.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ZoomTargets<'a> {
    /// All that are not 0.
    #[default]
    All,
    /// All are computed, and those of largest magnitude kept, as [`WaveletImage::from_pixels`] chooses.
    Largest(Keep),
    /// Those of the given flat indices of the result's grid, strictly ascending, chosen before they are known; such as
    /// a [`Prediction`](crate::affine::Prediction) of [`Zoom::maps`] makes them. Nothing else is computed.
    At(&'a [u32]),
}

/// Plan of a zoom: a window of pictures of one size, at another, in the wavelet domain.
///
/// ```math
/// L(x, y) = F(s_x x + o_x, s_y y + o_y),   L_k = Σ_i F_i D_ik(s, o)               [Sun 2008, §4.6.2, eq. 4.35]
/// ```
///
/// Every term of the picture is coupled with those of the result that it meets, one axis after the other; the picture
/// is never decompressed, and memory and time grow with the terms that there are. F is 0 beyond its grid. The result is
/// the L² projection of the zoomed picture on its own pixels: exact area averages, whether it is enlarged or made
/// smaller. Projections do not chain: zoom with the composed window ([`AffineMap::then`]) instead of zooming twice,
/// unless the first window enlarges by a power of two and is [`snapped`](ZoomWindow::snapped).
///
/// Accuracy: ends are rounded by ε of their place, which a cell as narrow as a pixel sees as side · ε: up to 121 ε of
/// max |F| at sides up to 64.
/// Cost: where the terms are too many, pixels are cheaper ([`route`](Self::route)); docs/wavelet_image.md has
/// measurements.
///
/// # Example
/// ```
/// use haarmonic::affine::{WaveletImage, ZoomWindow, Zoom, ZoomTargets};
/// use haarmonic::haar::Keep;
/// let image = WaveletImage::from_pixels([2, 2], [&[0.0, 4.0, 0.0, 8.0]], Keep::Fraction(1.0))?;
/// let right_half = ZoomWindow::new([0.75, 0.5], [2.0, 1.0])?;
/// let zoom = Zoom::new(right_half, [2, 2], [2, 2])?;
/// assert_eq!(zoom.apply(&image)?.to_pixels(), [[4.0, 4.0, 8.0, 8.0]]);
/// let mean = zoom.with_targets(ZoomTargets::Largest(Keep::Terms(1))).apply(&image)?;
/// assert_eq!(mean.to_pixels(), [[6.0; 4]]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zoom<'a> {
    pub(super) from: [usize; 2],
    pub(super) size: [usize; 2],
    pub(super) maps: [AffineMap; 2],
    targets: ZoomTargets<'a>,
    route: Option<ImageRoute>,
}

/// Working memory of a [`Zoom`]; grows on first use, then is used again. One for each thread.
#[derive(Debug, Clone)]
pub struct ZoomScratch<T, const C: usize = 1> {
    pub(super) occurs: [Vec<bool>; 2],
    pub(super) couplings: [Couplings<T>; 2],
    pub(super) passes: TwoPass<T, C>,
    bands: [Band<T>; 2],
    planes: [Vec<T>; 2],
}

impl<T: Real, const C: usize> ZoomScratch<T, C> {
    /// Working memory that has not grown yet.
    pub fn new() -> Self {
        Self {
            occurs: Default::default(),
            couplings: [(); 2].map(|()| Couplings::new()),
            passes: TwoPass::new(),
            bands: [Band::new(), Band::new()],
            planes: Default::default(),
        }
    }

    /// Which functions of each axis the terms have.
    pub(super) fn set_occurs(&mut self, image: &WaveletImage<T, C>) {
        let grid = image.grid();
        for (occurs, side) in self.occurs.iter_mut().zip(grid) {
            occurs.clear();
            occurs.resize(side, false);
        }
        let (log, mask) = (grid[0].ilog2(), grid[0] as u32 - 1);
        for &i in &image.indices {
            self.occurs[0][(i & mask) as usize] = true;
            self.occurs[1][(i >> log) as usize] = true;
        }
    }

    /// What the two passes cost with the couplings that are set, in nanoseconds of one core (Zen 5); only the ratio to
    /// the cost of pixels matters.
    ///
    /// An upper bound: terms of a row that meet the same columns are counted apart.
    pub(super) fn cost(&self, image: &WaveletImage<T, C>, grid: [usize; 2]) -> f64 {
        let (log, mask, channels) = (image.grid()[0].ilog2(), image.grid()[0] as u32 - 1, C as f64);
        let [x, y] = &self.couplings;
        let entry = 0.5 + 0.3 * channels;
        let whole = 0.15 * channels * grid[0] as f64;
        let (mut passes, mut results, mut begin) = (0.0, 0, 0);
        while begin < image.indices.len() {
            let row = image.indices[begin] >> log;
            let mut met = 0;
            while begin < image.indices.len() && image.indices[begin] >> log == row {
                met += x.count((image.indices[begin] & mask) as usize);
                begin += 1;
            }
            let reached = y.count(row as usize);
            if reached > 0 {
                let (met, reached) = (met as f64, reached as f64);
                passes += entry * met + reached * whole.min(entry * met);
            }
            results += reached * met.min(grid[0]);
        }
        passes + result_cost(results.min(grid[0] * grid[1]))
    }

    /// Each channel by way of pixels: `each(c, coefficients)`.
    pub(super) fn resample(
        planes: &mut [Vec<T>; 2],
        image: &WaveletImage<T, C>,
        grid: [usize; 2],
        weights: [AxisWeights<'_, T>; 2],
        mut each: impl FnMut(usize, &[T]),
    ) {
        let (from, area) = (image.grid(), grid[0] * grid[1]);
        for plane in planes.iter_mut() {
            plane.resize(plane_len(from, grid), T::zero());
        }
        let [first, second] = planes;
        for c in 0..C {
            image.write_channel(c, &mut first[..from[0] * from[1]]);
            let (weights, planes) = (weights.clone(), [&mut first[..], &mut second[..]]);
            Arch::new().dispatch(Resample { from, to: grid, weights, planes });
            each(c, &first[..area]);
        }
    }
}

impl<T: Real, const C: usize> Default for ZoomScratch<T, C> {
    fn default() -> Self {
        Self::new()
    }
}

/// Of so many terms that are written.
pub(super) fn result_cost(terms: usize) -> f64 {
    2.5 * terms as f64
}

impl<'a> Zoom<'a> {
    /// A plan for pictures of `from` = [width, height] pixels, whose window is shown at `size` pixels.
    ///
    /// # Errors
    /// [`Error::Empty`] if a side is 0; [`Error::OutOfRange`] above a side of 32768, and where a map between the grids
    /// leaves the range of an [`AffineMap`].
    pub fn new(window: ZoomWindow, from: [usize; 2], size: [usize; 2]) -> Result<Self> {
        grid_of(from)?;
        grid_of(size)?;
        let maps = window.between(from, size)?;
        Ok(Self { from, size, maps, targets: ZoomTargets::All, route: None })
    }

    /// The same plan for other terms of the result.
    #[must_use]
    pub fn with_targets(mut self, targets: ZoomTargets<'a>) -> Self {
        self.targets = targets;
        self
    }

    /// The same plan by a given route, whatever it costs.
    #[must_use]
    pub fn with_route(mut self, route: ImageRoute) -> Self {
        self.route = Some(route);
        self
    }

    /// The maps of the axes from the grid of the result to the grid of the picture.
    #[inline]
    pub fn maps(&self) -> [AffineMap; 2] {
        self.maps
    }

    /// [width, height] of the result.
    #[inline]
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// [width, height] of the grid of the result.
    #[inline]
    pub fn grid(&self) -> [usize; 2] {
        self.size.map(usize::next_power_of_two)
    }

    /// The route that [`apply`](Self::apply) takes: the one that was asked for, or the cheaper by a fixed model of
    /// counts; the same on every machine and at every time.
    ///
    /// # Panics
    /// Unless the picture's size is the plan's.
    #[track_caller]
    pub fn route<T: Real, const C: usize>(
        &self,
        image: &WaveletImage<T, C>,
        scratch: &mut ZoomScratch<T, C>,
    ) -> ImageRoute {
        self.check(image);
        if let Some(route) = self.route {
            return route;
        }
        self.couple(image, scratch);
        self.cheaper(image, scratch)
    }

    fn cheaper<T: Real, const C: usize>(&self, image: &WaveletImage<T, C>, scratch: &ZoomScratch<T, C>) -> ImageRoute {
        let (grid, from) = (self.grid(), image.grid());
        let pixels = (from[0] * from[1] + 2 * from[0] * grid[1] + 2 * grid[0] * grid[1]) as f64;
        let pixels = 0.6 * C as f64 * pixels + result_cost(grid[0] * grid[1]);
        if scratch.cost(image, grid) <= pixels { ImageRoute::Wavelets } else { ImageRoute::Pixels }
    }

    /// The window of a picture.
    ///
    /// Allocates its memory; see [`apply_with`](Self::apply_with).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a [`Keep`] outside [0, 1], and for indices of [`ZoomTargets::At`] that do not ascend
    /// or are beyond the grid; [`Error::NotFinite`] where sums leave the range of T and terms are to be chosen.
    ///
    /// # Panics
    /// Unless the picture's size is the plan's.
    #[track_caller]
    pub fn apply<T: Real, const C: usize>(&self, image: &WaveletImage<T, C>) -> Result<WaveletImage<T, C>> {
        self.apply_with(image, &mut ZoomScratch::new())
    }

    /// As [`apply`](Self::apply), allocating nothing but the result once the scratch has grown.
    ///
    /// # Errors
    /// As [`apply`](Self::apply).
    ///
    /// # Panics
    /// As [`apply`](Self::apply).
    #[track_caller]
    pub fn apply_with<T: Real, const C: usize>(
        &self,
        image: &WaveletImage<T, C>,
        scratch: &mut ZoomScratch<T, C>,
    ) -> Result<WaveletImage<T, C>> {
        self.check(image);
        self.check_targets()?;
        if self.route != Some(ImageRoute::Pixels) {
            self.couple(image, scratch);
            if self.route.is_some() || self.cheaper(image, scratch) == ImageRoute::Wavelets {
                return self.by_wavelets(image, scratch);
            }
        }
        self.by_pixels(image, scratch)
    }

    #[track_caller]
    pub(super) fn check<T: Real, const C: usize>(&self, image: &WaveletImage<T, C>) {
        assert!(image.size == self.from, "a picture of {:?} pixels, where the plan has {:?}", image.size, self.from);
    }

    fn check_targets(&self) -> Result<()> {
        let [across, down] = self.grid();
        match self.targets {
            ZoomTargets::All => Ok(()),
            ZoomTargets::Largest(keep) => keep.check(),
            ZoomTargets::At(indices) => {
                let mut next = 0u64;
                for &i in indices {
                    if u64::from(i) < next || i as usize >= across * down {
                        let allowed = "above the index before it and below the area of the grid";
                        return Err(Error::OutOfRange { what: "index of a zoom's target", got: f64::from(i), allowed });
                    }
                    next = u64::from(i) + 1;
                }
                Ok(())
            }
        }
    }

    /// The couplings of both axes.
    pub(super) fn couple<T: Real, const C: usize>(&self, image: &WaveletImage<T, C>, scratch: &mut ZoomScratch<T, C>) {
        scratch.set_occurs(image);
        let grid = self.grid();
        for axis in 0..2 {
            scratch.couplings[axis].set_map(&scratch.occurs[axis], grid[axis].ilog2(), self.maps[axis]);
        }
    }

    /// From the couplings that are set.
    fn by_wavelets<T: Real, const C: usize>(
        &self,
        image: &WaveletImage<T, C>,
        scratch: &mut ZoomScratch<T, C>,
    ) -> Result<WaveletImage<T, C>> {
        let (grid, mut out) = (self.grid(), WaveletImage::empty(self.size));
        scratch.passes.set(image, &scratch.couplings, grid);
        let wanted = if let ZoomTargets::At(indices) = self.targets { Some(indices) } else { None };
        scratch.passes.write([0..grid[0], 0..grid[1]], wanted, &mut out);
        match self.targets {
            ZoomTargets::Largest(keep) if keep.of(grid[0] * grid[1]) < out.terms() => out.kept(keep),
            _ => Ok(out),
        }
    }

    fn by_pixels<T: Real, const C: usize>(
        &self,
        image: &WaveletImage<T, C>,
        scratch: &mut ZoomScratch<T, C>,
    ) -> Result<WaveletImage<T, C>> {
        let (from, grid) = (image.grid(), self.grid());
        let ZoomScratch { bands, planes, .. } = scratch;
        for axis in 0..2 {
            bands[axis].set(from[axis], grid[axis], self.maps[axis], Weights::Value);
        }
        let weights = bands.each_ref().map(AxisWeights::Band);
        let mut result: [Vec<T>; C] = std::array::from_fn(|_| Vec::new());
        ZoomScratch::resample(planes, image, grid, weights, |c, plane| result[c].extend_from_slice(plane));
        let planes = result.each_ref().map(Vec::as_slice);
        match self.targets {
            ZoomTargets::All => Ok(WaveletImage::from_dense(self.size, planes)),
            ZoomTargets::Largest(keep) => WaveletImage::select(self.size, planes, keep),
            ZoomTargets::At(indices) => {
                let mut out = WaveletImage::empty(self.size);
                indices.iter().for_each(|&i| out.push(i, planes.map(|plane| plane[i as usize])));
                Ok(out)
            }
        }
    }
}

impl<T: Real, const C: usize> WaveletImage<T, C> {
    /// The window of this picture at `size` = [width, height] pixels: the one-shot form of [`Zoom`].
    ///
    /// # Errors
    /// As [`Zoom::new`].
    pub fn zoom(&self, window: ZoomWindow, size: [usize; 2]) -> Result<Self> {
        Zoom::new(window, self.size, size)?.apply(self)
    }

    /// ∫∫ F(s_x x + o_x, s_y y + o_y) G(x, y) dx dy of each channel: the window of this picture, met by a picture of
    /// weights; of its terms alone, for nothing else of the zoom is computed.
    ///
    /// With a translation for a window, this is the value of a correlation at one place, and with G turned round that
    /// of a convolution, without the others: for weights that differ from place to place. By affine couplings, Σ_ik F_i
    /// G_k D_ik. Of many places, [`AffineProduct2d`](crate::affine::AffineProduct2d) costs less, which decodes F once.
    ///
    /// # Errors
    /// As [`Zoom::new`].
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::{WaveletImage, ZoomWindow};
    /// use haarmonic::haar::Keep;
    /// let image = WaveletImage::from_pixels([4, 1], [&[1.0, 2.0, 3.0, 4.0]], Keep::Fraction(1.0))?;
    /// let half = WaveletImage::from_separable(&[1.0, 0.0], &[1.0])?;
    /// // The mean of the second and the third pixel, times ½.
    /// let window = ZoomWindow::new([0.75, 0.5], [1.0, 1.0])?;
    /// assert_eq!(image.product_integral(window, &half)?, [0.5 * 2.5]);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn product_integral(&self, window: ZoomWindow, weights: &WaveletImage<T, 1>) -> Result<[f64; C]> {
        let zoom = Zoom::new(window, self.size, weights.size)?.with_targets(ZoomTargets::At(&weights.indices));
        let seen = zoom.with_route(ImageRoute::Wavelets).apply(self)?;
        let (mut sums, mut terms) = ([0.0; C], weights.indices.iter().zip(&weights.values));
        for (i, value) in seen.indices.iter().zip(&seen.values) {
            // Those that are 0 have been left out.
            let Some((_, [g])) = terms.find(|(k, _)| *k == i) else { break };
            for c in 0..C {
                sums[c] += value[c].widen() * g.widen();
            }
        }
        Ok(sums)
    }
}
