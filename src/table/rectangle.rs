//! Rectangles of pixels and the disk inside a square of them.

use crate::approx_eq::approx_by_parts;
use crate::{Error, Result};

/// An axis-aligned rectangle in pixel units: pixel (x, y) is [x, x + 1] × [y, y + 1].
///
/// Bounds may be fractional, outside the image, or the wrong way round: integrals over it are oriented, as ∫ₐᵇ = −∫ᵇₐ,
/// so that neighbouring rectangles add up whatever their order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    /// The x it starts at.
    pub left: f64,
    /// The y it starts at.
    pub top: f64,
    /// The x it ends at.
    pub right: f64,
    /// The y it ends at.
    pub bottom: f64,
}

impl Rectangle {
    /// A square around a point.
    #[inline]
    pub fn square(centre: [f64; 2], edge: f64) -> Self {
        let ([x, y], half) = (centre, 0.5 * edge);
        Self { left: x - half, top: y - half, right: x + half, bottom: y + half }
    }

    /// (right − left)·(bottom − top): negative if it is inverted along one axis.
    #[inline]
    pub fn area(&self) -> f64 {
        (self.right - self.left) * (self.bottom - self.top)
    }
}

/// What a look-up finds beyond the image, along one axis.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Outside {
    /// Nothing: f is 0 there.
    #[default]
    Zero,
    /// The image again: it repeats for ever, as longitude does.
    Wrap,
}

/// A square grid over [−1, 1]², and in it the unit disk, which the equal-area map makes of a hemisphere
/// ([`HemisphereDisk`](crate::sphere::HemisphereDisk)).
///
/// Pixel (x, y) has its centre at ((2x + 1)/side − 1, (2y + 1)/side − 1). It belongs to the disk if that point does.
/// The ring 1 < ρ < √2 is the hemisphere below the horizon, where visibility and reflectance are 0: a map that is zero
/// outside the disk gives a square light across the horizon what is above it, if integrals are divided by the square's
/// whole area [Xu 2006 §5, which leaves it open].
///
/// # Example
/// ```
/// use haarmonic::table::{DiskGrid, SummedArea};
/// let grid = DiskGrid::new(32)?;
/// let mut sky = vec![1.0_f32; 32 * 32];
/// grid.mask(&mut sky);
/// let table: SummedArea<f64> = SummedArea::new(32, 32, &sky)?;
/// let horizon = grid.square([1.0, 0.0], 0.25);
/// assert_eq!(table.as_ref().mean(horizon), 0.5);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DiskGrid {
    side: usize,
}

impl DiskGrid {
    /// A grid of `side` × `side` pixels.
    ///
    /// # Errors
    /// [`Error::Empty`] if `side` is 0; [`Error::OutOfRange`] above 2¹⁶.
    pub fn new(side: usize) -> Result<Self> {
        match side {
            0 => Err(Error::Empty { what: "disk grid" }),
            1..=0x1_0000 => Ok(Self { side }),
            _ => Err(Error::OutOfRange { what: "side of a disk grid", got: side as f64, allowed: "at most 65536" }),
        }
    }

    /// Pixels along a side.
    #[inline]
    pub fn side(&self) -> usize {
        self.side
    }

    /// Whether the centre of a pixel is in the closed unit disk; no pixel outside the grid is.
    #[inline]
    pub fn contains(&self, x: usize, y: usize) -> bool {
        if x >= self.side || y >= self.side {
            return false;
        }
        let n = self.side as i64;
        // 2·side times the centre, in integers: the mask is symmetric, whatever the side.
        let [u, v] = [x, y].map(|k| 2 * k as i64 + 1 - n);
        u * u + v * v <= n * n
    }

    /// Sets what is outside the disk to zero (`false`).
    ///
    /// # Panics
    /// If `map.len()` is not side².
    #[track_caller]
    pub fn mask<V: Default>(&self, map: &mut [V]) {
        crate::error::check_length("pixels of a disk grid", self.side * self.side, map.len());
        for (i, value) in map.iter_mut().enumerate() {
            if !self.contains(i % self.side, i / self.side) {
                *value = V::default();
            }
        }
    }

    /// The place of a point of [−1, 1]² in pixels, from the grid's first corner.
    #[inline]
    pub fn pixels(&self, point: [f64; 2]) -> [f64; 2] {
        point.map(|p| 0.5 * (p + 1.0) * self.side as f64)
    }

    /// A length of the disk's plane in pixels.
    #[inline]
    pub fn length(&self, length: f64) -> f64 {
        0.5 * length * self.side as f64
    }

    /// A square of the disk's plane in pixels. For a light of solid angle s its edge is √(s/2)
    /// ([`HemisphereDisk::AREA_PER_STERADIAN`](crate::sphere::HemisphereDisk::AREA_PER_STERADIAN)).
    #[inline]
    pub fn square(&self, centre: [f64; 2], edge: f64) -> Rectangle {
        Rectangle::square(self.pixels(centre), self.length(edge))
    }
}

approx_by_parts!([] Rectangle, f64, |r| close [[r.left, r.top, r.right, r.bottom]] same []);
