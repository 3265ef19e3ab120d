//! Single elements of rows that are stored as weights, without the rest of their rows.

use super::components::Pca;
use crate::Real;
use crate::error::check_length;

/// mean + Σ w_j u_j at a column; the order of the sum is that of whole rows, and so are the bits.
#[inline(always)]
pub(in super::super) fn entry_of<T: Real>(mean: &[T], components: &[T], weights: &[T], column: usize) -> T {
    let mut sum = mean[column];
    for (&weight, component) in weights.iter().zip(components.chunks_exact(mean.len())) {
        sum += weight * component[column];
    }
    sum
}

/// The same from what a column has of the mean and of each component.
#[inline(always)]
pub(in super::super) fn entry_of_column<T: Real>(column: &[T], weights: &[T]) -> T {
    let (&mean, components) = column.split_first().expect("the mean");
    weights.iter().zip(components).fold(mean, |sum, (&weight, &u)| sum + weight * u)
}

/// What a column has of the mean and of each component.
pub(in super::super) fn column_of<T: Real>(mean: &[T], components: &[T], column: usize, out: &mut [T]) {
    let (first, rest) = out.split_first_mut().expect("a place for the mean");
    *first = mean[column];
    rest.iter_mut().zip(components.chunks_exact(mean.len())).for_each(|(out, u)| *out = u[column]);
}

#[track_caller]
pub(in super::super) fn check_index(what: &str, index: usize, count: usize) {
    assert!(index < count, "{what} {index} of {count}");
}

impl<T: Real> Pca<T> {
    /// One element of the row that has these weights: the bits of [`reconstruct`](Self::reconstruct), at the cost of
    /// [`len`](Self::len) multiplications and additions.
    ///
    /// # Panics
    /// If `weights.len()` is not [`len`](Self::len) or `column` is out of range.
    #[track_caller]
    pub fn entry(&self, weights: &[T], column: usize) -> T {
        check_length("weights", self.len(), weights.len());
        check_index("column", column, self.columns());
        entry_of(self.mean(), self.components(), weights, column)
    }

    /// Elements of the row that has these weights: `out[i]` is that of `columns[i]`, any columns in any order.
    ///
    /// # Panics
    /// If `weights.len()` is not [`len`](Self::len), `out` is not as long as `columns`, or one of those is out of
    /// range.
    #[track_caller]
    pub fn row_entries(&self, weights: &[T], columns: &[usize], out: &mut [T]) {
        check_length("weights", self.len(), weights.len());
        check_length("entries", columns.len(), out.len());
        columns.iter().for_each(|&column| check_index("column", column, self.columns()));
        for (out, &column) in out.iter_mut().zip(columns) {
            *out = entry_of(self.mean(), self.components(), weights, column);
        }
    }

    /// Elements of one column: `out[i]` is that of the row whose weights are number i of `weights`, row after row.
    ///
    /// What the column has of the components is gathered once, in `scratch`; each row is then a dot product.
    ///
    /// # Panics
    /// If `weights` does not hold [`len`](Self::len) numbers for each of `out`, `column` is out of range, or `scratch`
    /// is not [`len`](Self::len) + 1 long.
    ///
    /// # Example
    /// ```
    /// use haarmonic::compress::{Pca, PcaSettings};
    /// let points = [1.0, 2.0, 5.0, 5.0, -3.0, -1.0];
    /// let pca = Pca::new(&points, 2, &PcaSettings::new(1))?;
    /// let (mut weights, mut heights, mut scratch) = ([0.0; 3], [0.0f64; 3], [0.0; 2]);
    /// pca.project(&points, &mut weights);
    /// pca.column_entries(&weights, 1, &mut heights, &mut scratch);
    /// assert!((heights[2] + 1.0).abs() < 1e-14 && heights[2] == pca.entry(&weights[2..], 1));
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    #[track_caller]
    pub fn column_entries(&self, weights: &[T], column: usize, out: &mut [T], scratch: &mut [T]) {
        check_length("weights", self.len().saturating_mul(out.len()), weights.len());
        check_length("scratch", self.len() + 1, scratch.len());
        check_index("column", column, self.columns());
        column_of(self.mean(), self.components(), column, scratch);
        for (row, out) in out.iter_mut().enumerate() {
            *out = entry_of_column(scratch, &weights[row * self.len()..][..self.len()]);
        }
    }

    /// Elements anywhere: `out[i]` is that of row `places[i].0` and column `places[i].1`, where rows are those of
    /// `weights`.
    ///
    /// # Panics
    /// Unless `weights` holds whole rows of [`len`](Self::len) numbers and every place is in range, or if `out` is not
    /// as long as `places`.
    #[track_caller]
    pub fn entries(&self, weights: &[T], places: &[(usize, usize)], out: &mut [T]) {
        check_length("entries", places.len(), out.len());
        // Without components every row is the mean.
        let rows = if self.is_empty() { usize::MAX } else { weights.len() / self.len() };
        check_length("weights", if self.is_empty() { 0 } else { rows * self.len() }, weights.len());
        for &(row, column) in places {
            check_index("row", row, rows);
            check_index("column", column, self.columns());
        }
        for (out, &(row, column)) in out.iter_mut().zip(places) {
            let weights = if self.is_empty() { weights } else { &weights[row * self.len()..][..self.len()] };
            *out = entry_of(self.mean(), self.components(), weights, column);
        }
    }
}
