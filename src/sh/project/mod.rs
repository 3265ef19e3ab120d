//! Functions, maps and samples onto harmonics, harmonics onto maps.

mod channels;
mod cube;
mod frame;
mod function;
mod lat_long;
mod rows;
mod texel_rule;

pub use channels::Channels;
pub use cube::{CubeProjection, CubeReconstruction, project_cube};
pub use function::{project_fn, project_fn_channels};
pub use lat_long::{LatLongProjection, LatLongReconstruction, project_lat_long};
pub use texel_rule::TexelRule;
