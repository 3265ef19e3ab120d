//! What is compressed: a map of visibility times cosine for each vertex, and what a light makes of it.

use haarmonic::io;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Mesh, Procedural, VisibilityBaker, VisibilitySettings};
use haarmonic::sphere::CubeGrid;
use rayon::prelude::*;

use crate::args::Args;
use crate::support::Failure;
use crate::support::environment::{file_name, warn};
use crate::support::progress::Bar;

/// Side of the faces of the maps: 6 × 16 × 16 texels.
const SIDE: usize = 16;
/// Rays along a texel's edge: 4 × 4 a texel.
const SAMPLES: usize = 4;

/// The maps of a mesh and a light.
pub struct Maps {
    /// Of the scene.
    pub name: String,
    pub light_name: String,
    pub grid: CubeGrid,
    /// A row for each vertex, a column for each texel: share that is visible · max(0, cosine at the centre).
    pub matrix: Vec<f32>,
    /// Radiance · solid angle of each texel.
    light: Vec<Vector3<f64>>,
}

impl Maps {
    pub fn new(args: &Args) -> Result<Self, Failure> {
        let (name, mesh) = match &args.mesh {
            Some(path) => {
                let loaded = io::load_mesh(path)?;
                loaded.warnings.iter().for_each(warn);
                (file_name(path), loaded.value)
            }
            None => {
                let scene = Procedural::TorusKnotOnFloor;
                (scene.name().to_owned(), scene.build(args.vertices)?.mesh)
            }
        };
        let grid = CubeGrid::new(SIDE)?;
        let bar = Bar::new("visibility");
        let matrix = bake(&mesh, grid, &bar)?;
        bar.finish();
        let (light_name, light) = args.light.load()?;
        let angles = grid.face_solid_angles();
        let light = light.to_cube(grid);
        let light = light.texels().iter().enumerate().map(|(i, l)| l.cast::<f64>() * angles[i % grid.face_len()]);
        Ok(Self { name, light_name, grid, matrix, light: light.collect() })
    }

    pub fn columns(&self) -> usize {
        self.grid.len()
    }

    pub fn vertices(&self) -> usize {
        self.matrix.len() / self.columns()
    }

    pub fn map(&self, vertex: usize) -> &[f32] {
        &self.matrix[vertex * self.columns()..][..self.columns()]
    }

    /// The irradiance of each row of a matrix: Σ map · light.
    pub fn relit(&self, matrix: &[f32]) -> Vec<Vector3<f64>> {
        let sum = |row: &[f32]| row.iter().zip(&self.light).map(|(&x, l)| l * f64::from(x)).sum();
        matrix.par_chunks_exact(self.columns()).map(sum).collect()
    }

    /// The light as right-hand sides, `[texel·3 + channel]`.
    pub fn sides(&self) -> Vec<f32> {
        self.light.iter().flat_map(|l| [l.x, l.y, l.z]).map(|x| x as f32).collect()
    }
}

fn bake(mesh: &Mesh, grid: CubeGrid, bar: &Bar) -> Result<Vec<f32>, Failure> {
    let visibility = VisibilityBaker::new(mesh, grid, VisibilitySettings::default())?.bake_fractional(SAMPLES, bar)?;
    let directions: Vec<Vector3<f32>> = grid.directions().iter().map(|d| d.into_inner().cast()).collect();
    let mut matrix = vec![0.0; mesh.positions().len() * grid.len()];
    for (vertex, row) in matrix.chunks_exact_mut(grid.len()).enumerate() {
        let normal = &mesh.normals()[vertex];
        for ((x, seen), d) in row.iter_mut().zip(visibility.values(vertex)).zip(&directions) {
            *x = seen * normal.dot(d).max(0.0);
        }
    }
    Ok(matrix)
}
