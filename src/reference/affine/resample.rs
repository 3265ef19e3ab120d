//! Whole signals seen through a map: the exact means over the cells of the target.

use super::steps::{Function, Placed, integral};
use crate::affine::AffineMap;

/// Mean over cell `k` of `count`.
fn mean(function: &Placed, count: usize, k: usize) -> f64 {
    integral(&[function, &Function::cell(count, k, count as f64).fixed()])
}

/// The means of F(sv + o) over as many cells of [0, 1] as F has: its L² projection. F is 0 outside [0, 1].
pub fn resample_1d(samples: &[f64], map: AffineMap) -> Vec<f64> {
    resample_between_1d(samples, samples.len(), map)
}

/// The means of F(sv + o) over `size` cells of [0, 1], whatever the number of the samples of F.
pub fn resample_between_1d(samples: &[f64], size: usize, map: AffineMap) -> Vec<f64> {
    let function = Function::cells(samples).through(map);
    (0..size).map(|k| mean(&function, size, k)).collect()
}

/// The means of F(s_x x + o_x, s_y y + o_y) over the pixels of an image of the same size, row-major.
pub fn resample_2d(image: &[f64], width: usize, height: usize, maps: [AffineMap; 2]) -> Vec<f64> {
    assert_eq!(image.len(), width * height, "width·height pixels");
    resample_between_2d(image, width, [width, height], maps)
}

/// The means of F(s_x x + o_x, s_y y + o_y) over the `size[0]` × `size[1]` pixels of another image, row-major; F has
/// rows of `width` pixels.
pub fn resample_between_2d(image: &[f64], width: usize, size: [usize; 2], [map_x, map_y]: [AffineMap; 2]) -> Vec<f64> {
    let [across, down] = size;
    let rows: Vec<Vec<f64>> = image.chunks(width.max(1)).map(|row| resample_between_1d(row, across, map_x)).collect();
    let mut out = vec![0.0; across * down];
    for x in 0..across {
        let column: Vec<f64> = rows.iter().map(|row| row[x]).collect();
        let means = resample_between_1d(&column, down, map_y);
        means.into_iter().enumerate().for_each(|(y, mean)| out[y * across + x] = mean);
    }
    out
}

/// The means of F(sv + o, v) over `directions` cells of v, of a light field of samples F[v₁·directions + v₂]
/// [Sun 2008, §4.5.3].
pub fn resample_light_field(field: &[f64], directions: usize, map: AffineMap) -> Vec<f64> {
    let at = |v2: usize| {
        let slice: Vec<f64> = field.iter().skip(v2).step_by(directions).copied().collect();
        mean(&Function::cells(&slice).through(map), directions, v2)
    };
    (0..directions).map(at).collect()
}
