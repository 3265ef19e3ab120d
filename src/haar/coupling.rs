//! Coupling coefficients of the orthonormal basis.

use crate::Real;

/// Coupling coefficient of two basis functions, by flat index, in 1D or 2D.
///
///   C_ij = ∫ ψ_i ψ_j = δ_ij                                   [Sun 2008, eq. 4.4 and §4.3.3]
///
/// The basis is orthonormal, so the double-product integral of two signals is the dot product of their coefficients.
#[inline]
pub fn coupling<T: Real>(i: usize, j: usize) -> T {
    if i == j { T::one() } else { T::zero() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coupling_is_kronecker() {
        assert_eq!(coupling::<f64>(7, 7), 1.0);
        assert_eq!(coupling::<f32>(7, 8), 0.0);
        assert_eq!(coupling::<f32>(0, 0), 1.0);
    }
}
