//! Files that were read and written: meshes, pictures, environments.
#![cfg(feature = "io")]

mod assets;
mod files;
mod gltf;
mod mesh_faults;
mod mesh_origin;
mod mesh_polygons;
mod meshes;
mod pictures;
mod ply;
#[path = "../support/mod.rs"]
mod support;
mod texture;
