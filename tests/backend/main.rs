//! The back ends: what all of them promise (corpus), and each against its own twins and laws.
#![cfg(all(feature = "backends", feature = "reference", feature = "proptest"))]

mod allocations;
mod block_product;
mod corpus;
#[path = "near_field/importance_sampling/mod.rs"]
mod importance_sampling;
#[path = "../support/mod.rs"]
mod support;
mod wavelet;
mod wavelet_file;
mod wavelet_range;
