//! The logarithm of a disc's visibility, tabulated over its angle.

use nalgebra::{DMatrix, DVector, Vector3};

use super::piecewise::Piecewise;
use super::series::check_bands;
use super::zonal::{Zonal, cap_less_one};
use crate::error::check_length;
use crate::numeric::GaussLegendre;
use crate::sh::Basis;
use crate::{Error, Real, Result};

/// Which exp the logarithm of a disc is the inverse of.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum CapFit {
    /// exp by products: [`LogMethod::Eigenvalues`](super::LogMethod::Eigenvalues).
    Products {
        /// ε, as a share of the largest eigenvalue.
        floor: f64,
    },
    /// exp point by point: the f with ∫ exp(f) y_l = g_l, which exists for every angle and clips nothing. Up to a
    /// hemisphere.
    Grid,
}

impl Default for CapFit {
    /// Products, 0.02 of the largest.
    fn default() -> Self {
        Self::Products { floor: 0.02 }
    }
}

/// The logarithm of the visibility of a disc that hides what is within the angle θ of the z axis, for any θ.
///
/// ```math
/// f(θ) = log g(θ),  g_0 = √π (1 + cos θ),  g_l = −2π K_l (P_{l−1} − P_{l+1})(cos θ)/(2l+1)     [Sun 2008, eq. 5.36]
/// ```
///
/// It is zonal: n coefficients (l, 0), to be turned to the disc's direction; logarithms of several discs add up.
/// Tabulated is f_l/(1 − cos θ), which is finite at θ = 0, in pieces that end where f has a kink: where the clipping of
/// an eigenvalue sets in (1.13, 0.854, 0.571 for bands 3, 4, 6) and where another one follows.
///
/// Accuracy: the table is within 2e-6 (1 − cos θ) of the logarithm ([`CapFit::Grid`]: 2e-5). Cost: 16 multiplications a
/// coefficient. Range: θ is taken as 0 if less and as [`largest`](Self::largest) if more; spheres seen from outside are
/// below π/2.
///
/// # Example
/// ```
/// use haarmonic::sh::{CapFit, CapLog};
/// let log = CapLog::new(4, CapFit::default())?;
/// let mut f = [0.0f32; 4];
/// log.eval(0.1, &mut f);
/// assert!((f[0] + 0.00903136).abs() < 1e-7);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct CapLog {
    bands: usize,
    table: Piecewise,
    /// The angles between 0 and the largest at which f has a kink.
    kinks: Vec<f64>,
    error: f64,
}

impl CapLog {
    /// The largest angle of [`CapFit::Products`]: with more only a hole of less than 37° about −z is left.
    pub const LARGEST: f64 = 2.5;

    /// The largest angle of the table: [`LARGEST`](Self::LARGEST), or π/2 for [`CapFit::Grid`].
    pub fn largest(&self) -> f64 {
        self.table.end()
    }

    /// The table of `bands`. Cost, measured on one core: 3 ms at 4 bands, 0.03 s at 8, 0.5 s at 16, 7 s at 32; it grows
    /// as bands⁴.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is not in 1…32 (1…8 for [`CapFit::Grid`]), or the floor is not above 0 and
    /// below 1.
    pub fn new(bands: usize, fit: CapFit) -> Result<Self> {
        check_bands(bands)?;
        let over = |log: Vec<f64>, theta: f64| {
            let half = (0.5 * theta).sin();
            log.into_iter().map(|f| f / (2.0 * half * half)).collect()
        };
        let (kinks, (table, error)) = match fit {
            CapFit::Products { floor } => {
                if !(floor > 0.0 && floor < 1.0) {
                    let allowed = "above 0 and below 1";
                    return Err(Error::OutOfRange { what: "floor of the logarithm", got: floor, allowed });
                }
                let zonal = Zonal::new(bands)?;
                let kinks = zonal.cap_kinks(Self::LARGEST, floor)?;
                let ends = [&[0.0], &kinks[..], &[Self::LARGEST]].concat();
                let log = |theta| Ok(over(zonal.log(&cap_less_one(bands, theta)?, 1.0, floor)?.log, theta));
                (kinks, Piecewise::fit(bands, &ends, TOLERANCE, log)?)
            }
            CapFit::Grid => {
                let density = Density::new(bands)?;
                let log = |theta| Ok(over(density.fit(&cap_less_one(bands, theta)?)?, theta));
                (Vec::new(), Piecewise::fit(bands, &[0.0, std::f64::consts::FRAC_PI_2], GRID_TOLERANCE, log)?)
            }
        };
        Ok(Self { bands, table, kinks, error })
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// The angles, ascending between 0 and [`largest`](Self::largest), at which f(θ) has a kink: where an eigenvalue
    /// begins or ceases to be clipped.
    pub fn kinks(&self) -> &[f64] {
        &self.kinks
    }

    /// The largest difference between the table and what it tabulates, f_l/(1 − cos θ), at the points where that was
    /// tried.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// The number of pieces of the table, each with 8 numbers for each band.
    pub fn pieces(&self) -> usize {
        self.table.breaks().len() - 1
    }

    /// The zonal coefficients (l, 0) of f(θ), one for each band. NaN gives NaN.
    ///
    /// # Panics
    /// If `out.len()` is not the number of bands.
    #[track_caller]
    pub fn eval<T: Real>(&self, theta: T, out: &mut [T]) {
        check_length("zonal coefficients", self.bands, out.len());
        let theta = theta.widen();
        let theta = if theta < 0.0 { 0.0 } else { theta };
        let theta = if theta > self.table.end() { self.table.end() } else { theta };
        let half = (0.5 * theta).sin();
        let mut values = [0.0; 32];
        self.table.eval(theta, &mut values[..self.bands]);
        for (out, value) in out.iter_mut().zip(values) {
            *out = T::of(value * (2.0 * half * half));
        }
    }
}

/// How far f_l/(1 − cos θ) may be from its polynomial.
const TOLERANCE: f64 = 1e-6;
/// The same for fits: f is in the dozens where hardly anything depends on it, and is known the less.
const GRID_TOLERANCE: f64 = 1e-5;

/// Positive densities exp(Σ f_l y_{l,0}) with given moments.
struct Density {
    bands: usize,
    /// y_{l,0} at each node, then the weight.
    nodes: Vec<(Vec<f64>, f64)>,
}

impl Density {
    fn new(bands: usize) -> Result<Self> {
        const MOST: usize = 8;
        if bands > MOST {
            return Err(Error::OutOfRange { what: "bands", got: bands as f64, allowed: "1 to 8 for a fit on a grid" });
        }
        let (basis, gauss) = (Basis::<f64>::new(bands)?, GaussLegendre::new(64)?);
        let mut all = vec![0.0; bands * bands];
        let node = |(&z, &weight): (&f64, &f64)| {
            basis.eval(&Vector3::new((1.0 - z * z).sqrt(), 0.0, z), &mut all);
            ((0..bands).map(|l| all[l * l + l]).collect(), weight * 2.0 * std::f64::consts::PI)
        };
        Ok(Self { bands, nodes: gauss.nodes().iter().zip(gauss.weights()).map(node).collect() })
    }

    /// The f with ∫ (exp(f) − 1) y_l = `less_one`.
    ///
    /// It is the minimum of ∫ exp(f) − f·g, which is convex and has one for every g of a bounded function that is
    /// positive somewhere (the maximum-entropy problem); Newton's steps, shortened far from it.
    fn fit(&self, less_one: &[f64]) -> Result<Vec<f64>> {
        const STEPS: usize = 400;
        let mut f = DVector::<f64>::zeros(self.bands);
        let size = less_one.iter().map(|g| g.abs()).fold(0.0, f64::max);
        let mut best = f64::INFINITY;
        for _ in 0..STEPS {
            let (gradient, hessian) = self.derivatives(&f, less_one);
            let failed = || Error::OutOfRange {
                what: "moment of a density",
                got: gradient[0],
                allowed: "that of a positive one",
            };
            let step = hessian.cholesky().ok_or_else(failed)?.solve(&gradient);
            let decrement = gradient.dot(&step).max(0.0).sqrt();
            let residual = gradient.amax();
            if residual <= 1e-15 * size || (decrement < 1e-6 && residual >= best) {
                return Ok(f.as_slice().to_vec());
            }
            best = best.min(residual);
            f -= step * if decrement < 0.25 { 1.0 } else { 1.0 / (1.0 + decrement) };
        }
        Err(Error::OutOfRange { what: "steps of a fit", got: STEPS as f64, allowed: "fewer" })
    }

    fn derivatives(&self, f: &DVector<f64>, less_one: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let mut gradient = -DVector::from_column_slice(less_one);
        let mut hessian = DMatrix::zeros(self.bands, self.bands);
        for (y, weight) in &self.nodes {
            let value: f64 = y.iter().zip(f.iter()).map(|(y, f)| y * f).sum();
            let (less_one, density) = (weight * value.exp_m1(), weight * value.exp());
            for l in 0..self.bands {
                gradient[l] += less_one * y[l];
                for k in 0..self.bands {
                    hessian[(l, k)] += density * y[l] * y[k];
                }
            }
        }
        (gradient, hessian)
    }
}
