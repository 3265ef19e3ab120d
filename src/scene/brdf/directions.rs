//! Directions as structure of arrays, for kernels.

use nalgebra::Vector3;

use crate::scene::LocalFrame;
use crate::sphere::{CubeGrid, Face, TopFace};

/// The directions of a cube grid's texels or a top face's cells as planes of x, y and z, with their solid angles, in
/// `f32`.
///
/// Build one per grid and share it between threads. The order is that of [`CubeGrid`] or [`TopFace`].
#[derive(Debug, Clone)]
pub struct DirectionTable {
    grid: Option<CubeGrid>,
    /// Directions of a row: these lie in a plane with the origin.
    row: usize,
    planes: [Vec<f32>; 3],
    solid_angles: Vec<f32>,
    pub(super) arch: pulp::Arch,
}

impl DirectionTable {
    /// The directions of `grid`: 12 bytes a texel, and 4 for the solid angles of one face.
    pub fn new(grid: CubeGrid) -> Self {
        let directions = (0..grid.len()).map(|i| grid.direction(i).into_inner());
        let solid_angles = grid.face_solid_angles().iter().map(|&s| s as f32).collect();
        Self::build(Some(grid), grid.side(), directions, solid_angles)
    }

    /// The directions of a top face that looks along the normal of `frame`, in world coordinates: 16 bytes a cell.
    pub fn top_face(face: &TopFace, frame: &LocalFrame) -> Self {
        let cells = face.cells();
        let directions = (0..face.len()).map(|i| frame.to_world(&face.cell_direction(i)).normalize());
        let solid_angles = (0..face.len()).map(|i| face.solid_angle(i % cells, i / cells) as f32).collect();
        Self::build(None, cells, directions, solid_angles)
    }

    fn build(
        grid: Option<CubeGrid>,
        row: usize,
        directions: impl Iterator<Item = Vector3<f64>>,
        solid_angles: Vec<f32>,
    ) -> Self {
        let mut planes = [(); 3].map(|()| Vec::with_capacity(directions.size_hint().0));
        for d in directions {
            for (plane, c) in planes.iter_mut().zip(d.iter()) {
                plane.push(*c as f32);
            }
        }
        Self { grid, row, planes, solid_angles, arch: pulp::Arch::new() }
    }

    /// The grid, of a cube map's directions.
    #[inline]
    pub fn grid(&self) -> Option<CubeGrid> {
        self.grid
    }

    /// How many directions there are.
    #[inline]
    #[expect(clippy::len_without_is_empty, reason = "neither a grid nor a face is ever empty")]
    pub fn len(&self) -> usize {
        self.planes[0].len()
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

    /// The solid angles in steradians: of one face's texels, where all faces are alike, or of all cells of a top face.
    #[inline]
    pub fn face_solid_angles(&self) -> &[f32] {
        &self.solid_angles
    }

    /// Directions of a row.
    #[inline(always)]
    pub(super) fn row(&self) -> usize {
        self.row
    }

    /// The numbers of the rows that may be above the horizon of `normal`, whole faces at a time.
    #[inline(always)]
    pub(super) fn rows_above(&self, normal: [f32; 3]) -> impl Iterator<Item = usize> + use<> {
        let (side, faces) = if self.grid.is_some() { (self.row, 6) } else { (self.len() / self.row, 1) };
        let is_below = |f: &usize| faces == 6 && face_is_below(Face::ALL[*f], normal);
        let above: [bool; 6] = std::array::from_fn(|f| f < faces && !is_below(&f));
        (0..6).filter(move |&f| above[f]).flat_map(move |f| f * side..(f + 1) * side)
    }
}

/// Whether no point of a face is above the horizon of `normal`, by at least the rounding error.
///
/// The largest n·(out + u right + v down) over the face is n·out + |n·right| + |n·down|.
#[inline]
fn face_is_below(face: Face, normal: [f32; 3]) -> bool {
    let [right, down, out] = face.axes();
    let dot = |a: [f64; 3]| (0..3).map(|k| a[k] * f64::from(normal[k])).sum::<f64>();
    dot(out) + dot(right).abs() + dot(down).abs() < -1e-6
}
