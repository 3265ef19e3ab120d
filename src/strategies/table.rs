//! Binary maps as visibility has them, and rectangles.

use proptest::prelude::*;

use crate::table::{Outside, Rectangle};

/// A binary map of width × height pixels, row-major: half-planes, wedges, disks, stripes, noise dense and sparse, a
/// single pixel, or all alike; each of them or its negative.
pub fn visibility_map(width: usize, height: usize) -> BoxedStrategy<Vec<bool>> {
    let size = [width as f64, height as f64];
    let fill = move |inside: Box<dyn Fn(f64, f64) -> bool>| -> Vec<bool> {
        (0..width * height).map(|i| inside((i % width) as f64 + 0.5, (i / width) as f64 + 0.5)).collect()
    };
    let point = (-0.25..1.25, -0.25..1.25).prop_map(move |(x, y): (f64, f64)| [x * size[0], y * size[1]]);
    let angle = 0.0..std::f64::consts::TAU;
    let side = |[x, y]: [f64; 2], angle: f64| move |u: f64, v: f64| (u - x) * angle.cos() + (v - y) * angle.sin() > 0.0;
    let half_plane = (point.clone(), angle.clone()).prop_map(move |(p, a)| fill(Box::new(side(p, a))));
    let wedge = (point.clone(), angle.clone(), angle.clone()).prop_map(move |(p, a, b)| {
        let (one, other) = (side(p, a), side(p, b));
        fill(Box::new(move |u, v| one(u, v) && other(u, v)))
    });
    let disk = (point.clone(), 0.0..1.0).prop_map(move |([x, y], r): ([f64; 2], f64)| {
        let radius = r * size[0].max(size[1]);
        fill(Box::new(move |u, v| (u - x).hypot(v - y) < radius))
    });
    let stripes = (angle, 1.0..8.0).prop_map(move |(a, period): (f64, f64)| {
        fill(Box::new(move |u, v| ((u * a.cos() + v * a.sin()) / period).rem_euclid(1.0) < 0.5))
    });
    let noise = prop::sample::select(vec![0.5, 0.1, 0.01])
        .prop_flat_map(move |p| proptest::collection::vec(proptest::bool::weighted(p), width * height));
    let single = (0..(width * height).max(1)).prop_map(move |at| (0..width * height).map(|i| i == at).collect());
    let uniform = Just(vec![false; width * height]);
    let map = prop_oneof![2 => half_plane, 2 => wedge, 2 => disk, 1 => stripes, 3 => noise, 1 => single, 1 => uniform];
    (map, any::<bool>()).prop_map(|(map, flip)| map.into_iter().map(|v| v != flip).collect::<Vec<bool>>()).boxed()
}

/// A rectangle over an image of width × height: on pixels or between them, inside or partly outside, empty or inverted.
pub fn rectangle(width: usize, height: usize) -> impl Strategy<Value = Rectangle> + Clone {
    let bound = |size: usize| {
        let n = size as i32;
        prop_oneof![
            (0..=n).prop_map(f64::from),
            (-n - 1..=2 * n + 1).prop_map(f64::from),
            -0.5 * f64::from(n)..1.5 * f64::from(n) + 1.0
        ]
    };
    let (x, y) = (bound(width), bound(height));
    (x.clone(), y.clone(), x, y).prop_map(|(left, top, right, bottom)| Rectangle { left, top, right, bottom })
}

/// Either of the two.
pub fn outside() -> impl Strategy<Value = Outside> + Clone {
    prop::sample::select(vec![Outside::Zero, Outside::Wrap])
}
