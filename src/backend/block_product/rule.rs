//! How many samples a block of reflectance gets.

use crate::{Error, Result};

/// What chooses between 0, 1, 4, 16 samples a block and one for every pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Rule {
    /// The fewest whose error, as measured for the lobe and weighed with the block's light, is at most `tolerance` ×
    /// the mean radiance of the light, divided by the square root of half the number of blocks; cosines exactly.
    ///
    /// 0 takes every pixel of a lobe: the sum over all texels, to rounding. See [`Rule::bounded`].
    Bounded {
        /// Error of a vertex's radiance in units of the light's mean radiance, if the errors of blocks are independent.
        tolerance: f64,
    },
    /// The fixed rule of appendix A [Inger 2013] by the angle between a block's centre and the mirror direction,
    /// whatever the light; one sample for cosines.
    ///
    /// Lobes other than Phong's go by the Phong exponent of the same width.
    Fixed {
        /// To what the angle is taken.
        angle: BlockAngle,
    },
    /// Every block through its pixels (line 11 of algorithm 1): the baseline that the paper's speed-ups are against.
    Pixels,
}

/// To what of a block [`Rule::Fixed`] takes the angle from the mirror direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BlockAngle {
    /// Its centre, as printed: a block just outside π/8 counts as smooth although it may hold .87 of the peak of a lobe
    /// of exponent 100.
    Centre,
    /// Its nearest point: the angle to the centre, less the block's radius.
    Nearest,
}

impl Rule {
    /// [`Rule::Bounded`].
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless `tolerance` is finite and at least 0.
    pub fn bounded(tolerance: f64) -> Result<Self> {
        if tolerance >= 0.0 && tolerance.is_finite() {
            return Ok(Self::Bounded { tolerance });
        }
        Err(Error::OutOfRange {
            what: "tolerance of a block product",
            got: tolerance,
            allowed: "finite and at least 0",
        })
    }
}

impl Default for Rule {
    /// Bounded by 0.1: better than 45 dB for Phong exponents up to 200 (docs/block_product.md).
    fn default() -> Self {
        Self::Bounded { tolerance: 0.1 }
    }
}

/// How many samples of reflectance a block gets, in ascending order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) struct SampleClass(u8);

impl SampleClass {
    pub(super) const NONE: Self = Self(0);
    pub(super) const ONE: Self = Self(1);
    pub(super) const FOUR: Self = Self(2);
    pub(super) const SIXTEEN: Self = Self(3);
    /// One for every pixel.
    pub(super) const PIXELS: Self = Self(4);

    /// The class after so many others, at most 7 of them.
    #[inline(always)]
    pub(super) fn after(others: u32) -> Self {
        Self(others as u8)
    }

    /// The number of classes before this one.
    #[inline(always)]
    pub(super) fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// The classes within π/8 of the mirror direction, within π/4, and beyond [Inger 2013, appendix A]; exponents 30 and
/// 250, of which the print says nothing, go to the finer side.
pub(super) fn fixed(exponent: Option<f64>) -> [SampleClass; 3] {
    const ONE: SampleClass = SampleClass::ONE;
    match exponent {
        None => [ONE; 3],
        Some(s) if s < 30.0 => [SampleClass::FOUR, SampleClass::FOUR, ONE],
        Some(s) if s < 250.0 => [SampleClass::SIXTEEN, SampleClass::FOUR, ONE],
        Some(_) => [SampleClass::PIXELS, SampleClass::FOUR, ONE],
    }
}
