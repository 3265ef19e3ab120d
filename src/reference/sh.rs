//! Twins of [`sh`](crate::sh): every number is a sum over a quadrature of the sphere.

mod product;

pub use product::{gamma, product, product_matrix, triple_integral};
