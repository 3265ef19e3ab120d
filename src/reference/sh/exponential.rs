//! Exponentials and logarithms of expansions, straight from their definitions.

use std::f64::consts::PI;

use nalgebra::{UnitVector3, Vector3};

use super::basis::basis;
use super::product::{product, product_matrix};
use crate::numeric::GaussLegendre;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn one() -> f64 {
    (4.0 * PI).sqrt()
}

/// ∫ h(f(ω)) y(ω) dω by `rings` Gauss–Legendre rings of 2·`rings` points, for the bands of `f` [Sun 2008, eq. 5.15].
pub fn function_projected(f: &[f64], h: impl Fn(f64) -> f64, rings: usize) -> Vec<f64> {
    let gauss = GaussLegendre::new(rings).expect("at least one ring");
    let mut out = vec![0.0; f.len()];
    for (&z, &weight) in gauss.nodes().iter().zip(gauss.weights()) {
        let across = (1.0 - z * z).sqrt();
        for k in 0..2 * rings {
            let (sin, cos) = (PI * k as f64 / rings as f64).sin_cos();
            let y = basis(f.len().isqrt(), &UnitVector3::new_normalize(Vector3::new(across * cos, across * sin, z)));
            let value = h(dot(f, &y)) * weight * PI / rings as f64;
            out.iter_mut().zip(&y).for_each(|(out, y)| *out += value * y);
        }
    }
    out
}

/// ∫ exp(f) y by a rule fine enough for 1e-12 of moderate f: the truth that every exp is measured by.
pub fn exp_projected(f: &[f64]) -> Vec<f64> {
    function_projected(f, f64::exp, 48)
}

/// PS-p: Σ_{k ≤ p} f^{k*}/k!, f^{k*} = f^{(k−1)*} * f [Sun 2008, eq. 5.22].
pub fn exp_series(f: &[f64], p: usize) -> Vec<f64> {
    let bands = f.len().isqrt();
    let mut sum = vec![0.0; f.len()];
    sum[0] = one();
    let mut term = sum.clone();
    for k in 1..=p {
        term = product(&term, f, bands);
        term.iter_mut().for_each(|x| *x /= k as f64);
        sum.iter_mut().zip(&term).for_each(|(sum, x)| *sum += x);
    }
    sum
}

/// PS*-p: constant apart, scaled to ‖f̂‖ ≤ `norm`, even and odd powers, squared up [Sun 2008, eqs. 5.25–5.27].
pub fn exp_scaled_series(f: &[f64], p: usize, norm: f64) -> Vec<f64> {
    let bands = f.len().isqrt();
    let mut hat = f.to_vec();
    hat[0] = 0.0;
    let length = dot(&hat, &hat).sqrt();
    let squarings = (length / norm * (1.0 - 1e-6)).log2().ceil().max(0.0) as i32;
    hat.iter_mut().for_each(|x| *x /= 2f64.powi(squarings));
    let mut factorials = vec![1.0];
    (1..=p).for_each(|k| factorials.push(factorials[k - 1] * k as f64));
    // f^2, f^4, …: even multiples of two as squares.
    let mut powers: Vec<Vec<f64>> = Vec::new();
    for k in 1..=p / 2 {
        let next = match k {
            1 => product(&hat, &hat, bands),
            _ if k % 2 == 0 => product(&powers[k / 2 - 1], &powers[k / 2 - 1], bands),
            _ => product(&powers[k - 2], &powers[0], bands),
        };
        powers.push(next);
    }
    let polynomial = |odd: usize| {
        let mut sum = vec![0.0; f.len()];
        if p >= odd {
            sum[0] = one() / factorials[odd];
        }
        for (k, power) in powers.iter().enumerate().filter(|(k, _)| 2 * k + 2 + odd <= p) {
            sum.iter_mut().zip(power).for_each(|(sum, x)| *sum += x / factorials[2 * k + 2 + odd]);
        }
        sum
    };
    let mut out = product(&polynomial(1), &hat, bands);
    out.iter_mut().zip(polynomial(0)).for_each(|(out, x)| *out += x);
    for _ in 0..squarings {
        out = product(&out, &out, bands);
    }
    let factor = (f[0] / one()).exp();
    out.into_iter().map(|x| x * factor).collect()
}

/// exp(M_f)·1 [Sun 2008, eq. 5.31], with exp(M_f) = exp(M_f/k)^k applied as Taylor series of 30 terms, ‖M_f/k‖ ≤ 1.
pub fn exp_limit(f: &[f64]) -> Vec<f64> {
    let (bands, size) = (f.len().isqrt(), f.len());
    let matrix = product_matrix(f, bands, bands);
    let steps = (1..=size).map(|i| matrix[(i - 1) * size..i * size].iter().map(|x| x.abs()).sum()).fold(1.0, f64::max);
    let steps = steps.ceil();
    let mut out = vec![0.0; size];
    out[0] = one();
    for _ in 0..steps as usize {
        let mut term = out.clone();
        for k in 1..=30 {
            term = (0..size).map(|i| dot(&matrix[i * size..][..size], &term) / (steps * f64::from(k))).collect();
            out.iter_mut().zip(&term).for_each(|(out, x)| *out += x);
        }
    }
    out
}

/// Eigenvalues and eigenvectors (rows) of M_f, by Jacobi rotations.
pub fn product_eigen(f: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
    let size = f.len();
    let mut a = product_matrix(f, size.isqrt(), size.isqrt());
    let mut vectors: Vec<Vec<f64>> =
        (0..size).map(|i| (0..size).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    for _ in 0..30 {
        for p in 0..size {
            for q in p + 1..size {
                let off = a[p * size + q];
                if off.abs() < 1e-300 {
                    continue;
                }
                let theta = (a[q * size + q] - a[p * size + p]) / (2.0 * off);
                let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let c = 1.0 / t.hypot(1.0);
                let s = t * c;
                for k in 0..size {
                    let (x, y) = (a[k * size + p], a[k * size + q]);
                    (a[k * size + p], a[k * size + q]) = (c * x - s * y, s * x + c * y);
                }
                for k in 0..size {
                    let (x, y) = (a[p * size + k], a[q * size + k]);
                    (a[p * size + k], a[q * size + k]) = (c * x - s * y, s * x + c * y);
                    let (x, y) = (vectors[p][k], vectors[q][k]);
                    (vectors[p][k], vectors[q][k]) = (c * x - s * y, s * x + c * y);
                }
            }
        }
    }
    ((0..size).map(|i| a[i * size + i]).collect(), vectors)
}

/// Rᵀ q′(max(D, `floor` · max D)) R (g − 1), q′(x) = log x/(x − 1) [Sun 2008, eqs. 5.33–5.35].
pub fn log_by_eigenvalues(g: &[f64], floor: f64) -> Vec<f64> {
    let (values, vectors) = product_eigen(g);
    let lowest = floor * values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut less_one = g.to_vec();
    less_one[0] -= one();
    let mut out = vec![0.0; g.len()];
    for (value, vector) in values.into_iter().zip(&vectors) {
        let x = value.max(lowest);
        let ratio = if (x - 1.0).abs() < 1e-14 { 1.0 } else { x.ln() / (x - 1.0) };
        let along = dot(vector, &less_one);
        out.iter_mut().zip(vector).for_each(|(out, v)| *out += ratio * along * v);
    }
    out
}

/// [a, b] that minimise ‖exp_*(f̂) − a 1 − b f̂‖.
pub fn optimal_linear(f: &[f64]) -> [f64; 2] {
    let mut hat = f.to_vec();
    hat[0] = 0.0;
    let exp = exp_limit(&hat);
    [exp[0] / one(), dot(&exp, &hat) / dot(&hat, &hat)]
}

/// Coefficients of the function that is 0 within `theta` of `axis` and 1 elsewhere, by quadrature from the disc's edge
/// on [Sun 2008, eq. 5.36].
pub fn cap_visibility(bands: usize, axis: &UnitVector3<f64>, theta: f64) -> Vec<f64> {
    let gauss = GaussLegendre::new(2 * bands + 2).expect("at least one node");
    let around =
        |z: f64| super::basis::basis(bands, &UnitVector3::new_normalize(Vector3::new((1.0 - z * z).sqrt(), 0.0, z)));
    let mut zonal = vec![0.0; bands];
    let (low, high) = (-1.0, theta.cos());
    for (&t, &weight) in gauss.nodes().iter().zip(gauss.weights()) {
        let y = around(0.5 * (low + high) + 0.5 * (high - low) * t);
        for (l, zonal) in zonal.iter_mut().enumerate() {
            *zonal += PI * (high - low) * weight * y[l * l + l];
        }
    }
    turned(&zonal, axis)
}

/// Zonal coefficients about `axis` instead of z: f_lm = √(4π/(2l+1)) f_l y_lm(axis).
fn turned(zonal: &[f64], axis: &UnitVector3<f64>) -> Vec<f64> {
    let y = basis(zonal.len(), axis);
    (0..y.len())
        .map(|i| {
            let l = i.isqrt();
            (4.0 * PI / (2 * l + 1) as f64).sqrt() * zonal[l] * y[i]
        })
        .collect()
}

/// Coefficients of the function that is 0 within any of the discs (axis, θ) and 1 elsewhere, by `rings` rings of
/// 2·`rings` points: good to some 1/`rings`^{3/2}, as the edges are where they are.
pub fn union_visibility(bands: usize, discs: &[(UnitVector3<f64>, f64)], rings: usize) -> Vec<f64> {
    let gauss = GaussLegendre::new(rings).expect("at least one ring");
    let mut out = vec![0.0; bands * bands];
    for (&z, &weight) in gauss.nodes().iter().zip(gauss.weights()) {
        let across = (1.0 - z * z).sqrt();
        for k in 0..2 * rings {
            let (sin, cos) = (PI * (k as f64 + 0.5) / rings as f64).sin_cos();
            let d = UnitVector3::new_normalize(Vector3::new(across * cos, across * sin, z));
            if discs.iter().all(|(axis, theta)| axis.dot(&d) < theta.cos()) {
                let y = basis(bands, &d);
                out.iter_mut().zip(y).for_each(|(out, y)| *out += weight * PI / rings as f64 * y);
            }
        }
    }
    out
}
