//! Naive `f64` twins of the fast paths: short, slow and obviously right, for tests here and elsewhere.

#[cfg(feature = "scene")]
pub mod scene;
