//! A procedural sky: a gradient, a ground, a sun and soft boxes.

use nalgebra::{Rotation3, Unit, UnitVector3, Vector3};

use super::sun::{Sun, angle, check_radius, check_range};
use crate::sphere::{CubeGrid, CubeMap};
use crate::{Error, Result};

/// A sky made of numbers, in high dynamic range; +y is up.
///
/// ```math
/// L(ω) = mix(ground, horizon + (zenith − horizon) · y^falloff, above(y)) + sun + Σ soft boxes
/// ```
///
/// `above` runs smoothly from 0 to 1 within `horizon_softness` of the horizon.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Vector3, scene::Sky};
/// let sky = Sky::default();
/// assert_eq!(sky.radiance(&Vector3::y()), sky.zenith);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Sky {
    /// Radiance straight up.
    pub zenith: Vector3<f64>,
    /// Radiance just above the horizon.
    pub horizon: Vector3<f64>,
    /// Radiance of everything below the horizon.
    pub ground: Vector3<f64>,
    /// How fast the horizon's colour gives way: the exponent of y = sin(elevation), in (0, 16]. Small values keep the
    /// horizon's colour in a thin band.
    pub falloff: f64,
    /// Half the height, in y, of the passage from ground to sky, in [0, 1]. 0 is a sharp edge.
    pub horizon_softness: f64,
    /// The sun, if there is one.
    pub sun: Option<Sun>,
    /// Lamps before the sky; they add to it.
    pub boxes: Vec<SoftBox>,
}

/// A rectangular lamp with soft edges, as photographers use them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SoftBox {
    /// Where its centre stands; its upper edge is level unless it stands straight up or down.
    pub direction: UnitVector3<f64>,
    /// Half its width and height on the plane at distance 1, each in (0, 100].
    pub half_size: [f64; 2],
    /// Width of the soft edge as a fraction of the half size, in [0, 1].
    pub softness: f64,
    /// Radiance in the middle.
    pub radiance: Vector3<f64>,
}

impl Default for Sky {
    /// A clear afternoon: blue zenith, pale horizon, earthy ground, the sun 40° high towards +x and −z.
    fn default() -> Self {
        Self {
            zenith: Vector3::new(0.18, 0.35, 0.85),
            horizon: Vector3::new(0.75, 0.85, 1.0),
            ground: Vector3::new(0.16, 0.13, 0.10),
            falloff: 0.5,
            horizon_softness: 0.02,
            sun: Some(Sun {
                direction: toward(40.0, 35.0),
                angular_radius: 0.025,
                radiance: Vector3::new(900.0, 820.0, 680.0),
            }),
            boxes: Vec::new(),
        }
    }
}

/// The unit direction at an elevation and an azimuth in degrees; azimuth 0 is −z, 90 is +x.
fn toward(elevation: f64, azimuth: f64) -> UnitVector3<f64> {
    let ((se, ce), (sa, ca)) = (elevation.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
    Unit::new_normalize(Vector3::new(ce * sa, se, -ce * ca))
}

impl Sky {
    /// A photographer's studio: a dim room, a warm key light, a cool fill light, a rim light from behind, no sun.
    pub fn studio() -> Self {
        let lamp = |elevation, azimuth, half_size, radiance: [f64; 3]| SoftBox {
            direction: toward(elevation, azimuth),
            half_size,
            softness: 0.25,
            radiance: radiance.into(),
        };
        Self {
            zenith: Vector3::new(0.06, 0.06, 0.07),
            horizon: Vector3::new(0.12, 0.12, 0.12),
            ground: Vector3::new(0.05, 0.045, 0.04),
            falloff: 1.0,
            horizon_softness: 0.1,
            sun: None,
            boxes: vec![
                lamp(35.0, 130.0, [0.45, 0.6], [14.0, 12.0, 9.5]),
                lamp(20.0, -120.0, [0.5, 0.5], [1.6, 2.4, 4.2]),
                lamp(50.0, -15.0, [0.7, 0.15], [8.0, 8.5, 9.0]),
            ],
        }
    }

    /// An evening: a low orange sun, a glowing horizon, a violet zenith.
    pub fn sunset() -> Self {
        Self {
            zenith: Vector3::new(0.10, 0.13, 0.32),
            horizon: Vector3::new(1.6, 0.75, 0.32),
            ground: Vector3::new(0.07, 0.05, 0.05),
            falloff: 0.35,
            horizon_softness: 0.02,
            sun: Some(Sun {
                direction: toward(8.0, 110.0),
                angular_radius: 0.03,
                radiance: Vector3::new(620.0, 290.0, 95.0),
            }),
            boxes: Vec::new(),
        }
    }

    /// This sky with another sun.
    pub fn with_sun(mut self, sun: Option<Sun>) -> Self {
        self.sun = sun;
        self
    }

    /// This sky with one more soft box.
    pub fn with_box(mut self, lamp: SoftBox) -> Self {
        self.boxes.push(lamp);
        self
    }

    /// The radiance from `direction`, which need not be unit; the zero vector gives that on the horizon, without the
    /// sun, a direction that is not finite NaN.
    pub fn radiance(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        // Squares of lengths beyond these under- or overflow.
        let size = direction.amax();
        let direction = if (1e-100..=1e100).contains(&size) || size == 0.0 { *direction } else { direction / size };
        let sun = self.sun.filter(|sun| size > 0.0 && angle(&sun.direction, &direction) <= sun.angular_radius);
        self.without_sun(&direction) + sun.map_or_else(Vector3::zeros, |sun| sun.radiance)
    }

    /// Everything that varies slowly.
    fn without_sun(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.with_lamps(direction, &self.boxes)
    }

    /// The backdrop and some lamps.
    fn with_lamps<'a>(&self, direction: &Vector3<f64>, lamps: impl IntoIterator<Item = &'a SoftBox>) -> Vector3<f64> {
        let d = direction.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        let above = smooth_step(d.y, self.horizon_softness);
        let high = d.y.max(0.0).powf(self.falloff);
        let sky = self.horizon * (1.0 - high) + self.zenith * high;
        let backdrop = self.ground * (1.0 - above) + sky * above;
        lamps.into_iter().fold(backdrop, |sum, lamp| sum + lamp.radiance * lamp.coverage(&d))
    }

    /// The mean over every texel of the sky turned by `rotation`.
    pub(super) fn to_cube(&self, grid: CubeGrid, rotation: &Rotation3<f64>) -> CubeMap<Vector3<f32>> {
        // At least 256 points along a face's edge, and four in each texel.
        let across = (256usize.div_ceil(grid.side())).max(2);
        let inverse = rotation.inverse();
        // A lamp no wider than a few points would be caught by chance: it hands out its light itself, as the sun does.
        let pitch = 2.0 / (grid.side() * across) as f64;
        let (narrow, wide): (Vec<&SoftBox>, Vec<&SoftBox>) =
            self.boxes.iter().partition(|lamp| lamp.half_size[0].min(lamp.half_size[1]) < 4.0 * pitch);
        let small = if self.sun.is_some() || !narrow.is_empty() { grid.len() } else { 0 };
        let mut handed_out = vec![Vector3::<f64>::zeros(); small];
        if let Some(sun) = &self.sun {
            sun.texels(grid, rotation).for_each(|(i, mean)| handed_out[i] = mean);
        }
        if !narrow.is_empty() {
            let omega = grid.face_solid_angles();
            for lamp in narrow {
                lamp.for_each_point(pitch / 8.0, |d, share| {
                    let i = grid.nearest(&(rotation * d));
                    handed_out[i] += lamp.radiance * (share / omega[i % omega.len()]);
                });
            }
        }
        CubeMap::from_indices(
            grid,
            || (),
            |i, ()| {
                let (face, x, y) = grid.texel(i);
                let place =
                    |i: usize, k: usize| (2 * (i * across + k) + 1) as f64 / (grid.side() * across) as f64 - 1.0;
                let (mut sum, mut weight) = (Vector3::zeros(), 0.0);
                for v in (0..across).map(|k| place(y, k)) {
                    for u in (0..across).map(|k| place(x, k)) {
                        // dω = du dv/(1 + u² + v²)^{3/2}
                        let squared = 1.0 + u * u + v * v;
                        let w = 1.0 / (squared * squared.sqrt());
                        sum += self.with_lamps(&(inverse * face.point(u, v)), wide.iter().copied()) * w;
                        weight += w;
                    }
                }
                sum / weight + handed_out.get(i).copied().unwrap_or_else(Vector3::zeros)
            },
        )
    }

    /// Refuses what would make light that is negative or not finite.
    pub(super) fn check(&self) -> Result<()> {
        let backdrop = [
            ("channel of the sky's zenith", &self.zenith),
            ("channel of the sky's horizon", &self.horizon),
            ("channel of the sky's ground", &self.ground),
        ];
        let sun = self.sun.iter().map(|sun| ("channel of the sun's radiance", &sun.radiance));
        let boxes = self.boxes.iter().map(|lamp| ("channel of a soft box's radiance", &lamp.radiance));
        for (what, colour) in backdrop.into_iter().chain(sun).chain(boxes) {
            if let Some(index) = colour.iter().position(|c| !c.is_finite()) {
                return Err(Error::NotFinite { what, index });
            }
            for &c in colour {
                check_range(what, c, c >= 0.0, "not negative")?;
            }
        }
        check_range("falloff of the sky", self.falloff, self.falloff > 0.0 && self.falloff <= 16.0, "in (0, 16]")?;
        let soft = self.horizon_softness;
        check_range("softness of the horizon", soft, (0.0..=1.0).contains(&soft), "in [0, 1]")?;
        if let Some(sun) = &self.sun {
            check_radius(sun.angular_radius)?;
            check_unit("length of the sun's direction", &sun.direction)?;
        }
        for lamp in &self.boxes {
            for h in lamp.half_size {
                check_range("half size of a soft box", h, h > 0.0 && h <= 100.0, "in (0, 100]")?;
            }
            check_range("softness of a soft box", lamp.softness, (0.0..=1.0).contains(&lamp.softness), "in [0, 1]")?;
            check_unit("length of a soft box's direction", &lamp.direction)?;
        }
        self.check_brightest()
    }

    /// Refuses a sky of which a texel of some grid could be beyond the largest `f32`.
    fn check_brightest(&self) -> Result<()> {
        let finest = CubeGrid::new(CubeGrid::MAX_SIDE).expect("the largest side is allowed").solid_angle(0, 0);
        let sun = self.sun.map_or_else(Vector3::zeros, |sun| (sun.energy() / finest).inf(&sun.radiance));
        let lamps: Vector3<f64> = self.boxes.iter().map(|lamp| lamp.radiance).sum();
        let brightest = (self.zenith.sup(&self.horizon).sup(&self.ground) + lamps + sun).max();
        if brightest <= f64::from(f32::MAX) {
            Ok(())
        } else {
            let allowed = "at most 3.4e38, the largest f32, where sky, sun and soft boxes add up";
            Err(Error::OutOfRange { what: "brightest radiance of a sky", got: brightest, allowed })
        }
    }
}

/// A `UnitVector3` can be made unchecked, or from a zero vector.
fn check_unit(what: &'static str, direction: &UnitVector3<f64>) -> Result<()> {
    let norm = direction.norm();
    check_range(what, norm, (norm - 1.0).abs() < 1e-6, "1")
}

impl SoftBox {
    /// 1 inside, 0 outside, smooth across the edge; `d` unit.
    fn coverage(&self, d: &Vector3<f64>) -> f64 {
        let forward = d.dot(&self.direction);
        if forward <= 0.0 {
            return 0.0;
        }
        let [right, up] = self.axes();
        let [w, h] = self.half_size;
        self.edge(d.dot(&right) / forward, w) * self.edge(d.dot(&up) / forward, h)
    }

    /// The axes of its width and height. Its upper edge is level: the horizontal axis is up × direction, +x overhead.
    fn axes(&self) -> [Vector3<f64>; 2] {
        let right = Vector3::y().cross(&self.direction).try_normalize(1e-9).unwrap_or_else(Vector3::x);
        [right, self.direction.cross(&right)]
    }

    /// The coverage along one axis at the distance `t` from the middle.
    fn edge(&self, t: f64, half: f64) -> f64 {
        smooth_step(half - t.abs(), self.softness * half)
    }

    /// Points all over it, at most `spacing` apart in angle along each axis: their directions and coverage · solid
    /// angle.
    ///
    /// Midpoints in θ of a = tan θ, piece by piece between the ends of the soft edges, where coverage is smooth;
    /// dω = da db/(1 + a² + b²)^{3/2}.
    fn for_each_point(&self, spacing: f64, mut each: impl FnMut(Vector3<f64>, f64)) {
        let [right, up] = self.axes();
        let axis = |half: f64| {
            let ends = [1.0 + self.softness, 1.0 - self.softness].map(|f| (half * f).atan());
            let mut points = Vec::new();
            for (from, to) in [(-ends[0], -ends[1]), (-ends[1], ends[1]), (ends[1], ends[0])] {
                let n = (((to - from) / spacing).ceil() as usize).max(32);
                let step = (to - from) / n as f64;
                points.extend((0..n).filter(|_| step > 0.0).map(|k| {
                    let a = (from + (k as f64 + 0.5) * step).tan();
                    (a, self.edge(a, half) * (1.0 + a * a) * step)
                }));
            }
            points
        };
        let (across, along) = (axis(self.half_size[0]), axis(self.half_size[1]));
        for (a, da) in across {
            for &(b, db) in &along {
                let squared = 1.0 + a * a + b * b;
                each(*self.direction + right * a + up * b, da * db / (squared * squared.sqrt()));
            }
        }
    }
}

/// 0 below −width, 1 above width, a cubic between; at width 0 a step that is 1 at 0.
fn smooth_step(x: f64, width: f64) -> f64 {
    if x >= width {
        1.0
    } else if x <= -width {
        0.0
    } else {
        let t = 0.5 + 0.5 * x / width;
        t * t * (3.0 - 2.0 * t)
    }
}
