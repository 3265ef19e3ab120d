//! Greedy growth of one bicluster.
//!
//! With m_k the count of the most frequent non-zero value of column k over the rows R, z_k its zeros there, r = |R|,
//! l = |C|:
//! ```math
//! ΔW = 2 nnz(M) − (r + 2l − 1) − 2 nnz(M_R) = Σ_{k∈C} 2 (m_k − z_k − 1) − (r − 1)
//! ```
//! because nnz(M) = Σ (r − z_k) and nnz(M_R) = Σ (r − m_k). Hence what each move gains, with "mode" a value that occurs
//! m_k times:
//! - add column k:    2 (m_k + nnz_k − r − 1), nnz_k = r − z_k
//! - add row i:       2 s_i − 2l − 1,  s_i = Σ_{k∈C, T_ik≠0} (1 + \[T_ik is a mode of k\])
//! - delete row i:    1 + 2l − 2 u_i,  u_i = Σ_{k∈C, T_ik≠0} (1 + \[T_ik is the only mode of k\])
//! - delete column k: the negative of adding it.
//!
//! r and l are the same for all candidates of a kind, so a queue keyed by m_k + nnz_k, and one keyed by s_i, stay valid
//! while they change: a move touches only rows and columns that share a non-zero with the row or column that moves. A
//! column that is empty over R has t = 0 and an empty residual: it contributes −2 whatever r is. Only deletions of rows
//! lead there; `soles` and `empties` count the columns for which the formulas above need a correction.

use super::histogram::Histogram;
use super::queue::BucketQueue;
use super::residual::Residual;
use super::trace::{BiclusterMove, BiclusterStep};

/// Work space for growing biclusters of one matrix, one after another.
pub(super) struct Growth {
    rows: Vec<u32>,
    columns: Vec<u32>,
    row_in: Vec<bool>,
    column_in: Vec<bool>,
    /// s_i of rows outside, u_i of rows inside.
    row_keys: Vec<u32>,
    histograms: Vec<Histogram>,
    row_queue: BucketQueue,
    column_queue: BucketQueue,
    row_touched: Touched,
    column_touched: Touched,
    /// Chosen columns with one non-zero in the chosen rows, and with none.
    soles: usize,
    empties: usize,
    modes: Vec<i32>,
}

/// Which items differ from their initial state.
struct Touched {
    is: Vec<bool>,
    list: Vec<u32>,
}

impl Touched {
    fn new(items: usize) -> Self {
        Self { is: vec![false; items], list: Vec::new() }
    }

    #[inline]
    fn touch(&mut self, item: usize) {
        if !std::mem::replace(&mut self.is[item], true) {
            self.list.push(item as u32);
        }
    }
}

/// A finished bicluster, ascending.
pub(super) struct Grown {
    pub(super) rows: Vec<u32>,
    pub(super) columns: Vec<u32>,
    pub(super) levels: Vec<i32>,
    pub(super) saving: i64,
}

impl Growth {
    pub(super) fn new(rows: usize, columns: usize) -> Self {
        Self {
            rows: Vec::new(),
            columns: Vec::new(),
            row_in: vec![false; rows],
            column_in: vec![false; columns],
            row_keys: vec![0; rows],
            histograms: vec![Histogram::default(); columns],
            row_queue: BucketQueue::new(rows),
            column_queue: BucketQueue::new(columns),
            row_touched: Touched::new(rows),
            column_touched: Touched::new(columns),
            soles: 0,
            empties: 0,
            modes: Vec::new(),
        }
    }

    /// Grows from a non-zero element until no move saves more; tells `step` each move.
    pub(super) fn grow(
        &mut self,
        matrix: &Residual,
        seed: (usize, usize),
        mut step: impl FnMut(BiclusterStep),
    ) -> Grown {
        self.add_row(matrix, seed.0);
        self.add_column(matrix, seed.1);
        let mut saving = 0;
        while let Some((kind, index, gain)) = self.best_move(matrix) {
            match kind {
                BiclusterMove::AddRow => self.add_row(matrix, index),
                BiclusterMove::AddColumn => self.add_column(matrix, index),
                BiclusterMove::DeleteRow => self.delete_row(matrix, index),
                BiclusterMove::DeleteColumn => self.delete_column(matrix, index),
            }
            saving += gain;
            step(BiclusterStep { kind, index, saving });
        }
        self.finish(saving)
    }

    fn add_row(&mut self, matrix: &Residual, row: usize) {
        self.row_queue.set(row, 0);
        self.row_touched.touch(row);
        self.row_in[row] = true;
        self.rows.push(row as u32);
        let mut only = 0;
        for e in &matrix.rows[row] {
            let column = e.index as usize;
            self.column_touched.touch(column);
            let changed = self.histograms[column].add(e.level, &mut self.modes);
            if !self.column_in[column] {
                self.column_queue.set(column, self.histograms[column].key());
                continue;
            }
            match self.histograms[column].total() {
                1 => (self.empties, self.soles) = (self.empties - 1, self.soles + 1),
                2 => self.soles -= 1,
                _ => {}
            }
            if changed {
                self.modes_changed(matrix, column, row);
            }
            only += 1 + u32::from(self.histograms[column].is_only_mode(e.level));
        }
        self.row_keys[row] = only;
    }

    fn delete_row(&mut self, matrix: &Residual, row: usize) {
        self.row_in[row] = false;
        self.rows.retain(|&r| r as usize != row);
        let mut shared = 0;
        for e in &matrix.rows[row] {
            let column = e.index as usize;
            let changed = self.histograms[column].remove(e.level, &mut self.modes);
            if !self.column_in[column] {
                self.column_queue.set(column, self.histograms[column].key());
                continue;
            }
            match self.histograms[column].total() {
                0 => (self.empties, self.soles) = (self.empties + 1, self.soles - 1),
                1 => self.soles += 1,
                _ => {}
            }
            if changed {
                self.modes_changed(matrix, column, row);
            }
            shared += 1 + u32::from(self.histograms[column].is_mode(e.level));
        }
        self.row_keys[row] = shared;
        self.row_queue.set(row, shared);
    }

    /// Updates s_i and u_i of the rows of a column but for the one that moves, which is counted afresh.
    fn modes_changed(&mut self, matrix: &Residual, column: usize, moving: usize) {
        let (histogram, before) = (&self.histograms[column], self.modes.as_slice());
        for e in &matrix.columns[column] {
            let row = e.index as usize;
            let (old, new) = if self.row_in[row] {
                (before == [e.level], histogram.is_only_mode(e.level))
            } else {
                (before.contains(&e.level), histogram.is_mode(e.level))
            };
            if old == new || row == moving {
                continue;
            }
            let key = &mut self.row_keys[row];
            *key = if new { *key + 1 } else { *key - 1 };
            if !self.row_in[row] {
                self.row_queue.set(row, *key);
            }
        }
    }

    fn add_column(&mut self, matrix: &Residual, column: usize) {
        self.column_queue.set(column, 0);
        self.column_in[column] = true;
        self.columns.push(column as u32);
        self.soles += usize::from(self.histograms[column].total() == 1);
        for e in &matrix.columns[column] {
            let row = e.index as usize;
            if self.row_in[row] {
                self.row_keys[row] += 1 + u32::from(self.histograms[column].is_only_mode(e.level));
            } else {
                self.row_touched.touch(row);
                self.row_keys[row] += 1 + u32::from(self.histograms[column].is_mode(e.level));
                self.row_queue.set(row, self.row_keys[row]);
            }
        }
    }

    fn delete_column(&mut self, matrix: &Residual, column: usize) {
        self.column_in[column] = false;
        self.columns.retain(|&c| c as usize != column);
        match self.histograms[column].total() {
            0 => self.empties -= 1,
            1 => self.soles -= 1,
            _ => {}
        }
        for e in &matrix.columns[column] {
            let row = e.index as usize;
            if self.row_in[row] {
                self.row_keys[row] -= 1 + u32::from(self.histograms[column].is_only_mode(e.level));
            } else {
                self.row_keys[row] -= 1 + u32::from(self.histograms[column].is_mode(e.level));
                self.row_queue.set(row, self.row_keys[row]);
            }
        }
        self.column_queue.set(column, self.histograms[column].key());
    }

    /// The move that gains most, if any gains: of equals the first in the order of [`BiclusterMove`], then the lowest
    /// index.
    fn best_move(&mut self, matrix: &Residual) -> Option<(BiclusterMove, usize, i64)> {
        let moves = [
            self.best_row(matrix).map(|m| (BiclusterMove::AddRow, m)),
            self.best_column().map(|m| (BiclusterMove::AddColumn, m)),
            self.worst_row(matrix).map(|m| (BiclusterMove::DeleteRow, m)),
            self.worst_column().map(|m| (BiclusterMove::DeleteColumn, m)),
        ];
        let mut best = None;
        let mut most = 0;
        for (kind, (index, gain)) in moves.into_iter().flatten() {
            if gain > most {
                (best, most) = (Some((kind, index, gain)), gain);
            }
        }
        best
    }

    fn best_row(&mut self, matrix: &Residual) -> Option<(usize, i64)> {
        let columns = self.columns.len() as i64;
        let gain = |key: u32| 2 * i64::from(key) - 2 * columns - 1;
        if self.empties == 0 {
            let (key, row) = self.row_queue.best(self.columns.len() as u32 + 1)?;
            return Some((row, gain(key)));
        }
        // Zeros of empty columns cost nothing there (formula: −2), non-zeros −2r + 2 (formula: 0).
        let outside = self.row_touched.list.iter().map(|&row| row as usize).filter(|&row| !self.row_in[row]);
        let exact = |row: usize| {
            let empty = |column: usize| self.column_in[column] && self.histograms[column].total() == 0;
            let filled = matrix.rows[row].iter().filter(|e| empty(e.index as usize)).count();
            gain(self.row_keys[row]) + 2 * self.empties as i64 - 2 * (self.rows.len() * filled) as i64
        };
        best_of(outside.map(|row| (row, exact(row))))
    }

    fn best_column(&mut self) -> Option<(usize, i64)> {
        let rows = self.rows.len() as u32;
        let (key, column) = self.column_queue.best(rows + 2)?;
        Some((column, 2 * (i64::from(key) - i64::from(rows) - 1)))
    }

    fn worst_row(&self, matrix: &Residual) -> Option<(usize, i64)> {
        let (r, l) = (self.rows.len() as i64, self.columns.len() as i64);
        if r < 2 {
            return None;
        }
        // An empty column gains nothing from a zero less (formula: 2); a column that becomes empty goes from −2 (r − 1)
        // to −2 (formula: −2, only mode).
        let gain = |row: usize| 1 + 2 * l - 2 * i64::from(self.row_keys[row]) - 2 * self.empties as i64;
        let rows = self.rows.iter().map(|&row| row as usize);
        if self.soles == 0 {
            return best_of(rows.map(|row| (row, gain(row))));
        }
        let most = (2 * r - 2) * self.soles as i64;
        let sole = |column: usize| self.column_in[column] && self.histograms[column].total() == 1;
        best_of(rows.filter(|&row| gain(row) + most > 0).map(|row| {
            let soles = matrix.rows[row].iter().filter(|e| sole(e.index as usize)).count();
            (row, gain(row) + (2 * r - 2) * soles as i64)
        }))
    }

    fn worst_column(&self) -> Option<(usize, i64)> {
        if self.columns.len() < 2 {
            return None;
        }
        let r = self.rows.len() as i64;
        best_of(self.columns.iter().map(|&column| {
            let histogram = &self.histograms[column as usize];
            let gain = if histogram.max() == 0 { 2 } else { 2 * (r + 1 - i64::from(histogram.key())) };
            (column as usize, gain)
        }))
    }

    /// Hands over the bicluster and empties the work space.
    fn finish(&mut self, saving: i64) -> Grown {
        let (mut rows, mut columns) = (std::mem::take(&mut self.rows), std::mem::take(&mut self.columns));
        rows.sort_unstable();
        columns.sort_unstable();
        let mode = |&column: &u32| {
            self.histograms[column as usize].mode().expect("deleting an empty column gains, so none is left")
        };
        let levels = columns.iter().map(mode).collect();
        for &row in &self.row_touched.list {
            let row = row as usize;
            (self.row_in[row], self.row_keys[row], self.row_touched.is[row]) = (false, 0, false);
            self.row_queue.set(row, 0);
        }
        for &column in &self.column_touched.list {
            let column = column as usize;
            (self.column_in[column], self.column_touched.is[column]) = (false, false);
            self.histograms[column].clear();
            self.column_queue.set(column, 0);
        }
        self.row_touched.list.clear();
        self.column_touched.list.clear();
        (self.soles, self.empties) = (0, 0);
        Grown { rows, columns, levels, saving }
    }
}

/// The largest gain and the lowest index that has it.
fn best_of(moves: impl Iterator<Item = (usize, i64)>) -> Option<(usize, i64)> {
    moves.max_by(|a, b| a.1.cmp(&b.1).then(b.0.cmp(&a.0)))
}

#[cfg(all(test, feature = "reference"))]
mod tests {
    use super::super::residual::Entry;
    use super::*;
    use crate::reference::compress::bicluster_saving;

    /// Numbers without a pattern.
    struct Random(u32);

    impl Random {
        fn below(&mut self, limit: usize) -> usize {
            self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (self.0 >> 16) as usize % limit
        }
    }

    /// The first move that gains most, from the definition of ΔW.
    fn best_by_definition(
        matrix: &[Vec<i64>],
        rows: &[usize],
        columns: &[usize],
    ) -> Option<(BiclusterMove, usize, i64)> {
        let without = |list: &[usize], i| list.iter().copied().filter(|&item| item != i).collect::<Vec<_>>();
        let with = |list: &[usize], i| [list, &[i]].concat();
        let mut moves = Vec::new();
        let other_rows = (0..matrix.len()).filter(|i| !rows.contains(i));
        moves.extend(other_rows.map(|i| (BiclusterMove::AddRow, i, with(rows, i), columns.to_vec())));
        let other_columns = (0..matrix[0].len()).filter(|i| !columns.contains(i));
        moves.extend(other_columns.map(|i| (BiclusterMove::AddColumn, i, rows.to_vec(), with(columns, i))));
        let (mut rows, mut columns) = (rows.to_vec(), columns.to_vec());
        rows.sort_unstable();
        columns.sort_unstable();
        let now = bicluster_saving(matrix, &rows, &columns);
        if rows.len() > 1 {
            moves.extend(rows.iter().map(|&i| (BiclusterMove::DeleteRow, i, without(&rows, i), columns.clone())));
        }
        if columns.len() > 1 {
            moves.extend(columns.iter().map(|&i| (BiclusterMove::DeleteColumn, i, rows.clone(), without(&columns, i))));
        }
        let mut best = None;
        for (kind, index, r, c) in moves {
            let gain = bicluster_saving(matrix, &r, &c) - now;
            if gain > best.map_or(0, |b: (_, _, i64)| b.2) {
                best = Some((kind, index, gain));
            }
        }
        best
    }

    /// Also submatrices that greedy growth does not pass through: with columns that are empty, or have a single
    /// non-zero.
    #[test]
    fn the_best_move_of_any_submatrix_is_that_of_the_definition() {
        let mut random = Random(1);
        for round in 0..1500 {
            let (height, width) = (1 + random.below(6), 1 + random.below(6));
            let density = 1 + random.below(4);
            let mut value = |_| if random.below(4) < density { random.below(5) as i64 - 2 } else { 0 };
            let dense: Vec<Vec<i64>> = (0..height).map(|_| (0..width).map(&mut value).collect()).collect();
            let entries = |row: &Vec<i64>| -> Vec<Entry> {
                let all = row.iter().enumerate().filter(|(_, v)| **v != 0);
                all.map(|(k, &v)| Entry { index: k as u32, level: v as i32 }).collect()
            };
            let matrix = Residual::new(dense.iter().map(entries).collect(), width);
            let mut growth = Growth::new(height, width);
            let (mut rows, mut columns) = (vec![random.below(height)], vec![random.below(width)]);
            growth.add_row(&matrix, rows[0]);
            growth.add_column(&matrix, columns[0]);
            growth.empties += usize::from(dense[rows[0]][columns[0]] == 0); // a seed is never zero in a search
            for step in 0..12 {
                let (row, column) = (random.below(height), random.below(width));
                match random.below(2) {
                    0 if !rows.contains(&row) => {
                        growth.add_row(&matrix, row);
                        rows.push(row);
                    }
                    0 if rows.len() > 1 => {
                        growth.delete_row(&matrix, row);
                        rows.retain(|&i| i != row);
                    }
                    1 if !columns.contains(&column) && growth.histograms[column].total() > 0 => {
                        growth.add_column(&matrix, column);
                        columns.push(column);
                    }
                    1 if columns.contains(&column) && columns.len() > 1 => {
                        growth.delete_column(&matrix, column);
                        columns.retain(|&i| i != column);
                    }
                    _ => {}
                }
                let want = best_by_definition(&dense, &rows, &columns);
                assert_eq!(
                    growth.best_move(&matrix),
                    want,
                    "round {round}, step {step}: {dense:?} {rows:?} {columns:?}"
                );
            }
        }
    }
}
