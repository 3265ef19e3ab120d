//! Light as coefficients.

mod diffuse;
mod irradiance;
mod polygon;

use nalgebra::Vector3;

pub use diffuse::{DiffuseLight, DiffuseLightTable};
pub use irradiance::Irradiance;
pub use polygon::{PolygonLight, PolygonScratch, Sides};

use super::zonal::CapFactors;
use super::{Basis, Zonal};
use crate::error::check_length;
use crate::{Real, Result};

/// A light of a simple shape, seen from a point at the origin: where it is, not how bright.
///
/// Directions and axes are unit vectors towards the light.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Light<T> {
    /// The same radiance from everywhere.
    Ambient,
    /// All light from one direction.
    Directional {
        /// Towards the light.
        direction: Vector3<T>,
    },
    /// Constant radiance within a cone: the sun's disc, a spot on the sky.
    Cone {
        /// The middle.
        axis: Vector3<T>,
        /// From the middle to the rim, radians; below 0 counts as 0, above π as π.
        half_angle: T,
    },
    /// A glowing sphere: [`Cone`](Self::Cone) of sin θ = radius/distance.
    ///
    /// At and within its surface: the hemisphere towards the centre. At the centre itself there is no direction, and
    /// the degrees above 0 are 0.
    Sphere {
        /// From the point to the centre, any length.
        centre: Vector3<T>,
        /// Its radius; below 0 counts as 0.
        radius: T,
    },
    /// Constant radiance on one side of a plane, 0 on the other: a sky. A ground is another one, of −`up`.
    Hemisphere {
        /// The middle.
        up: Vector3<T>,
    },
    /// Radiance that falls linearly with the height, (1 + up·ω)/2 of that at `up`: a soft sky. A ground is another one,
    /// of −`up`.
    Gradient {
        /// Where it is brightest.
        up: Vector3<T>,
    },
}

/// What a light's intensity means.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Measure {
    /// Radiance (of [`Gradient`](Light::Gradient): at its brightest); of a directional light, which has none,
    /// irradiance on a plane that faces it.
    #[default]
    Radiance,
    /// Irradiance on a plane that faces the light, ∫ L max(cos, 0) dω, whatever its size: a cone that closes becomes
    /// the directional light.
    ///
    /// That is the light's own irradiance. What is left of it in few bands differs: of a directional light 2 bands show
    /// ¾, 3 show 17/16, 5 show 31/32.
    FacingIrradiance,
    /// The scale of DirectXMath's `XMSHEval…Light`, so that colours written for it can be kept.
    ///
    /// | theirs | ours | its radiance or irradiance is the colour times |
    /// |---|---|---|
    /// | `Directional` | `Directional` | π over the share shown by the bands (¾, 17/16, 31/32…): white reflects the colour |
    /// | `Cone` | `Cone` | 1/sin²θ, at most 90°: irradiance π. It does not become their directional light, by that share |
    /// | `Spherical` | `Sphere` | 1 |
    /// | `Hemisphere` | `Gradient`, one each for top and bottom | 3/2; white under a white top reflects 5/4, not the 1 of their comment |
    ///
    /// `Ambient` and `Hemisphere` have no counterpart and keep radiance. Signs still differ: theirs have (−1)^m
    /// ([`Convention`](super::Convention)).
    DirectXMath,
}

/// Coefficients of [`Light`]s, built once for a number of bands.
///
/// Shapes: bands² coefficients a channel; 1, 3 or any number of channels. Units: coefficients are radiance · sr;
/// irradiance is the convolution with [`Zonal::clamped_cosine`], π included.
/// Accuracy: that of the basis. Calls do not allocate.
///
/// # Example
/// ```
/// use haarmonic::nalgebra::Vector3;
/// use haarmonic::sh::{Irradiance, Light, Lights, Measure};
/// let lights = Lights::<f64>::new(3)?.with_measure(Measure::FacingIrradiance);
/// let mut sun = [0.0; 9];
/// lights.eval(&Light::Cone { axis: Vector3::z(), half_angle: 0.3 }, [2.0], [&mut sun]);
/// let [shown] = Irradiance::new([&sun]).eval(&Vector3::z());
/// assert!((shown / 2.0 - 1.06).abs() < 0.01); // 17/16 for a point, 1 for a hemisphere
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Lights<T> {
    basis: Basis<T>,
    measure: Measure,
    /// π over the share of a directional light's irradiance that the bands show.
    directional: f64,
}

impl<T: Real> Lights<T> {
    /// A plan for lights of `bands` bands whose intensity is radiance.
    ///
    /// # Errors
    /// As [`Basis::new`].
    pub fn new(bands: usize) -> Result<Self> {
        let basis = Basis::new(bands)?;
        let directional = std::f64::consts::PI / Zonal::<f64>::clamped_cosine(bands)?.eval(1.0);
        Ok(Self { basis, measure: Measure::default(), directional })
    }

    /// The same with another measure.
    pub fn with_measure(mut self, measure: Measure) -> Self {
        self.measure = measure;
        self
    }

    /// The number of bands.
    #[inline]
    pub fn bands(&self) -> usize {
        self.basis.bands()
    }

    /// What an intensity means.
    #[inline]
    pub fn measure(&self) -> Measure {
        self.measure
    }

    /// The coefficients of a light of this intensity, a slice for each channel.
    ///
    /// # Panics
    /// If an `out` is not bands² long.
    #[track_caller]
    pub fn eval<const C: usize>(&self, light: &Light<T>, intensity: [T; C], mut out: [&mut [T]; C]) {
        let Some((first, rest)) = out.split_first_mut() else { return };
        self.unit(light, first);
        for (out, &intensity) in rest.iter_mut().zip(&intensity[1..]) {
            check_length("coefficients", first.len(), out.len());
            out.iter_mut().zip(&**first).for_each(|(out, y)| *out = *y * intensity);
        }
        first.iter_mut().for_each(|y| *y *= intensity[0]);
    }

    /// Adds a light to coefficients, each slice with its intensity: `out` is (intensity, coefficients).
    ///
    /// # Panics
    /// If a slice of coefficients or `scratch` is not bands² long.
    #[track_caller]
    pub fn add<const C: usize>(&self, light: &Light<T>, out: [(T, &mut [T]); C], scratch: &mut [T]) {
        self.unit(light, scratch);
        for (intensity, out) in out {
            check_length("coefficients", scratch.len(), out.len());
            out.iter_mut().zip(&*scratch).for_each(|(out, y)| *out += intensity * *y);
        }
    }

    /// The light of intensity 1.
    #[track_caller]
    fn unit(&self, light: &Light<T>, out: &mut [T]) {
        check_length("coefficients", self.basis.coefficient_count(), out.len());
        let facing = self.measure != Measure::Radiance;
        let theirs = self.measure == Measure::DirectXMath;
        match *light {
            Light::Ambient => {
                let radiance =
                    if self.measure == Measure::FacingIrradiance { std::f64::consts::FRAC_1_PI } else { 1.0 };
                out.fill(T::zero());
                out[0] = T::of(radiance * (4.0 * std::f64::consts::PI).sqrt());
            }
            Light::Directional { direction } => {
                let scale = if theirs { self.directional } else { 1.0 };
                self.about(&direction, std::iter::repeat(scale), out);
            }
            Light::Cone { axis, half_angle } => {
                self.cone(&axis, half_angle.widen(), facing, if theirs { std::f64::consts::PI } else { 1.0 }, out);
            }
            Light::Sphere { centre, radius } => self.sphere(&centre, radius, facing && !theirs, out),
            Light::Hemisphere { up } => {
                self.cone(&up, std::f64::consts::FRAC_PI_2, facing && !theirs, 1.0, out);
            }
            Light::Gradient { up } => {
                let radiance = match self.measure {
                    Measure::Radiance => 1.0,
                    // ∫ (1 + t)/2 t over the upper half: π (1/2 + 1/3).
                    Measure::FacingIrradiance => 1.2 * std::f64::consts::FRAC_1_PI,
                    Measure::DirectXMath => 1.5,
                };
                // (1 + t)/2: 2π ∫ over [−1, 1], and with t.
                let factors = [2.0, 2.0 / 3.0].map(|k| std::f64::consts::PI * k * radiance);
                self.about(&up, factors.into_iter().chain(std::iter::repeat(0.0)), out);
            }
        }
    }

    #[track_caller]
    fn cone(&self, axis: &Vector3<T>, half_angle: f64, facing: bool, scale: f64, out: &mut [T]) {
        let cap = CapFactors::from_half_angle(half_angle);
        if facing && half_angle <= std::f64::consts::FRAC_PI_2 {
            self.about(axis, cap.per_facing_irradiance().map(|k| k * scale), out);
        } else {
            // Beyond the hemisphere nothing is added to the irradiance, π.
            let scale = if facing { scale * std::f64::consts::FRAC_1_PI } else { scale };
            self.about(axis, cap.map(|k| k * scale), out);
        }
    }

    #[track_caller]
    fn sphere(&self, centre: &Vector3<T>, radius: T, facing: bool, out: &mut [T]) {
        let (mut centre, mut radius) = (centre.map(T::widen), radius.widen());
        if centre.amax() > 1e300 {
            // Only their quotient matters, and its root must not overflow.
            (centre, radius) = (centre * 0.25, radius * 0.25);
        }
        let distance = centre.x.hypot(centre.y).hypot(centre.z);
        // clamp keeps NaN; at the centre the quotient may be one that the arguments are not.
        let sine = if distance == 0.0 { 1.0 } else { (radius / distance).clamp(0.0, 1.0) };
        let axis = if distance == 0.0 { Vector3::z() } else { centre.map(|c| T::of(c / distance)) };
        let cap = CapFactors::from_sine(sine);
        if facing {
            self.about(&axis, cap.per_facing_irradiance(), out);
        } else {
            self.about(&axis, cap, out);
        }
        if distance == 0.0 {
            out[1..].fill(T::zero());
        }
    }

    /// f_lm = k_l y_lm(axis).
    #[track_caller]
    fn about(&self, axis: &Vector3<T>, factors: impl Iterator<Item = f64>, out: &mut [T]) {
        self.basis.eval(axis, out);
        let mut rest = out;
        for (l, k) in (0..self.basis.bands()).zip(factors) {
            let (degree, above) = rest.split_at_mut(2 * l + 1);
            let k = T::of(k);
            degree.iter_mut().for_each(|y| *y *= k);
            rest = above;
        }
    }
}
