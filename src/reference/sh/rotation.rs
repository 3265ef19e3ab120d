//! Rotation of expansions by quadrature.

use nalgebra::{Rotation3, UnitVector3, Vector3};

use super::basis;
use crate::numeric::GaussLegendre;

/// Directions and weights that integrate polynomials up to `degree` exactly.
fn rule(degree: usize) -> Vec<(UnitVector3<f64>, f64)> {
    let gauss = GaussLegendre::new(degree / 2 + 1).expect("at least one node");
    let step = 2.0 * std::f64::consts::PI / (degree + 1) as f64;
    let mut nodes = Vec::new();
    for (&z, &weight) in gauss.nodes().iter().zip(gauss.weights()) {
        let across = ((1.0 - z) * (1.0 + z)).sqrt();
        for i in 0..=degree {
            let (sin, cos) = (i as f64 * step).sin_cos();
            nodes.push((UnitVector3::new_normalize(Vector3::new(across * cos, across * sin, z)), weight * step));
        }
    }
    nodes
}

/// M_ij = ∫ y_i(Rω) y_j(ω) dω, a row-major block for each degree below `bands`: y(Rω) = M y(ω), and M f are the
/// coefficients of f(R⁻¹ω).
pub fn rotation(bands: usize, rotation: &Rotation3<f64>) -> Vec<Vec<f64>> {
    let mut blocks: Vec<_> = (0..bands).map(|l| vec![0.0; (2 * l + 1) * (2 * l + 1)]).collect();
    for (d, weight) in rule(2 * bands) {
        let (turned, y) = (basis(bands, &(rotation * d)), basis(bands, &d));
        for (l, block) in blocks.iter_mut().enumerate() {
            let (size, rows) = (2 * l + 1, l * l..(l + 1) * (l + 1));
            for (block, a) in block.chunks_exact_mut(size).zip(&turned[rows.clone()]) {
                block.iter_mut().zip(&y[rows.clone()]).for_each(|(m, b)| *m += weight * a * b);
            }
        }
    }
    blocks
}

/// The coefficients of f(R⁻¹ω): evaluate there, project. `f` has bands² coefficients.
pub fn rotate(f: &[f64], rotation: &Rotation3<f64>) -> Vec<f64> {
    let bands = f.len().isqrt();
    let mut out = vec![0.0; f.len()];
    for (d, weight) in rule(2 * bands) {
        let there = basis(bands, &(rotation.inverse() * d));
        let value: f64 = f.iter().zip(there).map(|(f, y)| f * y).sum();
        out.iter_mut().zip(basis(bands, &d)).for_each(|(out, y)| *out += weight * value * y);
    }
    out
}
