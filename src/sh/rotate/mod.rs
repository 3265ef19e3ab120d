//! Rotation of expansions.

mod about_z;
mod blocks;
mod chain;
mod rotation;
mod rotator;
mod sample;
mod single;
mod sizes;
mod swap;
mod turns;

pub use about_z::{rotate_z, rotate_z_batch};
pub use rotation::Rotation;
pub use rotator::Rotator;
