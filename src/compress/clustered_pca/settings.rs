//! How to cluster.

use crate::{Error, Result};

/// Settings of [`ClusteredPca`](crate::compress::ClusteredPca).
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ClusteredPcaSettings {
    /// Most clusters.
    pub clusters: usize,
    /// Components of each cluster beside its mean; with 0 this is k-means. At most 65536, or the number of columns if
    /// that is more.
    pub components: usize,
    /// Most rounds of k-means, and then of clustering by components; default 20. A round reads the matrix twice.
    pub iterations: usize,
    /// Rounds end when the squared error falls by less than this share of it, default 0.002.
    pub tolerance: f64,
    /// Seed of the first means and of the sketches of components.
    pub seed: u64,
}

impl ClusteredPcaSettings {
    /// At most `clusters` clusters of `components` components.
    pub fn new(clusters: usize, components: usize) -> Self {
        Self { clusters, components, iterations: 20, tolerance: 0.002, seed: 0 }
    }

    /// The same with at most so many rounds.
    #[must_use]
    pub fn with_iterations(self, iterations: usize) -> Self {
        Self { iterations, ..self }
    }

    /// The same with another tolerance.
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// The same from another seed.
    #[must_use]
    pub fn with_seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    pub(super) fn check(&self, columns: usize) -> Result<()> {
        if self.clusters == 0 {
            return Err(Error::OutOfRange { what: "clusters", got: 0.0, allowed: "at least 1" });
        }
        // Those beyond the columns are zeros, and take memory.
        if self.components > columns.max(1 << 16) {
            let (got, allowed) = (self.components as f64, "at most 65536, or the number of columns");
            return Err(Error::OutOfRange { what: "components of a cluster", got, allowed });
        }
        if !(self.tolerance >= 0.0) {
            return Err(Error::OutOfRange { what: "tolerance", got: self.tolerance, allowed: "at least 0" });
        }
        Ok(())
    }
}
