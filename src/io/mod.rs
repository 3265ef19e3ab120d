//! Files: meshes and pictures in and out.
//!
//! | format | read | write | by |
//! |---|---|---|---|
//! | OBJ | yes | no | own reader |
//! | PLY, ASCII and binary of both byte orders | yes | binary little endian, with texture coordinates and float colours | own reader |
//! | glTF 2.0, `.gltf` and `.glb` | yes | no | crate `serde_json`, own reader of what a mesh needs |
//! | Radiance HDR (RGBE) | yes | yes | own reader and writer |
//! | OpenEXR, flat, every compression but HTJ2K | yes | yes (lossless ZIP, 32-bit float) | own reader and writer |
//! | PNG, 8 and 16 bits | yes | 8 bits, sRGB; 8 and 16 bits, data | crate `image` |
//!
//! Nothing here panics on the content of a file. What cannot be read is an [`Error::File`](crate::Error::File) that
//! names the file and the place in it; what could be repaired comes back with a [`Warning`] in [`Loaded`]. What a
//! header promises is checked against the bytes that are there before memory is taken for it. Every reader also exists
//! as a function of bytes (`read_obj`, `read_ply`, …), which never touches the file system.
//!
//! Every `save_…` writes a temporary file beside its target and renames it, so that an interrupted run leaves either
//! the old file or the new one.
//!
//! # Meshes
//! What [`load_mesh`] and the readers of meshes do with every format, each with a [`Warning`] where it changes the
//! file:
//!
//! | what | becomes |
//! |---|---|
//! | coordinates that `f32` would round visibly, as far from zero | an origin is taken off in `f64`: [`Mesh::origin`](crate::scene::Mesh::origin) |
//! | polygons | triangles: a fan around the first corner where that covers it (always for convex ones), ear clipping (crate `earcut`) otherwise; holes are joined to the outline by bridges, corners that come twice. An outline that crosses itself is cut as well as it can be |
//! | vertices that are NaN or infinite | dropped if no face uses them, else an error |
//! | faces without area, vertices without a face | dropped |
//! | normals that are missing, zero or not finite | computed from the faces, weighted by angle |
//! | faces there twice, once each way round, without normals | two sides with vertices of their own |
//! | winding that disagrees or points inwards, in closed surfaces | turned where it is clear: [`Winding`] |
//! | texture coordinates that are NaN, infinite or, at some corners only, missing | (0, 0) |
//! | a mesh whose z or x axis points up | turned, on demand: [`Up`] |
//!
//! Texture coordinates are read and become [`Mesh::uv`](crate::scene::Mesh::uv), with v upwards: OBJ and PLY have it
//! so, glTF's v is turned round. Where the corners at a vertex have different ones, the vertex is split after
//! everything above, so that a seam of the texture changes neither positions, faces nor normals. A file without texture
//! coordinates makes a mesh without.
//!
//! # Pictures
//! Pixels and colours are linear RGB radiance in `f32`, of the primaries and white of Rec. 709; files that name others
//! are converted, with a warning. PNG alone is sRGB-encoded. Images that are no light, such as normal maps, are read as
//! they are stored by [`read_image_with`] and [`ImageEncoding::Data`].
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

mod atomic;
mod count;
mod mesh;
mod picture;
mod report;

pub use mesh::{
    MeshOptions, Up, Winding, encode_ply, load_mesh, load_mesh_with, read_gltf, read_gltf_with, read_obj,
    read_obj_with, read_ply, read_ply_with, save_ply,
};
pub use picture::{
    EnvironmentLayout, Image, ImageEncoding, PngDepth, encode_exr, encode_hdr, encode_png, encode_png_data,
    encode_png_srgb8, load_environment, load_environment_with, load_image, load_image_with, read_environment,
    read_environment_with, read_exr, read_hdr, read_image, read_image_with, read_png, save_exr, save_hdr, save_png,
    save_png_data, save_png_srgb8,
};
pub use report::{Loaded, Warning};
