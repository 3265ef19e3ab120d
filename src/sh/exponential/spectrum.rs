//! Functions of the product matrix by its eigenvectors.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::ONE;
use crate::sh::Product;
use crate::{Error, Result};

/// Eigenvalues and eigenvectors of a product matrix M_f, and functions of it.
///
/// ```math
/// M_f = Rᵀ D R,  h(M_f) v = Rᵀ h(D) R v                       [Sun 2008, eqs. 5.30–5.33]
/// ```
///
/// h(M_f)·1 is the limit of the product series of h ([`ProductSeries`](super::ProductSeries)) for every analytic h: eq.
/// 5.31 is exp(M_f)·1, eq. 5.33 is log(M_g)·1. The eigenvalues are within the range of f over the sphere, and h is only
/// ever asked for these.
///
/// Accuracy: checked at construction, ‖M − RᵀDR‖ ≤ 1e-12 ‖M‖. Allocates: for precomputation. Cost: about 10 bands⁶
/// operations; an expansion about an axis is better served by
/// [`Logarithm::apply_zonal`](super::Logarithm::apply_zonal).
///
/// # Example
/// ```
/// use haarmonic::sh::{Product, ProductSpectrum};
/// let f = [-1.0, 0.3, 0.0, 0.2];
/// let spectrum = ProductSpectrum::new(&Product::new(2, 2, 2)?, &f)?;
/// let again = spectrum.apply(|x| x); // M_f 1 = f
/// assert!(again.iter().zip(f).all(|(a, b)| (a - b).abs() < 1e-14));
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ProductSpectrum {
    eigen: SymmetricEigen<f64, nalgebra::Dyn>,
}

impl ProductSpectrum {
    /// The spectrum of M_f; `product` is that of equal bands.
    ///
    /// # Errors
    /// [`Error::Length`] if the product's three numbers of bands differ or `f.len()` is not their square,
    /// [`Error::NotFinite`] if f has NaN or infinity, [`Error::OutOfRange`] if the decomposition does not converge to
    /// the stated accuracy.
    pub fn new(product: &Product<f64>, f: &[f64]) -> Result<Self> {
        let [bands, second, out] = product.bands();
        for other in [second, out] {
            if other != bands {
                return Err(Error::Length { what: "bands of the product", expected: bands, got: other });
            }
        }
        let size = bands * bands;
        check_input("expansion", size, f)?;
        let mut matrix = vec![0.0; size * size];
        product.matrix(f, &mut matrix);
        Ok(Self { eigen: decompose(DMatrix::from_row_slice(size, size, &matrix))? })
    }

    /// The eigenvalues, in no order.
    pub fn eigenvalues(&self) -> &[f64] {
        self.eigen.eigenvalues.as_slice()
    }

    /// The largest eigenvalue.
    pub fn largest(&self) -> f64 {
        self.eigen.eigenvalues.max()
    }

    /// h(M_f)·1.
    pub fn apply(&self, h: impl Fn(f64) -> f64) -> Vec<f64> {
        let scaled = self.eigen.eigenvalues.map(h).component_mul(&self.eigen.eigenvectors.row(0).transpose()) * ONE;
        (&self.eigen.eigenvectors * scaled).as_slice().to_vec()
    }

    /// h(M_f) v.
    ///
    /// # Panics
    /// If `v.len()` is not bands².
    #[track_caller]
    pub fn multiply(&self, h: impl Fn(f64) -> f64, v: &[f64]) -> Vec<f64> {
        crate::error::check_length("expansion", self.eigen.eigenvalues.len(), v.len());
        apply(&self.eigen, h, v)
    }
}

pub(super) fn check_input(what: &'static str, expected: usize, values: &[f64]) -> Result<()> {
    if values.len() != expected {
        return Err(Error::Length { what, expected, got: values.len() });
    }
    match values.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(Error::NotFinite { what, index }),
        None => Ok(()),
    }
}

/// Rᵀ h(D) R v.
pub(super) fn apply(eigen: &SymmetricEigen<f64, nalgebra::Dyn>, h: impl Fn(f64) -> f64, v: &[f64]) -> Vec<f64> {
    let turned = eigen.eigenvectors.tr_mul(&DVector::from_column_slice(v));
    (&eigen.eigenvectors * turned.component_mul(&eigen.eigenvalues.map(h))).as_slice().to_vec()
}

/// The largest eigenvalue of a symmetric matrix, with the bits that [`decompose`] gives it in a tenth of its time.
pub(super) fn largest_eigenvalue(matrix: DMatrix<f64>) -> Result<f64> {
    let (unit, scale) = scaled_to_one(matrix)?;
    Ok(unit.symmetric_eigenvalues().max() * scale)
}

/// A matrix over its largest entry, and that: the library's shifts square the entries.
fn scaled_to_one(matrix: DMatrix<f64>) -> Result<(DMatrix<f64>, f64)> {
    let largest = matrix.amax();
    // Of NaN or infinity no iteration would end.
    if !matrix.iter().all(|x| x.is_finite()) {
        return Err(no_eigenvectors());
    }
    let scale = if largest > 0.0 { largest } else { 1.0 };
    Ok((matrix.unscale(scale), scale))
}

fn no_eigenvectors() -> Error {
    Error::OutOfRange {
        what: "residual of the eigenvectors of a product matrix",
        got: f64::INFINITY,
        allowed: "at most 1e-12 of the matrix",
    }
}

/// The decomposition of a symmetric matrix, checked by composing it again.
pub(super) fn decompose(matrix: DMatrix<f64>) -> Result<SymmetricEigen<f64, nalgebra::Dyn>> {
    const STEPS: usize = 1000;
    let (unit, scale) = scaled_to_one(matrix)?;
    let mut eigen = SymmetricEigen::try_new(unit.clone(), f64::EPSILON, STEPS).ok_or_else(no_eigenvectors)?;
    let residual = (eigen.recompose() - &unit).amax();
    if !(residual <= 1e-12) {
        return Err(no_eigenvectors());
    }
    eigen.eigenvalues *= scale;
    Ok(eigen)
}
