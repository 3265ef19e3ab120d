//! Twins of [`affine`](crate::affine): exact integrals of piecewise constant functions, by merging their breakpoints.
//!
//! Nothing here knows of the canonical coupling: each basis function is a list of breakpoints and values, the affine
//! map moves the breakpoints, and an integral is a sum of length times value over the pieces between them. Breakpoints
//! carry 106 bits, so that what the twin rounds away does not show beside what a fast path in `f64` does. Whether a
//! coefficient is *exactly* zero is decided in integers (`…_sign_…`, `count_…`); `exact_…` round nothing but their
//! result, whatever the map.

mod exact;
mod exact_value;
mod fourier;
pub mod fourier_basis;
mod image;
mod integrals;
pub mod pixel_basis;
mod resample;
mod steps;

pub use exact::{
    count_nonzeros_1d, count_nonzeros_nonstandard, count_pixel_nonzeros, count_tripling_nonzeros_1d, coupling_sign_1d,
    coupling_sign_nonstandard, tripling_sign_1d,
};
pub use exact_value::{
    exact_coupling_1d, exact_coupling_gradient_1d, exact_coupling_nonstandard, exact_pixel_coupling,
    exact_pixel_gradient, exact_tripling_1d,
};
pub use fourier::{fourier_coupling, fourier_tripling};
pub use image::{convolve_2d, convolve_density, decode_standard};
pub use integrals::{
    canonical, coupling_1d, coupling_nonstandard, coupling_slope_1d, coupling_standard, double_product, pixel_coupling,
    pixel_tripling, triple_product, tripling_1d, tripling_nonstandard, tripling_standard,
};
pub use resample::{resample_1d, resample_2d, resample_between_1d, resample_between_2d, resample_light_field};
