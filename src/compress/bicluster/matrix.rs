//! Sparse matrices of integer levels.

use crate::error::check_length;
use crate::{Error, Real, Result, parallel};

/// A sparse matrix whose entries are integer levels times one scale; compressed rows.
/// ```math
/// T_jk = scale · level_jk
/// ```
///
/// Integers, because compression that gives back every bit must subtract, and differences of floating-point numbers are
/// not exact. Visibility sampled 2^m × 2^m times a texel has the levels 0…2^{2m} and the scale 2^{−2m} [bi-scale
/// radiance transfer §IV-A]. Powers of two as scales keep every entry exact in `f32`.
///
/// Entries of a row ascend strictly by column and none is zero. Two matrices are equal if shape, scale and entries are.
///
/// # Example
/// ```
/// use haarmonic::compress::SparseMatrix;
/// // Any order; entries of one place are added.
/// let matrix = SparseMatrix::from_triplets(2, 3, 0.25, [(1, 2, 4), (0, 1, 1), (0, 1, 2)])?;
/// assert_eq!((matrix.nnz(), matrix.level(0, 1), matrix.level(0, 0)), (2, 3, 0));
/// let mut product = [0.0; 2];
/// matrix.multiply(&[1.0, 2.0, 3.0], &mut product);
/// assert_eq!(product, [0.75 * 2.0, 1.0 * 3.0]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SparseMatrix {
    columns: usize,
    scale: f64,
    offsets: Vec<usize>,
    indices: Vec<u32>,
    levels: Vec<i32>,
}

impl SparseMatrix {
    /// The largest magnitude of a level: 2^24, below which integers are exact in `f32`.
    pub const MAX_LEVEL: i32 = 1 << 24;

    /// A matrix from (row, column, level) in any order; levels of one place are added, and what adds up to zero is
    /// dropped.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless every place is in the matrix, every level (and sum) is at most
    /// [`MAX_LEVEL`](Self::MAX_LEVEL) in magnitude, `scale` is finite and above 0, and both sizes are below 2^31.
    pub fn from_triplets(
        rows: usize,
        columns: usize,
        scale: f64,
        triplets: impl IntoIterator<Item = (usize, usize, i32)>,
    ) -> Result<Self> {
        check_shape(rows, columns, scale)?;
        let mut entries = Vec::new();
        for (row, column, level) in triplets {
            check_index("row", row, rows)?;
            check_index("column", column, columns)?;
            entries.push((row as u32, column as u32, i64::from(level)));
        }
        entries.sort_unstable_by_key(|&(row, column, _)| (row, column));
        entries.dedup_by(|next, sum| {
            let same = (next.0, next.1) == (sum.0, sum.1);
            if same {
                sum.2 += next.2; // 2^31 addends of 2^31 fit
            }
            same
        });
        let mut matrix = Self::empty(rows, columns, scale, entries.len());
        for (row, column, level) in entries {
            if level != 0 {
                matrix.offsets[row as usize + 1] += 1;
                matrix.indices.push(column);
                matrix.levels.push(checked_level(level)?);
            }
        }
        for row in 0..rows {
            matrix.offsets[row + 1] += matrix.offsets[row];
        }
        Ok(matrix)
    }

    /// A matrix from the entries of each row in turn, which must be sorted: for matrices too large to sort again.
    ///
    /// `offsets[j]..offsets[j + 1]` are the entries of row j in `indices` (columns) and `levels`.
    ///
    /// # Errors
    /// [`Error::Length`] unless `offsets` start at 0, end at the number of entries and there is one level an index;
    /// [`Error::OutOfRange`] unless offsets ascend, columns ascend strictly in each row and are in the matrix, and
    /// levels are not 0; and as [`from_triplets`](Self::from_triplets).
    pub fn from_rows(
        columns: usize,
        scale: f64,
        offsets: Vec<usize>,
        indices: Vec<u32>,
        levels: Vec<i32>,
    ) -> Result<Self> {
        let Some(rows) = offsets.len().checked_sub(1) else { return Err(Error::Empty { what: "row offsets" }) };
        check_shape(rows, columns, scale)?;
        let ends = [
            ("levels of a sparse matrix", indices.len(), levels.len()),
            ("first row offset", 0, offsets[0]),
            ("last row offset", indices.len(), offsets[rows]),
        ];
        for (what, expected, got) in ends {
            if expected != got {
                return Err(Error::Length { what, expected, got });
            }
        }
        for row in 0..rows {
            if offsets[row] > offsets[row + 1] {
                let (got, allowed) = (offsets[row + 1] as f64, "at least the offset before it");
                return Err(Error::OutOfRange { what: "row offset", got, allowed });
            }
            // The last offset is the length and offsets ascend up to here; later ones are seen in their turn.
            let Some(entries) = indices.get(offsets[row]..offsets[row + 1]) else {
                let (got, allowed) = (offsets[row + 1] as f64, "at most the number of entries");
                return Err(Error::OutOfRange { what: "row offset", got, allowed });
            };
            if let Some(pair) = entries.windows(2).find(|pair| pair[0] >= pair[1]) {
                let (got, allowed) = (f64::from(pair[1]), "above the column before it in its row");
                return Err(Error::OutOfRange { what: "column", got, allowed });
            }
            if let Some(&last) = entries.last() {
                check_index("column", last as usize, columns)?;
            }
        }
        for &level in &levels {
            if level == 0 {
                return Err(Error::OutOfRange { what: "level", got: 0.0, allowed: "not 0 where it is stored" });
            }
            checked_level(i64::from(level))?;
        }
        Ok(Self { columns, scale, offsets, indices, levels })
    }

    /// A matrix from (row, column, value) with values rounded to the nearest multiple of `scale`, halves away from
    /// zero.
    ///
    /// Exact if the values are such multiples. Values of one place are rounded, then added.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a value is NaN or infinite (`index` counts the triplets), and as
    /// [`from_triplets`](Self::from_triplets).
    pub fn quantise(
        rows: usize,
        columns: usize,
        scale: f64,
        triplets: impl IntoIterator<Item = (usize, usize, f64)>,
    ) -> Result<Self> {
        check_shape(rows, columns, scale)?;
        let mut levels = Vec::new();
        for (index, (row, column, value)) in triplets.into_iter().enumerate() {
            if !value.is_finite() {
                return Err(Error::NotFinite { what: "sparse matrix", index });
            }
            let level = (value / scale).round();
            if level.abs() > f64::from(Self::MAX_LEVEL) {
                return Err(level_out_of_range(level));
            }
            levels.push((row, column, level as i32));
        }
        Self::from_triplets(rows, columns, scale, levels)
    }

    fn empty(rows: usize, columns: usize, scale: f64, capacity: usize) -> Self {
        let (indices, levels) = (Vec::with_capacity(capacity), Vec::with_capacity(capacity));
        Self { columns, scale, offsets: vec![0; rows + 1], indices, levels }
    }

    /// How many rows the matrix has.
    #[inline]
    pub fn rows(&self) -> usize {
        self.offsets.len() - 1
    }

    /// How many columns the matrix has.
    #[inline]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// What a level of 1 stands for.
    #[inline]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// How many entries are not zero.
    #[inline]
    pub fn nnz(&self) -> usize {
        self.indices.len()
    }

    /// The entries of a row that are not zero: columns, strictly ascending, and their levels.
    ///
    /// # Panics
    /// If `row` is out of range.
    #[inline]
    #[track_caller]
    pub fn row(&self, row: usize) -> (&[u32], &[i32]) {
        let range = self.offsets[row]..self.offsets[row + 1];
        (&self.indices[range.clone()], &self.levels[range])
    }

    /// The level at one place, 0 where nothing is stored.
    ///
    /// # Panics
    /// If the place is out of range.
    #[track_caller]
    pub fn level(&self, row: usize, column: usize) -> i32 {
        assert!(column < self.columns, "column {column} of a matrix with {}", self.columns);
        let (indices, levels) = self.row(row);
        indices.binary_search(&(column as u32)).map_or(0, |at| levels[at])
    }

    /// T·x by rows. Each sum runs over ascending columns in T. On all threads (feature `rayon`), the same bits for any
    /// number of them.
    ///
    /// # Panics
    /// If `x.len()` is not the number of columns or `out.len()` not that of rows.
    #[track_caller]
    pub fn multiply<T: Real>(&self, x: &[T], out: &mut [T]) {
        self.multiply_batch(1, x, out);
    }

    /// [`multiply`](Self::multiply) for `count` right-hand sides at once (RGB, several lights).
    ///
    /// Number k of side s is `x[k · count + s]`.
    ///
    /// # Panics
    /// If `x.len()` is not columns · `count` or `out.len()` not rows · `count`.
    #[track_caller]
    pub fn multiply_batch<T: Real>(&self, count: usize, x: &[T], out: &mut [T]) {
        check_length("right-hand sides", self.columns.saturating_mul(count), x.len());
        check_length("product", self.rows().saturating_mul(count), out.len());
        let scale = T::of(self.scale);
        parallel::rows(out, count, 64, |row, out| {
            out.fill(T::zero());
            let (columns, levels) = self.row(row);
            for (&column, &level) in columns.iter().zip(levels) {
                let weight = scale * T::of(f64::from(level));
                let x = &x[column as usize * count..][..count];
                out.iter_mut().zip(x).for_each(|(sum, &x)| *sum += weight * x);
            }
        });
    }

    /// A multiplication and an addition for every entry: 2 nnz.
    #[inline]
    pub fn flops(&self) -> usize {
        2 * self.nnz()
    }

    /// What compressed rows take with `f32` values and 32-bit indices: 8 nnz + 4 (rows + 1).
    #[inline]
    pub fn bytes(&self) -> usize {
        8 * self.nnz() + 4 * (self.rows() + 1)
    }
}

pub(super) fn check_shape(rows: usize, columns: usize, scale: f64) -> Result<()> {
    for (what, got) in [("rows of a sparse matrix", rows), ("columns of a sparse matrix", columns)] {
        if got >= 1 << 31 {
            return Err(Error::OutOfRange { what, got: got as f64, allowed: "below 2^31" });
        }
    }
    if !(scale.is_finite() && scale > 0.0) {
        return Err(Error::OutOfRange { what: "scale of a sparse matrix", got: scale, allowed: "finite and above 0" });
    }
    Ok(())
}

fn check_index(what: &'static str, got: usize, size: usize) -> Result<()> {
    if got >= size {
        return Err(Error::OutOfRange { what, got: got as f64, allowed: "below the matrix's size" });
    }
    Ok(())
}

fn checked_level(level: i64) -> Result<i32> {
    if level.abs() > i64::from(SparseMatrix::MAX_LEVEL) {
        return Err(level_out_of_range(level as f64));
    }
    Ok(level as i32)
}

fn level_out_of_range(got: f64) -> Error {
    Error::OutOfRange { what: "level", got, allowed: "in −2^24…2^24" }
}
