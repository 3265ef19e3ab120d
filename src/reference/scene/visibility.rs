//! Every triangle against every ray, in `f64`.

use nalgebra::Vector3;

use crate::scene::{BackFaces, Mesh};

/// The face that a ray meets first and its distance in units of the direction's length; [Möller and Trumbore 1997].
///
/// Back faces count under [`BackFaces::Occlude`]. A ray in the plane of a face misses it.
pub fn closest_hit(
    mesh: &Mesh,
    origin: &Vector3<f64>,
    direction: &Vector3<f64>,
    back_faces: BackFaces,
) -> Option<(usize, f64)> {
    let mut closest: Option<(usize, f64)> = None;
    for face in 0..mesh.faces().len() {
        let [a, b, c] = mesh.corners(face).map(|p| p.cast::<f64>());
        let (e, f) = (b - a, c - a);
        let p = direction.cross(&f);
        let determinant = e.dot(&p);
        // Positive where the ray meets the front.
        if determinant == 0.0 || (back_faces == BackFaces::Ignore && determinant < 0.0) {
            continue;
        }
        let s = origin - a;
        let q = s.cross(&e);
        let (u, v, t) = (s.dot(&p) / determinant, direction.dot(&q) / determinant, f.dot(&q) / determinant);
        if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && closest.is_none_or(|(_, nearest)| t < nearest) {
            closest = Some((face, t));
        }
    }
    closest
}

/// Whether a ray meets any face.
pub fn occluded(mesh: &Mesh, origin: &Vector3<f64>, direction: &Vector3<f64>, back_faces: BackFaces) -> bool {
    closest_hit(mesh, origin, direction, back_faces).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_triangle() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Vector3::from);
        let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
        let (above, down) = (Vector3::new(0.25, 0.25, 2.0), Vector3::new(0.0, 0.0, -2.0));
        assert_eq!(closest_hit(&mesh, &above, &down, BackFaces::Ignore), Some((0, 1.0)));
        assert!(!occluded(&mesh, &above, &-down, BackFaces::Occlude));
        let below = Vector3::new(0.25, 0.25, -2.0);
        assert!(occluded(&mesh, &below, &-down, BackFaces::Occlude));
        assert!(!occluded(&mesh, &below, &-down, BackFaces::Ignore));
        assert!(!occluded(&mesh, &Vector3::new(0.6, 0.6, 2.0), &down, BackFaces::Occlude));
    }
}
