//! Lights, irradiance and polygons by quadrature.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{UnitVector3, Vector3};

use super::{basis, product, project_cap};
use crate::numeric::GaussLegendre;

/// ∫ L max(n · ω, 0) dω of an expansion L, of any bands.
pub fn irradiance(radiance: &[f64], normal: &UnitVector3<f64>) -> f64 {
    let bands = radiance.len().isqrt();
    let hemisphere = project_cap(bands, normal, FRAC_PI_2, 1, |d| d.dot(normal));
    hemisphere.iter().zip(radiance).map(|(h, l)| h * l).sum()
}

/// L_H(N) = L ∗ H(N), truncated: the product of an expansion with H(N) = 1/π ∫ max(s · N, 0) y ds of `bands_cosine`
/// bands.
pub fn diffuse_light(light: &[f64], bands_cosine: usize, normal: &UnitVector3<f64>, bands_out: usize) -> Vec<f64> {
    let h = project_cap(bands_cosine, normal, FRAC_PI_2, 1, |d| d.dot(normal) / PI);
    product(light, &h, bands_out)
}

/// ∫ y_i dω over the directions in which a polygon is seen from the origin, above the plane of `horizon` if there is
/// one.
///
/// Vertices of a polygon in a plane, of any shape; signed, positive where they run counterclockwise around an outward
/// ray. The triangles (v_0, v_i, v_{i+1}) are cut into 4^`levels` and integrated in their plane by 12 × 12 points each:
/// smooth integrands to rounding, those that the horizon cuts to about 2^−levels of a triangle.
pub fn polygon(bands: usize, vertices: &[Vector3<f64>], horizon: Option<Vector3<f64>>, levels: u32) -> Vec<f64> {
    let mut out = vec![0.0; bands * bands];
    // It calls itself so often: 4^12 triangles take hours anyhow.
    let levels = levels.min(12);
    for i in 2..vertices.len() {
        let triangle = [vertices[0], vertices[i - 1], vertices[i]];
        add_triangle(bands, triangle, horizon, levels, &mut out);
    }
    out
}

fn add_triangle(
    bands: usize,
    [a, b, c]: [Vector3<f64>; 3],
    horizon: Option<Vector3<f64>>,
    levels: u32,
    out: &mut [f64],
) {
    if levels > 0 {
        let [d, e, f] = [(b + c) / 2.0, (c + a) / 2.0, (a + b) / 2.0];
        for part in [[a, f, e], [f, b, d], [e, d, c], [d, e, f]] {
            add_triangle(bands, part, horizon, levels - 1, out);
        }
        return;
    }
    let rule = GaussLegendre::new(12).expect("nodes");
    // x = a + r ((b − a)(1 − w) + (c − a) w), Jacobian r; x · (dA) = det (a, b − a, c − a) dr dw r.
    let determinant = a.dot(&(b - a).cross(&(c - a)));
    for (r, wr) in rule.nodes().iter().zip(rule.weights()) {
        for (w, ww) in rule.nodes().iter().zip(rule.weights()) {
            let (r, w) = (0.5 + 0.5 * r, 0.5 + 0.5 * w);
            let x = a + ((b - a) * (1.0 - w) + (c - a) * w) * r;
            if horizon.is_some_and(|n| n.dot(&x) < 0.0) {
                continue;
            }
            let weight = 0.25 * wr * ww * r * determinant / x.norm().powi(3);
            let y = basis(bands, &UnitVector3::new_normalize(x));
            out.iter_mut().zip(y).for_each(|(out, y)| *out += weight * y);
        }
    }
}
