//! Tripling coefficients by numeric integration, products by texels.

/// Samples of a function of the 1D basis on the grid of `size` cells, from its definition.
pub fn basis_1d(size: usize, flat: usize) -> Vec<f64> {
    let cell = |i: usize| (i as f64 + 0.5) / size as f64;
    if flat == 0 {
        return vec![1.0; size];
    }
    let level = flat.ilog2();
    let (scale, offset) = (f64::from(1 << level), (flat - (1 << level)) as f64);
    (0..size).map(|i| scale.sqrt() * mother(scale * cell(i) - offset)).collect()
}

/// Samples, row after row, of a function of the 2D nonstandard basis on the grid of `side`² texels, from its definition.
pub fn basis_2d(side: usize, flat: usize) -> Vec<f64> {
    let cell = |i: usize| (i as f64 + 0.5) / side as f64;
    if flat == 0 {
        return vec![1.0; side * side];
    }
    let level = flat.ilog2() / 2;
    let count = 1 << (2 * level);
    let (kind, at) = (flat / count, flat % count);
    let scale = f64::from(1 << level);
    let (tx, ty) = ((at % (1 << level)) as f64, (at / (1 << level)) as f64);
    let along = |wavelet: bool, v: f64| if wavelet { mother(v) } else { father(v) };
    let mut out = Vec::with_capacity(side * side);
    for y in 0..side {
        for x in 0..side {
            let fx = along(kind == 1 || kind == 3, scale * cell(x) - tx);
            let fy = along(kind == 2 || kind == 3, scale * cell(y) - ty);
            out.push(scale * fx * fy);
        }
    }
    out
}

fn father(v: f64) -> f64 {
    if (0.0..1.0).contains(&v) { 1.0 } else { 0.0 }
}

fn mother(v: f64) -> f64 {
    if (0.0..0.5).contains(&v) {
        1.0
    } else if (0.5..1.0).contains(&v) {
        -1.0
    } else {
        0.0
    }
}

/// Σ c_i ψ_i on the grid.
pub fn synthesise_1d(coefficients: &[f64]) -> Vec<f64> {
    synthesise(coefficients, |i| basis_1d(coefficients.len(), i))
}

/// Σ c_i Ψ_i on the grid, row after row; the length must be a square.
pub fn synthesise_2d(coefficients: &[f64]) -> Vec<f64> {
    let side = coefficients.len().isqrt();
    synthesise(coefficients, |i| basis_2d(side, i))
}

fn synthesise(coefficients: &[f64], basis: impl Fn(usize) -> Vec<f64>) -> Vec<f64> {
    let mut out = vec![0.0; coefficients.len()];
    for (i, &c) in coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0) {
        out.iter_mut().zip(basis(i)).for_each(|(o, b)| *o += c * b);
    }
    out
}

/// ∫ f ψ_i for every i, f constant on each cell.
pub fn analyse_1d(samples: &[f64]) -> Vec<f64> {
    (0..samples.len()).map(|i| pixel_product_integral(&[samples, &basis_1d(samples.len(), i)])).collect()
}

/// ∫∫ f Ψ_i for every i, f constant on each texel; the length must be a square.
pub fn analyse_2d(pixels: &[f64]) -> Vec<f64> {
    let side = pixels.len().isqrt();
    (0..pixels.len()).map(|i| pixel_product_integral(&[pixels, &basis_2d(side, i)])).collect()
}

/// Mean over the cells of the product of any number of signals; 0 factors or cells give NaN.
pub fn pixel_product_integral(factors: &[&[f64]]) -> f64 {
    let cells = factors.first().map_or(0, |f| f.len());
    let sum: f64 = (0..cells).map(|i| factors.iter().map(|f| f[i]).product::<f64>()).sum();
    sum / cells as f64
}

/// ∫ ψ_i ψ_j ψ_k by the midpoint rule on the grid of `size` cells, exact up to rounding.
pub fn tripling_1d(size: usize, i: usize, j: usize, k: usize) -> f64 {
    pixel_product_integral(&[&basis_1d(size, i), &basis_1d(size, j), &basis_1d(size, k)])
}

/// ∫∫ Ψ_i Ψ_j Ψ_k by the midpoint rule on the grid of `side`² texels, exact up to rounding.
pub fn tripling_2d(side: usize, i: usize, j: usize, k: usize) -> f64 {
    pixel_product_integral(&[&basis_2d(side, i), &basis_2d(side, j), &basis_2d(side, k)])
}

/// Σ_ijk f_i g_j h_k C_ijk over all N³ triples, C by numeric integration.
pub fn triple_sum_1d(f: &[f64], g: &[f64], h: &[f64]) -> f64 {
    triple_sum(f, g, h, |i| basis_1d(f.len(), i))
}

/// Σ_ijk f_i g_j h_k C_ijk over all N³ triples of the 2D nonstandard basis, C by numeric integration.
pub fn triple_sum_2d(f: &[f64], g: &[f64], h: &[f64]) -> f64 {
    let side = f.len().isqrt();
    triple_sum(f, g, h, |i| basis_2d(side, i))
}

fn triple_sum(f: &[f64], g: &[f64], h: &[f64], basis: impl Fn(usize) -> Vec<f64>) -> f64 {
    let basis: Vec<_> = (0..f.len()).map(basis).collect();
    let kept = |c: &[f64]| (0..c.len()).filter(|&i| c[i] != 0.0).collect::<Vec<_>>();
    let (js, ks) = (kept(g), kept(h));
    let mut sum = 0.0;
    for i in kept(f) {
        for &j in &js {
            for &k in &ks {
                sum += f[i] * g[j] * h[k] * pixel_product_integral(&[&basis[i], &basis[j], &basis[k]]);
            }
        }
    }
    sum
}
