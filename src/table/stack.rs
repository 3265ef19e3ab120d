//! Many summed-area tables of one size, interleaved.

use super::Rectangle;
use super::lookup::Place;
use crate::approx_eq::approx_by_parts;
use crate::{Error, Real, Result};

/// A stack of summed-area tables that share one layout, the same entry of all layers side by side: a look-up in several
/// layers costs little more than one.
///
/// Layers are what a texture's third axis is to Xu's BRDF tables: the polar angles of an isotropic material, or the
/// view directions (a grid of them) of an anisotropic one; [`mix`](Self::mix) interpolates between them. [Xu 2006 §4.2,
/// 5.1]
///
/// Shapes: sample (x, y) of layer l at (l·height + y)·width + x; entries (r·(width + 1) + c)·layers + l.
/// Accuracy: sums run in `f64` and are rounded once, to T.
///
/// # Example
/// ```
/// # fn main() -> Result<(), haarmonic::Error> {
/// use haarmonic::table::{Rectangle, SummedAreaStack};
/// let stack: SummedAreaStack<f32> = SummedAreaStack::new([2, 1], 2, &[1.0, 2.0, 30.0, 40.0])?;
/// let all = Rectangle { left: 0.0, top: 0.0, right: 2.0, bottom: 1.0 };
/// assert_eq!(stack.mix(all, [(0, 0.5), (1, 0.5)]), 36.5);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SummedAreaStack<T> {
    size: [usize; 2],
    layers: usize,
    entries: Vec<T>,
}

impl<T: Real> SummedAreaStack<T> {
    /// The tables of `layers` images of size [width, height], one after another.
    ///
    /// # Errors
    /// [`Error::Length`] unless there are layers·width·height samples; [`Error::OutOfRange`] if the tables cannot be
    /// addressed.
    pub fn new<S: Real>(size: [usize; 2], layers: usize, samples: &[S]) -> Result<Self> {
        let [width, height] = size;
        // One layer must be addressable even where there is none.
        let layer = (width as u128 + 1).saturating_mul(height as u128 + 1);
        let count = layer.saturating_mul(layers.max(1) as u128);
        if count > (isize::MAX as u128) / 16 {
            return Err(Error::OutOfRange { what: "stack of tables", got: count as f64, allowed: "addressable" });
        }
        let area = width * height;
        if samples.len() != area * layers {
            return Err(Error::Length { what: "samples", expected: area * layers, got: samples.len() });
        }
        let row_len = (width + 1) * layers;
        let mut entries = vec![T::zero(); row_len * (height + 1)];
        // The column sums of every layer, and their prefix along the row.
        let (mut columns, mut prefix) = (vec![0.0; width * layers], vec![0.0; layers]);
        for (y, row) in entries.chunks_exact_mut(row_len.max(1)).skip(1).enumerate() {
            for layer in 0..layers {
                let line = &samples[layer * area + y * width..][..width];
                line.iter().enumerate().for_each(|(x, s)| columns[x * layers + layer] += s.widen());
            }
            prefix.fill(0.0);
            let below = row[layers..].chunks_exact_mut(layers.max(1));
            for (entries, sums) in below.zip(columns.chunks_exact(layers.max(1))) {
                for layer in 0..layers {
                    prefix[layer] += sums[layer];
                    entries[layer] = T::of(prefix[layer]);
                }
            }
        }
        Ok(Self { size, layers, entries })
    }

    /// [width, height] of a layer.
    #[inline]
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// The number of layers.
    #[inline]
    pub fn layers(&self) -> usize {
        self.layers
    }

    /// All entries.
    #[inline]
    pub fn entries(&self) -> &[T] {
        &self.entries
    }

    /// ∫ f over a rectangle, in every layer; as [`SummedAreaRef::sum`](crate::table::SummedAreaRef::sum).
    ///
    /// # Panics
    /// If `out.len()` is not the number of layers.
    #[track_caller]
    pub fn sums(&self, rectangle: Rectangle, out: &mut [f64]) {
        crate::error::check_length("layers", self.layers, out.len());
        out.fill(0.0);
        for (at, weight) in self.corners(rectangle) {
            if weight == 0.0 {
                continue;
            }
            let entries = &self.entries[at * self.layers..][..self.layers];
            for (out, entry) in out.iter_mut().zip(entries) {
                *out += weight * entry.widen();
            }
        }
    }

    /// Σ wₗ ∫ fₗ over a rectangle: two layers and weights for one angle between two, four for a direction between four.
    ///
    /// # Panics
    /// If a layer is not below [`layers`](Self::layers).
    #[inline]
    #[track_caller]
    pub fn mix<const N: usize>(&self, rectangle: Rectangle, layers: [(usize, f64); N]) -> f64 {
        for (layer, _) in layers {
            assert!(layer < self.layers, "layer {layer} of a stack of {}", self.layers);
        }
        let mut sum = 0.0;
        for (at, weight) in self.corners(rectangle) {
            if weight == 0.0 {
                continue;
            }
            let entries = &self.entries[at * self.layers..][..self.layers];
            let mixed: f64 = layers.iter().map(|&(layer, w)| w * entries[layer].widen()).sum();
            sum += weight * mixed;
        }
        sum
    }

    /// The entries that a rectangle's integral is made of, and their weights: the four bilinear corners of each of its
    /// four.
    #[inline(always)]
    fn corners(&self, rectangle: Rectangle) -> [(usize, f64); 16] {
        let Rectangle { left, top, right, bottom } = rectangle;
        let [width, height] = self.size;
        let x = ends([left, right].map(|bound| Place::new(bound, width)));
        let y = ends([top, bottom].map(|bound| Place::new(bound, height)));
        std::array::from_fn(|k| {
            let ((row, v), (column, u)) = (y[k / 4], x[k % 4]);
            (row * (width + 1) + column, v * u)
        })
    }
}

#[inline(always)]
fn ends([low, high]: [Place; 2]) -> [(usize, f64); 4] {
    [(high.low, 1.0 - high.within), (high.high, high.within), (low.low, low.within - 1.0), (low.high, -low.within)]
}

approx_by_parts!([T] SummedAreaStack<T>, T, |t| close [&t.entries] same [t.size, t.layers]);
