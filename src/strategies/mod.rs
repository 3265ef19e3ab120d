//! [`proptest`](https://docs.rs/proptest) strategies for the crate's inputs (feature `proptest`), for tests here and
//! elsewhere.
//!
//! They lean on the edges where code like this breaks: size 1, all zeros, one sample only, numbers near the ends of the
//! scalar's range, poles, face edges and degenerate rotations. None generates NaN or infinity.

mod affine;
mod haar;
#[cfg(feature = "scene")]
mod scene;
mod sh;
mod sh_visibility;
mod sphere;

pub use affine::{affine_map, dyadic_map};
pub use haar::{haar_image, haar_signal, power_of_two, signal, sparse_vector};
#[cfg(feature = "scene")]
pub use scene::{procedural, triangle_soup};
pub use sh::sh_vector;
pub use sh_visibility::{discs, sh_visibility};
pub use sphere::{cube_map, direction, lat_long_map, radiance, rotation};
