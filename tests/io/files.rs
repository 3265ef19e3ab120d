//! Files: round trips, hand-written files, and every kind of damage.

use std::path::Path;

use haarmonic::Error;
use haarmonic::io::*;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::Mesh;
use haarmonic::sphere::LatLongMap;
use proptest::prelude::*;

use crate::pictures::exr_files::COMPRESSIONS;

use crate::support::cases;

fn v(x: f32, y: f32, z: f32) -> Vector3<f32> {
    Vector3::new(x, y, z)
}

fn messages<T>(loaded: &Loaded<T>) -> Vec<String> {
    loaded.warnings.iter().map(ToString::to_string).collect()
}

type ReadMesh = fn(&[u8], &str) -> haarmonic::Result<Loaded<Mesh>>;

const READ_OBJ: ReadMesh = |b, n| read_obj(b, n);
const READ_PLY: ReadMesh = |b, n| read_ply(b, n);
const READ_GLTF: ReadMesh = |b, n| read_gltf(b, n);

fn obj(text: &str) -> haarmonic::Result<Loaded<Mesh>> {
    read_obj(text.as_bytes(), "a.obj")
}

fn ply(text: &str) -> haarmonic::Result<Loaded<Mesh>> {
    read_ply(text.as_bytes(), "a.ply")
}

#[track_caller]
fn golden<T: std::fmt::Debug>(result: haarmonic::Result<T>, message: &str) {
    assert_eq!(result.unwrap_err().to_string(), message);
}

// ---------------------------------------------------------------------------------------------------------- OBJ

#[test]
fn obj_forms_of_a_face() {
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";
    for face in [
        "f 1 2 3 4",
        "f 1/1 2/1 3/1 4/1",
        "f 1//1 2//1 3//1 4//1",
        "f 1/1/1 2/1/1 3/1/1 4/1/1",
        "f -4 -3 -2 -1",
        "fo 1 2 3 4",
    ] {
        let loaded = obj(&format!("{corners}{face}")).unwrap();
        assert_eq!(loaded.value.faces(), [[0, 1, 2], [0, 2, 3]], "{face}");
        assert_eq!(loaded.value.positions()[2], v(1.0, 1.0, 0.0));
        assert!(loaded.value.normals().iter().all(|n| *n == v(0.0, 0.0, 1.0)), "{face}");
        assert_eq!(loaded.warnings, []);
    }
}

#[test]
fn obj_lines_of_every_kind() {
    let text = "\u{feff}# Räder\r\nmtllib a b.mtl\r\no thing\ng a b\ns off\nv\t0 0 0 0.5 0.25 1 # red\r\nv 1e0 0 .0\nv 0 \\\n 1.0 \\\r\n -0\n\n\
                usemtl m\nl 1 2\np 1\nf 1 \\\n2 3 # the end";
    let loaded = obj(text).unwrap();
    assert_eq!(loaded.value.positions(), [v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0)]);
    assert_eq!(loaded.value.faces(), [[0, 1, 2]]);
    assert_eq!(loaded.warnings, []);
    // Old Mac line ends, and a comment that ends in a backslash.
    assert_eq!(obj("# C:\\\rv 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r").unwrap().value.faces(), [[0, 1, 2]]);
    // Bytes that are no text, in a comment and a name.
    let latin1 = b"# caf\xe9\no caf\xe9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    assert_eq!(read_obj(latin1, "a.obj").unwrap().warnings, []);
}

#[test]
fn obj_faces_may_come_before_their_vertices() {
    assert_eq!(obj("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap().value.faces(), [[0, 1, 2]]);
}

#[test]
fn obj_very_long_lines() {
    // A circle of 100,000 corners in one statement.
    let n = 100_000;
    let mut text = String::new();
    for i in 0..n {
        let t = i as f64 / n as f64 * std::f64::consts::TAU;
        text += &format!("v {} {} 0\n", t.cos(), t.sin());
    }
    text += "f";
    for i in 1..=n {
        text += &format!(" {i}");
    }
    let mesh = obj(&text).unwrap().value;
    let area: f64 = mesh.face_areas().iter().sum();
    assert!((area - std::f64::consts::PI).abs() < 1e-4, "{area}");
}

#[test]
fn obj_vertices_split_only_where_normals_differ() {
    // Two triangles with a crease along 1–3; the normals 1 and 3 are equal.
    let text =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\nvn 0 0 1\nvn 0 -1 1\nvn 0 0 1\nf 1//1 2//3 3//1\nf 1//3 3//2 4//2\n";
    let mesh = obj(text).unwrap().value;
    assert_eq!(mesh.faces(), [[0, 1, 2], [0, 4, 3]]);
    assert_eq!(mesh.positions()[4], mesh.positions()[2]);
    assert_eq!(mesh.normals()[2], v(0.0, 0.0, 1.0));
    let half = 0.5f32.sqrt();
    assert!((mesh.normals()[4] - v(0.0, -half, half)).norm() < 1e-7);
}

#[test]
fn obj_corners_without_normals_get_the_faces() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 5\nv 1 0 5\nv 0 1 5\nvn 1 0 0\nf 1 2 3\nf 4//1 5//1 6//1\nf 4 6 5";
    let loaded = obj(text).unwrap();
    let mesh = &loaded.value;
    assert_eq!(mesh.normals()[0], v(0.0, 0.0, 1.0));
    assert_eq!(mesh.normals()[3], v(1.0, 0.0, 0.0));
    // The third face has the positions of the second without its normals: vertices of their own.
    assert_eq!(mesh.faces()[2], [6, 7, 8]);
    assert_eq!(mesh.normals()[6], v(0.0, 0.0, -1.0));
    assert_eq!(messages(&loaded), ["a.obj: 6 normals are missing or zero; computed from the faces"]);
}

#[test]
fn obj_repairs_are_reported() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 9\nv 2 0 0\nfoo 1\nf 1 2\nf 1 2 2\nf 1 2 5\nf 1 2 3\nbar";
    let loaded = obj(text).unwrap();
    assert_eq!(loaded.value.faces(), [[0, 1, 2]]);
    assert_eq!(loaded.value.positions().len(), 3);
    assert_eq!(
        messages(&loaded),
        [
            "a.obj, line 6: \"foo\": 2 unknown statements skipped",
            "a.obj, line 7: 1 face with fewer than three corners left out",
            "a.obj, triangle 0: 2 triangles without area left out",
            "a.obj, vertex 3: 2 vertices without a face left out",
        ]
    );
    let concave = obj("v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nf 1 2 3 4").unwrap();
    assert_eq!(concave.warnings, []);
    let concave = obj("v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nf 2 3 4 1\n").unwrap();
    assert_eq!(concave.warnings, []);
    assert_eq!(concave.value.face_areas().iter().sum::<f64>(), 4.0);
    let zero = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nvn nan 0 1\nvn 1 0 0\nf 1//1 2//2 3//3").unwrap();
    assert_eq!(zero.value.normals(), [v(0.0, 0.0, 1.0), v(0.0, 0.0, 1.0), v(1.0, 0.0, 0.0)]);
    assert_eq!(zero.warnings.len(), 2);
    let inside_out = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -1\nf 1//1 2//1 3//1").unwrap();
    assert_eq!(messages(&inside_out), ["a.obj: 1 of 1 faces are wound against their normals; the normals were kept"]);
}

#[test]
fn obj_messages() {
    let three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    golden(obj(""), "a.obj: the file is empty");
    golden(obj("\n\n"), "a.obj: no vertices");
    golden(obj("hello there"), "a.obj, line 1: \"hello\": not a statement of an OBJ file, and no vertices anywhere");
    golden(obj(three), "a.obj: no faces; a mesh needs triangles");
    golden(obj("v 0 0\n"), "a.obj, line 1: a vertex has 2 of 3 numbers");
    golden(obj("v 0 0 0\nv 0 1,5 0\n"), "a.obj, line 2: \"1,5\" is not a number");
    golden(obj("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3"), "a.obj, line 1: the vertex is NaN, infinite or beyond f32");
    golden(obj("v 0 0 -inf\nv 1 0 0\nv 0 1 0\nf 1 2 3"), "a.obj, line 1: the vertex is NaN, infinite or beyond f32");
    golden(obj("v 0 0 1e39\nv 1 0 0\nv 0 1 0\nf 1 2 3"), "a.obj, line 1: the vertex is NaN, infinite or beyond f32");
    golden(obj(&format!("{three}f 1 2 0")), "a.obj, line 4: vertex index 0; indices start at 1");
    golden(obj(&format!("{three}f 1 2 4")), "a.obj, line 4: vertex index 4 is out of range; the file has 3");
    golden(obj(&format!("{three}f 1 2 -4")), "a.obj, line 4: vertex index -4 is out of range; there are 3 so far");
    golden(
        obj(&format!("{three}f 1 2 99999999999")),
        "a.obj, line 4: vertex index 99999999999 is out of range; there are 3 so far",
    );
    golden(
        obj(&format!("{three}f 1 2 4294967295")),
        "a.obj, line 4: vertex index 4294967295 is out of range; the file has 3",
    );
    golden(obj(&format!("{three}f 1//x 2//1 3//1")), "a.obj, line 4: \"x\" is not a normal index");
    golden(obj(&format!("{three}f 1 2 x3")), "a.obj, line 4: \"x3\" is not a vertex index");
    golden(obj(&format!("{three}f 1 1 2")), "a.obj: all 1 faces have no area");
    golden(obj("v 0 0 \\\n 0\nv 1 \\\n\\\n x 0"), "a.obj, line 3: \"x\" is not a number");
}

// ---------------------------------------------------------------------------------------------------------- PLY

const PLY_TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                            element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

#[test]
fn ply_ascii() {
    for ending in ["\n", "\r\n", "\r"] {
        let loaded = ply(&PLY_TRIANGLE.replace('\n', ending)).unwrap();
        assert_eq!(loaded.value.faces(), [[0, 1, 2]]);
        assert_eq!(loaded.value.positions()[1], v(1.0, 0.0, 0.0));
        assert_eq!(loaded.warnings, []);
    }
    assert_eq!(ply(PLY_TRIANGLE.trim_end()).unwrap().value.faces(), [[0, 1, 2]]);
    assert_eq!(
        messages(&ply(&format!("{PLY_TRIANGLE}\n 7 7")).unwrap()),
        [format!("a.ply, byte {}: 3 bytes after the last element skipped", PLY_TRIANGLE.len() + 2)]
    );
}

/// A file that uses everything: other elements before and after, lists among the vertices' properties, doubles,
/// normals, quads, strips.
fn rich_ply(format: &str) -> Vec<u8> {
    let mut out = format!(
        "ply\nformat {format} 1.0\ncomment made by hand\nobj_info none\nelement camera 2\nproperty short a\nproperty list uint16 float64 b\n\
         element nothing 1000000\nelement vertex 5\nproperty double x\nproperty list char uint8 extra\nproperty float32 z\nproperty double y\n\
         property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\n\
         element face 2\nproperty int16 flags\nproperty list uint8 ushort vertex_index\nelement tristrips 1\nproperty list int int vertex_indices\n\
         element tail 1\nproperty char c\nend_header\n"
    )
    .into_bytes();
    enum N {
        I8(i8),
        U8(u8),
        I16(i16),
        U16(u16),
        I32(i32),
        F32(f32),
        F64(f64),
        Row,
    }
    use N::*;
    let mut body = vec![I16(-3), U16(2), F64(0.5), F64(f64::NAN), Row, I16(7), U16(0), Row];
    for (i, [x, y]) in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [-1.0, 0.5]].into_iter().enumerate() {
        body.extend([F64(x), I8(i as i8)]);
        body.extend((0..i).map(|_| U8(200)));
        body.extend([F32(0.25), F64(y), F32(0.0), F32(0.0), F32(2.0), U8(255), Row]);
    }
    body.extend([I16(-1), U8(4), U16(0), U16(1), U16(2), U16(3), Row]);
    body.extend([I16(-1), U8(3), U16(0), U16(3), U16(4), Row]);
    body.extend([I32(8), I32(0), I32(1), I32(3), I32(2), I32(-1), I32(0), I32(3), I32(4), Row, I8(-7), Row]);
    for n in body {
        macro_rules! put {
            ($x:expr) => {
                match format {
                    "ascii" => out.extend_from_slice(format!("{} ", $x).as_bytes()),
                    "binary_little_endian" => out.extend_from_slice(&$x.to_le_bytes()),
                    _ => out.extend_from_slice(&$x.to_be_bytes()),
                }
            };
        }
        match n {
            I8(x) => put!(x),
            U8(x) => put!(x),
            I16(x) => put!(x),
            U16(x) => put!(x),
            I32(x) => put!(x),
            F32(x) => put!(x),
            F64(x) => put!(x),
            Row if format == "ascii" => out.push(b'\n'),
            Row => {}
        }
    }
    out
}

#[test]
fn ply_everything_in_three_formats() {
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let loaded = read_ply(&rich_ply(format), "rich.ply").unwrap();
        let mesh = &loaded.value;
        assert_eq!(loaded.warnings, [], "{format}");
        assert_eq!(mesh.faces(), [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 1, 3], [3, 1, 2], [0, 3, 4]], "{format}");
        assert_eq!(mesh.positions()[2], v(1.0, 1.0, 0.25), "{format}");
        assert!(mesh.normals().iter().all(|n| *n == v(0.0, 0.0, 1.0)), "{format}");
    }
}

#[test]
fn ply_messages() {
    let with = |from: &str, to: &str| {
        assert!(PLY_TRIANGLE.contains(from), "{from}");
        ply(&PLY_TRIANGLE.replacen(from, to, 1))
    };
    golden(ply(""), "a.ply: the file is empty");
    golden(ply("solid cube"), "a.ply, line 1: not a PLY file: it does not begin with a line \"ply\"");
    golden(ply("ply\nformat ascii 1.0\n"), "a.ply, line 3: the header has no end_header");
    golden(with("ascii 1.0", "ascii 2.0"), "a.ply, line 2: PLY version \"2.0\"; only 1.0 is known");
    golden(with("ascii", "morse"), "a.ply, line 2: \"morse\" is not a PLY format");
    golden(with("format ascii 1.0\n", ""), "a.ply, header: no format line");
    golden(with("element vertex 3", "element vertex -3"), "a.ply, line 3: \"-3\" is not a count of elements");
    golden(with("property float x", "property quad x"), "a.ply, line 4: \"quad\" is not a PLY type");
    golden(
        with("property float x", "property float u"),
        "a.ply, line 3: element \"vertex\" has 0 scalar properties \"x\"; there must be one",
    );
    golden(
        with("property float x", "propperty float x"),
        "a.ply, line 4: \"propperty float x\" is not a line of a PLY header",
    );
    golden(with("element vertex 3", "element vertices 3"), "a.ply, header: 0 elements \"vertex\"; there must be one");
    golden(with("element vertex 3\n", ""), "a.ply, line 3: a property before any element");
    golden(
        with("int vertex_indices", "float vertex_indices"),
        "a.ply, line 8: list \"vertex_indices\" holds floating-point numbers, not indices",
    );
    golden(
        with("list uchar int", "list float int"),
        "a.ply, line 8: the count of list \"vertex_indices\" is not an integer",
    );
    golden(
        with("vertex_indices", "vertices"),
        "a.ply, header: no faces (element \"face\" with a list \"vertex_indices\"); a point cloud is no mesh",
    );
    golden(
        with("element vertex 3", "element vertex 99999999999"),
        "a.ply, line 3: 99999999999 elements \"vertex\" of at least 6 bytes each, but only 26 bytes are there",
    );
    golden(with("1 0 0", "1 0"), "a.ply, line 11 (vertex 1): the line has too few values");
    let longer = with("1 0 0", "1 0 0 4").unwrap();
    assert_eq!(longer.value.positions()[1], v(1.0, 0.0, 0.0));
    assert_eq!(messages(&longer), ["a.ply, line 11: 1 line has more values than the header declares; dropped"]);
    golden(with("1 0 0", "1 zero 0"), "a.ply, line 11 (vertex 1): \"zero\" is not a number");
    golden(with("1 0 0", "1 NaN 0"), "a.ply, line 11 (vertex 1): the vertex is NaN, infinite or beyond f32");
    golden(with("3 0 1 2", "3 0 1 3"), "a.ply, line 13 (face 0): vertex index 3 is out of range; there are 3");
    golden(with("3 0 1 2", "3 0 1 -2"), "a.ply, line 13 (face 0): vertex index -2 is out of range; there are 3");
    golden(with("3 0 1 2", "3 0 1 0.5"), "a.ply, line 13 (face 0): \"0.5\" is not a whole number");
    golden(with("3 0 1 2", "-1 0 1 2"), "a.ply, line 13 (face 0): list \"vertex_indices\" has a count of -1");
    golden(
        with("3 0 1 2", "200 0 1 2"),
        "a.ply, line 13 (face 0): list \"vertex_indices\" of 200 values, but only 6 bytes are there",
    );
    golden(
        with("0 1 0\n3 0 1 2\n", "0 1 0\n"),
        "a.ply, line 7: 1 elements \"face\" of at least 2 bytes each, but only 0 bytes are there",
    );

    let binary = read_ply(&rich_ply("binary_big_endian"), "b.ply").unwrap().value;
    let mut bytes = encode_ply(&binary, None).unwrap();
    let face = bytes.len() - 13 * binary.faces().len();
    bytes[face + 4] = 0x7f;
    golden(
        read_ply(&bytes, "b.ply"),
        &format!("b.ply, face 0 (byte {}): vertex index 2130706432 is out of range; there are 5", face + 5),
    );
    bytes[face + 4] = 0;
    golden(
        read_ply(&bytes[..face + 70], "b.ply"),
        &format!("b.ply, face 5 (byte {}): list \"vertex_indices\" of 3 values, but only 4 bytes are there", face + 66),
    );
}

#[test]
fn ply_out_and_in() {
    let mesh = read_ply(&rich_ply("ascii"), "rich.ply").unwrap().value;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.ply");
    let colours: Vec<_> = (0..5).map(|i| v(i as f32, 0.1, 1e6)).collect();
    save_ply(&path, &mesh, Some(&colours)).unwrap();
    let back = load_mesh(&path).unwrap();
    assert_eq!(back.warnings, []);
    assert_eq!(back.value.positions(), mesh.positions());
    assert_eq!(back.value.normals(), mesh.normals());
    assert_eq!(back.value.faces(), mesh.faces());
    // The colours are where the header says, bit for bit.
    let bytes = std::fs::read(&path).unwrap();
    let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let header = std::str::from_utf8(&bytes[..end]).unwrap();
    assert!(header.contains("property float nz\nproperty float red\nproperty float green\nproperty float blue\n"));
    let red = |i: usize| f32::from_le_bytes(bytes[end + 36 * i + 24..][..4].try_into().unwrap());
    assert_eq!((0..5).map(red).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0, 4.0]);
    assert_eq!(
        encode_ply(&mesh, Some(&colours[1..])),
        Err(Error::Length { what: "colours of a mesh", expected: 5, got: 4 })
    );
}

// --------------------------------------------------------------------------------------------------------- glTF

fn to_base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for group in bytes.chunks(3) {
        let n = group.iter().fold(0u32, |n, b| n << 8 | u32::from(*b)) << (8 * (3 - group.len()));
        for i in 0..4 {
            out.push(if i <= group.len() { char::from(DIGITS[(n >> (18 - 6 * i)) as usize & 63]) } else { '=' });
        }
    }
    out
}

/// The buffer of the test files: four corners of a square, four normals, indices u16 and u8, the corners as i16.
fn gltf_buffer() -> Vec<u8> {
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let mut out: Vec<u8> = corners.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
    out.extend([[0.0f32, 0.0, 1.0]; 4].iter().flatten().flat_map(|c| c.to_le_bytes()));
    out.extend([0u16, 1, 2, 2, 1, 3].iter().flat_map(|i| i.to_le_bytes()));
    out.extend([0u8, 1, 3, 2]);
    for c in corners {
        out.extend(c.iter().flat_map(|c| ((c * 32767.0) as i16).to_le_bytes()));
        out.extend([0, 0]);
    }
    assert_eq!(out.len(), 144);
    out
}

/// A glTF document around [`gltf_buffer`]; `nodes` and `primitive` as JSON.
fn gltf(buffer: &str, nodes: &str, primitive: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
"nodes":[{nodes}],"meshes":[{{"primitives":[{primitive}]}}],
"buffers":[{{"byteLength":144{buffer}}}],
"bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":48}},
{{"buffer":0,"byteOffset":96,"byteLength":16}},{{"buffer":0,"byteOffset":112,"byteLength":32,"byteStride":8}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
{{"bufferView":1,"componentType":5126,"count":4,"type":"VEC3"}},
{{"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}},
{{"bufferView":2,"byteOffset":12,"componentType":5121,"count":4,"type":"SCALAR"}},
{{"bufferView":3,"componentType":5122,"normalized":true,"count":4,"type":"VEC3"}}]}}"#
    )
}

fn data_uri() -> String {
    format!(r#","uri":"data:application/octet-stream;base64,{}""#, to_base64(&gltf_buffer()))
}

fn read_text(text: &str) -> haarmonic::Result<Loaded<Mesh>> {
    read_gltf(text.as_bytes(), "a.gltf")
}

fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut out = b"glTF".to_vec();
    for n in [2, 28 + json.len() + binary.len(), json.len()] {
        out.extend((n as u32).to_le_bytes());
    }
    out.extend(b"JSON");
    out.extend(&json);
    out.extend((binary.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(binary);
    out
}

const INDEXED: &str = r#"{"attributes":{"POSITION":0,"NORMAL":1},"indices":2}"#;

#[test]
fn gltf_buffers_of_every_kind() {
    let expected = read_text(&gltf(&data_uri(), r#"{"mesh":0}"#, INDEXED)).unwrap();
    assert_eq!(expected.warnings, []);
    assert_eq!(expected.value.faces(), [[0, 1, 2], [2, 1, 3]]);
    assert_eq!(expected.value.positions()[3], v(1.0, 1.0, 0.0));

    let embedded = glb(&gltf("", r#"{"mesh":0}"#, INDEXED), &gltf_buffer());
    assert_eq!(read_gltf(&embedded, "a.glb").unwrap(), expected);

    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("sub folder")).unwrap();
    std::fs::write(folder.path().join("sub folder/a.bin"), gltf_buffer()).unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, gltf(r#","uri":"sub%20folder/./a.bin""#, r#"{"mesh":0}"#, INDEXED)).unwrap();
    assert_eq!(load_mesh(&path).unwrap(), expected);
    // By its content, whatever its name.
    std::fs::write(folder.path().join("a.xyz"), &embedded).unwrap();
    assert_eq!(load_mesh(folder.path().join("a.xyz")).unwrap(), expected);
}

#[test]
fn gltf_paths_stay_in_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("inner")).unwrap();
    std::fs::write(folder.path().join("a.bin"), gltf_buffer()).unwrap();
    let path = folder.path().join("inner/a.gltf");
    let absolute = folder.path().join("a.bin").display().to_string();
    for uri in [
        "../a.bin",
        "%2e%2e/a.bin",
        "x/../../a.bin",
        "..%5ca.bin",
        "file:../a.bin",
        "https://example.org/a.bin",
        "C:a.bin",
        "a%00.bin",
        "a%zz",
        "",
        &absolute,
    ] {
        std::fs::write(&path, gltf(&format!(r#","uri":"{uri}""#), r#"{"mesh":0}"#, INDEXED)).unwrap();
        let message = load_mesh(&path).unwrap_err().to_string();
        assert!(message.ends_with("is not a plain path into the file's own folder"), "{uri}: {message}");
    }
}

#[test]
fn gltf_modes_and_quantised_positions() {
    // Without normals every triangle has vertices of its own: 4 and 5 are copies.
    for (mode, faces) in [(5, [[0, 1, 3], [4, 5, 2]]), (6, [[0, 1, 3], [4, 5, 2]])] {
        let primitive = format!(r#"{{"attributes":{{"POSITION":4}},"indices":3,"mode":{mode}}}"#);
        let mesh = read_text(&gltf(&data_uri(), r#"{"mesh":0}"#, &primitive)).unwrap().value;
        assert_eq!(mesh.faces(), faces);
        assert_eq!(mesh.positions()[3], v(1.0, 1.0, 0.0));
    }
    // Without indices; the fourth corner is left over.
    let loaded = read_text(&gltf(&data_uri(), r#"{"mesh":0}"#, r#"{"attributes":{"POSITION":0}}"#)).unwrap();
    assert_eq!(loaded.value.faces(), [[0, 1, 2]]);
    assert_eq!(
        messages(&loaded),
        [
            "a.gltf, mesh 0 primitive 0: 1 list of triangles has left over corners",
            "a.gltf, vertex 3: 1 vertex without a face left out",
        ]
    );
}

#[test]
fn gltf_transforms() {
    // Parent turns by 90° about y and shifts; child mirrors x and scales.
    let half = 0.5f32.sqrt();
    let nodes = format!(
        r#"{{"children":[1],"rotation":[0,{half},0,{half}],"translation":[10,0,0]}},{{"mesh":0,"scale":[-2,3,4]}}"#
    );
    let loaded = read_text(&gltf(&data_uri(), &nodes, INDEXED)).unwrap();
    let mesh = &loaded.value;
    // (x, y, z) → (−2x, 3y, 4z) → (z', y', −x') + (10, 0, 0).
    for (p, q) in
        mesh.positions().iter().zip([v(10.0, 0.0, 0.0), v(10.0, 0.0, 2.0), v(10.0, 3.0, 0.0), v(10.0, 3.0, 2.0)])
    {
        assert!((p - q).norm() < 1e-5, "{p} {q}");
    }
    // The normal +z goes to +x, and the triangles, turned round, agree with it.
    assert_eq!(mesh.faces(), [[0, 2, 1], [2, 3, 1]]);
    assert!(mesh.normals().iter().all(|n| (n - v(1.0, 0.0, 0.0)).norm() < 1e-6));
    assert_eq!(loaded.warnings, []);
    // The same as a matrix, column by column.
    let matrix = r#"{"mesh":0,"matrix":[0,0,2,0,0,3,0,0,4,0,0,0,10,0,0,1]}"#;
    let other = read_text(&gltf(&data_uri(), matrix, INDEXED)).unwrap().value;
    for (p, q) in mesh.positions().iter().zip(other.positions()) {
        assert!((p - q).norm() < 1e-5);
    }
    assert_eq!(mesh.faces(), other.faces());
}

#[test]
fn gltf_instances_are_merged_and_extras_reported() {
    let nodes = r#"{"children":[1,2,3]},{"mesh":0},{"mesh":0,"translation":[5,0,0]},{"camera":9}"#;
    let primitives = format!(r#"{INDEXED},{{"attributes":{{"POSITION":0}},"mode":0}}"#);
    let loaded = read_text(&gltf(&data_uri(), nodes, &primitives)).unwrap();
    assert_eq!(loaded.value.faces(), [[0, 1, 2], [2, 1, 3], [4, 5, 6], [6, 5, 7]]);
    assert_eq!(loaded.value.positions()[5], v(6.0, 0.0, 0.0));
    assert_eq!(messages(&loaded), ["a.gltf, mesh 0 primitive 1: 2 primitives of points or lines left out"]);
}

#[test]
fn gltf_messages() {
    let uri = data_uri();
    let good = gltf(&uri, r#"{"mesh":0}"#, INDEXED);
    let with = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        read_text(&good.replacen(from, to, 1))
    };
    golden(read_text(""), "a.gltf: the file is empty");
    golden(read_text("{\"asset\":\n{]"), "a.gltf, JSON line 2 column 2: key must be a string");
    golden(with("\"2.0\"", "\"1.0\""), "a.gltf, asset: glTF version \"1.0\"; only 2 can be read");
    golden(
        with("\"scene\":0", "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]"),
        "a.gltf, extensionsRequired: the extension \"KHR_draco_mesh_compression\" cannot be read",
    );
    golden(with("\"scene\":0", "\"scene\":7"), "a.gltf, scene: there is no such scene");
    golden(with("\"nodes\":[0]", "\"nodes\":[4]"), "a.gltf, node 4: there is no such node");
    golden(with("{\"mesh\":0}", "{\"mesh\":3}"), "a.gltf, mesh 3: there is no such mesh");
    golden(with("{\"mesh\":0}", "{}"), "a.gltf: no triangles in the scene");
    golden(
        with("{\"mesh\":0}", "{\"mesh\":0,\"children\":[0]}"),
        "a.gltf, node 0: is reached twice; nodes must form a tree",
    );
    golden(
        with("{\"mesh\":0}", "{\"mesh\":0,\"rotation\":[0,0,0,0]}"),
        "a.gltf, node 0: its transform is NaN or infinite",
    );
    golden(
        with("{\"mesh\":0}", "{\"mesh\":0,\"scale\":[3e38,1,1],\"children\":[]},{}").and_then(|_| {
            with("{\"mesh\":0}", "{\"children\":[1],\"scale\":[3e38,1,1]},{\"mesh\":0,\"scale\":[3e38,1,1]}")
        }),
        "a.gltf, mesh 0 primitive 0 POSITION 1: the vertex is NaN, infinite or beyond f32",
    );
    golden(with("\"POSITION\":0,", ""), "a.gltf, mesh 0 primitive 0: has no POSITION (compressed data cannot be read)");
    golden(
        with("\"POSITION\":0,", "\"POSITION\":9,"),
        "a.gltf, mesh 0 primitive 0 POSITION: accessor 9: there is no such accessor",
    );
    golden(
        with("\"POSITION\":0,", "\"POSITION\":2,"),
        "a.gltf, mesh 0 primitive 0 POSITION: accessor 2: it holds SCALAR, not VEC3",
    );
    golden(with("{\"bufferView\":0,", "{"), "a.gltf: all 2 faces have no area");
    golden(
        with(
            "\"count\":4,",
            "\"count\":4,\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":0,\"componentType\":5126},\"values\":{\"bufferView\":0}},",
        ),
        "a.gltf, mesh 0 primitive 0 POSITION: accessor 0: sparse indices: they must be unsigned integers",
    );
    golden(
        with("\"count\":4,", "\"count\":5,"),
        "a.gltf, mesh 0 primitive 0 POSITION: accessor 0: its 5 elements reach beyond the buffer view",
    );
    golden(
        with("\"count\":4,", "\"count\":18446744073709551615,"),
        "a.gltf, mesh 0 primitive 0 POSITION: accessor 0: its 18446744073709551615 elements reach beyond the buffer view",
    );
    golden(
        with("5126", "5127"),
        "a.gltf, mesh 0 primitive 0 POSITION: accessor 0: its component type 5127 is not one of glTF",
    );
    golden(
        with("\"byteLength\":48", "\"byteLength\":4800"),
        "a.gltf, mesh 0 primitive 0 POSITION: accessor 0: its buffer view reaches beyond the buffer",
    );
    golden(
        with("\"byteLength\":144", "\"byteLength\":145"),
        "a.gltf, mesh 0 primitive 0 POSITION: accessor 0: buffer 0: it should have 145 bytes, but only 144 are there",
    );
    golden(
        with(";base64,", ";base64,!"),
        "a.gltf, mesh 0 primitive 0 POSITION: accessor 0: buffer 0: character 0 of its data URI is not base64",
    );
    golden(
        with(&uri, ""),
        "a.gltf, mesh 0 primitive 0 POSITION: accessor 0: buffer 0: it has no URI, and the file has no binary chunk",
    );
    golden(
        with(&uri, ",\"uri\":\"a.bin\""),
        "a.gltf, mesh 0 primitive 0 POSITION: accessor 0: buffer 0: \"a.bin\" is a file of its own; open the file by its path",
    );
    golden(
        with("\"indices\":2", "\"indices\":0"),
        "a.gltf, mesh 0 primitive 0 indices: accessor 0: it holds VEC3, not SCALAR",
    );
    golden(
        with("\"indices\":2", "\"indices\":2,\"mode\":12"),
        "a.gltf, mesh 0 primitive 0: its mode is not one of glTF",
    );
    golden(with("\"indices\":2", "\"indices\":2,\"mode\":1"), "a.gltf: only points or lines");
    golden(
        with("5123,\"count\":6", "5123,\"count\":8"),
        "a.gltf, mesh 0 primitive 0 indices: number 6: vertex index 256 is out of range; there are 4",
    );
    let binary = glb(&gltf("", r#"{"mesh":0}"#, INDEXED), &gltf_buffer());
    let mut v1 = binary.clone();
    v1[4] = 1;
    golden(read_gltf(&v1, "a.glb"), "a.glb, byte 4: GLB version 1; only 2 can be read");
    golden(
        read_gltf(&binary[..binary.len() - 1], "a.glb"),
        "a.glb, mesh 0 primitive 0 POSITION: accessor 0: buffer 0: it should have 144 bytes, but only 143 are there",
    );
}

// ------------------------------------------------------------------------------------------------------ pictures

/// A picture with a wide range and a gradient in every direction.
fn picture(width: usize, height: usize) -> Image {
    let pixel = |i: usize| {
        let (x, y) = (i % width, i / width);
        v(0.5 + x as f32, 0.001 * (1 + y) as f32, if (x / 5 + y) % 3 == 0 { 1e4 } else { 0.25 })
    };
    Image::new(width, height, (0..width * height).map(pixel).collect()).unwrap()
}

const SIZES: [(usize, usize); 7] = [(1, 1), (1, 5), (7, 1), (8, 2), (33, 17), (200, 3), (64, 64)];

#[test]
fn exr_round_trip_is_exact() {
    for (w, h) in SIZES {
        let mut image = picture(w, h);
        let loaded = read_image(&encode_exr(&image).unwrap(), "a.exr").unwrap();
        assert_eq!(loaded.warnings, []);
        assert_eq!(loaded.value, image, "{w} × {h}");
        let mut pixels = image.into_pixels();
        pixels[0] = v(f32::MAX, f32::MIN_POSITIVE, 1e-42);
        image = Image::new(w, h, pixels).unwrap();
        assert_eq!(read_exr(&encode_exr(&image).unwrap(), "a.exr").unwrap().value, image);
    }
}

#[test]
fn hdr_round_trip_is_within_half_a_step() {
    for (w, h) in SIZES {
        let image = picture(w, h);
        let loaded = read_image(&encode_hdr(&image).unwrap(), "a.hdr").unwrap();
        assert_eq!(loaded.warnings, []);
        assert_eq!((loaded.value.width(), loaded.value.height()), (w, h));
        for (a, b) in image.pixels().iter().zip(loaded.value.pixels()) {
            // Half of the last of 8 bits, the first of which is set in the largest channel.
            assert!((a - b).amax() <= a.amax() / 256.0, "{a} {b}");
        }
        // What has been rounded once stays.
        assert_eq!(read_hdr(&encode_hdr(&loaded.value).unwrap(), "a.hdr").unwrap().value, loaded.value);
    }
    let nan = Image::new(2, 1, vec![v(0.0, 0.0, 0.0), v(0.0, f32::NAN, 0.0)]).unwrap();
    assert_eq!(encode_hdr(&nan), Err(Error::NotFinite { what: "pixel of a picture", index: 1 }));
}

#[test]
fn hdr_by_hand() {
    let read = |header: &str, pixels: &[u8]| {
        let mut bytes = format!("#?RGBE\n# comment\nSOFTWARE=none\nFORMAT=32-bit_rle_rgbe\n{header}\n").into_bytes();
        bytes.extend_from_slice(pixels);
        read_hdr(&bytes, "a.hdr")
    };
    let one = [128, 64, 0, 129];
    let two = [0, 0, 255, 136];
    let (a, b) = (v(1.0, 0.5, 0.0), v(0.0, 0.0, 255.0));
    // Two rows of one pixel; the old run code (a pixel, and 1 + 1·256 repetitions).
    let image = read("\n-Y 2 +X 1", &[one, two].concat()).unwrap().value;
    assert_eq!(image.pixels(), [a, b]);
    let image = read("\n-Y 1 +X 259", &[two, one, [1, 1, 1, 1], [1, 1, 1, 1]].concat()).unwrap();
    assert_eq!(image.value.pixels()[258], a);
    assert_eq!(image.value.pixels()[0], b);
    // Orientations: the same four stored pixels A B C D.
    let stored: Vec<u8> = (1..=4).flat_map(|i| [i, 0, 0, 136]).collect();
    for (resolution, expected) in [
        ("-Y 2 +X 2", [1.0, 2.0, 3.0, 4.0]),
        ("+Y 2 +X 2", [3.0, 4.0, 1.0, 2.0]),
        ("-Y 2 -X 2", [2.0, 1.0, 4.0, 3.0]),
        ("+Y 2 -X 2", [4.0, 3.0, 2.0, 1.0]),
        ("+X 2 -Y 2", [1.0, 3.0, 2.0, 4.0]),
        ("-X 2 -Y 2", [3.0, 1.0, 4.0, 2.0]),
        ("+X 2 +Y 2", [2.0, 4.0, 1.0, 3.0]),
        ("-X 2 +Y 2", [4.0, 2.0, 3.0, 1.0]),
    ] {
        let image = read(&format!("\n{resolution}"), &stored).unwrap().value;
        assert_eq!(image.pixels().iter().map(|p| p.x).collect::<Vec<_>>(), expected, "{resolution}");
    }
    let wide = read("\n+X 3 -Y 1", &stored[..12]).unwrap().value;
    assert_eq!((wide.width(), wide.height()), (3, 1));
    let exposed = read("EXPOSURE=4\nCOLORCORR=0.5 1 1\nEXPOSURE= 0.5\n\n-Y 1 +X 1", &one).unwrap();
    assert_eq!(exposed.value.pixels(), [v(1.0, 0.25, 0.0)]);
    assert_eq!(exposed.warnings.len(), 3);

    golden(read_hdr(b"", "a.hdr"), "a.hdr: the file is empty");
    golden(read_hdr(b"RADIANCE", "a.hdr"), "a.hdr, byte 0: not a Radiance HDR file: it does not begin with \"#?\"");
    golden(read_hdr(b"#?RADIANCE\nFORMAT=x", "a.hdr"), "a.hdr, line 2: the header ends here, before the resolution");
    golden(read("\n-Y 2 +Y 2", &stored), "a.hdr, line 6: \"-Y 2 +Y 2\" is not a resolution");
    golden(read("\n-Y 0 +X 2", &stored), "a.hdr, line 6: a picture of 2 × 0 pixels is empty");
    golden(
        read("\n-Y 100000 +X 100000", &stored),
        "a.hdr, line 6: a picture of 100000 × 100000 pixels; at most 2^27 can be read",
    );
    golden(
        read("\n-Y 100000 +X 2", &stored),
        "a.hdr, byte 70: 100000 scan lines take at least 400000 bytes, but only 16 are there",
    );
    golden(
        read_hdr(b"#?RADIANCE\nFORMAT=32-bit_rle_cmyk\n\n-Y 1 +X 1\nabcd", "a.hdr"),
        "a.hdr, line 2: pixel format \"32-bit_rle_cmyk\"; only 32-bit_rle_rgbe and 32-bit_rle_xyze can be read",
    );
    golden(read("\n-Y 2 +X 3", &stored), "a.hdr, scan line 1 (byte 81): the file ends here");
    golden(read("\n-Y 1 +X 2", &[1, 1, 1, 9]), "a.hdr, scan line 0 (byte 69): a run beyond the 2 pixels that are left");
    golden(read("\n-Y 1 +X 2", &[1, 1, 1, 2]), "a.hdr, scan line 0 (byte 69): a run before any pixel");
    // Empty runs: each shifts the next by 8 bits; eight of them are beyond any word.
    let chain = [&one[..], &[1, 1, 1, 0].repeat(9), &[1, 1, 1, 1]].concat();
    golden(read("\n-Y 1 +X 2", &chain), "a.hdr, scan line 0 (byte 89): a run beyond the 1 pixels that are left");
    golden(
        read("\n-Y 1 +X 9", &[2, 2, 0, 8]),
        "a.hdr, scan line 0 (byte 69): the scan line says that it has 8 pixels, not 9",
    );
    let overlong = [&[2, 2, 0, 9, 138, 7][..], &[0; 8]].concat();
    golden(read("\n-Y 1 +X 9", &overlong), "a.hdr, scan line 0 (byte 70): a run of 10 pixels where 9 are left");
    let trailing = read("\n-Y 1 +X 1", &stored).unwrap();
    assert_eq!(messages(&trailing), ["a.hdr, byte 69: 12 bytes after the last scan line skipped"]);
}

#[test]
fn png_round_trip_of_every_byte() {
    let pixels: Vec<[u8; 3]> = (0..=255).map(|i| [i, 255 - i, i / 2]).collect();
    let bytes = encode_png_srgb8(32, 8, &pixels).unwrap();
    let image = read_image(&bytes, "a.png").unwrap();
    assert_eq!(image.warnings, []);
    // Known points of the curve: 0, 1, and 188/255, which is 0.5029.
    assert_eq!(image.value.pixels()[0], v(0.0, 1.0, 0.0));
    assert!((image.value.pixels()[188].x - 0.502_886).abs() < 1e-5);
    assert_eq!(encode_png(&image.value, 0.0).unwrap(), bytes);
    let clipped = Image::new(2, 1, vec![v(f32::NAN, -1.0, 7.0), v(f32::INFINITY, 0.25, 0.0)]).unwrap();
    let back = read_png(&encode_png(&clipped, 1.0).unwrap(), "a.png").unwrap().value;
    assert_eq!(back.pixels()[0], v(0.0, 0.0, 1.0));
    assert!((back.pixels()[1] - v(1.0, 0.5, 0.0)).amax() < 5e-3);
    assert_eq!(encode_png_srgb8(0, 1, &[]), Err(Error::Empty { what: "picture" }));
    assert!(matches!(encode_png_srgb8(2, 1, &[[0; 3]]), Err(Error::Length { expected: 2, got: 1, .. })));
    golden(read_png(b"", "a.png"), "a.png: the file is empty");
}

#[test]
fn pictures_of_wrong_content() {
    let with = |pixel| {
        let mut pixels = picture(4, 3).into_pixels();
        pixels[6] = pixel;
        read_image(&exr_files::rgb(4, &pixels), "a.exr")
    };
    golden(with(v(0.0, f32::NAN, 0.0)), "a.exr, pixel (2, 1): NaN or infinite");
    golden(with(v(0.0, 0.0, f32::INFINITY)), "a.exr, pixel (2, 1): NaN or infinite");
    let negative = with(v(0.5, -0.25, -1.0)).unwrap();
    assert_eq!(negative.value.pixel(2, 1), v(0.5, 0.0, 0.0));
    assert_eq!(messages(&negative), ["a.exr, pixel (2, 1): 1 negative pixel set to 0 (lowest -1)"]);
    golden(read_image(b"GIF89a", "a.gif"), "a.gif, byte 0: not a picture format that can be read: HDR, EXR, PNG");
    assert!(Image::new(0, 4, vec![]).is_err());
    assert!(Image::new(2, 2, vec![Vector3::zeros(); 3]).is_err());
    // What would not be read is not written.
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut pixels = picture(4, 3).into_pixels();
        pixels[6].y = bad;
        let image = Image::new(4, 3, pixels).unwrap();
        for result in [encode_exr(&image), encode_hdr(&image)] {
            let e = result.unwrap_err();
            assert!(matches!(e, Error::NotFinite { index: 6, .. }), "{e}");
        }
        let folder = tempfile::tempdir().unwrap();
        assert!(save_exr(folder.path().join("a.exr"), &image).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

mod exr_files {
    use exr::prelude::*;
    use std::io::Cursor;

    /// A file with the given channels, in which channel c has the value 64 + c + x + 10 y.
    pub(super) fn with_channels(names: &[&str], compression: Compression) -> Vec<u8> {
        layer(names, compression, (0, 0), None, Vec2(8, 4), Blocks::ScanLines)
    }

    pub(super) fn layer(
        names: &[&str],
        compression: Compression,
        at: (i32, i32),
        display: Option<IntegerBounds>,
        size: Vec2<usize>,
        blocks: Blocks,
    ) -> Vec<u8> {
        let list = names.iter().enumerate().map(|(c, name)| {
            let samples = (0..size.area()).map(|i| (64 + c + i % size.0 + 10 * (i / size.0)) as f32);
            let samples = if c % 2 == 0 {
                FlatSamples::F16(samples.map(f16::from_f32).collect())
            } else {
                FlatSamples::F32(samples.collect())
            };
            AnyChannel::new(*name, samples)
        });
        let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
        let mut attributes = LayerAttributes::named("layer");
        attributes.layer_position = Vec2(at.0, at.1);
        let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(list.collect()));
        let display = display.unwrap_or(IntegerBounds::new(at, size));
        let image = Image { attributes: ImageAttributes::new(display), layer_data: layer };
        let mut out = Cursor::new(Vec::new());
        image.write().to_buffered(&mut out).unwrap();
        out.into_inner()
    }

    /// Any pixels, those included that the writer of the library refuses.
    pub(super) fn rgb(width: usize, pixels: &[super::Vector3<f32>]) -> Vec<u8> {
        let pixel = |at: Vec2<usize>| {
            let p = pixels[at.1 * width + at.0];
            (p.x, p.y, p.z)
        };
        let mut out = Cursor::new(Vec::new());
        let image = Image::from_channels((width, pixels.len() / width), SpecificChannels::rgb(pixel));
        image.write().to_buffered(&mut out).unwrap();
        out.into_inner()
    }

    pub(super) fn two_parts() -> Vec<u8> {
        let part = |name: &str| {
            let list = smallvec(AnyChannel::new("Y", FlatSamples::F32(vec![1.0; 4])));
            Layer::new((2, 2), LayerAttributes::named(name), Encoding::UNCOMPRESSED, AnyChannels::sort(list))
        };
        let layers = [part("a"), part("b")].into_iter().collect::<Layers<_>>();
        let image = Image::from_layers(ImageAttributes::new(IntegerBounds::from_dimensions((2, 2))), layers);
        let mut out = Cursor::new(Vec::new());
        image.write().to_buffered(&mut out).unwrap();
        out.into_inner()
    }

    fn smallvec<T>(x: T) -> exr::prelude::SmallVec<[T; 4]> {
        std::iter::once(x).collect()
    }
}

#[test]
fn exr_compressions_channels_and_windows() {
    use exr::prelude::{Blocks, Compression, IntegerBounds, Vec2};
    let lossless = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
    ];
    let lossy = [Compression::B44, Compression::B44A, Compression::DWAA(None), Compression::DWAB(None)];
    for compression in lossless.into_iter().chain(lossy) {
        let loaded = read_exr(&exr_files::with_channels(&["R", "G", "B", "A", "Z"], compression), "a.exr").unwrap();
        assert_eq!(loaded.warnings, [], "{compression}");
        for (i, p) in loaded.value.pixels().iter().enumerate() {
            let expected = Vector3::repeat((64 + i % 8 + 10 * (i / 8)) as f32) + v(0.0, 1.0, 2.0);
            // B44 has 6 bits for the differences within 4 × 4 pixels, whose values here run from 64 to 101.
            let tolerance = if lossless.contains(&compression) { 0.0 } else { 1.0 };
            assert!((p - expected).amax() <= tolerance, "{compression}, pixel {i}: {p} {expected}");
        }
    }
    let read = |names: &[&str]| read_exr(&exr_files::with_channels(names, Compression::ZIP16), "a.exr");
    assert_eq!(read(&["Y", "Z"]).unwrap().value.pixel(3, 1), v(77.0, 77.0, 77.0));
    let layered = read(&["a.R", "a.G", "a.B", "b.Z"]).unwrap();
    assert_eq!(layered.value.pixel(0, 0), v(64.0, 65.0, 66.0));
    assert_eq!(messages(&layered), ["a.exr, header: colours taken from the layer \"a\""]);
    golden(
        read(&["a.R", "a.G", "a.B", "b.R", "b.G", "b.B"]),
        "a.exr, header: there is no one set of channels R, G, B and no plain Y; the channels are: a.B, a.G, a.R, b.B, b.G, b.R",
    );
    golden(
        read(&["Y", "RY", "BY"]),
        "a.exr, header: there is no one set of channels R, G, B and no plain Y; the channels are: BY, RY, Y",
    );
    golden(
        read_exr(&exr_files::two_parts(), "a.exr"),
        "a.exr, header: a file of several parts cannot be read; save one part by itself",
    );
    let mut deep = exr_files::with_channels(&["Y"], Compression::ZIP16);
    deep[5] |= 0x08;
    golden(read_exr(&deep, "a.exr"), "a.exr, header: deep data cannot be read; flatten the picture first");

    // Data window of 8 × 4 at (−2, 1) in a display window of 4 × 6 at (0, 0), scan lines and tiles.
    for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(3, 3))] {
        let display = Some(IntegerBounds::new((0, 0), (4, 6)));
        let bytes = exr_files::layer(&["Y"], Compression::ZIP16, (-2, 1), display, Vec2(8, 4), blocks);
        let loaded = read_exr(&bytes, "a.exr").unwrap();
        assert_eq!((loaded.value.width(), loaded.value.height()), (4, 6));
        for y in 0..6 {
            for x in 0..4 {
                let expected = if (1..5).contains(&y) { (64 + x + 2 + 10 * (y - 1)) as f32 } else { 0.0 };
                assert_eq!(loaded.value.pixel(x, y).x, expected, "({x}, {y})");
            }
        }
        assert_eq!(
            messages(&loaded),
            [
                "a.exr, header: the data window (8 × 4 at -2, 1) is not the display window (4 × 6); cut or filled with black"
            ]
        );
    }
}

// -------------------------------------------------------------------------------------------------- environments

#[test]
fn environments_of_every_layout() {
    // A colour that is linear in the direction, sampled at the pixels that each layout puts there.
    let colour = |d: Vector3<f64>| d.normalize().map(|c| (1.0 + c) as f32);
    let n = 8;
    let centre = |i: usize| (2 * i + 1) as f64 / n as f64 - 1.0;
    let cross = |x: usize, y: usize, tall: bool| {
        let (u, v) = (centre(x % n), centre(y % n));
        // Written per cell as the direction that its centre looks along, and the picture's right and down there.
        let d = match (x / n, y / n) {
            (1, 1) => Vector3::new(u, -v, -1.0),
            (0, 1) => Vector3::new(-1.0, -v, -u),
            (2, 1) => Vector3::new(1.0, -v, u),
            (3, 1) => Vector3::new(-u, -v, 1.0),
            (1, 0) => Vector3::new(u, 1.0, -v),
            (1, 2) => Vector3::new(u, -1.0, v),
            (1, 3) if tall => Vector3::new(u, v, 1.0),
            _ => return Vector3::repeat(9.0),
        };
        colour(d)
    };
    let strip =
        |i: usize, x: usize, y: usize| colour(haarmonic::sphere::Face::ALL[i].point(centre(x % n), centre(y % n)));
    let lat_long = LatLongMap::from_fn(haarmonic::sphere::LatLongGrid::new(64, 32).unwrap(), |d| colour(*d));
    let make = |w: usize, h: usize, f: &dyn Fn(usize, usize) -> Vector3<f32>| {
        Image::new(w, h, (0..w * h).map(|i| f(i % w, i / w)).collect()).unwrap()
    };
    let images = [
        make(4 * n, 3 * n, &|x, y| cross(x, y, false)),
        make(3 * n, 4 * n, &|x, y| cross(x, y, true)),
        make(6 * n, n, &|x, y| strip(x / n, x, y)),
        make(n, 6 * n, &|x, y| strip(y / n, x, y)),
        Image::from(lat_long),
    ];
    for image in images {
        let loaded = read_environment(&encode_exr(&image).unwrap(), "a.exr").unwrap();
        assert_eq!(loaded.warnings, []);
        let mut worst = 0.0f64;
        for d in haarmonic::sphere::CubeGrid::new(5).unwrap().directions() {
            worst = worst.max((loaded.value.radiance(&d) - d.map(|c| 1.0 + c)).amax());
        }
        // Bilinear interpolation between directions up to 2/8 apart; a wrong axis would give an error of order 1.
        assert!(worst < 0.03, "{} × {}: {worst}", image.width(), image.height());
    }
    let odd = read_environment(&encode_exr(&picture(5, 3)).unwrap(), "a.exr").unwrap();
    assert_eq!(messages(&odd), ["a.exr: 5 × 3 pixels are not 2 : 1; taken as a latitude–longitude map all the same"]);
}

// -------------------------------------------------------------------------------------------------- the file system

#[test]
fn paths_that_are_not_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let shown = |name: &str| at(name).display().to_string();
    std::fs::write(at("empty.obj"), "").unwrap();
    std::fs::write(at("a.stl"), "solid").unwrap();
    std::fs::create_dir(at("folder.obj")).unwrap();
    golden(
        load_mesh(at("none.obj")),
        &format!("{}: there is no such file", shown("none.obj")).replace("there is", "cannot be read: there is"),
    );
    golden(load_mesh(at("empty.obj")), &format!("{}: the file is empty", shown("empty.obj")));
    golden(load_mesh(at("folder.obj")), &format!("{}: is a folder, not a file", shown("folder.obj")));
    golden(
        load_mesh(at("a.stl")),
        &format!("{}: not a mesh format that can be read: OBJ, PLY, glTF, GLB", shown("a.stl")),
    );
    golden(load_image(at("none.exr")), &format!("{}: cannot be read: there is no such file", shown("none.exr")));
    golden(load_environment(at("folder.obj")), &format!("{}: is a folder, not a file", shown("folder.obj")));
    let image = picture(2, 2);
    golden(save_exr(at("folder.obj"), &image), &format!("{}: is a folder, not a file", shown("folder.obj")));
    golden(
        save_hdr(at("no/a.hdr"), &image),
        &format!("{}: cannot be written: there is no such folder", shown("no/a.hdr")),
    );
}

#[test]
fn files_are_replaced_whole() {
    let folder = tempfile::tempdir().unwrap();
    let image = picture(8, 4);
    for name in ["a.exr", "a.hdr", "a.png"] {
        let path = folder.path().join(name);
        std::fs::write(&path, "old").unwrap();
        match name {
            "a.exr" => save_exr(&path, &image),
            "a.hdr" => save_hdr(&path, &image),
            _ => save_png(&path, &image, -4.0),
        }
        .unwrap();
        assert_eq!(load_image(&path).unwrap().value.width(), 8);
    }
    save_png_srgb8(folder.path().join("b.png"), 1, 1, &[[1, 2, 3]]).unwrap();
    // A failure leaves the old file and nothing else.
    let nan = Image::new(1, 1, vec![Vector3::repeat(f32::NAN)]).unwrap();
    let before = std::fs::read(folder.path().join("a.hdr")).unwrap();
    assert!(save_hdr(folder.path().join("a.hdr"), &nan).is_err());
    assert_eq!(std::fs::read(folder.path().join("a.hdr")).unwrap(), before);
    let mut names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["a.exr", "a.hdr", "a.png", "b.png"]);
}

#[cfg(unix)]
#[test]
fn links_are_followed() {
    let folder = tempfile::tempdir().unwrap();
    let (target, link) = (folder.path().join("target.exr"), folder.path().join("link.exr"));
    std::fs::write(&target, "old").unwrap();
    std::os::unix::fs::symlink(&target, &link).unwrap();
    save_exr(&link, &picture(3, 2)).unwrap();
    assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(load_image(&target).unwrap().value, picture(3, 2));
}

// ---------------------------------------------------------------------------------------------------------- damage

/// Small valid files and their readers.
fn mesh_files() -> Vec<(&'static str, Vec<u8>, ReadMesh)> {
    let rich_obj = "v 0 0 0\nv 1 0 0\nv 1 1 0 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nvn 0 1 0\nf 1//1 2//1 3//1 \\\n 4//2\nf -1 -2 -3\n";
    vec![
        ("a.obj", rich_obj.into(), READ_OBJ),
        ("ascii.ply", rich_ply("ascii"), READ_PLY),
        ("little.ply", rich_ply("binary_little_endian"), READ_PLY),
        ("big.ply", rich_ply("binary_big_endian"), READ_PLY),
        ("a.gltf", gltf(&data_uri(), r#"{"mesh":0,"scale":[1,2,3]}"#, INDEXED).into(), READ_GLTF),
        ("a.glb", glb(&gltf("", r#"{"mesh":0}"#, INDEXED), &gltf_buffer()), READ_GLTF),
    ]
}

fn image_files() -> Vec<(String, Vec<u8>)> {
    let mut files = vec![
        ("a.hdr".to_owned(), encode_hdr(&picture(33, 5)).unwrap()),
        ("narrow.hdr".to_owned(), encode_hdr(&picture(3, 5)).unwrap()),
        ("a.png".to_owned(), encode_png(&picture(9, 7), 0.0).unwrap()),
        ("float.exr".to_owned(), encode_exr(&picture(9, 7)).unwrap()),
    ];
    for compression in COMPRESSIONS {
        files.push((format!("{compression}.exr"), exr_files::with_channels(&["R", "G", "B"], compression)));
    }
    files
}

/// An error of a reader names the file.
fn check<T>(name: &str, result: haarmonic::Result<T>) {
    if let Err(e) = result {
        assert!(e.to_string().starts_with(name), "{e}");
    }
}

#[test]
fn meshes_cut_short_at_every_byte() {
    for (name, bytes, read) in mesh_files() {
        let _ = read(&bytes, name).unwrap_or_else(|e| panic!("{e}"));
        for n in 0..bytes.len() {
            check(name, read(&bytes[..n], name));
        }
    }
}

#[test]
fn pictures_cut_short_at_every_byte() {
    for (name, bytes) in image_files() {
        let _ = read_image(&bytes, &name).unwrap_or_else(|e| panic!("{e}"));
        for n in 0..bytes.len() {
            let result = read_image(&bytes[..n], &name);
            assert!(result.is_err() || name == "a.png", "{name} cut to {n} of {} bytes was read", bytes.len());
            check(&name, result);
        }
    }
}

/// What happens to the bytes of a file.
fn damage() -> impl Strategy<Value = Vec<(prop::sample::Index, u8, u8)>> {
    prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..4u8), 1..6)
}

fn apply(bytes: &mut Vec<u8>, damage: &[(prop::sample::Index, u8, u8)]) {
    for (index, value, kind) in damage {
        if bytes.is_empty() {
            return;
        }
        let at = index.index(bytes.len());
        match kind {
            0 => bytes[at] = *value,
            1 => bytes[at] ^= 1 << (value % 8),
            2 => bytes.insert(at, *value),
            _ => drop(bytes.drain(at..(at + usize::from(*value) / 16).min(bytes.len()))),
        }
    }
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn damaged_meshes(damage in damage()) {
        for (name, mut bytes, read) in mesh_files() {
            apply(&mut bytes, &damage);
            check(name, read(&bytes, name));
        }
    }

    #[test]
    fn damaged_pictures(damage in damage()) {
        for (name, mut bytes) in image_files() {
            apply(&mut bytes, &damage);
            check(&name, read_image(&bytes, &name));
        }
    }

    #[test]
    fn noise(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        for (name, head, read) in [("n.obj", "v ", READ_OBJ), ("n.ply", "ply\nformat ascii 1.0\n", READ_PLY), ("n.glb", "glTF\x02\0\0\0", READ_GLTF)] {
            check(name, read(&bytes, name));
            check(name, read(&[head.as_bytes(), &bytes].concat(), name));
        }
        for head in [&b"#?RADIANCE\n\n-Y 3 +X 9\n"[..], b"\x76\x2f\x31\x01\x02\0\0\0", b"\x89PNG\r\n\x1a\n", b""] {
            check("n.img", read_image(&[head, &bytes].concat(), "n.img"));
        }
    }

    #[test]
    fn ply_round_trip(corners in prop::collection::vec(prop::array::uniform3(-1e6f32..1e6), 3..40), seed in any::<u64>()) {
        let n = corners.len() as u64;
        let faces: Vec<[u32; 3]> = (0..n).map(|i| [i, (i + 1 + seed % (n - 1)) % n, (i + 1 + (seed >> 32) % (n - 1)) % n].map(|i| i as u32)).collect();
        let Ok(mesh) = Mesh::new(corners.into_iter().map(Vector3::from).collect(), faces) else { return Ok(()) };
        let back = read_ply(&encode_ply(&mesh, None).unwrap(), "a.ply").map(|l| l.value);
        // Faces without area, and the vertices that only they have, are dropped: compare what they leave.
        if let Ok(back) = back && back.faces().len() == mesh.faces().len() {
            prop_assert_eq!(back.positions(), mesh.positions());
            prop_assert_eq!(back.faces(), mesh.faces());
            // Unit vectors are scaled to unit length once more.
            for (a, b) in back.normals().iter().zip(mesh.normals()) {
                prop_assert!((a - b).amax() <= f32::EPSILON, "{} {}", a, b);
            }
        }
    }
}

/// Files whose header promises far more than they hold are refused before memory is taken.
#[test]
fn lying_headers() {
    let mut exr = encode_exr(&picture(4, 4)).unwrap();
    let at = |bytes: &[u8], name: &[u8]| bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len();
    for window in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
        let i = at(&exr, window) + 4;
        exr[i + 8..i + 16].copy_from_slice(&[0xff, 0xff, 0, 0, 0xff, 0xff, 0, 0]);
    }
    let i = at(&exr, b"chunkCount\0int\0") + 4;
    exr[i..i + 4].copy_from_slice(&4096u32.to_le_bytes());
    golden(
        read_exr(&exr, "a.exr"),
        "a.exr, header, display window: a picture of 65536 × 65536 pixels; at most 2^27 can be read",
    );

    // A data window beyond what the bytes can hold, and a display window that is almost all empty.
    let mut wide = encode_exr(&picture(4, 4)).unwrap();
    let i = at(&wide, b"dataWindow\0box2i\0") + 4;
    wide[i + 8..i + 12].copy_from_slice(&0x7f_ffffu32.to_le_bytes());
    golden(
        read_exr(&wide, "a.exr"),
        &format!("a.exr, header, data window: 8388608 × 4 pixels in 1 blocks cannot come from {} bytes", wide.len()),
    );
    let mut empty = encode_exr(&picture(4, 4)).unwrap();
    let i = at(&empty, b"displayWindow\0box2i\0") + 4;
    empty[i + 8..i + 12].copy_from_slice(&0xff_ffffu32.to_le_bytes());
    golden(
        read_exr(&empty, "a.exr"),
        "a.exr, header, display window: 16777216 × 4 pixels, more than 1024 times the 4 × 4 that have data",
    );

    let mut png = encode_png(&picture(4, 4), 0.0).unwrap();
    png[16..24].copy_from_slice(&[0, 0, 0xff, 0xff, 0, 0, 0x07, 0xff]);
    let e = read_png(&png, "a.png").unwrap_err().to_string();
    assert!(e.starts_with("a.png, header:"), "{e}");
}

/// The readers name a path as it was given.
#[test]
fn names_are_kept() {
    let e = read_obj(b"v x", Path::new("some/where.obj")).unwrap_err();
    assert!(matches!(e, Error::File { path, .. } if path == Path::new("some/where.obj")));
}
