//! Summed-area and visibility distance tables against naive twins.
#![cfg(all(feature = "reference", feature = "proptest"))]

mod summed_area;
#[path = "../support/mod.rs"]
mod support;
mod visibility_distance;
