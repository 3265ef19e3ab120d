//! Compression of what light transport stores.
//!
//! | you have | use |
//! |---|---|
//! | a sparse matrix whose entries take few values, such as down-sampled visibility | [`Biclustering`]: lossless, and cheaper to multiply by |

mod bicluster;

pub use bicluster::{
    Bicluster, BiclusterMove, BiclusterMultiplier, BiclusterSettings, BiclusterStats, BiclusterStep, BiclusterTrace,
    Biclustering, Seeds, SparseMatrix,
};
