//! Scenes against naive twins: geometry, visibility, BRDFs, lights, ground truth.
#![cfg(all(feature = "backends", feature = "reference", feature = "proptest"))]

mod brdf;
mod brdf_expansions;
mod edges;
mod far;
mod geometry;
mod ground_truth;
mod light;
mod local_truth;
mod stage;
#[path = "../support/mod.rs"]
mod support;
mod visibility;
mod visibility_anywhere;
