//! Fewer bits a number.

mod bytes;
mod half;
mod stored;

pub use bytes::{ByteBlocks, QuantisedBytes};
pub use half::{QuantisedHalf, half_to_real, real_to_half};
