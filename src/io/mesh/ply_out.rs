//! PLY out.

use std::fmt::Write as _;
use std::path::Path;

use nalgebra::Vector3;

use crate::io::atomic;
use crate::scene::Mesh;
use crate::{Error, Result};

/// Writes a mesh as PLY: binary little endian, positions and normals and, if there are any, texture coordinates and
/// linear RGB colours, all as `float`.
///
/// Texture coordinates are the properties `s t` of the vertices, with v upwards as in [`Mesh::uv`]. Tangents are not
/// written.
///
/// The colours are the properties `red green blue` of the vertices, of type `float` and not clamped: radiance goes in
/// and comes out. (Viewers that expect `uchar` colours show them scaled or not at all.) The positions of a mesh whose
/// [`origin`](Mesh::origin) is not zero are written as `double`, with the origin added: the file has world coordinates.
///
/// # Errors
/// [`Error::Length`] unless there is one colour a vertex; [`Error::File`] if the file cannot be written.
pub fn save_ply(path: impl AsRef<Path>, mesh: &Mesh, colours: Option<&[Vector3<f32>]>) -> Result<()> {
    atomic::write(path.as_ref(), &encode_ply(mesh, colours)?)
}

/// The bytes that [`save_ply`] writes.
///
/// # Errors
/// [`Error::Length`] unless there is one colour a vertex.
pub fn encode_ply(mesh: &Mesh, colours: Option<&[Vector3<f32>]>) -> Result<Vec<u8>> {
    let vertices = mesh.positions().len();
    if let Some(colours) = colours.filter(|c| c.len() != vertices) {
        return Err(Error::Length { what: "colours of a mesh", expected: vertices, got: colours.len() });
    }
    let mut header = String::from("ply\nformat binary_little_endian 1.0\n");
    if colours.is_some() {
        header.push_str("comment red green blue: linear RGB radiance\n");
    }
    // Writing to a string cannot fail.
    let _ = writeln!(header, "element vertex {vertices}");
    let far = mesh.origin() != Vector3::zeros();
    let mut names = vec!["nx", "ny", "nz"];
    names.extend(mesh.uv().iter().flat_map(|_| ["s", "t"]));
    names.extend(colours.iter().flat_map(|_| ["red", "green", "blue"]));
    for name in ["x", "y", "z"] {
        let _ = writeln!(header, "property {} {name}", if far { "double" } else { "float" });
    }
    for name in &names {
        let _ = writeln!(header, "property float {name}");
    }
    // More readers know signed indices.
    let index = if i32::try_from(vertices).is_ok() { "int" } else { "uint" };
    let _ =
        write!(header, "element face {}\nproperty list uchar {index} vertex_indices\nend_header\n", mesh.faces().len());

    let row = 4 * names.len() + if far { 24 } else { 12 };
    let mut out = Vec::with_capacity(header.len() + row * vertices + 13 * mesh.faces().len());
    out.extend_from_slice(header.as_bytes());
    for i in 0..vertices {
        let position = mesh.positions()[i];
        if far {
            let world = mesh.origin() + position.cast::<f64>();
            world.iter().for_each(|c| out.extend_from_slice(&c.to_le_bytes()));
        }
        let mut put = |numbers: &[f32]| numbers.iter().for_each(|c| out.extend_from_slice(&c.to_le_bytes()));
        if !far {
            put(position.as_slice());
        }
        put(mesh.normals()[i].as_slice());
        mesh.uv().into_iter().for_each(|uv| put(uv[i].as_slice()));
        colours.into_iter().for_each(|c| put(c[i].as_slice()));
    }
    for face in mesh.faces() {
        out.push(3);
        face.iter().for_each(|i| out.extend_from_slice(&i.to_le_bytes()));
    }
    Ok(out)
}
