//! Harmonics along meridians, and turns that permute the axes.

use std::f64::consts::PI;

use nalgebra::Vector3;

use crate::Result;
use crate::sh::Basis;

/// Fourier coefficients of the normalised Legendre functions along a whole meridian.
///
///   y_{l,m}(cos α, 0, sin α) = Σ_k D_{lmk} {cos kα (l − m even), sin kα (l − m odd)},  k = l, l−2, …, m ≥ 0
///
/// The parity: α → −α mirrors z, α → α + π is the antipode. No D exceeds √((2l+1)/4π)·√2.
#[derive(Debug, Clone)]
pub(super) struct Meridians {
    bands: usize,
    /// For m = 0…, l = m…, k = l % 2, l % 2 + 2, …, l.
    values: Vec<f64>,
}

impl Meridians {
    /// By the discrete transform of 2·bands + 2 samples, which is exact.
    pub(super) fn new(bands: usize) -> Result<Self> {
        let basis = Basis::<f64>::new(bands)?;
        let samples = 2 * bands + 2;
        let turn: Vec<[f64; 2]> =
            (0..samples).map(|j| (2.0 * PI * j as f64 / samples as f64).sin_cos().into()).collect();
        let mut y = vec![0.0; samples * bands * bands];
        for ([sin, cos], y) in turn.iter().zip(y.chunks_exact_mut(bands * bands)) {
            basis.eval(&Vector3::new(*cos, 0.0, *sin), y);
        }
        let mut values = Vec::new();
        for m in 0..bands {
            for l in m..bands {
                let at = l * (l + 1) + m;
                for k in (l % 2..=l).step_by(2) {
                    let wave = |j: usize| turn[j * k % samples][1 - (l - m) % 2];
                    let sum: f64 = (0..samples).map(|j| y[j * bands * bands + at] * wave(j)).sum();
                    values.push(sum * if k == 0 { 1.0 } else { 2.0 } / samples as f64);
                }
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
///   y(Rω) = M y(ω),  Rω = (y, z, x)
///
/// M by recurrence in l [Ivanic & Ruedenberg 1996, with the corrections of 1998], all of whose terms are bounded by 1.
#[derive(Debug, Clone)]
pub(super) struct AxesTurn {
    /// Rows of M_l, l after l.
    blocks: Vec<Vec<f64>>,
}

impl AxesTurn {
    pub(super) fn new(bands: usize) -> Self {
        // In the order (y, z, x) of degree 1: y' = z, z' = x, x' = y.
        let first = vec![0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0];
        let mut blocks = vec![vec![1.0], first];
        for l in 2..bands {
            let next = next_block(l, &blocks[1], &blocks[l - 1]);
            blocks.push(next);
        }
        blocks.truncate(bands);
        Self { blocks }
    }

    /// Adds M c.
    pub(super) fn add_turned(&self, coefficients: &[f64], out: &mut [f64]) {
        self.walk(|row, column, m| out[row] += m * coefficients[column]);
    }

    /// Adds Mᵀ c.
    pub(super) fn add_turned_back(&self, coefficients: &[f64], out: &mut [f64]) {
        self.walk(|row, column, m| out[column] += m * coefficients[row]);
    }

    #[inline(always)]
    fn walk(&self, mut visit: impl FnMut(usize, usize, f64)) {
        for (l, block) in self.blocks.iter().enumerate() {
            for (row, values) in block.chunks_exact(2 * l + 1).enumerate() {
                for (column, &m) in values.iter().enumerate() {
                    visit(l * l + row, l * l + column, m);
                }
            }
        }
    }
}

/// M_l from M_1 and M_{l−1}.
fn next_block(l: usize, first: &[f64], below: &[f64]) -> Vec<f64> {
    let l = l as isize;
    let r = |i: isize, j: isize| first[(3 * (i + 1) + j + 1) as usize];
    let at = |m: isize, n: isize| below[((m + l - 1) * (2 * l - 1) + n + l - 1) as usize];
    let p = |i: isize, m: isize, n: isize| {
        if n == l {
            r(i, 1) * at(m, l - 1) - r(i, -1) * at(m, 1 - l)
        } else if n == -l {
            r(i, 1) * at(m, 1 - l) + r(i, -1) * at(m, l - 1)
        } else {
            r(i, 0) * at(m, n)
        }
    };
    let mut out = Vec::with_capacity(((2 * l + 1) * (2 * l + 1)) as usize);
    for m in -l..=l {
        let size = m.abs();
        for n in -l..=l {
            let denominator = (if n.abs() < l { (l + n) * (l - n) } else { 2 * l * (2 * l - 1) }) as f64;
            let root = |x: isize| (x as f64 / denominator).sqrt();
            let mut sum = 0.0;
            if size < l {
                sum += root((l + m) * (l - m)) * p(0, m, n);
            }
            let v = root((l + size - 1) * (l + size));
            sum += match m {
                0 => -(2f64.sqrt() / 2.0) * v * (p(1, 1, n) + p(-1, -1, n)),
                1 => 0.5 * v * 2f64.sqrt() * p(1, 0, n),
                -1 => 0.5 * v * 2f64.sqrt() * p(-1, 0, n),
                2.. => 0.5 * v * (p(1, m - 1, n) - p(-1, 1 - m, n)),
                _ => 0.5 * v * (p(1, m + 1, n) + p(-1, -m - 1, n)),
            };
            if m != 0 && size < l - 1 {
                let w = root((l - size - 1) * (l - size));
                sum -= 0.5
                    * w
                    * match m {
                        1.. => p(1, m + 1, n) + p(-1, -m - 1, n),
                        _ => p(1, m - 1, n) - p(-1, 1 - m, n),
                    };
            }
            out.push(sum);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sh::eval;
    use crate::sphere::fibonacci_directions;

    #[test]
    fn turned_axes() {
        let turn = AxesTurn::new(40);
        let mut error = 0f64;
        for d in fibonacci_directions(20) {
            let (y, turned) = (eval(40, &d).unwrap(), eval(40, &Vector3::new(d.y, d.z, d.x)).unwrap());
            let (mut out, mut back) = (vec![0.0; 1600], vec![0.0; 1600]);
            turn.add_turned(&y, &mut out);
            turn.add_turned_back(&turned, &mut back);
            for i in 0..1600 {
                error = error.max((out[i] - turned[i]).abs()).max((back[i] - y[i]).abs());
            }
        }
        // eval's own 1e-13 at 40 bands, summed over a row of norm 1.
        assert!(error < 1e-12, "{error:e}");
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
