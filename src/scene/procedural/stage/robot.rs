//! A robot of twelve rigid parts: the bones of a figure in boxes and rods, a pelvis and a pack on its back.

use nalgebra::{Isometry3, Vector3};

use super::super::builder::Builder;
use super::{Plan, figure};

pub(super) fn plan(phase: f64) -> Plan {
    let mut plan = Plan::new([2.4, 1.8, 3.7], [0.0, 0.85, 0.0]);
    plan.ground(2.0);
    let bones = figure::bones(phase);
    let arm: fn(&mut Builder, f64) = |builder, spacing| {
        builder.cuboid([-0.05, -0.27, -0.05], [0.05, 0.02, 0.05], spacing);
        builder.rod([[-0.065, 0.0, 0.0], [0.065, 0.0, 0.0]], [0.045; 2], spacing);
    };
    let leg: fn(&mut Builder, f64) = |builder, spacing| {
        builder.cuboid([-0.07, -0.4, -0.07], [0.07, 0.02, 0.07], spacing);
        builder.rod([[-0.085, 0.0, 0.0], [0.085, 0.0, 0.0]], [0.06; 2], spacing);
    };
    let (arm, leg) = (plan.shape(arm), plan.shape(leg));
    plan.add("torso", bones[0], |builder, spacing| {
        builder.cuboid([-0.2, 0.08, -0.12], [0.2, 0.54, 0.12], spacing);
        builder.rod([[0.0, 0.05, 0.0], [0.0, 0.08, 0.0]], [0.07; 2], spacing);
    });
    plan.add("pelvis", bones[0] * Isometry3::translation(0.0, -0.06, 0.0), |builder, spacing| {
        builder.cuboid([-0.17, -0.05, -0.1], [0.17, 0.1, 0.1], spacing);
    });
    plan.add("head", bones[1], |builder, spacing| {
        builder.rod([[0.0, -0.02, 0.0], [0.0, 0.08, 0.0]], [0.04; 2], spacing);
        builder.cuboid([-0.11, 0.08, -0.1], [0.11, 0.3, 0.1], spacing);
        builder.rod([[0.07, 0.3, 0.0], [0.09, 0.44, 0.0]], [0.008; 2], spacing);
        builder.sphere([0.09, 0.45, 0.0], 0.02, spacing);
    });
    plan.add("pack", bones[0] * Isometry3::new(Vector3::new(0.0, 0.3, -0.2), Vector3::zeros()), |builder, spacing| {
        builder.cuboid([-0.13, -0.16, -0.075], [0.13, 0.16, 0.075], spacing);
    });
    let limbs = [
        ("left upper arm", arm, 2),
        ("left forearm", arm, 3),
        ("right upper arm", arm, 4),
        ("right forearm", arm, 5),
        ("left thigh", leg, 6),
        ("left shin", leg, 7),
        ("right thigh", leg, 8),
        ("right shin", leg, 9),
    ];
    limbs.into_iter().for_each(|(name, shape, bone)| plan.place(name, shape, bones[bone]));
    plan
}
