//! Texture coordinates of OBJ and PLY files, and of any mesh; those of glTF are in `gltf`.

use haarmonic::io::{Loaded, encode_ply, read_obj, read_ply};
use haarmonic::nalgebra::{Vector2, Vector3};
use haarmonic::scene::{Mesh, Procedural};
use haarmonic::strategies::textured_soup;
use proptest::prelude::*;

use crate::meshes::{messages, v};
use crate::support::cases;

const SQUARE: &str = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\n";

fn obj(text: &str) -> Loaded<Mesh> {
    read_obj(text.as_bytes(), "a.obj").unwrap_or_else(|e| panic!("{text}: {e}"))
}

fn uv(mesh: &Mesh) -> Vec<[f32; 2]> {
    mesh.uv().expect("texture coordinates").iter().map(|c| (*c).into()).collect()
}

#[test]
fn obj_indices_before_and_after_negative_and_with_three_numbers() {
    let pairs = "vt 0 0\nvt 0.5 0 9\nvt 0.5 1 0.25\nvt 0 1\n";
    let expected = [[0.0, 0.0], [0.5, 0.0], [0.5, 1.0], [0.0, 1.0]];
    for text in [
        format!("{SQUARE}{pairs}f 1/1 2/2 3/3 4/4\n"),
        format!("{SQUARE}{pairs}f 1/-4 2/-3 3/-2 -1/-1\n"),
        format!("{SQUARE}f 1/1 2/2 3/3 4/4\n{pairs}"),
        format!("{SQUARE}{pairs}vn 0 0 1\nf 1/1/1 2/2/1 3/3/1 4/4/1\n"),
        format!("{SQUARE}{}f 1/1/ 2/2/ 3/3/ 4/4\n", pairs.replace("vt 0 1", "vt \\\n 0 1")),
    ] {
        let loaded = obj(&text);
        assert_eq!(messages(&loaded), [""; 0], "{text}");
        assert_eq!(loaded.value.faces(), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(uv(&loaded.value), expected, "{text}");
    }
    // One number is u.
    let loaded = obj(&format!("{SQUARE}vt 0.75\nf 1/1 2/1 3/1\n"));
    assert_eq!(
        (uv(&loaded.value), messages(&loaded)),
        (vec![[0.75, 0.0]; 3], vec!["vertex 3: 1 vertex without a face left out".into()])
    );
}

#[test]
fn obj_seams_split_vertices_but_not_normals() {
    // A roof: two squares that share an edge, along which the texture is cut.
    let roof = "v 0 0 0\nv 0 0 1\nv 1 1 0\nv 1 1 1\nv 2 0 0\nv 2 0 1\n";
    let faces = ["f 1 2 4 3\nf 3 4 6 5\n", "f 1/1 2/2 4/3 3/4\nf 3/5 4/6 6/7 5/8\n"];
    let pairs = "vt 0 0\nvt 0 1\nvt 1 1\nvt 1 0\nvt 2 0\nvt 2 1\nvt 3 1\nvt 3 0\n";
    for smoothing in ["", "s 1\n", "s off\n"] {
        let [plain, textured] = faces.map(|f| obj(&format!("{roof}{pairs}{smoothing}{f}")));
        assert_eq!(plain.value.uv(), None);
        assert_eq!(messages(&textured), messages(&plain));
        let (plain, textured) = (plain.value, textured.value);
        // Flat faces share no vertex in any case.
        let more = if smoothing == "s off\n" { 0 } else { 2 };
        assert_eq!(textured.positions().len(), plain.positions().len() + more);
        assert_eq!(textured.positions()[..plain.positions().len()], *plain.positions());
        assert_eq!(textured.normals()[..plain.positions().len()], *plain.normals());
        for (a, b) in textured.faces().iter().flatten().zip(plain.faces().iter().flatten()) {
            let (a, b) = (*a as usize, *b as usize);
            assert_eq!((textured.positions()[a], textured.normals()[a]), (plain.positions()[b], plain.normals()[b]));
            // u is x but for the gap of 1.
            assert_eq!(textured.uv().unwrap()[a].y, textured.positions()[a].z);
        }
        let us: Vec<f32> =
            textured.faces().iter().map(|f| f.iter().map(|&i| textured.uv().unwrap()[i as usize].x).sum()).collect();
        assert_eq!(us, [1.0, 2.0, 7.0, 8.0]);
    }
}

#[test]
fn obj_keys_are_position_normal_and_coordinates() {
    let text = "vn 0 0 1\nvn 0 1 1\nvt 0 0\nvt 1 0\nvt -0 0\n\
                f 1/1/1 2/1/1 3/1/1\nf 1/1/1 3/2/1 4/1/1\nf 1/1/2 2/1/1 4/3/1\n";
    let loaded = obj(&format!("{SQUARE}{text}"));
    // Vertex 4 is that of the second normal, 5 that of the second pair; −0 is 0.
    assert_eq!(loaded.value.faces(), [[0, 1, 2], [0, 5, 3], [4, 1, 3]]);
    assert_eq!(uv(&loaded.value)[5], [1.0, 0.0]);
    assert_eq!(loaded.value.normals()[5], v(0.0, 0.0, 1.0));
}

#[test]
fn obj_faults_are_warnings() {
    let pairs = "vt 0.5 1\nvt nan 0\nvt x 0\nvt\nvt 1 1e300\nvt 0 -inf\n";
    let loaded = obj(&format!("{SQUARE}{pairs}f 1/2 2/3 3/4\nf 1/1 3/5 4/6\n"));
    assert_eq!(uv(&loaded.value), [[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.5, 1.0]]);
    assert_eq!(messages(&loaded), ["line 6: 5 texture coordinates are malformed, NaN or infinite; set to (0, 0)"]);
    for index in
        ["0", "3", "-2", "x", "1.0", "99999999999999999999", "4294967295", "4294967296", "-9223372036854775808"]
    {
        let loaded = obj(&format!("{SQUARE}vt 0.5 1\nf 1/1 2/{index} 3/1\nf 1/1 3/1 4/1\n"));
        assert_eq!(uv(&loaded.value), [[0.5, 1.0], [0.0, 0.0], [0.5, 1.0], [0.5, 1.0]], "{index}");
        let expected = format!(
            "line 6: texture index {}: 1 corner names texture coordinates that the file does not have (it has 1); \
             set to (0, 0)",
            index
        );
        assert_eq!(messages(&loaded), [expected]);
    }
    // No face names any that are there: no texture.
    let loaded = obj(&format!("{SQUARE}f 1/1 2/2 3/3 4/4\n"));
    let expected = "line 5: texture index 1: 4 corners name texture coordinates that the file does not have \
                    (it has 0); \
                    left out";
    assert_eq!((loaded.value.uv(), messages(&loaded)), (None, vec![expected.into()]));
    let loaded = obj(&format!("{SQUARE}vt 0 1\nf 1 2 3 4\n"));
    assert_eq!((loaded.value.uv(), loaded.warnings), (None, vec![]));
}

#[test]
fn obj_corners_without_are_zero() {
    let text = "vt 1 1\nf 1 2 3\nf 1/1 3 4/1\n";
    let loaded = obj(&format!("{SQUARE}{text}"));
    assert_eq!(loaded.value.faces(), [[0, 1, 2], [4, 2, 3]]);
    assert_eq!(uv(&loaded.value), [[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [1.0, 1.0], [1.0, 1.0]]);
    let expected = "triangle 0: 4 corners of triangles have no texture coordinates, others have; set to (0, 0)";
    assert_eq!(messages(&loaded), [expected]);
}

/// Whether coordinates go where their corners go, whatever is repaired: here u, v are x, y.
#[track_caller]
fn follow(points: &[[i32; 3]], faces: &str) {
    let vertices: String = points.iter().map(|[x, y, z]| format!("v {x} {y} {z}\nvt {x} {y}\n")).collect();
    let plain = obj(&format!("{vertices}{faces}"));
    let word = |w: &str| if w == "f" { w.to_owned() } else { format!(" {w}/{w}") };
    let textured: String = faces.lines().map(|line| line.split(' ').map(word).collect::<String>() + "\n").collect();
    let loaded = obj(&format!("{vertices}{textured}"));
    assert_eq!(messages(&loaded), messages(&plain));
    assert_eq!((loaded.value.positions(), loaded.value.faces()), (plain.value.positions(), plain.value.faces()));
    for (position, uv) in loaded.value.positions().iter().zip(loaded.value.uv().unwrap()) {
        assert_eq!(position.xy(), *uv);
    }
}

#[test]
fn coordinates_follow_the_ears_of_polygons() {
    // Vertices and faces that are left out are there too.
    let concave = [[0, 0, 0], [4, 0, 0], [4, 4, 0], [3, 1, 0], [9, 9, 9]];
    follow(&concave, "f 1 2 2\nf 1 2 3 4\nf 1 2 4");
    let cut = obj("v 0 0 0\nv 4 0 0\nv 4 4 0\nv 3 1 0\nf 1 2 3 4\n");
    assert_ne!(cut.value.faces(), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn coordinates_follow_faces_that_are_turned_or_there_twice() {
    // A tetrahedron with a face wound inwards; one all inwards; a square that is there both ways round.
    let corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
    follow(&corners, "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 4 3");
    follow(&corners, "f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3");
    follow(&[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "f 1 2 3 4\nf 4 3 2 1");
}

#[test]
fn ply_pairs_of_vertices() {
    let file = |properties: &str, values: [&str; 3]| {
        let [a, b, c] = values;
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             {properties}element face 1\nproperty list uchar int vertex_indices\nend_header\n\
             0 0 0 {a}\n1 0 0 {b}\n0 1 0 {c}\n3 0 1 2\n"
        );
        read_ply(text.as_bytes(), "a.ply").unwrap()
    };
    let values = ["0.25 0.5", "1 0", "-3 7"];
    let expected = [[0.25, 0.5], [1.0, 0.0], [-3.0, 7.0]];
    for [u, v] in [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]] {
        let loaded = file(&format!("property float {u}\nproperty double {v}\n"), values);
        assert_eq!((uv(&loaded.value), messages(&loaded)), (expected.into(), vec![]));
        let loaded = file(&format!("property float {v}\nproperty float {u}\n"), values);
        assert_eq!(uv(&loaded.value), expected.map(|[u, v]| [v, u]));
    }
    let half = file("property float u\nproperty float t\n", values);
    assert_eq!(half.value.uv(), None);
    assert_eq!(
        messages(&half),
        [
            "line 3: element \"vertex\" has 0 properties \"s\" and 1 \"t\", not one each; left out",
            "line 3: element \"vertex\" has 1 properties \"u\" and 0 \"v\", not one each; left out",
        ]
    );
    let bad = file("property float s\nproperty float t\n", ["nan 0.5", "1 0", "-3 inf"]);
    assert_eq!(uv(&bad.value), [[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]]);
    let expected = "line 12 (vertex 0): 2 texture coordinates are malformed, NaN or infinite; set to (0, 0)";
    assert_eq!(messages(&bad), [expected]);
}

#[test]
fn ply_lists_of_faces() {
    let file = |pairs: [&str; 2]| {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
             property float s\nproperty float t\n\
             element face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n\
             0 0 0 8 8\n1 0 0 8 8\n1 1 0 8 8\n0 1 0 8 8\n3 0 1 2 {}\n3 0 2 3 {}\n",
            pairs[0], pairs[1]
        );
        read_ply(text.as_bytes(), "a.ply").unwrap()
    };
    let loaded = file(["6 0 0 1 0 1 1", "6 0 0 0.5 1 0 1"]);
    assert_eq!(messages(&loaded), [""; 0]);
    assert_eq!(loaded.value.faces(), [[0, 1, 2], [0, 4, 3]]);
    assert_eq!(uv(&loaded.value), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 1.0]]);
    for short in ["0", "4 0 0 1 0", "5 0 0 1 0 1"] {
        let loaded = file([short, "6 2 2 2 2 2 2"]);
        assert_eq!(uv(&loaded.value)[1], [0.0, 0.0]);
        let expected = "triangle 0: 3 corners of triangles have no texture coordinates, others have; set to (0, 0)";
        assert_eq!(messages(&loaded), [expected]);
    }
}

#[test]
fn written_coordinates_come_back() {
    for scene in Procedural::ALL {
        let mesh = scene.build(1_000).unwrap().mesh;
        let n = mesh.positions().len();
        let colours = vec![Vector3::new(0.5, 1.0, 2.0); n];
        for colours in [None, Some(&colours[..])] {
            for origin in [Vector3::zeros(), Vector3::new(4096.0, 0.0, -8.0)] {
                let moved = mesh.clone().with_origin(origin).unwrap();
                let bytes = encode_ply(&moved, colours).unwrap();
                let loaded = read_ply(&bytes, "a.ply").unwrap();
                assert_eq!(loaded.value.uv(), mesh.uv());
                assert_eq!(loaded.value.faces(), mesh.faces());
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(32))]

    #[test]
    fn frames_stay_frames(mesh in textured_soup(20)) {
        let mesh = mesh.with_tangents_from_uv().unwrap();
        let hands = mesh.uv_handedness().unwrap();
        for (vertex, hand) in hands.into_iter().enumerate() {
            let frame = mesh.local_frame(vertex);
            prop_assert!((frame.tangent.norm() - 1.0).abs() < 1e-6);
            prop_assert!(frame.tangent.dot(&frame.normal).abs() < 1e-6);
            prop_assert!(hand.abs() == 1.0);
        }
    }

    #[test]
    fn corners_come_back(mesh in textured_soup(20), pairs in prop::collection::vec(0..4_u8, 60)) {
        let pair = |k: usize| Vector2::new(f32::from(pairs[k % 60] % 2), f32::from(pairs[k % 60] / 2));
        let corners: Vec<_> = (0..mesh.faces().len()).map(|f| [0, 1, 2].map(|k| pair(3 * f + k))).collect();
        let split = mesh.clone().with_corner_uv(&corners).unwrap();
        let uv = split.uv().unwrap();
        for ((new, old), corners) in split.faces().iter().zip(mesh.faces()).zip(&corners) {
            prop_assert_eq!(new.map(|i| uv[i as usize]), *corners);
            let places = |mesh: &Mesh, face: &[u32; 3]| face.map(|i| mesh.positions()[i as usize]);
            prop_assert_eq!(places(&split, new), places(&mesh, old));
        }
        // No more vertices than pairs of vertex and coordinates.
        let mut used: Vec<_> = split.faces().iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let mut keys: Vec<_> = (mesh.faces().iter().flatten().zip(corners.iter().flatten()))
            .map(|(i, c)| (*i, c.x as u8, c.y as u8))
            .collect();
        keys.sort_unstable();
        keys.dedup();
        prop_assert_eq!(used.len(), keys.len());
    }

    #[test]
    fn ply_round_trip(mesh in textured_soup(12)) {
        let plain = Mesh::new(mesh.positions().to_vec(), mesh.faces().to_vec()).unwrap();
        let read = |mesh: &Mesh| read_ply(&encode_ply(mesh, None).unwrap(), "a.ply");
        if let Ok(loaded) = read(&mesh) {
            let without = read(&plain).unwrap();
            prop_assert_eq!(loaded.value.positions(), without.value.positions());
            prop_assert_eq!(loaded.value.faces(), without.value.faces());
            prop_assert_eq!(loaded.value.normals(), without.value.normals());
            prop_assert_eq!(&loaded.warnings, &without.warnings);
            // Vertices that are left out take their coordinates with them.
            let known = |p: &Vector3<f32>, uv: &Vector2<f32>| {
                mesh.positions().iter().zip(mesh.uv().unwrap()).any(|(q, c)| q == p && c == uv)
            };
            let pairs = loaded.value.positions().iter().zip(loaded.value.uv().unwrap());
            prop_assert!(pairs.into_iter().all(|(p, uv)| known(p, uv)));
        } else {
            prop_assert!(read(&plain).is_err());
        }
    }
}
