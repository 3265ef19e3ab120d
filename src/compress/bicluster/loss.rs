//! What elements of a matrix have lost.

use super::clusters::Biclustering;
use crate::numeric::CompensatedSum;

/// The levels that were taken from each place that any bicluster has.
pub(super) struct Loss<'a> {
    weights: &'a [Vec<f64>; 2],
    /// Where the places of each row begin.
    offsets: Vec<usize>,
    /// Their columns, ascending in a row.
    columns: Vec<u32>,
    lost: Vec<i64>,
}

impl<'a> Loss<'a> {
    pub(super) fn new(all: &Biclustering, weights: &'a [Vec<f64>; 2]) -> Self {
        let mut of_row: Vec<Vec<u32>> = vec![Vec::new(); all.rows];
        for at in 0..all.len() {
            all.rows_of(at).iter().for_each(|&row| of_row[row as usize].push(at as u32));
        }
        let (mut offsets, mut columns, mut row_columns) = (vec![0], Vec::new(), Vec::new());
        for members in of_row {
            row_columns.clear();
            for at in members {
                let range = all.column_offsets[at as usize]..all.column_offsets[at as usize + 1];
                row_columns.extend_from_slice(&all.column_indices[range]);
            }
            row_columns.sort_unstable();
            row_columns.dedup();
            columns.extend_from_slice(&row_columns);
            offsets.push(columns.len());
        }
        let lost = vec![0; columns.len()];
        Self { weights, offsets, columns, lost }
    }

    /// Takes a level from a column of some rows; `changed` gets what the error rises by in each, in squared levels.
    pub(super) fn take(&mut self, rows: &[u32], column: u32, level: i32, mut changed: impl FnMut(f64)) {
        let weight = self.weights[1][column as usize];
        for &row in rows {
            let places = self.offsets[row as usize]..self.offsets[row as usize + 1];
            let Ok(at) = self.columns[places.clone()].binary_search(&column) else { continue };
            let lost = &mut self.lost[places.start + at];
            let before = *lost;
            *lost += i64::from(level);
            // (a + t)² − a² = t (2a + t)
            changed(self.weights[0][row as usize] * weight * (f64::from(level) * (before + *lost) as f64));
        }
    }

    /// The error, in squared levels.
    pub(super) fn squared(&self) -> f64 {
        let mut sum = CompensatedSum::default();
        for (row, ends) in self.offsets.windows(2).enumerate() {
            for at in ends[0]..ends[1] {
                let lost = self.lost[at] as f64;
                sum.add(self.weights[0][row] * self.weights[1][self.columns[at] as usize] * (lost * lost));
            }
        }
        sum.total()
    }
}
