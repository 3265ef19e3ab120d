//! Sparse coefficient vectors.

use crate::{Error, Real, Result};

/// The non-zero coefficients of a vector: strictly ascending flat indices and their values.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SparseVector<T> {
    len: usize,
    indices: Vec<u32>,
    values: Vec<T>,
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

    /// The non-zero entries of a dense vector.
    ///
    /// # Panics
    /// If `dense.len()` exceeds `u32::MAX`.
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
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (usize, T)> + '_ {
        self.indices.iter().map(|&i| i as usize).zip(self.values.iter().copied())
    }
}
