//! Affine wavelets: what a Haar signal becomes when it is scaled and moved, without leaving the wavelet basis.

mod canonical;
mod exact_sum;
mod fourier;
mod map;
mod pixel;

pub use canonical::{Mother, canonical, canonical_batch, canonical_gradient, canonical_slope};
pub use fourier::{
    fourier_coupling, fourier_coupling_matrix, fourier_coupling_nonzeros, fourier_tripling, fourier_tripling_count,
};
pub use map::AffineMap;
pub use pixel::{
    pixel_coupling, pixel_coupling_bound, pixel_coupling_gradient, pixel_coupling_nonzeros, pixel_coupling_slope,
    pixel_tripling, pixel_tripling_nonzeros,
};
