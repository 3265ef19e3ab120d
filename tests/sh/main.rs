//! Spherical harmonics against naive twins, golden values, quadrature and theorems.
//!
//! One program, so that the library's generic code is compiled for its tests once.
#![cfg(all(feature = "reference", feature = "proptest"))]

mod basis;
mod cap_sum;
mod edges;
mod exp_log;
mod expansion;
mod light;
mod polygon;
mod presets;
mod product;
mod project;
mod rotate;
#[path = "../support/mod.rs"]
mod support;
mod zonal;
