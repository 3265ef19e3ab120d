//! Wavelet triple products: light × visibility × reflectance, all of them free [Ng 2004].
//!
//! Only visibility around each vertex is precomputed, a bit a texel of a cube map. A frame keeps few Haar wavelets of
//! the light and of each vertex's reflectance × cosine (its *slice*: of one normal and one view, over all directions),
//! and integrates the product of three. Light, view and materials may change.
//!
//! | type | life |
//! |---|---|
//! | [`Transport`] | visibility of a static scene, baked once, saved and loaded |
//! | [`Relighter`] | frames |
//! | [`Settings`], [`Slices`] | how many wavelets are kept, and where slices come from |
//!
//! A face's light is weighted by side² × solid angle of each texel, so that the mean over the face of light ×
//! visibility × brdf_cos is the integral over its solid angle. Which wavelets to keep: see
//! [`Selection`](crate::haar::Selection). By magnitude alone 1 % of the terms is too few (docs/performance.md has the
//! figures).
//!
//! docs/references.md names a patent on product integrals by wavelet trees.

mod relighter;
mod settings;
mod slices;
mod transport;

pub use relighter::Relighter;
pub use settings::{Settings, Slices};
pub use transport::{Transport, TransportStats};
