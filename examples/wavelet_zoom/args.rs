//! The command line.

use std::path::PathBuf;

use clap::Parser;
use haarmonic::haar::Keep;

use crate::support::args::{Common, Folder, parse};

/// A compressed picture, zoomed, streamed and edited by its wavelet coefficients, and what the same costs by way of
/// pixels.
///
/// Without arguments: a picture of houses that the program draws, 1024 pixels across, pictures in out/wavelet_zoom.
#[derive(Debug, Parser)]
#[command(version, name = "wavelet_zoom")]
pub struct Args {
    /// Picture (PNG, EXR, HDR), of which the largest square in the middle is taken; without it a built-in one
    #[arg(long, value_name = "FILE")]
    pub image: Option<PathBuf>,

    /// Pixels across, of the picture and of the zoom (a power of two)
    #[arg(long, value_name = "N", default_value_t = 1024)]
    pub side: usize,

    /// How many times larger the window is shown
    #[arg(long, value_name = "F", default_value_t = 4.0)]
    pub zoom: f64,

    /// Centre of the window, in widths and heights of the picture (default: a façade, or the middle)
    #[arg(long, value_name = "X,Y", value_delimiter = ',')]
    pub at: Vec<f64>,

    /// Terms of the picture that are kept: a count, a percentage such as 1%, or `all`; without it several
    #[arg(long, value_name = "KEEP")]
    pub source: Option<Keep>,

    /// Terms of the zoom that are kept, likewise
    #[arg(long, value_name = "KEEP")]
    pub target: Option<Keep>,

    #[command(flatten)]
    pub folder: Folder,

    #[command(flatten)]
    pub common: Common,
}

impl Args {
    /// The command line, with the defaults of this example.
    pub fn new() -> Self {
        parse(&[("out", "out/wavelet_zoom")])
    }

    /// What the types of the options do not say.
    pub fn check(&self) -> Result<(), String> {
        if !self.side.is_power_of_two() || !(32..=4096).contains(&self.side) {
            return Err(format!("--side must be a power of two in 32...4096, got {}", self.side));
        }
        if !(0.01..=1000.0).contains(&self.zoom) {
            return Err(format!("--zoom must be in 0.01...1000, got {}", self.zoom));
        }
        if ![0, 2].contains(&self.at.len()) {
            return Err(format!("--at must be two numbers such as 0.3,0.6, got {}", self.at.len()));
        }
        match self.at.iter().find(|at| !(-10.0..=10.0).contains(*at)) {
            Some(at) => Err(format!("--at must be in -10...10, got {at}")),
            None => Ok(()),
        }
    }
}
