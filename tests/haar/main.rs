//! Haar wavelets against naive twins and golden values.
#![cfg(all(feature = "reference", feature = "proptest"))]

mod product;
mod sample_warp;
mod standard;
#[path = "../support/mod.rs"]
mod support;
mod transform;
