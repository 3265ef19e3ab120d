//! A street between houses, three pairs of lamps along it.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Vector3};

use super::Plan;
use crate::Result;
use crate::scene::{LocalLight, SpotLight};

pub(super) fn plan() -> Result<Plan> {
    let mut plan = Plan::new([0.6, 1.9, 13.5], [-0.4, 2.2, 0.0]);
    plan.ground(14.0);
    let house = |plan: &mut Plan, name: &'static str, x: f64, z: f64, size: [f64; 3]| {
        let [width, height, depth] = size;
        plan.add(name, Isometry3::translation(x, 0.0, z), move |builder, spacing| {
            builder.cuboid([-0.5 * width, 0.0, -0.5 * depth], [0.5 * width, height, 0.5 * depth], 2.0 * spacing);
            // A ledge under the roof, and a chimney.
            builder.cuboid(
                [-0.5 * width - 0.15, height, -0.5 * depth - 0.15],
                [0.5 * width + 0.15, height + 0.25, 0.5 * depth + 0.15],
                2.0 * spacing,
            );
            builder.cuboid([0.2, height + 0.25, -0.3], [0.7, height + 1.2, 0.3], spacing);
        });
    };
    house(&mut plan, "left house", -6.2, 2.5, [4.5, 5.5, 8.0]);
    house(&mut plan, "far left house", -6.4, -7.0, [4.5, 7.0, 8.0]);
    house(&mut plan, "right house", 6.2, 1.0, [4.5, 6.2, 9.0]);
    house(&mut plan, "far right house", 6.0, -8.5, [4.0, 5.0, 7.0]);
    let lamp = plan.shape(|builder, spacing| {
        builder.rod([[0.0, 0.0, 0.0], [0.0, 0.3, 0.0]], [0.12, 0.1], 0.7 * spacing);
        builder.rod([[0.0, 0.3, 0.0], [0.0, 3.4, 0.0]], [0.06, 0.045], 0.7 * spacing);
        builder.rod([[0.0, 3.36, 0.0], [0.75, 3.5, 0.0]], [0.035; 2], 0.7 * spacing);
        builder.rod([[0.75, 3.5, 0.0], [0.75, 3.62, 0.0]], [0.2, 0.06], 0.5 * spacing);
    });
    for z in [5.0, -1.0, -7.0] {
        for (name, x, turn) in [("left lamp", -2.6, 0.0), ("right lamp", 2.6, PI)] {
            let pose = Isometry3::new(Vector3::new(x, 0.0, z), Vector3::y() * turn);
            plan.place(name, lamp, pose);
            // Just below the shade.
            let at = pose * nalgebra::Point3::new(0.75, 3.45, 0.0);
            let light = SpotLight::spot(at.coords, -Vector3::y_axis(), Vector3::new(30.0, 22.0, 12.0), 0.7, 1.3)?;
            plan.lights.push(LocalLight::Spot(light));
        }
    }
    Ok(plan)
}
