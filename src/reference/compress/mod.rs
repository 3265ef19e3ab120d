//! Twins of [`compress`](crate::compress).

mod bicluster;

pub use bicluster::{NaiveBicluster, bicluster, bicluster_saving, bicluster_values, first_nonzero, multiply_levels};
