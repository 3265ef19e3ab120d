//! The command line.

use clap::Parser;

use crate::support::args::{Common, Folder, parse};
use crate::support::environment::Light;

/// Spherical harmonics in pictures: the basis, and what it makes of an environment light.
///
/// Without arguments: the built-in studio, pictures in out/harmonics.
#[derive(Debug, Parser)]
#[command(version, name = "harmonics")]
pub struct Args {
    #[command(flatten)]
    pub light: Light,

    /// Texels along a side of the cube map that is projected
    #[arg(long, value_name = "N", default_value_t = 64)]
    pub resolution: usize,

    /// Sizes of the expansion, one row of pictures each
    #[arg(long, value_name = "N,N,...", default_value = "2,3,5,9,17", value_delimiter = ',')]
    pub bands: Vec<usize>,

    #[command(flatten)]
    pub folder: Folder,

    #[command(flatten)]
    pub common: Common,
}

impl Args {
    /// The command line, with the defaults of this example.
    pub fn new() -> Self {
        parse(&[("out", "out/harmonics"), ("env", "studio")])
    }

    /// What the types of the options do not say.
    pub fn check(&self) -> Result<(), String> {
        if !(8..=512).contains(&self.resolution) {
            return Err(format!("--resolution must be in 8...512, got {}", self.resolution));
        }
        if let Some(bad) = self.bands.iter().find(|n| !(1..=64).contains(*n)) {
            return Err(format!("--bands must each be in 1...64, got {bad}"));
        }
        if self.bands.len() > 8 {
            return Err(format!("--bands takes at most 8 sizes, got {}", self.bands.len()));
        }
        Ok(())
    }
}
