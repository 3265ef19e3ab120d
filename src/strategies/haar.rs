//! Signals, images and sparse vectors.

use proptest::collection::vec;
use proptest::prelude::*;

use crate::Real;
use crate::haar::SparseVector;

/// 1, 2, 4, … up to 2^`max_log`.
pub fn power_of_two(max_log: u32) -> impl Strategy<Value = usize> + Clone {
    (0..=max_log).prop_map(|log| 1 << log)
}

/// A signal of `len` samples: ordinary numbers in [−1, 1], high dynamic range, huge, tiny, binary, constant, one-hot or
/// zero.
///
/// Huge is up to 2^−24 of the largest number, so that sums of a test still fit; tiny down to the smallest normal one.
pub fn signal<T: Real>(len: usize) -> BoxedStrategy<Vec<T>> {
    let unit = || vec((-1.0..1.0).prop_map(T::of), len);
    let times = move |factor: T| unit().prop_map(move |x| x.into_iter().map(|x| x * factor).collect::<Vec<T>>());
    let huge = T::max_value() * T::of(2.0f64.powi(-24));
    let tiny = T::min_positive_value() * T::of(16.0);
    let one_hot = (0..len.max(1), -8.0..8.0).prop_map(move |(at, value)| {
        let value = T::of(value);
        (0..len).map(|i| if i == at { value } else { T::zero() }).collect()
    });
    prop_oneof![
        4 => unit(),
        2 => vec((-12.0..12.0_f64).prop_map(|e| T::of(e.exp2())), len),
        2 => vec(any::<bool>().prop_map(|b| if b { T::one() } else { T::zero() }), len),
        1 => times(huge),
        1 => times(tiny),
        1 => (-8.0..8.0_f64).prop_map(move |x| std::vec![T::of(x); len]),
        1 => one_hot,
        1 => Just(std::vec![T::zero(); len]),
    ]
    .boxed()
}

/// A [`signal`] of 1 to 2^`max_log` samples, a power of two.
pub fn haar_signal<T: Real>(max_log: u32) -> impl Strategy<Value = Vec<T>> {
    power_of_two(max_log).prop_flat_map(signal)
}

/// A square image of 1 to 2^`max_log` samples a side, a power of two: (side, row-major samples).
pub fn haar_image<T: Real>(max_log: u32) -> impl Strategy<Value = (usize, Vec<T>)> {
    power_of_two(max_log).prop_flat_map(|size| (Just(size), signal(size * size)))
}

/// A vector of dense length `len` with at most `max_terms` entries of ordinary size, not 0.
pub fn sparse_vector<T: Real>(len: usize, max_terms: usize) -> impl Strategy<Value = SparseVector<T>> {
    let value = prop_oneof![0.01..1.0, -1.0..-0.01_f64].prop_map(T::of);
    let pairs = proptest::collection::btree_map(0..len.max(1), value, 0..=max_terms.min(len));
    pairs.prop_map(move |pairs| SparseVector::from_pairs(len, pairs).expect("indices are below the length"))
}
