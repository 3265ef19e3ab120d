//! v ↦ s v + o.

use crate::approx_eq::approx_by_parts;
use crate::{Error, Result};

/// The affine map v ↦ s·v + o of one axis, s ≠ 0: a signal F seen through it is F(s v + o).
///
/// Both numbers are `f64` whatever the scalar of the signal: a map costs nothing, and the couplings of a small s need
/// it.
///
/// # Example
/// ```
/// use haarmonic::affine::AffineMap;
/// let half = AffineMap::new(0.5, 0.25)?; // the middle half, drawn twice as large
/// assert_eq!(half.apply(1.0), 0.75);
/// assert_eq!(half.inverse().apply(0.75), 1.0);
/// assert!(AffineMap::new(0.0, 0.0).is_err());
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(try_from = "Unchecked"))]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AffineMap {
    scale: f64,
    offset: f64,
}

/// The range of |s|; |o| is at most the larger.
const SMALLEST: f64 = 1e-100;
const LARGEST: f64 = 1e100;

/// What a stored map says of itself.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Unchecked {
    scale: f64,
    offset: f64,
}

#[cfg(feature = "serde")]
impl TryFrom<Unchecked> for AffineMap {
    type Error = Error;

    fn try_from(map: Unchecked) -> Result<Self> {
        Self::new(map.scale, map.offset)
    }
}

impl AffineMap {
    /// v ↦ v.
    pub const IDENTITY: Self = Self { scale: 1.0, offset: 0.0 };

    /// The map of scale s and offset o.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 1e-100 ≤ |s| ≤ 1e100 and |o| ≤ 1e100, NaN included: nothing can overflow inside
    /// that.
    pub fn new(scale: f64, offset: f64) -> Result<Self> {
        if !(SMALLEST..=LARGEST).contains(&scale.abs()) {
            let allowed = "not zero: 1e-100 ≤ |s| ≤ 1e100";
            return Err(Error::OutOfRange { what: "scale of an affine map", got: scale, allowed });
        }
        if !(offset.abs() <= LARGEST) {
            let allowed = "finite: |o| ≤ 1e100";
            return Err(Error::OutOfRange { what: "offset of an affine map", got: offset, allowed });
        }
        Ok(Self { scale, offset })
    }

    /// s.
    #[inline]
    pub fn scale(self) -> f64 {
        self.scale
    }

    /// o.
    #[inline]
    pub fn offset(self) -> f64 {
        self.offset
    }

    /// v ↦ s·`factor` v + o, whose range is not checked: `factor` is a ratio of two sizes, and exact.
    pub(super) fn stretched(self, factor: f64) -> Self {
        Self { scale: self.scale * factor, offset: self.offset }
    }

    /// s v + o, rounded twice.
    #[inline]
    pub fn apply(self, v: f64) -> f64 {
        self.scale * v + self.offset
    }

    /// (x − o)/s: the v that goes to x.
    #[inline]
    pub fn solve(self, x: f64) -> f64 {
        (x - self.offset) / self.scale
    }

    /// x ↦ (x − o)/s.
    ///
    /// Both numbers are held inside the range of [`new`](Self::new). Where −o/s leaves it, s [0, 1] + o has no length
    /// in common with [0, 1], and neither has the inverse's image with the offset at ±1e100: nothing is in sight
    /// through either.
    #[inline]
    pub fn inverse(self) -> Self {
        let scale = self.scale.recip();
        Self {
            scale: scale.abs().clamp(SMALLEST, LARGEST).copysign(scale),
            offset: (-self.offset / self.scale).clamp(-LARGEST, LARGEST),
        }
    }

    /// v ↦ `outer`(self(v)): F(outer(v)), seen through `self`.
    ///
    /// Transformed signals of finite resolution do not chain (each is a projection of its own): compose the maps first.
    ///
    /// # Errors
    /// As [`new`](Self::new), where the composition leaves the range.
    pub fn then(self, outer: Self) -> Result<Self> {
        Self::new(outer.scale * self.scale, outer.scale * self.offset + outer.offset)
    }
}

/// What a derivative is taken with respect to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Parameter {
    /// s.
    Scale,
    /// o.
    Offset,
}

impl Parameter {
    /// Both, in the order of every gradient here.
    pub const ALL: [Self; 2] = [Self::Scale, Self::Offset];
}

impl Default for AffineMap {
    fn default() -> Self {
        Self::IDENTITY
    }
}

approx_by_parts!([] AffineMap, f64, |m| close [[m.scale, m.offset]] same []);
