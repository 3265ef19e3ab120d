//! Compression of what light transport stores.
//!
//! | you have | use |
//! |---|---|
//! | a sparse matrix whose entries take few values, such as down-sampled visibility | [`Biclustering`]: lossless, and cheaper to multiply by |
//! | the same, and an error that may be made | [`Biclustering::pruning`]: the smallest storage for it, and the whole curve |
//! | binary maps with long runs, such as visibility, to be multiplied by ever new lights | [`CodedBinaryMaps`]: lossless, a dot product costs one look-up a change |
//! | the same, anti-aliased | [`CodedGrayMaps`] |
//! | dense rows that are alike: transfer vectors, grey maps | [`Pca`]: with loss, a few weights a row |
//! | the same, and kinds of rows that differ | [`ClusteredPca`]: fewer weights a row for the same error, products with a light without decoding |
//! | numbers, such as weights and components, and too many bits | [`QuantisedHalf`], [`QuantisedBytes`] |

mod bicluster;
mod clustered_pca;
mod dense;
mod distortion;
mod pca;
mod quantise;
mod random;
mod run_coding;

pub use bicluster::{
    Bicluster, BiclusterMove, BiclusterMultiplier, BiclusterPruning, BiclusterSettings, BiclusterStats, BiclusterStep,
    BiclusterTrace, Biclustering, PruningPoint, Seeds, SparseMatrix,
};
pub use clustered_pca::{ClusteredPca, ClusteredPcaSettings, ClusteredPcaStats};
pub use distortion::Distortion;
pub use pca::{Centre, Pca, PcaMethod, PcaSettings};
pub use quantise::{ByteBlocks, QuantisedBytes, QuantisedHalf, half_to_real, real_to_half};
pub use run_coding::{
    CodedBinaryMap, CodedBinaryMaps, CodedGrayMap, CodedGrayMaps, GraySpans, MapIndex, MapState, RunStats, Runs,
    Sample, Scan, ScanOrder, decode_gaps, encode_gaps, suffix_sums,
};
