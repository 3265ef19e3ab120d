//! Directions and the domains that hold functions of direction.

mod cube_grid;
mod cube_map;
mod texel;

pub use cube_grid::{CubeGrid, Face};
pub use cube_map::CubeMap;
pub use texel::Texel;
