//! Tripling coefficients by numeric integration, products texel by texel.

use super::transform::{basis_1d, basis_nonstandard, forward_1d, forward_nonstandard, inverse_1d, inverse_nonstandard};

/// Mean over the samples of the product of any number of sampled signals: ∫ Π f. NaN without factors or samples.
pub fn product_integral(factors: &[&[f64]]) -> f64 {
    let samples = factors.first().map_or(0, |f| f.len());
    let sum: f64 = (0..samples).map(|i| factors.iter().map(|f| f[i]).product::<f64>()).sum();
    sum / samples as f64
}

/// ∫ ψ_i ψ_j ψ_k by the midpoint rule on `size` cells: exact up to rounding if the three are in the basis of that size.
pub fn tripling_1d(size: usize, i: usize, j: usize, k: usize) -> f64 {
    let [i, j, k] = [i, j, k].map(|flat| table_1d(size, flat));
    product_integral(&[&i, &j, &k])
}

/// ∫∫ Ψ_i Ψ_j Ψ_k of nonstandard functions by the midpoint rule on `side`² texels.
pub fn tripling_2d(side: usize, i: usize, j: usize, k: usize) -> f64 {
    let [i, j, k] = [i, j, k].map(|flat| table_2d(side, flat));
    product_integral(&[&i, &j, &k])
}

fn table_1d(size: usize, flat: usize) -> Vec<f64> {
    (0..size).map(|i| basis_1d(flat, (i as f64 + 0.5) / size as f64)).collect()
}

fn table_2d(side: usize, flat: usize) -> Vec<f64> {
    let centre = |i: usize| (i as f64 + 0.5) / side as f64;
    (0..side * side).map(|i| basis_nonstandard(flat, centre(i % side), centre(i / side))).collect()
}

/// Σ_ijk f_i g_j h_k C_ijk over all triples of 1D coefficients, each C by numeric integration.
pub fn triple_sum_1d(f: &[f64], g: &[f64], h: &[f64]) -> f64 {
    triple_sum(f, g, h, |i| table_1d(f.len(), i))
}

/// Σ_ijk f_i g_j h_k C_ijk over all triples of 2D nonstandard coefficients, each C by numeric integration.
pub fn triple_sum_2d(f: &[f64], g: &[f64], h: &[f64]) -> f64 {
    let side = f.len().isqrt();
    triple_sum(f, g, h, |i| table_2d(side, i))
}

fn triple_sum(f: &[f64], g: &[f64], h: &[f64], table: impl Fn(usize) -> Vec<f64>) -> f64 {
    let basis: Vec<_> = (0..f.len()).map(table).collect();
    let kept = |c: &[f64]| (0..c.len()).filter(|&i| c[i] != 0.0).collect::<Vec<_>>();
    let (js, ks) = (kept(g), kept(h));
    let mut sum = 0.0;
    for i in kept(f) {
        for &j in &js {
            for &k in &ks {
                sum += f[i] * g[j] * h[k] * product_integral(&[&basis[i], &basis[j], &basis[k]]);
            }
        }
    }
    sum
}

/// Coefficients of the product of 1D signals given by coefficients: to samples, multiply, back.
pub fn product_1d(factors: &[&[f64]]) -> Vec<f64> {
    forward_1d(&multiply(&factors.iter().map(|f| inverse_1d(f)).collect::<Vec<_>>()))
}

/// Coefficients of the product of 2D signals given by nonstandard coefficients: to texels, multiply, back.
pub fn product_2d(factors: &[&[f64]]) -> Vec<f64> {
    forward_nonstandard(&multiply(&factors.iter().map(|f| inverse_nonstandard(f)).collect::<Vec<_>>()))
}

fn multiply(factors: &[Vec<f64>]) -> Vec<f64> {
    let samples = factors.first().map_or(0, Vec::len);
    (0..samples).map(|i| factors.iter().map(|f| f[i]).product()).collect()
}

/// Σ of `pixels` whose bit is set, row-major or Morton alike: bit i mod 64 of word i / 64.
pub fn masked_sum(pixels: &[f64], words: &[u64]) -> f64 {
    pixels.iter().enumerate().filter(|(i, _)| words[i / 64] >> (i % 64) & 1 == 1).map(|(_, p)| p).sum()
}
