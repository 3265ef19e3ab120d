//! Functions of the angle to an axis.

mod factors;
mod von_mises_fisher;

use nalgebra::Vector3;

pub(super) use factors::CapFactors;
pub use von_mises_fisher::VonMisesFisher;

use super::Basis;
use crate::approx_eq::approx_by_parts;
use crate::error::check_length;
use crate::numeric::{GaussLegendre, LegendreSteps, legendre_all};
use crate::{Error, Real, Result};

/// A function f(cos θ) of the angle to an axis, in `bands` numbers.
///
/// The same data has two scales, and mixing them is the usual mistake. This type holds the first and gives the second:
///
/// ```text
/// factors       k_l = 2π ∫ f(t) P_l(t) dt over −1 ≤ t ≤ 1
/// coefficients  z_l = √((2l+1)/4π) k_l
/// ```
///
/// With factors, convolution multiplies degree l by k_l, and f about an axis is the expansion `k_l y_lm(axis)`. With
/// coefficients, f about +z is `Σ z_l y_{l,0}`.
///
/// (A paper's Â_l, ρ̂_l and A_l are factors; its f_l and g_l are coefficients [Sun 2008, eqs. 2.20, 5.7, 5.36].) Both
/// rules for the factors are the Funk–Hecke theorem. Built in `f64`, then narrowed.
///
/// # Example
/// ```
/// use haarmonic::sh::Zonal;
/// // Irradiance from radiance: π, 2π/3, π/4 by degree.
/// let cosine = Zonal::<f64>::clamped_cosine(3)?;
/// assert_eq!(cosine.factors(), [1.0, 2.0 / 3.0, 0.25].map(|x| x * std::f64::consts::PI));
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Zonal<T> {
    factors: Vec<T>,
}

/// √((2l+1)/4π): the coefficient of degree l over its factor.
fn coefficient_over_factor(l: usize) -> f64 {
    ((2 * l + 1) as f64 / (4.0 * std::f64::consts::PI)).sqrt()
}

fn check_bands(bands: usize) -> Result<()> {
    if (1..=MAX_BANDS).contains(&bands) {
        Ok(())
    } else {
        Err(Error::OutOfRange { what: "bands of a zonal function", got: bands as f64, allowed: "1 to 65536" })
    }
}

/// The most degrees: those of a lobe of 1e-4 rad.
const MAX_BANDS: usize = 1 << 16;

impl<T: Real> Zonal<T> {
    /// From factors k_l.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for none, or more than 65536.
    pub fn from_factors(factors: impl IntoIterator<Item = T>) -> Result<Self> {
        // One more than is allowed shows that there are too many, without end if they have none.
        let factors: Vec<T> = factors.into_iter().take(MAX_BANDS + 1).collect();
        check_bands(factors.len())?;
        Ok(Self { factors })
    }

    /// From coefficients z_l with respect to y_{l,0}.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for none, or more than 65536.
    pub fn from_coefficients(coefficients: impl IntoIterator<Item = T>) -> Result<Self> {
        let scaled = coefficients.into_iter().enumerate();
        Self::from_factors(scaled.map(|(l, z)| T::of(z.widen() / coefficient_over_factor(l))))
    }

    /// From `f64` factors, without end: the first `bands`.
    fn take(bands: usize, factors: impl Iterator<Item = f64>) -> Result<Self> {
        check_bands(bands)?;
        Self::from_factors(factors.take(bands).map(T::of))
    }

    /// The projection of f(t), t = cos θ, by Gauss–Legendre rules of `nodes` points on the pieces of [−1, 1] between
    /// `breaks`.
    ///
    /// Exact up to rounding where f is a polynomial of degree 2·nodes − bands on each piece; a kink or jump belongs at
    /// a break.
    /// Accuracy there: 1e-14 of max |f|. Allocates.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is 0 or above 65536, [`Error::Empty`] if `nodes` is, and [`Error::OutOfRange`]
    /// unless the breaks ascend strictly inside (−1, 1).
    ///
    /// # Example
    /// ```
    /// use haarmonic::sh::Zonal;
    /// let by_quadrature = Zonal::<f64>::project(6, 4, &[0.0], |t| t.max(0.0))?;
    /// approx::assert_abs_diff_eq!(by_quadrature, Zonal::clamped_cosine(6)?, epsilon = 1e-15);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn project(bands: usize, nodes: usize, breaks: &[f64], mut f: impl FnMut(f64) -> f64) -> Result<Self> {
        check_bands(bands)?;
        let rule = GaussLegendre::new(nodes)?;
        let (mut sums, mut p) = (vec![0.0; bands], vec![0.0; bands]);
        let mut from = -1.0;
        for &to in breaks.iter().chain([&1.0]) {
            if !(from < to && to <= 1.0) {
                return Err(Error::OutOfRange {
                    what: "break of a zonal function",
                    got: to,
                    allowed: "ascending in (−1, 1)",
                });
            }
            let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
            for (x, w) in rule.nodes().iter().zip(rule.weights()) {
                let t = middle + half * x;
                let weighted = 2.0 * std::f64::consts::PI * half * w * f(t);
                legendre_all(t, &mut p);
                sums.iter_mut().zip(&p).for_each(|(sum, p)| *sum += weighted * p);
            }
            from = to;
        }
        Self::from_factors(sums.into_iter().map(T::of))
    }

    /// The delta: ∫ f = 1, all of it on the axis. Every factor is 1.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is 0 or above 65536.
    pub fn delta(bands: usize) -> Result<Self> {
        Self::take(bands, std::iter::repeat(1.0))
    }

    /// max(cos θ, 0): the kernel that turns radiance into irradiance, π included.
    ///
    /// ```math
    /// Â_0 = π, Â_1 = 2π/3, Â_l = 0 for odd l > 1, else
    /// Â_l = 2π (−1)^{l/2−1} / ((l+2)(l−1)) · l!/(2^l (l/2)!²)                           [Sun 2008, eqs. 2.21–2.23]
    /// ```
    ///
    /// The size falls as l^{−5/2}, and Â_4 is negative (docs/errata.md). Accuracy: relative, 5e-16 below 12 bands,
    /// 4e-15 below 100.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is 0 or above 65536.
    pub fn clamped_cosine(bands: usize) -> Result<Self> {
        Self::cosine_power(bands, 1.0)
    }

    /// max(cos θ, 0)^s for real s ≥ 0: the Phong lobe; s = 0 is the hemisphere, large s tends to 2π/(s+1) times the
    /// delta.
    ///
    /// Not normalised: k_0 = ∫ f = 2π/(s+1), and (s+2)/2π · f reflects all light at normal incidence from a plane.
    ///
    /// ```math
    /// ∫_0^1 t^s P_l dt: 1/(s+1), 1/(s+2), then two degrees up times (s − l)/(s + l + 3)
    /// ```
    ///
    /// which is the ratio of Γ functions of the closed form [Gradshteyn & Ryzhik 7.126.1]. For integer s the zeros are
    /// exact.
    /// Accuracy: relative, 5e-16 below 12 bands, 4e-15 below 100. (Sun's 2.19 means this lobe: the max is missing in
    /// print.)
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is 0 or above 65536, or unless 0 ≤ `power` < ∞.
    pub fn cosine_power(bands: usize, power: f64) -> Result<Self> {
        if !(0.0..f64::INFINITY).contains(&power) {
            return Err(Error::OutOfRange { what: "power of a cosine", got: power, allowed: "in [0, ∞)" });
        }
        Self::take(bands, factors::cosine_power(power))
    }

    /// 1 within `half_angle` radians of the axis, 0 beyond: a cone or disc of light.
    ///
    /// ```math
    /// k_0 = 2π (1 − cos θ),  k_l = 2π sin²θ P_l′(cos θ)/(l(l+1))
    /// ```
    ///
    /// No difference of large numbers: relative accuracy for caps of any size down to nothing, 1e-15 below 12 bands. An
    /// angle below 0 counts as 0, one above π as π; NaN gives NaN.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is 0 or above 65536.
    ///
    /// # Example
    /// ```
    /// let sun = haarmonic::sh::Zonal::<f64>::cap(3, 0.00465)?;
    /// assert!((sun.factors()[0] / 6.793e-5 - 1.0).abs() < 1e-4); // its solid angle, steradians
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn cap(bands: usize, half_angle: f64) -> Result<Self> {
        Self::take(bands, CapFactors::from_half_angle(half_angle))
    }

    /// 0 within `half_angle` of the axis, 1 beyond: what a round blocker leaves visible [Sun 2008, eq. 5.36].
    ///
    /// The coefficients are g_0 = √π (1 + cos θ), g_l = −2π N_{l0} (P_{l−1} − P_{l+1})(cos θ)/(2l+1), computed as those
    /// of [`cap`](Self::cap): with relative accuracy at both ends. Angles likewise.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is 0 or above 65536.
    pub fn outside_cap(bands: usize, half_angle: f64) -> Result<Self> {
        Self::take(bands, CapFactors::from_half_angle(half_angle).complement())
    }

    /// A [`VonMisesFisher`] density, ∫ f = 1: the factors A_l.
    ///
    /// Accuracy: relative, 6e-16 below 12 bands, 3e-15 below 100, for κ from 0 to ∞.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is 0 or above 65536.
    pub fn von_mises_fisher(bands: usize, density: &VonMisesFisher) -> Result<Self> {
        check_bands(bands)?;
        let mut factors = vec![0.0; bands];
        density.factors(&mut factors);
        Self::from_factors(factors.into_iter().map(T::of))
    }

    /// The number of bands.
    #[inline]
    pub fn bands(&self) -> usize {
        self.factors.len()
    }

    /// The factors k_l.
    #[inline]
    pub fn factors(&self) -> &[T] {
        &self.factors
    }

    /// The factors, to write.
    #[inline]
    pub fn factors_mut(&mut self) -> &mut [T] {
        &mut self.factors
    }

    /// The coefficients z_l with respect to y_{l,0}.
    pub fn coefficients(&self) -> Vec<T> {
        let scaled = self.factors.iter().enumerate();
        scaled.map(|(l, k)| T::of(k.widen() * coefficient_over_factor(l))).collect()
    }

    /// This function times `weight`.
    pub fn scaled(mut self, weight: T) -> Self {
        self.factors.iter_mut().for_each(|k| *k *= weight);
        self
    }

    /// f where the angle to the axis has this cosine.
    ///
    /// ```math
    /// f(t) = Σ (2l+1)/4π k_l P_l(t)
    /// ```
    pub fn eval(&self, cosine: T) -> T {
        let mut steps = LegendreSteps::new(cosine.widen());
        let mut sum = 0.0;
        for (l, k) in self.factors.iter().enumerate() {
            sum += (2 * l + 1) as f64 * k.widen() * steps.value();
            steps.advance();
        }
        let sum = 0.25 / std::f64::consts::PI * sum;
        T::of(sum)
    }

    /// The coefficients of f about any axis: that is its rotation [Sloan 2005].
    ///
    /// ```math
    /// f_lm = k_l y_lm(axis)
    /// ```
    ///
    /// `axis` is a unit vector. Cost: one evaluation of the basis and bands² multiplications.
    ///
    /// # Panics
    /// If the bands of `basis` differ or `out.len()` is not bands².
    #[track_caller]
    pub fn about(&self, basis: &Basis<T>, axis: &Vector3<T>, out: &mut [T]) {
        check_length("bands of the basis", self.bands(), basis.bands());
        basis.eval(axis, out);
        self.convolve(out);
    }

    /// Adds f about an axis to any number of channels, each with its own weight: `out` is (weight, coefficients).
    ///
    /// # Panics
    /// If the bands of `basis` differ, or a slice of coefficients or `scratch` is not bands² long.
    ///
    /// # Example
    /// ```
    /// use haarmonic::{nalgebra::Vector3, sh::{Basis, Zonal}};
    /// let (basis, lamp) = (Basis::<f32>::new(2)?, Zonal::cap(2, 0.2)?);
    /// let ([mut r, mut g, mut b], mut scratch) = ([[0.0; 4]; 3], [0.0; 4]);
    /// let rgb = [(3.0, &mut r[..]), (2.0, &mut g[..]), (1.0, &mut b[..])];
    /// lamp.add_about(&basis, &Vector3::z(), rgb, &mut scratch);
    /// assert!(r[2] == 3.0 * b[2] && b[2] > 0.0 && r[1] == 0.0);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    #[track_caller]
    pub fn add_about<const C: usize>(
        &self,
        basis: &Basis<T>,
        axis: &Vector3<T>,
        out: [(T, &mut [T]); C],
        scratch: &mut [T],
    ) {
        self.about(basis, axis, scratch);
        for (weight, out) in out {
            check_length("coefficients", scratch.len(), out.len());
            out.iter_mut().zip(&*scratch).for_each(|(out, y)| *out += weight * *y);
        }
    }

    /// f about many axes, coefficient-major: coefficient i of axis v at i·count + v. The same bits as
    /// [`about`](Self::about).
    ///
    /// # Panics
    /// If the bands of `basis` differ, the slices of axes do, or `out.len()` is not bands² times their length.
    #[track_caller]
    pub fn about_batch(&self, basis: &Basis<T>, [x, y, z]: [&[T]; 3], out: &mut [T]) {
        check_length("bands of the basis", self.bands(), basis.bands());
        basis.eval_batch(x, y, z, out);
        self.convolve_batch(x.len(), out);
    }

    /// Convolves an expansion with f, in place: degree l times k_l.
    ///
    /// ```math
    /// (f ∗ L)(n) = ∫ f(n · ω) L(ω) dω
    /// ```
    ///
    /// Irradiance from radiance is this with [`clamped_cosine`](Self::clamped_cosine); so is the effective BRDF of a
    /// filtered normal map, from the expansion of its distribution of normals [Sun 2008, eq. 5.7].
    ///
    /// # Panics
    /// If `coefficients.len()` is not bands².
    #[track_caller]
    pub fn convolve(&self, coefficients: &mut [T]) {
        self.convolve_batch(1, coefficients);
    }

    /// Convolves `count` expansions, coefficient-major: coefficient i of vector v at i·count + v.
    ///
    /// # Panics
    /// If `coefficients.len()` is not count · bands².
    #[track_caller]
    pub fn convolve_batch(&self, count: usize, coefficients: &mut [T]) {
        check_length("coefficients", (self.bands() * self.bands()).saturating_mul(count), coefficients.len());
        let mut rest = coefficients;
        for (l, &k) in self.factors.iter().enumerate() {
            let (degree, above) = rest.split_at_mut((2 * l + 1) * count);
            degree.iter_mut().for_each(|c| *c *= k);
            rest = above;
        }
    }
}

approx_by_parts!([T] Zonal<T>, T, |z| close [&z.factors] same []);
