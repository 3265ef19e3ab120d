//! The right answer, by brute force.
//!
//! | light | truth |
//! |---|---|
//! | distant, on the texels of a cube map | [`GroundTruth`] |
//! | lamps: rectangles, spheres, points, spots, light fields; in clear air or in fog | [`LocalTruth`] |
//! | what surfaces reflect to each other, of either | [`Interreflection`] |
//!
//! All are in f64. What is sampled says how finely, and [`Convergence`] doubles that until nothing moves.

mod convergence;
mod distant;
mod fog;
mod interreflection;
mod local;

pub use convergence::Convergence;
pub use distant::{GroundTruth, TexelVisibility};
pub use fog::{Fog, Phase};
pub use interreflection::{Interreflection, Outgoing};
pub use local::LocalTruth;
