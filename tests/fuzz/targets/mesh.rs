//! Readers of meshes.

use haarmonic::Result;
use haarmonic::io::{
    Loaded, MeshOptions, Up, Winding, encode_ply, read_gltf_with, read_obj_with, read_ply, read_ply_with,
};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::Mesh;

use super::{NAME, check_error, split};

/// A PLY file, ASCII or binary.
pub fn ply(data: &[u8]) {
    let (settings, file) = split(data);
    check(read_ply_with(file, NAME, &options(settings)));
}

/// An OBJ file.
pub fn obj(data: &[u8]) {
    let (settings, file) = split(data);
    check(read_obj_with(file, NAME, &options(settings)));
}

/// A GLB file, or JSON whose buffers are in it.
pub fn gltf(data: &[u8]) {
    let (settings, file) = split(data);
    check(read_gltf_with(file, NAME, &options(settings)));
}

fn options(settings: usize) -> MeshOptions {
    let up = [Up::Y, Up::Z, Up::X][settings % 3];
    let winding = [Winding::Repair, Winding::Keep][settings / 3 % 2];
    MeshOptions::default().with_up(up).with_winding(winding)
}

fn check(read: Result<Loaded<Mesh>>) {
    let Loaded { value: mesh, warnings } = match read {
        Ok(loaded) => loaded,
        Err(error) => return check_error(&error),
    };
    for warning in &warnings {
        assert!(warning.path.as_os_str() == NAME && !warning.message.is_empty(), "{warning:?}");
    }
    let vertices = mesh.positions().len();
    assert_eq!((mesh.normals().len(), mesh.tangents().len()), (vertices, vertices));
    if let Some(uv) = mesh.uv() {
        assert!(uv.len() == vertices && uv.iter().all(|c| c.x.is_finite() && c.y.is_finite()), "{uv:?}");
    }
    assert!(mesh.origin().iter().all(|c| c.is_finite()), "origin {:?}", mesh.origin());
    let mut used = vec![false; vertices];
    for face in mesh.faces() {
        for &corner in face {
            used[corner as usize] = true;
        }
        assert!(face[0] != face[1] && face[1] != face[2] && face[2] != face[0], "{face:?}");
    }
    assert!(!mesh.faces().is_empty() && used.iter().all(|&used| used), "vertices without a face");
    for (v, position) in mesh.positions().iter().enumerate() {
        assert!(position.iter().all(|c| c.is_finite()), "position {v}: {position:?}");
        for unit in [&mesh.normals()[v], &mesh.tangents()[v]] {
            assert!((unit.cast::<f64>().norm() - 1.0).abs() < 1e-5, "direction at vertex {v}: {unit:?}");
        }
    }
    assert!(mesh.face_areas().iter().all(|&area| area > 0.0 && area.is_finite()), "{:?}", mesh.face_areas());
    assert!(mesh.bounds().radius().is_finite());

    // Written and read it is what it was. Far from zero another origin may be chosen then, and thin faces rounded away.
    let colours = vec![Vector3::repeat(0.5); vertices];
    let written = encode_ply(&mesh, Some(&colours)).expect("there is a colour a vertex");
    let again = read_ply(&written, NAME);
    if mesh.origin() == Vector3::zeros() {
        let again = again.expect("what is written can be read").value;
        assert_eq!((again.positions().len(), again.faces().len()), (vertices, mesh.faces().len()));
        assert_eq!(again.uv().is_some(), mesh.uv().is_some());
    }
}
