//! Clustered principal components.

mod bases;
mod build;
mod coded;
mod entries;
mod nearest;
mod seeds;
mod settings;
mod stored;

pub use coded::{ClusteredPca, ClusteredPcaStats};
pub use settings::ClusteredPcaSettings;
