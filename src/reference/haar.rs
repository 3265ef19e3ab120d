//! Twins of [`haar`](crate::haar): every number is a sum over basis functions written out from their definition.

mod ng;
mod product;
mod sample_warp;
mod transform;

pub use ng::{NgTree, NgTripleProduct};
pub use product::{
    masked_sum, product_1d, product_2d, product_integral, triple_sum_1d, triple_sum_2d, tripling_1d, tripling_2d,
};
pub use sample_warp::{warp_1d, warp_nonstandard, warp_standard};
pub use transform::{
    basis_1d, basis_nonstandard, basis_standard, forward_1d, forward_nonstandard, forward_standard, inverse_1d,
    inverse_nonstandard, inverse_standard, means, select_indices,
};
