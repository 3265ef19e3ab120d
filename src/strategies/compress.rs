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

/// A binary map of `width` × `height` pixels, row-major, as occluders make them: unions of half-planes, discs and thin
/// sticks hide parts of a map of ones; all and nothing hidden among them.
pub fn visibility_map(width: usize, height: usize) -> impl Strategy<Value = Vec<bool>> {
    let (w, h) = (width as f64, height as f64);
    let at = (0.0..w, 0.0..h, 0.0..std::f64::consts::TAU);
    let edge = prop_oneof![Just(Shape::HalfPlane), (0.5..2.0).prop_map(Shape::Stick)];
    let shape = prop_oneof![2 => edge, 1 => (0.0..w.hypot(h) / 2.0).prop_map(Shape::Disc)];
    vec((at, shape), 0..4).prop_map(move |occluders| {
        let seen = |x: f64, y: f64| {
            !occluders.iter().any(|((x0, y0, angle), shape)| {
                let (dx, dy) = (x - x0, y - y0);
                let along = dx * angle.cos() + dy * angle.sin();
                match *shape {
                    Shape::HalfPlane => along > 0.0,
                    Shape::Stick(width) => along.abs() <= 0.5 * width,
                    Shape::Disc(radius) => dx.hypot(dy) <= radius,
                }
            })
        };
        (0..width * height).map(|i| seen((i % width) as f64 + 0.5, (i / width) as f64 + 0.5)).collect()
    })
}

/// What hides.
#[derive(Debug, Clone, Copy)]
enum Shape {
    HalfPlane,
    Stick(f64),
    Disc(f64),
}

/// A map of `len` levels from 0 to `top`: [`run_map`]s of two levels, and noise.
pub fn level_map(len: usize, top: u8) -> impl Strategy<Value = Vec<u8>> {
    let two = (run_map(len), 0..=top, 0..=top);
    prop_oneof![two.prop_map(|(map, a, b)| map.into_iter().map(|v| if v { a } else { b }).collect()), vec(0..=top, len),]
}
