//! Rendering back ends: one module is one method behind one feature.
//!
//! | module | method | precomputed for each vertex | may change in each frame |
//! |---|---|---|---|
//! | `wavelet_double` | Ng 2003: sparse light × transport | visibility × reflectance, in wavelets | light |
//! | `wavelet_triple` | Ng 2004: light × visibility × reflectance | visibility, a bit a texel | light, view, materials |
//! | `near_field` | Sun 2008: planar lights near the scene | visibility × reflectance on top faces, in wavelets | lights: place, size, angle, texture; the view, if it was left free |
//! | `block_product` | Inger 2013: locally adaptive products | visibility, coded in blocks | light, view, materials |
//!
//! Every method has the same words and the same life. A `Transport` holds what was precomputed of a static scene. It is
//! made by `Transport::bake`, which may take long and so reports [`Progress`](crate::Progress), or by a
//! `Transport::from_…` of what is there already; it is saved and loaded by [`store::Stored`](crate::store::Stored);
//! `stats` counts what it holds, and `bytes` says how much memory that takes. A `Relighter` borrows a transport.
//! `Relighter::new` takes its `Settings`, `set_light` a light, and `relight` gives the radiance of every vertex.
//! Arguments come in one order: mesh, visibility, view, materials, settings, progress, output; a method leaves out what
//! it does not need.
//!
//! The results are the same bits for any number of threads. After the first frame of a relighter, `relight` allocates
//! nothing as long as the materials stay the same; `set_light` may allocate.
//!
//! [`DistantRelighter`] is what methods for distant light per vertex have in common: hold them as `dyn` to swap one for
//! another. Near light is not of that kind: it has relighters of its own, with the same verbs.

#[cfg(feature = "block_product")]
pub mod block_product;
mod distant;
#[cfg(feature = "near_field")]
pub mod near_field;
#[cfg(feature = "wavelet_double")]
pub mod wavelet_double;
#[cfg(feature = "wavelet_triple")]
pub mod wavelet_triple;

pub use distant::{DistantRelighter, Freedom};
