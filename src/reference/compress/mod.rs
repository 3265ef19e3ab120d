//! Twins of [`compress`](crate::compress).

mod bicluster;
mod clustered_pca;
mod pca;
mod quantise;
mod run_coding;

pub use bicluster::{
    NaiveBicluster, bicluster, bicluster_saving, bicluster_values, first_nonzero, least_pruning_error, multiply_levels,
    weighted_squared_error,
};
pub use clustered_pca::{assign, cluster_distances, fit_clusters, total_error};
pub use pca::{NaivePca, symmetric_eigen};
pub use quantise::{bytes, half_value, nearest_half};
pub use run_coding::{differences, hilbert, integrate, suffix_sums, varint};
