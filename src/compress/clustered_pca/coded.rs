//! Rows as a cluster and weights.

use pulp::Arch;

use super::super::dense::{Factors, Part, Rows, Scaling, times_rows};
use super::super::distortion::Distortion;
use super::super::pca::{add_up, check_matrix};
use super::bases::Bases;
use super::build::{Builder, Start};
use super::nearest::{Nearest, Place};
use super::settings::ClusteredPcaSettings;
use crate::approx_eq::approx_by_parts;
use crate::error::check_length;
use crate::parallel::Watch;
use crate::{Error, Progress, Real, Result, parallel};

/// The rows of a matrix, each as a cluster c and weights of that cluster's principal components [Sloan, Hall, Hart &
/// Snyder 2003].
/// ```math
/// x ≈ m_c + Σ_j w_j u_cj,   x·l ≈ m_c·l + Σ_j w_j (u_cj·l)
/// ```
///
/// The second line is what this is for: a light l meets the means and components once, and each row is then
/// `components` multiplications and additions.
///
/// Found as the paper says: k-means, then rounds of fitting components to the rows of each cluster and moving each row
/// to the cluster whose affine subspace is nearest to it, until the squared error hardly falls
/// ([`ClusteredPcaSettings`]). Moves never raise the error. The first means are drawn far from each other; a cluster
/// that loses all its rows begins anew at the row with the largest error.
///
/// Shapes: matrices row-major; components of a cluster `[j·columns + c]`. There are at most as many clusters as
/// different rows; [`clusters`](Self::clusters) says. A cluster whose rows lie in a smaller subspace (less rows than
/// components, equal rows) has zeros for the components that it lacks, and weights 0.
///
/// The same bits for any number of threads.
///
/// # Example
/// ```
/// use haarmonic::compress::{ClusteredPca, ClusteredPcaSettings};
/// // Points on two lines.
/// let points: Vec<f32> = (0..10).flat_map(|i| [i as f32, 1.0, -20.0, i as f32]).collect();
/// let coded = ClusteredPca::new(&points, 2, &ClusteredPcaSettings::new(2, 1), &())?;
/// assert_eq!(coded.clusters(), 2);
/// assert!(coded.stats().distortion.max < 1e-5);
/// let mut sums = [0.0; 20];
/// coded.multiply(&[1.0, 10.0], &mut sums, &mut vec![0.0; coded.scratch_len(1)]);
/// assert!((sums[6] - 13.0).abs() < 1e-4 && (sums[7] - 10.0).abs() < 1e-4);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ClusteredPca<T> {
    pub(super) bases: Bases<T>,
    pub(super) labels: Vec<u32>,
    pub(super) weights: Vec<T>,
    pub(super) distortion: Distortion,
}

/// What a [`ClusteredPca`] takes in memory, and what it loses.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ClusteredPcaStats {
    /// Clusters that have rows.
    pub clusters: usize,
    /// How far rows are from what is stored of them.
    pub distortion: Distortion,
    /// Means and components: clusters · (components + 1) · columns numbers.
    pub basis_bytes: usize,
    /// Weights, and 4 bytes a row for the cluster.
    pub row_bytes: usize,
    /// The matrix.
    pub matrix_bytes: usize,
}

impl ClusteredPcaStats {
    /// How many bytes of the matrix there are for each byte that is stored.
    pub fn ratio(&self) -> f64 {
        self.matrix_bytes as f64 / (self.basis_bytes + self.row_bytes) as f64
    }
}

impl<T: Real> ClusteredPca<T> {
    /// Clusters and codes of the rows of a row-major matrix.
    ///
    /// `progress` counts rows: one for each row and round; it jumps where rounds end early.
    /// Cost: a round is rows · clusters · (components + 1) · columns multiplications and additions, at the speed of a
    /// matrix product.
    ///
    /// # Errors
    /// [`Error::Empty`] without rows or columns; [`Error::Length`] unless rows are whole; [`Error::NotFinite`];
    /// [`Error::OutOfRange`] without clusters, for too many components, a tolerance that is negative or NaN, 2^32 rows,
    /// and elements above 1e140; [`Error::Cancelled`] if `progress` asked to stop.
    pub fn new(matrix: &[T], columns: usize, settings: &ClusteredPcaSettings, progress: &dyn Progress) -> Result<Self> {
        check(matrix, columns, settings)?;
        Self::build(matrix, columns, settings, progress, Start::Seeds)
    }

    /// As [`new`](Self::new), from a cluster for each row, below `settings.clusters`, instead of k-means.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`Error::Length`] unless there is a label for each row; [`Error::OutOfRange`] for a label
    /// that is not below the number of clusters, and of rows.
    pub fn from_labels(
        matrix: &[T],
        columns: usize,
        labels: &[u32],
        settings: &ClusteredPcaSettings,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let rows = check(matrix, columns, settings)?;
        if labels.len() != rows {
            return Err(Error::Length { what: "labels", expected: rows, got: labels.len() });
        }
        let limit = settings.clusters.min(rows);
        if let Some(&label) = labels.iter().find(|&&label| label as usize >= limit) {
            let allowed = "below the number of clusters and of rows";
            return Err(Error::OutOfRange { what: "label", got: f64::from(label), allowed });
        }
        Self::build(matrix, columns, settings, progress, Start::Labels(labels))
    }

    fn build(
        matrix: &[T],
        columns: usize,
        settings: &ClusteredPcaSettings,
        progress: &dyn Progress,
        start: Start,
    ) -> Result<Self> {
        let (bases, labels) = Builder::new(matrix, columns, settings, progress)?.run(start)?;
        let mut weights = vec![T::zero(); labels.len() * bases.components];
        weigh(&bases, matrix, &labels, &mut weights);
        let nothing = Distortion::default();
        let mut all = Self { bases, labels, weights, distortion: nothing };
        all.distortion = Distortion::of_rows(matrix, columns, |first, _, out| all.reconstruct_rows(first, out));
        Ok(all)
    }

    /// Rows of the matrix.
    #[inline]
    pub fn rows(&self) -> usize {
        self.labels.len()
    }

    /// Columns of the matrix.
    #[inline]
    pub fn columns(&self) -> usize {
        self.bases.columns
    }

    /// How many clusters have rows.
    #[inline]
    pub fn clusters(&self) -> usize {
        self.bases.clusters()
    }

    /// Components of a cluster, as the settings said.
    #[inline]
    pub fn components(&self) -> usize {
        self.bases.components
    }

    /// The mean of cluster c and its components, one after the other.
    ///
    /// # Panics
    /// If c is out of range.
    #[inline]
    #[track_caller]
    pub fn cluster(&self, c: usize) -> (&[T], &[T]) {
        self.bases.cluster(c)
    }

    /// The cluster of each row.
    #[inline]
    pub fn labels(&self) -> &[u32] {
        &self.labels
    }

    /// Weights, `[row·components + j]`.
    #[inline]
    pub fn weights(&self) -> &[T] {
        &self.weights
    }

    /// A row, from what is stored of it.
    ///
    /// # Panics
    /// If `row` is out of range or `out` has not as many numbers as the matrix has columns.
    #[track_caller]
    pub fn reconstruct(&self, row: usize, out: &mut [T]) {
        check_length("row", self.columns(), out.len());
        assert!(row < self.rows(), "row {row} of {}", self.rows());
        self.reconstruct_rows(row, out);
    }

    /// Rows from `first` on, as many as `out` has.
    fn reconstruct_rows(&self, first: usize, out: &mut [T]) {
        let (arch, k) = (Arch::new(), self.components());
        parallel::rows(out, self.columns(), 16, |row, out| {
            let row = first + row;
            let (mean, components) = self.bases.cluster(self.labels[row] as usize);
            let weights = &self.weights[row * k..][..k];
            arch.dispatch(|| add_up(mean, components, weights, out));
        });
    }

    /// The clusters and weights of other rows: for each the cluster nearest to it (but for rounding in `T`).
    ///
    /// # Errors
    /// [`Error::NotFinite`] for NaN and infinite elements.
    ///
    /// # Panics
    /// Unless `rows` holds whole rows, `labels` a number for each and `weights` [`components`](Self::components)
    /// numbers for each.
    #[track_caller]
    pub fn encode(&self, rows: &[T], labels: &mut [u32], weights: &mut [T]) -> Result<()> {
        let columns = self.columns();
        let count = rows.len() / columns;
        check_length("rows", count * columns, rows.len());
        check_length("labels", count, labels.len());
        check_length("weights", count * self.components(), weights.len());
        let largest = |x: &[T]| x.iter().fold(0.0f64, |max, x| max.max(x.widen().abs()));
        if let Some(index) = rows.iter().position(|x| !x.is_finite()) {
            return Err(Error::NotFinite { what: "row element", index });
        }
        // About the mean of the means.
        let mean = |c: usize| self.bases.cluster(c).0;
        let share = T::of(1.0 / self.clusters() as f64);
        let mut centre = vec![T::zero(); columns];
        for c in 0..self.clusters() {
            centre.iter_mut().zip(mean(c)).for_each(|(sum, &m)| *sum += m * share);
        }
        let scaling = Scaling::of::<T>((0..self.clusters()).fold(largest(rows), |max, c| max.max(largest(mean(c)))));
        let mut places = vec![Place { label: u32::MAX, error: 0.0 }; count];
        let watch = Watch::new(&(), count);
        Nearest::new(&self.bases, &centre, scaling).nearest(rows, &mut places, &watch)?;
        labels.iter_mut().zip(&places).for_each(|(label, place)| *label = place.label);
        weigh(&self.bases, rows, labels, weights);
        Ok(())
    }

    /// Length of the scratch of a product with `count` right-hand sides.
    pub fn scratch_len(&self, count: usize) -> usize {
        (self.clusters() * (self.components() + 1)).saturating_mul(count)
    }

    /// The product with a light, without decoding.
    ///
    /// # Panics
    /// If `x.len()` is not the number of columns, `out.len()` not that of rows, or `scratch` not
    /// [`scratch_len(1)`](Self::scratch_len) long.
    #[track_caller]
    pub fn multiply(&self, x: &[T], out: &mut [T], scratch: &mut [T]) {
        self.multiply_batch(1, x, out, scratch);
    }

    #[track_caller]
    fn check_sides(&self, sides: usize, x: &[T], out: &[T]) {
        check_length("right-hand sides", self.columns().saturating_mul(sides), x.len());
        check_length("product", self.rows().saturating_mul(sides), out.len());
    }

    /// The products with `count` lights at once: number k of light s is `x[k · count + s]`. What the means and
    /// components give goes to `scratch`.
    ///
    /// Accuracy: products with means and components are sums in `f64`, rounded once; a row is a sum of components + 1
    /// terms in `T`.
    ///
    /// # Panics
    /// If `x.len()` is not columns · `count`, `out.len()` not rows · `count`, or `scratch` not
    /// [`scratch_len`](Self::scratch_len) long.
    #[track_caller]
    pub fn multiply_batch(&self, count: usize, x: &[T], out: &mut [T], scratch: &mut [T]) {
        self.check_sides(count, x, out);
        check_length("scratch", self.scratch_len(count), scratch.len());
        self.meet(x, count, scratch);
        match count {
            1 => self.gather::<1>(scratch, out),
            3 => self.gather::<3>(scratch, out),
            4 => self.gather::<4>(scratch, out),
            _ => self.gather_any(count, scratch, out),
        }
    }

    /// Products of all means and components with the right-hand sides.
    fn meet(&self, x: &[T], sides: usize, out: &mut [T]) {
        let columns = self.columns();
        let turned: Vec<f64> = (0..columns * sides).map(|at| x[at % columns * sides + at / columns].widen()).collect();
        let zeros = vec![0.0; columns];
        let rows = Rows::<T, f64>::new(&self.bases.data, &zeros, Scaling::of::<f64>(0.0));
        let mut wide = vec![0.0; out.len()];
        times_rows(&rows, &Factors::plain(&turned, columns), Part::All, &mut wide);
        out.iter_mut().zip(wide).for_each(|(out, x)| *out = T::of(x));
    }

    fn gather<const S: usize>(&self, met: &[T], out: &mut [T]) {
        let (met, _) = met.as_chunks::<S>();
        let k = self.components();
        parallel::rows(out, S, 256, |row, out| {
            let met = &met[self.labels[row] as usize * (k + 1)..][..k + 1];
            let mut sums = met[0];
            for (&weight, met) in self.weights[row * k..][..k].iter().zip(&met[1..]) {
                (0..S).for_each(|s| sums[s] += weight * met[s]);
            }
            out.copy_from_slice(&sums);
        });
    }

    fn gather_any(&self, sides: usize, met: &[T], out: &mut [T]) {
        let k = self.components();
        parallel::rows(out, sides, 64, |row, out| {
            let met = &met[self.labels[row] as usize * (k + 1) * sides..][..(k + 1) * sides];
            out.copy_from_slice(&met[..sides]);
            for (&weight, met) in self.weights[row * k..][..k].iter().zip(met[sides..].chunks_exact(sides)) {
                out.iter_mut().zip(met).for_each(|(sum, &met)| *sum += weight * met);
            }
        });
    }

    /// Sizes and errors.
    pub fn stats(&self) -> ClusteredPcaStats {
        let size = size_of::<T>();
        ClusteredPcaStats {
            clusters: self.clusters(),
            distortion: self.distortion,
            basis_bytes: self.bases.data.len() * size,
            row_bytes: self.weights.len() * size + self.labels.len() * 4,
            matrix_bytes: self.rows() * self.columns() * size,
        }
    }
}

fn check<T>(matrix: &[T], columns: usize, settings: &ClusteredPcaSettings) -> Result<usize> {
    let rows = check_matrix(matrix, columns)?;
    settings.check(columns)?;
    if rows > u32::MAX as usize {
        return Err(Error::OutOfRange { what: "rows", got: rows as f64, allowed: "below 2^32" });
    }
    Ok(rows)
}

/// Weights of rows in the clusters that `labels` name.
fn weigh<T: Real>(bases: &Bases<T>, rows: &[T], labels: &[u32], weights: &mut [T]) {
    let arch = Arch::new();
    parallel::rows(weights, bases.components, 64, |row, weights| {
        let mut difference = vec![0.0; bases.columns];
        let x = &rows[row * bases.columns..][..bases.columns];
        arch.dispatch(|| bases.distance(labels[row] as usize, x, 1.0, &mut difference, weights));
    });
}

approx_by_parts!(
    [T] ClusteredPca<T>, T,
    |c| close [&c.bases.data, &c.weights] same [c.bases.columns, c.bases.components, &c.bases.sizes, &c.labels]
);
