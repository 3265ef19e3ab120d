//! Coefficient vectors in other people's conventions, and back.

use nalgebra::Complex;

use super::index::{coefficient_count, index};
use crate::Real;
use crate::error::check_length;

/// The sign of the odd orders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Phase {
    /// None: y_{1,·} = c·(y, z, x). This crate.
    #[default]
    Plain,
    /// (−1)^m on every order: y_{1,·} = c·(−y, z, −x). Sloan's tables, DirectXMath.
    CondonShortley,
}

/// The scale of a basis function.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Normalization {
    /// ∫ y² dω = 1. This crate.
    #[default]
    Orthonormal,
    /// ∫ y² dω = 4π: geodesy.
    FourPi,
    /// ∫ y² dω = 4π/(2l+1): Schmidt's semi-normalisation, geomagnetism; also Racah's C_lm and ambisonics' SN3D.
    Schmidt,
}

/// Where a coefficient lies in its vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Layout {
    /// l(l+1) + m. This crate; ambisonics' ACN.
    #[default]
    ByDegree,
    /// m = 0, 1, −1, 2, −2, …; within an order, l = |m|, …, bands − 1.
    ByOrder,
}

/// A convention for the coefficients of a real function in a real basis.
///
/// Coefficients scale inversely to basis functions: if y' = k y then c' = c/k, so that Σ c' y' = Σ c y. Values of basis
/// functions therefore go through [`export_values`](Self::export_values), not through [`export`](Self::export).
///
/// # Example
/// ```
/// use haarmonic::sh::{Convention, Phase};
/// let sloan = Convention { phase: Phase::CondonShortley, ..Convention::default() };
/// assert_eq!(sloan.export(2, &[1.0, 2.0, 3.0, 4.0]), [1.0, -2.0, 3.0, -4.0]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Convention {
    /// The sign of the odd orders.
    pub phase: Phase,
    /// The scale of a basis function.
    pub normalization: Normalization,
    /// The order of the vector.
    pub layout: Layout,
}

impl Convention {
    /// Coefficients of this crate → coefficients of the convention.
    ///
    /// # Panics
    /// If `coefficients.len()` is not bands².
    #[track_caller]
    pub fn export<T: Real>(&self, bands: usize, coefficients: &[T]) -> Vec<T> {
        check_length("coefficients", coefficient_count(bands), coefficients.len());
        self.order(bands).map(|(l, m)| coefficients[index(l, m)] * T::of(1.0 / self.scale(l, m))).collect()
    }

    /// Coefficients of the convention → coefficients of this crate. Inverse of [`export`](Self::export).
    ///
    /// # Panics
    /// If `coefficients.len()` is not bands².
    #[track_caller]
    pub fn import<T: Real>(&self, bands: usize, coefficients: &[T]) -> Vec<T> {
        check_length("coefficients", coefficient_count(bands), coefficients.len());
        let mut out = vec![T::zero(); coefficients.len()];
        for ((l, m), &c) in self.order(bands).zip(coefficients) {
            out[index(l, m)] = c * T::of(self.scale(l, m));
        }
        out
    }

    /// Values of this crate's basis functions → values of the convention's.
    ///
    /// # Panics
    /// If `values.len()` is not bands².
    #[track_caller]
    pub fn export_values<T: Real>(&self, bands: usize, values: &[T]) -> Vec<T> {
        check_length("values", coefficient_count(bands), values.len());
        self.order(bands).map(|(l, m)| values[index(l, m)] * T::of(self.scale(l, m))).collect()
    }

    /// The convention's basis function over this crate's.
    fn scale(&self, l: usize, m: isize) -> f64 {
        let four_pi = 4.0 * std::f64::consts::PI;
        let size = match self.normalization {
            Normalization::Orthonormal => 1.0,
            Normalization::FourPi => four_pi.sqrt(),
            Normalization::Schmidt => (four_pi / (2 * l + 1) as f64).sqrt(),
        };
        match self.phase {
            Phase::CondonShortley if m % 2 != 0 => -size,
            _ => size,
        }
    }

    /// The (l, m) of the convention's vector, from its start.
    fn order(&self, bands: usize) -> impl Iterator<Item = (usize, isize)> {
        let by_order = self.layout == Layout::ByOrder;
        (0..if by_order { 2 * bands.max(1) - 1 } else { bands }).flat_map(move |outer| {
            let inner = if by_order { bands.saturating_sub(outer.div_ceil(2)) } else { 2 * outer + 1 };
            (0..inner).map(move |k| {
                if by_order {
                    let m = outer.div_ceil(2);
                    (m + k, if outer % 2 == 1 { m as isize } else { -(m as isize) })
                } else {
                    (outer, k as isize - outer as isize)
                }
            })
        })
    }
}

/// Coefficients of a real function in the complex orthonormal basis with Condon–Shortley phase (SciPy's `sph_harm_y`,
/// quantum mechanics), index l(l+1) + m.
///
///   a_{l,0} = c_{l,0},  a_{l,m} = (−1)^m (c_{l,m} − i c_{l,−m})/√2,  a_{l,−m} = (−1)^m conj(a_{l,m})  (m > 0)
///
/// from y_{l,±m} = √2 (−1)^m {Re, Im} Y_{l,m}; then Σ a Y = Σ c y.
///
/// # Panics
/// If `coefficients.len()` is not bands².
#[track_caller]
pub fn to_complex<T: Real>(bands: usize, coefficients: &[T]) -> Vec<Complex<T>> {
    check_length("coefficients", coefficient_count(bands), coefficients.len());
    let mut out = vec![Complex::new(T::zero(), T::zero()); coefficients.len()];
    for l in 0..bands {
        let centre = l * (l + 1);
        out[centre].re = coefficients[centre];
        for m in 1..=l {
            let half = T::of(sign(m) * 0.5f64.sqrt());
            let (even, odd) = (coefficients[centre + m], coefficients[centre - m]);
            out[centre + m] = Complex::new(half * even, -half * odd);
            let plain = T::of(0.5f64.sqrt());
            out[centre - m] = Complex::new(plain * even, plain * odd);
        }
    }
    out
}

/// Coefficients of the real part of Σ a Y, from those in the complex basis of [`to_complex`], whose inverse it is.
///
///   c_{l,m} = Re((−1)^m a_{l,m} + a_{l,−m})/√2,  c_{l,−m} = Im(a_{l,−m} − (−1)^m a_{l,m})/√2
///
/// # Panics
/// If `coefficients.len()` is not bands².
#[track_caller]
pub fn from_complex<T: Real>(bands: usize, coefficients: &[Complex<T>]) -> Vec<T> {
    check_length("coefficients", coefficient_count(bands), coefficients.len());
    let mut out = vec![T::zero(); coefficients.len()];
    let half = T::of(0.5f64.sqrt());
    for l in 0..bands {
        let centre = l * (l + 1);
        out[centre] = coefficients[centre].re;
        for m in 1..=l {
            let (up, down) = (coefficients[centre + m], coefficients[centre - m]);
            let sign = T::of(sign(m));
            out[centre + m] = half * (sign * up.re + down.re);
            out[centre - m] = half * (down.im - sign * up.im);
        }
    }
    out
}

fn sign(m: usize) -> f64 {
    if m % 2 == 0 { 1.0 } else { -1.0 }
}
