//! A carved medallion: a sheet displaced along +y.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::builder::{Builder, Ends};

const HALF: f64 = 1.2;
const SKIRT: f64 = 0.12;

pub(super) fn tessellate(builder: &mut Builder, spacing: f64) {
    let cells = ((2.0 * HALF / spacing).round() as usize).max(8);
    let place = |t: f64| HALF * (2.0 * t - 1.0);
    builder.part(0);
    builder.textured_grid(
        [cells; 2],
        [Ends::Open; 2],
        |u, v| [v, 1.0 - u],
        |u, v| {
            let (x, z) = (place(v), place(u));
            const STEP: f64 = 1e-4;
            let slope_x = (height(x + STEP, z) - height(x - STEP, z)) / (2.0 * STEP);
            let slope_z = (height(x, z + STEP) - height(x, z - STEP)) / (2.0 * STEP);
            (Vector3::new(x, height(x, z), z), Vector3::new(-slope_x, 1.0, -slope_z).normalize())
        },
    );
    builder.part(1);
    for side in 0..4 {
        let turn = |x: f64, z: f64| match side {
            0 => (x, z),
            1 => (z, -x),
            2 => (-x, -z),
            _ => (-z, x),
        };
        builder.grid([cells, 1], [Ends::Open; 2], |u, v| {
            let ((x, z), (nx, nz)) = (turn(place(u), HALF), turn(0.0, 1.0));
            (Vector3::new(x, if v > 0.0 { height(x, z) } else { -SKIRT }, z), Vector3::new(nx, 0.0, nz))
        });
    }
}

/// 0 below `from`, 1 above `to`, C¹ between.
fn step(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A ridge of half-width `w` around 0 with a round top.
fn ridge(x: f64, w: f64) -> f64 {
    let t = (x / w).abs().min(1.0);
    (1.0 - t * t).powi(2)
}

/// A rosette in a beaded ring in a frame, and leaves in the corners.
fn height(x: f64, z: f64) -> f64 {
    let (r, angle) = (x.hypot(z), z.atan2(x));
    let square = x.abs().max(z.abs());
    let frame = 0.1 * step(1.04, 1.09, square) - 0.05 * ridge(square - 1.14, 0.03);
    let ring = 0.09 * ridge(r - 0.95, 0.06) + 0.05 * ridge(r - 0.72, 0.035);
    // 24 beads between the rings.
    let sector = (angle * 24.0 / TAU).rem_euclid(1.0) - 0.5;
    let bead = (sector * TAU / 24.0 * 0.83).hypot(r - 0.83);
    let beads = 0.08 * (1.0 - (bead / 0.06).powi(2)).max(0.0);
    // Two rows of eight petals, each with a vein.
    let petal = |turn: f64, length: f64, width: f64| {
        let a = ((angle + turn) * 8.0 / TAU).rem_euclid(1.0) - 0.5;
        let across = a * TAU / 8.0 * r / (width * (r / length * (1.0 - (r / length).powi(3))).max(0.0).sqrt() + 1e-3);
        let body = (1.0 - across * across).max(0.0) * step(0.0, 0.12, 1.0 - r / length);
        body * (1.0 - 0.25 * ridge(across, 0.25)) * (0.4 + 0.6 * (r / length).min(1.0))
    };
    let outer = 0.12 * petal(TAU / 16.0, 0.66, 0.17);
    let inner = 0.17 * petal(0.0, 0.42, 0.13);
    let heart = 0.19 * (1.0 - (r / 0.14).powi(2)).max(0.0);
    // Leaves along the diagonals.
    let (along, aside) = ((x.abs() + z.abs()) / 2_f64.sqrt(), (x.abs() - z.abs()) / 2_f64.sqrt());
    let reach = ((along - 1.02) / 0.36).clamp(0.0, 1.0);
    let width = 0.16 * (reach * (1.0 - reach)).sqrt() * 2.0 + 1e-3;
    let leaf = 0.08
        * (1.0 - (aside / width).powi(2)).max(0.0)
        * (1.0 - 0.3 * ridge(aside, 0.02))
        * (1.0 + 0.12 * (40.0 * (along - aside.abs())).sin());
    outer.max(inner).max(heart).max(ring).max(beads).max(leaf * step(0.0, 0.05, reach)).max(frame)
}
