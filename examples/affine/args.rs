//! The command line.

use clap::Parser;

use crate::support::args::{Common, Folder, parse};

/// Affine wavelets in pictures and tables: the canonical coupling, how many couplings are not zero, what tables of them
/// cost, how long a light takes to a place.
///
/// Without arguments: everything, pictures in out/affine.
#[derive(Debug, Parser)]
#[command(version, name = "affine")]
pub struct Args {
    /// Largest signal whose couplings are counted (a power of two)
    #[arg(long, value_name = "N", default_value_t = 2048)]
    pub largest: usize,

    /// Random maps (s, o) to count at
    #[arg(long, value_name = "K", default_value_t = 50)]
    pub maps: usize,

    /// Largest table of stored couplings to build, cells along s and along o; the sizes and times of larger ones are
    /// extrapolated
    #[arg(long, value_name = "R", default_value_t = 256)]
    pub cells: usize,

    #[command(flatten)]
    pub folder: Folder,

    #[command(flatten)]
    pub common: Common,
}

impl Args {
    /// The command line, with the defaults of this example.
    pub fn new() -> Self {
        parse(&[("out", "out/affine")])
    }

    /// What the types of the options do not say.
    pub fn check(&self) -> Result<(), String> {
        if !self.largest.is_power_of_two() || !(16..=16384).contains(&self.largest) {
            return Err(format!("--largest must be a power of two in 16...16384, got {}", self.largest));
        }
        if !(1..=1000).contains(&self.maps) {
            return Err(format!("--maps must be in 1...1000, got {}", self.maps));
        }
        if !(64..=1024).contains(&self.cells) {
            return Err(format!("--cells must be in 64...1024, got {}", self.cells));
        }
        Ok(())
    }
}
