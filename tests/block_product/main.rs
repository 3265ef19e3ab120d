//! Locally adaptive products against naive twins and ground truth; their files.
#![cfg(all(feature = "block_product", feature = "reference", feature = "proptest"))]

mod bounded;
mod closures;
mod exact;
mod extremes;
mod file;
mod fixed;
mod frames;
mod layout;
mod light;
#[path = "../support/mod.rs"]
mod shared;
mod support;
mod transport;
