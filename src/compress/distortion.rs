//! What compression with loss loses.

use super::parallel::map;
use crate::Real;

/// How far numbers are from what compression made of them.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Distortion {
    /// The largest difference.
    pub max: f64,
    /// √ of the mean squared difference.
    pub rms: f64,
    /// √(Σ (x − x')² / Σ x²): 0 if nothing is lost, 1 if all is; 0 for zeros that stay zeros.
    pub relative: f64,
}

impl Distortion {
    /// Of numbers and what is left of them; all 0 if there are none. NaN in either makes `rms` NaN.
    ///
    /// # Panics
    /// If the lengths differ.
    #[track_caller]
    pub fn between<T: Real>(original: &[T], compressed: &[T]) -> Self {
        crate::error::check_length("compressed numbers", original.len(), compressed.len());
        Self::of_rows(original, 1, |first, _, out| out.copy_from_slice(&compressed[first..][..out.len()]))
    }

    /// Of rows; `with(first row, rows, out)` writes what is left of some of them. In chunks that are folded in order.
    pub(super) fn of_rows<T: Real>(
        original: &[T],
        columns: usize,
        with: impl Fn(usize, &[T], &mut [T]) + Sync + Send,
    ) -> Self {
        let chunk = (1usize << 16).div_ceil(columns) * columns;
        let pieces = map(original.len().div_ceil(chunk), |piece| {
            let rows = &original[piece * chunk..original.len().min((piece + 1) * chunk)];
            let mut out = vec![T::zero(); rows.len()];
            with(piece * chunk / columns, rows, &mut out);
            rows.iter().zip(&out).fold((0.0f64, 0.0, 0.0), |(max, squares, energy), (x, y)| {
                let (x, d) = (x.widen(), x.widen() - y.widen());
                (max.max(d.abs()), squares + d * d, energy + x * x)
            })
        });
        let sum = pieces.into_iter().fold((0.0f64, 0.0, 0.0), |a, b| (a.0.max(b.0), a.1 + b.1, a.2 + b.2));
        let (max, squares, energy) = sum;
        let relative = if squares == 0.0 { 0.0 } else { (squares / energy).sqrt() };
        Self { max, rms: (squares / (original.len() as f64).max(1.0)).sqrt(), relative }
    }
}
