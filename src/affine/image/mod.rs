//! Compressed images that are zoomed, moved, mixed and filtered by their wavelet coefficients, without decompression
//! [Sun 2008, §4.6.2].
//!
//! Everything linear that works on one axis after the other is a pair of sparse operators ([`couplings`]), applied to
//! the terms that there are by one engine ([`two_pass`]): a zoom couples an axis with itself through an affine map, a
//! convolution with itself through a sum of translations. Where the terms are too many for that, the same operators are
//! applied to pixels ([`pixels`]).

mod convolve;
mod couplings;
mod edit;
mod kernel;
mod levels;
mod multiply;
mod pixels;
mod route;
mod two_pass;
mod wavelet_image;
mod window;
mod zoom;

pub use kernel::Kernel;
pub use levels::{ImageLevels, ZoomLevels};
pub use route::ImageRoute;
pub use wavelet_image::WaveletImage;
pub use window::ZoomWindow;
pub use zoom::{Zoom, ZoomScratch, ZoomTargets};
