//! Files: meshes and pictures in and out.
//!
//! | format | read | write | by |
//! |---|---|---|---|
//! | OBJ | yes | no | own reader |
//! | PLY, ASCII and binary of both byte orders | yes | binary little endian, with float colours | own reader |
//! | glTF 2.0, `.gltf` and `.glb` | yes | no | crate `serde_json`, own reader of what a mesh needs |
//! | Radiance HDR (RGBE) | yes | yes | own reader and writer |
//! | OpenEXR, flat, every compression but HTJ2K | yes | yes (lossless ZIP, 32-bit float) | own reader and writer |
//! | PNG, 8 and 16 bits | yes | 8 bits, sRGB | crate `image` |
//!
//! Nothing here panics on the content of a file. What cannot be read is an [`Error::File`] that names the file and the
//! place in it; what could be repaired comes back with a [`Warning`] in [`Loaded`]. What a header promises is
//! checked against the bytes that are there before memory is taken for it. Every reader also exists as a function
//! of bytes (`read_obj`, `read_ply`, …), which never touches the file system.
//!
//! Every `save_…` writes a temporary file beside its target and renames it, so that an interrupted run leaves either
//! the old file or the new one.
//!
//! # Meshes
//! What [`load_mesh`] and the readers of meshes do with every format, each with a [`Warning`] where it changes the file:
//!
//! | what | becomes |
//! |---|---|
//! | coordinates that `f32` would round visibly, as far from zero | an origin is taken off in `f64`: [`Mesh::origin`] |
//! | polygons | triangles: a fan around the first corner where that covers it (always for convex ones), ear clipping (crate `earcut`) otherwise; holes are joined to the outline by bridges, corners that come twice. An outline that crosses itself is cut as well as it can be |
//! | vertices that are NaN or infinite | dropped if no face uses them, else an error |
//! | faces without area, vertices without a face | dropped |
//! | normals that are missing, zero or not finite | computed from the faces, weighted by angle |
//! | faces there twice, once each way round, without normals | two sides with vertices of their own |
//! | winding that disagrees or points inwards, in closed surfaces | turned where it is clear: [`Winding`] |
//! | a mesh whose z or x axis points up | turned, on demand: [`Up`] |
//!
//! # Pictures
//! Pixels and colours are linear RGB radiance in `f32`, of the primaries and white of Rec. 709; files that name others are
//! converted, with a warning. PNG alone is sRGB-encoded.
//!
//! # Example
//! ```
//! use haarmonic::io::read_obj;
//!
//! let quad = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
//! let loaded = read_obj(quad, "quad.obj")?;
//! assert_eq!(loaded.value.faces(), [[0, 1, 2], [0, 2, 3]]);
//! assert!(loaded.warnings.is_empty());
//!
//! let e = read_obj(b"v 0 0 0\nv 1 zero 0\n", "bad.obj").unwrap_err();
//! assert_eq!(e.to_string(), "bad.obj, line 2: \"zero\" is not a number");
//! # Ok::<(), haarmonic::Error>(())
//! ```

mod assemble;
mod atomic;
mod count;
mod environment;
mod exr;
mod gltf;
mod hdr;
mod image;
mod number;
mod obj;
mod options;
mod origin;
mod ply;
mod ply_out;
mod png;
mod polygon;
mod primaries;
mod repair;
mod sides;
mod split;
mod winding;

use std::borrow::Cow;
use std::path::{Path, PathBuf};

pub use self::environment::{
    EnvironmentLayout, load_environment, load_environment_with, read_environment, read_environment_with,
};
pub use self::exr::{encode_exr, read_exr};
pub use self::gltf::{read_gltf, read_gltf_with};
pub use self::hdr::{encode_hdr, read_hdr};
pub use self::image::{Image, load_image, read_image, save_exr, save_hdr, save_png, save_png_srgb8};
pub use self::obj::{read_obj, read_obj_with};
pub use self::options::{MeshOptions, Up, Winding};
pub use self::ply::{read_ply, read_ply_with};
pub use self::ply_out::{encode_ply, save_ply};
pub use self::png::{encode_png, encode_png_srgb8, read_png};
use crate::scene::Mesh;
use crate::{Error, Result};

/// What a file held, and what had to be repaired or left out to read it.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct Loaded<T> {
    /// The content.
    pub value: T,
    /// The repairs and omissions, in the order they were found; empty for a clean file.
    pub warnings: Vec<Warning>,
}

impl<T> Loaded<T> {
    /// The content turned into something else, with the same warnings.
    pub fn map<U>(self, f: impl FnOnce(T) -> U) -> Loaded<U> {
        Loaded { value: f(self.value), warnings: self.warnings }
    }
}

/// Something in a file that was repaired or left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// The file.
    pub path: PathBuf,
    /// Where in it (the first place, if there are several); empty where the whole file is meant.
    pub place: String,
    /// What was found and what was done about it.
    pub message: String,
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.place.as_str() {
            "" => write!(f, "{}: {}", self.path.display(), self.message),
            place => write!(f, "{}, {place}: {}", self.path.display(), self.message),
        }
    }
}

/// The name of the file being read and the warnings so far; makes the errors.
#[derive(Debug)]
struct Report {
    path: PathBuf,
    warnings: Vec<Warning>,
}

impl Report {
    fn new(path: impl AsRef<Path>) -> Self {
        Self { path: path.as_ref().to_owned(), warnings: Vec::new() }
    }

    fn error(&self, place: impl Into<String>, reason: impl Into<String>) -> Error {
        Error::File { path: self.path.clone(), place: place.into(), reason: reason.into() }
    }

    fn warn(&mut self, place: impl Into<String>, message: impl Into<String>) {
        self.warnings.push(Warning { path: self.path.clone(), place: place.into(), message: message.into() });
    }

    fn loaded<T>(self, value: T) -> Loaded<T> {
        Loaded { value, warnings: self.warnings }
    }
}

/// Reads a mesh file: OBJ, PLY, glTF or GLB.
///
/// [`load_mesh_with`] with the default options: y is up, and closed surfaces that are wound inside out are turned.
///
/// # Errors
/// [`Error::File`] with the place for anything that cannot be read or repaired.
pub fn load_mesh(path: impl AsRef<Path>) -> Result<Loaded<Mesh>> {
    load_mesh_with(path, &MeshOptions::default())
}

/// Reads a mesh file: OBJ, PLY, glTF or GLB, as the options say.
///
/// The first bytes decide where they can (PLY, GLB), the extension otherwise. See [`read_obj`], [`read_ply`] and
/// [`read_gltf`] for what each reader takes, skips and repairs. What they have in common is on the
/// [module's page](self#meshes).
///
/// A `.gltf` file may name buffers beside it. Only relative paths to the file's own folder or below are followed.
///
/// # Errors
/// [`Error::File`] with the place for anything that cannot be read or repaired.
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

/// The whole content of a file that must not be empty.
fn read_file(path: &Path) -> Result<Vec<u8>> {
    let report = Report::new(path);
    if path.is_dir() {
        return Err(report.error("", "is a folder, not a file"));
    }
    let bytes = std::fs::read(path).map_err(|e| report.error("", format!("cannot be read: {}", describe(&e))))?;
    if bytes.is_empty() {
        return Err(report.error("", "the file is empty"));
    }
    Ok(bytes)
}

/// An operating-system error in words that do not depend on the system, where there are any.
fn describe(e: &std::io::Error) -> Cow<'static, str> {
    match e.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".into(),
        std::io::ErrorKind::PermissionDenied => "permission denied".into(),
        _ => e.to_string().into(),
    }
}

/// A short piece of a file for a message: printable, at most 32 characters.
fn excerpt(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(128)]);
    let mut out: String = text.chars().take(32).flat_map(char::escape_debug).collect();
    if text.chars().count() > 32 || bytes.len() > 128 {
        out.push('…');
    }
    out
}
