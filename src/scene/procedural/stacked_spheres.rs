//! A pyramid of ten spheres on a floor, and small ones around it.

use std::f64::consts::TAU;

use super::builder::Builder;

const RADIUS: f64 = 0.4;

pub(super) fn tessellate(builder: &mut Builder, spacing: f64) {
    builder.part(0);
    builder.floor(2.4, 0.12, 1.1 * spacing);
    builder.part(1);
    // Rows of a triangular lattice; each layer sits in the hollows of the one below.
    let (row, layer) = (RADIUS * 3_f64.sqrt(), RADIUS * (8.0_f64 / 3.0).sqrt());
    for level in 0..3_usize {
        let n = 3 - level;
        for i in 0..n {
            for j in 0..n - i {
                let x = RADIUS * (2 * j + i) as f64 - RADIUS * (n - 1) as f64;
                let z = row * (n - 1) as f64 / 3.0 - row * i as f64;
                builder.sphere([x, RADIUS + layer * level as f64, z], RADIUS, spacing);
            }
        }
    }
    builder.part(2);
    for k in 0..9_usize {
        let angle = TAU * (k as f64 + 0.35) / 9.0;
        let radius = [0.16, 0.1, 0.13][k % 3];
        let away = 1.55 + 0.16 * [0.0, 1.0, -0.6, 0.5][k % 4];
        builder.sphere([away * angle.cos(), radius, away * angle.sin()], radius, 0.8 * spacing);
    }
}
