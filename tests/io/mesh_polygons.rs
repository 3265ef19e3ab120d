//! Polygons cut into triangles: nothing outside, nothing twice, all of the area.

use std::fmt::Write as _;

use haarmonic::io::{Loaded, read_obj};
use haarmonic::nalgebra::{Rotation3, Vector3};
use haarmonic::scene::Mesh;
use proptest::prelude::*;

use crate::support::cases;

type P = [f64; 2];

/// A polygon as one face, laid into space by `place`.
fn read(outline: &[P], place: impl Fn(P) -> Vector3<f64>) -> Loaded<Mesh> {
    let mut text = String::new();
    for &p in outline {
        let v = place(p);
        let _ = writeln!(text, "v {} {} {}", v.x as f32, v.y as f32, v.z as f32);
    }
    let corners: String = (1..=outline.len()).map(|i| format!(" {i}")).collect();
    read_obj(format!("{text}f{corners}\n").as_bytes(), "a.obj").unwrap()
}

fn flat([x, y]: P) -> Vector3<f64> {
    Vector3::new(x, y, 0.0)
}

fn cross([ax, ay]: P, [bx, by]: P, [cx, cy]: P) -> f64 {
    (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
}

/// The signed area of an outline, which holes diminish.
fn area(outline: &[P]) -> f64 {
    let n = outline.len();
    (0..n).map(|i| outline[i][0] * outline[(i + 1) % n][1] - outline[i][1] * outline[(i + 1) % n][0]).sum::<f64>() / 2.0
}

/// How often an outline goes around a point.
fn windings(outline: &[P], p: P) -> i32 {
    let n = outline.len();
    (0..n)
        .map(|i| (outline[i], outline[(i + 1) % n]))
        .map(|(a, b)| match (a[1] <= p[1], b[1] <= p[1]) {
            (true, false) if cross(a, b, p) > 0.0 => 1,
            (false, true) if cross(a, b, p) < 0.0 => -1,
            _ => 0,
        })
        .sum()
}

/// The triangles of a mesh in the plane z = 0.
fn triangles(mesh: &Mesh) -> Vec<[P; 3]> {
    let at = |i: u32| mesh.positions()[i as usize].cast::<f64>();
    mesh.faces().iter().map(|f| f.map(|i| [at(i).x, at(i).y])).collect()
}

/// The triangles all turn as the outline does, lie inside, and have its area.
fn covers(mesh: &Mesh, outline: &[P], slack: f64) {
    let whole = area(outline);
    let mut sum = 0.0;
    for [a, b, c] in triangles(mesh) {
        let twice = cross(a, b, c) * whole.signum();
        assert!(twice >= -slack, "a triangle of area {} turns the other way", twice / 2.0);
        sum += twice / 2.0;
        // Points well within a triangle that is no sliver.
        if twice > 1e3 * slack {
            for w in
                [[1.0, 1.0, 1.0], [8.0, 1.0, 1.0], [1.0, 8.0, 1.0], [1.0, 1.0, 8.0], [5.0, 5.0, 1.0], [1.0, 5.0, 5.0]]
            {
                let total: f64 = w.iter().sum();
                let p = [0, 1].map(|k| (w[0] * a[k] + w[1] * b[k] + w[2] * c[k]) / total);
                assert_eq!(windings(outline, p), whole.signum() as i32, "{p:?} of {:?} is outside", [a, b, c]);
            }
        }
    }
    assert!((sum - whole.abs()).abs() <= slack, "{sum} {whole}");
}

fn rounded(p: P) -> P {
    p.map(|c| f64::from(c as f32))
}

/// A star-shaped outline with `n` radii, counter-clockwise.
fn star(radii: &[f64], centre: P, size: f64, turn: f64) -> Vec<P> {
    let n = radii.len();
    let corner = |i: usize| {
        let t = (i as f64 + turn) / n as f64 * std::f64::consts::TAU;
        rounded([centre[0] + size * radii[i] * t.cos(), centre[1] + size * radii[i] * t.sin()])
    };
    (0..n).map(corner).collect()
}

/// A square of side 8 with holes in cells of a grid of 4 × 4, each joined to the outline by a bridge to its left
/// neighbour.
fn with_holes(holes: &[Vec<f64>]) -> Vec<P> {
    let mut outline: Vec<P> = vec![[0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0]];
    for (i, radii) in holes.iter().enumerate() {
        // One column each, so that a bridge straight down to the lower edge meets nothing.
        let centre = [1.0 + 2.0 * i as f64, 4.0];
        let mut hole = star(radii, centre, 0.9, -0.25 * radii.len() as f64);
        hole.reverse();
        // The corner straight below the centre is the first of the star, the last after reversing.
        let foot = [hole[hole.len() - 1][0], 0.0];
        let at = outline.iter().position(|p| *p == [8.0, 0.0]).unwrap();
        let mut bridge = vec![foot, hole[hole.len() - 1]];
        bridge.extend(&hole);
        bridge.push(foot);
        outline.splice(at..at, bridge);
    }
    outline
}

/// Rounding of coordinates up to 8 to f32, on an outline of length 1000 at most.
const SLACK: f64 = 8.0 * f32::EPSILON as f64 * 1000.0;

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn star_shaped(radii in prop::collection::vec(0.05..1.0f64, 3..40), start in 0..40usize, clockwise in any::<bool>()) {
        let mut outline = star(&radii, [0.5, -0.25], 4.0, 0.3);
        outline.rotate_left(start % radii.len());
        if clockwise {
            outline.reverse();
        }
        prop_assume!(area(&outline).abs() > 1e-3);
        let loaded = read(&outline, flat);
        prop_assert_eq!(&loaded.warnings[..], &[][..]);
        // The coordinates are those of the outline: only the sums are rounded.
        covers(&loaded.value, &outline, 1e-12);
    }

    #[test]
    fn with_bridges(
        holes in prop::collection::vec(prop::collection::vec(0.2..1.0f64, 3..12), 1..4),
        start in 0..60usize,
        clockwise in any::<bool>(),
    ) {
        let mut outline = with_holes(&holes);
        let n = outline.len();
        outline.rotate_left(start % n);
        if clockwise {
            outline.reverse();
        }
        let loaded = read(&outline, flat);
        prop_assert!(loaded.warnings.iter().all(|w| !w.message.contains("crosses")), "{:?}", loaded.warnings);
        covers(&loaded.value, &outline, SLACK);
    }

    #[test]
    fn in_space(radii in prop::collection::vec(0.1..1.0f64, 4..20), axis in prop::array::uniform3(-1.0..1.0f64), bump in 0.0..0.05f64) {
        let outline = star(&radii, [0.0, 0.0], 3.0, 0.1);
        let turn = Rotation3::new(Vector3::from(axis) * 3.0);
        let place = |p: P| turn * Vector3::new(p[0], p[1], bump * (3.0 * p[0]).sin()) + Vector3::new(5.0, -3.0, 1.0);
        let loaded = read(&outline, place);
        prop_assert_eq!(&loaded.warnings[..], &[][..]);
        // Laid back into the plane.
        let back = |i: &u32| turn.inverse() * (loaded.value.positions()[*i as usize].cast::<f64>() - Vector3::new(5.0, -3.0, 1.0));
        let area_of = |f: &[u32; 3]| {
            let [a, b, c] = [0, 1, 2].map(|k| back(&f[k]));
            cross([a.x, a.y], [b.x, b.y], [c.x, c.y]) / 2.0
        };
        let sum: f64 = loaded.value.faces().iter().map(area_of).sum();
        let size: f64 = loaded.value.faces().iter().map(|f| area_of(f).abs()).sum();
        // Seen along another direction than the Newell normal by the bumps: slivers may turn by their square.
        prop_assert!((sum - area(&outline)).abs() < 1e-4, "{} {}", sum, area(&outline));
        prop_assert!(size - sum < 1e-4 + 0.2 * bump * size, "{} {}", size, sum);
    }

    #[test]
    fn anything(points in prop::collection::vec(prop::array::uniform2(0..6i32), 4..30)) {
        // Crossing, touching, running back on itself: a mesh or an error, never a panic, and a warning if the area is
        // wrong.
        let outline: Vec<P> = points.iter().map(|p| p.map(f64::from)).collect();
        let mut text: String = outline.iter().map(|p| format!("v {} {} 0\n", p[0], p[1])).collect();
        text += "f";
        (1..=outline.len()).for_each(|i| text += &format!(" {i}"));
        if let Ok(loaded) = read_obj(text.as_bytes(), "a.obj") {
            let sum: f64 = loaded.value.face_areas().iter().sum();
            let told = loaded.warnings.iter().any(|w| w.message.contains("crosses itself"));
            prop_assert!(told || (sum - area(&outline).abs()).abs() < 1e-9, "{} {}", sum, area(&outline));
        }
    }
}

#[test]
fn convex_polygons_are_fans() {
    for n in 3..60 {
        let outline = star(&vec![1.0; n], [3.0, 7.0], 2.0, 0.2);
        for place in
            [flat as fn(P) -> Vector3<f64>, |p| Vector3::new(1.0, p[0], p[1]), |p| Vector3::new(p[0], p[0], p[1])]
        {
            let fan: Vec<[u32; 3]> = (1..n as u32 - 1).map(|i| [0, i, i + 1]).collect();
            assert_eq!(read(&outline, place).value.faces(), fan);
        }
    }
    // Corners along an edge, also at the first corner, where a triangle has no area.
    let edge = [[1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0]];
    assert_eq!(read(&edge, flat).value.faces(), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    // A quadrilateral that is not plane, convex along its normal: the diagonal from the first corner.
    let bent = read(&edge[1..], |p| Vector3::new(p[0], p[1], p[0] * p[1]));
    assert_eq!(bent.value.faces(), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn corners_that_repeat() {
    let square = [[0.0, 0.0], [0.0, 0.0], [2.0, 0.0], [2.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0]];
    covers(&read(&square, flat).value, &square, 0.0);
    // A spike out and back, inwards and outwards.
    let spikes =
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
    let sum: f64 = read(&spikes, flat).value.face_areas().iter().sum();
    assert!((sum - 4.0).abs() < 1e-12, "{sum}");
}

#[test]
fn outlines_that_cross_themselves() {
    let pentagram: Vec<P> =
        (0..5).map(|i| f64::from(i) * 0.8 * std::f64::consts::PI).map(|t| [t.cos(), t.sin()]).collect();
    for outline in [
        vec![[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]],
        vec![[0.0, 0.0], [3.0, 3.0], [3.0, 0.0], [0.0, 2.0]],
        pentagram,
    ] {
        let loaded = read(&outline, flat);
        let n = outline.len();
        assert_eq!(loaded.warnings[0].place, format!("triangle 0, a polygon of {n} corners"));
        assert!(loaded.warnings[0].message.starts_with("the outline of 1 polygon crosses itself"));
        assert!(!loaded.value.faces().is_empty());
    }
}

#[test]
fn long_outlines() {
    // A comb of fifty thousand corners, a spiral of eight thousand.
    let n = 50_000;
    let comb: Vec<P> = (0..n)
        .map(|i| rounded([i as f64, if i % 2 == 0 { 0.0 } else { 5e4 }]))
        .chain([[n as f64, -1.0], [0.0, -1.0]])
        .collect();
    let loaded = read(&comb, flat);
    assert_eq!(loaded.warnings, []);
    let sum: f64 = loaded.value.face_areas().iter().sum();
    assert!((sum / area(&comb).abs() - 1.0).abs() < 1e-9, "{sum}");
    let turn = |i: usize, r: f64| {
        let t = i as f64 * 0.05;
        rounded([(t + r) * t.cos(), (t + r) * t.sin()])
    };
    let m = 4_000;
    let spiral: Vec<P> = (0..m).map(|i| turn(i, 3.0)).chain((0..m).rev().map(|i| turn(i, 1.0))).collect();
    let loaded = read(&spiral, flat);
    let sum: f64 = loaded.value.face_areas().iter().sum();
    assert!((sum / area(&spiral).abs() - 1.0).abs() < 1e-6, "{sum} {}", area(&spiral));
}
