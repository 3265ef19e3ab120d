//! The pixel method as a program without this library would have it: decompress all, sample, compress all.
//!
//! The bench `wavelet_image` uses this file too.

use haarmonic::affine::ZoomWindow;
use haarmonic::haar::{Keep, SparseVector, Weighting, select};

/// Memory for square pictures of one side.
pub struct Plain {
    side: usize,
    image: Vec<f32>,
    result: Vec<f32>,
    line: Vec<f32>,
}

impl Plain {
    pub fn new(side: usize) -> Self {
        let (image, result) = (vec![0.0; side * side], vec![0.0; side * side]);
        Self { side, image, result, line: vec![0.0; 2 * side] }
    }

    /// One channel: the coefficients of the window, of which `keep` are kept.
    pub fn zoom(&mut self, coefs: &[f32], window: ZoomWindow, keep: Keep) -> SparseVector<f32> {
        let side = self.side;
        self.image.copy_from_slice(coefs);
        // Columns, then rows.
        for at in 0..side {
            inverse(&mut self.image[at..], side, side, &mut self.line);
        }
        for row in self.image.chunks_exact_mut(side) {
            inverse(row, side, 1, &mut self.line);
        }
        self.sample(window);
        for row in self.result.chunks_exact_mut(side) {
            forward(row, side, 1, &mut self.line);
        }
        for at in 0..side {
            forward(&mut self.result[at..], side, side, &mut self.line);
        }
        select(&self.result, keep, Weighting::Magnitude).expect("finite coefficients")
    }

    /// Between the centres of the four pixels around each point; 0 outside.
    fn sample(&mut self, window: ZoomWindow) {
        let (side, [x, y]) = (self.side, window.maps());
        let at = |i: i64, j: i64| {
            let inside = (0..side as i64).contains(&i) && (0..side as i64).contains(&j);
            if inside { self.image[j as usize * side + i as usize] } else { 0.0 }
        };
        for (k, out) in self.result.iter_mut().enumerate() {
            let place = |map: haarmonic::affine::AffineMap, k: usize| {
                let v = map.apply((k as f64 + 0.5) / side as f64) * side as f64 - 0.5;
                (v.floor() as i64, (v - v.floor()) as f32)
            };
            let ((i, u), (j, v)) = (place(x, k % side), place(y, k / side));
            let top = at(i, j) + u * (at(i + 1, j) - at(i, j));
            let bottom = at(i, j + 1) + u * (at(i + 1, j + 1) - at(i, j + 1));
            *out = top + v * (bottom - top);
        }
    }
}

/// Coefficients that lie `stride` apart, to samples.
fn inverse(data: &mut [f32], size: usize, stride: usize, line: &mut [f32]) {
    let (mut width, mut scale) = (1, 1.0f32);
    while width < size {
        for t in 0..width {
            let (mean, detail) = (data[t * stride], scale * data[(width + t) * stride]);
            (line[2 * t], line[2 * t + 1]) = (mean + detail, mean - detail);
        }
        width *= 2;
        (0..width).for_each(|t| data[t * stride] = line[t]);
        scale *= std::f32::consts::SQRT_2;
    }
}

/// Samples that lie `stride` apart, to coefficients.
fn forward(data: &mut [f32], size: usize, stride: usize, line: &mut [f32]) {
    let mut width = size;
    while width > 1 {
        width /= 2;
        let scale = 0.5 / (width as f32).sqrt();
        for t in 0..width {
            let (a, b) = (data[2 * t * stride], data[(2 * t + 1) * stride]);
            (line[t], line[width + t]) = (0.5 * (a + b), scale * (a - b));
        }
        (0..2 * width).for_each(|t| data[t * stride] = line[t]);
    }
}
