//! Whole signals seen through a map: the exact means over the cells of the target.

use super::steps::{Function, Placed, integral};
use crate::affine::AffineMap;

/// Mean over cell `k` of `count`.
fn mean(function: &Placed, count: usize, k: usize) -> f64 {
    integral(&[function, &Function::cell(count, k, count as f64).fixed()])
}

/// The means of F(sv + o) over as many cells of [0, 1] as F has: its L² projection. F is 0 outside [0, 1].
pub fn resample_1d(samples: &[f64], map: AffineMap) -> Vec<f64> {
    let function = Function::cells(samples).through(map);
    (0..samples.len()).map(|k| mean(&function, samples.len(), k)).collect()
}

/// The means of F(s_x x + o_x, s_y y + o_y) over the pixels of an image of the same size, row-major.
pub fn resample_2d(image: &[f64], width: usize, height: usize, [map_x, map_y]: [AffineMap; 2]) -> Vec<f64> {
    assert_eq!(image.len(), width * height, "width·height pixels");
    let rows: Vec<f64> = image.chunks(width.max(1)).flat_map(|row| resample_1d(row, map_x)).collect();
    let mut out = vec![0.0; image.len()];
    for x in 0..width {
        let column: Vec<f64> = (0..height).map(|y| rows[y * width + x]).collect();
        resample_1d(&column, map_y).into_iter().enumerate().for_each(|(y, mean)| out[y * width + x] = mean);
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
