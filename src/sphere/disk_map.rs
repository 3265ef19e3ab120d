//! Pictures of all directions on a disk: angular maps, sphere maps, paraboloids.

use nalgebra::{Unit, UnitVector3, Vector2, Vector3};
use num_traits::Float;

use super::{CubeGrid, CubeMap, Texel};
use crate::{Error, Real, Result};

/// How directions lie on the unit disk, x to the right and y up.
///
/// | | centre | rim | radius | seen |
/// |---|---|---|---|---|
/// | angular map (light probe) | −z | +z | θ/π | from inside, +x at the right |
/// | sphere map (mirror ball) | +z | −z | sin(θ/2) | the ball from outside, +x at the right |
/// | paraboloid | −z | the horizon z = 0 | tan(θ/2) | from inside, +x at the right |
///
/// θ is the angle to the centre's direction. The back half of a dual paraboloid is the paraboloid around +z, mirrored
/// so that what is beside the rim in one is at the same place of the rim in the other.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DiskProjection {
    /// Equal steps of the angle: what light probes are published in [Debevec 1998].
    AngularMap,
    /// What an orthographic camera sees in a mirrored ball: OpenGL's sphere map.
    SphereMap,
    /// What an orthographic camera sees in a paraboloid [Heidrich & Seidel 1998]; front and back half.
    DualParaboloid,
}

impl DiskProjection {
    /// The disks of a picture, side by side.
    pub const fn disks(self) -> usize {
        match self {
            Self::AngularMap | Self::SphereMap => 1,
            Self::DualParaboloid => 2,
        }
    }

    /// The disk of a direction and the point of it. `direction` need not be unit.
    ///
    /// The direction of the rim gives (1, 0), one of its points.
    ///
    /// # Example
    /// ```
    /// use haarmonic::{nalgebra::Vector3, sphere::DiskProjection};
    /// let (disk, point) = DiskProjection::DualParaboloid.point(&Vector3::x());
    /// assert_eq!((disk, point.x, point.y), (0, 1.0, 0.0));
    /// ```
    pub fn point(self, direction: &Vector3<f64>) -> (usize, Vector2<f64>) {
        let d = direction;
        let across = d.x.hypot(d.y);
        let outwards = if across == 0.0 { Vector2::new(1.0, 0.0) } else { d.xy() / across };
        match self {
            Self::AngularMap => (0, outwards * (across.atan2(-d.z) * std::f64::consts::FRAC_1_PI)),
            // The normal is half-way between the direction and that of the camera.
            Self::SphereMap => (0, outwards * (0.5 * across.atan2(d.z)).sin()),
            Self::DualParaboloid => {
                let is_back = d.z > 0.0;
                (usize::from(is_back), outwards * (across / (d.norm() + d.z.abs())))
            }
        }
    }

    /// The direction of a point of a disk; `None` beyond the rim, and for a disk that is not there.
    pub fn direction(self, disk: usize, point: &Vector2<f64>) -> Option<UnitVector3<f64>> {
        let radius = point.norm();
        if disk >= self.disks() || !(radius <= 1.0) {
            return None;
        }
        let outwards = if radius == 0.0 { Vector2::zeros() } else { point / radius };
        // Along z, from the centre's direction.
        let (angle, z) = match self {
            Self::AngularMap => (radius * std::f64::consts::PI, -1.0),
            Self::SphereMap => (2.0 * radius.asin(), 1.0),
            Self::DualParaboloid => (2.0 * radius.atan(), if disk == 0 { -1.0 } else { 1.0 }),
        };
        let (s, c) = angle.sin_cos();
        Some(Unit::new_normalize((outwards * s).push(z * c)))
    }
}

/// A map of directions on disks, as a picture: `side` × `side` pixels a disk, disks side by side.
///
/// Pixels are stored row after row from the top left. Those whose centre is beyond the rim show nothing, and are not
/// looked at.
///
/// # Example
/// ```
/// use haarmonic::sphere::{CubeGrid, CubeMap, DiskMap, DiskProjection};
/// let sky = CubeMap::from_fn(CubeGrid::new(64)?, |d| 1.0 + d.y);
/// let probe = DiskMap::from_cube(DiskProjection::AngularMap, 128, &sky)?;
/// let back = probe.to_cube(CubeGrid::new(16)?);
/// assert!((back.bilinear(&haarmonic::nalgebra::Vector3::y()) - 2.0_f64).abs() < 0.02);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Unchecked<P>", bound(deserialize = "P: Texel + serde::Deserialize<'de>"))
)]
#[derive(Debug, Clone, PartialEq)]
pub struct DiskMap<P> {
    projection: DiskProjection,
    side: usize,
    pixels: Vec<P>,
}

/// What a stored map says of itself.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Unchecked<P> {
    projection: DiskProjection,
    side: usize,
    pixels: Vec<P>,
}

#[cfg(feature = "serde")]
impl<P: Texel> TryFrom<Unchecked<P>> for DiskMap<P> {
    type Error = Error;

    fn try_from(map: Unchecked<P>) -> Result<Self> {
        Self::new(map.projection, map.side, map.pixels)
    }
}

impl<P: Texel> DiskMap<P> {
    /// The most pixels along a disk.
    pub const MAX_SIDE: usize = 1 << 14;

    /// A map from its pixels: rows of [`DiskProjection::disks`] · `side`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 1 ≤ `side` ≤ [`MAX_SIDE`](Self::MAX_SIDE), [`Error::Length`] unless there is one
    /// value a pixel.
    pub fn new(projection: DiskProjection, side: usize, pixels: Vec<P>) -> Result<Self> {
        check_side::<P>(side)?;
        let expected = projection.disks() * side * side;
        if pixels.len() != expected {
            return Err(Error::Length { what: "pixels of a disk map", expected, got: pixels.len() });
        }
        Ok(Self { projection, side, pixels })
    }

    /// The map whose pixels are a function of the direction of their centre; zero beyond the rim.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 1 ≤ `side` ≤ [`MAX_SIDE`](Self::MAX_SIDE).
    pub fn from_fn(projection: DiskProjection, side: usize, f: impl Fn(&UnitVector3<f64>) -> P) -> Result<Self> {
        check_side::<P>(side)?;
        let width = projection.disks() * side;
        let pixel = |i: usize| {
            let (column, row) = (i % width, i / width);
            let point = Vector2::new(centre(column % side, side), -centre(row, side));
            projection.direction(column / side, &point).map_or(P::zero(), |direction| f(&direction))
        };
        Ok(Self { projection, side, pixels: (0..width * side).map(pixel).collect() })
    }

    /// The bilinear values of a cube map at the pixels' centres.
    ///
    /// # Errors
    /// Those of [`from_fn`](Self::from_fn).
    pub fn from_cube(projection: DiskProjection, side: usize, cube: &CubeMap<P>) -> Result<Self> {
        Self::from_fn(projection, side, |direction| P::narrow(cube.bilinear(direction)))
    }

    /// How directions lie in the picture.
    pub fn projection(&self) -> DiskProjection {
        self.projection
    }

    /// Pixels along an edge of a disk's square.
    pub fn side(&self) -> usize {
        self.side
    }

    /// All pixels, row after row from the top left.
    pub fn pixels(&self) -> &[P] {
        &self.pixels
    }

    /// The same.
    pub fn into_pixels(self) -> Vec<P> {
        self.pixels
    }

    /// The value in a direction: bilinear between those of the four pixels around it that show something; if none of
    /// them does, that of the one nearest to the centre. `direction` need not be unit.
    pub fn bilinear(&self, direction: &Vector3<f64>) -> P::Wide {
        let (disk, point) = self.projection.point(direction);
        let last = (self.side - 1) as f64;
        let place = |u: f64| ((u + 1.0) * 0.5 * self.side as f64 - 0.5).clamp(0.0, last);
        let (x, y) = (place(point.x), place(-point.y));
        let (x0, y0) = (x as usize, y as usize);
        let (x1, y1) = ((x0 + 1).min(self.side - 1), (y0 + 1).min(self.side - 1));
        let (s, t) = (x - x0 as f64, y - y0 as f64);
        let at =
            |x: usize, y: usize| self.pixels[y * self.projection.disks() * self.side + disk * self.side + x].widen();
        let mut sum = P::zero().widen();
        let mut weights = 0.0;
        for (x, y, weight) in
            [(x0, y0, (1.0 - s) * (1.0 - t)), (x1, y0, s * (1.0 - t)), (x0, y1, (1.0 - s) * t), (x1, y1, s * t)]
        {
            let shows = centre(x, self.side).hypot(centre(y, self.side)) <= 1.0;
            if weight > 0.0 && shows {
                sum = sum + at(x, y) * weight;
                weights += weight;
            }
        }
        if weights == 0.0 {
            let inwards = |i: usize, j: usize| if 2 * i < self.side { j } else { i };
            return at(inwards(x0, x1), inwards(y0, y1));
        }
        sum.map_components(|c| c / weights)
    }

    /// The values at the centres of a cube map's texels.
    ///
    /// A face of side/2 texels is denser than the pixels in the middle of a disk: 4/side radians for 2π/side of an
    /// angular map and 4/side of the others. The energy is not restored.
    pub fn to_cube(&self, grid: CubeGrid) -> CubeMap<P> {
        // A mean of finite numbers is not beyond the largest of them, but for rounding.
        let largest = P::Scalar::max_value().widen();
        CubeMap::from_fn(grid, |d| P::narrow(self.bilinear(&d).map_components(|c| c.clamp(-largest, largest))))
    }
}

fn check_side<P: Texel>(side: usize) -> Result<()> {
    if (1..=DiskMap::<P>::MAX_SIDE).contains(&side) {
        return Ok(());
    }
    Err(Error::OutOfRange { what: "side of a disk map", got: side as f64, allowed: "in 1…16384" })
}

/// The coordinate of the centre of pixel i in [−1, 1].
fn centre(i: usize, side: usize) -> f64 {
    (2 * i + 1) as f64 / side as f64 - 1.0
}

crate::approx_eq::approx_by_parts!(
    [P: Texel + approx::RelativeEq + approx::UlpsEq + approx::AbsDiffEq<Epsilon: Copy>] DiskMap<P>,
    P, |m| close [&m.pixels] same [m.projection, m.side]
);
