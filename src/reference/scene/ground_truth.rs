//! Radiance by one sum over everything.

use nalgebra::Vector3;

use crate::numeric::GaussLegendre;
use crate::sphere::{CubeMap, Face};

/// f(wi, wo) in local coordinates, RGB.
pub type Reflectance<'a> = dyn Fn(&Vector3<f64>, &Vector3<f64>) -> Vector3<f64> + 'a;

/// Σ over all texels of light × visibility × f × max(cos θ_i, 0) × solid angle, for one vertex.
///
/// Directions and solid angles are recomputed here from the cube's geometry; each solid angle by a 24 × 24
/// Gauss–Legendre rule over its texel, good to rounding. `frame` is (tangent, bitangent, normal), `wo` the direction to
/// the viewer in world coordinates, `visibility` gives the weight of a flat texel index, and `brdf` takes wi and wo in
/// local coordinates.
pub fn radiance(
    light: &CubeMap<Vector3<f32>>,
    visibility: &dyn Fn(usize) -> f64,
    brdf: &Reflectance,
    frame: [Vector3<f64>; 3],
    wo: &Vector3<f64>,
) -> Vector3<f64> {
    let side = light.grid().side();
    let rule = GaussLegendre::new(24).expect("24 points");
    let local = |d: &Vector3<f64>| Vector3::new(frame[0].dot(d), frame[1].dot(d), frame[2].dot(d));
    let wo = local(wo);
    let mut sum = Vector3::zeros();
    let mut index = 0;
    for face in Face::ALL {
        for y in 0..side {
            for x in 0..side {
                let cell = 2.0 / side as f64;
                let (u, v) = ((x as f64 + 0.5) * cell - 1.0, (y as f64 + 0.5) * cell - 1.0);
                let wi = local(&face.point(u, v).normalize());
                if wi.z > 0.0 && wo.z > 0.0 {
                    let l = light.texels()[index].cast::<f64>();
                    let f = brdf(&wi, &wo);
                    let factor = visibility(index) * wi.z * solid_angle(x, y, side, &rule);
                    sum += l.component_mul(&f) * factor;
                }
                index += 1;
            }
        }
    }
    sum
}

/// ∫ du dv / (1 + u² + v²)^{3/2} over the texel.
fn solid_angle(x: usize, y: usize, side: usize, rule: &GaussLegendre) -> f64 {
    let half = 1.0 / side as f64;
    let at = |i: usize, node: f64| (2 * i + 1) as f64 * half - 1.0 + node * half;
    let mut sum = 0.0;
    for (node_v, weight_v) in rule.nodes().iter().zip(rule.weights()) {
        for (node_u, weight_u) in rule.nodes().iter().zip(rule.weights()) {
            let (u, v) = (at(x, *node_u), at(y, *node_v));
            sum += weight_u * weight_v * half * half * (1.0 + u * u + v * v).powf(-1.5);
        }
    }
    sum
}
