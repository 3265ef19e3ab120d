//! Affine wavelets against exact sums, twins and golden values.
#![cfg(all(feature = "reference", feature = "proptest"))]

mod bases;
mod canonical;
mod coupling;
mod exactness;
mod product;
mod propagation;
mod reference;
#[path = "../support/mod.rs"]
mod support;
mod tables;
mod tripling;
