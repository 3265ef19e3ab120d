//! A trefoil tube that stands on a floor.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::builder::{Builder, Ends};

/// Radius of the torus, radius of its winding, radius of the tube.
const SHAPE: [f64; 3] = [0.86, 0.42, 0.2];

/// How far the tube sinks into the floor, so that no light passes beneath.
const SUNK: f64 = 0.012;

pub(super) fn tessellate(builder: &mut Builder, spacing: f64) {
    builder.part(0);
    builder.floor(2.3, 0.12, 1.15 * spacing);
    builder.part(1);
    let lowest = (0..4096).map(|i| curve(i as f64 / 4096.0).y).fold(f64::INFINITY, f64::min);
    let lift = Vector3::y() * (SHAPE[2] - SUNK - lowest);
    let length: f64 = (0..256).map(|i| (curve((i + 1) as f64 / 256.0) - curve(i as f64 / 256.0)).norm()).sum();
    let around = ((TAU * SHAPE[2] / spacing).round() as usize).max(6);
    let along = ((length / spacing).round() as usize).max(24);
    builder.grid([around, along], [Ends::Joined; 2], |u, v| {
        let [_, normal, binormal] = frame(v);
        let out = normal * (TAU * u).cos() + binormal * (TAU * u).sin();
        (curve(v) + lift + out * SHAPE[2], out)
    });
}

/// The (2, 3) torus knot around the z axis.
fn curve(t: f64) -> Vector3<f64> {
    let (s3, c3) = (3.0 * TAU * t).sin_cos();
    let (s2, c2) = (2.0 * TAU * t).sin_cos();
    let r = SHAPE[0] + SHAPE[1] * c3;
    // Turned so that it stands on two of its three loops.
    Vector3::new(r * s2, r * c2, SHAPE[1] * s3)
}

/// Tangent, normal, binormal. The knot's curvature has no zero, so that Frenet's frame closes.
fn frame(t: f64) -> [Vector3<f64>; 3] {
    const STEP: f64 = 1e-4;
    let (before, here, after) = (curve(t - STEP), curve(t), curve(t + STEP));
    let tangent = (after - before).normalize();
    let bend = after + before - here * 2.0;
    let normal = (bend - tangent * tangent.dot(&bend)).normalize();
    [tangent, normal, tangent.cross(&normal)]
}
