//! The command line.

use std::path::PathBuf;

use clap::Parser;

/// Spherical harmonics in pictures: the basis, and what it makes of an environment light.
///
/// Without arguments: the built-in studio, pictures in out/harmonics.
#[derive(Debug, Parser)]
#[command(version, name = "harmonics")]
pub struct Args {
    /// The light: sky, sunset, studio, or a lat-long file (HDR, EXR, PNG)
    #[arg(long, value_name = "NAME|FILE", default_value = "studio")]
    pub env: String,

    /// Texels along a side of the cube map that is projected
    #[arg(long, value_name = "N", default_value_t = 64)]
    pub resolution: usize,

    /// Sizes of the expansion, one row of pictures each
    #[arg(long, value_name = "N,N,...", default_value = "2,3,5,9,17", value_delimiter = ',')]
    pub bands: Vec<usize>,

    /// Folder of the pictures
    #[arg(long, value_name = "DIR", default_value = "out/harmonics")]
    pub out: PathBuf,

    /// Also write the figures as JSON
    #[arg(long, value_name = "R.json")]
    pub report: Option<PathBuf>,

    /// Threads (default: all cores)
    #[arg(long, value_name = "T")]
    pub threads: Option<usize>,
}

impl Args {
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
        if self.threads == Some(0) {
            return Err("--threads must be at least 1".to_owned());
        }
        Ok(())
    }
}
