//! Meshes far from zero: the origin that is taken off before coordinates are rounded to `f32`.

use std::fmt::Write as _;

use haarmonic::Error;
use haarmonic::io::{Loaded, encode_ply, load_mesh, read_obj, read_ply};
use haarmonic::nalgebra::{Affine3, Matrix4, Vector3};
use haarmonic::scene::Mesh;

type V = Vector3<f64>;

/// A torus of radii 2 and 1 as OBJ text: its middle at `centre`, `scale` times as large, so many decimals.
fn torus(centre: V, scale: f64, decimals: usize) -> String {
    let (n, m) = (24, 12);
    let angle = |i: usize, n: usize| i as f64 / n as f64 * std::f64::consts::TAU;
    let mut text = String::new();
    for i in 0..n * m {
        let (a, b) = (angle(i / m, n), angle(i % m, m));
        let p = centre + V::new((2.0 + b.cos()) * a.cos(), b.sin(), -(2.0 + b.cos()) * a.sin()) * scale;
        let _ = writeln!(text, "v {:.*} {:.*} {:.*}", decimals, p.x, decimals, p.y, decimals, p.z);
    }
    for i in 0..n * m {
        let at = |i: usize, j: usize| i % n * m + j % m + 1;
        let (i, j) = (i / m, i % m);
        let _ = writeln!(text, "f {} {} {} {}", at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
    text
}

fn read(text: &str) -> Loaded<Mesh> {
    read_obj(text.as_bytes(), "a.obj").unwrap()
}

fn world(mesh: &Mesh) -> Vec<V> {
    mesh.positions().iter().map(|p| mesh.origin() + p.cast::<f64>()).collect()
}

/// The largest distance, in the maximum norm, between the coordinates of the text and those of the mesh.
fn error(text: &str, mesh: &Mesh) -> f64 {
    let numbers = |l: &str| V::from_iterator(l[2..].split(' ').map(|w| w.parse::<f64>().unwrap()));
    let given: Vec<V> = text.lines().filter(|l| l.starts_with("v ")).map(numbers).collect();
    assert_eq!(given.len(), mesh.positions().len());
    given.iter().zip(world(mesh)).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max)
}

#[test]
fn surveyors_coordinates_keep_their_shape() {
    let zero = read(&torus(V::zeros(), 1.0, 4)).value;
    for centre in
        [V::new(500_123.0, 5_412_345.0, 312.0), V::new(3_456_789.0, 5_765_432.0, -40.0), V::new(0.0, 0.0, 2e7)]
    {
        let text = torus(centre, 1.0, 4);
        let loaded = read(&text);
        let mesh = &loaded.value;
        // Relative coordinates are below 4 and a step of the grid: half of their last place.
        assert!(error(&text, mesh) <= f64::from(f32::EPSILON) * 4.0, "{}", error(&text, mesh));
        let [x, y, z] = mesh.origin().into();
        assert_eq!(
            loaded.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
            [format!(
                "a.obj: coordinates are too far from zero for f32: the origin ({x}, {y}, {z}) was taken off them; \
                 Mesh::origin has it"
            )]
        );
        assert!((mesh.origin() - centre).amax() <= 4.0);
        for (a, b) in mesh.normals().iter().zip(zero.normals()) {
            // Four decimals on edges of a quarter.
            assert!((a - b).norm() < 1e-3);
        }
    }
}

#[test]
fn a_ball_of_three_metres_in_utm() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/faults/utm.obj");
    let loaded = load_mesh(path).unwrap();
    let area: f64 = loaded.value.face_areas().iter().sum();
    assert_eq!(loaded.value.faces().len(), 80);
    assert!((area - 104.996).abs() < 1e-3, "{area}");
    assert_eq!(loaded.warnings.len(), 1);
    // Written and read again: the same coordinates, as doubles.
    let mesh = loaded.value;
    let bytes = encode_ply(&mesh, Some(&vec![Vector3::zeros(); mesh.positions().len()])).unwrap();
    let header = String::from_utf8_lossy(&bytes[..400]).into_owned();
    assert!(
        header.contains("property double x\nproperty double y\nproperty double z\nproperty float nx\n"),
        "{header}"
    );
    let back = read_ply(&bytes, "b.ply").unwrap().value;
    assert_eq!(world(&back), world(&mesh));
    assert_eq!(back, mesh);
}

#[test]
fn what_f32_holds_is_left_alone() {
    // Near zero, beside zero, large, small; and far away where the numbers are exact.
    for (centre, scale) in
        [(V::zeros(), 1.0), (V::new(3.0, 40.0, 0.0), 1.0), (V::zeros(), 1e30), (V::new(1.0, 2.0, 3.0), 1e-3)]
    {
        let text = torus(centre, scale, 9);
        let loaded = read(&text);
        assert_eq!(loaded.value.origin(), V::zeros());
        assert_eq!(loaded.warnings, []);
        let parsed = text.lines().find(|l| l.starts_with("v ")).unwrap()[2..].split(' ');
        let parsed = Vector3::from_iterator(parsed.map(|w| w.parse::<f32>().unwrap()));
        assert_eq!(loaded.value.positions()[0], parsed);
    }
    let exact = read("v 8000000 0 0\nv 8000002 0 0\nv 8000000 2 0\nf 1 2 3\n");
    assert_eq!((exact.value.origin(), exact.warnings.len()), (V::zeros(), 0));
}

#[test]
fn a_far_triangle_makes_nothing_worse() {
    let body = torus(V::zeros(), 1.0, 6);
    let alone = read(&body).value;
    for far in [1e4, 1e5, 1e7] {
        let text = format!("{body}v 0 {far}.1 0\nv {far}.3 {far}.1 0\nv 0 {far}.1 {far}.7\nf 289 290 291\n");
        let loaded = read(&text);
        assert_eq!((loaded.value.origin(), &loaded.warnings[..]), (V::zeros(), &[][..]), "{far}");
        assert_eq!(loaded.value.positions()[..288], alone.positions()[..]);
    }
    // The body far away and the triangle at zero: the origin is the body's.
    let centre = V::new(0.0, 5_412_345.0, 0.0);
    let text = torus(centre, 1.0, 4) + "v 0 0 0\nv 1000.3 0 0\nv 0 0 1000.3\nf 289 290 291\n";
    let loaded = read(&text);
    assert!((loaded.value.origin() - centre).amax() <= 4.0);
    assert_eq!(loaded.warnings.len(), 1);
    let body = &loaded.value.positions()[..288];
    assert!(body.iter().all(|p| p.amax() <= 8.0));
    // Two bodies far apart: one of them is rounded, and that is said.
    let (first, second) = (torus(centre, 1.0, 4), torus(-centre, 1.0, 4));
    let lines = |text: &str, kind: &str| -> String {
        text.lines().filter(|l| l.starts_with(kind)).map(|l| format!("{l}\n")).collect()
    };
    // Counted back from the line, the same numbers name the vertices just read.
    let relative = |text: &str| -> String {
        let corner = |w: &str| format!(" {}", w.parse::<i64>().unwrap() - 289);
        let face = |l: &str| format!("f{}\n", l[2..].split(' ').map(corner).collect::<String>());
        lines(text, "f ").lines().map(face).collect()
    };
    let loaded = read(&(lines(&first, "v ") + &relative(&first) + &lines(&second, "v ") + &relative(&second)));
    let said = loaded.warnings.last().unwrap().to_string();
    assert!(said.contains("the coordinates span too much for f32: rounding moves corners by up to"), "{said}");
    // Neither is worth more than the other.
    assert_eq!(loaded.value.origin(), V::zeros());
}

#[test]
fn coordinates_beyond_f32() {
    // Finite once the origin is off.
    let text = "v 1e40 0 0\nv 1.001e40 0 0\nv 1e40 1e37 0\nf 1 2 3\n";
    let mesh = read(text).value;
    assert!((world(&mesh)[1].x - 1.001e40).abs() < 1e40 * 1e-9);
    // Not finite from anywhere: the line.
    for (bad, line) in [
        ("v 0 0 0\nv 1 0 0\nv 0 1e300 0\n", 3),
        ("v 0 0 0\nv inf 0 0\nv 0 1 0\n", 2),
        ("v 0 0 nan\nv 1 0 0\nv 0 1 0\n", 1),
    ] {
        let e = read_obj(format!("{bad}f 1 2 3\n").as_bytes(), "a.obj").unwrap_err().to_string();
        assert_eq!(e, format!("a.obj, line {line}: the vertex is NaN, infinite or beyond f32"));
    }
    // In a vertex without a face they do not matter.
    let loaded = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 1e300 0\nv 0 inf 0\nf 1 2 3\nf 1 1 4\n");
    assert_eq!(loaded.value.positions().len(), 3);
    assert_eq!(loaded.warnings.len(), 2);
    // Extremes of f64: an error or a mesh, never a panic.
    for p in ["1.7e308", "-1.7e308", "5e-324", "1e-310"] {
        let _ = read_obj(format!("v {p} 0 0\nv -{p} 1 0\nv 0 {p} 1\nf 1 2 3\n").replace("--", "").as_bytes(), "a.obj");
    }
}

#[test]
fn meshes_with_origins_merge_and_move() {
    let origin = V::new(500_000.0, 5_400_000.0, 8.0);
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.5]].map(Vector3::<f32>::from).to_vec();
    let mesh = Mesh::new(corners, vec![[0, 1, 2]]).unwrap();
    assert_eq!(mesh.origin(), V::zeros());
    let far = mesh.clone().with_origin(origin).unwrap();
    let farther = mesh.clone().with_origin(origin + V::new(0.25, -2.0, 100.0)).unwrap();
    let both = Mesh::merge([&far, &farther]).unwrap();
    assert_eq!(both.origin(), origin);
    assert_eq!(world(&both), [world(&far), world(&farther)].concat());
    assert_eq!(both.positions()[4], Vector3::new(1.25, -2.0, 100.0));
    // Without origins the bits stay, −0 too.
    let minus = mesh.clone().with_origin(V::repeat(-0.0)).unwrap();
    assert_eq!(Mesh::merge([&mesh, &minus]).unwrap().positions()[3..], *mesh.positions());
    // A map acts on the positions.
    let twice = Affine3::from_matrix_unchecked(Matrix4::new_scaling(2.0));
    let scaled = far.transformed(&twice).unwrap();
    assert_eq!((scaled.origin(), scaled.positions()[1]), (origin, Vector3::new(2.0, 0.0, 0.0)));
    // Errors.
    assert!(matches!(mesh.clone().with_origin(V::new(0.0, f64::NAN, 0.0)), Err(Error::NotFinite { index: 1, .. })));
    assert!(matches!(
        mesh.clone().with_origin(V::new(f64::INFINITY, 0.0, 0.0)),
        Err(Error::NotFinite { index: 0, .. })
    ));
    let away = mesh.clone().with_origin(V::new(1e300, 0.0, 0.0)).unwrap();
    assert!(matches!(Mesh::merge([&mesh, &away]), Err(Error::NotFinite { index: 3, .. })));
    // Files without an origin are written as before.
    let bytes = encode_ply(&mesh, None).unwrap();
    assert!(String::from_utf8_lossy(&bytes).contains("property float x\n"));
}
