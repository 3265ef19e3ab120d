//! What tests of mesh files share.

use haarmonic::io::{Loaded, load_mesh};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::Mesh;

/// A file of `tests/faults`.
pub fn fault(name: &str) -> Loaded<Mesh> {
    load_mesh(format!("{}/tests/faults/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

pub fn v(x: f32, y: f32, z: f32) -> Vector3<f32> {
    Vector3::new(x, y, z)
}

/// The messages, without the name of the file.
pub fn messages(loaded: &Loaded<Mesh>) -> Vec<String> {
    loaded.warnings.iter().map(|w| format!("{}: {}", w.place, w.message)).collect()
}

#[track_caller]
pub fn check(loaded: &Loaded<Mesh>, faces: usize, area: f64) {
    let sum: f64 = loaded.value.face_areas().iter().sum();
    assert_eq!(loaded.value.faces().len(), faces);
    // Areas of few faces with coordinates of order 1: a few roundings of f32.
    assert!((sum - area).abs() <= 1e-5 * area, "area {sum}, not {area}");
}
