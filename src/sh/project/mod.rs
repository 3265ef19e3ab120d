//! Functions, maps and samples onto harmonics, harmonics onto maps.

mod channels;
mod cube;
mod dering;
mod extrema;
mod frame;
mod function;
mod lat_long;
mod monte_carlo;
mod rows;
mod scattered;
mod texel_rule;
mod window;

pub use channels::Channels;
pub use cube::{CubeProjection, CubeReconstruction, project_cube};
pub use dering::{DeringBy, Deringing};
pub use extrema::{Extrema, Extremum};
pub use function::{project_fn, project_fn_channels};
pub use lat_long::{LatLongProjection, LatLongReconstruction, project_lat_long};
pub use monte_carlo::{MonteCarlo, monte_carlo};
pub use scattered::ScatteredFit;
pub use texel_rule::TexelRule;
pub use window::Window;
