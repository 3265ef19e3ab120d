//! The command line.

use std::path::PathBuf;

use clap::Parser;

use crate::support::args::{Common, Folder, parse};

/// The transfer matrix of bi-scale radiance transfer, biclustered: operations, bytes and time against the vertices.
///
/// Without arguments: the built-in torus knot at 1,000, 2,000 and 4,000 vertices, pictures in out/bicluster.
#[derive(Debug, Parser)]
#[command(version, name = "bicluster")]
pub struct Args {
    /// Mesh file (OBJ, PLY, glTF, GLB), refined by halving its longest edges; without it a built-in scene
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,

    /// Vertices of the largest mesh (a mesh file keeps its own if it has more)
    #[arg(long, value_name = "N", default_value_t = 4000)]
    pub vertices: usize,

    /// How many sizes, each half of the one before
    #[arg(long, value_name = "K", default_value_t = 3)]
    pub sizes: usize,

    /// Rows of a group of the search
    #[arg(long, value_name = "R", default_value_t = 4096)]
    pub group_rows: usize,

    /// Begin biclusters at random elements, chosen by this number, instead of the first ones
    #[arg(long, value_name = "S")]
    pub seed: Option<u64>,

    #[command(flatten)]
    pub folder: Folder,

    #[command(flatten)]
    pub common: Common,
}

impl Args {
    /// The command line, with the defaults of this example.
    pub fn new() -> Self {
        parse(&[("out", "out/bicluster")])
    }

    /// What the types of the options do not say.
    pub fn check(&self) -> Result<(), String> {
        if !(1..=8).contains(&self.sizes) {
            return Err(format!("--sizes must be in 1...8, got {}", self.sizes));
        }
        if self.group_rows == 0 {
            return Err("--group-rows must be at least 1".to_owned());
        }
        let smallest = self.vertices >> (self.sizes - 1);
        if self.mesh.is_none() && (smallest < 1000 || self.vertices > 200_000) {
            let sizes = self.sizes;
            return Err(format!(
                "--vertices must be in {}...200000 for {sizes} sizes of a built-in scene, got {}",
                1000 << (sizes - 1),
                self.vertices
            ));
        }
        Ok(())
    }
}
