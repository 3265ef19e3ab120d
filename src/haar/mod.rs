//! Haar wavelets.

mod coupling;
mod index;
mod n_fold;
mod product;
mod sparse;
mod triple;
mod tripling;
mod wavelet_tree;

pub use coupling::coupling;
pub use index::{Index1d, Index2d, Kind};
pub use n_fold::NFoldProduct;
pub use product::{Product1d, Product2d, multiply_sparse_1d, multiply_sparse_2d};
pub use sparse::SparseVector;
pub use triple::{
    BitPyramid, BitPyramidRef, Factor, MaskedSum, MeanTree, NgTree, NgTripleProduct, Route, SparseNodes, TripleProduct,
    Visibility, rows_to_morton, upper_means,
};
pub use tripling::{
    Tripling, tripling_1d, tripling_2d, tripling_count_1d, tripling_count_2d, tripling_nonzeros_1d,
    tripling_nonzeros_2d,
};
pub use wavelet_tree::{BinaryTree, Quadtree, WaveletTree};
