//! The plane above a surface, cut off at a size.

use nalgebra::{Unit, UnitVector3, Vector2, Vector3};

use super::cube_grid::rectangle_solid_angle;
use crate::{Error, Result};

/// The square of the plane at distance 1 above a surface: the top face of a cube, of any size, cut into cells.
///
/// ```math
/// v = (d_x, d_y)/d_z,  w = v/size + ½ ∈ [0, 1]²                                   [Sun 2008, §4.5.4]
/// dω = dv/(1 + |v|²)^{3/2},  cos θ dω = dv/(1 + |v|²)²
/// ```
///
/// +z is the normal; size 2 is the face of an ordinary cube map. A larger face covers more of the hemisphere, at the
/// same number of cells more coarsely:
///
/// | size | of the hemisphere | of the irradiance under a constant sky |
/// |---|---|---|
/// | 2 | .333 | .554 |
/// | 3 | .487 | .735 |
/// | 4 | .590 | .831 |
/// | 10 | .823 | .968 |
///
/// Cell (x, y) has index y · cells + x; x runs along d_x and y along d_y, both upwards.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Vector3, sphere::TopFace};
/// let face = TopFace::new(10.0, 32)?;
/// assert!((face.covered_solid_angle() / std::f64::consts::TAU - 0.8229).abs() < 1e-4);
/// assert_eq!(face.nearest(&Vector3::new(0.1, 0.1, 1.0)), Some(16 * 32 + 16));
/// assert_eq!(face.nearest(&Vector3::new(6.0, 0.0, 1.0)), None);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TopFace {
    size: f64,
    cells: usize,
}

impl TopFace {
    /// The most cells along an edge.
    pub const MAX_CELLS: usize = 1 << 14;

    /// A face whose edge is `size` long, cut into `cells`² cells.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the size is in [1e-6, 1e6] and `cells` in 1…[`MAX_CELLS`](Self::MAX_CELLS).
    pub fn new(size: f64, cells: usize) -> Result<Self> {
        if !(1e-6..=1e6).contains(&size) {
            return Err(Error::OutOfRange { what: "size of a top face", got: size, allowed: "in [1e-6, 1e6]" });
        }
        if !(1..=Self::MAX_CELLS).contains(&cells) {
            let got = cells as f64;
            return Err(Error::OutOfRange { what: "cells along a top face", got, allowed: "in 1…16384" });
        }
        Ok(Self { size, cells })
    }

    /// The length of an edge.
    #[inline]
    pub const fn size(&self) -> f64 {
        self.size
    }

    /// Cells along an edge.
    #[inline]
    pub const fn cells(&self) -> usize {
        self.cells
    }

    /// All cells.
    #[expect(clippy::len_without_is_empty, reason = "a face has cells")]
    #[inline]
    pub const fn len(&self) -> usize {
        self.cells * self.cells
    }

    /// The point v of the plane that a local direction meets; `None` unless it points upwards.
    #[inline]
    pub fn point(direction: &Vector3<f64>) -> Option<Vector2<f64>> {
        (direction.z > 0.0).then(|| direction.xy() / direction.z)
    }

    /// The coordinate w ∈ [0, 1]² of a local direction; `None` if it misses the face.
    #[inline]
    pub fn coordinate(&self, direction: &Vector3<f64>) -> Option<Vector2<f64>> {
        let w = Self::point(direction)? / self.size + Vector2::repeat(0.5);
        w.iter().all(|w| (0.0..=1.0).contains(w)).then_some(w)
    }

    /// The unit local direction of a coordinate w; those outside [0, 1]² lie in the same plane.
    #[inline]
    pub fn direction(&self, w: &Vector2<f64>) -> UnitVector3<f64> {
        let v = (w - Vector2::repeat(0.5)) * self.size;
        Unit::new_normalize(v.push(1.0))
    }

    /// The unit direction of a cell's centre.
    ///
    /// # Panics
    /// If there is no such cell.
    #[track_caller]
    #[inline]
    pub fn cell_direction(&self, index: usize) -> UnitVector3<f64> {
        assert!(index < self.len(), "cell {index} of {}", self.len());
        let centre = |i: usize| (i as f64 + 0.5) / self.cells as f64;
        self.direction(&Vector2::new(centre(index % self.cells), centre(index / self.cells)))
    }

    /// The cell that a local direction meets; `None` if it misses the face.
    #[inline]
    pub fn nearest(&self, direction: &Vector3<f64>) -> Option<usize> {
        let w = self.coordinate(direction)?;
        let cell = |w: f64| ((w * self.cells as f64) as usize).min(self.cells - 1);
        Some(cell(w.y) * self.cells + cell(w.x))
    }

    /// The solid angle of cell (x, y), ∫ dω.
    ///
    /// Accuracy: eps absolute, by differences of arc tangents over its corners.
    ///
    /// # Panics
    /// If x or y is not below the number of cells.
    #[track_caller]
    pub fn solid_angle(&self, x: usize, y: usize) -> f64 {
        rectangle_solid_angle(self.span(x), self.span(y))
    }

    /// The cosine-weighted solid angle of cell (x, y), ∫ cos θ dω: what it contributes to the irradiance of a surface
    /// under radiance 1.
    ///
    /// ```math
    /// ∫∫ du dv/(1 + u² + v²)² = g(u, v) + g(v, u) over the corners,  g(u, v) = ½ u/√(1 + u²) atan(v/√(1 + u²))
    /// ```
    ///
    /// Accuracy: eps absolute.
    ///
    /// # Panics
    /// If x or y is not below the number of cells.
    #[track_caller]
    pub fn projected_solid_angle(&self, x: usize, y: usize) -> f64 {
        rectangle_projected_solid_angle(self.span(x), self.span(y))
    }

    /// The solid angle of the whole face, 4 atan(h²/√(1 + 2h²)) with h half of its size; the hemisphere has 2π.
    pub fn covered_solid_angle(&self) -> f64 {
        let h2 = 0.25 * self.size * self.size;
        4.0 * (h2 / (1.0 + 2.0 * h2).sqrt()).atan()
    }

    /// The cosine-weighted solid angle of the whole face, 4 h/√(1 + h²) atan(h/√(1 + h²)); the hemisphere has π.
    pub fn covered_projected_solid_angle(&self) -> f64 {
        let h = 0.5 * self.size;
        let slope = h / h.hypot(1.0);
        4.0 * slope * slope.atan()
    }

    /// Where the cells of row or column `i` begin and end in the plane.
    #[track_caller]
    fn span(&self, i: usize) -> [f64; 2] {
        assert!(i < self.cells, "cell {i} of {} along a top face", self.cells);
        let line = |i: usize| self.size * (i as f64 / self.cells as f64 - 0.5);
        [line(i), line(i + 1)]
    }
}

/// ∫ cos θ dω over the rectangle u × v of the plane at distance 1.
fn rectangle_projected_solid_angle(u: [f64; 2], v: [f64; 2]) -> f64 {
    let half = |x: f64, y: f64| {
        let length = x.hypot(1.0);
        0.5 * (x / length) * (y / length).atan()
    };
    let corner = |x: f64, y: f64| half(x, y) + half(y, x);
    corner(u[1], v[1]) - corner(u[0], v[1]) - corner(u[1], v[0]) + corner(u[0], v[0])
}
