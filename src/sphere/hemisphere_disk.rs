//! The hemisphere above a surface, flattened to a disk without changing relative areas.

use nalgebra::{Unit, UnitVector3, Vector2, Vector3};

use crate::numeric::safe_sqrt;

/// The equal-area map between local directions (+z is the normal) and a disk.
///
/// ```math
/// p = (d_x, d_y)/√(1 + d_z),  |p|² = 1 − d_z,  dA = ½ dω          [Xu 2006 §5, the factor ½ made explicit]
/// d = (x √(2 − ρ²), y √(2 − ρ²), 1 − ρ²),  ρ² = x² + y²
/// ```
///
/// The upper hemisphere is the unit disk; directions below the horizon follow on 1 < ρ < √2, and the nadir is the whole
/// circle ρ = √2. Shapes are stretched along the circles ρ = const by 1/cos²(θ/2): 1 at the zenith, 2 at the horizon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HemisphereDisk;

impl HemisphereDisk {
    /// dA/dω: disk area per steradian; the disk's π is the hemisphere's 2π.
    pub const AREA_PER_STERADIAN: f64 = 0.5;

    /// The radius ρ = √2 of the nadir.
    pub const NADIR_RADIUS: f64 = std::f64::consts::SQRT_2;

    /// The disk point of a unit local direction.
    ///
    /// The nadir (0, 0, −1) gives (√2, 0), one of its points. Accuracy: 4 eps, also beside the nadir.
    ///
    /// # Example
    /// ```
    /// use haarmonic::{nalgebra::Vector3, sphere::HemisphereDisk};
    /// let horizon = HemisphereDisk::point(&Vector3::x_axis());
    /// assert_eq!((horizon.x, horizon.y), (1.0, 0.0));
    /// ```
    #[inline]
    pub fn point(direction: &UnitVector3<f64>) -> Vector2<f64> {
        let d = direction;
        if d.z >= 0.0 {
            return Vector2::new(d.x, d.y) / (1.0 + d.z).sqrt();
        }
        // Below the horizon 1 + z cancels; √(1 − z)/|(x, y)| is the same factor, because |(x, y)|² = (1 − z)(1 + z).
        let across = d.x.hypot(d.y);
        if across == 0.0 {
            return Vector2::new(Self::NADIR_RADIUS, 0.0);
        }
        Vector2::new(d.x, d.y) * ((1.0 - d.z).sqrt() / across)
    }

    /// The local direction of a disk point; points beyond ρ = √2 give the nadir, NaN gives NaN.
    #[inline]
    pub fn direction(point: &Vector2<f64>) -> UnitVector3<f64> {
        let squared = point.norm_squared();
        if squared >= 2.0 {
            return Unit::new_unchecked(-Vector3::z());
        }
        let scale = safe_sqrt(2.0 - squared);
        Unit::new_unchecked(Vector3::new(point.x * scale, point.y * scale, 1.0 - squared))
    }
}
