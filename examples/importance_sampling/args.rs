//! The command line.

use std::path::PathBuf;

use clap::{Parser, ValueEnum};
use haarmonic::haar::Keep;

use crate::support::args::{Common, Folder};

/// A glossy object near a textured lamp, with a few samples a pixel: product importance sampling beside its rivals.
///
/// Without arguments: the built-in knot in gold, 8 samples, pictures and a table in the folder out.
#[derive(Debug, Parser)]
#[command(version, name = "importance_sampling")]
pub struct Args {
    /// Mesh file (OBJ, PLY, glTF, GLB); without it the built-in knot on a floor
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,

    /// Vertices of the built-in scene
    #[arg(long, value_name = "N", default_value_t = 40_000)]
    pub vertices: usize,

    /// Reflectance of the object: phong:50, ggx:0.3, ward:0.2:0.5, merl:FILE, … or a sum such as phong:50+lambert:0.4
    #[arg(long, value_name = "SPEC", default_value = "ggx:0.1:0.1:1,0.78,0.34")]
    pub brdf: String,

    /// Samples a pixel (a power of two)
    #[arg(long, value_name = "N", default_value_t = 8)]
    pub spp: usize,

    /// Cells along an edge of the window and of the light (a power of two)
    #[arg(long, value_name = "N", default_value_t = 64)]
    pub order: usize,

    /// Coefficients of the light that are kept: a percentage, a count, or `all`
    #[arg(long, value_name = "TERMS", default_value = "all")]
    pub terms: Keep,

    /// Share of light sampling in the product's samples
    #[arg(long, value_name = "SHARE", default_value_t = 0.0625)]
    pub share: f64,

    /// Uniform numbers of a pixel: a stratified net, shifted by lot, or each by itself
    #[arg(long, value_enum, default_value = "stratified")]
    pub numbers: Numbers,

    /// Edge of each picture in pixels
    #[arg(long, value_name = "PX", default_value_t = 120)]
    pub size: usize,

    /// Samples of the reference along an edge of a texel of the lamp
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub truth: usize,

    #[command(flatten)]
    pub folder: Folder,

    #[command(flatten)]
    pub common: Common,
}

/// Where uniform numbers come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Numbers {
    Stratified,
    Independent,
}

impl Args {
    /// What the types of the options do not say.
    pub fn check(&self) -> Result<(), String> {
        if !self.spp.is_power_of_two() || self.spp > 4096 {
            return Err(format!("--spp must be a power of two of at most 4096, got {}", self.spp));
        }
        if !(16..=2048).contains(&self.size) {
            return Err(format!("--size must be in 16...2048 pixels, got {}", self.size));
        }
        if !(1..=16).contains(&self.truth) {
            return Err(format!("--truth must be in 1...16, got {}", self.truth));
        }
        Ok(())
    }
}
