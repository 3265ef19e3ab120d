//! The command line.

use std::path::PathBuf;

use clap::Parser;

/// Transport maps as principal components, in one piece and clustered: error, storage and relit values.
///
/// Without arguments: the built-in torus knot with 4,000 vertices, pictures in out/clustered_pca.
#[derive(Debug, Parser)]
#[command(version, name = "clustered_pca")]
pub struct Args {
    /// Mesh file (OBJ, PLY, glTF, GLB), taken as it is; without it a built-in scene
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,

    /// Vertices of the built-in scene
    #[arg(long, value_name = "N", default_value_t = 4000)]
    pub vertices: usize,

    /// Light that the maps are multiplied by: sky, sunset, studio or a file (HDR, EXR)
    #[arg(long, value_name = "LIGHT", default_value = "sky")]
    pub env: String,

    /// Seed of the first means and of the sketches of components
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,

    /// Folder of the pictures
    #[arg(long, value_name = "DIR", default_value = "out/clustered_pca")]
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
        if self.threads == Some(0) {
            return Err("--threads must be at least 1".to_owned());
        }
        if self.mesh.is_none() && !(1000..=100_000).contains(&self.vertices) {
            return Err(format!("--vertices must be in 1000...100000, got {}", self.vertices));
        }
        Ok(())
    }
}
