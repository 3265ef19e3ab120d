//! Compression against naive twins; its files.
#![cfg(all(feature = "reference", feature = "proptest"))]

mod bicluster;
mod clustered_pca;
mod entries;
mod pca;
mod pruning;
mod quantise;
mod run_coding;
mod stored;
#[path = "../support/mod.rs"]
mod support;
