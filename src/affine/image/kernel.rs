//! Kernels of one axis, as weights of translations by whole pixels.

use crate::{Error, Result};

/// A kernel of one axis for [`WaveletImage::convolve`](super::WaveletImage::convolve): what a convolution with it does
/// to a signal that is constant on each pixel.
///
/// A convolution adds translations, (f ∗ g)(x) = ∫ g(y) f(x − y) dy. For f constant on pixels of width h the mean of
/// f ∗ g over a pixel is a sum over whole pixels alone, whatever g:
///
/// ```math
/// (f ∗ g)_p = Σ_m t_m f_{p−m},   t_m = ∫ g(y) max(0, 1 − |y/h − m|) dy
/// ```
///
/// since a pixel that is moved by y has the overlap max(0, 1 − |y/h − m|) with the pixel m places on. The *taps* t_m
/// are all that is kept of g, and nothing is lost by that: the result is the exact L² projection of f ∗ g. Translations
/// by whole pixels chain, and so do the taps ([`then`](Self::then)).
///
/// Weights are the caller's: nothing is normalised but where a constructor says so.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(try_from = "Unchecked"))]
#[derive(Debug, Clone, PartialEq)]
pub struct Kernel {
    first: i64,
    taps: Vec<f64>,
}

/// What a stored kernel says of itself.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Unchecked {
    first: i64,
    taps: Vec<f64>,
}

#[cfg(feature = "serde")]
impl TryFrom<Unchecked> for Kernel {
    type Error = Error;

    fn try_from(kernel: Unchecked) -> Result<Self> {
        Self::from_taps(kernel.first, &kernel.taps)
    }
}

/// The farthest tap: a translation farther than the largest picture leaves nothing of it.
const FARTHEST: usize = 1 << 16;

impl Kernel {
    /// The kernel that does nothing.
    pub fn identity() -> Self {
        Self { first: 0, taps: vec![1.0] }
    }

    /// The kernel of given taps: t_m for m = `first`, `first` + 1, …; what is at pixel p goes to pixel p + m.
    ///
    /// # Errors
    /// [`Error::Empty`] without taps; [`Error::OutOfRange`] for a first or last m beyond ±65536; [`Error::NotFinite`]
    /// for a tap that is not.
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::{Kernel, WaveletImage};
    /// use haarmonic::haar::Keep;
    /// let image = WaveletImage::<f64>::from_pixels([4, 1], [&[0.0, 8.0, 0.0, 0.0]], Keep::Fraction(1.0))?;
    /// let right = Kernel::from_taps(1, &[1.0])?; // moves to the right
    /// let [moved] = image.convolve([&right, &Kernel::identity()]).to_pixels();
    /// assert!(moved.iter().zip([0.0, 0.0, 8.0, 0.0]).all(|(got, want)| (got - want).abs() < 1e-14), "{moved:?}");
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn from_taps(first: i64, taps: &[f64]) -> Result<Self> {
        if taps.is_empty() {
            return Err(Error::Empty { what: "taps of a kernel" });
        }
        for end in [first, first.saturating_add(taps.len() as i64 - 1)] {
            if end.unsigned_abs() > FARTHEST as u64 {
                let allowed = "at most 65536 pixels away";
                return Err(Error::OutOfRange { what: "place of a kernel's tap", got: end as f64, allowed });
            }
        }
        match taps.iter().position(|tap| !tap.is_finite()) {
            Some(index) => Err(Error::NotFinite { what: "tap of a kernel", index }),
            None => Ok(Self { first, taps: taps.to_vec() }),
        }
    }

    /// The kernel that is constant on cells of a pixel's width: g = `cells[k]` between `first` + k and `first` + k + 1
    /// pixels.
    ///
    /// Each cell is half at either of its ends: t_m = ½ (g_{m−1} + g_m).
    ///
    /// # Errors
    /// As [`from_taps`](Self::from_taps).
    pub fn from_cells(first: i64, cells: &[f64]) -> Result<Self> {
        if cells.is_empty() {
            return Err(Error::Empty { what: "cells of a kernel" });
        }
        let cell = |k: usize| cells.get(k).copied().unwrap_or(0.0);
        let taps: Vec<f64> =
            (0..=cells.len()).map(|m| 0.5 * cell(m) + if m > 0 { 0.5 * cell(m - 1) } else { 0.0 }).collect();
        Self::from_taps(first, &taps)
    }

    /// A translation by any number of pixels, to the right and down where it is positive.
    ///
    /// Between two pixels it is a sum of the two: what the projection leaves of it.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless it is within ±65535.
    pub fn translation(pixels: f64) -> Result<Self> {
        check_width("translation in pixels", pixels.abs(), FARTHEST as f64 - 1.0)?;
        let (whole, part) = (pixels.floor(), pixels - pixels.floor());
        Self::from_taps(whole as i64, &[1.0 - part, part][..if part == 0.0 { 1 } else { 2 }])
    }

    /// The mean over `width` pixels around each point: a box of weight 1.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the width is positive and at most 65535.
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::Kernel;
    /// assert_eq!(Kernel::boxed(3.0)?.taps(), [0.125, 0.875, 1.0, 0.875, 0.125].map(|tap| tap / 3.0));
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn boxed(width: f64) -> Result<Self> {
        check_width("width of a box", width, FARTHEST as f64 - 1.0)?;
        if !(width > 0.0) {
            return Err(Error::OutOfRange { what: "width of a box", got: width, allowed: "positive" });
        }
        if width <= 2.0 {
            return Self::from_taps(-1, &[0.125 * width, 1.0 - 0.25 * width, 0.125 * width]);
        }
        // A tap is the mean over the box of a pixel's own tent, by its primitive.
        let primitive = |x: f64| match x {
            x if x <= -1.0 => 0.0,
            x if x <= 0.0 => 0.5 * (x + 1.0).powi(2),
            x if x <= 1.0 => 1.0 - 0.5 * (1.0 - x).powi(2),
            _ => 1.0,
        };
        symmetric(0.5 * width, |m| (primitive(m + 0.5 * width) - primitive(m - 0.5 * width)) / width)
    }

    /// A tent of weight 1 that reaches `radius` pixels to either side: a box of width `radius`, twice.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the radius is positive and at most 65535.
    pub fn tent(radius: f64) -> Result<Self> {
        check_width("radius of a tent", radius, FARTHEST as f64 - 1.0)?;
        if !(radius > 0.0) {
            return Err(Error::OutOfRange { what: "radius of a tent", got: radius, allowed: "positive" });
        }
        if radius <= 1.0 {
            return Self::from_taps(-1, &[radius / 6.0, 1.0 - radius / 3.0, radius / 6.0]);
        }
        // The same by the second primitive, of which the tent makes a second difference.
        let primitive = |x: f64| match x {
            x if x <= -1.0 => 0.0,
            x if x <= 0.0 => (x + 1.0).powi(3) / 6.0,
            x if x <= 1.0 => (x + 1.0).powi(3) / 6.0 - x.powi(3) / 3.0,
            x => x,
        };
        let difference = |m: f64| primitive(m - radius) - 2.0 * primitive(m) + primitive(m + radius);
        symmetric(radius, |m| difference(m) / radius.powi(2))
    }

    /// First this kernel, then another: their convolution, tap by tap.
    ///
    /// # Errors
    /// As [`from_taps`](Self::from_taps), of the result.
    pub fn then(&self, other: &Self) -> Result<Self> {
        let mut taps = vec![0.0; self.taps.len() + other.taps.len() - 1];
        for (i, a) in self.taps.iter().enumerate() {
            for (j, b) in other.taps.iter().enumerate() {
                taps[i + j] += a * b;
            }
        }
        Self::from_taps(self.first + other.first, &taps)
    }

    /// Every tap times a factor.
    ///
    /// # Errors
    /// [`Error::NotFinite`] where a product is not.
    pub fn scaled(&self, factor: f64) -> Result<Self> {
        let taps: Vec<f64> = self.taps.iter().map(|tap| tap * factor).collect();
        Self::from_taps(self.first, &taps)
    }

    /// The m of the first tap.
    #[inline]
    pub fn first(&self) -> i64 {
        self.first
    }

    /// The taps, from [`first`](Self::first) on.
    #[inline]
    pub fn taps(&self) -> &[f64] {
        &self.taps
    }

    /// (m, t_m).
    #[inline]
    pub(super) fn iter(&self) -> impl Iterator<Item = (i64, f64)> + '_ {
        (self.first..).zip(self.taps.iter().copied())
    }
}

/// The taps of a kernel that reaches `radius` pixels, which are the same to both sides.
fn symmetric(radius: f64, tap: impl Fn(f64) -> f64) -> Result<Kernel> {
    let reach = (radius + 1.0).ceil() as i64 - 1;
    let taps: Vec<f64> = (-reach..=reach).map(|m| tap(-m.abs() as f64)).collect();
    Kernel::from_taps(-reach, &taps)
}

fn check_width(what: &'static str, got: f64, most: f64) -> Result<()> {
    if got <= most { Ok(()) } else { Err(Error::OutOfRange { what, got, allowed: "at most 65535 pixels" }) }
}

crate::approx_eq::approx_by_parts!([] Kernel, f64, |k| close [&k.taps] same [k.first]);
