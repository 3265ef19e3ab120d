//! [`proptest`](https://docs.rs/proptest) strategies for the crate's inputs (feature `proptest`), for tests here and
//! elsewhere.

mod sphere;

pub use sphere::{cube_map, direction, lat_long_map, radiance, rotation};
