//! Twins of [`compress`](crate::compress).

mod run_coding;

pub use run_coding::{differences, hilbert, integrate, suffix_sums, varint};
