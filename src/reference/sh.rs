//! Twins of [`sh`](crate::sh): one basis function at a time from angles, products by quadrature of the sphere.

mod basis;
mod product;
mod rotation;

pub use basis::{associated_legendre, basis, basis_function, basis_gradient, basis_hessian};
pub use product::{gamma, product, product_matrix, triple_integral};
pub use rotation::{rotate, rotation};
