//! Directions and the domains that hold functions of direction.
//!
//! | domain | for |
//! |---|---|
//! | [`CubeMap`] | light and transport: nearly square texels, six plain images for 2D wavelets |
//! | [`LatLongMap`] | environment photographs, as files hold them |
//! | [`DiskMap`] | light probes, mirror balls and paraboloids, as files and GPUs hold them |
//! | [`HemisphereDisk`], [`ConcentricSquare`] | local hemispheres in the plane, areas in proportion |
//! | [`TopFace`] | the plane above a surface, where the light of a lamp parallel to it only moves and scales |
//! | [`SphereQuadrature`] | integrals of smooth functions, exact to a stated degree |
//!
//! [`Axes`] and [`LatLongConvention`] say how the worlds and the images of other programs lie in this one.
//!
//! Maps are resampled into each other by [`Resampling`], energy kept: ∫ L dω is the same before and after.

mod axes;
mod concentric_square;
mod cube_grid;
mod cube_map;
mod disk_map;
mod hemisphere_disk;
mod lat_long;
mod overlap_cube;
mod overlap_lat_long;
pub(crate) mod quadrature;
mod resample;
mod texel;
mod top_face;

pub use axes::{Axes, SignedAxis};
pub use concentric_square::ConcentricSquare;
pub use cube_grid::{CubeGrid, Face};
pub use cube_map::CubeMap;
pub use disk_map::{DiskMap, DiskProjection};
pub use hemisphere_disk::HemisphereDisk;
pub use lat_long::{LatLongConvention, LatLongGrid, LatLongMap};
pub use quadrature::{SphereQuadrature, fibonacci_directions};
pub use resample::Resampling;
pub use texel::Texel;
pub use top_face::TopFace;
