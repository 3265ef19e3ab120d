//! Twins of [`sh`](crate::sh): one basis function at a time from angles, products by quadrature of the sphere.

mod basis;
mod product;
mod project;

pub use basis::{associated_legendre, basis, basis_function, basis_gradient};
pub use product::{gamma, product, product_matrix, triple_integral};
pub use project::{
    cube_texel_integrals, lat_long_pixel_integrals, least_squares, project, project_cube, project_lat_long,
    reconstruct, sampled_minimum,
};
