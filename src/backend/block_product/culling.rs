//! Which vertices a picture needs.

use nalgebra::Vector3;

use crate::scene::{Camera, Mesh};

/// Marks the vertices of faces that turn their front to the camera and are not wholly to one side of the picture or
/// behind it.
pub(super) fn mark(mesh: &Mesh, camera: &Camera, aspect: f64, needed: &mut Vec<bool>) {
    needed.clear();
    needed.resize(mesh.positions().len(), false);
    let planes = planes(camera, aspect);
    let eye = camera.eye();
    for face in mesh.faces() {
        let corners = face.map(|v| mesh.positions()[v as usize].cast::<f64>() - eye);
        let front = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).dot(&corners[0]) < 0.0;
        let outside = planes.iter().any(|plane| corners.iter().all(|corner| plane.dot(corner) < 0.0));
        if front && !outside {
            face.iter().for_each(|&v| needed[v as usize] = true);
        }
    }
}

/// The planes through the eye and the edges of the picture, and the one across its axis: a point of the picture is on
/// the positive side of all.
fn planes(camera: &Camera, aspect: f64) -> [Vector3<f64>; 5] {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let corners = corners.map(|[x, y]| camera.direction(x * aspect, y).into_inner());
    let forward = camera.forward().into_inner();
    let side = |i: usize| {
        let plane = corners[i].cross(&corners[(i + 1) % 4]);
        plane * plane.dot(&forward).signum()
    };
    [side(0), side(1), side(2), side(3), forward]
}
