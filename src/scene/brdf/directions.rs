//! Directions as structure of arrays, for kernels.

use crate::sphere::{CubeGrid, Face};

/// The texel directions of a cube grid as planes of x, y and z, with their solid angles, in `f32`.
///
/// Build one per grid and share it between threads. The order is that of [`CubeGrid`].
#[derive(Debug, Clone)]
pub struct DirectionTable {
    grid: CubeGrid,
    planes: [Vec<f32>; 3],
    solid_angles: Vec<f32>,
    pub(super) arch: pulp::Arch,
}

impl DirectionTable {
    /// The directions of `grid`: 12 bytes a texel, and 4 for the solid angles of one face.
    pub fn new(grid: CubeGrid) -> Self {
        let mut planes = [(); 3].map(|()| Vec::with_capacity(grid.len()));
        for i in 0..grid.len() {
            let d = grid.direction(i);
            for (plane, c) in planes.iter_mut().zip(d.iter()) {
                plane.push(*c as f32);
            }
        }
        let solid_angles = grid.face_solid_angles().iter().map(|&s| s as f32).collect();
        Self { grid, planes, solid_angles, arch: pulp::Arch::new() }
    }

    /// The grid.
    #[inline]
    pub fn grid(&self) -> CubeGrid {
        self.grid
    }

    /// How many directions there are.
    #[inline]
    #[expect(clippy::len_without_is_empty, reason = "a grid is never empty")]
    pub fn len(&self) -> usize {
        self.grid.len()
    }

    /// The x components.
    #[inline]
    pub fn x(&self) -> &[f32] {
        &self.planes[0]
    }

    /// The y components.
    #[inline]
    pub fn y(&self) -> &[f32] {
        &self.planes[1]
    }

    /// The z components.
    #[inline]
    pub fn z(&self) -> &[f32] {
        &self.planes[2]
    }

    /// x, y and z of `length` directions from `first` on.
    #[inline(always)]
    pub(super) fn slices(&self, first: usize, length: usize) -> [&[f32]; 3] {
        [
            &self.planes[0][first..first + length],
            &self.planes[1][first..first + length],
            &self.planes[2][first..first + length],
        ]
    }

    /// The solid angles of one face's texels in steradians; all faces are alike.
    #[inline]
    pub fn face_solid_angles(&self) -> &[f32] {
        &self.solid_angles
    }

    /// Whether no point of a face is above the horizon of `normal`, by at least the rounding error.
    ///
    /// The largest n·(out + u right + v down) over the face is n·out + |n·right| + |n·down|.
    #[inline]
    pub(super) fn face_is_below(face: Face, normal: [f32; 3]) -> bool {
        let [right, down, out] = face.axes();
        let dot = |a: [f64; 3]| (0..3).map(|k| a[k] * f64::from(normal[k])).sum::<f64>();
        dot(out) + dot(right).abs() + dot(down).abs() < -1e-6
    }
}
