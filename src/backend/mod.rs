//! Rendering back ends: one module is one method behind one feature.
//!
//! All of them have one life. **Bake** turns a scene into a *transport*: long work with progress and cancellation, in
//! parallel, the same bits for any number of threads. A transport is saved and loaded as a checksummed file. **Relight** turns
//! light, view and materials into radiance per vertex, frame after frame, without allocation after the first.

mod archive;
#[cfg(feature = "block_product")]
pub mod block_product;
#[cfg(feature = "wavelet")]
pub mod wavelet;
