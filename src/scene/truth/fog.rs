//! Homogeneous fog: what it takes away, and the light that it scatters once.

use nalgebra::Vector3;

use crate::scene::{LocalLight, Occluders};
use crate::{Error, Result};

/// How light is scattered: the share into a solid angle, by the cosine of the angle between the old and the new
/// direction. Its integral over the sphere is 1.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub enum Phase {
    /// 1/4π.
    #[default]
    Isotropic,
    /// 3/16π (1 + cos²): air.
    Rayleigh,
    /// (1 − g²)/(4π (1 + g² − 2g cos)^{3/2}), −1 < g < 1: forward for g > 0 [Henyey & Greenstein 1941].
    HenyeyGreenstein(f64),
}

impl Phase {
    /// The share a steradian.
    pub fn eval(self, cosine: f64) -> f64 {
        const ISOTROPIC: f64 = 0.25 * std::f64::consts::FRAC_1_PI;
        match self {
            Self::Isotropic => ISOTROPIC,
            Self::Rayleigh => 0.75 * ISOTROPIC * (1.0 + cosine * cosine),
            Self::HenyeyGreenstein(g) => {
                let base = 1.0 + g * g - 2.0 * g * cosine;
                ISOTROPIC * (1.0 - g * g) / (base * base.sqrt())
            }
        }
    }
}

/// Homogeneous fog in which light is scattered at most once on its way to an eye or a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fog {
    scattering: Vector3<f64>,
    absorption: Vector3<f64>,
    phase: Phase,
}

impl Fog {
    /// Fog of a scattering and an absorption coefficient, both one over a length, in RGB.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for NaN and ∞, [`Error::OutOfRange`] for a negative coefficient or a
    /// [`Phase::HenyeyGreenstein`] whose g is not within (−1, 1).
    pub fn new(scattering: Vector3<f64>, absorption: Vector3<f64>, phase: Phase) -> Result<Self> {
        for (what, coefficient) in [("scattering coefficient", scattering), ("absorption coefficient", absorption)] {
            if let Some(index) = coefficient.iter().position(|c| !c.is_finite()) {
                return Err(Error::NotFinite { what, index });
            }
            if let Some(&got) = coefficient.iter().find(|c| **c < 0.0) {
                return Err(Error::OutOfRange { what, got, allowed: "not negative" });
            }
        }
        if let Phase::HenyeyGreenstein(g) = phase
            && !(g > -1.0 && g < 1.0)
        {
            let what = "g of Henyey and Greenstein";
            return Err(Error::OutOfRange { what, got: g, allowed: "in (−1, 1)" });
        }
        Ok(Self { scattering, absorption, phase })
    }

    /// Scattering and absorption together.
    pub fn extinction(&self) -> Vector3<f64> {
        self.scattering + self.absorption
    }

    /// The share of light that comes through a distance.
    pub fn transmittance(&self, distance: f64) -> Vector3<f64> {
        // 0 · ∞ is no fog over any distance.
        self.extinction().map(|k| if k == 0.0 { 1.0 } else { (-k * distance).exp() })
    }

    /// The radiance that fog scatters into an eye along a ray of a length, which may be infinite: light of the lamps,
    /// dimmed on its way to a point of the ray, scattered there, and dimmed on its way to the eye.
    ///
    /// ```math
    /// L = ∫ β e^{−κt} Σ ∫ p(ω · ω_i) e^{−κd} V L_i dω_i dt
    /// ```
    ///
    /// by the midpoint rule at `samples` points, equal steps of the angle that a lamp's centre sees the ray under, and
    /// an eighth as many samples along an edge of the lamp. What falls on the ray past `occluders` is looked up by
    /// rays. A ray through a point light has no finite radiance.
    ///
    /// Error: falls with the square of 1/samples where shadows do not cross the ray.
    ///
    /// # Panics
    /// If `samples` is 0.
    #[track_caller]
    pub fn airlight(
        &self,
        eye: &Vector3<f64>,
        direction: &Vector3<f64>,
        length: f64,
        lights: &[LocalLight],
        occluders: Option<&Occluders>,
        samples: usize,
    ) -> Vector3<f64> {
        assert!(samples > 0, "airlight without samples");
        if self.scattering == Vector3::zeros() || !(length > 0.0) {
            return Vector3::zeros();
        }
        lights.iter().map(|light| self.airlight_of(eye, direction, length, light, occluders, samples)).sum()
    }

    fn airlight_of(
        &self,
        eye: &Vector3<f64>,
        direction: &Vector3<f64>,
        length: f64,
        light: &LocalLight,
        occluders: Option<&Occluders>,
        samples: usize,
    ) -> Vector3<f64> {
        // The foot of the perpendicular from the lamp is at `foot` along the ray, and `away` from it.
        let to = light.centre() - eye;
        let foot = to.dot(direction);
        let away = (to - direction * foot).norm().max(1e-9 * to.norm()).max(f64::MIN_POSITIVE);
        let (first, last) = ((-foot).atan2(away), (length - foot).atan2(away));
        let step = (last - first) / samples as f64;
        let within = samples.div_ceil(8);
        let mut sum = Vector3::zeros();
        for i in 0..samples {
            let tangent = (first + (i as f64 + 0.5) * step).tan();
            let along = foot + away * tangent;
            let point = eye + direction * along;
            let mut scattered = Vector3::zeros();
            light.sample(&point, within, |part| {
                let hidden = occluders
                    .is_some_and(|o| o.any_hit_within(&point, &part.direction, part.distance * SHORT_OF_THE_LAMP));
                if !hidden {
                    let share = self.phase.eval(part.direction.dot(direction));
                    scattered += part.irradiance.component_mul(&self.transmittance(part.distance)) * share;
                }
            });
            let dt = away * (1.0 + tangent * tangent) * step;
            sum += scattered.component_mul(&self.transmittance(along)).component_mul(&self.scattering) * dt;
        }
        sum
    }
}

/// Rays to a lamp end a little before it, so that it does not hide itself where it is part of the scene.
pub(super) const SHORT_OF_THE_LAMP: f64 = 1.0 - 1e-6;
