//! Compression against naive twins; its files.
#![cfg(all(feature = "reference", feature = "proptest"))]

mod bicluster;
mod clustered_pca;
mod pca;
mod quantise;
mod run_coding;
mod stored;
#[path = "../support/mod.rs"]
mod support;
