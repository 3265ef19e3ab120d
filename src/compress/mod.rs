//! Compression of what light transport stores.
//!
//! | you have | use |
//! |---|---|
//! | binary maps with long runs, such as visibility, to be multiplied by ever new lights | [`BinaryMaps`]: lossless, a dot product costs one look-up a change |
//! | the same, anti-aliased | [`GrayMaps`] |

mod run_coding;

pub use run_coding::{
    BinaryMap, BinaryMaps, GrayMap, GrayMaps, GraySpans, MapIndex, MapState, RunStats, Runs, Sample, Scan, ScanOrder,
    decode_gaps, encode_gaps, suffix_sums,
};
