//! The transfer matrix of bi-scale radiance transfer [§IV-A]: which light from the whole sphere arrives along which
//! local direction.

use haarmonic::compress::SparseMatrix;
use haarmonic::nalgebra::{UnitVector3, Vector3};
use haarmonic::scene::{Mesh, VisibilityBaker, VisibilitySettings};
use haarmonic::sphere::{ConcentricSquare, CubeGrid};
use haarmonic::{Progress, Result};

/// Side of the faces of the global light: 6 × 32 × 32 directions.
pub const SIDE: usize = 32;
/// Local directions along one side of the hemisphere's square: 8 × 8 of them.
pub const LOCAL: usize = 8;
/// Samples along a texel's edge: 2 × 2, so the levels of visibility are 0…4.
pub const SAMPLES: usize = 2;

/// The local directions: centres of a grid on the concentric square (equal areas of the hemisphere).
pub fn local_directions() -> Vec<UnitVector3<f64>> {
    (0..LOCAL * LOCAL).map(|i| ConcentricSquare::cell_direction(LOCAL, i)).collect()
}

/// T: a row for each vertex and local direction, a column for each texel of the global light; entry = visibility of the
/// texel where the local direction is the nearest one to it. Each texel falls to one local direction of a vertex.
pub fn transfer_matrix(mesh: &Mesh, progress: &impl Progress) -> Result<SparseMatrix> {
    let grid = CubeGrid::new(SIDE)?;
    let visibility =
        VisibilityBaker::new(mesh, grid, VisibilitySettings::default())?.bake_fractional(SAMPLES, progress)?;
    let local = local_directions();
    let texels: Vec<Vector3<f64>> = grid.directions().iter().map(|d| d.into_inner()).collect();
    let (mut offsets, mut columns, mut levels) = (vec![0], Vec::new(), Vec::new());
    let mut rows: Vec<Vec<(u32, i32)>> = vec![Vec::new(); local.len()];
    for vertex in 0..mesh.positions().len() {
        rows.iter_mut().for_each(Vec::clear);
        let frame = mesh.local_frame(vertex);
        for (texel, &level) in visibility.vertex(vertex).iter().enumerate().filter(|(_, level)| **level > 0) {
            rows[nearest(&local, &frame.to_local(&texels[texel]))].push((texel as u32, i32::from(level)));
        }
        for row in &rows {
            columns.extend(row.iter().map(|e| e.0));
            levels.extend(row.iter().map(|e| e.1));
            offsets.push(columns.len());
        }
    }
    SparseMatrix::from_rows(grid.len(), 1.0 / (SAMPLES * SAMPLES) as f64, offsets, columns, levels)
}

fn nearest(local: &[UnitVector3<f64>], direction: &Vector3<f64>) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (j, d) in local.iter().enumerate() {
        let cosine = d.dot(direction);
        if cosine > best.1 {
            best = (j, cosine);
        }
    }
    best.0
}
