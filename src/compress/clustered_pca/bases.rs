//! Means and components of all clusters.

use pulp::Arch;

use super::super::dense::{Scaling, dot_wide};
use super::super::pca::{PcaSettings, Source, fit};
use crate::{Real, parallel};

/// For each cluster its mean and then its components; those that a cluster lacks are zero.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bases<T> {
    pub columns: usize,
    /// Components of a cluster.
    pub components: usize,
    pub data: Vec<T>,
    /// How many rows each cluster has; one without rows takes none.
    pub sizes: Vec<usize>,
}

impl<T: Real> Bases<T> {
    /// Means alone, of clusters that count as inhabited.
    pub fn of_rows(matrix: &[T], columns: usize, rows: &[usize]) -> Self {
        let data = rows.iter().flat_map(|&row| &matrix[row * columns..][..columns]).copied().collect();
        Self { columns, components: 0, data, sizes: vec![1; rows.len()] }
    }

    /// The mean and the first `components` components of the rows of each label.
    pub fn fit(
        matrix: &[T],
        columns: usize,
        labels: &[u32],
        scaling: Scaling,
        settings: &PcaSettings,
        clusters: usize,
    ) -> Self {
        let members = members(labels, clusters);
        let arch = Arch::new();
        let bases = parallel::map(clusters, |c| {
            let order = &members[c];
            let mut basis = vec![T::zero(); columns * (settings.components + 1)];
            if order.is_empty() {
                return basis;
            }
            let (mean, rest) = basis.split_at_mut(columns);
            arch.dispatch(|| mean_of(matrix, order, mean));
            let found = fit(&Source { data: matrix, mean, scaling, order: Some(order) }, settings);
            rest.iter_mut().zip(&found.components).for_each(|(to, &x)| *to = T::of(x));
            basis
        });
        let sizes = members.iter().map(Vec::len).collect();
        Self { columns, components: settings.components, data: bases.concat(), sizes }
    }

    pub fn clusters(&self) -> usize {
        self.sizes.len()
    }

    /// Mean and components of a cluster.
    #[inline(always)]
    pub fn cluster(&self, c: usize) -> (&[T], &[T]) {
        let len = self.columns * (self.components + 1);
        self.data[c * len..][..len].split_at(self.columns)
    }

    /// |d|² − Σ (u_j·d)² of d = factor · (x − m), in `f64`; weights go to `weights` if it is not empty.
    #[inline(always)]
    pub fn distance(&self, c: usize, x: &[T], factor: f64, difference: &mut [f64], weights: &mut [T]) -> f64 {
        let (mean, components) = self.cluster(c);
        for ((d, x), m) in difference.iter_mut().zip(x).zip(mean) {
            *d = factor * (x.widen() - m.widen());
        }
        let mut left = dot_wide(difference, difference);
        for (j, u) in components.chunks_exact(self.columns).enumerate() {
            let weight = dot_wide(difference, u);
            left -= weight * weight;
            if let Some(slot) = weights.get_mut(j) {
                *slot = T::of(weight);
            }
        }
        left.max(0.0)
    }

    /// Without clusters that have no rows; `labels` are renumbered.
    pub fn without_empty(mut self, labels: &mut [u32]) -> Self {
        let len = self.columns * (self.components + 1);
        let mut numbers = vec![0; self.clusters()];
        let mut kept = 0;
        for c in 0..self.clusters() {
            if self.sizes[c] > 0 {
                self.data.copy_within(c * len..(c + 1) * len, kept * len);
                self.sizes[kept] = self.sizes[c];
                numbers[c] = kept as u32;
                kept += 1;
            }
        }
        self.data.truncate(kept * len);
        self.sizes.truncate(kept);
        labels.iter_mut().for_each(|label| *label = numbers[*label as usize]);
        self
    }
}

/// The rows of each label, ascending.
fn members(labels: &[u32], clusters: usize) -> Vec<Vec<u32>> {
    let mut members = vec![Vec::new(); clusters];
    labels.iter().enumerate().for_each(|(row, &label)| members[label as usize].push(row as u32));
    members
}

/// r + Σ (x − r)/n with r the first row: exact if all rows are equal.
#[inline(always)]
fn mean_of<T: Real>(matrix: &[T], order: &[u32], mean: &mut [T]) {
    let columns = mean.len();
    let row = |row: u32| &matrix[row as usize * columns..][..columns];
    let reference = row(order[0]);
    let mut sums = vec![0.0; columns];
    for &i in order {
        for ((sum, x), r) in sums.iter_mut().zip(row(i)).zip(reference) {
            *sum += x.widen() - r.widen();
        }
    }
    for ((mean, sum), r) in mean.iter_mut().zip(sums).zip(reference) {
        *mean = T::of(r.widen() + sum / order.len() as f64);
    }
}
