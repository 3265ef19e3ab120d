//! Naive twins of [`scene`](crate::scene).

mod visibility;

pub use visibility::{closest_hit, occluded};
