//! The mathematics of light transport.
#![cfg_attr(docsrs, feature(doc_cfg))]

mod error;
#[cfg(feature = "scene")]
mod progress;
mod real;

pub mod haar;
pub mod numeric;
#[cfg(feature = "reference")]
pub mod reference;
#[cfg(feature = "scene")]
pub mod scene;
pub mod sphere;
#[cfg(feature = "proptest")]
pub mod strategies;

pub use error::{Error, Result};
pub use nalgebra;
#[cfg(feature = "scene")]
pub use progress::Progress;
pub use real::Real;
