//! Haar wavelets against naive twins and golden values.
#![cfg(all(feature = "reference", feature = "proptest"))]

mod product;
#[path = "../support/mod.rs"]
mod support;
mod transform;
