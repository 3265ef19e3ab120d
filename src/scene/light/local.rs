//! Lights at a place: rectangles, spheres, points, spots, light fields.

use std::sync::Arc;

use nalgebra::{UnitVector3, Vector3};

use crate::{Error, Result};

/// A light at a place in the world.
///
/// Radiance is in W/(sr m²) or any unit that the caller likes, in RGB; intensity of points and spots is radiance times
/// area, the same unit times m².
#[derive(Debug, Clone)]
pub enum LocalLight {
    /// A textured rectangle.
    Rectangle(RectangleLight),
    /// A sphere of one radiance.
    Sphere(SphereLight),
    /// A point that shines the same in all directions, or a cone of it.
    Spot(SpotLight),
    /// A rectangle whose radiance depends on the direction too.
    Field(LightField),
}

/// Light that arrives at a point from one part of a light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightSample {
    /// The unit direction from the point to the light.
    pub direction: Vector3<f64>,
    /// How far the light is.
    pub distance: f64,
    /// ∫ L dω over the part: what it adds to the irradiance of a surface that faces it.
    pub irradiance: Vector3<f64>,
}

impl LocalLight {
    /// Calls `each` for parts of the light as seen from a point: `samples`² of them for a sphere, for each pixel of a
    /// rectangle's texture and for a light field; 1 for a spot.
    ///
    /// The sum over `each` converges to ∫ L(ω) g(ω) dω with the square of 1/samples, for smooth g.
    pub fn sample(&self, from: &Vector3<f64>, samples: usize, mut each: impl FnMut(LightSample)) {
        match self {
            Self::Rectangle(light) => light.sample(from, samples, &mut each),
            Self::Sphere(light) => light.sample(from, samples, &mut each),
            Self::Spot(light) => light.sample(from, &mut each),
            Self::Field(light) => light.sample(from, samples, &mut each),
        }
    }

    /// A point in its middle.
    pub fn centre(&self) -> Vector3<f64> {
        match self {
            Self::Rectangle(light) => light.pane.centre,
            Self::Sphere(light) => light.centre,
            Self::Spot(light) => light.position,
            Self::Field(light) => light.pane.centre,
        }
    }
}

/// A rectangle in any pose; it shines to the side of half_u × half_v.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Pane {
    centre: Vector3<f64>,
    half_u: Vector3<f64>,
    half_v: Vector3<f64>,
}

impl Pane {
    fn new(centre: Vector3<f64>, half_u: Vector3<f64>, half_v: Vector3<f64>) -> Result<Self> {
        let all = [centre, half_u, half_v];
        if let Some(index) = all.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
            return Err(Error::NotFinite { what: "rectangle: centre, half edge along u, along v:", index });
        }
        let sine = half_u.normalize().cross(&half_v.normalize()).norm();
        if !((sine - 1.0).abs() < 1e-6) {
            let what = "sine of the angle between a rectangle's edges";
            return Err(Error::OutOfRange { what, got: sine, allowed: "1 to 1e-6, of edges that are not 0" });
        }
        Ok(Self { centre, half_u, half_v })
    }

    /// The samples of cells [i, j] of n × m, the radiance of each a function of its place in [0, 1]² and the direction
    /// from the light to the point.
    fn sample(
        &self,
        from: &Vector3<f64>,
        [columns, rows]: [usize; 2],
        radiance: impl Fn([f64; 2], &Vector3<f64>) -> Vector3<f64>,
        each: &mut impl FnMut(LightSample),
    ) {
        let normal = self.half_u.cross(&self.half_v);
        let area = 4.0 * normal.norm() / (columns * rows) as f64;
        let normal = normal.normalize();
        if normal.dot(&(from - self.centre)) <= 0.0 {
            return;
        }
        for j in 0..rows {
            for i in 0..columns {
                let [s, t] = [(i as f64 + 0.5) / columns as f64, (j as f64 + 0.5) / rows as f64];
                let to = self.centre + self.half_u * (2.0 * s - 1.0) + self.half_v * (2.0 * t - 1.0) - from;
                let distance = to.norm();
                let direction = to / distance;
                let omega = area * -normal.dot(&direction) / (distance * distance);
                let irradiance = radiance([s, t], &-direction) * omega;
                if irradiance != Vector3::zeros() {
                    each(LightSample { direction, distance, irradiance });
                }
            }
        }
    }
}

/// A rectangle with a texture of radiance: constant over each pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct RectangleLight {
    pane: Pane,
    width: usize,
    height: usize,
    pixels: Vec<Vector3<f32>>,
}

impl RectangleLight {
    /// A rectangle centre ± `half_u` ± `half_v` that shines to the side of `half_u` × `half_v`, with a texture of
    /// `width` × `height` pixels: row after row, columns along `half_u` and rows along `half_v`.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for a vector or pixel with NaN or ∞, [`Error::OutOfRange`] unless the edges are
    /// perpendicular to 10⁻⁶ and not 0, [`Error::Length`] unless there are width · height pixels, [`Error::Empty`]
    /// without one.
    pub fn new(
        centre: Vector3<f64>,
        half_u: Vector3<f64>,
        half_v: Vector3<f64>,
        width: usize,
        pixels: Vec<Vector3<f32>>,
    ) -> Result<Self> {
        let pane = Pane::new(centre, half_u, half_v)?;
        if pixels.is_empty() || width == 0 {
            return Err(Error::Empty { what: "texture of a rectangle" });
        }
        if !pixels.len().is_multiple_of(width) {
            let expected = pixels.len().next_multiple_of(width);
            return Err(Error::Length { what: "pixels of a rectangle's texture", expected, got: pixels.len() });
        }
        if let Some(index) = pixels.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            return Err(Error::NotFinite { what: "pixel of a rectangle's texture", index });
        }
        Ok(Self { pane, width, height: pixels.len() / width, pixels })
    }

    /// A rectangle of one radiance.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn uniform(
        centre: Vector3<f64>,
        half_u: Vector3<f64>,
        half_v: Vector3<f64>,
        radiance: Vector3<f32>,
    ) -> Result<Self> {
        Self::new(centre, half_u, half_v, 1, vec![radiance])
    }

    /// The four corners, counter-clockwise seen from the side that it shines to.
    pub fn corners(&self) -> [Vector3<f64>; 4] {
        let Pane { centre, half_u, half_v } = self.pane;
        [centre - half_u - half_v, centre + half_u - half_v, centre + half_u + half_v, centre - half_u + half_v]
    }

    /// Columns and rows of the texture.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// The texture, row after row.
    pub fn pixels(&self) -> &[Vector3<f32>] {
        &self.pixels
    }

    fn sample(&self, from: &Vector3<f64>, samples: usize, each: &mut impl FnMut(LightSample)) {
        let radiance = |[s, t]: [f64; 2], _: &Vector3<f64>| {
            let [i, j] = [(s, self.width), (t, self.height)].map(|(s, n)| ((s * n as f64) as usize).min(n - 1));
            self.pixels[j * self.width + i].cast()
        };
        self.pane.sample(from, [self.width * samples, self.height * samples], radiance, each);
    }
}

/// Radiance by the place in [0, 1]² and the unit direction that leaves the light.
type Radiance = dyn Fn([f64; 2], &Vector3<f64>) -> Vector3<f64> + Send + Sync;

/// A rectangle whose radiance is a function of place and direction: what a window shows, a display, a lamp with a
/// reflector.
#[derive(Clone)]
pub struct LightField {
    pane: Pane,
    radiance: Arc<Radiance>,
}

impl std::fmt::Debug for LightField {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LightField").field("pane", &self.pane).finish_non_exhaustive()
    }
}

impl LightField {
    /// A rectangle centre ± `half_u` ± `half_v` that shines to the side of `half_u` × `half_v`. `radiance(w, ω)` is
    /// that at w ∈ [0, 1]² (along u and v) into the unit direction ω, which leaves the light.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for a vector with NaN or ∞, [`Error::OutOfRange`] unless the edges are perpendicular to
    /// 10⁻⁶ and not 0.
    pub fn new(
        centre: Vector3<f64>,
        half_u: Vector3<f64>,
        half_v: Vector3<f64>,
        radiance: impl Fn([f64; 2], &Vector3<f64>) -> Vector3<f64> + Send + Sync + 'static,
    ) -> Result<Self> {
        Ok(Self { pane: Pane::new(centre, half_u, half_v)?, radiance: Arc::new(radiance) })
    }

    fn sample(&self, from: &Vector3<f64>, samples: usize, each: &mut impl FnMut(LightSample)) {
        self.pane.sample(from, [samples, samples], |place, direction| (self.radiance)(place, direction), each);
    }
}

/// A sphere that shines with the same radiance everywhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphereLight {
    centre: Vector3<f64>,
    radius: f64,
    radiance: Vector3<f64>,
}

impl SphereLight {
    /// # Errors
    /// [`Error::NotFinite`] for a centre or radiance with NaN or ∞, [`Error::OutOfRange`] unless the radius is positive
    /// and finite.
    pub fn new(centre: Vector3<f64>, radius: f64, radiance: Vector3<f64>) -> Result<Self> {
        if let Some(index) = [centre, radiance].iter().position(|v| !v.iter().all(|c| c.is_finite())) {
            return Err(Error::NotFinite { what: "sphere light: centre, radiance:", index });
        }
        if !(radius > 0.0 && radius.is_finite()) {
            let what = "radius of a sphere light";
            return Err(Error::OutOfRange { what, got: radius, allowed: "positive and finite" });
        }
        Ok(Self { centre, radius, radiance })
    }

    /// The centre.
    pub fn centre(&self) -> Vector3<f64> {
        self.centre
    }

    /// The radius.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Equal solid angles of the cap that the sphere is seen as; all directions from inside of it.
    fn sample(&self, from: &Vector3<f64>, samples: usize, each: &mut impl FnMut(LightSample)) {
        let to = self.centre - from;
        let away = to.norm();
        let axis = to.try_normalize(0.0).unwrap_or_else(Vector3::z);
        let sine = self.radius / away;
        let is_inside = !(sine < 1.0);
        // 1 − cos θ, without cancellation.
        let cap = if is_inside { 2.0 } else { sine * sine / (1.0 + (1.0 - sine * sine).sqrt()) };
        let across = Vector3::ith(axis.iamin(), 1.0).cross(&axis).normalize();
        let other = axis.cross(&across);
        let omega = std::f64::consts::TAU * cap / (samples * samples) as f64;
        for j in 0..samples {
            let below = cap * (j as f64 + 0.5) / samples as f64;
            let (c, s) = (1.0 - below, (below * (2.0 - below)).sqrt());
            for i in 0..samples {
                let angle = std::f64::consts::TAU * (i as f64 + 0.5) / samples as f64;
                let direction = axis * c + (across * angle.cos() + other * angle.sin()) * s;
                // Where the ray enters the sphere, or leaves it.
                let along = direction.dot(&to);
                let half_chord = (along * along - away * away + self.radius * self.radius).max(0.0).sqrt();
                let distance = if is_inside { along + half_chord } else { along - half_chord };
                each(LightSample { direction, distance, irradiance: self.radiance * omega });
            }
        }
    }
}

/// A point that shines into a cone, or everywhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpotLight {
    position: Vector3<f64>,
    axis: Vector3<f64>,
    intensity: Vector3<f64>,
    /// The cosines of the angles where the light begins to fade and is gone.
    cosines: [f64; 2],
}

impl SpotLight {
    /// A point light: the same intensity in all directions.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for a position or intensity with NaN or ∞.
    pub fn point(position: Vector3<f64>, intensity: Vector3<f64>) -> Result<Self> {
        Self::checked(position, Vector3::z_axis(), intensity, [-1.0, -2.0])
    }

    /// A spot light: full intensity up to `inner` radians from its axis, none from `outer` on, and between them the
    /// cubic 3t² − 2t³ in the cosine.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for a position or intensity with NaN or ∞, [`Error::OutOfRange`] unless 0 ≤ `inner` <
    /// `outer` ≤ π.
    pub fn spot(
        position: Vector3<f64>,
        axis: UnitVector3<f64>,
        intensity: Vector3<f64>,
        inner: f64,
        outer: f64,
    ) -> Result<Self> {
        if !(0.0 <= inner && inner < outer && outer <= std::f64::consts::PI) {
            let what = "angles of a spot light, outer less inner";
            return Err(Error::OutOfRange { what, got: outer - inner, allowed: "positive, both in [0, π]" });
        }
        Self::checked(position, axis, intensity, [inner.cos(), outer.cos()])
    }

    fn checked(
        position: Vector3<f64>,
        axis: UnitVector3<f64>,
        intensity: Vector3<f64>,
        cosines: [f64; 2],
    ) -> Result<Self> {
        let all = [position, axis.into_inner(), intensity];
        match all.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
            Some(index) => Err(Error::NotFinite { what: "spot light: position, axis, intensity:", index }),
            None => Ok(Self { position, axis: axis.into_inner(), intensity, cosines }),
        }
    }

    /// Where it is.
    pub fn position(&self) -> Vector3<f64> {
        self.position
    }

    /// The intensity in a unit direction that leaves the light.
    pub fn intensity(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let [full, none] = self.cosines;
        let t = ((self.axis.dot(direction) - none) / (full - none)).clamp(0.0, 1.0);
        self.intensity * (t * t * (3.0 - 2.0 * t))
    }

    fn sample(&self, from: &Vector3<f64>, each: &mut impl FnMut(LightSample)) {
        let to = self.position - from;
        let Some(direction) = to.try_normalize(0.0) else { return };
        let irradiance = self.intensity(&-direction) / to.norm_squared();
        if irradiance != Vector3::zeros() {
            each(LightSample { direction, distance: to.norm(), irradiance });
        }
    }
}
