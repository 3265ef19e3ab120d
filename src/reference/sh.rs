//! Twins of [`sh`](crate::sh): one basis function at a time from angles, products, zonal functions and lights by
//! quadrature.

mod basis;
mod exponential;
mod light;
mod product;
mod project;
mod rotation;
mod zonal;

pub use basis::{associated_legendre, basis, basis_function, basis_gradient, basis_hessian};
pub use exponential::{
    cap_visibility, exp_limit, exp_projected, exp_scaled_series, exp_series, function_projected, log_by_eigenvalues,
    optimal_linear, product_eigen, union_visibility,
};
pub use light::{diffuse_light, irradiance, polygon};
pub use product::{gamma, product, product_matrix, triple_integral};
pub use project::{
    cube_texel_integrals, lat_long_pixel_integrals, least_squares, project, project_cube, project_lat_long,
    reconstruct, sampled_minimum,
};
pub use rotation::{rotate, rotation};
pub use zonal::{cap_sum, legendre, project_cap, sphere_cap, zonal_factors};
