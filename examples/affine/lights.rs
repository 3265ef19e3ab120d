//! Textured lights: a gradient, discs and noise, from a seed.

use crate::pair;

/// A light of `side`² texels.
pub fn textured(side: usize, seed: usize) -> Vec<f64> {
    let number = |k: usize| pair(1009 * (seed + 1) + k);
    let [slope_x, slope_y] = number(0);
    let discs: Vec<([f64; 2], f64, f64)> = (0..5)
        .map(|k| {
            let [radius, radiance] = number(10 + 2 * k);
            (number(11 + 2 * k), 0.05 + 0.2 * radius, 0.5 + 2.0 * radiance)
        })
        .collect();
    let texel = |i: usize| {
        let at = [(i % side) as f64, (i / side) as f64].map(|c| (c + 0.5) / side as f64);
        let gradient = 0.3 + 0.5 * (slope_x * at[0] + slope_y * at[1]);
        let inside = |c: &[f64; 2], r: f64| (at[0] - c[0]).hypot(at[1] - c[1]) < r;
        let disc: f64 = discs.iter().filter(|(c, r, _)| inside(c, *r)).map(|(_, _, radiance)| radiance).sum();
        gradient + disc + 0.15 * number(100 + i)[0]
    };
    (0..side * side).map(texel).collect()
}
