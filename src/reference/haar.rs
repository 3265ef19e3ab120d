//! Twins of [`haar`](crate::haar): every number is a sum over basis functions written out from their definition.

mod transform;

pub use transform::{
    basis_1d, basis_nonstandard, basis_standard, forward_1d, forward_nonstandard, forward_standard, inverse_1d,
    inverse_nonstandard, inverse_standard, means, select_indices,
};
