//! Expansions in spherical harmonics.

use proptest::collection::vec;
use proptest::prelude::*;

use crate::Real;

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
