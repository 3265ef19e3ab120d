//! Normals of faces and vertices, and what is perpendicular to them.

use nalgebra::Vector3;

/// Twice the area of a triangle, along its normal.
pub(super) fn double_area_vector([a, b, c]: &[Vector3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// The unit vector along `v`, unless that is zero or not finite.
pub(super) fn unit(v: &Vector3<f32>) -> Option<Vector3<f32>> {
    let v = v.cast::<f64>();
    let length = v.norm();
    (length > 0.0 && length.is_finite()).then(|| (v / length).cast())
}

pub(super) fn angle_weighted_normals(positions: &[Vector3<f32>], faces: &[[u32; 3]]) -> Vec<Vector3<f32>> {
    let mut sums = vec![Vector3::<f64>::zeros(); positions.len()];
    for face in faces {
        let corners = face.map(|i| positions[i as usize].cast::<f64>());
        let Some(normal) = double_area_vector(&corners).try_normalize(0.0) else {
            continue;
        };
        for k in 0..3 {
            let to = |j: usize| corners[(k + j) % 3] - corners[k];
            sums[face[k] as usize] += normal * to(1).angle(&to(2));
        }
    }
    sums.iter().map(|s| s.try_normalize(1e-30).unwrap_or_else(Vector3::y).cast()).collect()
}

/// A unit vector perpendicular to a unit vector.
pub(super) fn perpendicular(n: &Vector3<f32>) -> Vector3<f32> {
    let axis = if n.x.abs() < 0.8 { Vector3::x() } else { Vector3::z() };
    (axis - n * n.dot(&axis)).normalize()
}
