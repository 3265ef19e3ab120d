//! Wavelet double products: a light of few wavelets times the transport of a fixed view and fixed materials [Ng 2003].
//!
//! Visibility × reflectance × cosine around each vertex is computed once, over a cube map, and brought into the Haar
//! basis of each face. A frame multiplies that sparse matrix with the few wavelets that are kept of the light. Only the
//! light may change.
//!
//! | type | life |
//! |---|---|
//! | [`Transport`] | the matrix of a static scene, baked once, saved and loaded |
//! | [`BakeSettings`], [`Precision`] | what is dropped of it, and in how many bits the rest is stored |
//! | [`Relighter`] | frames |
//! | [`Settings`] | how many wavelets a light keeps, and which |
//!
//! Which wavelets of the light to keep: see [`Selection`](crate::haar::Selection). By magnitude alone 1 % of the terms
//! is too few (docs/performance.md has the figures).

mod bake;
mod block;
mod file;
mod relighter;
mod settings;
mod transport;

pub use relighter::Relighter;
pub use settings::{BakeSettings, Precision, Settings};
pub use transport::{Transport, TransportStats};
