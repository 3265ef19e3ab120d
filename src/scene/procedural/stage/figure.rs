//! A figure of ten bones, and what walks like one.
//!
//! Bones hang on each other by ball joints; a walk turns hips, knees, shoulders and elbows about the axis across. The
//! ground is under the lower foot at every phase.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::super::builder::Builder;
use super::Plan;

/// The bones: torso, head, then upper and lower arms and legs, left before right.
const NAMES: [&str; 10] = [
    "torso",
    "head",
    "left upper arm",
    "left forearm",
    "right upper arm",
    "right forearm",
    "left thigh",
    "left shin",
    "right thigh",
    "right shin",
];

/// Spheres on every bone: the torso has more. Sixty in all.
const SPHERES: [usize; 10] = [12, 4, 5, 5, 5, 5, 6, 6, 6, 6];

/// The poses of the bones: each has its joint at its origin and hangs down along −y; the torso rises from the hips, the
/// head from the neck. Metres: hips at .92, shoulders at 1.42.
pub(super) fn bones(phase: f64) -> [Isometry3<f64>; 10] {
    let swing = (TAU * phase).sin();
    let across = |angle: f64| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), angle);
    let joint = |at: [f64; 3], angle: f64| Isometry3::from_parts(Translation3::from(Vector3::from(at)), across(angle));
    let leg = |side: f64, forward: f64| {
        // The leg that swings forward bends its knee.
        let knee = 0.25 + 0.45 * (side * (TAU * phase).cos()).max(0.0);
        let thigh = joint([0.1 * side, 0.0, 0.0], -0.45 * forward);
        [thigh, thigh * joint([0.0, -0.42, 0.0], knee)]
    };
    let arm = |side: f64, forward: f64| {
        let upper = joint([0.22 * side, 0.5, 0.0], -0.5 * forward);
        [upper, upper * joint([0.0, -0.29, 0.0], -0.35 - 0.2 * forward.max(0.0))]
    };
    let (left_arm, right_arm) = (arm(1.0, -swing), arm(-1.0, swing));
    let (left_leg, right_leg) = (leg(1.0, swing), leg(-1.0, -swing));
    let lean = joint([0.0, 0.0, 0.0], 0.04);
    let upper = [lean, joint([0.0, 0.56, 0.0], -0.04)];
    let all = [
        upper[0],
        upper[1],
        left_arm[0],
        left_arm[1],
        right_arm[0],
        right_arm[1],
        left_leg[0],
        left_leg[1],
        right_leg[0],
        right_leg[1],
    ];
    // The lower of the two soles on the ground.
    let sole = |shin: &Isometry3<f64>| (shin * nalgebra::Point3::new(0.0, -0.42, 0.0)).y;
    let lift = Isometry3::translation(0.0, 0.06 - sole(&left_leg[1]).min(sole(&right_leg[1])), 0.0);
    all.map(|pose| lift * pose)
}

/// The ends and radii of a bone's flesh, in its own coordinates.
fn flesh(bone: usize) -> ([f64; 3], [f64; 2]) {
    match bone {
        0 => ([0.0, 0.5, 0.0], [0.15, 0.19]),
        1 => ([0.0, 0.24, 0.0], [0.06, 0.11]),
        2 | 4 => ([0.0, -0.29, 0.0], [0.055, 0.045]),
        3 | 5 => ([0.0, -0.27, 0.0], [0.042, 0.035]),
        6 | 8 => ([0.0, -0.42, 0.0], [0.085, 0.06]),
        _ => ([0.0, -0.42, 0.0], [0.06, 0.05]),
    }
}

fn tessellate(bone: usize, builder: &mut Builder, spacing: f64) {
    let (end, radii) = flesh(bone);
    builder.rod([[0.0; 3], end], radii, spacing);
    builder.sphere([0.0; 3], radii[0], spacing);
    builder.sphere(end, radii[1], spacing);
}

/// The spheres of a bone in its own coordinates: along it, as thick as it is there.
fn spheres(bone: usize) -> impl Iterator<Item = (Vector3<f64>, f64)> {
    let (end, [first, last]) = flesh(bone);
    let count = SPHERES[bone];
    (0..count).map(move |i| {
        let t = i as f64 / (count - 1) as f64;
        (Vector3::from(end) * t, first + (last - first) * t)
    })
}

/// side² figures.
pub(super) fn plan(phase: f64, side: usize) -> Plan {
    let mut plan = if side == 1 {
        Plan::new([2.3, 1.7, 3.6], [0.0, 0.85, 0.0])
    } else {
        Plan::new([6.0, 4.6, 8.2], [0.0, 0.5, 0.0])
    };
    plan.ground(if side == 1 { 2.0 } else { 4.2 });
    let shapes: Vec<usize> = (0..10)
        .map(|bone| plan.shape(move |builder: &mut Builder, spacing| tessellate(bone, builder, spacing)))
        .collect();
    for figure in 0..side * side {
        let place = |i: usize| 1.6 * (i as f64 - 0.5 * (side - 1) as f64);
        let (x, z) = (place(figure % side), place(figure / side));
        // Irrational steps: no two in step, none in a row.
        let turn = if side == 1 { 0.0 } else { TAU * (0.381_966 * figure as f64).fract() };
        let at = Isometry3::new(Vector3::new(x, 0.0, z), Vector3::y() * turn);
        for (bone, pose) in bones(phase + 0.618_034 * figure as f64).into_iter().enumerate() {
            let pose = at * pose;
            plan.place(NAMES[bone], shapes[bone], pose);
            plan.spheres.extend(spheres(bone).map(|(c, r)| ((pose * nalgebra::Point3::from(c)).coords, r)));
        }
    }
    plan
}
