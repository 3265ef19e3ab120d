//! A table with chairs and a railing behind: thin shadow casters. Metres.

use super::builder::Builder;

pub(super) fn tessellate(builder: &mut Builder, spacing: f64) {
    builder.part(0);
    builder.floor(1.7, 0.08, 0.85 * spacing);
    builder.part(1);
    builder.cuboid([-0.75, 0.7, -0.42], [0.75, 0.74, 0.42], spacing);
    for [x, z] in [[-0.68, -0.35], [0.68, -0.35], [-0.68, 0.35], [0.68, 0.35]] {
        builder.rod([[x, 0.0, z], [x, 0.7, z]], [0.022, 0.034], spacing);
    }
    builder.part(2);
    chair(builder, spacing, [-0.3, 0.72], [1.0, 0.0]);
    chair(builder, spacing, [1.0, -0.05], [0.28, 0.96]);
    builder.part(3);
    railing(builder, spacing);
    builder.part(4);
    builder.sphere([-0.12, 0.74 + 0.09, 0.02], 0.09, 0.7 * spacing);
    builder.sphere([0.09, 0.74 + 0.065, 0.1], 0.065, 0.7 * spacing);
    builder.sphere([0.06, 0.74 + 0.05, -0.07], 0.05, 0.7 * spacing);
}

/// A chair at (x, z) that looks along −z, turned by (cos, sin) about +y.
fn chair(builder: &mut Builder, spacing: f64, at: [f64; 2], turn: [f64; 2]) {
    let place = |x: f64, y: f64, z: f64| [at[0] + x * turn[0] + z * turn[1], y, at[1] - x * turn[1] + z * turn[0]];
    // The seat: slats across, so that light falls through.
    for k in 0..5 {
        let z = -0.18 + 0.09 * f64::from(k);
        builder.rod([place(-0.2, 0.44, z), place(0.2, 0.44, z)], [0.03; 2], spacing);
    }
    for x in [-0.19, 0.19] {
        builder.rod([place(x, 0.0, -0.18), place(x, 0.43, -0.18)], [0.014, 0.02], spacing);
        builder.rod([place(x, 0.0, 0.22), place(x, 0.92, 0.25)], [0.014, 0.018], spacing);
    }
    for k in 0..3 {
        let (y, z) = (0.6 + 0.13 * f64::from(k), 0.238 + 0.005 * f64::from(k));
        builder.rod([place(-0.19, y, z), place(0.19, y, z)], [0.016; 2], spacing);
    }
}

/// Two rails along x, and balusters.
fn railing(builder: &mut Builder, spacing: f64) {
    let z = -1.15;
    for (y, radius) in [(0.95, 0.03), (0.1, 0.018)] {
        builder.rod([[-1.45, y, z], [1.45, y, z]], [radius; 2], spacing);
    }
    for k in 0..11 {
        let x = -1.4 + 0.28 * f64::from(k);
        let radius = if k % 5 == 0 { 0.026 } else { 0.011 };
        let foot = if k % 5 == 0 { 0.0 } else { 0.1 };
        builder.rod([[x, foot, z], [x, 0.95, z]], [radius; 2], spacing);
    }
}
