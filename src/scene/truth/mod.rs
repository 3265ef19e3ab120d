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

use nalgebra::Vector3;

use crate::sphere::ConcentricSquare;
use crate::{Error, Result};

pub use convergence::Convergence;
pub use distant::{GroundTruth, TexelVisibility};
pub use fog::{Fog, Phase};
pub use interreflection::{Interreflection, Outgoing};
pub use local::LocalTruth;

/// The most samples along an edge of a lamp or of the hemisphere: more would not end.
const MOST_SAMPLES: usize = 4096;

fn check_samples(samples: usize) -> Result<()> {
    if (1..=MOST_SAMPLES).contains(&samples) {
        return Ok(());
    }
    let what = "samples along an edge of a lamp or of the hemisphere";
    Err(Error::OutOfRange { what, got: samples as f64, allowed: "in 1…4096" })
}

/// Local directions of `samples`² equal solid angles of the hemisphere.
fn hemisphere(samples: usize) -> Vec<Vector3<f64>> {
    (0..samples * samples).map(|i| ConcentricSquare::cell_direction(samples, i).into_inner()).collect()
}
