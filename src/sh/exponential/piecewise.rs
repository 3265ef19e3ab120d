//! Several functions of one variable, tabulated as polynomials on pieces of an interval.

use std::borrow::Cow;
use std::f64::consts::PI;

use crate::Result;

/// Coefficients of each function on each piece.
pub(super) const TERMS: usize = 8;

/// Functions of x as Chebyshev polynomials of degree 7 on pieces of an interval; beyond its ends they stay as they are
/// there.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Piecewise {
    functions: usize,
    breaks: Cow<'static, [f64]>,
    /// For each piece, for each term, for each function.
    terms: Cow<'static, [f64]>,
}

impl Piecewise {
    /// A committed table.
    pub(super) const fn committed(functions: usize, breaks: &'static [f64], terms: &'static [f64]) -> Self {
        Self { functions, breaks: Cow::Borrowed(breaks), terms: Cow::Borrowed(terms) }
    }

    /// A table from its numbers.
    pub(super) fn owned(functions: usize, breaks: Vec<f64>, terms: Vec<f64>) -> Self {
        Self { functions, breaks: breaks.into(), terms: terms.into() }
    }

    /// Tabulates `f`, which is smooth between the `breaks`: halves a piece until every function is met within
    /// `tolerance` at twice as many points, or the piece is shorter than 1e-5 of the whole. Also returns the largest
    /// difference seen.
    pub(super) fn fit(
        functions: usize,
        breaks: &[f64],
        tolerance: f64,
        mut f: impl FnMut(f64) -> Result<Vec<f64>>,
    ) -> Result<(Self, f64)> {
        let shortest = 1e-5 * (breaks[breaks.len() - 1] - breaks[0]);
        let (mut done, mut terms, mut worst) = (vec![breaks[0]], Vec::new(), 0.0f64);
        let mut waiting: Vec<[f64; 2]> = breaks.windows(2).rev().map(|ends| [ends[0], ends[1]]).collect();
        while let Some([low, high]) = waiting.pop() {
            let at = |t: f64| 0.5 * (low + high) + 0.5 * (high - low) * t;
            let piece = interpolate(functions, |t| f(at(t)))?;
            let mut error = 0.0f64;
            for i in 0..2 * TERMS {
                let t = (PI * (i as f64 + 0.5) / (2 * TERMS) as f64).cos();
                let mut got = vec![0.0; functions];
                clenshaw(&piece, t, &mut got);
                for (got, want) in got.iter().zip(f(at(t))?) {
                    error = error.max((got - want).abs());
                }
            }
            if error > tolerance && high - low > shortest {
                let middle = 0.5 * (low + high);
                waiting.extend([[middle, high], [low, middle]]);
            } else {
                done.push(high);
                terms.extend(piece);
                worst = worst.max(error);
            }
        }
        Ok((Self { functions, breaks: done.into(), terms: terms.into() }, worst))
    }

    pub(super) fn breaks(&self) -> &[f64] {
        &self.breaks
    }

    pub(super) fn terms(&self) -> &[f64] {
        &self.terms
    }

    pub(super) fn end(&self) -> f64 {
        self.breaks[self.breaks.len() - 1]
    }

    /// All functions at x. NaN gives NaN.
    pub(super) fn eval(&self, x: f64, out: &mut [f64]) {
        let last = self.breaks.len() - 2;
        let piece = self.breaks[1..=last].iter().filter(|&&end| x >= end).count();
        let (low, high) = (self.breaks[piece], self.breaks[piece + 1]);
        let t = (x - low - (high - x)) / (high - low);
        let t = if t < -1.0 { -1.0 } else { t };
        let t = if t > 1.0 { 1.0 } else { t };
        let size = TERMS * self.functions;
        clenshaw(&self.terms[piece * size..][..size], t, out);
    }
}

/// The coefficients of the polynomials through f at the TERMS Chebyshev points, for each term, for each function.
fn interpolate(functions: usize, mut f: impl FnMut(f64) -> Result<Vec<f64>>) -> Result<Vec<f64>> {
    let mut terms = vec![0.0; TERMS * functions];
    for i in 0..TERMS {
        let angle = PI * (i as f64 + 0.5) / TERMS as f64;
        let values = f(angle.cos())?;
        for k in 0..TERMS {
            let weight = if k == 0 { 1.0 } else { 2.0 } / TERMS as f64 * (k as f64 * angle).cos();
            for (term, value) in terms[k * functions..].iter_mut().zip(&values) {
                *term += weight * value;
            }
        }
    }
    Ok(terms)
}

/// Σ_k c_k T_k(t), for a few functions at a time: b_k = c_k + 2t b_{k+1} − b_{k+2}.
fn clenshaw(terms: &[f64], t: f64, out: &mut [f64]) {
    const TOGETHER: usize = 4;
    let functions = terms.len() / TERMS;
    for (first, out) in (0..functions).step_by(TOGETHER).zip(out.chunks_mut(TOGETHER)) {
        let (mut upper, mut upper2) = ([0.0; TOGETHER], [0.0; TOGETHER]);
        for k in (1..TERMS).rev() {
            let row = &terms[k * functions + first..];
            for (i, &c) in row[..out.len()].iter().enumerate() {
                (upper[i], upper2[i]) = (c + 2.0 * t * upper[i] - upper2[i], upper[i]);
            }
        }
        for (i, out) in out.iter_mut().enumerate() {
            *out = terms[first + i] + t * upper[i] - upper2[i];
        }
    }
}
