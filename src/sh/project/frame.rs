//! Harmonics along meridians, and turns that permute the axes.

use std::f64::consts::PI;

use nalgebra::Vector3;

use crate::Result;
use crate::sh::Basis;

/// y_{l,m} of `bands` at samples of a quarter of a meridian, m ≥ 0.
struct Samples {
    /// Samples of the quarter.
    count: usize,
    /// A row for each coefficient.
    y: Vec<f64>,
    /// (sin, cos) of πt/4count.
    waves: Vec<[f64; 2]>,
}

impl Samples {
    /// α_j = 2π(j + ½)/4count: none is at a pole.
    fn new(bands: usize) -> Result<Self> {
        let basis = Basis::<f64>::new(bands)?;
        let count = (2 * bands + 2).div_ceil(4);
        let waves: Vec<[f64; 2]> =
            (0..8 * count).map(|t| (0.25 * PI * t as f64 / count as f64).sin_cos().into()).collect();
        let component = |k: usize| (0..count).map(|j| waves[2 * j + 1][k]).collect::<Vec<f64>>();
        let mut y = vec![0.0; count * bands * bands];
        basis.eval_batch(&component(1), &vec![0.0; count], &component(0), &mut y);
        Ok(Self { count, y, waves })
    }

    /// The coefficient of cos kα (l − m even) or sin kα (l − m odd) in y_{l,m}, or in y_{l,m}/cos α. What is summed has
    /// period π and is even, so that a quarter stands for the whole.
    fn coefficient(&self, [l, m, k]: [usize; 3], over_cosine: bool) -> f64 {
        let row = &self.y[(l * (l + 1) + m) * self.count..][..self.count];
        let terms = row.iter().enumerate().map(|(j, y)| {
            let wave = self.waves[(2 * j + 1) * k % self.waves.len()][1 - (l - m) % 2];
            if over_cosine { y * wave / self.waves[2 * j + 1][1] } else { y * wave }
        });
        terms.sum::<f64>() * if k == 0 { 1.0 } else { 2.0 } / self.count as f64
    }
}

/// Fourier coefficients of the normalised Legendre functions along a whole meridian.
///
/// ```math
/// y_{l,m}(cos α, 0, sin α) = Σ_k D_{lmk} {cos kα (l − m even), sin kα (l − m odd)},  k = l, l−2, …, m ≥ 0
/// ```
///
/// The parity: α → −α mirrors z, α → α + π is the antipode. By the discrete transform, which is exact.
#[derive(Debug, Clone)]
pub(super) struct Meridians {
    bands: usize,
    /// For m = 0…, l = m…, k = l % 2, l % 2 + 2, …, l.
    values: Vec<f64>,
}

impl Meridians {
    pub(super) fn new(bands: usize) -> Result<Self> {
        let samples = Samples::new(bands)?;
        let mut values = Vec::new();
        for m in 0..bands {
            for l in m..bands {
                values.extend((l % 2..=l).step_by(2).map(|k| samples.coefficient([l, m, k], false)));
            }
        }
        Ok(Self { bands, values })
    }

    /// Adds c_{l,±m} = Σ_k D_{lmk} G_{±,m,k}, with G at `(2 m + sign)·functions + k`, sign 1 for −m.
    pub(super) fn analyse(&self, waves: &[f64], functions: usize, coefficients: &mut [f64]) {
        self.walk(|i, [row, k], d| coefficients[i] += d * waves[row * functions + k]);
    }

    /// Adds G_{±,m,k} = Σ_l D_{lmk} c_{l,±m}: the transpose.
    pub(super) fn synthesise(&self, coefficients: &[f64], functions: usize, waves: &mut [f64]) {
        self.walk(|i, [row, k], d| waves[row * functions + k] += d * coefficients[i]);
    }

    #[inline(always)]
    fn walk(&self, mut visit: impl FnMut(usize, [usize; 2], f64)) {
        let mut values = self.values.iter();
        for m in 0..self.bands {
            for l in m..self.bands {
                for (k, &d) in (l % 2..=l).step_by(2).zip(values.by_ref()) {
                    visit(l * (l + 1) + m, [2 * m, k], d);
                    if m > 0 {
                        visit(l * (l + 1) - m, [2 * m + 1, k], d);
                    }
                }
            }
        }
    }
}

/// Turns coefficients between the world and a frame whose axes (x', y', z') are the world's (y, z, x).
///
/// ```math
/// y(Rω) = M y(ω),  Rω = (y, z, x)
/// ```
///
/// On the equator ω = (cos φ, sin φ, 0) the right side is Σ M_{i,lm} p_{lm} {cos, sin} mφ, p the Legendre functions at
/// 0, and the left a meridian, α = π/2 − φ: M is D over p. That gives what is even in z: l − m even on the right, no
/// sine of the azimuth on the left. The rest is odd, and has the derivative along z in place of the value: p' on the
/// right, |m| y_{l,|m|}/cos α on the left. p and p' are nowhere small (the recurrences in l lose six digits by l =
/// 128).
#[derive(Debug, Clone)]
pub(super) struct AxesTurn {
    /// The non-zeros: row, column, value.
    entries: Vec<(u32, u32, f64)>,
}

impl AxesTurn {
    pub(super) fn new(bands: usize) -> Result<Self> {
        let samples = Samples::new(bands)?;
        let size = bands * bands;
        let (mut values, mut slopes) = (vec![0.0; size], vec![Vector3::zeros(); size]);
        Basis::<f64>::new(bands)?.gradient(&Vector3::x(), &mut values, &mut slopes);
        let mut entries = Vec::new();
        for l in 0..bands {
            let centre = l * (l + 1);
            for m in 0..=l {
                for k in (l % 2..=l).step_by(2) {
                    let value = samples.coefficient([l, m, k], false) / values[centre + k];
                    entries.extend(entry(l, centre + m, (l - m) % 2, k, value));
                }
                // Without sines there is no odd part.
                for k in ((l + 1) % 2..l).step_by(2).filter(|_| m > 0) {
                    let value = m as f64 * samples.coefficient([l, m, k], true) / slopes[centre + k].z;
                    entries.extend(entry(l, centre - m, (l - m) % 2, k, value));
                }
            }
        }
        Ok(Self { entries })
    }

    /// Adds M c.
    pub(super) fn add_turned(&self, coefficients: &[f64], out: &mut [f64]) {
        for &(row, column, m) in &self.entries {
            out[row as usize] += m * coefficients[column as usize];
        }
    }

    /// Adds Mᵀ c.
    pub(super) fn add_turned_back(&self, coefficients: &[f64], out: &mut [f64]) {
        for &(row, column, m) in &self.entries {
            out[column as usize] += m * coefficients[row as usize];
        }
    }
}

/// The column of cos kα (`sine` 0) or sin kα (1) at α = π/2 − φ, one of ±cos kφ and ±sin kφ; sin 0 has none.
fn entry(l: usize, row: usize, sine: usize, k: usize, value: f64) -> Option<(u32, u32, f64)> {
    let centre = l * (l + 1);
    let quarter = if k / 2 % 2 == 0 { value } else { -value };
    let (column, value) = match (sine, k % 2) {
        (0, 0) => (centre + k, quarter),
        (0, _) => (centre - k, quarter),
        (_, 0) => (centre - k, -quarter),
        _ => (centre + k, quarter),
    };
    (sine == 0 || k > 0).then_some((row as u32, column as u32, value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sh::eval;
    use crate::sphere::fibonacci_directions;

    #[test]
    fn turned_axes() {
        for (bands, tolerance) in [(1, 1e-15), (2, 1e-15), (9, 2e-14), (40, 1e-12), (128, 1e-11)] {
            let turn = AxesTurn::new(bands).unwrap();
            let size = bands * bands;
            let mut error = 0f64;
            for d in fibonacci_directions(10) {
                let (y, turned) = (eval(bands, &d).unwrap(), eval(bands, &Vector3::new(d.y, d.z, d.x)).unwrap());
                let (mut out, mut back) = (vec![0.0; size], vec![0.0; size]);
                turn.add_turned(&y, &mut out);
                turn.add_turned_back(&turned, &mut back);
                for i in 0..size {
                    error = error.max((out[i] - turned[i]).abs()).max((back[i] - y[i]).abs());
                }
            }
            // eval's own bands^2.5 eps, summed over a row of norm 1.
            assert!(error < tolerance, "{bands} bands: {error:e}");
        }
    }

    #[test]
    fn meridians_are_their_series() {
        let bands = 12;
        let meridians = Meridians::new(bands).unwrap();
        for alpha in [-3.0f64, -1.2, 0.0, 0.3, 1.5, 2.5] {
            let y = eval(bands, &Vector3::new(alpha.cos(), 0.0, alpha.sin())).unwrap();
            let mut series = vec![0.0; bands * bands];
            meridians.walk(|i, [row, k], d| {
                let odd = (i.isqrt() - row / 2) % 2 == 1;
                let wave = k as f64 * alpha;
                series[i] += d * if odd { wave.sin() } else { wave.cos() };
            });
            for (i, (a, b)) in series.iter().zip(&y).enumerate() {
                // Those of −m are 0 on this meridian; their series is that of m.
                let m = i as isize - (i.isqrt() * (i.isqrt() + 1)) as isize;
                assert!(m < 0 || (a - b).abs() < 1e-14, "{i}: {a} {b}");
            }
        }
    }
}
