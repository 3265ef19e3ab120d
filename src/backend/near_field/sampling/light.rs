//! The light itself: what is seen along a ray, and directions to it.

use nalgebra::{Vector2, Vector3};

use super::super::PlanarLight;
use super::{DirectionSample, DirectionSampler};
use crate::Result;
use crate::scene::{Axes, LocalFrame};

/// What points of a light are drawn by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum LightWeight {
    /// Every part of the area is as likely.
    Area,
    /// A texel is as likely as its radiance, the length of its RGB vector, is large.
    #[default]
    Radiance,
}

/// Light sampling: a light in its frame, ready to be looked at along rays and drawn from.
///
/// Points of the light are drawn, by area or by radiance ([`LightWeight`]), and looked at from the point to be lit:
/// what is near or faces the point is no likelier than what does not.
#[derive(Debug, Clone)]
pub struct LightSampler {
    axes: Axes,
    centre: Vector3<f64>,
    size: Vector2<f64>,
    /// (cos, sin) of the light's rotation.
    turn: (f64, f64),
    width: usize,
    height: usize,
    radiance: Vec<Vector3<f32>>,
    /// The light, if its radiance depends on the direction: densities take it for the same in all.
    profiled: Option<PlanarLight>,
    weight: LightWeight,
    /// Sums of the weights in a row up to and with a texel; and of whole rows up to and with a row.
    along_row: Vec<f64>,
    rows: Vec<f64>,
}

/// What a ray meets of a light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightHit {
    /// The radiance towards the ray's origin.
    pub radiance: Vector3<f64>,
    /// How far the light is, in units of the direction's length.
    pub distance: f64,
    texel: usize,
}

impl LightSampler {
    /// The light as it is now, in the frame that its plane lies across.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless the axes of the frame are orthonormal to 10⁻³.
    pub fn new(light: &PlanarLight, frame: &LocalFrame, weight: LightWeight) -> Result<Self> {
        frame.check("dot products of a frame's axes, less those of orthonormal ones")?;
        let [width, height] = light.texture_size();
        let radiance: Vec<Vector3<f32>> = (0..width * height).map(|texel| light.radiance(texel)).collect();
        let largest = radiance.iter().map(|l| l.amax()).fold(0.0, f32::max);
        let mut sampler = Self {
            axes: Axes::new(frame),
            centre: light.centre(),
            size: light.size().into(),
            turn: (light.rotation().cos(), light.rotation().sin()),
            width,
            height,
            radiance,
            profiled: light.has_profile().then(|| light.clone()),
            weight,
            along_row: Vec::with_capacity(width * height),
            rows: Vec::with_capacity(height),
        };
        let mut total = 0.0;
        for row in 0..height {
            let mut sum = 0.0;
            for texel in row * width..(row + 1) * width {
                sum += match weight {
                    LightWeight::Area => 1.0,
                    LightWeight::Radiance => importance(&sampler.radiance[texel], largest),
                };
                sampler.along_row.push(sum);
            }
            total += sum;
            sampler.rows.push(total);
        }
        Ok(sampler)
    }

    /// What a ray meets of the light; `None` if it misses it or comes from behind.
    ///
    /// The direction need not have length 1.
    pub fn hit(&self, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<LightHit> {
        let (to, d) = (self.axes.to_local(&(self.centre - origin)), self.axes.to_local(direction));
        let distance = to.z / d.z;
        // NaN is no hit.
        if !(to.z > 0.0 && d.z > 0.0 && distance.is_finite()) {
            return None;
        }
        let texel = self.texel(&(d.xy() * distance - to.xy()))?;
        let share = self.profiled.as_ref().map_or(1.0, |light| light.profile(&-direction.normalize()));
        Some(LightHit { radiance: self.radiance[texel].cast() * share, distance, texel })
    }

    /// Directions to the light from a place.
    pub fn density(&self, position: &Vector3<f64>) -> LightDensity<'_> {
        let to = self.axes.to_local(&(self.centre - position));
        let sees = to.z > 0.0 && self.total() > 0.0 && to.iter().all(|c| c.is_finite());
        LightDensity { light: self, position: *position, to, sees }
    }

    /// What its points are drawn by.
    pub fn weight(&self) -> LightWeight {
        self.weight
    }

    pub(super) fn axes(&self) -> &Axes {
        &self.axes
    }

    /// The middle of the light seen from a place, in the frame.
    pub(super) fn to_centre(&self, position: &Vector3<f64>) -> Vector3<f64> {
        self.axes.to_local(&(self.centre - position))
    }

    /// The texel at a point of the light's plane, seen from its centre.
    fn texel(&self, from_centre: &Vector2<f64>) -> Option<usize> {
        let (cos, sin) = self.turn;
        let (x, y) = (from_centre.x, from_centre.y);
        let turned = [cos * x + sin * y, cos * y - sin * x];
        let cell = |axis: usize, cells: usize| {
            let u = turned[axis] / self.size[axis] + 0.5;
            (0.0..=1.0).contains(&u).then(|| ((u * cells as f64) as usize).min(cells - 1))
        };
        Some(cell(1, self.height)? * self.width + cell(0, self.width)?)
    }

    fn total(&self) -> f64 {
        *self.rows.last().expect("a texture has rows")
    }

    /// The density of a texel's points, per area.
    fn density_of_area(&self, texel: usize) -> f64 {
        let before = if texel % self.width == 0 { 0.0 } else { self.along_row[texel - 1] };
        let texel_area = self.size.x * self.size.y / (self.width * self.height) as f64;
        (self.along_row[texel] - before) / (self.total() * texel_area)
    }
}

/// Light sampling about one point: see [`LightSampler`].
///
/// The density is 0 everywhere for a point in the light's plane or behind it, under a black light that is drawn from by
/// radiance, and for a point with NaN or ∞.
#[derive(Debug, Clone, Copy)]
pub struct LightDensity<'a> {
    light: &'a LightSampler,
    position: Vector3<f64>,
    /// The light's centre in its frame.
    to: Vector3<f64>,
    sees: bool,
}

impl LightDensity<'_> {
    /// Whether there is nothing to draw from.
    pub fn is_empty(&self) -> bool {
        !self.sees
    }
}

impl DirectionSampler for LightDensity<'_> {
    fn sample(&self, uniform: [f64; 2]) -> Option<DirectionSample> {
        if !self.sees {
            return None;
        }
        let light = self.light;
        let (row, down) = choose(&light.rows, uniform[1]);
        let (column, right) = choose(&light.along_row[row * light.width..][..light.width], uniform[0]);
        let along = |cell: usize, within: f64, cells: usize| (cell as f64 + within) / cells as f64 - 0.5;
        let x = light.size.x * along(column, right, light.width);
        let y = light.size.y * along(row, down, light.height);
        let (cos, sin) = light.turn;
        let to = self.to + Vector3::new(cos * x - sin * y, sin * x + cos * y, 0.0);
        let distance = to.norm();
        let pdf = light.density_of_area(row * light.width + column) * distance.powi(3) / to.z;
        Some(DirectionSample { direction: light.axes.to_world(&(to / distance)), pdf })
    }

    fn pdf(&self, direction: &Vector3<f64>) -> f64 {
        let Some(hit) = self.light.hit(&self.position, direction).filter(|_| self.sees) else { return 0.0 };
        self.light.density_of_area(hit.texel) * hit.distance.powi(3) / self.to.z
    }
}

/// The cell that a uniform number falls into, by cumulated weights, and how far into it.
fn choose(sums: &[f64], uniform: f64) -> (usize, f64) {
    let at = uniform * sums[sums.len() - 1];
    // The first sum above `at` ends a cell whose weight is not 0; rounding may leave none.
    let cell = sums.partition_point(|&sum| sum <= at);
    let cell = if cell < sums.len() { cell } else { sums.partition_point(|&sum| sum < sums[sums.len() - 1]) };
    let before = if cell == 0 { 0.0 } else { sums[cell - 1] };
    (cell, ((at - before) / (sums[cell] - before)).clamp(0.0, 1.0))
}

/// How much a texel matters to an error over all channels, relative to the largest channel of any: the length of its
/// RGB vector.
pub(super) fn importance(radiance: &Vector3<f32>, largest: f32) -> f64 {
    if largest > 0.0 { (radiance.cast::<f64>() / f64::from(largest)).norm() } else { 0.0 }
}
