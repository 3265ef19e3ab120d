//! Differential coding of maps: where a map changes, and what that is worth against partial sums of a signal.
//!
//! Concatenate the rows of a map V into a vector (`Scan` has better orders than rows). Its differences V_d = D V are
//! mostly 0, and those of a binary map alternate +1, −1, so their places are enough [Inger 2013, eq. 5]:
//!
//! | map | changes |
//! |---|---|
//! | 0000… | {} |
//! | 1111… | {0}: before the start all is 0 |
//! | 0011 0… | {2, 4} |
//! | …0001 | {len − 1}: the end is no change |
//!
//! A map of 256 pixels so has up to 256 changes, each of which fits 8 bits while their number needs 9. Against the sums
//! L_int\[i\] = Σ_{j≥i} L_j (D⁻ᵀ L, *suffix* sums; eq. 6) the dot product Σ V L is Σ V_d L_int: one look-up a change.

mod binary;
mod bytes;
mod gray;
mod index;
mod scan;
mod stats;
mod stored;
mod sums;

pub use binary::{CodedBinaryMap, CodedBinaryMaps, MapState, Runs};
pub use bytes::{decode_gaps, encode_gaps};
pub use gray::{CodedGrayMap, CodedGrayMaps, GraySpans};
pub use index::MapIndex;
pub use scan::{Scan, ScanOrder};
pub use stats::RunStats;
pub use sums::{Sample, suffix_sums};
