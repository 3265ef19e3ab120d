//! A temple of flat faces.

use nalgebra::{Isometry3, Vector3};

use super::Plan;

pub(super) fn plan() -> Plan {
    let mut plan = Plan::new([7.5, 4.2, 9.5], [0.0, 1.6, 0.0]);
    plan.ground(7.0);
    plan.add("steps", Isometry3::identity(), |builder, spacing| {
        for (k, [x, z]) in [[3.6, 2.7], [3.3, 2.4], [3.0, 2.1]].into_iter().enumerate() {
            let y = 0.22 * k as f64;
            builder.cuboid([-x, y, -z], [x, y + 0.22, z], spacing);
        }
    });
    let column = plan.shape(|builder, spacing| {
        builder.cuboid([-0.22, 0.0, -0.22], [0.22, 0.12, 0.22], 0.7 * spacing);
        builder.cuboid([-0.15, 0.12, -0.15], [0.15, 2.38, 0.15], 0.7 * spacing);
        builder.cuboid([-0.22, 2.38, -0.22], [0.22, 2.5, 0.22], 0.7 * spacing);
    });
    // Six along each long side and two more at each short one.
    let places = (0..6).flat_map(|i| {
        let x = -2.6 + 1.04 * f64::from(i);
        [[x, -1.7], [x, 1.7]]
    });
    let ends = [-2.6, 2.6].into_iter().flat_map(|x| [[x, -0.57], [x, 0.57]]);
    for [x, z] in places.chain(ends) {
        plan.place("column", column, Isometry3::translation(x, 0.66, z));
    }
    plan.add("roof", Isometry3::from(Vector3::new(0.0, 3.16, 0.0)), |builder, spacing| {
        builder.cuboid([-2.95, 0.0, -2.05], [2.95, 0.2, 2.05], spacing);
        builder.cuboid([-3.15, 0.2, -2.25], [3.15, 0.42, 2.25], spacing);
    });
    plan
}
