//! Zonal functions by quadrature.

use std::f64::consts::PI;

use nalgebra::{UnitVector3, Vector3};

use super::basis;
use crate::numeric::GaussLegendre;

/// P_l(cos θ) by Laplace's integral 1/π ∫_0^π Re (cos θ + i sin θ cos φ)^l dφ.
///
/// The integrand is a trigonometric polynomial of degree l in φ, which l + 1 equidistant points integrate exactly.
pub fn legendre(l: usize, angle: f64) -> f64 {
    let (sin, cos) = angle.sin_cos();
    let points = l + 1;
    let value = |k: usize| {
        let across = sin * (PI * (k as f64 + 0.5) / points as f64).cos();
        cos.hypot(across).powi(l as i32) * (l as f64 * across.atan2(cos)).cos()
    };
    (0..points).map(value).sum::<f64>() / points as f64
}

/// k_l = 2π ∫ f(θ) P_l(cos θ) sin θ dθ, l < `bands`, over θ from `breaks[0]` to the last of them.
///
/// Panels shrink by halves towards every break, so that a jump, a kink or a root of θ there, or a narrow peak, costs no
/// accuracy: about 1e-14 of ∫ |f|.
pub fn zonal_factors(bands: usize, breaks: &[f64], f: impl Fn(f64) -> f64) -> Vec<f64> {
    let rule = GaussLegendre::new(24).expect("nodes");
    let mut sums = vec![0.0; bands];
    for pair in breaks.windows(2) {
        let half = 0.5 * (pair[1] - pair[0]);
        for level in 0..48 {
            let (near, far) =
                if level == 47 { (0.0, 0.5f64.powi(47)) } else { (0.5f64.powi(level + 1), 0.5f64.powi(level)) };
            for (start, sign) in [(pair[0], 1.0), (pair[1], -1.0)] {
                let (a, b) = (half * near, half * far);
                for (x, w) in rule.nodes().iter().zip(rule.weights()) {
                    let angle = start + sign * (0.5 * (a + b) + 0.5 * (b - a) * x);
                    let weight = 0.5 * (b - a) * w * 2.0 * PI * angle.sin() * f(angle);
                    sums.iter_mut().enumerate().for_each(|(l, sum)| *sum += weight * legendre(l, angle));
                }
            }
        }
    }
    sums
}

/// Σ_j √(4π/(2l+1)) f_l(θ_j) y_lm(ω_j): zonal functions, given by their coefficients (l, 0) for an angle, about
/// directions.
pub fn cap_sum(bands: usize, f: impl Fn(f64) -> Vec<f64>, caps: &[(UnitVector3<f64>, f64)]) -> Vec<f64> {
    let mut out = vec![0.0; bands * bands];
    for (direction, angle) in caps {
        let zonal = f(*angle);
        for (i, (out, y)) in out.iter_mut().zip(basis(bands, direction)).enumerate() {
            let l = i.isqrt();
            *out += (4.0 * PI / (2 * l + 1) as f64).sqrt() * zonal[l] * y;
        }
    }
    out
}

/// The cap that a sphere is from the origin: the direction to its centre and its angular radius, π/2 at the surface and
/// within. At the centre there is no direction.
pub fn sphere_cap(centre: &Vector3<f64>, radius: f64) -> Option<(UnitVector3<f64>, f64)> {
    let distance = centre.norm();
    let direction = UnitVector3::try_new(*centre, 0.0)?;
    Some((direction, (radius.max(0.0) / distance).min(1.0).asin()))
}

/// ∫ f(ω) y_i(ω) dω, all i of `bands`, over the directions within `half_angle` of an axis, by a rule exact for f of
/// `degree`.
///
/// Gauss–Legendre in the cosine and equidistant points in azimuth, both about the axis.
pub fn project_cap(
    bands: usize,
    axis: &UnitVector3<f64>,
    half_angle: f64,
    degree: usize,
    f: impl Fn(&UnitVector3<f64>) -> f64,
) -> Vec<f64> {
    let degree = degree + bands;
    let first = if axis.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() }.cross(axis).normalize();
    let second = axis.cross(&first);
    let versine = 2.0 * (0.5 * half_angle).sin().powi(2);
    let rule = GaussLegendre::new(degree / 2 + 1).expect("nodes");
    let mut out = vec![0.0; bands * bands];
    for (x, w) in rule.nodes().iter().zip(rule.weights()) {
        let down = 0.5 * versine * (1.0 + x);
        let across = (down * (2.0 - down)).sqrt();
        for k in 0..=degree {
            let step = 2.0 * PI / (degree + 1) as f64;
            let (sin, cos) = (k as f64 * step).sin_cos();
            let direction = axis.into_inner() * (1.0 - down) + (first * cos + second * sin) * across;
            let direction = UnitVector3::new_normalize(direction);
            let weight = 0.5 * versine * w * step * f(&direction);
            out.iter_mut().zip(basis(bands, &direction)).for_each(|(out, y)| *out += weight * y);
        }
    }
    out
}
