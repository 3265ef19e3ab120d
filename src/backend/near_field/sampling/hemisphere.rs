//! The hemisphere as a square without trigonometry: half an octahedron, turned by 45° [Cigolle et al. 2014].
//!
//! A direction d lies on the facet |q_x| + |q_y| + q_z = 1 at q = d/(|d_x| + |d_y| + d_z), and at w = ((q_x + q_y),
//! (q_x − q_y))/2 + ½ in the square. A facet is 1/√3 away from the centre and dq_x dq_y is 1/√3 of its area, so that
//!
//! ```math
//! dω = dq_x dq_y/|q|³,  dq_x dq_y = 2 dw.
//! ```

use nalgebra::Vector3;

/// The point of the octahedron, not of length 1, at w ∈ [0, 1]².
#[inline(always)]
pub(super) fn point([x, y]: [f64; 2]) -> Vector3<f64> {
    let (sum, difference) = (2.0 * x - 1.0, 2.0 * y - 1.0);
    let (x, y) = (0.5 * (sum + difference), 0.5 * (sum - difference));
    Vector3::new(x, y, (1.0 - x.abs() - y.abs()).max(0.0))
}

/// The place in the square of a direction of any length that does not point down.
#[inline(always)]
pub(super) fn coordinate(d: &Vector3<f64>) -> [f64; 2] {
    let q = d / (d.x.abs() + d.y.abs() + d.z);
    [0.5 * (q.x + q.y) + 0.5, 0.5 * (q.x - q.y) + 0.5]
}

/// dω/dw at a point of the octahedron.
#[inline(always)]
pub(super) fn solid_angle(q: &Vector3<f64>) -> f64 {
    2.0 / q.norm().powi(3)
}
