//! The functions that are coupled.

use super::Mother;
use crate::haar::{Index1d, Index2d, WaveletKind};

/// A scaling function or wavelet of any level: 2^{l/2} f(2^l v − t), f = φ or ψ.
///
/// The 1D basis and the standard bases are products of φ at level 0 and wavelets; the nonstandard basis needs the
/// scaling functions of every level too, and so does the square of a wavelet.
///
/// # Example
/// ```
/// use haarmonic::affine::{Atom, Mother};
/// assert_eq!(Atom::from_flat(6), Atom { mother: Mother::Wavelet, level: 2, offset: 2 });
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Atom {
    /// f.
    pub mother: Mother,
    /// l, at most 63.
    pub level: u32,
    /// t, below 2^l for an atom of the unit interval.
    pub offset: usize,
}

impl Atom {
    /// The function of a flat index of the 1D basis.
    #[inline]
    pub fn from_flat(flat: usize) -> Self {
        match Index1d::from_flat(flat) {
            Index1d::Scaling => Self { mother: Mother::Scaling, level: 0, offset: 0 },
            Index1d::Detail { level, offset } => Self { mother: Mother::Wavelet, level, offset },
        }
    }

    /// The two factors, along x and y, of a function of the 2D nonstandard basis.
    #[inline]
    pub fn from_nonstandard(flat: usize) -> [Self; 2] {
        match Index2d::from_flat(flat) {
            Index2d::Scaling => [Self { mother: Mother::Scaling, level: 0, offset: 0 }; 2],
            Index2d::Detail { level, kind, x, y } => {
                let [horizontal, vertical] = match kind {
                    WaveletKind::Horizontal => [Mother::Wavelet, Mother::Scaling],
                    WaveletKind::Vertical => [Mother::Scaling, Mother::Wavelet],
                    WaveletKind::Diagonal => [Mother::Wavelet; 2],
                };
                [Self { mother: horizontal, level, offset: x }, Self { mother: vertical, level, offset: y }]
            }
        }
    }

    /// Panics if the level is beyond those of a flat index.
    #[inline(always)]
    #[track_caller]
    pub(super) fn check(self) {
        assert!(self.level <= 63, "level {} of an atom: at most 63", self.level);
    }

    /// 2^{−l}: the width of the support.
    #[inline(always)]
    pub(super) fn width(self) -> f64 {
        power(-(self.level as i32))
    }

    /// Where it begins, changes sign (φ: is half over) and ends; exact below 2^52.
    #[inline(always)]
    pub(super) fn breakpoints(self) -> [f64; 3] {
        let (width, t) = (self.width(), self.offset as f64);
        [t * width, (t + 0.5) * width, (t + 1.0) * width]
    }
}

/// 2^e for |e| < 1023, from its bits.
#[inline(always)]
pub(super) fn power(e: i32) -> f64 {
    f64::from_bits(((1023 + e) as u64) << 52)
}

/// 2^{e/2}: a power of two, times √2 for odd e.
#[inline(always)]
pub(super) fn root_power(e: i32) -> f64 {
    let even = power(e.div_euclid(2));
    if e & 1 == 0 { even } else { even * std::f64::consts::SQRT_2 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_exact() {
        for e in -100..=100 {
            assert_eq!(power(e), 2f64.powi(e));
            let root = root_power(e);
            assert!((root / 2f64.powf(f64::from(e) / 2.0) - 1.0).abs() < 4e-16, "{e}: {root}");
        }
    }
}
