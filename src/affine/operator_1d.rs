//! The affine map of a whole 1D signal, as a sparse matrix of couplings.

use super::coupling::levels_of;
use super::steps::{Steps, row_room};
use super::{AffineMap, Atom, Parameter};
use crate::error::check_length;
use crate::haar::SparseVector;
use crate::{Error, Real, Result};

/// F(s v + o) of 1D Haar signals: L_k = Σ_i F_i D_ik(s, o)                          [Sun 2008, eq. 4.35].
///
/// Holds the non-zero couplings of one map, row by row of the source; a new map reuses its memory. The result is the L²
/// projection of F(s v + o) on [0, 1), F = 0 outside: exact against every signal of the same size. Transformed signals
/// do not chain: compose the maps instead ([`AffineMap::then`]).
///
/// Shapes: signals of `size` coefficients, flat 1D index. Accuracy: a few ε·max|L| in T; couplings are computed in f64,
/// as those of [`Nonzeros1d::row`](super::Nonzeros1d::row).
/// Cost: [`set`](Self::set) visits the Θ(N) non-zeros alone, `apply` is one multiplication and addition each.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, Operator1d};
/// use haarmonic::haar::{forward_1d, inverse_1d};
/// let light = forward_1d(&[0.0, 2.0, 4.0, 8.0])?;
/// let zoom = Operator1d::<f64>::new(4, AffineMap::new(0.5, 0.5)?)?; // the right half, twice as large
/// let mut seen = [0.0; 4];
/// zoom.apply(&light, &mut seen);
/// assert_eq!(inverse_1d(&seen)?, [4.0, 4.0, 8.0, 8.0]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Operator1d<T> {
    levels: u32,
    /// Row i is entries start[i]..start[i + 1].
    start: Vec<u32>,
    target: Vec<u32>,
    value: Vec<T>,
}

impl<T: Real> Operator1d<T> {
    /// The operator of signals of `size` coefficients under `map`.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `size` is one; [`Error::OutOfRange`] above 2²⁴ (some gigabytes of couplings).
    pub fn new(size: usize, map: AffineMap) -> Result<Self> {
        let levels = levels_of("size of a signal", size)?;
        if levels > 24 {
            return Err(Error::OutOfRange { what: "size of a signal", got: size as f64, allowed: "at most 2^24" });
        }
        let mut operator = Self { levels, start: Vec::new(), target: Vec::new(), value: Vec::new() };
        operator.set(map);
        Ok(operator)
    }

    /// The number of coefficients of a signal.
    #[inline]
    pub fn size(&self) -> usize {
        1 << self.levels
    }

    /// How many couplings are not zero.
    #[inline]
    pub fn nnz(&self) -> usize {
        self.value.len()
    }

    /// The non-zero D_ij of source i: flat target indices j, ascending, and values.
    ///
    /// # Panics
    /// If `i` is not below [`size`](Self::size).
    #[track_caller]
    #[inline]
    pub fn row(&self, i: usize) -> (&[u32], &[T]) {
        let range = self.start[i] as usize..self.start[i + 1] as usize;
        (&self.target[range.clone()], &self.value[range])
    }

    /// Turns to another map, in the memory that is there.
    pub fn set(&mut self, map: AffineMap) {
        self.clear();
        let room = row_room(self.levels);
        let mut filled = 0;
        for i in 0..self.size() {
            // Twice the room at a time: the lists grow rarely and never beyond what some map needs.
            if self.value.len() < filled + room {
                self.target.resize(2 * (filled + room), 0);
                self.value.resize(2 * (filled + room), T::zero());
            }
            let steps = Steps::of_source(Atom::from_flat(i), map);
            filled += steps.write_basis(self.levels, &mut self.target[filled..], &mut self.value[filled..]);
            self.start.push(filled as u32);
        }
        self.target.truncate(filled);
        self.value.truncate(filled);
    }

    /// Turns to the derivative ∂D/∂s or ∂D/∂o of a map's operator, right-hand at kinks.
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::{AffineMap, Operator1d, Parameter};
    /// // The mean of φ(v + o) over [0, 1) is 1 − o for o ≥ 0.
    /// let mut slope = Operator1d::<f64>::new(1, AffineMap::IDENTITY)?;
    /// slope.set_derivative(AffineMap::IDENTITY, Parameter::Offset);
    /// assert_eq!(slope.row(0), (&[0][..], &[-1.0][..]));
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn set_derivative(&mut self, map: AffineMap, parameter: Parameter) {
        self.clear();
        for i in 0..1 << self.levels {
            let steps = Steps::of_source(Atom::from_flat(i), map);
            let velocity = steps.source_velocity(map, parameter);
            steps.basis_slopes(self.levels, velocity, |j, value| push(&mut self.target, &mut self.value, j, value));
            self.start.push(self.value.len() as u32);
        }
    }

    fn clear(&mut self) {
        self.start.clear();
        self.target.clear();
        self.value.clear();
        self.start.push(0);
    }

    /// L = Dᵀ F of a dense signal.
    ///
    /// # Panics
    /// If a length is not [`size`](Self::size).
    #[track_caller]
    pub fn apply(&self, source: &[T], target: &mut [T]) {
        check_length("source coefficients", self.size(), source.len());
        check_length("target coefficients", self.size(), target.len());
        target.fill(T::zero());
        for (i, &f) in source.iter().enumerate() {
            self.add_row(i, f, target);
        }
    }

    /// L = Dᵀ F of a sparse signal, as a dense one.
    ///
    /// # Panics
    /// If a length is not [`size`](Self::size).
    #[track_caller]
    pub fn apply_sparse(&self, source: &SparseVector<T>, target: &mut [T]) {
        check_length("source coefficients", self.size(), source.len());
        check_length("target coefficients", self.size(), target.len());
        target.fill(T::zero());
        for (i, f) in source.iter() {
            self.add_row(i, f, target);
        }
    }

    #[inline(always)]
    fn add_row(&self, i: usize, f: T, target: &mut [T]) {
        let (indices, values) = self.row(i);
        for (&j, &d) in indices.iter().zip(values) {
            target[j as usize] += f * d;
        }
    }

    /// G = D L: the transpose, with ⟨apply(F), L⟩ = ⟨F, apply_adjoint(L)⟩.
    ///
    /// # Panics
    /// If a length is not [`size`](Self::size).
    #[track_caller]
    pub fn apply_adjoint(&self, target: &[T], source: &mut [T]) {
        check_length("target coefficients", self.size(), target.len());
        check_length("source coefficients", self.size(), source.len());
        for (i, f) in source.iter_mut().enumerate() {
            let (indices, values) = self.row(i);
            *f = indices.iter().zip(values).map(|(&j, &d)| target[j as usize] * d).sum();
        }
    }
}

#[inline(always)]
fn push<T: Real>(target: &mut Vec<u32>, value: &mut Vec<T>, j: usize, d: f64) {
    target.push(j as u32);
    value.push(T::of(d));
}

/// F(s v + o) of the coefficients of a 1D signal: the one-shot form of [`Operator1d`].
///
/// # Errors
/// As [`Operator1d::new`], of the number of coefficients.
pub fn apply_map_1d<T: Real>(source: &[T], map: AffineMap) -> Result<Vec<T>> {
    let operator = Operator1d::new(source.len(), map)?;
    let mut target = vec![T::zero(); source.len()];
    operator.apply(source, &mut target);
    Ok(target)
}
