//! Sparse coefficient vectors.

use approx::{AbsDiffEq, RelativeEq, UlpsEq};

use crate::error::check_length;
use crate::{Error, Real, Result};

/// The non-zero coefficients of a vector: strictly ascending flat indices and their values.
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Unchecked<T>", bound(deserialize = "T: Real + serde::Deserialize<'de>"))
)]
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SparseVector<T> {
    len: usize,
    indices: Vec<u32>,
    values: Vec<T>,
}

/// What a stored vector says of itself.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Unchecked<T> {
    len: usize,
    indices: Vec<u32>,
    values: Vec<T>,
}

#[cfg(feature = "serde")]
impl<T: Real> TryFrom<Unchecked<T>> for SparseVector<T> {
    type Error = Error;

    fn try_from(vector: Unchecked<T>) -> Result<Self> {
        Self::new(vector.len, vector.indices, vector.values)
    }
}

impl<T: Real> SparseVector<T> {
    /// A vector of length `len` (the dense length) with `values` at `indices`.
    ///
    /// # Errors
    /// [`Error::Length`] unless there is one value an index; [`Error::OutOfRange`] unless the indices ascend strictly
    /// and stay below `len`.
    pub fn new(len: usize, indices: Vec<u32>, values: Vec<T>) -> Result<Self> {
        if indices.len() != values.len() {
            return Err(Error::Length { what: "sparse values", expected: indices.len(), got: values.len() });
        }
        let mut next = 0u64;
        for &i in &indices {
            if u64::from(i) < next || i as usize >= len {
                return Err(Error::OutOfRange {
                    what: "sparse index",
                    got: f64::from(i),
                    allowed: "above the index before it and below the vector's length",
                });
            }
            next = u64::from(i) + 1;
        }
        Ok(Self { len, indices, values })
    }

    /// A vector of length `len` from (index, value) pairs in any order; values of one index are added, in the order
    /// given.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless every index is below `len`.
    pub fn from_pairs(len: usize, pairs: impl IntoIterator<Item = (usize, T)>) -> Result<Self> {
        let mut sorted: Vec<(u32, T)> = Vec::new();
        for (i, v) in pairs {
            match u32::try_from(i) {
                Ok(index) if i < len => sorted.push((index, v)),
                _ => {
                    let allowed = "below the vector's length";
                    return Err(Error::OutOfRange { what: "sparse index", got: i as f64, allowed });
                }
            }
        }
        sorted.sort_by_key(|&(i, _)| i); // stable: sums in the order given
        let (mut indices, mut values) = (Vec::with_capacity(sorted.len()), Vec::<T>::with_capacity(sorted.len()));
        for (i, v) in sorted {
            match values.last_mut() {
                Some(last) if indices.last() == Some(&i) => *last += v,
                _ => {
                    indices.push(i);
                    values.push(v);
                }
            }
        }
        Ok(Self { len, indices, values })
    }

    /// The entries of a dense vector at `indices`, zeros included: several channels keep one set of indices.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn gather(dense: &[T], indices: &[u32]) -> Result<Self> {
        let values = indices.iter().map(|&i| dense.get(i as usize).copied().unwrap_or_default()).collect();
        Self::new(dense.len(), indices.to_vec(), values)
    }

    /// The non-zero entries of a dense vector.
    ///
    /// # Panics
    /// If `dense.len()` exceeds `u32::MAX`.
    #[track_caller]
    pub fn from_dense(dense: &[T]) -> Self {
        let len = u32::try_from(dense.len()).expect("a sparse vector's length fits u32");
        let indices: Vec<u32> = (0..len).filter(|&i| dense[i as usize] != T::zero()).collect();
        let values = indices.iter().map(|&i| dense[i as usize]).collect();
        Self { len: dense.len(), indices, values }
    }

    /// All coefficients, zeros included.
    pub fn to_dense(&self) -> Vec<T> {
        let mut dense = vec![T::zero(); self.len];
        for (i, v) in self.iter() {
            dense[i] = v;
        }
        dense
    }

    /// The dense length.
    #[inline]
    #[expect(clippy::len_without_is_empty, reason = "the dense length is a size, not a count of entries")]
    pub fn len(&self) -> usize {
        self.len
    }

    /// How many entries are stored.
    #[inline]
    pub fn nnz(&self) -> usize {
        self.indices.len()
    }

    /// The stored flat indices, strictly ascending.
    #[inline]
    pub fn indices(&self) -> &[u32] {
        &self.indices
    }

    /// The stored values.
    #[inline]
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// The stored (index, value) pairs, ascending.
    #[inline]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (usize, T)> + Clone + '_ {
        self.indices.iter().map(|&i| i as usize).zip(self.values.iter().copied())
    }

    /// Σ a_i b_i with a dense vector, summed in f64.
    ///
    /// # Panics
    /// If `dense.len()` is not [`len`](Self::len).
    #[track_caller]
    pub fn dot(&self, dense: &[T]) -> T {
        check_length("dense vector", self.len, dense.len());
        T::of(self.iter().fold(0.0, |sum, (i, v)| sum + v.widen() * dense[i].widen()))
    }

    /// Σ a_i b_i with a sparse vector, summed in f64. Cost: linear in the entries of both.
    ///
    /// # Panics
    /// If the dense lengths differ.
    #[track_caller]
    pub fn dot_sparse(&self, other: &Self) -> T {
        check_length("sparse vector", self.len, other.len);
        T::of(self.union(other).fold(0.0, |sum, (_, a, b)| sum + a.widen() * b.widen()))
    }

    /// √(Σ c²), summed in f64 without overflow: the L² norm of the function that the coefficients stand for.
    pub fn norm(&self) -> T {
        T::of(norm(self.values.iter().map(|v| v.widen())))
    }

    /// ‖self − dense‖ / ‖dense‖: by Parseval the relative L² error of the function. 0 if both vanish, infinite if only
    /// `dense` does.
    ///
    /// # Panics
    /// If `dense.len()` is not [`len`](Self::len).
    #[track_caller]
    pub fn relative_error(&self, dense: &[T]) -> f64 {
        check_length("dense vector", self.len, dense.len());
        let mut stored = self.iter().peekable();
        let difference = norm(dense.iter().enumerate().map(move |(i, d)| match stored.next_if(|&(at, _)| at == i) {
            Some((_, v)) => v.widen() - d.widen(),
            None => d.widen(),
        }));
        if difference == 0.0 { 0.0 } else { difference / norm(dense.iter().map(|d| d.widen())) }
    }

    /// Every value times `factor`; the indices stay, even if a value becomes 0.
    pub fn scaled(&self, factor: T) -> Self {
        let values = self.values.iter().map(|&v| v * factor).collect();
        Self { len: self.len, indices: self.indices.clone(), values }
    }

    /// (index, own value, other's value) at every index that either stores, ascending; 0 where one does not.
    fn union<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = (usize, T, T)> + 'a {
        let (mut ours, mut theirs) = (self.iter().peekable(), other.iter().peekable());
        std::iter::from_fn(move || {
            let ends = (ours.peek().map(|p| p.0), theirs.peek().map(|p| p.0));
            let at = match ends {
                (Some(i), Some(j)) => i.min(j),
                (i, j) => i.or(j)?,
            };
            let value = |p: Option<(usize, T)>| p.map_or(T::zero(), |p| p.1);
            Some((at, value(ours.next_if(|p| p.0 == at)), value(theirs.next_if(|p| p.0 == at))))
        })
    }
}

/// √(Σ x²), scaled by the largest magnitude so that squares neither overflow nor vanish.
fn norm(x: impl Iterator<Item = f64> + Clone) -> f64 {
    // `max` drops NaN; the sum below finds it again.
    let largest = x.clone().fold(0.0, |m: f64, x| m.max(x.abs()));
    if largest == 0.0 || largest.is_infinite() {
        return x.fold(0.0, |sum, x| sum + x.abs()); // (an empty `sum()` would be −0)
    }
    largest * x.map(|x| (x / largest).powi(2)).sum::<f64>().sqrt()
}

/// Entry by entry, where an entry that is not stored is 0; vectors of different lengths are never equal.
impl<T: Real + AbsDiffEq<Epsilon = T>> AbsDiffEq for SparseVector<T> {
    type Epsilon = T;

    fn default_epsilon() -> T {
        T::default_epsilon()
    }

    fn abs_diff_eq(&self, other: &Self, epsilon: T) -> bool {
        self.len == other.len && self.union(other).all(|(_, a, b)| a.abs_diff_eq(&b, epsilon))
    }
}

/// Entry by entry, as [`AbsDiffEq`].
impl<T: Real + RelativeEq<Epsilon = T>> RelativeEq for SparseVector<T> {
    fn default_max_relative() -> T {
        T::default_max_relative()
    }

    fn relative_eq(&self, other: &Self, epsilon: T, max_relative: T) -> bool {
        self.len == other.len && self.union(other).all(|(_, a, b)| a.relative_eq(&b, epsilon, max_relative))
    }
}

/// Entry by entry, as [`AbsDiffEq`].
impl<T: Real + UlpsEq<Epsilon = T>> UlpsEq for SparseVector<T> {
    fn default_max_ulps() -> u32 {
        T::default_max_ulps()
    }

    fn ulps_eq(&self, other: &Self, epsilon: T, max_ulps: u32) -> bool {
        self.len == other.len && self.union(other).all(|(_, a, b)| a.ulps_eq(&b, epsilon, max_ulps))
    }
}
