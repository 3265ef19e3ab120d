//! Twins of [`sh`](crate::sh): one basis function at a time, from angles.

mod basis;

pub use basis::{associated_legendre, basis, basis_function, basis_gradient};
