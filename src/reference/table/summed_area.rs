//! Sums over rectangles.

use crate::numeric::CompensatedSum;

/// S(r, c) = Σ f over rows < r and columns < c; (height + 1) rows of width + 1. Each entry is a sum of its own.
pub fn summed_area(width: usize, height: usize, samples: &[f64]) -> Vec<f64> {
    let entry = |r: usize, c: usize| {
        let terms = (0..r * c).map(|i| samples[i / c * width + i % c]);
        terms.collect::<CompensatedSum>().total()
    };
    (0..=height).flat_map(|r| (0..=width).map(move |c| entry(r, c))).collect()
}

/// ∫ f over [left, right] × [top, bottom], f constant on each pixel and 0 outside; with `wrap` along an axis it repeats
/// for ever. Each pixel counts by the length of it that is inside along x times that along y; inverted bounds count
/// negative.
///
/// Bounds must be finite, and with `wrap` not many images away.
pub fn rectangle_sum(
    [width, height]: [usize; 2],
    samples: &[f64],
    [left, top, right, bottom]: [f64; 4],
    wrap: [bool; 2],
) -> f64 {
    let columns: Vec<f64> = (0..width).map(|x| overlap(x, width, [left, right], wrap[0])).collect();
    let rows: Vec<f64> = (0..height).map(|y| overlap(y, height, [top, bottom], wrap[1])).collect();
    let term = |i: usize| samples[i] * (columns[i % width] * rows[i / width]);
    (0..width * height).map(term).collect::<CompensatedSum>().total()
}

/// The length of [k, k + 1], and of its images `size` apart, inside the bounds.
fn overlap(k: usize, size: usize, [low, high]: [f64; 2], wrap: bool) -> f64 {
    if low > high {
        return -overlap(k, size, [high, low], wrap);
    }
    let one = |k: f64| (high.min(k + 1.0) - low.max(k)).max(0.0);
    if !wrap {
        return one(k as f64);
    }
    let size = size as f64;
    let (first, last) = ((low / size).floor() as i64 - 1, (high / size).floor() as i64 + 1);
    (first..=last).map(|turn| one(k as f64 + turn as f64 * size)).sum()
}
