//! What of a matrix is not yet covered by biclusters.

/// A non-zero entry of a row (or column): its column (or row) and level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Entry {
    pub(super) index: u32,
    pub(super) level: i32,
}

/// T_c: the entries by row and by column, both sorted, none zero.
#[derive(Debug, Clone)]
pub(super) struct Residual {
    pub(super) rows: Vec<Vec<Entry>>,
    pub(super) columns: Vec<Vec<Entry>>,
    pub(super) nnz: usize,
    scratch: Vec<Entry>,
}

/// Some level of the difference would not fit.
pub(super) struct Overflow;

impl Residual {
    pub(super) fn new(rows: Vec<Vec<Entry>>, columns: usize) -> Self {
        let mut counts = vec![0; columns];
        rows.iter().flatten().for_each(|e| counts[e.index as usize] += 1);
        let mut by_column: Vec<Vec<Entry>> = counts.iter().map(|&n| Vec::with_capacity(n)).collect();
        for (row, entries) in rows.iter().enumerate() {
            for e in entries {
                by_column[e.index as usize].push(Entry { index: row as u32, level: e.level });
            }
        }
        Self { nnz: counts.iter().sum(), rows, columns: by_column, scratch: Vec::new() }
    }

    pub(super) fn level(&self, row: usize, column: usize) -> i32 {
        let entries = &self.rows[row];
        entries.binary_search_by_key(&(column as u32), |e| e.index).map_or(0, |at| entries[at].level)
    }

    /// T_c[R, k] −= t_k; rows and columns ascend. Nothing changes if a level would overflow.
    pub(super) fn subtract(&mut self, rows: &[u32], columns: &[u32], levels: &[i32]) -> Result<(), Overflow> {
        for (&column, &t) in columns.iter().zip(levels) {
            let overflows = |e: &Entry| e.level.checked_sub(t).is_none();
            let entries = &self.columns[column as usize];
            let of_zero = t == i32::MIN && rows.len() > 1;
            if of_zero || entries.iter().any(|e| overflows(e) && rows.binary_search(&e.index).is_ok()) {
                return Err(Overflow);
            }
        }
        for &row in rows {
            let line = &mut self.rows[row as usize];
            let before = line.len();
            subtract_line(line, columns.iter().copied().zip(levels.iter().copied()), &mut self.scratch);
            self.nnz = self.nnz - before + line.len();
        }
        for (&column, &t) in columns.iter().zip(levels) {
            let line = &mut self.columns[column as usize];
            subtract_line(line, rows.iter().map(|&row| (row, t)), &mut self.scratch);
        }
        Ok(())
    }
}

/// line −= (index, level) pairs, both ascending.
fn subtract_line(line: &mut Vec<Entry>, pairs: impl Iterator<Item = (u32, i32)>, scratch: &mut Vec<Entry>) {
    scratch.clear();
    let mut rest = line.as_slice();
    for (index, level) in pairs {
        let smaller = rest.partition_point(|e| e.index < index);
        scratch.extend_from_slice(&rest[..smaller]);
        rest = &rest[smaller..];
        let old = match rest.split_first() {
            Some((first, others)) if first.index == index => {
                rest = others;
                first.level
            }
            _ => 0,
        };
        if old != level {
            scratch.push(Entry { index, level: old - level });
        }
    }
    scratch.extend_from_slice(rest);
    line.clear();
    line.extend_from_slice(scratch);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_overflow_changes_nothing() {
        let row = |levels: [i32; 2]| (0..2).map(|k| Entry { index: k as u32, level: levels[k] }).collect::<Vec<_>>();
        let mut residual = Residual::new(vec![row([1, i32::MAX]), row([1, -2])], 2);
        let before = residual.clone();
        assert!(residual.subtract(&[0, 1], &[0, 1], &[1, 7]).is_ok());
        assert_eq!((residual.nnz, residual.level(1, 1)), (2, -9));
        let mut residual = before.clone();
        for levels in [[1, -2], [i32::MIN, 1]] {
            assert!(residual.subtract(&[0, 1], &[0, 1], &levels).is_err());
            assert_eq!((&residual.rows, &residual.columns, residual.nnz), (&before.rows, &before.columns, 4));
        }
        // An element alone always fits.
        let mut residual = Residual::new(vec![row([i32::MIN, 3])], 2);
        assert!(residual.subtract(&[0], &[0], &[i32::MIN]).is_ok());
        assert_eq!(residual.nnz, 1);
    }
}
