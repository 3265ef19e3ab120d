//! PyWavelets' orders and scaling of the same coefficients.
//!
//! PyWavelets' `haar` is orthonormal on *samples*: (a ± b)/√2 at each step, so that Σ c² = Σ x². Ours is orthonormal on
//! the unit interval or square: Σ c² = mean x². One is the other times the square root of the number of samples, with
//! the same signs: PyWavelets' detail is (a − b)/√2, first minus second, as ψ is.
//!
//! Its names of the 2D details are those of edges, ours those of the direction of change: `cH` (its key `da`: detail
//! along axis 0 = y, approximation along axis 1 = x) is φ(x)ψ(y), our vertical; `cV` (`ad`) is ψ(x)φ(y), our
//! horizontal; `cD` is diagonal in both.

use crate::{Error, Real, Result};

/// How PyWavelets lays out 2D coefficients of a full decomposition (`wavedec2(image, 'haar')`).
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PyWaveletsLayout {
    /// The arrays of `wavedec2`'s list as they come: cA, then cH, cV, cD of each level, coarsest first, each row-major.
    Wavedec2,
    /// `ravel_coeffs(wavedec2(…))[0]`: cA, then `ad`, `da`, `dd` (cV, cH, cD) of each level. Our order.
    Ravelled,
    /// `coeffs_to_array(wavedec2(…))[0]`: a size × size matrix, row-major, with cV right of, cH below and cD diagonally
    /// below the block of everything coarser.
    Array,
}

/// Our 1D coefficients → `numpy.concatenate(pywt.wavedec(x, 'haar'))`: the same order, times √N.
///
/// # Errors
/// [`Error::NotPowerOfTwo`] unless `coefs.len()` is 1, 2, 4, …
///
/// # Example
/// ```
/// # fn main() -> Result<(), haarmonic::Error> {
/// let coefs = haarmonic::haar::forward_1d(&[3.0, 1.0])?;
/// assert_eq!(coefs, [2.0, 1.0]);
/// let pywt = haarmonic::haar::to_pywavelets_1d(&coefs)?; // (3 ± 1)/√2
/// assert_eq!(pywt, [2.0 * 2.0_f64.sqrt(), 2.0_f64.sqrt()]);
/// # Ok(())
/// # }
/// ```
pub fn to_pywavelets_1d<T: Real>(coefs: &[T]) -> Result<Vec<T>> {
    let scale = T::of((check_len(coefs.len())? as f64).sqrt());
    Ok(coefs.iter().map(|&c| c * scale).collect())
}

/// The inverse of [`to_pywavelets_1d`].
///
/// # Errors
/// [`Error::NotPowerOfTwo`] unless `coefs.len()` is 1, 2, 4, …
pub fn from_pywavelets_1d<T: Real>(coefs: &[T]) -> Result<Vec<T>> {
    let scale = T::of((check_len(coefs.len())? as f64).sqrt());
    Ok(coefs.iter().map(|&c| c / scale).collect())
}

/// Our 2D nonstandard coefficients of a `size` × `size` image → PyWavelets': times `size`, in one of its layouts.
///
/// Our *standard* coefficients are `pywt.fswavedecn(image, 'haar').coeffs` row-major, divided by √(width·height).
///
/// # Errors
/// [`Error::NotPowerOfTwo`] unless `size` is 1, 2, 4, …; [`Error::Length`] unless there are size² coefficients.
pub fn to_pywavelets_2d<T: Real>(size: usize, coefs: &[T], layout: PyWaveletsLayout) -> Result<Vec<T>> {
    check_square(size, coefs.len())?;
    let scale = T::of(size as f64);
    let mut out = vec![T::zero(); coefs.len()];
    for (ours, &c) in coefs.iter().enumerate() {
        out[place(size, ours, layout)] = c * scale;
    }
    Ok(out)
}

/// The inverse of [`to_pywavelets_2d`].
///
/// # Errors
/// As [`to_pywavelets_2d`].
pub fn from_pywavelets_2d<T: Real>(size: usize, coefs: &[T], layout: PyWaveletsLayout) -> Result<Vec<T>> {
    check_square(size, coefs.len())?;
    let scale = T::of(size as f64);
    Ok((0..coefs.len()).map(|ours| coefs[place(size, ours, layout)] / scale).collect())
}

/// Where PyWavelets keeps the coefficient of our flat index.
fn place(size: usize, flat: usize, layout: PyWaveletsLayout) -> usize {
    use super::{Index2d, WaveletKind};
    let Index2d::Detail { level, kind, x, y } = Index2d::from_flat(flat) else { return 0 };
    match layout {
        PyWaveletsLayout::Ravelled => flat,
        PyWaveletsLayout::Wavedec2 => {
            let kind = match kind {
                WaveletKind::Horizontal => WaveletKind::Vertical,
                WaveletKind::Vertical => WaveletKind::Horizontal,
                WaveletKind::Diagonal => WaveletKind::Diagonal,
            };
            Index2d::Detail { level, kind, x, y }.flat()
        }
        PyWaveletsLayout::Array => {
            let side = 1 << level;
            let (column, row) = match kind {
                WaveletKind::Horizontal => (side + x, y),
                WaveletKind::Vertical => (x, side + y),
                WaveletKind::Diagonal => (side + x, side + y),
            };
            row * size + column
        }
    }
}

fn check_len(len: usize) -> Result<usize> {
    if len.is_power_of_two() { Ok(len) } else { Err(Error::NotPowerOfTwo { what: "signal length", got: len }) }
}

fn check_square(size: usize, len: usize) -> Result<()> {
    if !size.is_power_of_two() {
        return Err(Error::NotPowerOfTwo { what: "image size", got: size });
    }
    match size.checked_mul(size) {
        Some(expected) if expected == len => Ok(()),
        expected => Err(Error::Length { what: "coefficients", expected: expected.unwrap_or(usize::MAX), got: len }),
    }
}
