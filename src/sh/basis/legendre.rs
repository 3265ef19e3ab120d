//! The part of the basis that depends on z alone.

use super::kernel::{Table, Visitor, walk};
use crate::error::check_length;
use crate::{Error, Real, Result};

/// The polynomials q_{l,m}(z) of the basis, m ≥ 0, at l(l+1)/2 + m.
///
/// ```math
/// y_{l,±m} = q_{l,m}(z) {Re, Im} (x + iy)^m,  q_{l,m}(z) = √(2 − δ_{m0}) N_{lm} P_l^m(z) / (1 − z²)^{m/2}
/// ```
///
/// The normalised associated Legendre function without (−1)^m is q_{l,m} sin^m θ, with its factor √2 for m > 0.
/// Dividing by the sine makes it a polynomial, which has a value at the poles.
///
/// Shapes: out: bands (bands + 1)/2. Accuracy: that of [`Basis`](super::Basis), whose values have the same bits. One
/// shot: allocates its tables.
///
/// # Errors
/// [`Error::OutOfRange`] if `bands` is 0 or more than [`Basis::max_bands`](super::Basis::max_bands).
///
/// # Panics
/// If `out.len()` is not bands (bands + 1)/2.
///
/// # Example
/// ```
/// let mut q = [0.0; 3];
/// haarmonic::sh::associated_legendre(2, 0.5, &mut q)?;
/// let root = (3.0 / (4.0 * std::f64::consts::PI)).sqrt(); // y_{1,0} = root z, y_{1,1} = root x
/// assert!((q[1] - root * 0.5).abs() < 1e-16 && (q[2] - root).abs() < 1e-16);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[track_caller]
pub fn associated_legendre<T: Real>(bands: usize, z: T, out: &mut [T]) -> Result<()> {
    if bands == 0 || bands > super::Basis::<T>::max_bands() {
        return Err(Error::OutOfRange { what: "bands", got: bands as f64, allowed: "1 to Basis::max_bands" });
    }
    check_length("associated Legendre functions", bands * (bands + 1) / 2, out.len());
    walk(&Table::new(bands), bands, [&[T::zero()], &[T::zero()], &[z]], &mut StoreRings { out });
    Ok(())
}

struct StoreRings<'a, T> {
    out: &'a mut [T],
}

impl<T: Real> Visitor<T, 1> for StoreRings<'_, T> {
    #[inline(always)]
    fn visit(&mut self, l: usize, m: usize, q: &[T; 1], _: &[T; 1], _: &[T; 1]) {
        self.out[l * (l + 1) / 2 + m] = q[0];
    }
}
