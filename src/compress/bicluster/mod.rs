//! Biclustering of sparse matrices [bi-scale radiance transfer §IV, V, VI].

mod clusters;
mod growth;
mod histogram;
mod loss;
mod matrix;
mod multiply;
mod partition;
mod pruning;
mod queue;
mod residual;
mod search;
mod settings;
mod stored;
mod trace;

pub use clusters::{Bicluster, BiclusterStats, Biclustering};
pub use matrix::SparseMatrix;
pub use multiply::BiclusterMultiplier;
pub use pruning::{BiclusterPruning, PruningPoint};
pub use settings::{BiclusterSettings, Seeds};
pub use trace::{BiclusterMove, BiclusterStep, BiclusterTrace};
