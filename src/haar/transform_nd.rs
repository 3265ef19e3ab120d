//! The standard transform of arrays with any number of axes.

use super::transform_1d::{Direction, Transform1d, take_scratch};
use crate::error::check_length;
use crate::{Error, Real, Result};

/// Orthonormal standard Haar transform of an array with N axes: the 1D transform along each of them, planned once.
///
/// The basis functions are all products ψ_{k₁}(x₁) ψ_{k₂}(x₂) ⋯ of 1D ones; a light field has four axes, a
/// bidirectional texture function six. With two axes it is [`Transform2d`](super::Transform2d) with
/// [`Decomposition::Standard`](super::Decomposition::Standard).
///
/// Shapes: `sizes` are powers of two, slowest axis first; the element (i₁, i₂, …, i_N) of samples and coefficients is
/// at ((i₁ · size₂ + i₂) · size₃ + …) + i_N. Accuracy: at most Σ (log₂ size + 2)·ε of max |x|, each coefficient. Cost:
/// 2N multiplications and additions an element; axes but the last are taken sixteen lines at a time.
///
/// # Example
/// ```
/// use haarmonic::haar::TransformNd;
/// // A light field of 4 × 4 places and 2 × 2 directions, bright along one of them.
/// let plan = TransformNd::<f32>::new(&[4, 4, 2, 2])?;
/// let field: Vec<f32> = (0..plan.len()).map(|i| if i % 4 == 3 { 1.0 } else { 0.0 }).collect();
/// let (mut coefs, mut scratch) = (field.clone(), vec![0.0; plan.scratch_len()]);
/// plan.forward_in_place(&mut coefs, &mut scratch);
/// // Four of 64 coefficients: nothing depends on the place.
/// assert_eq!(coefs.iter().filter(|c| **c != 0.0).count(), 4);
/// plan.inverse_in_place(&mut coefs, &mut scratch);
/// assert_eq!(coefs, field);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct TransformNd<T> {
    axes: Vec<Transform1d<T>>,
    len: usize,
}

/// Lines along an axis that are transformed together.
const TOGETHER: usize = 16;

impl<T: Real> TransformNd<T> {
    /// Plans transforms of an array of these sizes.
    ///
    /// # Errors
    /// [`Error::Empty`] without an axis, [`Error::NotPowerOfTwo`] unless every size is one, [`Error::OutOfRange`] if
    /// the array cannot be addressed.
    pub fn new(sizes: &[usize]) -> Result<Self> {
        if sizes.is_empty() {
            return Err(Error::Empty { what: "list of sizes" });
        }
        let axes = sizes.iter().map(|&size| Transform1d::new(size)).collect::<Result<Vec<_>>>()?;
        let len = sizes.iter().try_fold(1_usize, |len, &size| len.checked_mul(size)).ok_or_else(|| {
            let got = sizes.iter().map(|&size| size as f64).product();
            Error::OutOfRange { what: "elements of an array", got, allowed: "addressable" }
        })?;
        Ok(Self { axes, len })
    }

    /// The sizes of the axes, slowest first.
    pub fn sizes(&self) -> Vec<usize> {
        self.axes.iter().map(Transform1d::len).collect()
    }

    /// The number of elements.
    #[inline]
    #[expect(clippy::len_without_is_empty, reason = "no axis has a size of 0")]
    pub fn len(&self) -> usize {
        self.len
    }

    /// How much scratch every method wants, at least.
    pub fn scratch_len(&self) -> usize {
        self.axes.iter().map(|axis| TOGETHER * axis.len() + axis.scratch_len()).max().unwrap_or(0)
    }

    /// Replaces samples by coefficients.
    ///
    /// # Panics
    /// If `data.len()` is not [`len`](Self::len), or `scratch` is shorter than [`scratch_len`](Self::scratch_len).
    #[track_caller]
    pub fn forward_in_place(&self, data: &mut [T], scratch: &mut [T]) {
        check_length("samples", self.len, data.len());
        self.run(Direction::Forward, data, scratch);
    }

    /// Replaces coefficients by samples.
    ///
    /// # Panics
    /// As [`forward_in_place`](Self::forward_in_place).
    #[track_caller]
    pub fn inverse_in_place(&self, data: &mut [T], scratch: &mut [T]) {
        check_length("coefficients", self.len, data.len());
        self.run(Direction::Inverse, data, scratch);
    }

    /// Coefficient `indices` = (k₁, …, k_N) of an array, by its number.
    ///
    /// # Panics
    /// Unless there is one index an axis, below its size.
    #[track_caller]
    pub fn flat(&self, indices: &[usize]) -> usize {
        check_length("indices of an element", self.axes.len(), indices.len());
        indices.iter().zip(&self.axes).fold(0, |flat, (&index, axis)| {
            assert!(index < axis.len(), "index {index} of an axis of {}", axis.len());
            flat * axis.len() + index
        })
    }

    #[track_caller]
    fn run(&self, direction: Direction, data: &mut [T], scratch: &mut [T]) {
        let scratch = take_scratch(self.scratch_len(), scratch);
        let mut stride = self.len;
        for axis in &self.axes {
            // Elements of a block lie `stride` apart along this axis, and blocks one after the other.
            let block = stride;
            stride /= axis.len();
            let (lines, rest) = scratch.split_at_mut(TOGETHER * axis.len());
            let run = |lines: &mut [T], rest: &mut [T]| match direction {
                Direction::Forward => axis.forward_batch_in_place(lines, rest),
                Direction::Inverse => axis.inverse_batch_in_place(lines, rest),
            };
            if stride == 1 {
                run(data, rest);
                continue;
            }
            for block in data.chunks_exact_mut(block) {
                for first in (0..stride).step_by(TOGETHER) {
                    let count = TOGETHER.min(stride - first);
                    let lines = &mut lines[..count * axis.len()];
                    for (i, row) in block.chunks_exact(stride).enumerate() {
                        (0..count).for_each(|k| lines[k * axis.len() + i] = row[first + k]);
                    }
                    run(lines, rest);
                    for (i, row) in block.chunks_exact_mut(stride).enumerate() {
                        (0..count).for_each(|k| row[first + k] = lines[k * axis.len() + i]);
                    }
                }
            }
        }
    }
}
