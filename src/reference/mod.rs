//! Naive `f64` twins of the fast paths: short, slow and obviously right, for tests here and elsewhere.

pub mod affine;
#[cfg(feature = "scene")]
pub mod backend;
pub mod compress;
pub mod dct;
pub mod haar;
#[cfg(feature = "scene")]
pub mod scene;
pub mod sh;
pub mod sphere;
pub mod table;
