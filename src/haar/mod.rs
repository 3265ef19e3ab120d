//! Haar wavelets on [0, 1] and [0, 1]²: transforms, pyramids, sparse vectors and the choice of terms.
//!
//! A signal or image is the piecewise constant function whose values on 2^k cells a side are its samples. Its
//! coefficients are inner products with an orthonormal basis of the *unit* interval or square, so they do not change
//! when the same function is sampled more finely, coefficient 0 is the mean, and Σ c² is the mean of x² (Parseval).
//!
//! | basis | index | function | made by |
//! |---|---|---|---|
//! | 1D | 0; 2^l + t ([`Index1d`]) | 1; 2^{l/2} ψ(2^l v − t) | [`Transform1d`] |
//! | 2D nonstandard | 0; 4^l·kind + y·2^l + x ([`Index2d`]) | 1; 2^l·{ψφ, φψ, ψψ}(2^l u − (x, y)) | [`Transform2d`], [`Decomposition::Nonstandard`] |
//! | 2D standard | k_y·width + k_x | ψ_{k_x}(x) ψ_{k_y}(y) | [`Transform2d`], [`Decomposition::Standard`] |
//! | N-D standard | row after row, slowest axis first | ψ_{k_1}(x_1) ⋯ ψ_{k_N}(x_N) | [`TransformNd`] |
//!
//! Which one: products of three functions and quadtrees need the *nonstandard* basis, whose supports are squares; it is
//! also the cheaper transform. Separable work (one axis scaled or filtered apart from the other) wants *standard*.
//!
//! | you have | you want | use |
//! |---|---|---|
//! | samples | coefficients, and back | [`Transform1d`], [`Transform2d`] |
//! | too many coefficients | the few that matter | [`Selection`]; by the error that may be made: [`threshold_for_error`] |
//! | light and lobe in few terms, a shadow | ∫ of their product | [`TripleProduct`] |
//! | two signals | the coefficients of their product | [`Product1d`], [`Product2d`], [`multiply_sparse_2d`] |
//! | the same in the standard basis | | [`StandardTripleProduct`], [`StandardProduct`], [`multiply_sparse_standard`] |
//! | any number of sparse signals | their product, or its integral | [`NFoldProduct`] |
//! | three basis functions | their tripling coefficient | [`tripling_1d`], [`tripling_2d`] |
//! | an image | its mean over each square of the quadtree | [`Pyramid`] |
//! | a density | samples of it | [`SampleWarp1d`], [`SampleWarp2d`] |
//! | PyWavelets' coefficients | ours, and back | [`from_pywavelets_2d`], [`to_pywavelets_2d`] |
//!
//! NaN and infinity reach exactly the coefficients whose basis function covers the sample, and back.
//!
//! docs/haar.md has the theory and what was measured.

mod index;
mod layout;
mod n_fold;
mod product;
mod projected_light;
mod pyramid;
mod sample_warp;
mod select;
mod sparse;
mod standard_product;
mod threshold;
mod transform_1d;
mod transform_2d;
pub(crate) mod transform_kernels;
mod transform_nd;
pub(crate) mod triple;
mod tripling;
pub(crate) mod wavelet_tree;

pub use index::{Index1d, Index2d, WaveletKind};
pub use layout::{PyWaveletsLayout, from_pywavelets_1d, from_pywavelets_2d, to_pywavelets_1d, to_pywavelets_2d};
pub use n_fold::NFoldProduct;
pub use product::{Product1d, Product2d, multiply_sparse_1d, multiply_sparse_2d};
pub use projected_light::ProjectedLight;
pub use pyramid::Pyramid;
pub use sample_warp::{SampleWarp1d, SampleWarp2d};
pub use select::{ChannelRule, Keep, ScalingTerms, Selection, SelectionScratch, Weighting, select, transport_weights};
pub use sparse::SparseVector;
pub use standard_product::{StandardProduct, StandardTripleProduct, multiply_sparse_standard};
pub use threshold::threshold_for_error;
pub use transform_1d::{Transform1d, forward_1d, inverse_1d};
pub use transform_2d::{Decomposition, Transform2d, forward_2d, inverse_2d};
pub use transform_nd::TransformNd;
pub use triple::{BitPyramid, BitPyramidRef, Factor, MaskedSum, MeanTree, Route, TripleProduct, Visibility};
pub use tripling::{
    Tripling, tripling_1d, tripling_2d, tripling_count_1d, tripling_count_2d, tripling_nonzeros_1d,
    tripling_nonzeros_2d,
};
pub use wavelet_tree::{BinaryTree, Quadtree, WaveletTree};
