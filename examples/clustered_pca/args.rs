//! The command line.

use std::path::PathBuf;

use clap::Parser;

use crate::support::args::{Common, Folder, parse};
use crate::support::environment::Light;

/// Transport maps as principal components, in one piece and clustered: error, storage and relit values.
///
/// Without arguments: the built-in torus knot with 1,000 vertices under the built-in sky, pictures in
/// out/clustered_pca.
#[derive(Debug, Parser)]
#[command(version, name = "clustered_pca")]
pub struct Args {
    /// Mesh file (OBJ, PLY, glTF, GLB), taken as it is; without it a built-in scene
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,

    /// Vertices of the built-in scene
    #[arg(long, value_name = "N", default_value_t = 1000)]
    pub vertices: usize,

    // What the maps are multiplied by.
    #[command(flatten)]
    pub light: Light,

    /// Seed of the first means and of the sketches of components
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,

    #[command(flatten)]
    pub folder: Folder,

    #[command(flatten)]
    pub common: Common,
}

impl Args {
    /// The command line, with the defaults of this example.
    pub fn new() -> Self {
        parse(&[("out", "out/clustered_pca")])
    }

    /// What the types of the options do not say.
    pub fn check(&self) -> Result<(), String> {
        if self.mesh.is_none() && !(1000..=100_000).contains(&self.vertices) {
            return Err(format!("--vertices must be in 1000...100000, got {}", self.vertices));
        }
        Ok(())
    }
}
