//! Light: distant (an environment map or a procedural sky, turned as the user likes) and at a place.

mod local;
mod sky;
mod sun;

use nalgebra::{Matrix3, Rotation3, Vector3};

pub use local::{LightField, LightSample, LocalLight, RectangleLight, SphereLight, SpotLight};
pub use sky::{Sky, SoftBox};
pub use sun::Sun;

use crate::sphere::{CubeGrid, CubeMap, LatLongMap, Resampling};
use crate::{Error, Result};

/// Light from infinitely far away: linear RGB radiance for every direction towards it.
///
/// Pixels must be finite: NaN and infinities, which would spread over a whole relit scene, are refused. Negative
/// pixels, which reconstruction filters leave in photographs, become 0 and are counted.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentLight {
    source: Source,
    rotation: Rotation3<f64>,
    clamped: usize,
}

/// What an [`EnvironmentLight`] is made of, before it is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum EnvironmentSource<'a> {
    /// A latitude–longitude map.
    LatLong(&'a LatLongMap<Vector3<f32>>),
    /// A cube map.
    Cube(&'a CubeMap<Vector3<f32>>),
    /// A procedural sky.
    Sky(&'a Sky),
}

#[derive(Debug, Clone, PartialEq)]
enum Source {
    LatLong(LatLongMap<Vector3<f32>>),
    Cube(CubeMap<Vector3<f32>>),
    Sky(Sky),
}

impl EnvironmentLight {
    /// The light of a latitude–longitude map.
    ///
    /// Maps drawn for another program are turned by
    /// [`LatLongConvention::rotation`](crate::sphere::LatLongConvention::rotation).
    ///
    /// # Errors
    /// [`Error::NotFinite`] with the first pixel that is NaN or infinite.
    pub fn from_lat_long(map: LatLongMap<Vector3<f32>>) -> Result<Self> {
        if let Some(index) = map.first_not_finite() {
            return Err(Error::NotFinite { what: "environment map pixel", index });
        }
        let clamped = count_negative(map.pixels());
        let map = if clamped == 0 { map } else { map.map(|p| p.map(|c| c.max(0.0))) };
        Ok(Self { source: Source::LatLong(map), rotation: Rotation3::identity(), clamped })
    }

    /// The light of a cube map.
    ///
    /// # Errors
    /// [`Error::NotFinite`] with the first texel that is NaN or infinite.
    pub fn from_cube(map: CubeMap<Vector3<f32>>) -> Result<Self> {
        if let Some(index) = map.first_not_finite() {
            return Err(Error::NotFinite { what: "environment map texel", index });
        }
        let clamped = count_negative(map.texels());
        let map = if clamped == 0 { map } else { map.map(|p| p.map(|c| c.max(0.0))) };
        Ok(Self { source: Source::Cube(map), rotation: Rotation3::identity(), clamped })
    }

    /// The light of a procedural sky.
    ///
    /// # Errors
    /// [`Error::NotFinite`] or [`Error::OutOfRange`] for a colour that is not finite or negative, or a size outside the
    /// range that its field states, or where sky, sun and lamps could add up to a texel above the largest `f32`.
    ///
    /// # Example
    /// ```
    /// use haarmonic::scene::{EnvironmentLight, Sky};
    /// use haarmonic::sphere::CubeGrid;
    /// let light = EnvironmentLight::from_sky(Sky::sunset())?;
    /// let (coarse, fine) = (light.to_cube(CubeGrid::new(2)?), light.to_cube(CubeGrid::new(64)?));
    /// assert!((coarse.integral() - fine.integral()).norm() < 1e-5 * fine.integral().norm());
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn from_sky(sky: Sky) -> Result<Self> {
        sky.check()?;
        Ok(Self { source: Source::Sky(sky), rotation: Rotation3::identity(), clamped: 0 })
    }

    /// This light turned by `rotation` and nothing else: what came from ω then comes from Rω.
    ///
    /// A matrix that is no rotation (made unchecked: a component not finite, or columns off being orthonormal by more
    /// than 1e-3) gives a light that is NaN in every direction and texel, which [`CubeMap::first_not_finite`] finds.
    pub fn with_rotation(mut self, rotation: Rotation3<f64>) -> Self {
        self.rotation = rotation;
        self
    }

    /// Turns the light, as [`with_rotation`](Self::with_rotation).
    pub fn set_rotation(&mut self, rotation: Rotation3<f64>) {
        self.rotation = rotation;
    }

    /// How the light is turned.
    pub fn rotation(&self) -> &Rotation3<f64> {
        &self.rotation
    }

    /// The map or sky, as it was given but for negative pixels, which are 0. The light is that, turned by
    /// [`rotation`](Self::rotation).
    ///
    /// # Example
    /// ```
    /// use haarmonic::nalgebra::Vector3;
    /// use haarmonic::scene::{EnvironmentLight, EnvironmentSource};
    /// use haarmonic::sphere::{CubeGrid, CubeMap};
    /// let map = CubeMap::from_fn(CubeGrid::new(2)?, |d| d.map(|c| c.abs() as f32));
    /// let light = EnvironmentLight::from_cube(map.clone())?;
    /// assert_eq!(light.source(), EnvironmentSource::Cube(&map));
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn source(&self) -> EnvironmentSource<'_> {
        match &self.source {
            Source::LatLong(map) => EnvironmentSource::LatLong(map),
            Source::Cube(map) => EnvironmentSource::Cube(map),
            Source::Sky(sky) => EnvironmentSource::Sky(sky),
        }
    }

    /// How many pixels had a negative channel that became 0.
    pub fn clamped_pixels(&self) -> usize {
        self.clamped
    }

    /// The radiance that comes from `direction`: bilinear for maps, analytic for a sky. `direction` need not be unit.
    ///
    /// NaN for a direction, or turned by a matrix, that is not finite.
    pub fn radiance(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        if !is_rotation(&self.rotation) {
            return Vector3::repeat(f64::NAN);
        }
        let within = self.rotation.inverse_transform_vector(direction);
        match &self.source {
            Source::LatLong(map) => map.bilinear(&within),
            Source::Cube(map) => map.bilinear(&within),
            Source::Sky(sky) => sky.radiance(&within),
        }
    }

    /// The mean radiance over every texel of a cube.
    ///
    /// Maps are resampled by [`Resampling::Smooth`], which keeps ∫ L dω at any size. Of a sky the sun keeps its energy
    /// exactly however small it is, the rest to 1e-4: it is averaged over 256² or more points a face. The sharp edge of
    /// a lamp falls between two of these points; a lamp narrower than eight hands out its energy on its own, to 1e-3.
    /// Accuracy: ∫ L dω of maps and suns to the rounding of `f32`, 1e-7 relative, where texels are normal numbers.
    pub fn to_cube(&self, grid: CubeGrid) -> CubeMap<Vector3<f32>> {
        if !is_rotation(&self.rotation) {
            return CubeMap::new(grid, vec![Vector3::repeat(f32::NAN); grid.len()]).expect("one value a texel");
        }
        match &self.source {
            Source::LatLong(map) => map.to_cube(grid, &self.rotation, Resampling::Smooth),
            Source::Cube(map) => map.to_cube(grid, &self.rotation, Resampling::Smooth),
            Source::Sky(sky) => sky.to_cube(grid, &self.rotation),
        }
    }
}

/// Whether a matrix is orthonormal but for what many multiplications may add up to.
fn is_rotation(rotation: &Rotation3<f64>) -> bool {
    let matrix = rotation.matrix();
    (matrix.transpose() * matrix - Matrix3::identity()).iter().all(|e| e.abs() <= 1e-3)
}

/// How many pixels have a negative channel.
fn count_negative(pixels: &[Vector3<f32>]) -> usize {
    pixels.iter().filter(|p| p.iter().any(|&c| c < 0.0)).count()
}
