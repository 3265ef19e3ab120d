//! Biclusterings from their parts, and their file form.
//!
//! ```text
//! SIZE  rows u64, columns u64, scale f64
//! ROWS  list of where each bicluster's rows end u64, list of rows u32
//! COLS  the same of columns, list of levels i32
//! ```

use super::clusters::{Bicluster, Biclustering};
use super::matrix::{SparseMatrix, check_shape};
use crate::store::parts::Parts;
use crate::store::{Kind, Reader, Writer};
use crate::{Error, Result};

/// Elements of the matrix, counted once for each bicluster that has them, at most: checking them takes half a minute.
const MOST_ELEMENTS: u64 = 1 << 32;

impl Biclustering {
    /// From biclusters of a matrix of `rows` × `columns`, of which a level of 1 stands for `scale`: for those that were
    /// stored.
    ///
    /// Cost: looks at every element of every bicluster once.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a size of 2^31 or more, a scale that is not positive and finite, biclusters of more
    /// than 2^32 elements together, and levels that add up to more than [`SparseMatrix::MAX_LEVEL`]; [`Error::Index`]
    /// for a row or column that is not there; [`Error::Damaged`] for rows or columns that do not rise, or are none, and
    /// levels of 0.
    pub fn from_parts<'a>(
        rows: usize,
        columns: usize,
        scale: f64,
        biclusters: impl IntoIterator<Item = Bicluster<'a>>,
    ) -> Result<Self> {
        let mut all = Self::empty(rows, columns, scale)?;
        for (at, bicluster) in biclusters.into_iter().enumerate() {
            check(at, &bicluster, rows, columns)?;
            all.push(&bicluster);
        }
        all.count_nonzeros()?;
        Ok(all)
    }

    pub(super) fn empty(rows: usize, columns: usize, scale: f64) -> Result<Self> {
        check_shape(rows, columns, scale)?;
        Ok(Self {
            rows,
            columns,
            scale,
            nnz: 0,
            row_offsets: vec![0],
            row_indices: Vec::new(),
            column_offsets: vec![0],
            column_indices: Vec::new(),
            levels: Vec::new(),
        })
    }

    pub(super) fn push(&mut self, bicluster: &Bicluster<'_>) {
        self.row_indices.extend_from_slice(bicluster.rows);
        self.column_indices.extend_from_slice(bicluster.columns);
        self.levels.extend_from_slice(bicluster.levels);
        self.row_offsets.push(self.row_indices.len());
        self.column_offsets.push(self.column_indices.len());
    }

    /// Adds up the levels of every element, a row at a time, and counts those that are not 0.
    fn count_nonzeros(&mut self) -> Result<()> {
        let elements: u64 = self.iter().map(|b| (b.rows.len() * b.columns.len()) as u64).sum();
        if elements > MOST_ELEMENTS {
            let what = "elements of all biclusters";
            return Err(Error::OutOfRange { what, got: elements as f64, allowed: "at most 2^32" });
        }
        let mut of_row: Vec<(u32, u32)> =
            self.iter().enumerate().flat_map(|(k, b)| b.rows.iter().map(move |&row| (row, k as u32))).collect();
        of_row.sort_unstable();
        let (mut row_entries, mut nnz) = (Vec::new(), 0);
        for row in of_row.chunk_by(|a, b| a.0 == b.0) {
            row_entries.clear();
            for &(_, k) in row {
                let columns = self.column_offsets[k as usize]..self.column_offsets[k as usize + 1];
                let levels = self.levels[columns.clone()].iter().map(|&level| i64::from(level));
                row_entries.extend(self.column_indices[columns].iter().copied().zip(levels));
            }
            row_entries.sort_unstable_by_key(|entry: &(u32, i64)| entry.0);
            for entries in row_entries.chunk_by(|a, b| a.0 == b.0) {
                let level: i64 = entries.iter().map(|entry| entry.1).sum();
                if level.abs() > i64::from(SparseMatrix::MAX_LEVEL) {
                    let what = "level of an element";
                    return Err(Error::OutOfRange { what, got: level as f64, allowed: "at most 2^24 in magnitude" });
                }
                nnz += usize::from(level != 0);
            }
        }
        self.nnz = nnz;
        Ok(())
    }
}

fn check(at: usize, bicluster: &Bicluster<'_>, rows: usize, columns: usize) -> Result<()> {
    let sides = [("row of bicluster", bicluster.rows, rows), ("column of bicluster", bicluster.columns, columns)];
    for (what, indices, count) in sides {
        let damaged = |reason| Err(Error::Damaged { what, offset: at, reason });
        match indices.last() {
            None => return damaged("there is none"),
            Some(&last) if last as usize >= count => {
                return Err(Error::Index { what, at, got: last as usize, count });
            }
            Some(_) if !indices.is_sorted_by(|a, b| a < b) => return damaged("they do not rise"),
            Some(_) => {}
        }
    }
    if bicluster.levels.len() != bicluster.columns.len() {
        let (expected, got) = (bicluster.columns.len(), bicluster.levels.len());
        return Err(Error::Length { what: "levels of a bicluster", expected, got });
    }
    match bicluster.levels.contains(&0) {
        true => Err(Error::Damaged { what: "levels of bicluster", offset: at, reason: "one is 0" }),
        false => Ok(()),
    }
}

impl Parts for Biclustering {
    const KIND: Kind = Kind::Biclustering;

    fn write(&self, to: &mut Writer) -> Result<()> {
        let ends = |offsets: &[usize]| offsets[1..].iter().map(|&end| end as u64).collect::<Vec<_>>();
        to.section(*b"SIZE", |s| {
            s.field(self.rows as u64);
            s.field(self.columns as u64);
            s.field(self.scale);
        })?;
        to.section(*b"ROWS", |s| {
            s.list(&ends(&self.row_offsets));
            s.list(&self.row_indices);
        })?;
        to.section(*b"COLS", |s| {
            s.list(&ends(&self.column_offsets));
            s.list(&self.column_indices);
            s.list(&self.levels);
        })
    }

    fn read(from: &mut Reader) -> Result<Self> {
        let mut size = from.section(*b"SIZE")?;
        let (rows, columns) = (size.count("rows")?, size.count("columns")?);
        let scale = size.field("a scale")?;
        size.end()?;
        let mut section = from.section(*b"ROWS")?;
        let (row_ends, row_indices) = (section.list::<u64>("ends of rows")?, section.list::<u32>("rows")?);
        section.end()?;
        let mut section = from.section(*b"COLS")?;
        let (column_ends, column_indices) = (section.list::<u64>("ends of columns")?, section.list::<u32>("columns")?);
        let levels: Vec<i32> = section.list("levels")?;
        section.end()?;
        let lie = |ends: &[u64], len: usize| !ends.is_sorted() || ends.last().copied().unwrap_or(0) != len as u64;
        if row_ends.len() != column_ends.len()
            || levels.len() != column_indices.len()
            || lie(&row_ends, row_indices.len())
            || lie(&column_ends, column_indices.len())
        {
            return Err(from.wrong("biclusters do not end where their rows and columns do"));
        }
        let (mut row, mut column) = (0, 0);
        let biclusters = row_ends.iter().zip(&column_ends).map(|(&row_end, &column_end)| {
            let rows = &row_indices[std::mem::replace(&mut row, row_end as usize)..row_end as usize];
            let columns = std::mem::replace(&mut column, column_end as usize)..column_end as usize;
            Bicluster { rows, columns: &column_indices[columns.clone()], levels: &levels[columns] }
        });
        Self::from_parts(rows, columns, scale, biclusters).map_err(|e| from.wrong(e.to_string()))
    }
}
