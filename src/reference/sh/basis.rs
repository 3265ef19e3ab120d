//! The real basis from (θ, φ), each degree by itself.

use std::f64::consts::PI;

use nalgebra::{Matrix3, UnitVector3, Vector3};

/// p_m = N_lm P_l^m(z) / (1 − z²)^{m/2} for m = 0…l, with N_lm² = (2l+1)/4π · (l−m)!/(l+m)! and no (−1)^m.
///
/// Recurrence in the order m at fixed degree, downwards from p_l, the direction in which it is stable:
///
/// ```math
/// √((l+m)(l−m+1)) p_{m−1} = 2 m z p_m − (1 − z²) √((l−m)(l+m+1)) p_{m+1}
/// ```
///
/// It follows from P^{m+1} = 2 m z/√(1−z²) P^m − (l+m)(l−m+1) P^{m−1}. The fast path recurs in l at fixed m instead.
/// `across2` is 1 − z², passed apart because it is the better known of the two near the poles.
pub fn associated_legendre(l: usize, z: f64, across2: f64) -> Vec<f64> {
    let mut p = vec![0.0; l + 2];
    // N_ll (2l − 1)!! squared is (2l+1)/4π Π (2k−1)/2k.
    p[l] = ((2 * l + 1) as f64 / (4.0 * PI) * (1..=l).map(|k| 1.0 - 0.5 / k as f64).product::<f64>()).sqrt();
    for m in (1..=l).rev() {
        let up = (((l - m) * (l + m + 1)) as f64).sqrt();
        let down = (((l + m) * (l - m + 1)) as f64).sqrt();
        p[m - 1] = (2.0 * m as f64 * z * p[m] - across2 * up * p[m + 1]) / down;
    }
    p.truncate(l + 1);
    p
}

/// y_{l,m} at a direction: real, orthonormal, no Condon–Shortley phase.
///
/// ```math
/// y_{l,0} = N P_l,  y_{l,m} = √2 N P_l^m cos mφ,  y_{l,−m} = √2 N P_l^m sin mφ  (m > 0)
/// ```
pub fn basis_function(l: usize, m: isize, direction: &UnitVector3<f64>) -> f64 {
    let d = direction.normalize();
    let across = d.x.hypot(d.y);
    let p = associated_legendre(l, d.z, across * across);
    from_angles(p[m.unsigned_abs()], m, across, d.y.atan2(d.x))
}

/// All y of `bands` at a direction, index l(l+1) + m.
pub fn basis(bands: usize, direction: &UnitVector3<f64>) -> Vec<f64> {
    let d = direction.normalize();
    let across = d.x.hypot(d.y);
    let azimuth = d.y.atan2(d.x);
    let mut out = Vec::new();
    for l in 0..bands {
        let p = associated_legendre(l, d.z, across * across);
        let l = l as isize;
        out.extend((-l..=l).map(|m| from_angles(p[m.unsigned_abs()], m, across, azimuth)));
    }
    out
}

fn from_angles(p: f64, m: isize, across: f64, azimuth: f64) -> f64 {
    let ring = across.powi(m.unsigned_abs() as i32);
    match m {
        0 => p,
        1.. => 2f64.sqrt() * p * ring * (m as f64 * azimuth).cos(),
        _ => 2f64.sqrt() * p * ring * (-m as f64 * azimuth).sin(),
    }
}

/// Tangent gradients of all y of `bands`, by central differences of sixth order along two great circles.
///
/// Accuracy: about 1e-12 · l² of the largest; the step is chosen for l ≤ 20 or so.
pub fn basis_gradient(bands: usize, direction: &UnitVector3<f64>) -> Vec<Vector3<f64>> {
    let d = direction.into_inner();
    let first = if d.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() }.cross(&d).normalize();
    let second = d.cross(&first);
    let step = 0.06 / (bands as f64 + 1.0);
    let mut out = vec![Vector3::zeros(); bands * bands];
    for tangent in [first, second] {
        for (k, weight) in [(1.0, 0.75), (2.0, -0.15), (3.0, 1.0 / 60.0)] {
            for sign in [1.0, -1.0] {
                let (sin, cos) = (sign * k * step).sin_cos();
                let at = UnitVector3::new_normalize(d * cos + tangent * sin);
                for (g, y) in out.iter_mut().zip(basis(bands, &at)) {
                    *g += tangent * (sign * weight * y / step);
                }
            }
        }
    }
    out
}

/// Hessians on the sphere of all y of `bands`, by second differences of sixth order along three great circles.
///
/// uᵀHu is the second derivative along the great circle in direction u; H ω = 0.
/// Accuracy: about 3e-12 · l² of the largest; the step is chosen for l ≤ 20 or so.
pub fn basis_hessian(bands: usize, direction: &UnitVector3<f64>) -> Vec<Matrix3<f64>> {
    let d = direction.into_inner();
    let first = if d.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() }.cross(&d).normalize();
    let second = d.cross(&first);
    let step = 0.12 / (bands as f64 + 1.0);
    let along = |tangent: Vector3<f64>| {
        let mut sum = vec![0.0; bands * bands];
        for (k, weight) in [(0.0, -49.0 / 18.0), (1.0, 1.5), (2.0, -0.15), (3.0, 1.0 / 90.0)] {
            for sign in if k == 0.0 { &[1.0][..] } else { &[1.0, -1.0] } {
                let (sin, cos) = (sign * k * step).sin_cos();
                let at = UnitVector3::new_normalize(d * cos + tangent * sin);
                sum.iter_mut().zip(basis(bands, &at)).for_each(|(s, y)| *s += weight * y / (step * step));
            }
        }
        sum
    };
    let (a, b, both) = (along(first), along(second), along((first + second).normalize()));
    let crossed = first * second.transpose() + second * first.transpose();
    (0..bands * bands)
        .map(|i| {
            let mixed = both[i] - (a[i] + b[i]) / 2.0;
            first * first.transpose() * a[i] + second * second.transpose() * b[i] + crossed * mixed
        })
        .collect()
}
