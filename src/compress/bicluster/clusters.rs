//! The biclusters of a matrix.

use super::matrix::SparseMatrix;
use super::partition::by_shared_columns;
use super::search::{Found, Tracing, search};
use super::settings::BiclusterSettings;
use super::trace::BiclusterTrace;
use crate::{Error, Progress, Result};

/// One bicluster: every chosen row has the same level in a chosen column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bicluster<'a> {
    /// The rows, strictly ascending.
    pub rows: &'a [u32],
    /// The columns, strictly ascending.
    pub columns: &'a [u32],
    /// The level of each column, never 0.
    pub levels: &'a [i32],
}

impl Bicluster<'_> {
    /// Floating-point operations of its product with a vector: l multiplications and l − 1 additions give one number,
    /// which is added to r rows.
    /// ```math
    /// W(B) = r + 2l − 1                                                          [bi-scale radiance transfer, eq. 7]
    /// ```
    pub fn cost(&self) -> usize {
        self.rows.len() + 2 * self.columns.len() - 1
    }
}

/// A sparse matrix as a sum of biclusters, without loss.
/// ```math
/// T = Σ_i B_i                                                                      [bi-scale radiance transfer §IV]
/// ```
///
/// Each bicluster grows from one element by the best of all moves (another row or column, or one less) until none saves
/// more operations; it is subtracted, and the search goes on in what is left, which is negative where a row has less
/// than its column's level. (Signs of eq. 9 and what algorithm 1 subtracts: docs/errata.md.)
///
/// The greedy rule is deterministic: of moves that gain the same, adding a row comes before adding a column, deleting a
/// row, deleting a column, and lower indices before higher ones; a column's level is its most frequent non-zero one
/// over the chosen rows at each step, the smallest of equals. The same result for any number of threads.
///
/// # Example
/// ```
/// use haarmonic::compress::{Biclustering, BiclusterSettings, SparseMatrix};
/// // Two rows that differ in one element, and one apart.
/// let levels = [[4, 3, 0, 2], [4, 3, 0, 1], [0, 0, 4, 0]];
/// let triplets = (0..3).flat_map(|j| (0..4).map(move |k| (j, k, levels[j][k])));
/// let matrix = SparseMatrix::from_triplets(3, 4, 0.25, triplets)?;
/// let biclusters = Biclustering::new(&matrix, &BiclusterSettings::default(), &())?;
/// assert_eq!(biclusters.to_matrix(), matrix);
/// assert_eq!(biclusters.stats().flops, 5 + 2 + 2 + 2);
/// let mut product = [0.0; 3];
/// let multiplier = biclusters.multiplier::<f32>();
/// let mut scratch = vec![0.0; multiplier.scratch_len(1)];
/// multiplier.multiply(&[1.0, 1.0, 1.0, 2.0], &mut product, &mut scratch);
/// assert_eq!(product, [2.75, 2.25, 1.0]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Biclustering {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) scale: f64,
    pub(super) nnz: usize,
    pub(super) row_offsets: Vec<usize>,
    pub(super) row_indices: Vec<u32>,
    pub(super) column_offsets: Vec<usize>,
    pub(super) column_indices: Vec<u32>,
    pub(super) levels: Vec<i32>,
}

/// What a [`Biclustering`] costs next to its matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct BiclusterStats {
    /// How many biclusters there are.
    pub biclusters: usize,
    /// Σ r.
    pub row_entries: usize,
    /// Σ l.
    pub column_entries: usize,
    /// Σ (r + 2l − 1): operations of a product with one vector.
    pub flops: usize,
    /// 2 nnz of the matrix.
    pub matrix_flops: usize,
    /// Bytes of a [`BiclusterMultiplier`](super::BiclusterMultiplier) for `f32`: 4 Σr + 8 Σl + 4 (biclusters + 1) + 4
    /// (rows + 1).
    pub bytes: usize,
    /// Bytes of the matrix in compressed rows ([`SparseMatrix::bytes`]).
    pub matrix_bytes: usize,
    /// Bytes of the matrix with all its zeros, one each: rows · columns, what the paper's shares of data are of.
    pub dense_bytes: usize,
}

impl Biclustering {
    /// Biclusters of a matrix, in groups of at most `settings.group_rows` rows.
    ///
    /// Groups are made of rows that share columns: rows of one direction, where rows are (vertex, local direction).
    /// Groups that are too large are cut into runs of consecutive rows, so put vertices in an order in which neighbours
    /// are near. A matrix without non-zeros gives no biclusters.
    ///
    /// `progress` counts non-zeros of the matrix.
    /// Cost: linear in the number of groups; about 1 s of one core for a million non-zeros of a transfer matrix.
    /// Memory: 16 B a non-zero and thread's group, and the result.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `settings.group_rows` is 0, [`Error::Cancelled`] if `progress` asked to stop.
    pub fn new(matrix: &SparseMatrix, settings: &BiclusterSettings, progress: &dyn Progress) -> Result<Self> {
        let groups = partition(matrix, settings)?;
        Ok(Self::collect(matrix, search(matrix, &groups, settings, Tracing::Off, progress)?).0)
    }

    /// Biclusters of groups of rows that the caller chose: `groups[j]` is the group of row j, any numbers.
    /// `settings.group_rows` is not used.
    ///
    /// # Errors
    /// [`Error::Length`] unless there is a group for each row; [`Error::Cancelled`] if `progress` asked to stop.
    pub fn with_groups(
        matrix: &SparseMatrix,
        groups: &[u32],
        settings: &BiclusterSettings,
        progress: &dyn Progress,
    ) -> Result<Self> {
        if groups.len() != matrix.rows() {
            return Err(Error::Length { what: "groups of rows", expected: matrix.rows(), got: groups.len() });
        }
        let mut order: Vec<u32> = (0..matrix.rows() as u32).collect();
        order.sort_by_key(|&row| groups[row as usize]); // stable: rows ascend in each group
        let groups: Vec<Vec<u32>> =
            order.chunk_by(|&a, &b| groups[a as usize] == groups[b as usize]).map(<[u32]>::to_vec).collect();
        Ok(Self::collect(matrix, search(matrix, &groups, settings, Tracing::Off, progress)?).0)
    }

    /// As [`new`](Self::new), with the moves that led to each bicluster.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn traced(
        matrix: &SparseMatrix,
        settings: &BiclusterSettings,
        progress: &dyn Progress,
    ) -> Result<(Self, Vec<BiclusterTrace>)> {
        let groups = partition(matrix, settings)?;
        Ok(Self::collect(matrix, search(matrix, &groups, settings, Tracing::On, progress)?))
    }

    fn collect(matrix: &SparseMatrix, found: Vec<Found>) -> (Self, Vec<BiclusterTrace>) {
        let count = found.iter().map(|f| f.0.len()).sum::<usize>();
        let sum = |of: fn(&super::growth::Grown) -> usize| found.iter().flat_map(|f| &f.0).map(of).sum::<usize>();
        let (row_entries, column_entries) = (sum(|g| g.rows.len()), sum(|g| g.columns.len()));
        let mut all = Self {
            rows: matrix.rows(),
            columns: matrix.columns(),
            scale: matrix.scale(),
            nnz: matrix.nnz(),
            row_offsets: Vec::with_capacity(count + 1),
            row_indices: Vec::with_capacity(row_entries),
            column_offsets: Vec::with_capacity(count + 1),
            column_indices: Vec::with_capacity(column_entries),
            levels: Vec::with_capacity(column_entries),
        };
        all.row_offsets.push(0);
        all.column_offsets.push(0);
        let mut traces = Vec::new();
        for (grown, mut steps) in found {
            traces.append(&mut steps);
            for grown in grown {
                all.push(&Bicluster { rows: &grown.rows, columns: &grown.columns, levels: &grown.levels });
            }
        }
        (all, traces)
    }

    /// How many biclusters there are.
    #[inline]
    pub fn len(&self) -> usize {
        self.row_offsets.len() - 1
    }

    /// Whether the matrix was zero.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Rows of the matrix.
    #[inline]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Columns of the matrix.
    #[inline]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// What a level of 1 stands for.
    #[inline]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The biclusters, group after group, in the order in which they were found.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Bicluster<'_>> + Clone {
        (0..self.len()).map(|i| {
            let columns = self.column_offsets[i]..self.column_offsets[i + 1];
            Bicluster {
                rows: self.rows_of(i),
                columns: &self.column_indices[columns.clone()],
                levels: &self.levels[columns],
            }
        })
    }

    /// The rows of a bicluster.
    pub(super) fn rows_of(&self, at: usize) -> &[u32] {
        &self.row_indices[self.row_offsets[at]..self.row_offsets[at + 1]]
    }

    /// Σ B_i: the matrix that was biclustered, bit for bit.
    pub fn to_matrix(&self) -> SparseMatrix {
        let places = self.iter().flat_map(|b| {
            let columns = b.columns.iter().zip(b.levels);
            b.rows.iter().flat_map(move |&row| columns.clone().map(move |(&column, &level)| (row, column, level)))
        });
        let mut by_row: Vec<Vec<(u32, i32)>> = vec![Vec::new(); self.rows];
        places.for_each(|(row, column, level)| by_row[row as usize].push((column, level)));
        let (mut offsets, mut indices, mut levels) = (vec![0], Vec::with_capacity(self.nnz), Vec::new());
        for mut row in by_row {
            row.sort_unstable_by_key(|e| e.0);
            for entries in row.chunk_by(|a, b| a.0 == b.0) {
                let level = entries.iter().map(|e| i64::from(e.1)).sum::<i64>();
                if level != 0 {
                    indices.push(entries[0].0);
                    levels.push(i32::try_from(level).expect("a level of the matrix"));
                }
            }
            offsets.push(indices.len());
        }
        SparseMatrix::from_rows(self.columns, self.scale, offsets, indices, levels)
            .expect("rows are sorted and the sums are the matrix's levels")
    }

    /// Counts of operations and bytes.
    pub fn stats(&self) -> BiclusterStats {
        let (row_entries, column_entries) = (self.row_indices.len(), self.column_indices.len());
        let biclusters = self.len();
        BiclusterStats {
            biclusters,
            row_entries,
            column_entries,
            flops: row_entries + 2 * column_entries - biclusters,
            matrix_flops: 2 * self.nnz,
            bytes: 4 * row_entries + 8 * column_entries + 4 * (biclusters + 1) + 4 * (self.rows + 1),
            matrix_bytes: 8 * self.nnz + 4 * (self.rows + 1),
            dense_bytes: self.rows.saturating_mul(self.columns),
        }
    }
}

fn partition(matrix: &SparseMatrix, settings: &BiclusterSettings) -> Result<Vec<Vec<u32>>> {
    settings.check()?;
    Ok(by_shared_columns(matrix, settings.group_rows))
}
