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

/// A room: the inside of the cube [−1, 1]³ in n² cells a wall, hard edges, normals inwards.
pub fn room(n: usize) -> Mesh {
    let (mut positions, mut normals, mut faces) = (vec![], vec![], vec![]);
    for axis in 0..3 {
        for side in [-1.0_f32, 1.0] {
            let base = positions.len() as u32;
            for i in 0..=n {
                for j in 0..=n {
                    let mut p = Vector3::repeat(side);
                    p[(axis + 1) % 3] = 2.0 * i as f32 / n as f32 - 1.0;
                    p[(axis + 2) % 3] = 2.0 * j as f32 / n as f32 - 1.0;
                    positions.push(p);
                    normals.push(Vector3::ith(axis, -side));
                }
            }
            for i in 0..n as u32 {
                for j in 0..n as u32 {
                    let w = n as u32 + 1;
                    let [a, b, c, d] =
                        [i * w + j, (i + 1) * w + j, (i + 1) * w + j + 1, i * w + j + 1].map(|k| base + k);
                    faces.extend(if side < 0.0 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
                }
            }
        }
    }
    Mesh::with_normals(positions, normals, faces).unwrap()
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
