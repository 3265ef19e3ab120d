//! glTF 2.0 and GLB.
//!
//! The JSON is read field by field, and only what a mesh needs: the crates for glTF check a file as a whole, so that a
//! fault in an animation or a material loses the mesh, and their accessor readers index and add without checks.
//!
//! | file | what |
//! |---|---|
//! | `container` | GLB chunks, JSON text |
//! | `document` | fields of JSON objects |
//! | `buffers` | bytes: binary chunk, data URIs, files beside |
//! | `accessor` | typed elements, sparse ones too |
//! | `instances` | node transforms, `EXT_mesh_gpu_instancing` |
//! | `primitive` | vertices and triangles |
//! | `bystanders` | warnings for faults in what a mesh does not need |

mod accessor;
mod buffers;
mod bystanders;
mod container;
mod document;
mod instances;
mod primitive;

use std::path::Path;

use nalgebra::Matrix4;
use serde_json::Value;

use self::buffers::Buffers;
pub(super) use self::container::is_glb;
use self::document::{MESHES, NODES, Object, SCENES, field, index, indices, list};
use super::MeshOptions;
use super::assemble::Soup;
use crate::io::count::{Count, plural};
use crate::io::report::{Loaded, Report, excerpt};
use crate::scene::Mesh;
use crate::{Error, Result};

/// Reads a glTF 2.0 file, JSON or GLB, from its bytes; `name` is what messages call it.
///
/// All triangles of the default scene (else of the first scene, else of all nodes) become one mesh, with the nodes'
/// transforms applied in `f64`; a transform that mirrors turns its triangles round. Lists, strips and fans are read;
/// positions are `f32` or quantised (`KHR_mesh_quantization`), normals likewise. Accessors may be sparse or without a
/// buffer view (zeros, by the standard). Every instance of `EXT_mesh_gpu_instancing` is read.
///
/// A primitive without normals is flat, as the standard demands: every corner has the normal of its face, and every
/// face vertices of its own (a vertex keeps its place in the list for the first one; the others are appended).
///
/// Texture coordinates are `TEXCOORD_0`, `f32` or integers; v, which runs downwards in these files, becomes 1 − v, so
/// that it runs upwards as in [`Mesh::uv`]. Other sets and `KHR_texture_transform` are not read. A set that cannot be
/// read is left out with a warning.
///
/// Buffers are the GLB's own or base64 data URIs; those in files beside need [`load_mesh`](super::load_mesh), which
/// follows relative paths into the file's own folder or below and nothing else (no `..`, no absolute path, no other
/// scheme; symbolic links are followed).
///
/// Left out with a warning are points and lines, skins and morph targets: a skinned mesh stands as stored, without its
/// node's transform. Animations, materials, textures, images, samplers, cameras, names and extras are not read; a field
/// of theirs or of a skin that is not what the standard says is a warning, one for each kind of object.
///
/// Repaired with a warning: GLB chunks that are out of order, padded in other ways than the standard's or cut short,
/// and a length of the whole that is not true; JSON that is not UTF-8, has NaN for a number (null) or is padded with
/// NUL; instances that cannot be read (the mesh stands once); and what is repaired in [every format](crate::io#meshes).
///
/// # Errors
/// [`Error::File`] with the line of the JSON or the name of the object in it: compressed data (Draco, meshopt), other
/// required extensions, no `POSITION`, anything that reaches outside its buffer, NaN or infinite coordinates of a face,
/// indices out of range, a node that is reached twice, more than 2²⁶ vertices or triangles, more than 2¹⁶ positions or
/// indices (16 for each sparse one) without a buffer view.
pub fn read_gltf(bytes: &[u8], name: impl AsRef<Path>) -> Result<Loaded<Mesh>> {
    read_gltf_with(bytes, name, &MeshOptions::default())
}

/// [`read_gltf`] as the options say.
///
/// # Errors
/// Those of [`read_gltf`].
pub fn read_gltf_with(bytes: &[u8], name: impl AsRef<Path>, options: &MeshOptions) -> Result<Loaded<Mesh>> {
    read_with_base(bytes, name, None, options)
}

/// Reads with the buffers of the folder `base`, if there is one.
pub(super) fn read_with_base(
    bytes: &[u8],
    name: impl AsRef<Path>,
    base: Option<&Path>,
    options: &MeshOptions,
) -> Result<Loaded<Mesh>> {
    let mut report = Report::new(name);
    if bytes.is_empty() {
        return Err(report.error("", "the file is empty"));
    }
    let (text, binary) = container::split(bytes, &mut report)?;
    let root = container::parse(text, &mut report)?;
    check_version(&root, &mut report)?;
    bystanders::inspect(&root, &mut report);
    let buffers = Buffers::new(&root, binary, base);
    let soup = Soup::new(options);
    let mut reader = Reader { buffers: &buffers, report, soup, has_flat: false, skipped: Skipped::default() };
    reader.scene()?;
    reader.finish()
}

fn check_version(root: &Object, report: &mut Report) -> Result<()> {
    match field(root, "asset").and_then(|a| a.get("version")) {
        Some(Value::String(version)) if version.starts_with("2.") => {}
        Some(Value::String(version)) => {
            let reason = format!("glTF version \"{}\"; only 2 can be read", excerpt(version.as_bytes()));
            return Err(report.error("asset", reason));
        }
        _ => return Err(report.error("asset", "has no \"version\"; a glTF document must state it")),
    }
    let required = list(root, "extensionsRequired").unwrap_or_else(|reason| {
        report.warn("extensionsRequired", reason);
        &[]
    });
    match required.iter().filter_map(Value::as_str).find(|e| !is_harmless(e)) {
        Some(e) => {
            let reason = format!("the extension \"{}\" cannot be read", excerpt(e.as_bytes()));
            Err(report.error("extensionsRequired", reason))
        }
        None => Ok(()),
    }
}

/// Whether a required extension can be read here, or changes how things look and not where the triangles are.
fn is_harmless(extension: &str) -> bool {
    const READ: [&str; 2] = ["KHR_mesh_quantization", "EXT_mesh_gpu_instancing"];
    const SUBJECTS: [&str; 7] = ["materials_", "texture_", "lights_", "animation_", "audio", "interactivity", "xmp"];
    // A name is the vendor, an underscore, the subject.
    let subject = extension.split_once('_').map_or("", |(_, s)| s);
    READ.contains(&extension) || SUBJECTS.iter().any(|s| subject.starts_with(s))
}

#[derive(Debug, Default)]
struct Skipped {
    primitives: Count,
    skins: Count,
    morphs: Count,
    uneven: Count,
    uv: Count,
}

struct Reader<'a> {
    buffers: &'a Buffers<'a>,
    report: Report,
    soup: Soup,
    /// Whether a primitive so far had no normals.
    has_flat: bool,
    skipped: Skipped,
}

impl<'a> Reader<'a> {
    fn root(&self) -> &'a Object {
        self.buffers.root()
    }

    /// Makes an error of a reason.
    fn fault<'s>(&'s self, place: &str) -> impl FnOnce(String) -> Error + use<'s, 'a> {
        let place = place.to_owned();
        move |reason| self.report.error(place, reason)
    }

    /// The nodes without a parent that are to be shown.
    fn roots(&self) -> Result<Vec<usize>> {
        let root = self.root();
        let scenes = SCENES.entries(root).map_err(self.fault("scenes"))?;
        let scene = match index(root, "scene").map_err(self.fault("scene"))? {
            None if scenes.is_empty() => {
                let nodes = NODES.entries(root).map_err(self.fault("nodes"))?;
                let mut is_child = vec![false; nodes.len()];
                for (i, node) in nodes.iter().enumerate() {
                    let children = node.as_object().map_or(Ok(Vec::new()), |node| indices(node, "children"));
                    let children = children.map_err(self.fault(&format!("node {i}")))?;
                    children.iter().for_each(|&c| is_child.get_mut(c).into_iter().for_each(|b| *b = true));
                }
                return Ok((0..nodes.len()).filter(|&i| !is_child[i]).collect());
            }
            scene => SCENES.entry(root, scene.unwrap_or(0)).map_err(self.fault("scene"))?,
        };
        indices(scene, "nodes").map_err(self.fault("scene"))
    }

    /// Walks the nodes, parents before children.
    fn scene(&mut self) -> Result<()> {
        let mut roots = self.roots()?;
        roots.reverse();
        let mut stack: Vec<_> = roots.into_iter().map(|n| (n, Matrix4::identity())).collect();
        let mut seen = vec![false; NODES.entries(self.root()).map_or(0, <[_]>::len)];
        while let Some((number, parent)) = stack.pop() {
            let place = format!("node {number}");
            let node = NODES.entry(self.root(), number).map_err(self.fault(&place))?;
            if std::mem::replace(&mut seen[number], true) {
                return Err(self.report.error(place, "is reached twice; nodes must form a tree"));
            }
            let world: Matrix4<f64> = parent * instances::local_transform(node).map_err(self.fault(&place))?;
            if !world.iter().all(|c| c.is_finite()) {
                return Err(self.report.error(place, "its transform is NaN or infinite"));
            }
            if let Some(mesh) = index(node, "mesh").map_err(self.fault(&place))? {
                let skins = list(self.root(), "skins").map_or(0, <[_]>::len);
                let skinned = index(node, "skin").is_ok_and(|s| s.is_some_and(|s| s < skins));
                if skinned {
                    self.skipped.skins.add(|| place.clone());
                }
                let transform = if skinned { Matrix4::identity() } else { world };
                let transforms = instances::transforms(self.buffers, node, &transform).unwrap_or_else(|reason| {
                    let message = format!("{reason}; the mesh stands there once");
                    self.report.warn(format!("{place} EXT_mesh_gpu_instancing"), message);
                    vec![transform]
                });
                self.mesh(mesh, &transforms)?;
            }
            let children = indices(node, "children").map_err(self.fault(&place))?;
            stack.extend(children.into_iter().rev().map(|c| (c, world)));
        }
        Ok(())
    }

    /// Adds a mesh, once for each transform.
    fn mesh(&mut self, number: usize, transforms: &[Matrix4<f64>]) -> Result<()> {
        let place = format!("mesh {number}");
        let mesh = MESHES.entry(self.root(), number).map_err(self.fault(&place))?;
        for (i, primitive) in list(mesh, "primitives").map_err(self.fault(&place))?.iter().enumerate() {
            let place = format!("{place} primitive {i}");
            let Some(primitive) = primitive.as_object() else {
                return Err(self.report.error(place, "is not an object"));
            };
            if list(primitive, "targets").is_ok_and(|t| !t.is_empty()) {
                self.skipped.morphs.add(|| place.clone());
            }
            match index(primitive, "mode") {
                Ok(mode @ (None | Some(4..=6))) => self.primitive(primitive, mode, transforms, &place)?,
                Ok(Some(0..=3)) => self.skipped.primitives.add(|| place),
                _ => return Err(self.report.error(place, "its mode is not one of glTF")),
            }
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Loaded<Mesh>> {
        let report = &mut self.report;
        let Skipped { primitives, skins, morphs, uneven, uv } = self.skipped;
        let points = primitives.n;
        primitives.warn(report, |n| format!("{} of points or lines left out", plural(n, "primitive", "primitives")));
        skins.warn(report, |n| format!("{} left out; the mesh stands as stored", plural(n, "skin", "skins")));
        morphs.warn(report, |n| format!("morph targets of {} left out", plural(n, "primitive", "primitives")));
        uneven.warn(report, |n| {
            format!("{} left over corners", plural(n, "list of triangles has", "lists of triangles have"))
        });
        uv.warn(report, |n| {
            let what = plural(n, "primitive has texture coordinates", "primitives have texture coordinates");
            format!("{what} that cannot be read; left out")
        });
        if let Some(normals) = &mut self.soup.normals {
            normals.resize(self.soup.positions.len(), nalgebra::Vector3::zeros());
        }
        if self.soup.faces.is_empty() {
            let reason = if points > 0 { "only points or lines" } else { "no triangles in the scene" };
            return Err(report.error("", reason));
        }
        self.soup.into_mesh(self.report)
    }
}
