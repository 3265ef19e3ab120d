//! [`proptest`](https://docs.rs/proptest) strategies for the crate's inputs (feature `proptest`), for tests here and
//! elsewhere.
//!
//! They lean on the edges where code like this breaks: size 1, all zeros, one sample only, numbers near the ends of the
//! scalar's range, poles, face edges and degenerate rotations. None generates NaN or infinity.

mod affine;
#[cfg(feature = "block_product")]
mod backend;
mod compress;
mod haar;
#[cfg(feature = "scene")]
mod scene;
mod sh;
mod sphere;
mod table;

pub use affine::{affine_map, dyadic_map, wavelet_image};
#[cfg(feature = "block_product")]
pub use backend::block_layout;
pub use compress::{block_matrix, clustered_rows, level_map, low_rank_rows, run_map};
pub use haar::{haar_image, haar_signal, power_of_two, signal, sparse_vector};
#[cfg(feature = "scene")]
pub use scene::{brdf, directions, local_frame, procedural, textured_soup, triangle_soup, viewpoint};
pub use sh::{discs, sh_vector, sh_visibility, spherical_polygon, zonal};
pub use sphere::{cube_map, direction, lat_long_map, radiance, rotation};
pub use table::{outside, rectangle, visibility_map};
