//! Affine maps, with the edges where a transformed wavelet meets another; compressed images.

use proptest::prelude::*;

use super::haar::sparse_vector;
use crate::Real;
use crate::affine::{AffineMap, WaveletImage};

fn map((scale, offset): (f64, f64)) -> AffineMap {
    AffineMap::new(scale, offset).expect("the strategy stays in range")
}

fn signed(magnitude: impl Strategy<Value = f64>) -> impl Strategy<Value = f64> {
    (any::<bool>(), magnitude).prop_map(|(negative, x)| if negative { -x } else { x })
}

/// Any map: the identity and the mirror; scales of ordinary size, tiny, huge and at the ends of what is allowed; dyadic
/// numbers ([`dyadic_map`]); sources that fall outside [0, 1], or touch it at a point.
pub fn affine_map() -> BoxedStrategy<AffineMap> {
    // The source point x is seen at v, so that something is there to be seen.
    let aimed = |logs: std::ops::Range<f64>| {
        (signed(logs.prop_map(f64::exp2)), 0.0..1.0f64, 0.0..1.0f64).prop_map(|(s, x, v)| map((s, x - s * v)))
    };
    let ordinary = (signed(0.1..4.0f64), -3.0..3.0f64).prop_map(map);
    let ends = (signed(prop_oneof![Just(1e-100), Just(1e100)]), prop_oneof![Just(0.0), Just(0.5), signed(Just(1e100))]);
    let outside = (signed(0.1..4.0f64), any::<bool>(), 0.0..2.0f64).prop_map(|(s, beyond, gap)| {
        // s·[0, 1] + o lies beyond 1 or before 0.
        map((s, if beyond { 1.0 - s.min(0.0) + gap } else { -s.max(0.0) - gap }))
    });
    prop_oneof![
        1 => Just(AffineMap::IDENTITY),
        1 => Just(map((-1.0, 1.0))),
        3 => ordinary,
        3 => aimed(-2.0..2.0),
        1 => aimed(-20.0..-4.0),
        1 => aimed(4.0..20.0),
        1 => ends.prop_map(map),
        3 => dyadic_map(),
        1 => outside,
        1 => touching(),
    ]
    .boxed()
}

/// A map whose scale and offset have few binary places, so that breakpoints coincide and `f64` is exact: |s| = m/2^k in
/// [2^−6, 16], o a multiple of 2^−k.
pub fn dyadic_map() -> BoxedStrategy<AffineMap> {
    let coarse = (signed((1..=16i32).prop_map(f64::from)), -64..=64i32, 0..=6i32).prop_map(|(m, n, places)| {
        let unit = (-f64::from(places)).exp2();
        map((m * unit, f64::from(n) * unit))
    });
    prop_oneof![4 => coarse, 1 => touching()].boxed()
}

/// A map of dyadic numbers under which the target [0, 1] and the source have an end in common and nothing else.
fn touching() -> impl Strategy<Value = AffineMap> {
    (signed((1..=64i32).prop_map(|m| f64::from(m) / 16.0)), any::<bool>()).prop_map(|(s, beyond)| {
        // s·[0, 1] + o begins at 1 or ends at 0.
        map((s, if beyond { 1.0 - s.min(0.0) } else { -s.max(0.0) }))
    })
}

/// A compressed image of 1 to `max_side` pixels a side, powers of two or not, with at most `max_terms` terms of
/// ordinary size in each of its channels; a term may be 0 in some of them.
pub fn wavelet_image<T: Real, const C: usize>(
    max_side: usize,
    max_terms: usize,
) -> impl Strategy<Value = WaveletImage<T, C>> {
    let side = 1..=max_side.max(1);
    (side.clone(), side).prop_flat_map(move |(width, height)| {
        let area = width.next_power_of_two() * height.next_power_of_two();
        let channels = proptest::collection::vec(sparse_vector(area, max_terms), C);
        channels.prop_map(move |channels| {
            let channels = std::array::from_fn(|c| &channels[c]);
            WaveletImage::from_sparse([width, height], channels).expect("the vectors have the grid's area")
        })
    })
}
