//! glTF files as real writers make them: faults beside the mesh, odd containers, sparse and absent data, instances.

use haarmonic::io::{Loaded, read_gltf};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::Mesh;
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::meshes::{check, fault, messages, v};

use crate::support::cases;

/// Little-endian bytes of numbers.
macro_rules! bytes {
    ($t:ty: $($x:expr),* $(,)?) => { [$(<$t>::to_le_bytes($x)),*].concat() };
}

/// A document that is put together piece by piece.
struct Document {
    json: Value,
    buffer: Vec<u8>,
}

const F32: u32 = 5126;

impl Document {
    /// The square (0, 0, 0) – (2, 2, 0): positions are accessor 0, indices accessor 1.
    fn square() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "bufferViews": [], "accessors": [],
        });
        let mut document = Self { json, buffer: Vec::new() };
        let corners = bytes!(f32: 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 2.0, 0.0, 0.0, 2.0, 0.0);
        document.accessor(&corners, F32, 4, "VEC3");
        document.accessor(&bytes!(u16: 0, 1, 2, 0, 2, 3), 5123, 6, "SCALAR");
        document
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0xee);
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len()}));
        self.buffer.extend_from_slice(bytes);
        views.len() - 1
    }

    fn push(&mut self, accessor: Value) -> usize {
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(accessor);
        accessors.len() - 1
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, count: usize, shape: &str) -> usize {
        let view = self.view(bytes);
        self.push(json!({"bufferView": view, "componentType": component, "count": count, "type": shape}))
    }

    /// The `sparse` of an accessor.
    fn sparse(&mut self, count: usize, indices: &[u8], component: u32, values: &[u8]) -> Value {
        let (indices, values) = (self.view(indices), self.view(values));
        json!({"count": count, "indices": {"bufferView": indices, "componentType": component},
               "values": {"bufferView": values}})
    }

    fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    fn json(&self) -> String {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.buffer.len()}]);
        json.to_string()
    }

    fn glb(&self) -> Vec<u8> {
        let mut text = self.json().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut binary = self.buffer.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        glb(&[(b"JSON", &text), (b"BIN\0", &binary)])
    }

    fn read(&self) -> haarmonic::Result<Loaded<Mesh>> {
        read_gltf(&self.glb(), "a.glb")
    }

    #[track_caller]
    fn refused(&self, message: &str) {
        assert_eq!(self.read().unwrap_err().to_string(), message);
    }
}

/// Kind and content.
type Chunk<'a> = (&'a [u8; 4], &'a [u8]);

fn glb(chunks: &[Chunk<'_>]) -> Vec<u8> {
    let length: usize = chunks.iter().map(|(_, c)| 8 + c.len()).sum();
    let mut out = [&b"glTF"[..], &bytes!(u32: 2, 12 + length as u32)].concat();
    for (kind, content) in chunks {
        out.extend(bytes!(u32: content.len() as u32));
        out.extend_from_slice(*kind);
        out.extend_from_slice(content);
    }
    out
}

// ---------------------------------------------------------------------------------------- what a mesh does not need

#[test]
fn valid_animations_are_no_trouble() {
    for name in ["animation_pointer.gltf", "channel_without_node.gltf"] {
        let loaded = fault(&format!("gltf/{name}"));
        check(&loaded, 2, 4.0);
        assert_eq!(messages(&loaded), [""; 0], "{name}");
    }
}

#[test]
fn a_broken_material_is_a_warning() {
    let loaded = fault("gltf/material_three_numbers.gltf");
    check(&loaded, 2, 4.0);
    assert_eq!(
        messages(&loaded),
        ["materials[0].pbrMetallicRoughness.baseColorFactor: is not a list of 4 numbers; the mesh does not need it"]
    );
}

#[test]
fn faults_beside_the_mesh_are_warnings() {
    // What stands at the top level, and the warning's place; no place where the standard allows it.
    let cases = [
        (json!({"animations": {}}), "animations"),
        (json!({"animations": [3]}), "animations[0]"),
        (json!({"animations": [{"channels": 1}]}), "animations[0].channels"),
        (json!({"animations": [{"channels": [{"target": {"path": 7}}]}]}), "animations[0].channels[0].target.path"),
        (json!({"animations": [{"channels": [{"target": {"path": "swirl"}}]}]}), ""),
        (json!({"animations": [{"channels": [{}, {"target": {"node": 1}}]}]}), "animations[0].channels[1].target.node"),
        (json!({"animations": [{"samplers": [{"input": -1}]}]}), "animations[0].samplers[0].input"),
        (json!({"animations": [{"samplers": [{"input": 99}]}]}), "animations[0].samplers[0].input"),
        (json!({"animations": [{}]}), ""),
        (json!({"cameras": [{"type": "fisheye"}]}), ""),
        (json!({"cameras": [{"perspective": {"yfov": "wide"}}]}), "cameras[0].perspective.yfov"),
        (json!({"images": [{"uri": 5}]}), "images[0].uri"),
        (json!({"images": [{"bufferView": 77}]}), "images[0].bufferView"),
        (json!({"images": [{"uri": "absent.png"}]}), ""),
        (json!({"materials": "red"}), "materials"),
        (json!({"materials": [null]}), "materials[0]"),
        (json!({"materials": [{"emissiveFactor": [1, 2, "x"]}]}), "materials[0].emissiveFactor"),
        (json!({"materials": [{"alphaMode": "SORT OF"}]}), ""),
        (json!({"materials": [{"alphaMode": 2}]}), "materials[0].alphaMode"),
        (json!({"materials": [{"doubleSided": 1}]}), "materials[0].doubleSided"),
        (json!({"materials": [{"name": 1, "alphaCutoff": "a"}]}), "materials[0].name"),
        (json!({"materials": [{"normalTexture": {"index": 0}}]}), "materials[0].normalTexture.index"),
        (json!({"materials": [{"extensions": {"KHR_materials_ior": {"ior": "high"}}}]}), ""),
        (json!({"samplers": [{"magFilter": 1}]}), ""),
        (json!({"samplers": [{"wrapS": 10497.5}]}), "samplers[0].wrapS"),
        (json!({"skins": [{"joints": [0, 5]}]}), "skins[0].joints[1]"),
        (json!({"skins": [{"joints": 0}]}), "skins[0].joints"),
        (json!({"nodes": [{"mesh": 0, "skin": 1, "translation": [7, 0, 0]}]}), "nodes[0].skin"),
        (json!({"textures": [{"source": 0}]}), "textures[0].source"),
        (json!({"textures": [{"source": 0}], "images": [{}]}), ""),
        (json!({"extensionsUsed": ["ACME_rocket"], "extensions": {"ACME_rocket": 3}}), ""),
        (json!({"extensionsUsed": 3, "extensions": 4, "extras": [[]]}), ""),
        (json!({"extensionsRequired": "ACME_rocket"}), "extensionsRequired"),
        (json!({"extensionsRequired": ["KHR_materials_unlit", "KHR_animation_pointer", "EXT_texture_webp"]}), ""),
    ];
    for (extra, place) in cases {
        let mut document = Document::square();
        document.json.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
        let loaded = document.read().unwrap_or_else(|e| panic!("{extra}: {e}"));
        check(&loaded, 2, 4.0);
        let places: Vec<_> = loaded.warnings.iter().map(|w| w.place.as_str()).collect();
        assert_eq!(places, if place.is_empty() { vec![] } else { vec![place] }, "{extra}");
    }
}

#[test]
fn faults_beside_the_mesh_inside_of_what_it_needs() {
    let mut document = Document::square();
    document.json["nodes"][0] = json!({"mesh": 0, "camera": "front", "name": 4, "weights": 1, "extensions": []});
    document.json["meshes"][0]["weights"] = json!("heavy");
    document.primitive()["material"] = json!(9);
    document.primitive()["attributes"]["TEXCOORD_1"] = json!("none");
    document.json["accessors"][0]["min"] = json!("unknown");
    document.json["accessors"][0]["max"] = json!([1e300]);
    document.json["bufferViews"][0]["target"] = json!(7);
    document.json["bufferViews"][0]["name"] = json!({});
    let absent = json!({"componentType": 1, "count": -1, "type": "MAT9", "bufferView": 1000});
    document.push(absent);
    document.json["meshes"].as_array_mut().unwrap().push(json!({"primitives": 3}));
    let loaded = document.read().unwrap();
    check(&loaded, 2, 4.0);
    assert_eq!(
        messages(&loaded),
        [
            "meshes[0].weights: is not a list of numbers, like 1 field more there; the mesh does not need it",
            "nodes[0].name: is not a string, like 3 fields more there; the mesh does not need it",
        ]
    );
}

#[test]
fn texture_coordinates_are_turned_round() {
    let expected = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let floats = bytes!(f32: 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0);
    let shorts = bytes!(u16: 0, 0, 65535, 0, 65535, 65535, 0, 65535);
    let chars = [0_u8, 0, 255, 0, 255, 255, 0, 255];
    for (bytes, component) in [(&floats[..], F32), (&shorts, 5123), (&chars, 5121)] {
        let mut document = Document::square();
        let accessor = document.accessor(bytes, component, 4, "VEC2");
        document.json["accessors"][accessor]["normalized"] = json!(component != F32);
        document.primitive()["attributes"]["TEXCOORD_0"] = json!(accessor);
        document.json["nodes"][0]["scale"] = json!([-1.0, 1.0, 1.0]);
        let loaded = document.read().unwrap();
        assert_eq!(messages(&loaded), [""; 0]);
        for (position, uv) in loaded.value.positions().iter().zip(loaded.value.uv().unwrap()) {
            // The square's own coordinates, before it is mirrored, are 2 u and 2 (1 − v).
            assert_eq!([-0.5 * position.x, 1.0 - 0.5 * position.y], [uv.x, uv.y]);
            assert!(expected.contains(&(*uv).into()));
        }
    }
    // What lies between the whole numbers: 51 / 255 = 0.2.
    let mut document = Document::square();
    let accessor = document.accessor(&[51, 51, 0, 0, 51, 51, 0, 0], 5121, 4, "VEC2");
    document.json["accessors"][accessor]["normalized"] = json!(true);
    document.primitive()["attributes"]["TEXCOORD_0"] = json!(accessor);
    let uv = document.read().unwrap().value.uv().unwrap()[0];
    assert_eq!([uv.x, uv.y], [0.2, 0.8]);
}

#[test]
fn faults_in_texture_coordinates_are_warnings() {
    let mut document = Document::square();
    document.primitive()["attributes"]["TEXCOORD_0"] = json!("none");
    let place = "mesh 0 primitive 0 TEXCOORD_0";
    let lost = "1 primitive has texture coordinates that cannot be read; left out";
    let check = |document: &Document, reason: &str| {
        let loaded = document.read().unwrap();
        assert_eq!(loaded.value.uv(), None);
        assert_eq!(messages(&loaded), [format!("{place}: {reason}: {lost}")]);
    };
    check(&document, "\"TEXCOORD_0\" is not a whole number that fits");
    let accessor = document.accessor(&bytes!(f32: 0.0, 0.0, 1.0, 0.0, 1.0, 1.0), F32, 3, "VEC2");
    document.primitive()["attributes"]["TEXCOORD_0"] = json!(accessor);
    check(&document, &format!("accessor {accessor}: 3 pairs for 4 positions"));
    let accessor = document.accessor(&bytes!(u32: 0, 0, 1, 0, 1, 1, 0, 0), 5125, 4, "VEC2");
    document.primitive()["attributes"]["TEXCOORD_0"] = json!(accessor);
    check(&document, &format!("accessor {accessor}: texture coordinates cannot be 32-bit integers"));
    // Numbers that are not finite, and a second primitive without any.
    let nan = bytes!(f32: 0.0, f32::NAN, 1.0, 0.0, f32::INFINITY, 1.0, 0.5, 1.0);
    let accessor = document.accessor(&nan, F32, 4, "VEC2");
    document.primitive()["attributes"]["TEXCOORD_0"] = json!(accessor);
    let second = json!({"attributes": {"POSITION": 0}, "indices": 1});
    document.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(second);
    document.json["nodes"][0]["children"] = json!([]);
    let loaded = document.read().unwrap();
    let warnings = messages(&loaded);
    assert_eq!(
        warnings[..2],
        [
            format!("{place} 0: 2 texture coordinates are malformed, NaN or infinite; set to (0, 0)"),
            "triangle 2: 6 corners of triangles have no texture coordinates, others have; set to (0, 0)".into(),
        ]
    );
    assert!(loaded.value.uv().unwrap().iter().any(|uv| [uv.x, uv.y] == [0.5, 0.0]));
}

#[test]
fn faults_in_what_the_mesh_needs_are_errors() {
    type Change = (&'static str, Value, &'static str);
    let changes: [Change; 18] = [
        ("/asset", json!({}), "asset: has no \"version\"; a glTF document must state it"),
        ("/scene", json!("first"), "scene: \"scene\" is not a whole number that fits"),
        ("/scenes", json!(1), "scenes: \"scenes\" is not a list"),
        ("/scenes/0/nodes", json!([-1]), "scene: \"nodes\" is not a list of whole numbers"),
        ("/nodes/0", json!([]), "node 0: the node is not an object"),
        ("/nodes/0", json!({"mesh": "a"}), "node 0: \"mesh\" is not a whole number that fits"),
        ("/nodes/0", json!({"mesh": 0, "scale": [1, 1]}), "node 0: \"scale\" is not a list of 3 numbers"),
        ("/nodes/0", json!({"mesh": 0, "children": [0.5]}), "node 0: \"children\" is not a list of whole numbers"),
        ("/meshes/0/primitives", json!({}), "mesh 0: \"primitives\" is not a list"),
        ("/meshes/0/primitives/0", json!(1), "mesh 0 primitive 0: is not an object"),
        ("/meshes/0/primitives/0/mode", json!(7), "mesh 0 primitive 0: its mode is not one of glTF"),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(-2),
            "mesh 0 primitive 0: \"POSITION\" is not a whole number that fits",
        ),
        (
            "/accessors/0/count",
            json!(2.5),
            "mesh 0 primitive 0 POSITION: accessor 0: \"count\" is not a whole number that fits",
        ),
        ("/accessors/0/type", json!(3), "mesh 0 primitive 0 POSITION: accessor 0: its \"type\" is not a string"),
        (
            "/accessors/1/componentType",
            json!(5124),
            "mesh 0 primitive 0 indices: accessor 1: its component type 5124 is not one of glTF",
        ),
        ("/bufferViews/1", json!({"buffer": 0}), "mesh 0 primitive 0 indices: accessor 1: it has no \"byteLength\""),
        (
            "/bufferViews/1/byteOffset",
            json!(1e15),
            "mesh 0 primitive 0 indices: accessor 1: its buffer view reaches beyond the buffer",
        ),
        (
            "/bufferViews/0/buffer",
            json!(1),
            "mesh 0 primitive 0 POSITION: accessor 0: buffer 1: there is no such buffer",
        ),
    ];
    for (pointer, value, message) in changes {
        let mut document = Document::square();
        match document.json.pointer_mut(pointer) {
            Some(place) => *place = value,
            None => {
                let (parent, name) = pointer.rsplit_once('/').unwrap();
                document.json.pointer_mut(parent).unwrap()[name] = value;
            }
        }
        document.refused(&format!("a.glb, {message}"));
    }
    let mut document = Document::square();
    document.json["extensionsRequired"] = json!(["KHR_materials_unlit", "ACME_rocket"]);
    document.refused("a.glb, extensionsRequired: the extension \"ACME_rocket\" cannot be read");
}

#[test]
fn integers_may_have_a_fraction_of_zero() {
    let mut document = Document::square();
    document.json["accessors"][0]["count"] = json!(4.0);
    document.json["scene"] = json!(0.0);
    check(&document.read().unwrap(), 2, 4.0);
}

#[test]
fn names_need_not_be_utf_8() {
    let mut document = Document::square();
    document.json["materials"] = json!([{"name": "caf@"}]);
    let mut glb = document.glb();
    let at = glb.iter().position(|b| *b == b'@').unwrap();
    glb[at] = 0xe9;
    let loaded = read_gltf(&glb, "a.glb").unwrap();
    check(&loaded, 2, 4.0);
    assert_eq!(messages(&loaded), ["JSON line 1: characters that are not UTF-8 replaced"]);
}

#[test]
fn nan_in_the_json_is_null() {
    let mut document = Document::square();
    document.json["materials"] = json!([{"alphaCutoff": "@", "name": "a \"NaN\" \\"}]);
    document.json["accessors"][0]["max"] = json!(["@", "@", 0]);
    let text = document.json();
    for word in ["NaN", "-Infinity", "nan", "-inf", "Infinity"] {
        let text = text.replace("\"@\"", word);
        let loaded = read_gltf(&glb(&[(b"JSON", text.as_bytes()), (b"BIN\0", &document.buffer)]), "a.glb").unwrap();
        check(&loaded, 2, 4.0);
        assert_eq!(messages(&loaded), ["JSON line 1: NaN and Infinity are not JSON; read as null"], "{word}");
    }
    // In what the mesh needs it is no number.
    document.json["nodes"][0]["translation"] = json!([0, "@", 0]);
    let text = document.json().replace("\"@\"", "NaN");
    let e = read_gltf(text.as_bytes(), "a.gltf").unwrap_err().to_string();
    assert_eq!(e, "a.gltf, node 0: \"translation\" is not a list of 3 numbers");
    let e = read_gltf(b"{\"a\": [NaN, }", "a.gltf").unwrap_err().to_string();
    assert!(e.starts_with("a.gltf, JSON line 1 column"), "{e}");
}

// ------------------------------------------------------------------------------------------------------- containers

#[test]
fn json_may_be_padded_with_anything_blank() {
    check(&fault("gltf/json_padded_with_nul.glb"), 2, 4.0);
    let document = Document::square();
    let text = document.json();
    let cases: [(&str, &[&str]); 7] = [
        ("", &[]),
        ("   ", &[]),
        ("\t\r\n ", &[]),
        ("\0", &["JSON: 1 byte after its end skipped"]),
        (" \0\0", &["JSON: 3 bytes after its end skipped"]),
        ("\0\0\0\n", &["JSON: 4 bytes after its end skipped"]),
        // What is left in a buffer of C strings.
        ("\0}x", &["JSON: 3 bytes after its end skipped"]),
    ];
    for (padding, expected) in cases {
        for mark in ["", "\u{feff}"] {
            let padded = format!("{mark}{text}{padding}");
            let glb = glb(&[(b"JSON", padded.as_bytes()), (b"BIN\0", &document.buffer)]);
            let loaded = read_gltf(&glb, "a.glb").unwrap();
            check(&loaded, 2, 4.0);
            assert_eq!(messages(&loaded), expected, "{padding:?}");
        }
    }
    let more = format!("{text}}}");
    let e = read_gltf(&glb(&[(b"JSON", more.as_bytes())]), "a.glb").unwrap_err().to_string();
    assert!(e.starts_with("a.glb, JSON line 1 column") && e.ends_with("trailing characters"), "{e}");
    assert_eq!(
        read_gltf(b"[1]", "a.gltf").unwrap_err().to_string(),
        "a.gltf, JSON: is not an object; a glTF document begins with \"{\""
    );
    assert_eq!(read_gltf(b"\0", "a.gltf").unwrap_err().to_string(), "a.gltf, JSON line 1 column 1: expected value");
}

#[test]
fn chunks_in_any_order_and_of_any_kind() {
    let document = Document::square();
    let text = document.json();
    let (json, binary): (&[u8], &[u8]) = (text.as_bytes(), &document.buffer);
    let start = 12 + 8 + binary.len();
    let cases: [(&[Chunk<'_>], Vec<String>); 6] = [
        (&[(b"JSON", json), (b"BIN\0", binary), (b"ACME", b"abcd"), (b"\0\0\0\0", b"")], vec![]),
        (&[(b"ACME", b"abcd"), (b"JSON", json), (b"XYZ\0", b""), (b"BIN\0", binary)], vec![]),
        (
            &[(b"BIN\0", binary), (b"JSON", json)],
            vec![format!("byte {start}: the JSON chunk comes after the binary chunk")],
        ),
        (
            &[(b"JSON", json), (b"BIN\0", binary), (b"BIN\0", b"more")],
            vec![format!("byte {}: a second chunk of the same kind skipped", start + 8 + json.len())],
        ),
        // Padding of the binary chunk, of any length and content, belongs to nothing.
        (&[(b"JSON", json), (b"BIN\0", &[binary, b"   "].concat())], vec![]),
        (&[(b"JSON", json), (b"BIN\0", &[binary, &[0xff; 9]].concat())], vec![]),
    ];
    for (chunks, expected) in cases {
        let loaded = read_gltf(&glb(chunks), "a.glb").unwrap();
        check(&loaded, 2, 4.0);
        assert_eq!(messages(&loaded), expected);
    }
}

#[test]
fn lengths_that_are_not_true() {
    let good = Document::square().glb();
    let end = good.len();
    let json = u32::from_le_bytes(good[12..16].try_into().unwrap()) as usize;
    let with = |at: usize, n: usize| {
        let mut bytes = good.clone();
        bytes[at..at + 4].copy_from_slice(&(n as u32).to_le_bytes());
        bytes
    };
    let whole = |n: usize| format!("byte 8: the GLB file says that it has {n} bytes; its chunks end at byte {end}");
    // The length of the whole: unknown to a writer that streams, or simply wrong.
    for n in [0, 12, 20 + json - 1, end - 1, end + 1, u32::MAX as usize] {
        let loaded = read_gltf(&with(8, n), "a.glb").unwrap();
        check(&loaded, 2, 4.0);
        assert_eq!(messages(&loaded), [whole(n)]);
    }
    // The binary chunk is longer than the file.
    let binary = 20 + json;
    let loaded = read_gltf(&with(binary, 1 << 30), "a.glb").unwrap();
    check(&loaded, 2, 4.0);
    let there = end - binary - 8;
    assert_eq!(
        messages(&loaded),
        [format!("byte {binary}: a GLB chunk of {} bytes, but only {there} are there; those are used", 1 << 30)]
    );
    // Something is appended.
    let loaded = read_gltf(&[&good[..], b"appended"].concat(), "a.glb").unwrap();
    assert_eq!(messages(&loaded), [format!("byte {end}: 8 bytes after the last chunk skipped")]);
    // The size of the JSON chunk leaves its padding out.
    let mut document = Document::square();
    while document.json().len() % 4 != 1 {
        document.json["asset"]["generator"] =
            json!(format!("{}x", document.json["asset"]["generator"].as_str().unwrap_or("")));
    }
    let text = document.json();
    let mut bytes = document.glb();
    bytes[12..16].copy_from_slice(&(text.len() as u32).to_le_bytes());
    let loaded = read_gltf(&bytes, "a.glb").unwrap();
    check(&loaded, 2, 4.0);
    let place = format!("byte {}", 20 + text.len());
    assert_eq!(messages(&loaded), [format!("{place}: the chunk before is padded beyond the size that it states")]);
    // What is needed is cut off.
    let e = read_gltf(&good[..end - 20], "a.glb").unwrap_err().to_string();
    assert!(e.contains("buffer 0: it should have 60 bytes, but only 40 are there"), "{e}");
}

// -------------------------------------------------------------------------------------------------------- accessors

#[test]
fn sparse_positions() {
    let loaded = fault("gltf/sparse.gltf");
    check(&loaded, 2, 6.0);
    assert_eq!(loaded.value.positions()[2], v(3.0, 3.0, 0.0));
    assert_eq!(messages(&loaded), [""; 0]);
    // Indices of every type, in any order; with and without elements below.
    let moved = bytes!(f32: 3.0, 3.0, 0.0, 0.0, 1.0, 0.0);
    let all = bytes!(f32: 0.0, 1.0, 0.0, 2.0, 0.0, 0.0, 3.0, 3.0, 0.0);
    for (indices, three, component) in [
        (vec![2, 3], vec![3, 1, 2], 5121),
        (bytes!(u16: 2, 3), bytes!(u16: 3, 1, 2), 5123),
        (bytes!(u32: 2, 3), bytes!(u32: 3, 1, 2), 5125),
    ] {
        let mut document = Document::square();
        document.json["accessors"][0]["sparse"] = document.sparse(2, &indices, component, &moved);
        let expected = [v(0.0, 0.0, 0.0), v(2.0, 0.0, 0.0), v(3.0, 3.0, 0.0), v(0.0, 1.0, 0.0)];
        assert_eq!(document.read().unwrap().value.positions()[..4], expected);
        let mut document = Document::square();
        let sparse = document.sparse(3, &three, component, &all);
        document.json["accessors"][0] = json!({"componentType": F32, "count": 4, "type": "VEC3", "sparse": sparse});
        assert_eq!(document.read().unwrap().value.positions()[..4], expected);
    }
}

#[test]
fn sparse_normals_and_indices() {
    let mut document = Document::square();
    // Zeros everywhere but for one: the others come from the faces.
    let sparse = document.sparse(1, &[1], 5121, &bytes!(f32: 0.0, 3.0, 4.0));
    let normals = document.push(json!({"componentType": F32, "count": 4, "type": "VEC3", "sparse": sparse}));
    document.primitive()["attributes"]["NORMAL"] = json!(normals);
    document.json["accessors"][1]["sparse"] = document.sparse(1, &bytes!(u16: 4), 5123, &bytes!(u16: 1));
    let loaded = document.read().unwrap();
    assert_eq!(loaded.value.faces(), [[0, 1, 2], [0, 1, 3]]);
    assert!((loaded.value.normals()[1] - v(0.0, 0.6, 0.8)).amax() < 1e-7);
    assert_eq!(loaded.value.normals()[3], v(0.0, 0.0, 1.0));
    assert_eq!(messages(&loaded), [": 3 normals are missing or zero; computed from the faces"]);
    // All of the indices sparse.
    let mut document = Document::square();
    let sparse = document.sparse(4, &[1, 2, 4, 5], 5121, &[1, 2, 2, 3]);
    document.json["accessors"][1] = json!({"componentType": 5121, "count": 6, "type": "SCALAR", "sparse": sparse});
    check(&document.read().unwrap(), 2, 4.0);
}

#[test]
fn sparse_faults() {
    let at = "a.glb, mesh 0 primitive 0 POSITION: accessor 0: sparse";
    let change = |pointer: &str, value: Value, message: &str| {
        let mut document = Document::square();
        let moved = bytes!(f32: 3.0, 3.0, 0.0);
        document.json["accessors"][0]["sparse"] = document.sparse(1, &[2], 5121, &moved);
        *document.json.pointer_mut(pointer).unwrap() = value;
        document.refused(&format!("{at}{message}"));
    };
    change(
        "/accessors/0/sparse/count",
        json!(1u64 << 40),
        " indices: its 1099511627776 elements reach beyond the buffer view",
    );
    change("/accessors/0/sparse/count", json!(null), ": it has no \"count\"");
    change("/accessors/0/sparse/indices", json!(null), ": it has no \"indices\"");
    change("/accessors/0/sparse/indices/componentType", json!(F32), " indices: they must be unsigned integers");
    change("/accessors/0/sparse/values/bufferView", json!(8), " values: there is no such buffer view");
    change("/bufferViews/3/byteLength", json!(11), " values: its 1 elements reach beyond the buffer view");
    change("/accessors/0/count", json!(2), " indices: number 0: 2 is out of range; there are 2");
}

#[test]
fn accessors_without_a_view_are_zeros() {
    let loaded = fault("gltf/normals_without_view.gltf");
    check(&loaded, 2, 4.0);
    assert!(loaded.value.normals().iter().all(|n| *n == v(0.0, 0.0, 1.0)));
    // Positions that are all zero have no area, and indices that are all zero name one corner.
    let mut document = Document::square();
    document.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    document.refused("a.glb: all 2 faces have no area");
    document.json["accessors"][0]["count"] = json!(1u64 << 40);
    document.refused(
        "a.glb, mesh 0 primitive 0 POSITION: accessor 0: 1099511627776 elements without a buffer view; at most \
         2^16, or 16 for each sparse one, can be read",
    );
    let mut document = Document::square();
    document.json["accessors"][1].as_object_mut().unwrap().remove("bufferView");
    document.refused("a.glb: all 2 faces have no area");
}

#[test]
fn compressed_data_are_refused_by_name() {
    let mut document = Document::square();
    document.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    document.primitive()["extensions"] = json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {}}});
    document.refused(
        "a.glb, mesh 0 primitive 0 POSITION: accessor 0: its data are those of KHR_draco_mesh_compression, which \
         cannot be read",
    );
    // With plain data beside the compressed ones the file can be read.
    document.json["accessors"][0]["bufferView"] = json!(0);
    check(&document.read().unwrap(), 2, 4.0);
    document.json["buffers"] =
        json!([{"byteLength": 60, "extensions": {"EXT_meshopt_compression": {"fallback": true}}}]);
    let e = read_gltf(document.json.to_string().as_bytes(), "a.gltf").unwrap_err().to_string();
    assert!(
        e.ends_with("buffer 0: it is a placeholder of the extension EXT_meshopt_compression, which cannot be read"),
        "{e}"
    );
}

#[test]
fn quantised_positions_and_strides() {
    // Corners in every type of KHR_mesh_quantization, the elements 8 or 16 bytes apart.
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    for (component, normalised, one) in
        [(5120, true, 127.0), (5121, true, 255.0), (5122, true, 32767.0), (5123, true, 65535.0), (5121, false, 1.0)]
    {
        for stride in [8, 16] {
            let mut document = Document::square();
            let mut bytes = Vec::new();
            for c in corners {
                let start = bytes.len();
                for x in [c[0] * one, c[1] * one, 0.0] {
                    let x = x as u32;
                    if component < 5122 { bytes.push(x as u8) } else { bytes.extend((x as u16).to_le_bytes()) }
                }
                bytes.resize(start + stride, 0xaa);
            }
            let view = document.view(&bytes);
            document.json["bufferViews"][view]["byteStride"] = json!(stride);
            document.json["accessors"][0] = json!({"bufferView": view, "componentType": component, "count": 4,
                "type": "VEC3", "normalized": normalised});
            document.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
            check(&document.read().unwrap(), 2, 1.0);
        }
    }
    // The lowest integers stand for −1 exactly; a stride of 0 means none.
    let mut document = Document::square();
    let view = document.view(&bytes!(i16: -32768, 0, 0, 32767, 0, 0, 0, 32767, 0, 0, 0, 0));
    document.json["bufferViews"][view]["byteStride"] = json!(0);
    document.json["accessors"][0] =
        json!({"bufferView": view, "componentType": 5122, "count": 4, "type": "VEC3", "normalized": true});
    assert_eq!(document.read().unwrap().value.positions()[0], v(-1.0, 0.0, 0.0));
}

// ----------------------------------------------------------------------------------------------------- flat normals

/// Every corner has the normal of its face.
#[track_caller]
fn is_flat(mesh: &Mesh) {
    for face in mesh.faces() {
        let [a, b, c] = face.map(|i| mesh.positions()[i as usize].cast::<f64>());
        let expected = (b - a).cross(&(c - a)).normalize();
        for &i in face {
            let error = (mesh.normals()[i as usize].cast::<f64>() - expected).amax();
            // Rounded to f32, like the positions that it is compared with.
            assert!(error < 1e-6, "vertex {i}: {error}");
        }
    }
}

#[test]
fn primitives_without_normals_are_flat() {
    let cube = fault("gltf/cube_no_normals.gltf");
    check(&cube, 12, 24.0);
    is_flat(&cube.value);
    // Every face has vertices of its own.
    assert_eq!(cube.value.positions().len(), 36);
    assert_eq!(messages(&cube), [""; 0]);
    let centre = |f: &[u32; 3]| f.iter().map(|&i| cube.value.positions()[i as usize]).sum::<Vector3<f32>>();
    assert!(cube.value.faces().iter().all(|f| cube.value.normals()[f[0] as usize].dot(&centre(f)) > 0.0));

    let roof = fault("gltf/roof_no_normals.gltf");
    is_flat(&roof.value);
    let half = 0.5f32.sqrt();
    for n in roof.value.normals() {
        assert!((n.x, n.y) == (0.0, half) && n.z.abs() == half, "{n}");
    }
    assert_eq!((roof.value.positions().len(), roof.value.faces().len()), (12, 4));
}

/// Four corners that are not in a plane, as a list, a strip and a fan.
fn tetrahedron(mode: u8, corners: &[u8]) -> Document {
    let mut document = Document::square();
    let positions = bytes!(f32: 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    let positions = document.accessor(&positions, F32, 4, "VEC3");
    let indices = document.accessor(corners, 5121, corners.len(), "SCALAR");
    *document.primitive() = json!({"attributes": {"POSITION": positions}, "indices": indices, "mode": mode});
    document
}

#[test]
fn strips_and_fans_without_normals_are_flat() {
    // Two triangles with an edge in common.
    for (mode, corners, z) in [(4, &[0u8, 2, 1, 0, 1, 3][..], -1.0), (5, &[0, 1, 2, 3], 1.0), (6, &[0, 1, 2, 3], 1.0)] {
        let loaded = tetrahedron(mode, corners).read().unwrap();
        is_flat(&loaded.value);
        assert_eq!((loaded.value.faces().len(), loaded.value.positions().len()), (2, 6), "mode {mode}");
        assert_eq!(loaded.value.normals()[loaded.value.faces()[0][0] as usize], v(0.0, 0.0, z));
        assert_eq!(messages(&loaded), [""; 0]);
    }
    // Every other triangle of a strip is turned, so that all of a plane look to one side.
    let mut document = Document::square();
    let indices = document.accessor(&[0, 1, 3, 2], 5121, 4, "SCALAR");
    *document.primitive() = json!({"attributes": {"POSITION": 0}, "indices": indices, "mode": 5});
    let loaded = document.read().unwrap();
    check(&loaded, 2, 4.0);
    assert_eq!(loaded.value.normals(), [v(0.0, 0.0, 1.0); 6]);
    // A strip that repeats corners to turn a corner: the triangles in between have no area.
    let loaded = tetrahedron(5, &[0, 1, 2, 2, 3, 3, 3, 1, 0]).read().unwrap();
    is_flat(&loaded.value);
    check(&loaded, 2, 0.5 + 0.5);
    assert_eq!(messages(&loaded), ["triangle 1: 5 triangles without area left out"]);
    // Without indices, and a vertex that no face uses.
    let mut document = Document::square();
    document.primitive().as_object_mut().unwrap().remove("indices");
    let loaded = document.read().unwrap();
    is_flat(&loaded.value);
    assert_eq!(
        messages(&loaded),
        ["mesh 0 primitive 0: 1 list of triangles has left over corners", "vertex 3: 1 vertex without a face left out"]
    );
}

#[test]
fn flat_normals_follow_transforms() {
    let mut document = tetrahedron(4, &[0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]);
    document.json["nodes"][0]["scale"] = json!([-1, 2, 3]);
    let mirrored = document.read().unwrap();
    is_flat(&mirrored.value);
    assert_eq!((mirrored.value.faces().len(), mirrored.value.positions().len()), (4, 12));
    assert!(
        mirrored.value.normals().contains(&v(0.0, 0.0, -1.0)) && mirrored.value.normals().contains(&v(1.0, 0.0, 0.0))
    );
    // A primitive with normals beside one without: each has its own.
    let normals =
        document.accessor(&bytes!(f32: 0.0, 0.6, 0.8, 0.0, 0.6, 0.8, 0.0, 0.6, 0.8, 0.0, 0.6, 0.8), F32, 4, "VEC3");
    let primitives = document.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    for at in [0, 2] {
        primitives.insert(at, json!({"attributes": {"POSITION": 0, "NORMAL": normals}, "indices": 1}));
    }
    document.json["nodes"][0] = json!({"mesh": 0});
    let loaded = document.read().unwrap();
    assert_eq!(messages(&loaded), [""; 0]);
    assert_eq!(loaded.value.positions().len(), 4 + 12 + 4);
    assert_eq!(loaded.value.normals()[..4], [v(0.0, 0.6, 0.8); 4]);
    assert_eq!(loaded.value.normals()[8..12], [v(0.0, 0.6, 0.8); 4]);
    assert_eq!(loaded.value.faces()[6..], [[8, 9, 10], [8, 10, 11]]);
}

// ---------------------------------------------------------------------------------------------------- far from zero

#[test]
fn meshes_far_from_zero_keep_their_shape() {
    let place = Vector3::new(455_000.123, 312.25, -5_411_000.456);
    let moved = [
        json!({"mesh": 0, "translation": [place.x, place.y, place.z]}),
        json!({"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, place.x, place.y, place.z, 1]}),
    ];
    for node in moved {
        let mut document = tetrahedron(4, &[0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]);
        document.json["nodes"][0] = node;
        let loaded = document.read().unwrap();
        check(&loaded, 4, 1.5 + 0.75f64.sqrt());
        is_flat(&loaded.value);
        assert_eq!(loaded.warnings.len(), 1, "{:?}", messages(&loaded));
        let mesh = &loaded.value;
        let corner = mesh.origin() + mesh.positions()[1].cast::<f64>();
        // Positions relative to the origin are of order 1: a few roundings of f32.
        assert!((corner - place - Vector3::x()).amax() < 1e-6, "{corner}");
    }
}

// -------------------------------------------------------------------------------------------------------- instances

fn instanced(attributes: &[(&str, &[u8], u32, bool)], count: usize) -> Document {
    let mut document = Document::square();
    let mut named = json!({});
    for (name, bytes, component, normalised) in attributes {
        let shape = if *name == "ROTATION" { "VEC4" } else { "VEC3" };
        let accessor = document.accessor(bytes, *component, count, shape);
        document.json["accessors"][accessor]["normalized"] = json!(normalised);
        named[*name] = json!(accessor);
    }
    document.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": named}});
    document.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    document
}

#[test]
fn every_instance_is_read() {
    let loaded = fault("gltf/gpu_instancing.gltf");
    check(&loaded, 6, 12.0);
    assert_eq!(messages(&loaded), [""; 0]);
    assert_eq!(loaded.value.positions()[8], v(10.0, 0.0, 0.0));

    // All three attributes, below a node that moves and mirrors.
    let half = 0.5f32.sqrt();
    let mut document = instanced(
        &[
            ("TRANSLATION", &bytes!(f32: 0.0, 0.0, 0.0, 0.0, 7.0, 0.0), F32, false),
            ("ROTATION", &bytes!(f32: 0.0, 0.0, 0.0, 1.0, 0.0, half, 0.0, half), F32, false),
            ("SCALE", &bytes!(f32: 1.0, 1.0, 1.0, 3.0, 0.5, 1.0), F32, false),
        ],
        2,
    );
    document.json["nodes"][0]["translation"] = json!([100, 0, 0]);
    document.json["nodes"][0]["scale"] = json!([-1, 1, 1]);
    document.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let loaded = document.read().unwrap();
    check(&loaded, 4, 4.0 + 6.0);
    // The second instance: (2, 2, 0) is scaled to (6, 1, 0), turned by 90° about y to (0, 1, −6), moved to (0, 8, −6).
    assert!((loaded.value.positions()[6] - v(100.0, 8.0, -6.0)).amax() < 1e-5, "{}", loaded.value.positions()[6]);
    // Turned round, since the node mirrors.
    assert_eq!(loaded.value.faces()[0], [0, 2, 1]);
    is_flat(&loaded.value);
}

#[test]
fn rotations_of_instances_may_be_integers() {
    // A turn by 90° about x: (√½, 0, 0, √½) as fractions of 127 and 32767.
    for (rotation, component) in [(vec![90u8, 0, 0, 90], 5120), (bytes!(i16: 23170, 0, 0, 23170), 5122)] {
        let loaded = instanced(&[("ROTATION", &rotation, component, true)], 1).read().unwrap();
        assert_eq!(messages(&loaded), [""; 0]);
        assert!((loaded.value.positions()[2] - v(2.0, 0.0, 2.0)).amax() < 1e-6);
    }
    let loaded = instanced(&[("SCALE", &bytes!(f32: 1.0, 1.0, 1.0, 2.0, 2.0, 1.0), F32, false)], 2).read().unwrap();
    check(&loaded, 4, 4.0 + 16.0);
}

#[test]
fn instances_that_cannot_be_read_are_one() {
    let three = bytes!(f32: 0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 9.0, 0.0, f32::NAN);
    let good = || instanced(&[("TRANSLATION", &three[..24], F32, false)], 2);
    check(&good().read().unwrap(), 4, 8.0);
    let one = |document: &Document, reason: &str| {
        let loaded = document.read().unwrap();
        check(&loaded, 2, 4.0);
        assert_eq!(
            messages(&loaded),
            [format!("node 0 EXT_mesh_gpu_instancing: {reason}; the mesh stands there once")]
        );
    };
    let change = |pointer: &str, value: Value, reason: &str| {
        let mut document = good();
        *document.json.pointer_mut(pointer).unwrap() = value;
        one(&document, reason);
    };
    let extension = "/nodes/0/extensions/EXT_mesh_gpu_instancing";
    change(extension, json!(5), "it has no object \"attributes\"");
    change(&format!("{extension}/attributes"), json!({"_ID": 2}), "it has none of TRANSLATION, ROTATION, SCALE");
    change(&format!("{extension}/attributes/TRANSLATION"), json!("x"), "TRANSLATION: is not an index of an accessor");
    change(
        &format!("{extension}/attributes/TRANSLATION"),
        json!(9),
        "TRANSLATION: accessor 9: there is no such accessor",
    );
    change("/accessors/2/count", json!(0), "it has no instances");
    change(
        "/accessors/2/count",
        json!(1u64 << 50),
        "TRANSLATION: accessor 2: its 1125899906842624 elements reach beyond the buffer view",
    );
    one(&instanced(&[("TRANSLATION", &three, F32, false)], 3), "instance 2: its transform is NaN or infinite");
    one(&instanced(&[("ROTATION", &[0; 16], F32, false)], 1), "instance 0: its transform is NaN or infinite");
    one(
        &instanced(&[("TRANSLATION", &[0; 6], 5122, true)], 1),
        "TRANSLATION: accessor 2: its component type is not allowed here",
    );
    let mut document = instanced(&[("TRANSLATION", &three[..24], F32, false), ("SCALE", &three[..24], F32, false)], 2);
    document.json["accessors"][3]["count"] = json!(1);
    one(&document, "its attributes have different lengths: [2, 1]");
}

#[test]
fn instances_are_bounded() {
    // 2¹⁴ instances of a strip of 2¹² + 1 triangles: refused before memory is taken for them.
    let n = 1 << 14;
    let mut document = instanced(&[("TRANSLATION", &vec![0; 12 * n], F32, false)], n);
    let corners: Vec<u8> = (0..4099).map(|i| (i % 4) as u8).collect();
    let indices = document.accessor(&corners, 5121, corners.len(), "SCALAR");
    *document.primitive() = json!({"attributes": {"POSITION": 0}, "indices": indices, "mode": 5});
    document.refused(
        "a.glb, mesh 0 primitive 0: 16384 instances of 4097 triangles: more than 2^26 vertices or triangles so far",
    );
    // Instances without a byte of their own stand for nothing.
    let mut document = Document::square();
    let instances = document.push(json!({"componentType": F32, "count": 1 << 20, "type": "VEC3"}));
    document.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": instances}}});
    let loaded = document.read().unwrap();
    check(&loaded, 2, 4.0);
    assert_eq!(
        messages(&loaded),
        ["node 0 EXT_mesh_gpu_instancing: none of its attributes has a buffer view; the mesh stands there once"]
    );
}

// ----------------------------------------------------------------------------------------------------------- damage

/// Documents that use every path: each is damaged in its JSON, its bytes and its chunks.
fn documents() -> Vec<Document> {
    let mut sparse = Document::square();
    sparse.json["accessors"][0]["sparse"] = sparse.sparse(1, &[2], 5121, &bytes!(f32: 3.0, 3.0, 0.0));
    let all = sparse.sparse(1, &bytes!(u16: 1), 5123, &bytes!(f32: 0.0, 3.0, 4.0));
    let normals = sparse.push(json!({"componentType": F32, "count": 4, "type": "VEC3", "sparse": all}));
    sparse.primitive()["attributes"]["NORMAL"] = json!(normals);
    let mut instances = instanced(
        &[
            ("TRANSLATION", &bytes!(f32: 0.0, 0.0, 0.0, 0.0, 7.0, 0.0), F32, false),
            ("ROTATION", &bytes!(i16: 0, 0, 0, 32767, 0, 32767, 0, 0), 5122, true),
        ],
        2,
    );
    instances.json["animations"] = json!([{"channels": [{"sampler": 0, "target": {"node": 0, "path": "scale"}}]}]);
    instances.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}]);
    let mut absent = Document::square();
    let normals = absent.push(json!({"componentType": F32, "count": 4, "type": "VEC3"}));
    absent.primitive()["attributes"]["NORMAL"] = json!(normals);
    vec![sparse, instances, absent]
}

#[test]
fn documents_cut_short_at_every_byte() {
    for bytes in documents().iter().map(Document::glb) {
        for n in 0..bytes.len() {
            if let Err(e) = read_gltf(&bytes[..n], "a.glb") {
                assert!(e.to_string().starts_with("a.glb"), "{e}");
            }
        }
    }
}

/// The places of all numbers in a value.
fn numbers(value: &Value, place: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(place.to_owned()),
        Value::Array(list) => list.iter().enumerate().for_each(|(i, v)| numbers(v, &format!("{place}/{i}"), found)),
        Value::Object(map) => map.iter().for_each(|(name, v)| numbers(v, &format!("{place}/{name}"), found)),
        _ => {}
    }
}

#[test]
fn memory_follows_the_bytes_whatever_the_numbers_say() {
    for document in documents() {
        let (bytes, text) = (document.glb(), document.json());
        let mut places = Vec::new();
        numbers(&serde_json::from_str(&text).unwrap(), "", &mut places);
        assert!(places.len() > 20);
        for (place, n) in places.iter().flat_map(|p| [16, 20, 26, 31, 32, 62, 63].map(|n| (p, n))) {
            let mut json: Value = serde_json::from_str(&text).unwrap();
            *json.pointer_mut(place).unwrap() = json!(1u64 << n);
            let bytes = glb(&[(b"JSON", json.to_string().as_bytes()), (b"BIN\0", &document.buffer)]);
            let used = allocation_counter::measure(|| drop(read_gltf(&bytes, "a.glb"))).bytes_max;
            // 2¹⁶ vertices without bytes of their own take some 100 bytes each.
            assert!(used < 1 << 24, "{place} = 2^{n}: {used} bytes");
        }
        let used = allocation_counter::measure(|| drop(read_gltf(&bytes, "a.glb"))).bytes_max;
        assert!(used < 100 * bytes.len() as u64, "{used} for {}", bytes.len());
    }
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn damaged_documents(damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..4u8), 1..6)) {
        for mut bytes in documents().iter().map(Document::glb) {
            for (index, value, kind) in &damage {
                let at = index.index(bytes.len());
                match kind {
                    0 => bytes[at] = *value,
                    1 => bytes[at] ^= 1 << (value % 8),
                    // Digits for digits, so that the JSON stays JSON and the numbers change.
                    2 => {
                        if let Some(digit) = bytes.iter_mut().skip(at).find(|b| b.is_ascii_digit()) {
                            *digit = b'0' + value % 10;
                        }
                    }
                    _ => bytes.insert(at, *value),
                }
            }
            if let Err(e) = read_gltf(&bytes, "a.glb") {
                prop_assert!(e.to_string().starts_with("a.glb"), "{}", e);
            }
        }
    }
}
