//! Naive twins of [`backend`](crate::backend).

#[cfg(feature = "block_product")]
pub mod block_product;
#[cfg(feature = "near_field")]
pub mod near_field;
#[cfg(feature = "near_field")]
pub mod near_field_sampling;
pub mod wavelet;
