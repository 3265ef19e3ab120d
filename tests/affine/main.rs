//! Affine wavelets against exact sums, twins and golden values.
#![cfg(all(feature = "reference", feature = "proptest"))]

mod bases;
mod canonical;
mod coupling;
mod exactness;
mod frames;
mod image;
mod pixel_operator;
mod product;
mod propagation;
mod reference;
mod sides;
#[path = "../support/mod.rs"]
mod support;
mod tables;
mod tripling;
mod vertices;
