//! glTF 2.0 and GLB.
//!
//! The crate `gltf` parses the JSON. Its validation and its accessor readers are not used: both index and add without
//! checks, so that a damaged file panics in them. What is read here is checked here instead, and a fault elsewhere in
//! the file (materials, animations) does no harm.

use std::cell::OnceCell;
use std::path::{Component, Path, PathBuf};

use ::gltf::json::accessor::{ComponentType, Type};
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use ::gltf::json::{self, Root};
use nalgebra::{Matrix3, Matrix4, Quaternion, UnitQuaternion, Vector3};

use super::assemble::{Count, Soup, plural};
use super::{Loaded, MeshOptions, Report, describe, excerpt};
use crate::Result;
use crate::scene::Mesh;

/// The most vertices, and the most triangles, that the instances of a scene may add up to: 2²⁶.
const MOST: usize = 1 << 26;

/// Reads a glTF 2.0 file, JSON or GLB, from its bytes; `name` is what messages call it.
///
/// All triangles of the default scene (else of the first scene, else of all nodes) become one mesh, with the nodes'
/// transforms applied; a transform that mirrors turns its triangles round. Lists, strips and fans are read; positions
/// are `f32` or quantised (`KHR_mesh_quantization`), normals likewise. Buffers are the GLB's own or base64 data URIs;
/// those in files beside need [`load_mesh`](super::load_mesh), which follows relative paths into the file's own folder
/// or below and nothing else (no `..`, no absolute path, no other scheme; symbolic links are followed).
///
/// Points and lines are left out with a warning, as are skins and morph targets: a skinned mesh stands as stored,
/// without its node's transform. Repaired is what is repaired in [every format](super#meshes).
///
/// # Errors
/// [`Error::File`](crate::Error::File) with the line of the JSON or the name of the object in it: sparse or compressed accessors (Draco,
/// meshopt), other required extensions, no `POSITION`, anything that reaches outside its buffer, NaN or infinite
/// coordinates, indices out of range, a node that is reached twice, more than 2²⁶ vertices or triangles.
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

/// Whether a file begins like GLB.
pub(super) fn is_glb(bytes: &[u8]) -> bool {
    bytes.starts_with(b"glTF")
}

/// Reads with the buffers of the folder `base`, if there is one.
pub(super) fn read_with_base(
    bytes: &[u8],
    name: impl AsRef<Path>,
    base: Option<&Path>,
    options: &MeshOptions,
) -> Result<Loaded<Mesh>> {
    let report = Report::new(name);
    if bytes.is_empty() {
        return Err(report.error("", "the file is empty"));
    }
    let (text, binary) = if is_glb(bytes) { split_glb(bytes, &report)? } else { (bytes, None) };
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let root: Root = json::deserialize::from_slice(text).map_err(|e| {
        // The message of the parser ends in the place, which we say first.
        let message = e.to_string();
        let reason = message.rsplit_once(" at line ").map_or(&*message, |(m, _)| m);
        report.error(format!("JSON line {} column {}", e.line(), e.column()), reason)
    })?;
    check_version(&root, &report)?;
    let buffers = Buffers { root: &root, binary, base, data: vec![OnceCell::new(); root.buffers.len()] };
    let mut reader = Reader { root: &root, buffers, report, soup: Soup::new(options), skipped: Skipped::default() };
    reader.scene()?;
    reader.finish()
}

/// The JSON and the binary chunk of a GLB file.
fn split_glb<'a>(bytes: &'a [u8], report: &Report) -> Result<(&'a [u8], Option<&'a [u8]>)> {
    let number = |at: usize| bytes.get(at..at + 4).and_then(|b| b.first_chunk().copied()).map(u32::from_le_bytes);
    let short = |at: usize| report.error(format!("byte {at}"), "the GLB file ends here");
    let version = number(4).ok_or_else(|| short(bytes.len()))?;
    if version != 2 {
        return Err(report.error("byte 4", format!("GLB version {version}; only 2 can be read")));
    }
    let length = number(8).ok_or_else(|| short(bytes.len()))? as usize;
    if length > bytes.len() {
        return Err(
            report.error("byte 8", format!("the GLB file says that it has {length} bytes, but it has {}", bytes.len()))
        );
    }
    let (mut text, mut binary) = (None, None);
    let mut at = 12;
    while at < length {
        let (size, kind) = number(at).zip(number(at + 4)).ok_or_else(|| short(bytes.len()))?;
        let chunk = (at + 8).checked_add(size as usize).and_then(|end| bytes[..length].get(at + 8..end));
        let chunk = chunk.ok_or_else(|| {
            report.error(format!("byte {at}"), format!("a GLB chunk of {size} bytes reaches beyond the file"))
        })?;
        match &kind.to_le_bytes() {
            b"JSON" if text.is_none() => text = Some(chunk),
            b"BIN\0" if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        at += 8 + size as usize;
    }
    let text = text.ok_or_else(|| report.error("byte 12", "the GLB file has no JSON chunk"))?;
    Ok((text, binary))
}

fn check_version(root: &Root, report: &Report) -> Result<()> {
    if !root.asset.version.starts_with("2.") {
        return Err(report.error(
            "asset",
            format!("glTF version \"{}\"; only 2 can be read", excerpt(root.asset.version.as_bytes())),
        ));
    }
    // Extensions that change how things look, not where the triangles are.
    let harmless = |e: &str| {
        e == "KHR_mesh_quantization"
            || ["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_"].iter().any(|p| e.starts_with(p))
    };
    match root.extensions_required.iter().find(|e| !harmless(e)) {
        Some(e) => {
            Err(report
                .error("extensionsRequired", format!("the extension \"{}\" cannot be read", excerpt(e.as_bytes()))))
        }
        None => Ok(()),
    }
}

/// The buffers, each loaded when it is first needed.
struct Buffers<'a> {
    root: &'a Root,
    binary: Option<&'a [u8]>,
    base: Option<&'a Path>,
    data: Vec<OnceCell<Vec<u8>>>,
}

impl Buffers<'_> {
    /// The bytes of a buffer; its length is at least what the file says.
    fn get(&self, index: usize) -> Result<&[u8], String> {
        let buffer = self.root.buffers.get(index).ok_or("there is no such buffer")?;
        let length = usize::try_from(buffer.byte_length.0).map_err(|_| "its length is beyond memory")?;
        let data = match &buffer.uri {
            None if index == 0 => self.binary.ok_or("it has no URI, and the file has no binary chunk")?,
            None => return Err("it has no URI (a placeholder of an extension?)".into()),
            Some(uri) => {
                if self.data[index].get().is_none() {
                    // Another value cannot have got in between: nothing else is running.
                    let _ = self.data[index].set(self.load(uri, length)?);
                }
                self.data[index].get().map_or(&[][..], Vec::as_slice)
            }
        };
        data.get(..length).ok_or_else(|| format!("it should have {length} bytes, but only {} are there", data.len()))
    }

    fn load(&self, uri: &str, length: usize) -> Result<Vec<u8>, String> {
        use std::io::Read;
        let shown = excerpt(uri.as_bytes());
        if let Some(data) = uri.strip_prefix("data:") {
            let (_, text) = data.split_once(";base64,").ok_or("its data URI is not base64")?;
            return base64(text.as_bytes());
        }
        let relative =
            relative_path(uri).ok_or_else(|| format!("\"{shown}\" is not a plain path into the file's own folder"))?;
        let base = self.base.ok_or_else(|| format!("\"{shown}\" is a file of its own; open the file by its path"))?;
        let path = base.join(relative);
        let failed = |e: std::io::Error| format!("\"{shown}\" cannot be read: {}", describe(&e));
        if path.is_dir() {
            return Err(format!("\"{shown}\" is a folder"));
        }
        let mut bytes = Vec::new();
        let file = std::fs::File::open(&path).map_err(failed)?;
        file.take(length as u64).read_to_end(&mut bytes).map_err(failed)?;
        Ok(bytes)
    }
}

/// The path of a relative URI that stays in its folder, with its %-codes decoded.
fn relative_path(uri: &str) -> Option<PathBuf> {
    let mut decoded = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        match (first, tail) {
            (b'%', [hi, lo, after @ ..]) => {
                let digit = |c: &u8| char::from(*c).to_digit(16);
                decoded.push((16 * digit(hi)? + digit(lo)?) as u8);
                rest = after;
            }
            (b'%', _) => return None,
            _ => decoded.push(*first),
        }
    }
    let text = String::from_utf8(decoded).ok()?;
    // Backslashes, colons and NUL mean something on some systems.
    if text.is_empty() || text.contains(['\\', ':', '\0']) {
        return None;
    }
    let path = PathBuf::from(text);
    path.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir)).then_some(path)
}

/// Decodes base64, padded or not.
fn base64(text: &[u8]) -> Result<Vec<u8>, String> {
    let unpadded = text.strip_suffix(b"==").or(text.strip_suffix(b"=")).unwrap_or(text);
    let mut out = Vec::with_capacity(unpadded.len() / 4 * 3 + 2);
    for (i, group) in unpadded.chunks(4).enumerate() {
        let mut bits = 0_u32;
        for (j, &c) in group.iter().enumerate() {
            let digit = match c {
                b'A'..=b'Z' => c - b'A',
                b'a'..=b'z' => c - b'a' + 26,
                b'0'..=b'9' => c - b'0' + 52,
                b'+' | b'-' => 62,
                b'/' | b'_' => 63,
                _ => return Err(format!("character {} of its data URI is not base64", 4 * i + j)),
            };
            bits |= u32::from(digit) << (18 - 6 * j);
        }
        if group.len() == 1 {
            return Err("its data URI is cut short".into());
        }
        out.extend_from_slice(&bits.to_be_bytes()[1..group.len()]);
    }
    Ok(out)
}

/// The elements of an accessor, checked to be inside their buffer.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
    component: ComponentType,
    normalised: bool,
}

impl<'a> Elements<'a> {
    fn new(root: &Root, buffers: &'a Buffers<'_>, index: usize, shape: Type) -> Result<Self, String> {
        let accessor = root.accessors.get(index).ok_or("there is no such accessor")?;
        if accessor.sparse.is_some() {
            return Err("sparse accessors cannot be read".into());
        }
        let (Checked::Valid(component), Checked::Valid(type_)) = (accessor.component_type, accessor.type_) else {
            return Err("its type is not one of glTF".into());
        };
        if type_ != shape {
            return Err(format!("it holds {type_:?}, not {shape:?}"));
        }
        let component = component.0;
        let size = component.size() * shape.multiplicity();
        let view = accessor.buffer_view.ok_or("it has no buffer view (compressed data cannot be read)")?;
        let view = root.buffer_views.get(view.value()).ok_or("there is no such buffer view")?;
        let stride = view.byte_stride.map_or(size, |s| s.0);
        if stride < size {
            return Err(format!("its stride of {stride} bytes is shorter than its elements of {size}"));
        }
        let count = usize::try_from(accessor.count.0).map_err(|_| "its count is beyond memory")?;
        let data = buffers.get(view.buffer.value()).map_err(|e| format!("buffer {}: {e}", view.buffer.value()))?;
        let number = |n: u64| usize::try_from(n).ok();
        let view_start = number(view.byte_offset.map_or(0, |o| o.0));
        let in_view = view_start
            .and_then(|start| Some(start..start.checked_add(number(view.byte_length.0)?)?))
            .and_then(|range| data.get(range))
            .ok_or("its buffer view reaches beyond the buffer")?;
        let length =
            if count == 0 { Some(0) } else { (count - 1).checked_mul(stride).and_then(|n| n.checked_add(size)) };
        let bytes = number(accessor.byte_offset.map_or(0, |o| o.0))
            .and_then(|start| Some(start..start.checked_add(length?)?))
            .and_then(|range| in_view.get(range))
            .ok_or_else(|| format!("its {count} elements reach beyond the buffer view"))?;
        Ok(Self { bytes, stride, count, component, normalised: accessor.normalized })
    }

    /// Component `c` of element `i`, scaled to [−1, 1] or [0, 1] if it is a normalised integer.
    fn get(&self, i: usize, c: usize) -> f64 {
        let at = i * self.stride + c * self.component.size();
        let b = &self.bytes[at..at + self.component.size()];
        let (value, full) = match self.component {
            ComponentType::I8 => (f64::from(b[0] as i8), 127.0),
            ComponentType::U8 => (f64::from(b[0]), 255.0),
            ComponentType::I16 => (f64::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            ComponentType::U16 => (f64::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            ComponentType::U32 => (f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])), f64::from(u32::MAX)),
            ComponentType::F32 => (f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])), 1.0),
        };
        if self.normalised { (value / full).max(if full == 1.0 { value } else { -1.0 }) } else { value }
    }

    fn vector(&self, i: usize) -> Vector3<f64> {
        Vector3::from_fn(|c, _| self.get(i, c))
    }
}

#[derive(Debug, Default)]
struct Skipped {
    primitives: Count,
    skins: Count,
    morphs: Count,
    uneven: Count,
}

struct Reader<'a> {
    root: &'a Root,
    buffers: Buffers<'a>,
    report: Report,
    soup: Soup,
    skipped: Skipped,
}

impl Reader<'_> {
    /// Walks the nodes, parents before children.
    fn scene(&mut self) -> Result<()> {
        let root = self.root;
        let scene = match root.scene {
            Some(i) => {
                Some(root.scenes.get(i.value()).ok_or_else(|| self.report.error("scene", "there is no such scene"))?)
            }
            None => root.scenes.first(),
        };
        let mut roots: Vec<usize> = match scene {
            Some(scene) => scene.nodes.iter().map(|n| n.value()).collect(),
            None => {
                let mut is_child = vec![false; root.nodes.len()];
                let children = root.nodes.iter().flat_map(|n| n.children.iter().flatten());
                children.for_each(|c| is_child.get_mut(c.value()).into_iter().for_each(|b| *b = true));
                (0..root.nodes.len()).filter(|&i| !is_child[i]).collect()
            }
        };
        roots.reverse();
        let mut stack: Vec<_> = roots.into_iter().map(|n| (n, Matrix4::identity())).collect();
        let mut seen = vec![false; root.nodes.len()];
        while let Some((index, parent)) = stack.pop() {
            let place = format!("node {index}");
            let node = root.nodes.get(index).ok_or_else(|| self.report.error(&*place, "there is no such node"))?;
            if std::mem::replace(&mut seen[index], true) {
                return Err(self.report.error(place, "is reached twice; nodes must form a tree"));
            }
            let world: Matrix4<f64> = parent * local_transform(node);
            if !world.iter().all(|c| c.is_finite()) {
                return Err(self.report.error(place, "its transform is NaN or infinite"));
            }
            if let Some(mesh) = node.mesh {
                if node.skin.is_some() {
                    self.skipped.skins.add(|| place.clone());
                }
                let transform = if node.skin.is_some() { Matrix4::identity() } else { world };
                self.mesh(mesh.value(), &transform)?;
            }
            stack.extend(node.children.iter().flatten().rev().map(|c| (c.value(), world)));
        }
        Ok(())
    }

    fn mesh(&mut self, index: usize, transform: &Matrix4<f64>) -> Result<()> {
        let root = self.root;
        let mesh = root
            .meshes
            .get(index)
            .ok_or_else(|| self.report.error(format!("mesh {index}"), "there is no such mesh"))?;
        for (i, primitive) in mesh.primitives.iter().enumerate() {
            let place = format!("mesh {index} primitive {i}");
            if primitive.targets.as_ref().is_some_and(|t| !t.is_empty()) {
                self.skipped.morphs.add(|| place.clone());
            }
            match primitive.mode {
                Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => {
                    self.primitive(primitive, mode, transform, &place)?;
                }
                Checked::Valid(_) => self.skipped.primitives.add(|| place),
                Checked::Invalid => return Err(self.report.error(place, "its mode is not one of glTF")),
            }
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive, mode: Mode, transform: &Matrix4<f64>, place: &str) -> Result<()> {
        let at = |part: &str| format!("{place} {part}");
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|i| i.value());
        let elements = |part: &str, index, shape| {
            Elements::new(self.root, &self.buffers, index, shape)
                .map_err(|e| self.report.error(at(part), format!("accessor {index}: {e}")))
        };
        let positions = attribute(Semantic::Positions)
            .ok_or_else(|| self.report.error(place, "has no POSITION (compressed data cannot be read)"))?;
        let positions = elements("POSITION", positions, Type::Vec3)?;
        if positions.component == ComponentType::U32 {
            return Err(self.report.error(at("POSITION"), "positions cannot be 32-bit integers"));
        }
        let normals = attribute(Semantic::Normals).map(|i| elements("NORMAL", i, Type::Vec3)).transpose()?;
        if let Some(n) = normals.as_ref().filter(|n| n.count != positions.count) {
            return Err(self
                .report
                .error(at("NORMAL"), format!("{} normals for {} positions", n.count, positions.count)));
        }
        let indices = primitive.indices.map(|i| elements("indices", i.value(), Type::Scalar)).transpose()?;
        let corners =
            self.corners(indices.as_ref(), positions.count).map_err(|e| self.report.error(at("indices"), e))?;

        let before = self.soup.positions.len();
        let triangles = if mode == Mode::Triangles { corners.len() / 3 } else { corners.len().saturating_sub(2) };
        if before + positions.count > MOST || self.soup.faces.len() + triangles > MOST {
            return Err(self.report.error(place, "more than 2^26 vertices or triangles so far"));
        }
        let linear: Matrix3<f64> = transform.fixed_view::<3, 3>(0, 0).into_owned();
        let shift: Vector3<f64> = transform.fixed_view::<3, 1>(0, 3).into_owned();
        for i in 0..positions.count {
            self.soup.push_position(linear * positions.vector(i) + shift, || at(&format!("POSITION {i}")));
        }
        // Normals transform with the cofactors, det(M) · M⁻ᵀ, which need no inverse; the sign of a mirroring is
        // taken out again, since the triangles are turned round.
        let mirrored = linear.determinant() < 0.0;
        let cofactors = cofactors(&linear) * if mirrored { -1.0 } else { 1.0 };
        if normals.is_some() || self.soup.normals.is_some() {
            let list = self.soup.normals.get_or_insert_default();
            list.resize(before, Vector3::zeros());
            let normal = |n: &Elements<'_>, i| (cofactors * n.vector(i)).try_normalize(0.0).unwrap_or_default().cast();
            list.extend((0..positions.count).map(|i| normals.as_ref().map_or_else(Vector3::zeros, |n| normal(n, i))));
        }
        if mode == Mode::Triangles && corners.len() % 3 != 0 {
            self.skipped.uneven.add(|| place.to_owned());
        }
        let face = |k: usize| match mode {
            Mode::TriangleStrip if k % 2 == 1 => [corners[k + 1], corners[k], corners[k + 2]],
            Mode::TriangleStrip => [corners[k], corners[k + 1], corners[k + 2]],
            Mode::TriangleFan => [corners[0], corners[k + 1], corners[k + 2]],
            _ => [corners[3 * k], corners[3 * k + 1], corners[3 * k + 2]],
        };
        self.soup.faces.extend((0..triangles).map(|k| {
            let [a, b, c] = face(k).map(|i| i + before as u32);
            if mirrored { [a, c, b] } else { [a, b, c] }
        }));
        Ok(())
    }

    /// The vertex indices of a primitive in order.
    fn corners(&self, indices: Option<&Elements<'_>>, vertices: usize) -> Result<Vec<u32>, String> {
        let Some(indices) = indices else {
            return u32::try_from(vertices).map(|n| (0..n).collect()).map_err(|_| "more vertices than indices".into());
        };
        if !matches!(indices.component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
            return Err("indices must be unsigned integers".into());
        }
        (0..indices.count)
            .map(|i| {
                let index = indices.get(i, 0);
                (index < vertices as f64)
                    .then_some(index as u32)
                    .ok_or_else(|| format!("number {i}: vertex index {index} is out of range; there are {vertices}"))
            })
            .collect()
    }

    fn finish(mut self) -> Result<Loaded<Mesh>> {
        let report = &mut self.report;
        let Skipped { primitives, skins, morphs, uneven } = self.skipped;
        let points = primitives.n;
        primitives.warn(report, |n| format!("{} of points or lines left out", plural(n, "primitive", "primitives")));
        skins.warn(report, |n| format!("{} left out; the mesh stands as stored", plural(n, "skin", "skins")));
        morphs.warn(report, |n| format!("morph targets of {} left out", plural(n, "primitive", "primitives")));
        uneven.warn(report, |n| {
            format!("{} left over corners", plural(n, "list of triangles has", "lists of triangles have"))
        });
        if self.soup.faces.is_empty() {
            let reason = if points > 0 { "only points or lines" } else { "no triangles in the scene" };
            return Err(report.error("", reason));
        }
        if let Some(normals) = &mut self.soup.normals {
            normals.resize(self.soup.positions.len(), Vector3::zeros());
        }
        self.soup.into_mesh(self.report)
    }
}

fn local_transform(node: &json::Node) -> Matrix4<f64> {
    if let Some(m) = node.matrix {
        return Matrix4::from_column_slice(&m.map(f64::from));
    }
    let [x, y, z, w] = node.rotation.map_or([0.0, 0.0, 0.0, 1.0], |q| q.0).map(f64::from);
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_homogeneous();
    let translation = Vector3::from(node.translation.unwrap_or_default().map(f64::from));
    let scale = Vector3::from(node.scale.unwrap_or([1.0; 3]).map(f64::from));
    Matrix4::new_translation(&translation) * rotation * Matrix4::new_nonuniform_scaling(&scale)
}

/// The matrix of cofactors: column i is the cross product of the other two columns.
fn cofactors(m: &Matrix3<f64>) -> Matrix3<f64> {
    let column = |i: usize| m.column(i).into_owned();
    Matrix3::from_columns(&[column(1).cross(&column(2)), column(2).cross(&column(0)), column(0).cross(&column(1))])
}
