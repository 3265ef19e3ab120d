//! The hemisphere above a surface, and the disk, flattened to a square without changing relative areas.

use nalgebra::{UnitVector3, Vector2};

use super::hemisphere_disk::HemisphereDisk;

/// The concentric map between the square [−1, 1]² and the unit disk, and by way of [`HemisphereDisk`] the hemisphere of
/// local directions (+z is the normal)                                                        [Shirley & Chiu 1997].
///
/// ```math
/// |x| ≥ |y|:  ρ = x, φ = (π/4) y/x;   else  ρ = y, φ = π/2 − (π/4) x/y
/// ```
///
/// Squares about the middle become circles, areas stay in proportion, and neighbours stay neighbours: grids of texels
/// and stratified samples go over as they are. The centre is the zenith, the square's edge the horizon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ConcentricSquare;

impl ConcentricSquare {
    /// dA/dω: area of the square per steradian; the square's 4 is the hemisphere's 2π.
    pub const AREA_PER_STERADIAN: f64 = 2.0 * std::f64::consts::FRAC_1_PI;

    /// The point of the disk that a point of the square becomes. Points outside the square lie outside the disk.
    #[inline]
    pub fn to_disk(square: &Vector2<f64>) -> Vector2<f64> {
        const QUARTER: f64 = std::f64::consts::FRAC_PI_4;
        let [x, y] = [square.x, square.y];
        if x.abs() >= y.abs() {
            // At the centre any angle will do.
            let (s, c) = (if x == 0.0 { 0.0 } else { QUARTER * (y / x) }).sin_cos();
            Vector2::new(x * c, x * s)
        } else {
            let (s, c) = (QUARTER * (x / y)).sin_cos();
            Vector2::new(y * s, y * c)
        }
    }

    /// The point of the square that becomes a point of the disk.
    #[inline]
    pub fn from_disk(disk: &Vector2<f64>) -> Vector2<f64> {
        const PER_QUARTER: f64 = 4.0 * std::f64::consts::FRAC_1_PI;
        let radius = disk.x.hypot(disk.y);
        if disk.x.abs() >= disk.y.abs() {
            let x = radius.copysign(disk.x);
            let angle = if disk.x == 0.0 { 0.0 } else { (disk.y / disk.x).atan() };
            Vector2::new(x, x * (PER_QUARTER * angle))
        } else {
            let y = radius.copysign(disk.y);
            Vector2::new(y * (PER_QUARTER * (disk.x / disk.y).atan()), y)
        }
    }

    /// The local direction of a point of the square.
    ///
    /// # Example
    /// ```
    /// use haarmonic::{nalgebra::{Vector2, Vector3}, sphere::ConcentricSquare};
    /// let corner = ConcentricSquare::direction(&Vector2::new(1.0, 1.0));
    /// assert!((corner.into_inner() - Vector3::new(0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.0)).norm() < 1e-15);
    /// assert!((ConcentricSquare::point(&corner) - Vector2::new(1.0, 1.0)).norm() < 1e-15);
    /// ```
    #[inline]
    pub fn direction(square: &Vector2<f64>) -> UnitVector3<f64> {
        HemisphereDisk::direction(&Self::to_disk(square))
    }

    /// The local direction of the centre of a cell of `cells`² equal ones, whose index is row · cells + column: equal
    /// solid angles of the hemisphere.
    ///
    /// # Panics
    /// If there is no such cell.
    #[track_caller]
    #[inline]
    pub fn cell_direction(cells: usize, index: usize) -> UnitVector3<f64> {
        assert!(cells > 0 && index / cells < cells, "cell {index} of {cells} × {cells}");
        let centre = |i: usize| (2 * i + 1) as f64 / cells as f64 - 1.0;
        Self::direction(&Vector2::new(centre(index % cells), centre(index / cells)))
    }

    /// The point of the square of a unit local direction; those below the horizon lie outside, up to √2.
    #[inline]
    pub fn point(direction: &UnitVector3<f64>) -> Vector2<f64> {
        Self::from_disk(&HemisphereDisk::point(direction))
    }
}
