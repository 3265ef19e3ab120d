//! A photograph that nobody took: sky, a hill, houses with façades of windows, and the grain of it all.
//!
//! The bench `wavelet_image` uses this file too.

use std::f64::consts::TAU;

/// The centre of a façade, in widths and heights of the picture.
pub const FACADE: [f64; 2] = [0.417, 0.573];

/// A number in [0, 1) for a place of a lattice.
fn hash(x: i64, y: i64, seed: u64) -> f64 {
    let mut h = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f) ^ seed;
    h = (h ^ (h >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    h = (h ^ (h >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((h ^ (h >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Smooth noise between −1 and 1, one lattice place a unit.
fn noise(x: f64, y: f64, seed: u64) -> f64 {
    let (x0, y0) = (x.floor(), y.floor());
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let (u, v) = (smooth(x - x0), smooth(y - y0));
    let at = |i: i64, j: i64| hash(x0 as i64 + i, y0 as i64 + j, seed);
    let [top, bottom] = [0, 1].map(|j| at(0, j) + u * (at(1, j) - at(0, j)));
    2.0 * (top + v * (bottom - top)) - 1.0
}

/// 1/f noise: as much in every octave from `first` cells across on.
fn fractal(x: f64, y: f64, first: u32, octaves: u32, seed: u64) -> f64 {
    (0..octaves)
        .map(|k| {
            let cells = f64::from(first << k);
            noise(x * cells, y * cells, seed + u64::from(k)) * 0.5f64.powi(k as i32)
        })
        .sum()
}

/// A house: left, right, top and bottom edges, columns and rows of windows, colour.
struct House {
    edges: [f64; 4],
    windows: [f64; 2],
    wall: [f64; 3],
}

const HOUSES: [House; 5] = [
    House { edges: [0.02, 0.20, 0.52, 0.86], windows: [7.0, 9.0], wall: [0.52, 0.40, 0.30] },
    House { edges: [0.23, 0.57, 0.36, 0.88], windows: [13.0, 12.0], wall: [0.62, 0.58, 0.50] },
    House { edges: [0.60, 0.72, 0.47, 0.85], windows: [4.0, 10.0], wall: [0.36, 0.34, 0.36] },
    House { edges: [0.75, 0.97, 0.58, 0.87], windows: [9.0, 6.0], wall: [0.55, 0.30, 0.24] },
    House { edges: [0.645, 0.675, 0.20, 0.47], windows: [1.0, 7.0], wall: [0.48, 0.46, 0.42] },
];

/// What of a house is at a place of its façade, both coordinates in [0, 1).
fn facade(house: &House, u: f64, v: f64, index: u64) -> [f64; 3] {
    let [columns, rows] = house.windows;
    let (cell_x, cell_y) = ((u * columns).floor(), (v * rows).floor());
    let (x, y) = (u * columns - cell_x, v * rows - cell_y);
    let lit = hash(cell_x as i64, cell_y as i64, 77 + index);
    let light = 1.0 + 0.25 * (0.5 - v) + 0.05 * fractal(u, v, 8, 5, 500 + index);
    // A cornice below each row, a frame around each window, a cross in it, glass that is dark or mirrors the sky.
    if y > 0.93 {
        return house.wall.map(|c| 1.25 * c * light);
    }
    let inside = (0.22..0.78).contains(&x) && (0.15..0.80).contains(&y);
    if !inside {
        return house.wall.map(|c| c * light);
    }
    let frame = !(0.27..0.73).contains(&x) || !(0.19..0.76).contains(&y);
    let cross = (x - 0.5).abs() < 0.02 || (y - 0.40).abs() < 0.02;
    if frame || cross {
        return [0.78, 0.76, 0.72].map(|c| c * light);
    }
    if lit > 0.9 {
        return [0.95, 0.78, 0.42];
    }
    let mirror = 0.10 + 0.35 * lit * (1.0 - y) + 0.04 * fractal(x + cell_x, y + cell_y, 2, 3, 900);
    [0.8 * mirror, 0.95 * mirror, 1.15 * mirror]
}

/// Red, green and blue at a point of the unit square.
fn colour(x: f64, y: f64) -> [f64; 3] {
    let grain = 0.012 * (hash((x * 4096.0) as i64, (y * 4096.0) as i64, 5) - 0.5);
    let found = HOUSES.iter().enumerate().find(|(_, House { edges: [left, right, top, bottom], .. })| {
        (*left..*right).contains(&x) && (*top..*bottom).contains(&y)
    });
    let base = if let Some((index, house)) = found {
        let [left, right, top, bottom] = house.edges;
        facade(house, (x - left) / (right - left), (y - top) / (bottom - top), index as u64)
    } else if y > 0.86 + 0.01 * fractal(x, 0.5, 6, 3, 31) {
        // The street.
        let stone = 0.24 + 0.10 * fractal(x, 2.0 * y, 32, 6, 41);
        [stone, 0.97 * stone, 0.92 * stone]
    } else if y > 0.66 + 0.10 * fractal(x, 0.1, 3, 6, 51) {
        // Trees on a hill.
        let leaves = 0.5 + 0.5 * fractal(x, y, 24, 6, 61);
        [0.10 + 0.16 * leaves, 0.14 + 0.24 * leaves, 0.06 + 0.08 * leaves]
    } else {
        let cloud = (0.5 + 0.7 * fractal(x, 1.8 * y, 3, 7, 71)).clamp(0.0, 1.0);
        let blue = [0.30 + 0.25 * y, 0.48 + 0.25 * y, 0.78 + 0.08 * y];
        [0, 1, 2].map(|c| blue[c] + cloud * ([0.93, 0.93, 0.95][c] - blue[c]) * 0.8)
    };
    let shade = 1.0 + 0.04 * (TAU * (0.5 * x + 0.2)).sin();
    base.map(|c| (c * shade + grain).clamp(0.0, 1.0))
}

/// Planes of red, green and blue, each pixel the mean of four points.
pub fn photograph(side: usize) -> [Vec<f32>; 3] {
    let mut planes = [(); 3].map(|()| Vec::with_capacity(side * side));
    for i in 0..side * side {
        let mut sum = [0.0; 3];
        for k in 0..4 {
            let [x, y] = [(i % side, k % 2), (i / side, k / 2)]
                .map(|(at, half)| (at as f64 + 0.25 + 0.5 * half as f64) / side as f64);
            let here = colour(x, y);
            (0..3).for_each(|c| sum[c] += 0.25 * here[c]);
        }
        (0..3).for_each(|c| planes[c].push(sum[c] as f32));
    }
    planes
}
