//! Biclustering of a dense matrix of integers, every quantity from its definition at every step.

use crate::compress::{BiclusterMove, BiclusterStep, BiclusterTrace};

/// A bicluster and how it was found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NaiveBicluster {
    /// Where it began, its moves, what it saves.
    pub trace: BiclusterTrace,
    /// The rows, ascending.
    pub rows: Vec<usize>,
    /// The columns, ascending.
    pub columns: Vec<usize>,
    /// t_k of each column.
    pub values: Vec<i64>,
}

/// t_k of every column of a submatrix: its most frequent non-zero value over the rows, the smallest of equals; 0 if all
/// are zero.
pub fn bicluster_values(matrix: &[Vec<i64>], rows: &[usize], columns: &[usize]) -> Vec<i64> {
    let value = |&column: &usize| {
        let mut values: Vec<i64> = rows.iter().map(|&row| matrix[row][column]).filter(|&v| v != 0).collect();
        values.sort_unstable();
        let mut best = (0, 0);
        for run in values.chunk_by(|a, b| a == b) {
            if run.len() > best.1 {
                best = (run[0], run.len());
            }
        }
        best.0
    };
    columns.iter().map(value).collect()
}

/// The floating-point operations that the bicluster of a submatrix saves.
/// ```math
/// ΔW = 2 nnz(M) − (r + 2l − 1) − 2 nnz(M − B)                    [bi-scale radiance transfer, eq. 9, signs restored]
/// ```
pub fn bicluster_saving(matrix: &[Vec<i64>], rows: &[usize], columns: &[usize]) -> i64 {
    let values = bicluster_values(matrix, rows, columns);
    let (mut nonzeros, mut residuals) = (0, 0);
    for &row in rows {
        for (&column, &t) in columns.iter().zip(&values) {
            nonzeros += i64::from(matrix[row][column] != 0);
            residuals += i64::from(matrix[row][column] != t);
        }
    }
    2 * nonzeros - (rows.len() + 2 * columns.len()) as i64 + 1 - 2 * residuals
}

/// The first non-zero element, rows before columns.
pub fn first_nonzero(matrix: &[Vec<i64>]) -> Option<(usize, usize)> {
    matrix.iter().enumerate().find_map(|(j, row)| Some((j, row.iter().position(|&v| v != 0)?)))
}

/// Algorithm 1: the biclusters in the order in which they are found.
///
/// `seed` chooses a non-zero element of what is left, `None` to end. Of the moves with the largest ΔW the first one in
/// the order of [`BiclusterMove`] and of ascending indices is made, as long as ΔW grows; a submatrix keeps at least one
/// row and column.
pub fn bicluster(
    matrix: &[Vec<i64>],
    mut seed: impl FnMut(&[Vec<i64>]) -> Option<(usize, usize)>,
) -> Vec<NaiveBicluster> {
    let mut left = matrix.to_vec();
    let mut found = Vec::new();
    while let Some(start) = seed(&left) {
        let (mut rows, mut columns) = (vec![start.0], vec![start.1]);
        let mut trace = BiclusterTrace { seed: start, steps: Vec::new(), saving: 0 };
        loop {
            let mut best: Option<(BiclusterStep, Vec<usize>, Vec<usize>)> = None;
            for (kind, index, r, c) in moves(&left, &rows, &columns) {
                let saving = bicluster_saving(&left, &r, &c);
                if saving > best.as_ref().map_or(trace.saving, |b| b.0.saving) {
                    best = Some((BiclusterStep { kind, index, saving }, r, c));
                }
            }
            let Some((step, r, c)) = best else { break };
            (rows, columns, trace.saving) = (r, c, step.saving);
            trace.steps.push(step);
        }
        let values = bicluster_values(&left, &rows, &columns);
        for &row in &rows {
            columns.iter().zip(&values).for_each(|(&column, &t)| left[row][column] -= t);
        }
        found.push(NaiveBicluster { trace, rows, columns, values });
    }
    found
}

/// Every submatrix that one move leads to, in the order of preference.
fn moves(
    matrix: &[Vec<i64>],
    rows: &[usize],
    columns: &[usize],
) -> Vec<(BiclusterMove, usize, Vec<usize>, Vec<usize>)> {
    let with = |list: &[usize], item| {
        let mut list = [list, &[item]].concat();
        list.sort_unstable();
        list
    };
    let without = |list: &[usize], item| list.iter().copied().filter(|&i| i != item).collect::<Vec<_>>();
    let mut all = Vec::new();
    for row in (0..matrix.len()).filter(|row| !rows.contains(row)) {
        all.push((BiclusterMove::AddRow, row, with(rows, row), columns.to_vec()));
    }
    for column in (0..matrix.first().map_or(0, Vec::len)).filter(|column| !columns.contains(column)) {
        all.push((BiclusterMove::AddColumn, column, rows.to_vec(), with(columns, column)));
    }
    if rows.len() > 1 {
        all.extend(rows.iter().map(|&row| (BiclusterMove::DeleteRow, row, without(rows, row), columns.to_vec())));
    }
    if columns.len() > 1 {
        let without = columns.iter().map(|&c| (BiclusterMove::DeleteColumn, c, rows.to_vec(), without(columns, c)));
        all.extend(without);
    }
    all
}

/// Σ_jk w_j v_k (a_jk − b_jk)², in squared levels.
pub fn weighted_squared_error(a: &[Vec<i64>], b: &[Vec<i64>], rows: &[f64], columns: &[f64]) -> f64 {
    let mut sum = 0.0;
    for ((a, b), w) in a.iter().zip(b).zip(rows) {
        for ((a, b), v) in a.iter().zip(b).zip(columns) {
            sum += w * v * ((a - b) as f64).powi(2);
        }
    }
    sum
}

/// The least error of a sum of biclusters, each (rows, columns, levels), of which columns are left out so that at most
/// `bytes` are left: every choice is tried, an error is that of the dense matrices.
pub fn least_pruning_error(
    shape: [usize; 2],
    biclusters: &[(Vec<usize>, Vec<usize>, Vec<i64>)],
    bytes: usize,
    weights: [&[f64]; 2],
) -> f64 {
    let columns: usize = biclusters.iter().map(|b| b.1.len()).sum();
    let sum_of = |choice: u32| {
        let (mut sum, mut size, mut bit) = (vec![vec![0; shape[1]]; shape[0]], 4 + 4 * (shape[0] + 1), 0);
        for (rows, columns, levels) in biclusters {
            let before = size;
            for (&column, &level) in columns.iter().zip(levels) {
                if choice >> bit & 1 == 1 {
                    size += 8;
                    rows.iter().for_each(|&row| sum[row][column] += level);
                }
                bit += 1;
            }
            if size > before {
                size += 4 * rows.len() + 4;
            }
        }
        (sum, size)
    };
    let (whole, _) = sum_of(u32::MAX);
    (0..1u32 << columns)
        .map(sum_of)
        .filter(|(_, size)| *size <= bytes)
        .map(|(sum, _)| weighted_squared_error(&whole, &sum, weights[0], weights[1]))
        .fold(f64::INFINITY, f64::min)
}

/// scale · levels · x.
pub fn multiply_levels(levels: &[Vec<i64>], scale: f64, x: &[f64]) -> Vec<f64> {
    levels.iter().map(|row| row.iter().zip(x).map(|(&level, &x)| scale * level as f64 * x).sum()).collect()
}
