//! Maps to be coded.

use proptest::collection::vec;
use proptest::prelude::*;

/// A binary map of `len` values: long runs, noise, alternating, one value out of line (first and last among them), constant.
pub fn run_map(len: usize) -> BoxedStrategy<Vec<bool>> {
    let longest = (len / 4).max(1);
    let runs = (any::<bool>(), vec(1..=longest, len / longest + 1..=len + 1)).prop_map(move |(first, runs)| {
        let values = runs.into_iter().enumerate().flat_map(|(i, run)| std::iter::repeat_n((i % 2 == 0) == first, run));
        let mut values: Vec<bool> = values.take(len).collect();
        values.resize(len, first);
        values
    });
    let last = len.saturating_sub(1);
    let place = prop_oneof![Just(0), Just(last), 0..=last];
    let odd_one = (place, any::<bool>()).prop_map(move |(at, value)| (0..len).map(|i| (i == at) == value).collect());
    prop_oneof![
        4 => runs,
        2 => vec(any::<bool>(), len),
        1 => any::<bool>().prop_map(move |first| (0..len).map(|i| (i % 2 == 0) == first).collect()),
        2 => odd_one,
        1 => any::<bool>().prop_map(move |value| std::vec![value; len]),
    ]
    .boxed()
}

/// A map of `len` levels from 0 to `top`: [`run_map`]s of two levels, and noise.
pub fn level_map(len: usize, top: u8) -> impl Strategy<Value = Vec<u8>> {
    let two = (run_map(len), 0..=top, 0..=top);
    prop_oneof![two.prop_map(|(map, a, b)| map.into_iter().map(|v| if v { a } else { b }).collect()), vec(0..=top, len),]
}
