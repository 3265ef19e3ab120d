//! Small scenes of noise: triangles, lights, and what bakes them.

use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Mesh, VisibilityBaker, VisibilitySettings};
use haarmonic::sphere::{CubeGrid, CubeMap};

use super::noise;

#[track_caller]
pub fn grid(side: usize) -> CubeGrid {
    CubeGrid::new(side).unwrap()
}

/// Loose triangles: 3 `faces` vertices, normals all over the sphere.
pub fn soup(faces: usize) -> Mesh {
    let point = |i: usize| Vector3::from_fn(|k, _| (noise(3 * i + k) - 0.5) as f32 * 4.0);
    Mesh::new((0..3 * faces).map(point).collect(), (0..faces as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect())
        .unwrap()
}

#[track_caller]
pub fn baker(mesh: &Mesh, side: usize) -> VisibilityBaker {
    VisibilityBaker::new(mesh, grid(side), VisibilitySettings::default()).unwrap()
}

/// Noise of up to 5, each channel its own.
pub fn noisy(side: usize, seed: usize) -> CubeMap<Vector3<f32>> {
    let texel = |i: usize| Vector3::from_fn(|k, _| (noise(seed + 3 * i + k) * 5.0) as f32);
    CubeMap::new(grid(side), (0..grid(side).len()).map(texel).collect()).unwrap()
}
