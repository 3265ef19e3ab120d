//! Expansions in spherical harmonics.

use nalgebra::UnitVector3;
use proptest::collection::vec;
use proptest::prelude::*;

use super::direction;
use crate::Real;
use crate::sh::Basis;
use crate::sphere::SphereQuadrature;

/// An expansion of `bands`, bands² coefficients at index l(l+1)+m: ordinary numbers in [−1, 1], smooth (falling as (l+1)⁻²), huge, tiny,
/// one-hot or zero.
///
/// Huge is up to 2^−12 √max, so that products of two are finite; tiny down to the smallest normal number.
pub fn sh_vector<T: Real>(bands: usize) -> BoxedStrategy<Vec<T>> {
    let count = bands * bands;
    let unit = move || vec((-1.0..1.0).prop_map(T::of), count);
    let times = move |factor: T| unit().prop_map(move |c| c.into_iter().map(|c| c * factor).collect::<Vec<T>>());
    let smooth = unit().prop_map(|c: Vec<T>| {
        c.into_iter().enumerate().map(|(i, c)| c * T::of((i.isqrt() as f64 + 1.0).powi(-2))).collect::<Vec<T>>()
    });
    let one_hot = (0..count.max(1), -8.0..8.0).prop_map(move |(at, value)| {
        (0..count).map(|i| if i == at { T::of(value) } else { T::zero() }).collect::<Vec<T>>()
    });
    prop_oneof![
        4 => unit(),
        2 => smooth,
        1 => times(T::max_value().sqrt() * T::of(2f64.powi(-12))),
        1 => times(T::min_positive_value() * T::of(16.0)),
        2 => one_hot,
        1 => Just(std::vec![T::zero(); count]),
    ]
    .boxed()
}

/// Up to `most` discs (axis, half angle): small, middling, a hemisphere, nested and overlapping as it happens, none at all.
pub fn discs(most: usize) -> BoxedStrategy<Vec<(UnitVector3<f64>, f64)>> {
    let angle =
        prop_oneof![4 => 0.05..0.8f64, 1 => 0.8..1.5f64, 1 => Just(std::f64::consts::FRAC_PI_2), 1 => 1e-4..1e-2f64];
    vec((direction(), angle), 0..=most).boxed()
}

/// The coefficients of a function that is 0 within a union of [`discs`] and 1 elsewhere, projected by a rule of 48 rings: what is
/// projected is 0 or 1 at each of its points, so the sums that hold for visibility hold, and its lobes ring below 0 and above 1.
pub fn sh_visibility(bands: usize) -> BoxedStrategy<Vec<f64>> {
    let rule = SphereQuadrature::new(95).expect("a small degree");
    let basis = Basis::<f64>::new(bands).expect("bands from 1");
    discs(8)
        .prop_map(move |discs| {
            let (mut y, mut out) = (vec![0.0; bands * bands], vec![0.0; bands * bands]);
            for (direction, weight) in rule.directions().iter().zip(rule.weights()) {
                if discs.iter().all(|(axis, angle)| axis.dot(direction) < angle.cos()) {
                    basis.eval(direction, &mut y);
                    out.iter_mut().zip(&y).for_each(|(out, y)| *out += weight * y);
                }
            }
            out
        })
        .boxed()
}
