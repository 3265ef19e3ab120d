//! Products of spherical harmonic expansions, direction by direction.

use std::f64::consts::PI;

use crate::numeric::GaussLegendre;

/// y_{lm} at cos θ = `z` and azimuth φ, from its definition: √2 K P_l^{|m|}(z) times cos mφ or sin |m|φ.
fn harmonic(l: usize, m: isize, z: f64, phi: f64) -> f64 {
    let order = m.unsigned_abs();
    let root = (1.0 - z * z).sqrt();
    // P_m^m = (2m−1)!! (1−z²)^{m/2}, then up in degree; no Condon–Shortley sign.
    let mut p = (0..order).fold(1.0, |p, i| p * (2 * i + 1) as f64 * root);
    let mut before = 0.0;
    for degree in order + 1..=l {
        let next = ((2 * degree - 1) as f64 * z * p - (degree + order - 1) as f64 * before) / (degree - order) as f64;
        (before, p) = (p, next);
    }
    let falling: f64 = (l - order + 1..=l + order).map(|i| i as f64).product();
    let k = ((2 * l + 1) as f64 / (4.0 * PI) / falling).sqrt();
    let angle = order as f64 * phi;
    match m {
        0 => k * p,
        1.. => 2f64.sqrt() * k * p * angle.cos(),
        _ => 2f64.sqrt() * k * p * angle.sin(),
    }
}

/// A rule on the sphere that integrates polynomials up to `degree` exactly: (cos θ, φ, weight).
fn rule(degree: usize) -> Vec<(f64, f64, f64)> {
    let gauss = GaussLegendre::new(degree / 2 + 1).expect("at least one node");
    let azimuths = degree + 1;
    let mut nodes = Vec::new();
    for (&z, &weight) in gauss.nodes().iter().zip(gauss.weights()) {
        for i in 0..azimuths {
            let step = 2.0 * PI / azimuths as f64;
            nodes.push((z, i as f64 * step, weight * step));
        }
    }
    nodes
}

fn all_harmonics(count: usize, z: f64, phi: f64) -> Vec<f64> {
    (0..count).map(|i| flat_harmonic(i, z, phi)).collect()
}

fn flat_harmonic(i: usize, z: f64, phi: f64) -> f64 {
    let l = i.isqrt();
    harmonic(l, i as isize - (l * l + l) as isize, z, phi)
}

fn dot(a: &[f64], y: &[f64]) -> f64 {
    a.iter().zip(y).map(|(a, y)| a * y).sum()
}

/// ∫ y_i y_j y_k by a rule that is exact for it up to rounding.
pub fn gamma(i: usize, j: usize, k: usize) -> f64 {
    let degree = i.isqrt() + j.isqrt() + k.isqrt();
    rule(degree)
        .into_iter()
        .map(|(z, phi, weight)| [i, j, k].map(|i| flat_harmonic(i, z, phi)).iter().product::<f64>() * weight)
        .sum()
}

/// Coefficients below `bands_out` of the product of two expansions: evaluate, multiply, project.
///
/// The lengths of `a` and `b` are squares: bands².
pub fn product(a: &[f64], b: &[f64], bands_out: usize) -> Vec<f64> {
    let (larger, count) = (a.len().max(b.len()), bands_out * bands_out);
    let mut out = vec![0.0; count];
    for (z, phi, weight) in rule(a.len().isqrt() + b.len().isqrt() + bands_out) {
        let y = all_harmonics(larger.max(count), z, phi);
        let value = dot(a, &y) * dot(b, &y) * weight;
        out.iter_mut().zip(&y).for_each(|(o, y)| *o += value * y);
    }
    out
}

/// The matrix, row-major with `bands_out`² rows of `bands_b`², whose column j is the product of `a` and y_j.
pub fn product_matrix(a: &[f64], bands_b: usize, bands_out: usize) -> Vec<f64> {
    let (columns, rows) = (bands_b * bands_b, bands_out * bands_out);
    let mut out = vec![0.0; rows * columns];
    for j in 0..columns {
        let hot: Vec<f64> = (0..columns).map(|i| f64::from(u8::from(i == j))).collect();
        for (k, value) in product(a, &hot, bands_out).into_iter().enumerate() {
            out[k * columns + j] = value;
        }
    }
    out
}

/// ∫ a b c of three expansions.
pub fn triple_integral(a: &[f64], b: &[f64], c: &[f64]) -> f64 {
    let largest = a.len().max(b.len()).max(c.len());
    let mut sum = 0.0;
    for (z, phi, weight) in rule(a.len().isqrt() + b.len().isqrt() + c.len().isqrt()) {
        let y = all_harmonics(largest, z, phi);
        sum += weight * dot(a, &y) * dot(b, &y) * dot(c, &y);
    }
    sum
}
