//! The components of a matrix.

use pulp::Arch;

use super::super::dense::{Factors, Part, Rows, Scaling, times_rows};
use super::super::distortion::Distortion;
use super::fit::{Source, fit};
use super::moments::Moments;
use super::settings::{Centre, PcaSettings};
use crate::approx_eq::approx_by_parts;
use crate::error::check_length;
use crate::{Error, Real, Result, parallel};

/// Principal components of the rows of a matrix: the mean and the directions in which rows vary most.
/// ```math
/// x ≈ m + Σ_j w_j u_j,   w_j = u_j·(x − m),   Σ_x w_j² / rows = variance of component j
/// ```
///
/// Of all affine subspaces of its dimension (through the origin with [`Centre::Origin`]) this is the one with the least
/// sum of squared distances to the rows. Components are orthonormal, variances descend, and the entry of largest
/// magnitude (the first of equals) of each component is positive.
///
/// Shapes: matrices row-major; components `[j·columns + c]`, weights `[row·len + j]`.
///
/// Rank: components whose standard deviation is below 4e-6 (`f32`) or 1.2e-7 (`f64`) of the largest one's are rounding,
/// and are dropped, so [`len`](Self::len) may be less than was asked for; it is 0 if all rows are equal. Never more
/// than min(rows, columns).
/// Accuracy: the exact method to a few ε·(first deviation/this deviation); the randomised one as its settings say.
/// Cost: the randomised method reads the matrix power iterations + 3 times and multiplies by it 2 · power iterations +
/// 2 times. The same bits for any number of threads.
///
/// # Example
/// ```
/// use haarmonic::compress::{Pca, PcaSettings};
/// // Points on a line through (1, 2), in the direction (4, 3)/5.
/// let points = [1.0, 2.0, 5.0, 5.0, -3.0, -1.0];
/// let pca = Pca::new(&points, 2, &PcaSettings::new(2))?;
/// assert_eq!((pca.len(), pca.mean()), (1, &[1.0, 2.0][..]));
/// assert!((pca.component(0)[0] - 0.8f64).abs() < 1e-15);
/// let (mut weight, mut back) = ([0.0], [0.0; 2]);
/// pca.project(&[9.0, 8.0], &mut weight);
/// assert!((weight[0] - 10.0).abs() < 1e-14);
/// pca.reconstruct(&weight, &mut back);
/// assert!((back[1] - 8.0).abs() < 1e-14);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Pca<T> {
    mean: Vec<T>,
    components: Vec<T>,
    variances: Vec<f64>,
    total_variance: f64,
    factors: Factors<T>,
}

impl<T: Real> Pca<T> {
    /// Components of a row-major matrix.
    ///
    /// # Errors
    /// [`Error::Empty`] without rows or columns; [`Error::Length`] unless rows are whole; [`Error::NotFinite`] for NaN
    /// and infinite elements; [`Error::OutOfRange`] for elements above 1e140, whose squares leave `f64`, and for more
    /// than 1000 power iterations.
    pub fn new(matrix: &[T], columns: usize, settings: &PcaSettings) -> Result<Self> {
        let rows = check_matrix(matrix, columns)?;
        if settings.power_iterations > 1000 {
            let (got, allowed) = (settings.power_iterations as f64, "at most 1000: a few settle all that can be");
            return Err(Error::OutOfRange { what: "power iterations", got, allowed });
        }
        let moments = Moments::of(matrix, columns)?;
        let (mean, total) = match settings.centre {
            Centre::Mean => (moments.mean.iter().map(|&m| T::of(m)).collect(), moments.deviation),
            Centre::Origin => (vec![T::zero(); columns], moments.energy),
        };
        let scaling = Scaling::of::<T>(moments.largest);
        let found = fit(&Source { data: matrix, mean: &mean, scaling, order: None }, settings);
        let unit = scaling.factor();
        let variances = found.values.iter().map(|v| v / unit / unit / rows as f64).collect();
        let components: Vec<T> = found.components.iter().map(|&x| T::of(x)).collect();
        let factors = Factors::plain(&components, columns);
        Ok(Self { mean, components, variances, total_variance: total / rows as f64, factors })
    }

    /// From a mean (zeros for [`Centre::Origin`]), orthonormal components row after row and their variances: for those
    /// that were stored, or quantised.
    ///
    /// # Errors
    /// [`Error::Empty`] if `mean` is; [`Error::Length`] unless there are as many components as variances;
    /// [`Error::NotFinite`].
    pub fn from_parts(mean: Vec<T>, components: Vec<T>, variances: Vec<f64>, total_variance: f64) -> Result<Self> {
        if mean.is_empty() {
            return Err(Error::Empty { what: "mean" });
        }
        let expected = mean.len() * variances.len();
        if components.len() != expected {
            return Err(Error::Length { what: "components", expected, got: components.len() });
        }
        let infinite = |what, index: Option<usize>| index.map_or(Ok(()), |index| Err(Error::NotFinite { what, index }));
        infinite("mean", mean.iter().position(|x| !x.is_finite()))?;
        infinite("component element", components.iter().position(|x| !x.is_finite()))?;
        infinite("variance", variances.iter().chain([&total_variance]).position(|x| !x.is_finite()))?;
        let factors = Factors::plain(&components, mean.len());
        Ok(Self { mean, components, variances, total_variance, factors })
    }

    /// How many components there are.
    #[inline]
    pub fn len(&self) -> usize {
        self.variances.len()
    }

    /// Whether there is no component: all rows are equal, or none was asked for.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.variances.is_empty()
    }

    /// Columns of the matrix.
    #[inline]
    pub fn columns(&self) -> usize {
        self.mean.len()
    }

    /// What components pass through: the mean of the rows, or zeros.
    #[inline]
    pub fn mean(&self) -> &[T] {
        &self.mean
    }

    /// All components, one after the other.
    #[inline]
    pub fn components(&self) -> &[T] {
        &self.components
    }

    /// Component j.
    ///
    /// # Panics
    /// If j is out of range.
    #[inline]
    #[track_caller]
    pub fn component(&self, j: usize) -> &[T] {
        &self.components[j * self.columns()..][..self.columns()]
    }

    /// Mean squared weight of each component over the rows, descending.
    #[inline]
    pub fn variances(&self) -> &[f64] {
        &self.variances
    }

    /// Mean squared distance of the rows from [`mean`](Self::mean): what the variances of all components add up to.
    #[inline]
    pub fn total_variance(&self) -> f64 {
        self.total_variance
    }

    /// Weights of one row or of several, one after the other.
    ///
    /// Each row has the same bits alone and among others. NaN and infinity stay in their row.
    ///
    /// # Panics
    /// Unless `rows` holds whole rows and `weights` [`len`](Self::len) numbers for each.
    #[track_caller]
    pub fn project(&self, rows: &[T], weights: &mut [T]) {
        let count = rows.len() / self.columns();
        check_length("rows", count * self.columns(), rows.len());
        check_length("weights", count * self.len(), weights.len());
        let rows = Rows::new(rows, &self.mean, Scaling::of::<T>(0.0));
        times_rows(&rows, &self.factors, Part::All, weights);
    }

    /// One row or several from their weights.
    ///
    /// # Panics
    /// As [`project`](Self::project).
    #[track_caller]
    pub fn reconstruct(&self, weights: &[T], rows: &mut [T]) {
        let count = rows.len() / self.columns();
        check_length("rows", count * self.columns(), rows.len());
        check_length("weights", count * self.len(), weights.len());
        let arch = Arch::new();
        parallel::rows(rows, self.columns(), 16, |row, out| {
            let weights = &weights[row * self.len()..][..self.len()];
            arch.dispatch(|| add_up(&self.mean, &self.components, weights, out));
        });
    }

    /// How far the rows are from their reconstruction.
    ///
    /// # Panics
    /// Unless `matrix` holds whole rows.
    #[track_caller]
    pub fn distortion(&self, matrix: &[T]) -> Distortion {
        check_length("rows", matrix.len() / self.columns() * self.columns(), matrix.len());
        Distortion::of_rows(matrix, self.columns(), |_, rows, out| {
            let mut weights = vec![T::zero(); rows.len() / self.columns() * self.len()];
            self.project(rows, &mut weights);
            self.reconstruct(&weights, out);
        })
    }

    /// Bytes of mean, components and the weights of so many rows.
    pub fn bytes(&self, rows: usize) -> usize {
        (self.mean.len() + self.components.len() + rows * self.len()) * size_of::<T>()
    }
}

/// mean + Σ w_j u_j, 32 columns at a time.
#[inline(always)]
pub(in super::super) fn add_up<T: Real>(mean: &[T], components: &[T], weights: &[T], out: &mut [T]) {
    const L: usize = 8;
    let columns = mean.len();
    let mut first = 0;
    let (blocks, rest) = out.as_chunks_mut::<{ 4 * L }>();
    for block in blocks {
        let mut sums = [[T::zero(); L]; 4];
        let (mean, _) = mean[first..].as_chunks::<L>();
        let Some(mean) = mean.first_chunk::<4>() else { return };
        sums.copy_from_slice(mean);
        for (j, &weight) in weights.iter().enumerate() {
            let (u, _) = components[j * columns + first..].as_chunks::<L>();
            let Some(u) = u.first_chunk::<4>() else { return };
            for v in 0..4 {
                for l in 0..L {
                    sums[v][l] += weight * u[v][l];
                }
            }
        }
        block.copy_from_slice(sums.as_flattened());
        first += 4 * L;
    }
    for (c, out) in rest.iter_mut().enumerate() {
        let at = first + c;
        *out = weights.iter().enumerate().fold(mean[at], |sum, (j, &w)| sum + w * components[j * columns + at]);
    }
}

/// Rows of a matrix, if it has whole ones.
pub(in super::super) fn check_matrix<T>(matrix: &[T], columns: usize) -> Result<usize> {
    if matrix.is_empty() || columns == 0 {
        return Err(Error::Empty { what: "matrix" });
    }
    let rows = matrix.len() / columns;
    if rows * columns != matrix.len() {
        return Err(Error::Length { what: "matrix", expected: (rows + 1) * columns, got: matrix.len() });
    }
    Ok(rows)
}

approx_by_parts!(
    [T] Pca<T>, T,
    |p| close [
        &p.mean, &p.components, p.variances.iter().map(|&v| T::of(v)).collect::<Vec<T>>(), [T::of(p.total_variance)]
    ] same []
);
