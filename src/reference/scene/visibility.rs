//! Every triangle against every ray, in `f64`.

use nalgebra::{Isometry3, Point3, Vector3};

use crate::scene::{BackFaces, Mesh, Viewpoint};

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

/// Whether a viewpoint sees one of its local directions past objects that stand at poses: above its horizon, and met by
/// no face.
///
/// Rays start at the position itself, in `f64`.
pub fn is_free(
    objects: &[(&Mesh, Isometry3<f64>)],
    viewpoint: &Viewpoint,
    direction: &Vector3<f64>,
    back_faces: BackFaces,
) -> bool {
    let world = viewpoint.frame().map_or(*direction, |frame| frame.to_world(direction));
    viewpoint.horizon().is_none_or(|normal| normal.dot(&world) > 0.0)
        && objects.iter().all(|(mesh, pose)| {
            let origin = pose.inverse_transform_point(&Point3::from(viewpoint.position())).coords;
            !occluded(mesh, &origin, &pose.inverse_transform_vector(&world), back_faces)
        })
}

/// Whether a vertex sees a direction, for rays that start infinitely near it: the limit that an offset from the surface
/// stands for.
///
/// The ray starts at v + εs, ε → 0⁺, with s the normal plus a direction into the vertex's own faces along the surface.
/// Every quantity that decides whether it meets a face is linear in ε, so its sign is that of its value at ε = 0 or,
/// where that is exactly 0, of its derivative. No length is chosen and nothing is left out: the faces around v count as
/// they look from just above them, those that touch v likewise, and all others as seen from v itself. Below the horizon
/// (n·ω ≤ 0) nothing is seen.
///
/// # Panics
/// If `vertex` is out of range.
#[track_caller]
pub fn sees(mesh: &Mesh, vertex: usize, direction: &Vector3<f64>, back_faces: BackFaces) -> bool {
    let position = mesh.positions()[vertex].cast::<f64>();
    if mesh.normals()[vertex].cast::<f64>().dot(direction) <= 0.0 {
        return false;
    }
    let side = off_surface(mesh, vertex);
    (0..mesh.faces().len()).all(|face| {
        let corners = mesh.corners(face).map(|p| p.cast::<f64>() - position);
        !meets(&corners, &side, direction, back_faces)
    })
}

/// The direction s in which the rays of a vertex leave it: its normal, and the mean of the directions to the centres of
/// its faces along the surface.
fn off_surface(mesh: &Mesh, vertex: usize) -> Vector3<f64> {
    let (position, normal) = (mesh.positions()[vertex].cast::<f64>(), mesh.normals()[vertex].cast::<f64>());
    let own = (0..mesh.faces().len()).filter(|&face| mesh.faces()[face].contains(&(vertex as u32)));
    let to_centre = |face: usize| {
        let corners = mesh.corners(face).map(|p| p.cast::<f64>() - position);
        (corners[0] + corners[1] + corners[2]).try_normalize(0.0)
    };
    let directions: Vec<_> = own.filter_map(to_centre).collect();
    let mean = directions.iter().sum::<Vector3<f64>>() / directions.len().max(1) as f64;
    normal + mean - normal * normal.dot(&mean)
}

/// Whether the ray from εs, ε → 0⁺, meets a triangle.
fn meets(p: &[Vector3<f64>; 3], s: &Vector3<f64>, direction: &Vector3<f64>, back_faces: BackFaces) -> bool {
    let sign = |value: f64, derivative: f64| if value == 0.0 { derivative } else { value };
    let normal = (p[1] - p[0]).cross(&(p[2] - p[0]));
    let slant = normal.dot(direction);
    // Positive where the ray comes from behind.
    if slant == 0.0 || (back_faces == BackFaces::Ignore && slant > 0.0) {
        return false;
    }
    let nearest = p.iter().min_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared())).expect("three corners");
    let ahead = sign(nearest.dot(&normal), -s.dot(&normal)) * slant > 0.0;
    ahead
        && (0..3).all(|k| {
            let (a, b) = (p[k], p[(k + 1) % 3]);
            sign(a.cross(&b).dot(direction), -s.cross(&(b - a)).dot(direction)) * slant >= 0.0
        })
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

    /// A wedge of two walls on a floor's edge, and a floor vertex at its foot: hidden up to the wall, whichever way it
    /// leans.
    #[test]
    fn a_vertex_at_the_foot_of_a_wall() {
        for lean in [-0.5, 0.0, 0.4] {
            // The floor z = 0 for x > 0, its own vertices; the wall rises from the line x = 0.
            let floor = [[0., -1., 0.], [1., -1., 0.], [1., 1., 0.], [0., 1., 0.], [0., 0., 0.]];
            let wall = [[0., -1., 0.], [0., 1., 0.], [lean, 1., 1.], [lean, -1., 1.]];
            let positions = floor.iter().chain(&wall).map(|&p| Vector3::from(p)).collect();
            let faces = vec![[4, 0, 1], [4, 1, 2], [4, 2, 3], [5, 6, 7], [5, 7, 8]];
            let mesh = Mesh::new(positions, faces).unwrap();
            let sees = |x: f64, z: f64| super::sees(&mesh, 4, &Vector3::new(x, 0.01, z), BackFaces::Occlude);
            let lean = f64::from(lean);
            assert!(
                sees(lean + 1e-6, 1.0) && !sees(lean - 1e-6, 1.0) && sees(1.0, 1e-9) && !sees(-1.0, 1e-9),
                "{lean}"
            );
            assert!(!sees(1.0, -1e-9));
        }
    }
}
