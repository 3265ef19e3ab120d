//! Single elements, without the rest of their rows.

use super::super::pca::{check_index, column_of, entry_of, entry_of_column};
use super::coded::ClusteredPca;
use crate::Real;
use crate::error::check_length;

impl<T: Real> ClusteredPca<T> {
    /// One element of the matrix: the bits of [`reconstruct`](Self::reconstruct), at the cost of
    /// [`components`](Self::components) multiplications and additions.
    ///
    /// # Panics
    /// If `row` or `column` is out of range.
    #[track_caller]
    pub fn entry(&self, row: usize, column: usize) -> T {
        check_index("row", row, self.rows());
        check_index("column", column, self.columns());
        self.entry_at(row, column)
    }

    /// Elements of one row: `out[i]` is that of `columns[i]`, any columns in any order.
    ///
    /// # Panics
    /// If `row` or a column is out of range, or `out` is not as long as `columns`.
    #[track_caller]
    pub fn row_entries(&self, row: usize, columns: &[usize], out: &mut [T]) {
        check_length("entries", columns.len(), out.len());
        check_index("row", row, self.rows());
        columns.iter().for_each(|&column| check_index("column", column, self.columns()));
        out.iter_mut().zip(columns).for_each(|(out, &column)| *out = self.entry_at(row, column));
    }

    /// Elements of one column: `out[i]` is that of `rows[i]`, any rows in any order.
    ///
    /// What the column has of all means and components is gathered once, in `scratch`; each row is then a dot product.
    /// For a few rows only, [`entries`](Self::entries) does less.
    ///
    /// # Panics
    /// If `column` or a row is out of range, `out` is not as long as `rows`, or `scratch` is not
    /// [`scratch_len(1)`](Self::scratch_len) long.
    #[track_caller]
    pub fn column_entries(&self, column: usize, rows: &[usize], out: &mut [T], scratch: &mut [T]) {
        check_length("entries", rows.len(), out.len());
        check_length("scratch", self.scratch_len(1), scratch.len());
        check_index("column", column, self.columns());
        rows.iter().for_each(|&row| check_index("row", row, self.rows()));
        let size = self.components() + 1;
        for (cluster, out) in scratch.chunks_exact_mut(size).enumerate() {
            let (mean, components) = self.bases.cluster(cluster);
            column_of(mean, components, column, out);
        }
        for (out, &row) in out.iter_mut().zip(rows) {
            let column = &scratch[self.labels[row] as usize * size..][..size];
            *out = entry_of_column(column, self.weights_of(row));
        }
    }

    /// Elements anywhere: `out[i]` is that of row `places[i].0` and column `places[i].1`.
    ///
    /// # Panics
    /// If a place is out of range or `out` is not as long as `places`.
    ///
    /// # Example
    /// ```
    /// use haarmonic::compress::{ClusteredPca, ClusteredPcaSettings};
    /// let points: Vec<f32> = (0..10).flat_map(|i| [i as f32, 1.0, -20.0, i as f32]).collect();
    /// let coded = ClusteredPca::new(&points, 2, &ClusteredPcaSettings::new(2, 1), &())?;
    /// let mut out = [0.0; 2];
    /// coded.entries(&[(6, 0), (7, 1)], &mut out);
    /// assert!((out[0] - 3.0).abs() < 1e-5 && (out[1] - 3.0).abs() < 1e-5);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    #[track_caller]
    pub fn entries(&self, places: &[(usize, usize)], out: &mut [T]) {
        check_length("entries", places.len(), out.len());
        for &(row, column) in places {
            check_index("row", row, self.rows());
            check_index("column", column, self.columns());
        }
        out.iter_mut().zip(places).for_each(|(out, &(row, column))| *out = self.entry_at(row, column));
    }

    #[inline(always)]
    fn entry_at(&self, row: usize, column: usize) -> T {
        let (mean, components) = self.bases.cluster(self.labels[row] as usize);
        entry_of(mean, components, self.weights_of(row), column)
    }

    #[inline(always)]
    fn weights_of(&self, row: usize) -> &[T] {
        let k = self.components();
        &self.weights[row * k..][..k]
    }
}
