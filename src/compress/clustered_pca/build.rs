//! Clustering, round after round.

use super::super::dense::Scaling;
use super::super::pca::{Moments, PcaSettings};
use super::bases::Bases;
use super::nearest::{Nearest, Place};
use super::seeds::far_rows;
use super::settings::ClusteredPcaSettings;
use crate::parallel::Watch;
use crate::{Progress, Real, Result};

/// Where to begin.
pub(super) enum Start<'a> {
    /// Rows that are far from each other, and k-means.
    Seeds,
    /// A cluster for each row.
    Labels(&'a [u32]),
}

/// Means and components, and the cluster of each row.
pub(super) type Built<T> = (Bases<T>, Vec<u32>);

pub(super) struct Builder<'a, T> {
    matrix: &'a [T],
    columns: usize,
    /// The mean of all rows.
    centre: Vec<T>,
    scaling: Scaling,
    settings: &'a ClusteredPcaSettings,
    watch: Watch<'a>,
}

impl<'a, T: Real> Builder<'a, T> {
    pub fn new(
        matrix: &'a [T],
        columns: usize,
        settings: &'a ClusteredPcaSettings,
        progress: &'a dyn Progress,
    ) -> Result<Self> {
        let moments = Moments::of(matrix, columns)?;
        let centre = moments.mean.iter().map(|&m| T::of(m)).collect();
        let scaling = Scaling::of::<T>(moments.largest);
        let rounds = settings.iterations.saturating_mul(2).saturating_add(1);
        let total = (matrix.len() / columns).saturating_mul(rounds);
        let watch = Watch::new(progress, total);
        Ok(Self { matrix, columns, centre, scaling, settings, watch })
    }

    pub fn run(&self, start: Start) -> Result<Built<T>> {
        let rows = self.matrix.len() / self.columns;
        let clusters = self.settings.clusters.min(rows);
        self.watch.check()?;
        let mut places = vec![Place::default(); rows];
        let mut finished = false;
        match start {
            Start::Seeds => {
                let seeds = far_rows(self.matrix, self.columns, clusters, self.settings.seed, self.scaling);
                let bases = Bases::of_rows(self.matrix, self.columns, &seeds);
                Nearest::new(&bases, &self.centre, self.scaling).nearest(self.matrix, &mut places, &self.watch)?;
                self.rounds(0, clusters, &mut places)?;
                finished = self.settings.components == 0;
            }
            Start::Labels(labels) => {
                // Errors are not known yet; they are after the first round.
                places
                    .iter_mut()
                    .zip(labels)
                    .for_each(|(place, &label)| *place = Place { label, error: f64::INFINITY });
            }
        }
        self.watch.skip_to(rows.saturating_mul(self.settings.iterations.saturating_add(1)));
        if !finished {
            self.rounds(self.settings.components, clusters, &mut places)?;
        }
        self.watch.check()?;
        let mut labels: Vec<u32> = places.iter().map(|place| place.label).collect();
        let bases = self.fit(&labels, clusters, self.settings.components).without_empty(&mut labels);
        self.watch.skip_to(self.watch.total());
        Ok((bases, labels))
    }

    /// Fits `components` to each cluster and moves rows to the nearest, until little changes.
    fn rounds(&self, components: usize, clusters: usize, places: &mut [Place]) -> Result<()> {
        let mut before = f64::INFINITY;
        for _ in 0..self.settings.iterations {
            self.watch.check()?;
            inhabit(places, clusters);
            let labels: Vec<u32> = places.iter().map(|place| place.label).collect();
            let bases = self.fit(&labels, clusters, components);
            Nearest::new(&bases, &self.centre, self.scaling).nearest(self.matrix, places, &self.watch)?;
            let error = places.iter().map(|place| place.error).sum::<f64>();
            // Not the first time: infinity less anything is more than any share of it.
            if error == 0.0 || before - error <= self.settings.tolerance * before && before.is_finite() {
                break;
            }
            before = error;
        }
        Ok(())
    }

    fn fit(&self, labels: &[u32], clusters: usize, components: usize) -> Bases<T> {
        let settings = PcaSettings::new(components).with_seed(self.settings.seed);
        Bases::fit(self.matrix, self.columns, labels, self.scaling, &settings, clusters)
    }
}

/// Gives each cluster without rows the row with the largest error (the first of equals) that is not alone in its
/// cluster; those without error stay where they are.
fn inhabit(places: &mut [Place], clusters: usize) {
    let mut sizes = vec![0usize; clusters];
    places.iter().for_each(|place| sizes[place.label as usize] += 1);
    let empty: Vec<usize> = (0..clusters).filter(|&c| sizes[c] == 0).collect();
    if empty.is_empty() {
        return;
    }
    let mut worst: Vec<usize> = (0..places.len()).filter(|&row| places[row].error > 0.0).collect();
    worst.sort_by(|&a, &b| places[b].error.total_cmp(&places[a].error)); // stable
    let mut worst = worst.into_iter();
    for c in empty {
        let Some(row) = worst.find(|&row| sizes[places[row].label as usize] > 1) else { return };
        sizes[places[row].label as usize] -= 1;
        sizes[c] = 1;
        places[row] = Place { label: c as u32, error: 0.0 };
    }
}
