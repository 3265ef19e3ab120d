//! The command line.

use clap::Parser;

use crate::support::args::{Common, Folder, parse};

/// Exponentials of spherical harmonic expansions: error and time of every method, on unions of discs.
///
/// Without arguments: bands 2 to 6, pictures in out/sh_exp.
#[derive(Debug, Parser)]
#[command(version, name = "sh_exp")]
pub struct Args {
    /// Number of unions
    #[arg(long, value_name = "K", default_value_t = 512)]
    pub vectors: usize,

    /// Largest half angle of a disc, in radians; the smallest is 0.2
    #[arg(long, value_name = "RAD", default_value_t = 0.75)]
    pub largest: f64,

    #[command(flatten)]
    pub folder: Folder,

    #[command(flatten)]
    pub common: Common,
}

impl Args {
    /// The command line, with the defaults of this example.
    pub fn new() -> Self {
        parse(&[("out", "out/sh_exp")])
    }

    /// What the types of the options do not say.
    pub fn check(&self) -> Result<(), String> {
        if !(8..=100_000).contains(&self.vectors) {
            return Err(format!("--vectors must be in 8...100000, got {}", self.vectors));
        }
        if !(self.largest > 0.2 && self.largest <= 1.5) {
            return Err(format!("--largest must be above 0.2 and at most 1.5, got {}", self.largest));
        }
        Ok(())
    }
}
