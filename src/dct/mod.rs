//! The cosine transform of square blocks, and its lowest frequencies from few samples or few coefficients.
//!
//! A light is cut into blocks of, say, 16 × 16 texels. Over a block where nothing hides it, the light reflected by a
//! smooth BRDF is a dot product of a few DCT coefficients of both: those of the light come from a transform at every
//! new light, those of the BRDF from a handful of samples at every vertex [Inger 2013, §4.1].
//!
//! | you have | you want | use |
//! |---|---|---|
//! | blocks, or an image to be tiled | all coefficients, or the l × l lowest | [`BlockDct::forward`], [`BlockDct::forward_low`] |
//! | coefficients, all or few | the block | [`BlockDct::inverse`], [`BlockDct::inverse_low`] |
//! | a function that can be sampled anywhere, smooth over the block | its l × l lowest | [`LowProjection::centres`] |
//! | the same, at whole pixels only | the same | [`LowProjection::at`] |
//! | coefficients of two functions | the sum over the block of their product | [`product_integral`] |
//!
//! The basis is orthonormal over the *samples* of a block, unlike that of [`haar`](crate::haar), which is orthonormal
//! over the unit square: C_00 is side × mean. NaN and infinity reach every coefficient of their block, and only theirs.

mod block;
mod kernels;
mod product;
mod projection;
mod tables;

pub use block::{BlockDct, forward, inverse};
pub use product::product_integral;
pub use projection::LowProjection;
