//! Biclusters with loss: what may be left out, for how much error.

use super::clusters::{Bicluster, Biclustering};
use super::loss::Loss;
use crate::numeric::CompensatedSum;
use crate::{Error, Result};

/// What leaving out parts of a [`Biclustering`] saves and costs.
///
/// A biclustering without loss ends in many small biclusters that hold what the large ones got wrong (the paper leaves
/// it to future work to drop them [bi-scale radiance transfer §VII]). What can be left out here are the columns of
/// each bicluster, one by one, and with the last of them the bicluster. The error of what remains, S, is
///
/// ```math
/// E = Σ_jk w_j v_k (T_jk − S_jk)²
/// ```
///
/// with a weight w for each row and v for each column, all 1 unless given: what a light does to an error is best
/// covered by its mean energy in each direction for v.
///
/// Columns are left out in the order of error for each byte. Where the last columns of a bicluster are cheaper
/// together than each alone, because they take its rows with them, they go together. That order is fixed by the matrix
/// and the weights; [`curve`](Self::curve) has a point after every step.
///
/// Optimality: while no element has lost two levels, no choice of columns with as few bytes errs less than a point of
/// the curve. Where biclusters overlap errors do not add up, and the order is a heuristic; the errors of the points are
/// those of their matrices all the same, each element counted with all that it has lost.
/// Cost: each element of each bicluster is looked up once in its row, and once more for each result. Memory: 12 B for
/// each place of the matrix that any bicluster has, about 60 B a step.
///
/// # Example
/// ```
/// use haarmonic::compress::{Biclustering, BiclusterSettings, SparseMatrix};
/// // Three rows alike, but for one level.
/// let levels = [[4, 3, 2, 2], [4, 3, 2, 2], [4, 3, 2, 1]];
/// let triplets = (0..3).flat_map(|j| (0..4).map(move |k| (j, k, levels[j][k])));
/// let matrix = SparseMatrix::from_triplets(3, 4, 0.25, triplets)?;
/// let exact = Biclustering::new(&matrix, &BiclusterSettings::default(), &())?;
/// let (lossy, point) = exact.pruning().within(0.1)?;
/// assert_eq!((exact.len(), lossy.len()), (2, 1));
/// assert_eq!((point.squared_error, point.bytes), (0.25 * 0.25, lossy.stats().bytes));
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct BiclusterPruning<'a> {
    biclusters: &'a Biclustering,
    /// Weights of rows and columns.
    weights: [Vec<f64>; 2],
    steps: Vec<Step>,
    curve: Vec<PruningPoint>,
}

/// What a biclustering takes and errs after some parts of it were left out.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct PruningPoint {
    /// [`BiclusterStats::bytes`](super::BiclusterStats) of what remains.
    pub bytes: usize,
    /// [`BiclusterStats::flops`](super::BiclusterStats) of what remains.
    pub flops: usize,
    /// Σ w_j v_k (T_jk − S_jk)².
    pub squared_error: f64,
}

/// Columns of a bicluster that go together: places in the list of all columns.
#[derive(Debug, Clone)]
struct Step {
    bicluster: u32,
    columns: Vec<u32>,
}

impl Biclustering {
    /// What leaving out parts would save and cost, all elements of the matrix weighing the same.
    pub fn pruning(&self) -> BiclusterPruning<'_> {
        BiclusterPruning::new(self, [vec![1.0; self.rows], vec![1.0; self.columns]])
    }

    /// The same with a weight for each row and each column.
    ///
    /// # Errors
    /// [`Error::Length`] unless there is a weight for each; [`Error::OutOfRange`] for one that is negative, NaN or
    /// infinite.
    pub fn weighted_pruning(&self, rows: &[f64], columns: &[f64]) -> Result<BiclusterPruning<'_>> {
        for (what, weights, expected) in
            [("weights of rows", rows, self.rows), ("weights of columns", columns, self.columns)]
        {
            if weights.len() != expected {
                return Err(Error::Length { what, expected, got: weights.len() });
            }
            if let Some(&got) = weights.iter().find(|w| !(**w >= 0.0 && w.is_finite())) {
                return Err(Error::OutOfRange { what, got, allowed: "finite and not negative" });
            }
        }
        Ok(BiclusterPruning::new(self, [rows.to_vec(), columns.to_vec()]))
    }
}

impl<'a> BiclusterPruning<'a> {
    fn new(biclusters: &'a Biclustering, weights: [Vec<f64>; 2]) -> Self {
        let mut priced: Vec<(f64, Step)> = Vec::new();
        for at in 0..biclusters.len() {
            price(biclusters, at, &weights, &mut priced);
        }
        // Stable: equals stay in the order of the biclusters.
        priced.sort_by(|a, b| a.0.total_cmp(&b.0));
        let steps: Vec<Step> = priced.into_iter().map(|(_, step)| step).collect();
        let stats = biclusters.stats();
        let mut point = PruningPoint { bytes: stats.bytes, flops: stats.flops, squared_error: 0.0 };
        let (mut curve, mut sum) = (vec![point], CompensatedSum::default());
        let mut loss = Loss::new(biclusters, &weights);
        let mut left: Vec<usize> = biclusters.column_offsets.windows(2).map(|ends| ends[1] - ends[0]).collect();
        for step in &steps {
            let at = step.bicluster as usize;
            let rows = biclusters.rows_of(at);
            for &column in &step.columns {
                loss.take(rows, biclusters.column_indices[column as usize], biclusters.levels[column as usize], |x| {
                    sum.add(x);
                });
            }
            left[at] -= step.columns.len();
            point.bytes -= 8 * step.columns.len();
            point.flops -= 2 * step.columns.len();
            if left[at] == 0 {
                point.bytes -= 4 * rows.len() + 4;
                // One of the last column's two operations was not there: l columns have l − 1 additions.
                point.flops = point.flops + 1 - rows.len();
            }
            point.squared_error = (sum.total() * biclusters.scale.powi(2)).max(0.0);
            curve.push(point);
        }
        Self { biclusters, weights, steps, curve }
    }

    /// Storage against error: the first point is the whole biclustering, the last has nothing left.
    #[inline]
    pub fn curve(&self) -> &[PruningPoint] {
        &self.curve
    }

    /// The smallest biclustering of the curve whose error is at most `squared_error`, and its point.
    ///
    /// The error of the point is that of the matrix which the result is the biclustering of, added up anew. Its
    /// [`stats`](Biclustering::stats) compare it with that matrix, not with the one that nothing was taken from.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if the bound is negative or NaN, and as [`Biclustering::from_parts`] in the rare case that
    /// what remains has levels which only what was left out had kept small.
    pub fn within(&self, squared_error: f64) -> Result<(Biclustering, PruningPoint)> {
        if !(squared_error >= 0.0) {
            let allowed = "not negative";
            return Err(Error::OutOfRange { what: "bound of a squared error", got: squared_error, allowed });
        }
        // The first point has no error.
        let mut last = self.curve.iter().rposition(|point| point.squared_error <= squared_error).unwrap_or(0);
        loop {
            let exact = self.squared_error_after(last);
            // The curve's own sums are rounded.
            if exact <= squared_error || last == 0 {
                let point = PruningPoint { squared_error: exact, ..self.curve[last] };
                return Ok((self.after(last)?, point));
            }
            last -= 1;
        }
    }

    /// The error after some steps, added up place by place.
    fn squared_error_after(&self, steps: usize) -> f64 {
        let mut loss = Loss::new(self.biclusters, &self.weights);
        for step in &self.steps[..steps] {
            let rows = self.biclusters.rows_of(step.bicluster as usize);
            for &column in &step.columns {
                let at = column as usize;
                loss.take(rows, self.biclusters.column_indices[at], self.biclusters.levels[at], |_| ());
            }
        }
        loss.squared() * self.biclusters.scale.powi(2)
    }

    /// What is left after some steps.
    fn after(&self, steps: usize) -> Result<Biclustering> {
        let all = self.biclusters;
        let mut kept = vec![true; all.levels.len()];
        for column in self.steps[..steps].iter().flat_map(|step| &step.columns) {
            kept[*column as usize] = false;
        }
        let parts: Vec<(usize, Vec<u32>, Vec<i32>)> = (0..all.len())
            .filter_map(|at| {
                let columns = (all.column_offsets[at]..all.column_offsets[at + 1]).filter(|&c| kept[c]);
                let (indices, levels): (Vec<u32>, Vec<i32>) =
                    columns.map(|c| (all.column_indices[c], all.levels[c])).unzip();
                (!indices.is_empty()).then_some((at, indices, levels))
            })
            .collect();
        let biclusters =
            parts.iter().map(|(at, columns, levels)| Bicluster { rows: all.rows_of(*at), columns, levels });
        Biclustering::from_parts(all.rows, all.columns, all.scale, biclusters)
    }
}

/// The steps of one bicluster with their errors a byte, which do not fall.
fn price(all: &Biclustering, at: usize, weights: &[Vec<f64>; 2], out: &mut Vec<(f64, Step)>) {
    let (rows, columns) = (all.rows_of(at), all.column_offsets[at]..all.column_offsets[at + 1]);
    let of_rows: f64 = rows.iter().map(|&row| weights[0][row as usize]).sum();
    let error = |column: usize| {
        let level = f64::from(all.levels[column]);
        of_rows * weights[1][all.column_indices[column] as usize] * level * level
    };
    let mut order: Vec<(f64, u32)> = columns.map(|column| (error(column), column as u32)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let last = order.len() - 1;
    let mut steps: Vec<(f64, f64, Vec<u32>)> = Vec::new();
    for (k, (error, column)) in order.into_iter().enumerate() {
        let bytes = if k == last { 12.0 + 4.0 * rows.len() as f64 } else { 8.0 };
        let mut step = (error, bytes, vec![column]);
        // Cheaper a byte than what comes before it: both go together.
        while let Some(before) = steps.pop_if(|before| before.0 * step.1 > step.0 * before.1) {
            step = (before.0 + step.0, before.1 + step.1, [before.2, step.2].concat());
        }
        steps.push(step);
    }
    let steps = steps.into_iter();
    out.extend(steps.map(|(error, bytes, columns)| (error / bytes, Step { bicluster: at as u32, columns })));
}
