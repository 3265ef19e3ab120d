//! Meshes: readers of three formats, and one way from what a file holds to a [`Mesh`].

mod assemble;
mod gltf;
mod number;
mod obj;
mod options;
mod ply;
mod ply_out;
mod split;

use std::path::Path;

pub use self::gltf::{read_gltf, read_gltf_with};
pub use self::obj::{read_obj, read_obj_with};
pub use self::options::{MeshOptions, Up, Winding};
pub use self::ply::{read_ply, read_ply_with};
pub use self::ply_out::{encode_ply, save_ply};
use super::report::{Loaded, Report, read_file};
use crate::Result;
use crate::scene::Mesh;

/// Reads a mesh file: OBJ, PLY, glTF or GLB.
///
/// [`load_mesh_with`] with the default options: y is up, and closed surfaces that are wound inside out are turned.
///
/// # Errors
/// [`Error::File`](crate::Error::File) with the place for anything that cannot be read or repaired.
pub fn load_mesh(path: impl AsRef<Path>) -> Result<Loaded<Mesh>> {
    load_mesh_with(path, &MeshOptions::default())
}

/// Reads a mesh file: OBJ, PLY, glTF or GLB, as the options say.
///
/// The first bytes decide where they can (PLY, GLB), the extension otherwise. See [`read_obj`], [`read_ply`] and
/// [`read_gltf`] for what each reader takes, skips and repairs. What they have in common is on the
/// [module's page](crate::io#meshes).
///
/// A `.gltf` file may name buffers beside it. Only relative paths to the file's own folder or below are followed.
///
/// # Errors
/// [`Error::File`](crate::Error::File) with the place for anything that cannot be read or repaired.
pub fn load_mesh_with(path: impl AsRef<Path>, options: &MeshOptions) -> Result<Loaded<Mesh>> {
    let path = path.as_ref();
    let bytes = read_file(path)?;
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    if ply::is_ply(&bytes) {
        return read_ply_with(&bytes, path, options);
    }
    if gltf::is_glb(&bytes) {
        return gltf::read_with_base(&bytes, path, path.parent(), options);
    }
    match extension.as_str() {
        "obj" => read_obj_with(&bytes, path, options),
        "ply" => read_ply_with(&bytes, path, options),
        "gltf" | "glb" => gltf::read_with_base(&bytes, path, path.parent(), options),
        _ => Err(Report::new(path).error("", "not a mesh format that can be read: OBJ, PLY, glTF, GLB")),
    }
}
