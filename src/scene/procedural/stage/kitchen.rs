//! A kitchen table, set, under a lamp with a pattern.

use nalgebra::{Isometry3, Vector3};

use super::Plan;
use crate::Result;
use crate::scene::{LocalLight, RectangleLight};

/// The height of the table's top.
const TOP: f64 = 0.74;

pub(super) fn plan() -> Result<Plan> {
    let mut plan = Plan::new([1.25, 1.75, 1.9], [0.0, 0.7, 0.0]);
    plan.ground(1.6);
    plan.add("table", Isometry3::identity(), |builder, spacing| {
        builder.cuboid([-0.7, TOP - 0.04, -0.45], [0.7, TOP, 0.45], spacing);
        for [x, z] in [[-0.63, -0.38], [0.63, -0.38], [-0.63, 0.38], [0.63, 0.38]] {
            builder.rod([[x, 0.0, z], [x, TOP - 0.04, z]], [0.024, 0.034], spacing);
        }
    });
    let on_top = |x: f64, z: f64, turn: f64| Isometry3::new(Vector3::new(x, TOP, z), Vector3::y() * turn);
    plan.add("pot", on_top(-0.22, -0.1, 0.6), |builder, spacing| {
        builder.rod([[0.0, 0.0, 0.0], [0.0, 0.02, 0.0]], [0.075; 2], spacing);
        builder.sphere([0.0, 0.11, 0.0], 0.105, 0.7 * spacing);
        builder.rod([[0.08, 0.1, 0.0], [0.19, 0.18, 0.0]], [0.022, 0.013], 0.5 * spacing);
        builder.sphere([0.0, 0.225, 0.0], 0.018, 0.5 * spacing);
        for (from, to) in [([-0.09, 0.16, 0.0], [-0.16, 0.15, 0.0]), ([-0.16, 0.15, 0.0], [-0.15, 0.06, 0.0])] {
            builder.rod([from, to], [0.011; 2], 0.5 * spacing);
        }
    });
    plan.add("mug", on_top(0.26, 0.16, -0.4), |builder, spacing| {
        builder.rod([[0.0, 0.0, 0.0], [0.0, 0.095, 0.0]], [0.038, 0.041], 0.6 * spacing);
        for (from, to) in [
            ([0.036, 0.08, 0.0], [0.066, 0.072, 0.0]),
            ([0.066, 0.072, 0.0], [0.066, 0.03, 0.0]),
            ([0.066, 0.03, 0.0], [0.036, 0.022, 0.0]),
        ] {
            builder.rod([from, to], [0.006; 2], 0.4 * spacing);
        }
    });
    plan.add("plate", on_top(0.12, -0.18, 0.0), |builder, spacing| {
        builder.rod([[0.0, 0.0, 0.0], [0.0, 0.012, 0.0]], [0.07, 0.12], 0.6 * spacing);
    });
    plan.add("apple", on_top(0.1, -0.17, 0.0) * Isometry3::translation(0.0, 0.012, 0.0), |builder, spacing| {
        builder.sphere([0.0, 0.037, 0.0], 0.037, 0.5 * spacing);
        builder.rod([[0.0, 0.07, 0.0], [0.006, 0.092, 0.0]], [0.003; 2], 0.3 * spacing);
    });
    // A pattern of eight by eight: warm and cool fields, one dark quarter.
    let pixel = |i: usize| {
        let (x, y) = (i % 8, i / 8);
        match (x < 4, y < 4, (x + y) % 2 == 0) {
            (true, true, _) => Vector3::new(0.5, 0.6, 0.8),
            (_, _, true) => Vector3::new(14.0, 10.0, 6.0),
            (_, _, false) => Vector3::new(3.0, 4.0, 7.0),
        }
    };
    let (centre, u, v) = (Vector3::new(0.05, 1.7, 0.0), Vector3::x() * 0.35, Vector3::z() * 0.35);
    plan.lights.push(LocalLight::Rectangle(RectangleLight::new(centre, u, v, 8, (0..64).map(pixel).collect())?));
    Ok(plan)
}
