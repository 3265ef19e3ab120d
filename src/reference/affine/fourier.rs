//! The Fourier basis (2π)^{−1/2} e^{ipv} on [0, 2π], by quadrature.

use std::f64::consts::TAU;

use nalgebra::Complex;

use crate::affine::AffineMap;
use crate::numeric::GaussLegendre;

/// ∫₀^{2π} of functions of the basis at given arguments; `waves` bounds the turns of the product.
fn integrate(waves: f64, f: impl Fn(f64) -> Complex<f64>) -> Complex<f64> {
    let rule = GaussLegendre::new(16).expect("16 nodes");
    let panels = 2 * waves.ceil() as usize + 1;
    let part = |take: fn(Complex<f64>) -> f64| -> f64 {
        let edge = |k: usize| TAU * k as f64 / panels as f64;
        (0..panels).map(|k| rule.integrate(edge(k), edge(k + 1), |v| take(f(v)))).sum()
    };
    Complex::new(part(|z| z.re), part(|z| z.im))
}

fn basis(p: i64, v: f64) -> Complex<f64> {
    Complex::from_polar(TAU.sqrt().recip(), p as f64 * v)
}

/// D_pq = ∫₀^{2π} φ_p(sv + o) φ_q*(v) dv.
pub fn fourier_coupling(p: i64, q: i64, map: AffineMap) -> Complex<f64> {
    let waves = (map.scale() * p as f64).abs() + q.abs() as f64;
    integrate(waves, |v| basis(p, map.scale() * v + map.offset()) * basis(q, v).conj())
}

/// D_npq = ∫₀^{2π} φ_n(sv + o) φ_p(v) φ_q*(v) dv.
pub fn fourier_tripling(n: i64, p: i64, q: i64, map: AffineMap) -> Complex<f64> {
    let waves = (map.scale() * n as f64).abs() + (p.abs() + q.abs()) as f64;
    integrate(waves, |v| basis(n, map.scale() * v + map.offset()) * basis(p, v) * basis(q, v).conj())
}
