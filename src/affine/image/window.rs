//! Which part of a picture is shown.

use crate::Result;
use crate::affine::AffineMap;
use crate::approx_eq::approx_by_parts;

/// The part of a picture that a zoom shows: one affine map an axis, from the frame of the result to that of the
/// picture, both of them [0, 1]².
///
/// A window may be larger than the picture, lie partly or wholly beside it, and be mirrored: the picture is 0 beyond
/// its border.
///
/// # Example
/// ```
/// use haarmonic::affine::ZoomWindow;
/// let window = ZoomWindow::new([0.5, 0.25], [4.0, 2.0])?; // a quarter as wide, half as high
/// assert_eq!(window.maps().map(|map| [map.offset(), map.apply(1.0)]), [[0.375, 0.625], [0.0, 0.5]]);
/// assert_eq!(window.moved([1.0, 0.0])?.centre(), [0.75, 0.25]); // one window to the right
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZoomWindow {
    maps: [AffineMap; 2],
}

impl ZoomWindow {
    /// The whole picture.
    pub const WHOLE: Self = Self { maps: [AffineMap::IDENTITY; 2] };

    /// The window with the given centre, in widths and heights of the picture, whose sides are 1/`zoom` of the
    /// picture's: each axis has its own factor; above 1 the picture is enlarged; a negative factor mirrors it.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless 1e-100 ≤ |zoom| ≤ 1e100, and for a centre that is not
    /// finite or beyond ±1e100.
    pub fn new(centre: [f64; 2], zoom: [f64; 2]) -> Result<Self> {
        let map = |axis: usize| {
            let scale = zoom[axis].recip();
            AffineMap::new(scale, centre[axis] - 0.5 * scale)
        };
        Ok(Self { maps: [map(0)?, map(1)?] })
    }

    /// The window of a pair of maps, along x and along y.
    pub fn from_maps(maps: [AffineMap; 2]) -> Self {
        Self { maps }
    }

    /// The maps of the axes: v of the result is s v + o of the picture.
    #[inline]
    pub fn maps(self) -> [AffineMap; 2] {
        self.maps
    }

    /// The centre, in widths and heights of the picture.
    pub fn centre(self) -> [f64; 2] {
        self.maps.map(|map| map.apply(0.5))
    }

    /// The factors by which the picture is enlarged.
    pub fn zoom(self) -> [f64; 2] {
        self.maps.map(|map| map.scale().recip())
    }

    /// The window moved by its own width times `by[0]` and its own height times `by[1]`: a pan.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) where it leaves the range of an [`AffineMap`].
    pub fn moved(self, by: [f64; 2]) -> Result<Self> {
        let map = |axis: usize| AffineMap::new(self.maps[axis].scale(), self.maps[axis].apply(by[axis]));
        Ok(Self { maps: [map(0)?, map(1)?] })
    }

    /// The window moved by less than a pixel, so that it begins where a pixel of a picture of `size` does.
    ///
    /// Through such a window, a zoom by a whole power of two has hardly more terms than the picture has inside, since
    /// edges of pixels stay edges of pixels; it is several times as fast as beside it.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) where it leaves the range of an [`AffineMap`].
    pub fn snapped(self, size: [usize; 2]) -> Result<Self> {
        let map = |axis: usize| {
            let side = size[axis].max(1) as f64;
            AffineMap::new(self.maps[axis].scale(), (self.maps[axis].offset() * side).round() / side)
        };
        Ok(Self { maps: [map(0)?, map(1)?] })
    }

    /// The maps from grid to grid, for pictures of these sizes.
    pub(super) fn between(self, from: [usize; 2], to: [usize; 2]) -> Result<[AffineMap; 2]> {
        let share = |size: [usize; 2], axis: usize| size[axis] as f64 / size[axis].next_power_of_two() as f64;
        let map = |axis: usize| {
            let (ours, theirs) = (share(from, axis), share(to, axis));
            AffineMap::new(self.maps[axis].scale() * (ours / theirs), self.maps[axis].offset() * ours)
        };
        Ok([map(0)?, map(1)?])
    }
}

impl Default for ZoomWindow {
    fn default() -> Self {
        Self::WHOLE
    }
}

approx_by_parts!(
    [] ZoomWindow, f64,
    |w| close [w.maps.map(AffineMap::scale), w.maps.map(AffineMap::offset)] same []
);
