//! Functions, by quadrature of the sphere.

use nalgebra::UnitVector3;

use crate::sh::Basis;
use crate::sphere::SphereQuadrature;
use crate::{Real, Result};

/// The coefficients ∫ f y_i of a function, `bands`² of them.
///
/// Exact up to rounding where f is a spherical polynomial of degree d and `rule` is exact to degree d + bands − 1; an
/// expansion of `b` bands has d = b − 1. For other functions the error is that of the rule: aliasing of what f has
/// above that degree.
///
/// Accuracy: 1e-14 of the largest coefficient for expansions of up to 20 bands; `f32` results are those of `f64`,
/// narrowed.
/// Cost: a call of f a point of the rule, and 2.5·bands² multiplications.
///
/// # Errors
/// As [`Basis::new`], for `f64`.
///
/// # Example
/// ```
/// use haarmonic::{sh::project_fn, sphere::SphereQuadrature};
/// // z² = √(4π)/3 y₀₀ + √(16π/45) y₂₀, of degree 2; onto 3 bands.
/// let c: Vec<f64> = project_fn(3, &SphereQuadrature::new(4)?, |d| d.z * d.z)?;
/// let pi = std::f64::consts::PI;
/// assert!((c[0] - (4.0 * pi).sqrt() / 3.0).abs() < 1e-14 && (c[6] - (16.0 * pi / 45.0).sqrt()).abs() < 1e-14);
/// # Ok::<(), haarmonic::Error>(())
/// ```
pub fn project_fn<T: Real>(
    bands: usize,
    rule: &SphereQuadrature,
    mut f: impl FnMut(&UnitVector3<f64>) -> f64,
) -> Result<Vec<T>> {
    let [c] = project_fn_channels(bands, rule, |d| [f(d)])?;
    Ok(c)
}

/// [`project_fn`] of `C` channels at once, such as RGB.
///
/// # Errors
/// As [`Basis::new`], for `f64`.
pub fn project_fn_channels<T: Real, const C: usize>(
    bands: usize,
    rule: &SphereQuadrature,
    mut f: impl FnMut(&UnitVector3<f64>) -> [f64; C],
) -> Result<[Vec<T>; C]> {
    let basis = Basis::<f64>::new(bands)?;
    let mut weighted: [Vec<f64>; C] = std::array::from_fn(|_| Vec::with_capacity(rule.weights().len()));
    for (d, w) in rule.directions().iter().zip(rule.weights()) {
        for (weighted, value) in weighted.iter_mut().zip(f(d)) {
            weighted.push(w * value);
        }
    }
    Ok(accumulate(&basis, &components(rule.directions()), &weighted).map(|c| c.into_iter().map(T::of).collect()))
}

/// Σ w y_i for each channel of weights.
pub(super) fn accumulate<const C: usize>(
    basis: &Basis<f64>,
    d: &[Vec<f64>; 3],
    weights: &[Vec<f64>; C],
) -> [Vec<f64>; C] {
    let mut out: [Vec<f64>; C] = std::array::from_fn(|_| vec![0.0; basis.coefficient_count()]);
    basis.accumulate(&d[0], &d[1], &d[2], weights.each_ref().map(|w| &w[..]), out.each_mut().map(|o| &mut o[..]));
    out
}

/// x, y and z apart.
pub(super) fn components(directions: &[UnitVector3<f64>]) -> [Vec<f64>; 3] {
    [0, 1, 2].map(|k| directions.iter().map(|d| d[k]).collect())
}
