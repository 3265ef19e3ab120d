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
/// ```math
/// a = (exp_*(f̂)·1)/4π,  b = (exp_*(f̂)·f̂)/‖f̂‖²,  f = log of a disc's visibility, f̂ = f without f_0
/// ```
///
/// (Not in the thesis, which names it only: see docs/errata.md.) The least-squares fit to exp_*(f̂) = exp(M_f̂)·1, as
/// 1·f̂ = 0. Tabulated over the angle of the disc, 0 to a right angle, against x = ‖f̂‖; logarithms by eigenvalues with
/// floor 0.02. Beyond the largest disc's x, a and b stay what they are there.
///
/// Accuracy: the tables are within 2e-6 of what they tabulate, 2e-7 below x = 1/8. The method itself: use it for x ≲ 1,
/// or as the seed of [`ExpMethod::Hybrid`](super::ExpMethod::Hybrid).
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

    /// Fits the tables: what the crate's were made by. Cost, measured on one core: 0.04 s at 8 bands, 0.4 s at 16, 7 s
    /// at 32; it grows as bands⁴.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is not in 1…32.
    pub fn fit(bands: usize) -> Result<Self> {
        check_bands(bands)?;
        if bands == 1 {
            // f̂ is 0.
            let none = vec![0.0; 16];
            return Ok(Self { bands, table: Piecewise::owned(2, vec![0.0, 1.0], none) });
        }
        let discs = Discs { zonal: Zonal::new(bands)? };
        let mut angles = vec![0.0];
        angles.extend(discs.rising()?);
        // (x, α, β) against θ first; x rises, so that its inverse is found on the table.
        let (by_angle, _) = Piecewise::fit(3, &angles, 0.01 * TOLERANCE, |theta| discs.optimum(theta))?;
        let at_angle = |theta: f64| {
            let mut out = [0.0; 3];
            by_angle.eval(theta, &mut out);
            out
        };
        let mut breaks: Vec<f64> = angles.iter().map(|&theta| at_angle(theta)[0]).collect();
        breaks[0] = 0.0;
        // The squarings of the hybrid double what is wrong here.
        breaks.insert(1, 0.125);
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

    /// [a, b] for x = ‖f̂‖: exactly [1, 1] for 0, and for what is below. NaN gives NaN.
    pub fn factors(&self, x: f64) -> [f64; 2] {
        let mut out = [0.0; 2];
        let x = if x < 0.0 { 0.0 } else { x };
        self.table.eval(x, &mut out);
        let x = if x > self.table.end() { self.table.end() } else { x };
        [1.0 + out[0] * (x * x / (1.0 + x * x)), 1.0 + out[1] * (x / (1.0 + x))]
    }

    /// The numbers of the table: the ends of its pieces, and for each piece the Chebyshev coefficients c_0…c_7 of α and
    /// β in turn, a = 1 + α x²/(1 + x²), b = 1 + β x/(1 + x).
    pub fn table(&self) -> (&[f64], &[f64]) {
        (self.table.breaks(), self.table.terms())
    }
}

/// Single discs about the z axis.
struct Discs {
    zonal: Zonal,
}

impl Discs {
    /// [x, α, β] of the disc of an angle above 0.
    fn optimum(&self, theta: f64) -> Result<Vec<f64>> {
        let mut log = self.zonal.log(&cap_less_one(self.zonal.bands(), theta)?, 1.0, FLOOR)?.log;
        log[0] = 0.0;
        let square: f64 = log.iter().map(|f| f * f).sum();
        let x = square.sqrt();
        let less_one = self.zonal.exp_less_one(&log)?;
        let along: f64 = less_one.iter().zip(&log).map(|(g, f)| g * f).sum();
        let alpha = less_one[0] / super::ONE * (1.0 + square) / square;
        let beta = (along - square) / square * (1.0 + x) / x;
        Ok(vec![x, alpha, beta])
    }

    /// The angles up to which x(θ) rises from 0, at whose ends x has kinks; to just below the top if there is one, as x
    /// is flat there.
    fn rising(&self) -> Result<Vec<f64>> {
        const STEPS: usize = 400;
        let x = |k: usize| Ok::<f64, Error>(self.optimum(LARGEST * k as f64 / STEPS as f64)?[0]);
        let mut rise = vec![0.0];
        for k in 1..=STEPS {
            let next = x(k)?;
            if next <= rise[k - 1] {
                break;
            }
            rise.push(next);
        }
        let top = if rise.len() > STEPS { f64::INFINITY } else { 0.995 * rise[rise.len() - 1] };
        let last = rise.iter().filter(|&&x| x < top).count() - 1;
        let end = LARGEST * last as f64 / STEPS as f64;
        let mut ends = self.zonal.cap_kinks(LARGEST, FLOOR)?;
        ends.retain(|&kink| kink < end);
        ends.push(end);
        Ok(ends)
    }
}
