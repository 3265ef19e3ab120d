//! The optimal linear approximation of exp.

use super::optimal_linear_table as committed;
use super::piecewise::Piecewise;
use super::series::check_bands;
use super::zonal::{Zonal, cap_less_one};
use crate::{Error, Result};

/// The floor of the logarithms of the discs.
const FLOOR: f64 = 0.02;
/// The largest disc: a hemisphere.
const LARGEST: f64 = std::f64::consts::FRAC_PI_2;
/// How far the tables may be from what they tabulate.
const TOLERANCE: f64 = 1e-6;

/// exp(f) ≈ e^{f_0/√4π} (a·1 + b f̂) with the a and b that are best for a single disc with the same ‖f̂‖.
///
///   a = (exp_*(f̂)·1)/4π,  b = (exp_*(f̂)·f̂)/‖f̂‖²,  f = log of a disc's visibility, f̂ = f without f_0
///
/// (Not in the thesis, which names it only: see docs/errata.md.) The least-squares fit to exp_*(f̂) = exp(M_f̂)·1, as 1·f̂ = 0. Tabulated over the angle of
/// the disc, 0 to a right angle, against x = ‖f̂‖; logarithms by eigenvalues with floor 0.02. Beyond the largest disc's x, a and b
/// stay what they are there.
///
/// Accuracy: the tables' polynomials are within 2e-6 of what they tabulate. The method itself: use it for x ≲ 1, or as the
/// seed of [`ExpMethod::Hybrid`](super::ExpMethod::Hybrid).
///
/// # Example
/// ```
/// let linear = haarmonic::sh::OptimalLinear::new(4)?;
/// let [a, b] = linear.factors(1.0);
/// assert!((a - 1.03344).abs() < 1e-4 && (b - 0.77343).abs() < 1e-4);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct OptimalLinear {
    bands: usize,
    table: Piecewise,
}

impl OptimalLinear {
    /// The tables of `bands`: those of the crate for 2 to 8, otherwise [`fit`](Self::fit).
    ///
    /// # Errors
    /// As [`fit`](Self::fit).
    pub fn new(bands: usize) -> Result<Self> {
        match committed::TABLES.get(bands.wrapping_sub(2)) {
            Some((breaks, terms)) => Ok(Self { bands, table: Piecewise::committed(2, breaks, terms) }),
            None => Self::fit(bands),
        }
    }

    /// Fits the tables: what the crate's were made by.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is not in 1…32.
    pub fn fit(bands: usize) -> Result<Self> {
        check_bands(bands)?;
        if bands == 1 {
            // f̂ is 0.
            let ones = [vec![1.0; 2], vec![0.0; 14]].concat();
            return Ok(Self { bands, table: Piecewise::owned(2, vec![0.0, 1.0], ones) });
        }
        let discs = Discs { zonal: Zonal::new(bands)? };
        let mut angles = vec![0.0];
        angles.extend(discs.rising()?);
        // (x, a, b) against θ first; x rises, so that its inverse is found on the table.
        let (by_angle, _) = Piecewise::fit(3, &angles, 0.01 * TOLERANCE, |theta| discs.optimum(theta))?;
        let at_angle = |theta: f64| {
            let mut out = [0.0; 3];
            by_angle.eval(theta, &mut out);
            out
        };
        let mut breaks: Vec<f64> = angles.iter().map(|&theta| at_angle(theta)[0]).collect();
        breaks[0] = 0.0;
        let (table, _) = Piecewise::fit(2, &breaks, TOLERANCE, |x| {
            let (mut low, mut high) = (0.0, *angles.last().expect("0 at least"));
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if at_angle(middle)[0] < x { low = middle } else { high = middle }
            }
            Ok(at_angle(0.5 * (low + high))[1..].to_vec())
        })?;
        Ok(Self { bands, table })
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// The largest ‖f̂‖ that was fitted.
    pub fn end(&self) -> f64 {
        self.table.end()
    }

    /// [a, b] for x = ‖f̂‖. NaN gives NaN.
    pub fn factors(&self, x: f64) -> [f64; 2] {
        let mut out = [0.0; 2];
        self.table.eval(x, &mut out);
        out
    }

    /// The numbers of the table: the ends of its pieces, and for each piece the Chebyshev coefficients c_0…c_7, a and b in turn.
    pub fn table(&self) -> (&[f64], &[f64]) {
        (self.table.breaks(), self.table.terms())
    }
}

/// Single discs about the z axis.
struct Discs {
    zonal: Zonal,
}

impl Discs {
    /// [x, a, b] of the disc of an angle.
    fn optimum(&self, theta: f64) -> Result<Vec<f64>> {
        let mut log = self.zonal.log(&cap_less_one(self.zonal.bands(), theta), 1.0, FLOOR)?.log;
        log[0] = 0.0;
        let square: f64 = log.iter().map(|f| f * f).sum();
        let less_one = self.zonal.exp_less_one(&log)?;
        let along: f64 = less_one.iter().zip(&log).map(|(g, f)| g * f).sum();
        let b = if square > 0.0 { along / square } else { 1.0 };
        Ok(vec![square.sqrt(), 1.0 + less_one[0] / super::ONE, b])
    }

    /// The angles up to which x(θ) rises from 0 without a break, at whose ends x has kinks.
    fn rising(&self) -> Result<Vec<f64>> {
        let mut ends = self.zonal.cap_kinks(LARGEST, FLOOR)?;
        const STEPS: usize = 200;
        let x = |k: usize| Ok::<f64, Error>(self.optimum(LARGEST * k as f64 / STEPS as f64)?[0]);
        let mut last = 0.0;
        for k in 1..=STEPS {
            let next = x(k)?;
            if next <= last {
                // Back one more: the top is between k − 2 and k.
                let end = LARGEST * (k - 2) as f64 / STEPS as f64;
                ends.retain(|&kink| kink < end);
                ends.push(end);
                return Ok(ends);
            }
            last = next;
        }
        ends.push(LARGEST);
        Ok(ends)
    }
}
