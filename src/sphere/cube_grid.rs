//! The geometry of a cube map: which direction a texel looks along and how much solid angle it holds.

use nalgebra::{Unit, UnitVector3, Vector3};

use crate::{Error, Result};

/// A face of the cube, named by the axis at its centre.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Face {
    /// +X, the first face.
    PosX,
    /// −X.
    NegX,
    /// +Y, the top.
    PosY,
    /// −Y, the bottom.
    NegY,
    /// +Z.
    PosZ,
    /// −Z.
    NegZ,
}

impl Face {
    /// The six faces in storage order.
    pub const ALL: [Self; 6] = [Self::PosX, Self::NegX, Self::PosY, Self::NegY, Self::PosZ, Self::NegZ];

    /// The face's axes (right, down, outward): the face point (u, v) ∈ [−1, 1]² looks along outward + u·right + v·down.
    ///
    /// The orientation is that of OpenGL and Vulkan cube maps [OpenGL 4.6 core, table 8.19].
    #[inline]
    pub const fn axes(self) -> [[f64; 3]; 3] {
        match self {
            Self::PosX => [[0., 0., -1.], [0., -1., 0.], [1., 0., 0.]],
            Self::NegX => [[0., 0., 1.], [0., -1., 0.], [-1., 0., 0.]],
            Self::PosY => [[1., 0., 0.], [0., 0., 1.], [0., 1., 0.]],
            Self::NegY => [[1., 0., 0.], [0., 0., -1.], [0., -1., 0.]],
            Self::PosZ => [[1., 0., 0.], [0., -1., 0.], [0., 0., 1.]],
            Self::NegZ => [[-1., 0., 0.], [0., -1., 0.], [0., 0., -1.]],
        }
    }

    /// The unnormalised direction of the face point (u, v); its largest component is 1 for |u|, |v| ≤ 1.
    #[inline]
    pub fn point(self, u: f64, v: f64) -> Vector3<f64> {
        let [right, down, out] = self.axes();
        Vector3::from_fn(|i, _| out[i] + u * right[i] + v * down[i])
    }

    /// The face that a direction hits and the point (u, v) ∈ [−1, 1]² where it does.
    ///
    /// `direction` need not be unit. Ties of the largest component go to x, then y. The zero vector gives (+Z, 0, 0). A
    /// component that is NaN gives u and v that are NaN on some face, and so do infinite ones, which have no direction.
    #[inline]
    pub fn locate(direction: &Vector3<f64>) -> (Self, f64, f64) {
        let d = direction;
        let (ax, ay, az) = (d.x.abs(), d.y.abs(), d.z.abs());
        if ax == 0.0 && ay == 0.0 && az == 0.0 {
            return (Self::PosZ, 0.0, 0.0);
        }
        let (face, major) = if ax >= ay && ax >= az {
            (if d.x > 0.0 { Self::PosX } else { Self::NegX }, ax)
        } else if ay >= az {
            (if d.y > 0.0 { Self::PosY } else { Self::NegY }, ay)
        } else {
            (if d.z > 0.0 { Self::PosZ } else { Self::NegZ }, az)
        };
        let [right, down, _] = face.axes();
        let dot = |axis: [f64; 3]| (axis[0] * d.x + axis[1] * d.y + axis[2] * d.z) / major;
        (face, dot(right), dot(down))
    }
}

/// The texel grid of a cube map of `side`² texels a face.
///
/// Texels are stored face after face in the order of [`Face::ALL`], each face row after row from its top left:
/// index = (face · side + y) · side + x.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(try_from = "usize", into = "usize"))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CubeGrid {
    side: usize,
}

impl TryFrom<usize> for CubeGrid {
    type Error = Error;

    /// As [`new`](CubeGrid::new), of the side.
    fn try_from(side: usize) -> Result<Self> {
        Self::new(side)
    }
}

impl From<CubeGrid> for usize {
    /// The side.
    fn from(grid: CubeGrid) -> Self {
        grid.side
    }
}

impl CubeGrid {
    /// The largest side that is allowed.
    pub const MAX_SIDE: usize = 1 << 14;

    /// A grid of `side`² texels a face.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 1 ≤ `side` ≤ [`MAX_SIDE`](Self::MAX_SIDE).
    pub fn new(side: usize) -> Result<Self> {
        if (1..=Self::MAX_SIDE).contains(&side) {
            Ok(Self { side })
        } else {
            Err(Error::OutOfRange { what: "cube map side", got: side as f64, allowed: "in 1…16384" })
        }
    }

    /// Texels along an edge of a face.
    #[inline]
    pub const fn side(self) -> usize {
        self.side
    }

    /// Texels of one face, side².
    #[inline]
    pub const fn face_len(self) -> usize {
        self.side * self.side
    }

    /// Texels of all six faces.
    #[inline]
    #[expect(clippy::len_without_is_empty, reason = "a grid is never empty")]
    pub const fn len(self) -> usize {
        6 * self.face_len()
    }

    /// Flat index of a texel.
    #[inline]
    pub const fn index(self, face: Face, x: usize, y: usize) -> usize {
        (face as usize * self.side + y) * self.side + x
    }

    /// The texel (face, x, y) of a flat index.
    ///
    /// # Panics
    /// If `index` ≥ [`len`](Self::len).
    #[track_caller]
    #[inline]
    pub fn texel(self, index: usize) -> (Face, usize, usize) {
        let within = index % self.face_len();
        (Face::ALL[index / self.face_len()], within % self.side, within / self.side)
    }

    /// The face coordinate in (−1, 1) of the centre of column (or row) `i`.
    #[inline]
    pub fn centre(self, i: usize) -> f64 {
        (2 * i + 1) as f64 / self.side as f64 - 1.0
    }

    /// The unit direction through the centre of a texel.
    ///
    /// # Panics
    /// If `index` ≥ [`len`](Self::len).
    #[track_caller]
    #[inline]
    pub fn direction(self, index: usize) -> UnitVector3<f64> {
        let (face, x, y) = self.texel(index);
        Unit::new_normalize(face.point(self.centre(x), self.centre(y)))
    }

    /// The unit directions of all texels in storage order.
    pub fn directions(self) -> Vec<UnitVector3<f64>> {
        (0..self.len()).map(|i| self.direction(i)).collect()
    }

    /// The flat index of the texel that a direction falls into (ties as in [`Face::locate`]); of some texel if a
    /// component is NaN or infinite.
    #[inline]
    pub fn nearest(self, direction: &Vector3<f64>) -> usize {
        let (face, u, v) = Face::locate(direction);
        let cell = |t: f64| (((t + 1.0) * 0.5 * self.side as f64) as usize).min(self.side - 1);
        self.index(face, cell(u), cell(v))
    }

    /// The face coordinate in [−1, 1] of the grid line before column (or row) `i`, `i` ≤ side.
    #[inline]
    pub fn line(self, i: usize) -> f64 {
        (2 * i) as f64 / self.side as f64 - 1.0
    }

    /// The four texels that share an edge with one: at its left, its right, above and below, across the edges of the
    /// face where it lies at one.
    ///
    /// Every texel is a neighbour of its neighbours. Beside an edge of the cube, left and right are those of the
    /// texel's own face: the neighbour may have them elsewhere.
    ///
    /// # Panics
    /// If `index` ≥ [`len`](Self::len).
    ///
    /// # Example
    /// ```
    /// use haarmonic::sphere::{CubeGrid, Face};
    /// let grid = CubeGrid::new(8)?;
    /// // Beyond the left edge of +X lies the right edge of +Z.
    /// let [left, right, _, _] = grid.neighbours(grid.index(Face::PosX, 0, 3));
    /// assert_eq!((left, right), (grid.index(Face::PosZ, 7, 3), grid.index(Face::PosX, 1, 3)));
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    #[track_caller]
    pub fn neighbours(self, index: usize) -> [usize; 4] {
        let (face, x, y) = self.texel(index);
        [(-1, 0), (1, 0), (0, -1), (0, 1)].map(|step| self.neighbour(face, x, y, step))
    }

    /// The texel that touches texel (x, y) of `face` on the side of (x + step.0, y + step.1), across the face's edge if
    /// need be. One of the two steps is 0, the other ±1.
    ///
    /// Beyond an edge: the centre of the step's target, continued in the plane of `face`, lies at 1 + 1/n. Seen from
    /// the adjacent face it has both coordinates scaled by n/(n + 1), which keeps it in its row: it moves by less than
    /// 1/(n + 1), half a texel is 1/n.
    pub(super) fn neighbour(self, face: Face, x: usize, y: usize, step: (isize, isize)) -> usize {
        let centre = |i: usize, step: isize| (2 * (i as isize + step) + 1) as f64 / self.side as f64 - 1.0;
        self.nearest(&face.point(centre(x, step.0), centre(y, step.1)))
    }

    /// The exact solid angle of the texel (x, y) of any face, in steradians.
    ///
    /// ```math
    /// Ω = g(x₁, y₁) − g(x₀, y₁) − g(x₁, y₀) + g(x₀, y₀),  g(x, y) = atan2(xy, √(x² + y² + 1))
    /// ```
    ///
    /// over the texel's corners on the face [−1, 1]² at distance 1. Accuracy: eps absolute, against golden values.
    ///
    /// # Example
    /// ```
    /// let face = haarmonic::sphere::CubeGrid::new(1)?.solid_angle(0, 0);
    /// assert!((face - 4.0 * std::f64::consts::PI / 6.0).abs() < 1e-15);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    ///
    /// # Panics
    /// If x or y is not below the side.
    #[inline]
    #[track_caller]
    pub fn solid_angle(self, x: usize, y: usize) -> f64 {
        assert!(x < self.side && y < self.side, "texel ({x}, {y}) of a face of side {}", self.side);
        rectangle_solid_angle([self.line(x), self.line(x + 1)], [self.line(y), self.line(y + 1)])
    }

    /// The exact solid angles of one face's texels in row order; all faces are alike, and six of them make 4π.
    pub fn face_solid_angles(self) -> Vec<f64> {
        (0..self.face_len()).map(|i| self.solid_angle(i % self.side, i / self.side)).collect()
    }
}

/// The solid angle of the rectangle u × v of the plane at distance 1.
#[inline]
pub(super) fn rectangle_solid_angle(u: [f64; 2], v: [f64; 2]) -> f64 {
    let corner = |x: f64, y: f64| (x * y).atan2((x * x + y * y + 1.0).sqrt());
    corner(u[1], v[1]) - corner(u[0], v[1]) - corner(u[1], v[0]) + corner(u[0], v[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn direction_and_texel_are_inverse() {
        for side in [1, 2, 3, 16, 17, 64] {
            let grid = CubeGrid::new(side).unwrap();
            for i in 0..grid.len() {
                assert_eq!(grid.nearest(&grid.direction(i)), i, "side {side}, texel {i}");
            }
        }
    }

    #[test]
    fn solid_angles_make_the_sphere() {
        for side in [1, 2, 3, 16, 64, 100] {
            let grid = CubeGrid::new(side).unwrap();
            let sum: f64 = grid.face_solid_angles().iter().sum::<f64>() * 6.0;
            assert!((sum / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-13, "side {side}: {sum}");
        }
    }

    #[test]
    fn faces_are_oriented_as_opengl_samples_them() {
        // Top-left corner texel of each face, from the (sc, tc, ma) table of the OpenGL specification.
        let corners = [[1., 1., 1.], [-1., 1., -1.], [-1., 1., -1.], [-1., -1., 1.], [-1., 1., 1.], [1., 1., -1.]];
        for (face, corner) in Face::ALL.into_iter().zip(corners) {
            assert_eq!(face.point(-1.0, -1.0), Vector3::from(corner), "{face:?}");
        }
    }

    #[test]
    fn sides_out_of_range_are_errors() {
        assert!(CubeGrid::new(0).is_err());
        assert!(CubeGrid::new(CubeGrid::MAX_SIDE + 1).is_err());
    }
}
