//! Meshes that other programs write and readers stumble over; the files are in tests/faults.

use haarmonic::io::{Loaded, MeshOptions, Up, Winding, load_mesh, read_obj, read_obj_with};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::Mesh;

type V = Vector3<f32>;

fn load(name: &str) -> Loaded<Mesh> {
    load_mesh(format!("{}/tests/faults/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

#[track_caller]
fn read(text: &str) -> Loaded<Mesh> {
    read_obj(text.as_bytes(), "a.obj").unwrap()
}

fn refused(text: &str) -> String {
    read_obj(text.as_bytes(), "a.obj").unwrap_err().to_string()
}

fn messages(loaded: &Loaded<Mesh>) -> Vec<String> {
    loaded.warnings.iter().map(|w| format!("{}: {}", w.place, w.message)).collect()
}

fn area(mesh: &Mesh) -> f64 {
    mesh.face_areas().iter().sum()
}

/// The area, in f64 from the positions, of the faces seen from +z, those below counted negative.
fn area_from_above(mesh: &Mesh) -> f64 {
    let double = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|i| mesh.positions()[i as usize].cast::<f64>());
        (b - a).cross(&(c - a)).z
    };
    mesh.faces().iter().map(double).sum::<f64>() / 2.0
}

/// The largest angle, as a sine, between a corner's normal and that of its face.
fn crease(mesh: &Mesh) -> f32 {
    let corner = |f: &[u32; 3], i: u32| {
        let [a, b, c] = f.map(|i| mesh.positions()[i as usize]);
        (b - a).cross(&(c - a)).normalize().cross(&mesh.normals()[i as usize]).norm()
    };
    mesh.faces().iter().flat_map(|f| f.map(|i| corner(f, i))).fold(0.0, f32::max)
}

fn volume(mesh: &Mesh) -> f64 {
    let six = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|i| mesh.positions()[i as usize].cast::<f64>());
        a.dot(&b.cross(&c))
    };
    mesh.faces().iter().map(six).sum::<f64>() / 6.0
}

const PLATE: &str = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\n";

/// A plate of two triangles, lit from +z, without a word.
#[track_caller]
fn is_plate(loaded: &Loaded<Mesh>, what: &str) {
    let mesh = &loaded.value;
    assert_eq!(mesh.faces().len(), 2, "{what}");
    assert_eq!(area(mesh), 4.0, "{what}");
    assert!(mesh.normals().iter().all(|n| *n == V::z()), "{what}");
}

// ----------------------------------------------------------------------------------------------------- backslashes

#[test]
fn no_line_vanishes_behind_a_backslash() {
    for name in ["ends_comment", "ends_indented_comment", "ends_name", "blank"] {
        let loaded = load(&format!("backslash_{name}.obj"));
        is_plate(&loaded, name);
        assert_eq!(messages(&loaded), [""; 0], "{name}");
    }
    for ending in ["\n", "\r\n", "\r"] {
        for body in [
            // At the end of comments and names of every kind.
            "# C:\\\nf 1 2 3 4\n",
            " \t# C:\\ \nf 1 2 3 4\n",
            "f 1 2 3 4 # C:\\",
            "o a\\\nf 1 2 3 4",
            "g C:\\tex\\ \nf 1 2 3 4",
            "mtllib C:\\tex\\\nusemtl C:\\\nf 1 2 3 4",
            "s off\\\nf 1 2 3 4",
            "usemtl a\\\n\n# b\\\nf 1 2 3 4",
            "usemtl a\\",
            "g a \\\n b c\nf 1 2 3 4",
            // Numbers continued, with blanks, comments and blank lines between.
            "f 1 2 \\\n3 4",
            "f 1 2 3\\\n 4",
            "f \\\n1 \\\n2 \\ \n3 \\\t\n4 \\\n",
            "f 1 2 \\\n# a comment\n3 4",
            "f 1 2 \\\n# a comment that ends in \\\n3 4",
            "f 1 2 \\ # why \\\n3 4 # because \\\n",
            "f 1 2 \\\n\n\n3 4",
            "f 1 2 \\\n\\\n3 4",
            "\\\nf 1 2 3 4",
            // Joined by an editor, the backslash left behind.
            "f 1 2 \\ 3 4",
            "f 1 2\\ 3 4 \\",
            "f 1 2 3 4 \\",
        ] {
            let body = if body.contains("f ") { body.to_owned() } else { format!("{body}\nf 1 2 3 4") };
            let loaded = read(&format!("{PLATE}{body}").replace('\n', ending));
            is_plate(&loaded, &body);
            assert_eq!(messages(&loaded), [""; 0], "{body}");
        }
    }
    // Before another statement it was no continuation.
    let loaded = read(&format!("{PLATE}f 1 2 3 \\\nf 1 3 4 \\\n"));
    is_plate(&loaded, "statement");
    assert_eq!(
        messages(&loaded),
        ["line 5: 1 line ends in a backslash and before another statement; not joined with it"]
    );
    // The error names the line where the statement begins.
    assert_eq!(refused(&format!("{PLATE}f 1 2 3 4\nv 1 \\\n\n2 x")), "a.obj, line 6: \"x\" is not a number");
}

// --------------------------------------------------------------------------------------------------------- normals

#[test]
fn normals_that_are_not_there_come_from_the_faces() {
    for (name, message) in [
        (
            "normals_not_there.obj",
            "line 5: normal index 1: 6 corners name normals that the file does not have (it has 0); computed from the faces",
        ),
        (
            "normal_past_end.obj",
            "line 7: normal index 7: 1 corner names a normal that the file does not have (it has 1); computed from the faces",
        ),
        (
            "normal_zero.obj",
            "line 8: normal index 0: 3 corners name normals that the file does not have (it has 1); computed from the faces",
        ),
    ] {
        let loaded = load(name);
        is_plate(&loaded, name);
        assert_eq!(messages(&loaded)[0], message);
    }
    for index in ["-2", "2", "0", "99999999999", "-99999999999", "4294967295", "4294967296", "-9223372036854775808"] {
        let loaded = read(&format!("{PLATE}vn 0 0 1\nf 1//1 2//1 3//{index} 4//1\n"));
        is_plate(&loaded, index);
        assert!(messages(&loaded)[0].starts_with("line 6: normal index"), "{index}");
    }
    // Normals after the faces are there all the same.
    let loaded = read(&format!("{PLATE}f 1//1 2//1 3//1 4//1\nvn 0 0 1\n"));
    is_plate(&loaded, "later");
    assert_eq!(messages(&loaded), [""; 0]);
    // Vertices must be there.
    assert!(refused(&format!("{PLATE}f 0//1 2//1 3//1")).contains("line 5: vertex index 0"));
}

#[test]
fn nan_in_any_spelling() {
    for nan in
        ["nan", "-nan(ind)", "1.#QNAN", "-1.#IND", "1.#INF", "nan(snan)", "inf", "-INF", "NaN", "-1.#IND00", "1e999"]
    {
        let loaded = read(&format!("{PLATE}vn {nan} 0 0\nvn 0 0 1\nf 1//1 2//2 3//2 4//2"));
        is_plate(&loaded, nan);
        assert_eq!(messages(&loaded)[0], "line 5: 1 normal is NaN or infinite; computed from the faces");
        let loaded = read(&format!("{PLATE}v {nan} {nan} 0\nf 1 2 3 4"));
        is_plate(&loaded, nan);
        assert_eq!(messages(&loaded), ["vertex 4: 1 vertex without a face left out"]);
        let e = refused(&format!("{PLATE}v 1 {nan} 0\nf 1 2 3 4\nf 1 2 5\n"));
        assert_eq!(e, "a.obj, line 5: the vertex is NaN, infinite or beyond f32");
    }
    is_plate(&load("normal_nan_ind.obj"), "normal");
    let loaded = load("unused_nan_vertex.obj");
    is_plate(&loaded, "vertex");
    assert_eq!(loaded.warnings.len(), 1);
    // A long normal is a direction all the same.
    is_plate(&read(&format!("{PLATE}vn 0 0 1e39\nf 1//1 2//1 3//1 4//1")), "long");
}

#[test]
fn normals_that_are_all_zero() {
    let loaded = read(&format!("{PLATE}vn 0 0 0\nf 1//1 2//1 3//1 4//1"));
    is_plate(&loaded, "zero");
    assert_eq!(messages(&loaded), [": 4 normals are missing or zero; computed from the faces"]);
}

// ------------------------------------------------------------------------------------------------ smoothing groups

#[test]
fn faces_with_smoothing_off_are_flat() {
    let loaded = load("cube_s_off.obj");
    let mesh = &loaded.value;
    assert_eq!((mesh.positions().len(), mesh.faces().len(), area(mesh)), (24, 12, 24.0));
    assert_eq!(crease(mesh), 0.0);
    assert_eq!(messages(&loaded), [""; 0]);
    assert!(volume(mesh) > 0.0);
    // Without a word about smoothing: smooth, as the same file with one group.
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/faults/cube_s_off.obj")).unwrap();
    let (silent, one) = (read(&text.replace("s off\n", "")).value, read(&text.replace("s off", "s 7")).value);
    assert_eq!((silent.positions().len(), silent.faces()), (8, one.faces()));
    assert_eq!(silent.normals(), one.normals());
    for off in ["s 0", "s OFF", "s\toff ", "s 00"] {
        assert_eq!(read(&text.replace("s off", off)).value, *mesh, "{off}");
    }
    // Corners with a normal keep it, whatever their group.
    let given = text.replace("f 5 6 7 8", "vn 1 2 3\nf 5//1 6//1 7//1 8//1");
    let given = read(&given).value;
    let kept = given.normals().iter().filter(|n| (**n - V::new(1.0, 2.0, 3.0).normalize()).norm() < 1e-6).count();
    assert_eq!((given.positions().len(), kept), (24, 4));
    // What is no group is said.
    assert_eq!(messages(&read(&format!("{text}s steel\ns\n"))), ["line 16: \"s steel\": 2 unknown statements skipped"]);
}

#[test]
fn faces_share_normals_within_their_group() {
    let mesh = load("cylinder_groups.obj").value;
    // Twelve vertices each for the side's two rings and the lids.
    assert_eq!(mesh.positions().len(), 48);
    for f in mesh.faces() {
        let heights = f.map(|i| mesh.positions()[i as usize].y);
        for i in f {
            let (p, n) = (mesh.positions()[*i as usize], mesh.normals()[*i as usize]);
            if heights.iter().all(|h| *h == heights[0]) {
                assert!((n - V::y() * (2.0 * p.y - 1.0)).norm() < 1e-6, "{p} {n}");
            } else {
                // Six decimals of the coordinates.
                assert!((n - V::new(p.x, 0.0, p.z)).norm() < 3e-6, "{p} {n}");
            }
        }
    }
    // Groups change from face to face, and come back.
    let roof = "v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 1\nv 1 2 0\nv 0 2 0\n";
    let count = |faces: &str| read(&format!("{roof}{faces}")).value.positions().len();
    assert_eq!(count("s 1\nf 1 2 3 4\nf 4 3 5 6"), 6);
    assert_eq!(count("s 1\nf 1 2 3 4\ns 2\nf 4 3 5 6"), 8);
    assert_eq!(count("s 1\nf 1 2 3\ns 2\nf 4 3 5 6\ns 1\nf 1 3 4"), 8);
    assert_eq!(count("f 1 2 3 4\ns 2\nf 4 3 5 6"), 8);
    assert_eq!(count("s off\nf 1 2 3\nf 1 3 4\nf 4 3 5 6"), 10);
    // The face's own normal, one for a quadrilateral that is not plane: of its Newell vector (−1, −1, 2)/2.
    let bent = read("v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 0\ns off\nf 1 2 3 4\n").value;
    let newell = V::new(-1.0, -1.0, 2.0).normalize();
    assert!(bent.normals().iter().all(|n| (n - newell).norm() < 1e-7), "{:?}", bent.normals());
}

// ----------------------------------------------------------------------------------------------------------- sides

#[test]
fn a_surface_given_both_ways_round_has_two_sides() {
    let loaded = load("plate_two_windings.obj");
    let mesh = &loaded.value;
    assert_eq!((mesh.positions().len(), mesh.faces().len()), (8, 4));
    assert_eq!(crease(mesh), 0.0);
    assert!(loaded.warnings.len() == 1 && messages(&loaded)[0].contains("once each way round"), "{loaded:?}");
    let mesh = load("torus_two_windings.obj");
    assert_eq!(mesh.warnings.len(), 1);
    let mesh = mesh.value;
    // The smooth torus's own deviation, from the file without its second half.
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/faults/torus_two_windings.obj");
    let text = std::fs::read_to_string(path).unwrap();
    let faces: Vec<&str> = text.lines().filter(|l| l.starts_with("f ")).collect();
    let mut seen = std::collections::HashSet::new();
    let sorted = |l: &str| {
        let mut c: Vec<u32> = l[2..].split_whitespace().map(|w| w.parse().unwrap()).collect();
        c.sort_unstable();
        c
    };
    let once: Vec<&str> = faces.iter().copied().filter(|l| seen.insert(sorted(l))).collect();
    assert_eq!(2 * once.len(), faces.len());
    let vertices: Vec<&str> = text.lines().filter(|l| l.starts_with("v ")).collect();
    let single = read(&[vertices.join("\n"), once.join("\n")].join("\n")).value;
    assert_eq!(mesh.positions().len(), 2 * single.positions().len());
    assert!(crease(&mesh) <= crease(&single) + 1e-6, "{} {}", crease(&mesh), crease(&single));
}

#[test]
fn two_sides_of_every_kind() {
    // Cut along different diagonals: no triangle has its counterpart.
    for faces in ["f 1 2 3\nf 1 3 4\nf 4 3 2\nf 4 2 1", "f 1 2 3\nf 1 3 4\nf 3 2 1\nf 4 3 1"] {
        let loaded = read(&format!("{PLATE}{faces}"));
        assert_eq!((loaded.value.positions().len(), crease(&loaded.value)), (8, 0.0), "{faces}");
        assert_eq!(loaded.warnings.len(), 1);
    }
    // A cube both ways round, in any order: normals outwards and inwards, along the diagonals.
    let corners = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n";
    let out = ["f 5 6 7 8", "f 2 1 4 3", "f 6 2 3 7", "f 1 5 8 4", "f 8 7 3 4", "f 1 2 6 5"];
    let back = ["f 8 7 6 5", "f 3 4 1 2", "f 7 3 2 6", "f 4 8 5 1", "f 4 3 7 8", "f 5 6 2 1"];
    let mut mixed: Vec<&str> =
        (0..6).flat_map(|i| if i % 2 == 0 { [out[i], back[i]] } else { [back[i], out[i]] }).collect();
    mixed.rotate_left(3);
    let mesh = read(&format!("{corners}{}", mixed.join("\n"))).value;
    assert_eq!(mesh.positions().len(), 16);
    for (p, n) in mesh.positions().iter().zip(mesh.normals()) {
        assert!((n.dot(p).abs() - 3f32.sqrt()).abs() < 1e-6, "{p} {n}");
    }
    for f in mesh.faces() {
        let [a, b, c] = f.map(|i| mesh.positions()[i as usize]);
        let up = (b - a).cross(&(c - a));
        assert!(f.iter().all(|&i| mesh.normals()[i as usize].dot(&up) > 0.0));
    }
    // Three walls that meet in an edge, each both ways round: six vertices for each end of the edge.
    let walls = "v 0 0 0\nv 0 0 1\nv 1 0 0\nv 1 0 1\nv 0 1 0\nv 0 1 1\nv -1 -1 0\nv -1 -1 1\n\
                 f 1 2 4 3\nf 3 4 2 1\nf 1 2 6 5\nf 5 6 2 1\nf 1 2 8 7\nf 7 8 2 1\n";
    let mesh = read(walls).value;
    assert_eq!((mesh.positions().len(), crease(&mesh)), (24, 0.0));
    // Given normals are kept and nothing is split.
    let given = read(&format!("{PLATE}vn 0 0 1\nf 1//1 2//1 3//1 4//1\nf 4//1 3//1 2//1 1//1"));
    assert_eq!((given.value.positions().len(), given.warnings.len()), (4, 0));
    // A face that is there twice the same way round changes nothing.
    let again = read(&format!("{PLATE}f 1 2 3 4\nf 3 4 1 2"));
    assert_eq!((again.value.positions().len(), again.warnings.len()), (4, 0));
}

// --------------------------------------------------------------------------------------------------------- winding

const CUBE: [&str; 6] = ["f 3 4 2 1", "f 6 8 7 5", "f 2 6 5 1", "f 7 8 4 3", "f 5 7 3 1", "f 4 8 6 2"];

/// The corners of an axis-parallel cube, in the order of [`CUBE`], which is wound inwards.
fn cube_corners(low: [f32; 3], size: f32) -> String {
    let at = |bit: usize, k: usize| low[k] + if bit == 0 { 0.0 } else { size };
    (0..8).map(|i| format!("v {} {} {}\n", at(i & 4, 0), at(i & 2, 1), at(i & 1, 2))).collect()
}

/// Such a cube after `before` vertices.
fn cube(low: [f32; 3], size: f32, before: usize, inwards: bool) -> (String, String) {
    let face = |f: &&str| {
        let mut corners: Vec<String> =
            f[2..].split(' ').map(|w| (w.parse::<usize>().unwrap() + before).to_string()).collect();
        if !inwards {
            corners.reverse();
        }
        format!("f {}\n", corners.join(" "))
    };
    (cube_corners(low, size), CUBE.iter().map(face).collect())
}

fn join(cubes: &[(String, String)]) -> String {
    let part = |k: usize| cubes.iter().map(|c| [&c.0, &c.1][k].as_str()).collect::<String>();
    part(0) + &part(1)
}

#[test]
fn closed_surfaces_are_wound_outwards() {
    let loaded = load("inside_out_cube.obj");
    assert_eq!(volume(&loaded.value), 1.0);
    assert!(
        loaded.value.positions().iter().zip(loaded.value.normals()).all(|(p, n)| (p - V::repeat(0.5)).dot(n) > 0.8)
    );
    assert_eq!(
        messages(&loaded),
        ["triangle 0: 1 closed surface is wound inwards; 12 triangles turned outwards (for a room that is seen from \
          inside ask for Winding::Keep)"]
    );
    let loaded = load("ball_mixed_winding.obj");
    assert!(loaded.value.positions().iter().zip(loaded.value.normals()).all(|(p, n)| p.dot(n) > 0.9 * p.norm()));
    assert_eq!(loaded.warnings.len(), 1);
    assert!(messages(&loaded)[0].contains("wound against the others; turned"), "{:?}", messages(&loaded));
    // Asked to keep it: as it is in the file, without a word.
    let text = join(&[cube([0.0; 3], 1.0, 0, true)]);
    let kept = read_obj_with(text.as_bytes(), "a.obj", &MeshOptions::default().with_winding(Winding::Keep)).unwrap();
    assert_eq!((volume(&kept.value), kept.warnings.len()), (-1.0, 0));
    // Wound outwards: nothing to do.
    let fine = read(&join(&[cube([0.0; 3], 1.0, 0, false)]));
    assert_eq!((volume(&fine.value), fine.warnings.len()), (1.0, 0));
    // Vertices of its own for every face, flat normals, faces there again: the same.
    for (from, to) in [("\nf ", "\nf "), ("v 0 0 0", "s off\nv 0 0 0")] {
        let text = text.replacen(from, to, 1) + "f 3 4 2 1\n";
        let mesh = read(&text).value;
        assert!(volume(&mesh) >= 1.0, "{to}");
        assert!(mesh.positions().iter().zip(mesh.normals()).all(|(p, n)| (p - V::repeat(0.5)).dot(n) > 0.4));
    }
    let single: String = CUBE
        .iter()
        .flat_map(|f| f[2..].split(' '))
        .map(|w| text.lines().nth(w.parse::<usize>().unwrap() - 1).unwrap().to_owned() + "\n")
        .collect();
    let single = single
        + &(0..6).map(|i| format!("f {} {} {} {}\n", 4 * i + 1, 4 * i + 2, 4 * i + 3, 4 * i + 4)).collect::<String>();
    assert_eq!(volume(&read(&single).value), 1.0);
}

#[test]
fn several_closed_surfaces() {
    let said = |cubes: &[(String, String)]| {
        let loaded = read(&join(cubes));
        (volume(&loaded.value), loaded.warnings.len())
    };
    // Side by side: each by itself. Touching along an edge: the same.
    for x in [3.0, 1.0] {
        let y = if x == 1.0 { 1.0 } else { 0.0 };
        assert_eq!(said(&[cube([0.0; 3], 1.0, 0, true), cube([x, y, 0.0], 1.0, 8, false)]), (2.0, 1), "{x}");
        assert_eq!(said(&[cube([0.0; 3], 1.0, 0, true), cube([x, y, 0.0], 1.0, 8, true)]), (2.0, 1), "{x}");
    }
    // A shell: its inner side is rightly wound inwards. A solid within a solid.
    assert_eq!(said(&[cube([0.0; 3], 4.0, 0, false), cube([1.0; 3], 1.0, 8, true)]), (63.0, 0));
    assert_eq!(said(&[cube([0.0; 3], 4.0, 0, false), cube([1.0; 3], 1.0, 8, false)]), (65.0, 0));
    // A room with furniture, in any order: stays, with a warning.
    let room = [cube([0.0; 3], 4.0, 0, true), cube([1.0; 3], 1.0, 8, false)];
    assert_eq!(said(&room), (-63.0, 1));
    assert_eq!(said(&[cube([1.0; 3], 1.0, 0, false), cube([0.0; 3], 4.0, 8, true)]), (-63.0, 1));
    assert!(messages(&read(&join(&room)))[0].contains("taken for a room"));
    // A room with a plate in it, which is not closed.
    let (v, f) = cube([0.0; 3], 4.0, 0, true);
    let plate = format!("{v}v 1 1 1\nv 2 1 1\nv 1 2 1\n{f}f 9 10 11\n");
    assert!(messages(&read(&plate))[0].contains("taken for a room"));
    // A box around, but nothing within: the inner cube is beside the arms of an L.
    assert_eq!(said(&[cube([0.0; 3], 1.0, 0, true), cube([10.0; 3], 1.0, 8, false)]), (2.0, 1));
}

#[test]
fn mixed_winding_of_every_kind() {
    // Any half of a cube's faces turned: outwards again.
    for bits in 1..63_u32 {
        let (corners, faces) = cube([0.0; 3], 1.0, 0, false);
        let faces: String = (faces.lines().enumerate())
            .map(|(i, line)| {
                let mut c: Vec<&str> = line[2..].split(' ').collect();
                if bits >> i & 1 == 1 {
                    c.reverse();
                }
                format!("f {}\n", c.join(" "))
            })
            .collect();
        let loaded = read(&(corners + &faces));
        assert_eq!((volume(&loaded.value), loaded.warnings.len()), (1.0, 1), "{bits:06b}");
        let n = 2 * bits.count_ones();
        let warned = &loaded.warnings[0].message;
        assert!(warned.starts_with(&format!("{n} triangles of closed surfaces were wound against")), "{warned}");
    }
    // Given normals say which way is out, a room's too.
    let (corners, faces) = cube([0.0; 3], 1.0, 0, true);
    let normals: String =
        ["-1 0 0", "1 0 0", "0 -1 0", "0 1 0", "0 0 -1", "0 0 1"].map(|n| format!("vn {n}\n")).concat();
    let inward = [2, 1, 4, 3, 6, 5];
    let faces: String = (faces.lines().zip(inward).enumerate())
        .map(|(i, (line, n))| {
            let mut c: Vec<String> = line[2..].split(' ').map(|w| format!("{w}//{n}")).collect();
            if i == 2 {
                c.reverse();
            }
            format!("f {}\n", c.join(" "))
        })
        .collect();
    // The normals of CUBE's faces, in its order: −x, +x, −y, +y, −z, +z.
    let loaded = read(&(corners + &normals + &faces));
    assert_eq!(volume(&loaded.value), -1.0);
    assert_eq!(loaded.warnings.len(), 1);
    // Flat, and covered twice in the same direction but with another diagonal: no inside, no outside.
    let flat = read(&format!("{PLATE}f 1 2 3 4\nf 2 3 4 1\nf 1 2 3\nf 1 3 4\n"));
    assert_eq!((area_from_above(&flat.value), flat.warnings.len()), (12.0, 0));
    // Open: a warning with the place, and nothing is turned.
    let open = read("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 4 3\n");
    assert_eq!(area_from_above(&open.value), 0.0);
    assert!(messages(&open)[0].starts_with("triangle 1: 1 surface that is open"), "{:?}", messages(&open));
    // A band with one side only.
    let n = 12;
    let mut band = String::new();
    for i in 0..n {
        let (a, h) = (i as f64 / n as f64 * std::f64::consts::TAU, i as f64 / n as f64 * std::f64::consts::PI);
        for s in [-0.3, 0.3] {
            let r = 1.0 + s * h.cos();
            band += &format!("v {} {} {}\n", r * a.cos(), s * h.sin(), r * a.sin());
        }
    }
    for i in 0..n {
        let (a, b) = (2 * i + 1, 2 * i + 2);
        let (c, d) = if i + 1 < n { (a + 2, b + 2) } else { (2, 1) };
        band += &format!("f {a} {b} {d} {c}\n");
    }
    let loaded = read(&band);
    assert!(messages(&loaded)[0].contains("that is open or has one side only"), "{:?}", messages(&loaded));
    assert_eq!(loaded.value.faces().len(), 2 * n);
}

// ----------------------------------------------------------------------------------------------------------------- up

#[test]
fn the_axis_that_points_up() {
    let text = format!("{PLATE}v 0 0 3\nvn 1 2 3\nf 1 2 3 4\nf 1//1 2//1 5//1\n");
    let turned = |up| read_obj_with(text.as_bytes(), "a.obj", &MeshOptions::default().with_up(up)).unwrap().value;
    let (x, y, z) = (turned(Up::X), turned(Up::Y), turned(Up::Z));
    assert_eq!(y, read(&text).value);
    for (i, p) in y.positions().iter().enumerate() {
        assert_eq!(x.positions()[i], V::new(-p.y, p.x, p.z));
        assert_eq!(z.positions()[i], V::new(p.x, p.z, -p.y));
        let n = y.normals()[i];
        assert_eq!(x.normals()[i], V::new(-n.y, n.x, n.z));
        assert_eq!(z.normals()[i], V::new(n.x, n.z, -n.y));
    }
    // The plate lies on the ground.
    assert!(z.normals().iter().filter(|n| **n == V::y()).count() >= 2);
    // The origin goes with it.
    let far = "v 500000.1 5400000.2 7.3\nv 500001.4 5400000.2 7.3\nv 500000.1 5400001.6 7.3\nf 1 2 3\n";
    let mesh = read_obj_with(far.as_bytes(), "a.obj", &MeshOptions::default().with_up(Up::Z)).unwrap().value;
    let p = mesh.origin() + mesh.positions()[2].cast::<f64>();
    assert!((p - Vector3::new(500_000.1, 7.3, -5_400_001.6)).amax() < 1e-6, "{p}");
}

// ------------------------------------------------------------------------------------------------------- polygons

#[test]
fn concave_polygons_keep_their_area() {
    for (name, expected) in [("dart.obj", 4.0), ("w.obj", 3.0)] {
        let loaded = load(name);
        assert_eq!(area(&loaded.value), expected, "{name}");
        assert_eq!(area_from_above(&loaded.value).abs(), expected, "{name}");
        assert_eq!(messages(&loaded), [""; 0], "{name}");
    }
}

/// Found by fuzzing: a polygon whose halves cancel took the triangles of the one before it, with corners that it does
/// not have.
#[test]
fn a_polygon_that_cancels_has_triangles_of_its_own() {
    let loaded = load("bow_tie_after_w.obj");
    assert_eq!(loaded.value.faces()[3..], [[5, 6, 7], [5, 7, 8]]);
    // A W of 3, and two halves of 2 each.
    assert_eq!(area(&loaded.value), 7.0);
    let message = "triangle 3, a polygon of 4 corners: the outline of 1 polygon crosses itself; the triangles cover \
                   more or less than it encloses";
    assert!(messages(&loaded).contains(&message.to_owned()), "{:?}", messages(&loaded));
}
