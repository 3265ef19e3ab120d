//! Twins of [`sh`](crate::sh): one basis function at a time from angles, products by quadrature of the sphere.

mod basis;
mod exponential;
mod product;

pub use basis::{associated_legendre, basis, basis_function, basis_gradient};
pub use exponential::{
    cap_visibility, exp_limit, exp_projected, exp_scaled_series, exp_series, function_projected, log_by_eigenvalues,
    optimal_linear, product_eigen, union_visibility,
};
pub use product::{gamma, product, product_matrix, triple_integral};
