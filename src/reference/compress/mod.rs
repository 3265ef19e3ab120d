//! Twins of [`compress`](crate::compress).

mod bicluster;
mod pca;
mod run_coding;

pub use bicluster::{NaiveBicluster, bicluster, bicluster_saving, bicluster_values, first_nonzero, multiply_levels};
pub use pca::{NaivePca, symmetric_eigen};
pub use run_coding::{differences, hilbert, integrate, suffix_sums, varint};
