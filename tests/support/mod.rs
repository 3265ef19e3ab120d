//! What tests of several rooms share, a file for each idea.
//!
//! Every test program takes it in whole (`#[path = "../support/mod.rs"] mod support;`) and uses its own share.
#![allow(dead_code, unused_imports, reason = "each test program uses its own share of this")]

mod affine;
mod cases;
mod compare;
mod golden;
mod harmonics;
mod noise;
#[cfg(feature = "scene")]
mod scene;
mod watch;

#[cfg(feature = "proptest")]
pub use affine::differentiable;
pub use affine::{map, right_gradient};
pub use cases::cases;
pub use compare::{
    assert_all_close, assert_below, assert_close, dot, flat, largest, narrow, norm, wide, worst, worst_of,
};
pub use golden::{HAAR_AFFINE, HARMONICS, golden, half_power, number, numbers};
pub use harmonics::coefficients;
pub use noise::{Stream, noise, random};
#[cfg(feature = "scene")]
pub use scene::{baker, grid, noisy, room, soup};
pub use watch::Watch;
