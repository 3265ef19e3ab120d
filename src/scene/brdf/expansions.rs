//! Isotropic BRDFs as spherical harmonics, for every elevation of the viewer.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Vector3;

use super::Brdf;
use crate::error::check_length;
use crate::numeric::{CompensatedSum, GaussLegendre};
use crate::sh::Basis;
use crate::{Error, Result, parallel};

/// An isotropic BRDF times the cosine as expansions in the direction of the light, one for each elevation of a grid of
/// viewers: for glossy shading by harmonics.
///
/// ```math
/// c_lm(θ_o) = ∫ f(ω_i, ω_o) max(cos θ_i, 0) y_lm(ω_i) dω_i,  ω_o in the x–z plane
/// ```
///
/// Between the elevations, which are evenly spaced in θ_o from the normal to the horizon, coefficients are linear. A
/// viewer at azimuth φ sees the same turned about z: since f is its own mirror image in the plane of the viewer only
/// m ≥ 0 is stored, and (l, ±m) is c_lm {cos, sin} mφ.
///
/// The expansion of the incoming radiance in the frame of the surface (+z its normal), dotted with
/// [`eval`](Self::eval), is what the viewer sees.
///
/// Accuracy: what is cut off, [`truncation_errors`](Self::truncation_errors), and what lies between elevations,
/// [`interpolation_errors`](Self::interpolation_errors). Memory: 6 bands (bands + 1) bytes an elevation.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Vector3, scene::{BrdfExpansions, Lambert}};
/// let table = BrdfExpansions::new(&Lambert::new([0.5; 3])?, 3, 2, 32)?;
/// let [mut r, mut g, mut b] = [[0.0; 9]; 3];
/// table.eval(&Vector3::new(0.0, 0.6, 0.8), [&mut r, &mut g, &mut b]);
/// // Radiance 1 from everywhere: the albedo.
/// assert!((r[0] * (4.0 * std::f32::consts::PI).sqrt() - 0.5).abs() < 1e-6);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct BrdfExpansions {
    bands: usize,
    /// [elevation][channel][l(l+1)/2 + m]
    values: Vec<f32>,
    truncation: Vec<f64>,
    interpolation: Vec<f64>,
}

/// The height of the viewer that stands for the horizon, where BRDFs are 0 but have a limit.
const HORIZON: f64 = 1e-6;

impl BrdfExpansions {
    /// The table of a BRDF: `bands` bands for each of `elevations` viewers, by a quadrature of `rings` rings of 4 ·
    /// `rings` points on the hemisphere of the light.
    ///
    /// A lobe wants a few rings over its width: 64 for one of 5°, and more than `bands` in any case.
    /// Cost: 8 rings² values of the BRDF and as many evaluations of the basis for each elevation, in parallel.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is not in 1…32, `elevations` in 2…4096, `rings` in `bands`…1024, or the BRDF is
    /// not isotropic; [`Error::NotFinite`] if a value of it is.
    pub fn new(brdf: &(impl Brdf + ?Sized), bands: usize, elevations: usize, rings: usize) -> Result<Self> {
        let limits = [
            ("bands", bands, 1, 32, "1 to 32"),
            ("elevations of a table of expansions", elevations, 2, 4096, "2 to 4096"),
            ("rings of a quadrature", rings, bands, 1024, "at least the bands and at most 1024"),
            ("isotropy of a BRDF, 1 or 0", usize::from(brdf.is_isotropic()), 1, 1, "1"),
        ];
        for (what, got, least, most, allowed) in limits {
            if !(least..=most).contains(&got) {
                return Err(Error::OutOfRange { what, got: got as f64, allowed });
            }
        }
        let rule = Rule::new(bands, rings)?;
        // Elevations, and the middles between them.
        let count = 2 * elevations - 1;
        let views = parallel::map(count, |k| rule.project(brdf, FRAC_PI_2 * k as f64 / (count - 1) as f64));
        if let Some(index) = views.iter().position(|view| !view.energy.is_finite()) {
            return Err(Error::NotFinite { what: "BRDF, viewer", index });
        }
        let interpolation = views.windows(3).step_by(2).map(|three| three[1].distance(&three[0], &three[2]));
        Ok(Self {
            bands,
            interpolation: interpolation.collect(),
            truncation: views.iter().step_by(2).map(View::truncation).collect(),
            values: views.iter().step_by(2).flat_map(|view| &view.coefficients).map(|&c| c as f32).collect(),
        })
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// The number of elevations.
    pub fn elevations(&self) -> usize {
        self.truncation.len()
    }

    /// For the viewer of each elevation the L² norm of what the bands leave out over that of f cos θ_i, over all
    /// channels; 0 if that is black.
    pub fn truncation_errors(&self) -> &[f64] {
        &self.truncation
    }

    /// Half-way between two elevations: the L² norm of the difference of the interpolated expansion and the true one,
    /// over that of f cos θ_i.
    pub fn interpolation_errors(&self) -> &[f64] {
        &self.interpolation
    }

    /// The expansions of f(·, wo) max(cos θ_i, 0) in RGB, bands² coefficients each at index l(l+1) + m, in the local
    /// frame; 0 for a viewer below the horizon, NaN for one that is NaN.
    ///
    /// `wo` is a unit vector. Does not allocate.
    ///
    /// # Panics
    /// If an `out` is not bands² long.
    #[track_caller]
    pub fn eval(&self, wo: &Vector3<f32>, out: [&mut [f32]; 3]) {
        for out in &out {
            check_length("coefficients", self.bands * self.bands, out.len());
        }
        let sum = wo.sum();
        if !sum.is_finite() || wo.z <= 0.0 {
            return out.into_iter().for_each(|out| out.fill(if sum.is_finite() { 0.0 } else { f32::NAN }));
        }
        let across = wo.x.hypot(wo.y);
        let last = self.elevations() - 1;
        let at = across.atan2(wo.z) / std::f32::consts::FRAC_PI_2 * last as f32;
        let cell = (at as usize).min(last - 1);
        let t = at - cell as f32;
        let (cos, sin) = if across > 0.0 { (wo.x / across, wo.y / across) } else { (1.0, 0.0) };
        let size = self.bands * (self.bands + 1) / 2;
        for (channel, out) in out.into_iter().enumerate() {
            let [low, high] = [0, 1].map(|k| &self.values[((cell + k) * 3 + channel) * size..][..size]);
            // cos mφ and sin mφ.
            let (mut c, mut s) = (1.0, 0.0);
            for m in 0..self.bands {
                for l in m..self.bands {
                    let place = l * (l + 1) / 2 + m;
                    let value = low[place] + t * (high[place] - low[place]);
                    // For m = 0 the sine goes first, and is overwritten.
                    out[l * (l + 1) - m] = value * s;
                    out[l * (l + 1) + m] = value * c;
                }
                (c, s) = (c * cos - s * sin, c * sin + s * cos);
            }
        }
    }
}

/// What a viewer sees.
struct View {
    /// [channel][l(l+1)/2 + m]
    coefficients: Vec<f64>,
    /// ∫ (f cos θ_i)² over all channels.
    energy: f64,
}

impl View {
    fn truncation(&self) -> f64 {
        let kept: CompensatedSum = self.coefficients.iter().map(|c| c * c).collect();
        self.share(self.energy - kept.total())
    }

    /// How far the mean of two others is from this.
    fn distance(&self, before: &Self, after: &Self) -> f64 {
        let others = before.coefficients.iter().zip(&after.coefficients);
        self.share(self.coefficients.iter().zip(others).map(|(c, (a, b))| (0.5 * (a + b) - c).powi(2)).sum())
    }

    fn share(&self, squared: f64) -> f64 {
        if self.energy > 0.0 { (squared.max(0.0) / self.energy).sqrt() } else { 0.0 }
    }
}

/// Directions above the horizon with weights, and the harmonics of m ≥ 0 there.
struct Rule {
    size: usize,
    directions: Vec<(Vector3<f64>, f64)>,
    harmonics: Vec<f64>,
}

impl Rule {
    fn new(bands: usize, rings: usize) -> Result<Self> {
        let (gauss, basis) = (GaussLegendre::new(rings)?, Basis::<f64>::new(bands)?);
        let (around, mut y) = (4 * rings, vec![0.0; bands * bands]);
        let (mut directions, mut harmonics) = (Vec::new(), Vec::new());
        // Gauss's points in the square root of the height: they lie closer at the horizon, where BRDFs bend.
        for (x, weight) in gauss.nodes().iter().zip(gauss.weights()) {
            let root = 0.5 + 0.5 * x;
            let (z, weight) = (root * root, weight * root * 2.0 * PI / around as f64);
            let flat = ((1.0 - z) * (1.0 + z)).sqrt();
            for k in 0..around {
                let (sin, cos) = (2.0 * PI * (k as f64 + 0.5) / around as f64).sin_cos();
                let direction = Vector3::new(flat * cos, flat * sin, z);
                basis.eval(&direction, &mut y);
                harmonics.extend((0..bands).flat_map(|l| &y[l * (l + 1)..=l * (l + 2)]));
                directions.push((direction, weight));
            }
        }
        Ok(Self { size: bands * (bands + 1) / 2, directions, harmonics })
    }

    /// For a viewer in the x–z plane.
    fn project(&self, brdf: &(impl Brdf + ?Sized), elevation: f64) -> View {
        let z = elevation.cos().max(HORIZON);
        let wo = Vector3::new((1.0 - z * z).sqrt(), 0.0, z);
        let mut view = View { coefficients: vec![0.0; 3 * self.size], energy: 0.0 };
        for ((wi, weight), y) in self.directions.iter().zip(self.harmonics.chunks_exact(self.size)) {
            let value = brdf.eval(wi, &wo) * wi.z;
            view.energy += weight * value.norm_squared();
            for (channel, sums) in view.coefficients.chunks_exact_mut(self.size).enumerate() {
                let value = weight * value[channel];
                sums.iter_mut().zip(y).for_each(|(sum, y)| *sum += value * y);
            }
        }
        view
    }
}
