//! Expansions about an axis: n coefficients, product matrices in blocks.

use nalgebra::DMatrix;

use super::ONE;
use super::spectrum::{apply, decompose, largest_eigenvalue};
use crate::sh::{gamma, index};
use crate::{Error, Result};

/// Product matrices of zonal vectors: M has a block for each order m, of the degrees l ≥ |m|, the same for m and −m.
#[derive(Debug, Clone)]
pub(super) struct Zonal {
    bands: usize,
    /// For each m: (row, column, k, Γ), row ≤ column.
    blocks: Vec<Vec<(usize, usize, usize, f64)>>,
}

/// What came of a logarithm.
#[derive(Debug, Clone)]
pub(super) struct ZonalLog {
    pub log: Vec<f64>,
    /// How many eigenvalues of the block m = 0 were clipped, and the m of the block with the largest.
    pub state: [usize; 2],
}

impl Zonal {
    pub(super) fn new(bands: usize) -> Result<Self> {
        let mut blocks = Vec::new();
        for m in 0..bands {
            let mut entries = Vec::new();
            for row in m..bands {
                for column in row..bands {
                    for k in (0..bands).filter(|k| (row + column + k) % 2 == 0) {
                        let at = |l| index(l, m as isize);
                        let value = gamma(at(row), at(column), index(k, 0))?;
                        if value != 0.0 {
                            entries.push((row - m, column - m, k, value));
                        }
                    }
                }
            }
            blocks.push(entries);
        }
        Ok(Self { bands, blocks })
    }

    pub(super) fn bands(&self) -> usize {
        self.bands
    }

    /// The angles below `largest` at which the logarithm of a cap's visibility has a kink: where an eigenvalue of its
    /// block comes to be clipped or no longer, and where another block comes to have the largest.
    pub(super) fn cap_kinks(&self, largest: f64, floor: f64) -> Result<Vec<f64>> {
        const STEPS: usize = 400;
        let state = |theta: f64| Ok::<_, Error>(self.log(&cap_less_one(self.bands, theta)?, 1.0, floor)?.state);
        let (mut kinks, mut before) = (Vec::new(), state(0.5 * largest / STEPS as f64)?);
        for k in 1..STEPS {
            let [mut low, mut high] = [k - 1, k].map(|k| largest * (k as f64 + 0.5) / STEPS as f64);
            let after = state(high)?;
            if after != before {
                while high - low > 1e-14 * largest {
                    let middle = 0.5 * (low + high);
                    // An end of the interval that the numbers between do not reach.
                    if middle <= low || middle >= high {
                        break;
                    }
                    if state(middle)? == before { low = middle } else { high = middle }
                }
                kinks.push(0.5 * (low + high));
                before = after;
            }
        }
        Ok(kinks)
    }

    /// The block of order m.
    fn block(&self, m: usize, zonal: &[f64]) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.bands - m, self.bands - m);
        for &(row, column, k, gamma) in &self.blocks[m] {
            matrix[(row, column)] += gamma * zonal[k];
        }
        matrix.fill_lower_triangle_with_upper_triangle();
        matrix
    }

    /// Eq. 5.33 with 5.35 of `part` + `rest` (0 or 1): log x/(x − 1) of the clipped eigenvalues, applied to the
    /// argument − 1.
    ///
    /// With rest 1 a log near 0 keeps its digits, with rest 0 that of a small argument: M_g = M_part + rest. The block
    /// m = 0 has the vector, all blocks have the largest eigenvalue.
    pub(super) fn log(&self, part: &[f64], rest: f64, floor: f64) -> Result<ZonalLog> {
        let eigen = decompose(self.block(0, part))?;
        let mut largest = (eigen.eigenvalues.max(), 0);
        for m in 1..self.bands {
            let most = largest_eigenvalue(self.block(m, part))?;
            // Blocks share eigenvalues where g is constant: rounding must not tell them apart.
            if most > largest.0 + 1e-14 * (rest + largest.0.abs()) {
                largest = (most, m);
            }
        }
        let lowest = floor * check_largest(rest + largest.0)?;
        let clipped = eigen.eigenvalues.iter().filter(|&&x| rest + x < lowest).count();
        let ratio = |x: f64| {
            if rest + x < lowest { log_ratio(lowest, lowest - 1.0) } else { log_ratio(rest + x, x + (rest - 1.0)) }
        };
        let mut less_one = part.to_vec();
        less_one[0] += (rest - 1.0) * ONE;
        // The largest matters only where something is clipped.
        let block = if clipped > 0 { largest.1 } else { 0 };
        Ok(ZonalLog { log: apply(&eigen, ratio, &less_one), state: [clipped, block] })
    }

    /// exp(M_f)·1 − 1 = q(M_f) f, q(x) = (e^x − 1)/x                  [Sun 2008, eqs. 5.31, 5.32]
    pub(super) fn exp_less_one(&self, f: &[f64]) -> Result<Vec<f64>> {
        let ratio = |x: f64| if x == 0.0 { 1.0 } else { x.exp_m1() / x };
        Ok(apply(&decompose(self.block(0, f))?, ratio, f))
    }
}

/// ln x/(x − 1), of x and of x − 1, each as well known as it is.
pub(super) fn log_ratio(x: f64, less_one: f64) -> f64 {
    match less_one {
        0.0 => 1.0,
        y if y.abs() < 0.5 => y.ln_1p() / y,
        y => x.ln() / y,
    }
}

/// The largest eigenvalue, if it has a logarithm.
pub(super) fn check_largest(largest: f64) -> Result<f64> {
    if largest > 0.0 {
        return Ok(largest);
    }
    Err(Error::OutOfRange { what: "largest eigenvalue of a logarithm's argument", got: largest, allowed: "above 0" })
}

/// g − 1 of the visibility of a cap of half angle θ that hides what is in it, the zonal coefficients.
pub(super) fn cap_less_one(bands: usize, theta: f64) -> Result<Vec<f64>> {
    Ok(crate::sh::Zonal::<f64>::cap(bands, theta)?.coefficients().into_iter().map(|c| -c).collect())
}
