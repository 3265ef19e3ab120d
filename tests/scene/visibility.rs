//! Baked visibility against the naive twin, known geometry and itself.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use haarmonic::nalgebra::{Rotation3, Vector3};
use haarmonic::reference::scene as naive;
use haarmonic::scene::{
    BackFaces, BinaryVisibility, FractionalVisibility, Mesh, Procedural, VisibilityBaker, VisibilitySettings,
};
use haarmonic::sphere::CubeGrid;
use haarmonic::{Error, Progress};
use proptest::prelude::*;

use crate::support::{baker, cases, grid, room};

type V = Vector3<f32>;

fn bake(mesh: &Mesh, side: usize) -> BinaryVisibility {
    baker(mesh, side).bake(&()).unwrap()
}

/// Texels above a vertex's horizon.
fn above(mesh: &Mesh, grid: CubeGrid, vertex: usize) -> Vec<usize> {
    let normal = mesh.normals()[vertex].cast::<f64>();
    (0..grid.len()).filter(|&t| normal.dot(&grid.direction(t)) > 0.0).collect()
}

/// A floor [−h, h]² at y = 0 with a vertex at its middle (number 0), and a sphere of icosahedral cut `parts`.
fn floor_and_sphere(centre: V, radius: f32) -> Mesh {
    let corners = [[0., 0., 0.], [-9., 0., -9.], [-9., 0., 9.], [9., 0., 9.], [9., 0., -9.]].map(V::from);
    let floor = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]]).unwrap();
    Mesh::merge([&floor, &sphere(centre, radius, 64)]).unwrap()
}

/// A sphere by latitude and longitude, closed, smooth normals.
fn sphere(centre: V, radius: f32, n: u32) -> Mesh {
    let (mut positions, mut faces) = (vec![], vec![]);
    for i in 0..=n {
        for j in 0..2 * n {
            let (s, c) = (PI * f64::from(i) / f64::from(n)).sin_cos();
            let (sj, cj) = (PI * f64::from(j) / f64::from(n)).sin_cos();
            positions.push(Vector3::new(s * cj, c, s * sj).cast::<f32>());
        }
    }
    for i in 0..n {
        for j in 0..2 * n {
            let at = |i: u32, j: u32| i * 2 * n + j % (2 * n);
            faces.extend([[at(i, j), at(i, j + 1), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i + 1, j)]]);
        }
    }
    let normals = positions.clone();
    let positions = positions.iter().map(|p| centre + p * radius).collect();
    Mesh::with_normals(positions, normals, faces).unwrap()
}

/// How near a ray passes by the plane through its origin and an edge of any face, in units of what `f32` may confuse.
///
/// That is 20 roundings of the terms of the edge function (12 of widening, 8 of error). Positions are not rounded.
pub fn nearest_edge(mesh: &Mesh, origin: &Vector3<f64>, direction: &Vector3<f64>) -> f64 {
    let u = f64::from(f32::EPSILON) * 0.5;
    let direction = direction / direction.amax();
    let mut nearest = f64::INFINITY;
    for face in 0..mesh.faces().len() {
        let corners = mesh.corners(face).map(|p| p.cast::<f64>() - origin);
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let (m, e) = (if b.norm() < a.norm() { b } else { a }, b - a);
            let terms = m.abs().cross(&e.abs()).abs().sum()
                + 2.0 * (0..3).map(|i| (m[i] * e[(i + 1) % 3]).abs().min((m[(i + 1) % 3] * e[i]).abs())).sum::<f64>();
            nearest = nearest.min(m.cross(&e).dot(&direction).abs() / (20.0 * u * terms));
        }
    }
    nearest
}

prop_compose! {
    fn soup()(
        corners in prop::collection::vec(prop::array::uniform3(-1.0_f32..1.0), 9..60),
        picks in prop::collection::vec(prop::array::uniform3(0_usize..1000), 1..40),
        size in prop::sample::select(vec![1e-4_f32, 1.0, 1e4]),
        shift in prop::array::uniform3(-3.0_f32..3.0),
    ) -> Mesh {
        let n = corners.len();
        let positions = corners.into_iter().map(|c| (V::from(c) + V::from(shift)) * size).collect();
        let faces = picks.into_iter().map(|f| f.map(|i| (i % n) as u32)).collect();
        Mesh::new(positions, faces).unwrap()
    }
}

proptest! {
    #![proptest_config(cases(48))]

    /// Rasterised in a hierarchy, front to back, in runs: the bits of every triangle against every ray.
    #[test]
    fn fast_path_has_the_bits_of_brute_force(
        mesh in soup(),
        side in prop::sample::select(vec![1_usize, 2, 3, 8, 13, 16, 65]),
        ignore in any::<bool>(),
    ) {
        let back_faces = if ignore { BackFaces::Ignore } else { BackFaces::Occlude };
        let settings = VisibilitySettings::default().with_back_faces(back_faces);
        let baker = VisibilityBaker::new(&mesh, grid(side), settings).unwrap();
        let baked = baker.bake(&()).unwrap();
        for vertex in 0..baker.vertices().min(3) {
            for texel in (0..baker.grid().len()).step_by(1 + side / 16 * 7) {
                prop_assert_eq!(baked.sees(vertex, texel), baker.sees_brute_force(vertex, texel));
            }
        }
    }

    /// The naive twin in `f64` says the same but at edges, within the bound that their widening is documented to have.
    #[test]
    fn fast_path_agrees_with_the_naive_twin(mesh in soup(), ignore in any::<bool>()) {
        let back_faces = if ignore { BackFaces::Ignore } else { BackFaces::Occlude };
        let settings = VisibilitySettings::default().with_back_faces(back_faces);
        let baker = VisibilityBaker::new(&mesh, grid(16), settings).unwrap();
        let baked = baker.bake(&()).unwrap();
        for vertex in 0..baker.vertices().min(4) {
            let origin = baker.origin(vertex);
            for texel in above(&mesh, baker.grid(), vertex) {
                let direction = baker.grid().direction(texel).into_inner();
                if baked.sees(vertex, texel) == naive::occluded(&mesh, &origin, &direction, back_faces) {
                    let near = nearest_edge(&mesh, &origin, &direction);
                    prop_assert!(near < 1.0, "vertex {} texel {}: {} of the bound", vertex, texel, near);
                }
            }
        }
    }
}

#[test]
fn built_in_scenes_agree_with_the_naive_twin() {
    for scene in Procedural::ALL {
        let mesh = scene.build(1_000).unwrap().mesh;
        let baker = baker(&mesh, 16);
        let (mut rays, mut different) = (0, 0);
        let mut words = vec![0; baker.words_per_vertex()];
        for vertex in (7..baker.vertices()).step_by(311) {
            baker.bake_vertex(vertex, &mut words, &mut baker.scratch());
            let baked = BinaryVisibility::new(baker.grid(), words.clone()).unwrap();
            let origin = baker.origin(vertex);
            for texel in above(&mesh, baker.grid(), vertex) {
                let direction = baker.grid().direction(texel).into_inner();
                rays += 1;
                if rays % 7 == 0 {
                    assert_eq!(
                        baked.sees(0, texel),
                        baker.sees_brute_force(vertex, texel),
                        "{} {vertex}",
                        scene.name()
                    );
                }
                if baked.sees(0, texel) == naive::occluded(&mesh, &origin, &direction, BackFaces::Occlude) {
                    different += 1;
                    let near = nearest_edge(&mesh, &origin, &direction);
                    assert!(near < 1.0, "{} vertex {vertex}, texel {texel}: {near} of the bound", scene.name());
                }
            }
        }
        assert!(rays > 1_500 && different <= rays / 1_000, "{}: {different} of {rays}", scene.name());
    }
}

#[test]
fn a_room_shows_no_sky() {
    for (n, side) in [(1, 1), (1, 2), (1, 3), (2, 17), (5, 16), (8, 64), (7, 33)] {
        let mesh = room(n);
        let baked = bake(&mesh, side);
        for vertex in 0..baked.vertices() {
            assert_eq!(baked.count_ones(vertex), 0, "{n} cells, side {side}, vertex {vertex}");
        }
    }
}

#[test]
fn a_room_has_no_leaks_at_any_size_or_turn() {
    for (scale, turn) in [(1e-4, 0.3), (1e4, 1.1), (1.0, 0.0), (1.0, std::f64::consts::FRAC_PI_4)] {
        let map = haarmonic::nalgebra::Similarity3::from_parts(
            Vector3::new(scale * 3.0, -scale, 0.0).into(),
            Rotation3::from_euler_angles(turn, 2.0 * turn, 0.0).into(),
            scale,
        );
        let mesh = room(6).transformed(&haarmonic::nalgebra::convert(map)).unwrap();
        let baked = bake(&mesh, 32);
        let open: usize = (0..baked.vertices()).map(|v| baked.count_ones(v)).sum();
        assert_eq!(open, 0, "scale {scale}, turned by {turn}");
    }
}

#[test]
fn walls_seen_from_behind_can_be_ignored() {
    // The room's faces look inwards: from outside they are backs.
    let mesh = room(4);
    let outside = Mesh::with_normals(
        mesh.positions().iter().map(|p| p * 1.5).collect(),
        mesh.normals().iter().map(|n| -n).collect(),
        mesh.faces().to_vec(),
    );
    let both = Mesh::merge([&mesh, &outside.unwrap()]).unwrap();
    let settings = VisibilitySettings::default().with_back_faces(BackFaces::Ignore);
    let baker = VisibilityBaker::new(&both, grid(16), settings).unwrap();
    let baked = baker.bake(&()).unwrap();
    // The outer shell's vertices look away and see everything; the inner ones see fronts all around.
    let n = mesh.positions().len();
    assert!((0..n).all(|v| baked.count_ones(v) == 0));
    assert!((n..2 * n).all(|v| baked.count_ones(v) == above(&both, grid(16), v).len()));
}

#[test]
fn a_convex_mesh_sees_its_upper_hemisphere() {
    for (scale, side) in [(1.0, 32), (1e-4, 16), (1e4, 17)] {
        let mesh = sphere(V::new(0.3, -2.0, 0.7) * scale, scale, 20);
        let baker = baker(&mesh, side);
        let baked = baker.bake(&()).unwrap();
        let mut lost = 0;
        for vertex in 0..baked.vertices() {
            for texel in above(&mesh, grid(side), vertex) {
                if !baked.sees(vertex, texel) {
                    lost += 1;
                    let rise = mesh.normals()[vertex].cast::<f64>().dot(&grid(side).direction(texel));
                    assert!(rise < 1e-3, "scale {scale}, vertex {vertex}, texel {texel}: {rise}");
                }
            }
        }
        assert!(lost <= baked.vertices() / 20, "{lost}");
    }
}

#[test]
fn a_plane_sees_half_of_all_directions() {
    let n = 12_u32;
    let positions = (0..=n).flat_map(|i| (0..=n).map(move |j| V::new(j as f32, 0.37, i as f32) / 3.0)).collect();
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let faces = (0..n)
        .flat_map(|i| (0..n).map(move |j| (i, j)))
        .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]);
    let flat = Mesh::new(positions, faces.collect()).unwrap();
    // Upright, and turned: then its vertices are in a plane only to rounding.
    let turn = Rotation3::from_euler_angles(0.4, 1.0, -0.7);
    let turned = flat.transformed(&haarmonic::nalgebra::convert(turn)).unwrap();
    for mesh in [flat, turned] {
        let baked = bake(&mesh, 40);
        for vertex in 0..baked.vertices() {
            assert_eq!(baked.count_ones(vertex), above(&mesh, grid(40), vertex).len(), "vertex {vertex}");
        }
    }
}

#[test]
fn a_sphere_hides_its_cap() {
    // A sphere of radius r at distance d hides the solid angle 2π(1 − √(1 − r²/d²)).
    let (centre, radius) = (V::new(0.4, 1.6, -0.3), 0.8_f32);
    let mesh = floor_and_sphere(centre, radius);
    let ratio = f64::from(radius) / centre.cast::<f64>().norm();
    let exact = 2.0 * PI * (1.0 - (1.0 - ratio * ratio).sqrt());
    for (side, tolerance) in [(16, 4e-2), (64, 1e-2), (128, 4e-3)] {
        let baker = baker(&mesh, side);
        let mut words = vec![0; baker.words_per_vertex()];
        baker.bake_vertex(0, &mut words, &mut baker.scratch());
        let baked = BinaryVisibility::new(grid(side), words).unwrap();
        let (grid, omega) = (grid(side), grid(side).face_solid_angles());
        let share = |see: bool| -> f64 {
            let texels = above(&mesh, grid, 0).into_iter().filter(|&t| baked.sees(0, t) == see);
            texels.map(|t| omega[t % omega.len()]).sum()
        };
        // Texels are in or out by their centre: an error of about √(perimeter in texels) texels.
        let hidden = share(false);
        assert!((hidden / exact - 1.0).abs() < tolerance, "side {side}: {hidden} against {exact}");
        assert!((hidden + share(true) - 2.0 * PI).abs() < 1e-10);
        if side > 64 {
            continue;
        }
        let fractional = baker.with_grid(CubeGrid::new(side / 4).unwrap()).bake_fractional(4, &()).unwrap();
        let omega = fractional.grid().face_solid_angles();
        let seen: f64 = fractional.values(0).enumerate().map(|(t, v)| f64::from(v) * omega[t % omega.len()]).sum();
        assert!((seen - (2.0 * PI - exact)).abs() < 2.0 * tolerance * exact, "side {side}: {seen}");
    }
}

#[test]
fn light_passes_through_a_hole() {
    // A floor vertex under a ceiling with a square hole right above.
    let ring = [[-2., 1., -2.], [-2., 1., 2.], [2., 1., 2.], [2., 1., -2.]].map(V::from);
    let hole = ring.map(|p| V::new(p.x * 0.25, 1.0, p.z * 0.25));
    let floor = [[0., 0., 0.], [-0.1, 0., 0.2], [0.2, 0., 0.]].map(V::from);
    let positions = ring.into_iter().chain(hole).chain(floor).collect();
    let mut faces: Vec<[u32; 3]> =
        (0..4).flat_map(|i| [[i, (i + 1) % 4, 4 + i], [(i + 1) % 4, 4 + (i + 1) % 4, 4 + i]]).collect();
    faces.push([8, 9, 10]);
    let mesh = Mesh::new(positions, faces).unwrap();
    let baked = bake(&mesh, 64);
    for texel in above(&mesh, grid(64), 8) {
        let d = grid(64).direction(texel);
        // Where the ray pierces the ceiling's plane, in the largest of |x|, |z|.
        let at = (d.x / d.y).abs().max((d.z / d.y).abs());
        assert_eq!(baked.sees(8, texel), !(0.5..=2.0).contains(&at), "{at}");
    }
}

#[test]
fn size_and_place_do_not_matter() {
    let mesh = Procedural::Table.build(1_200).unwrap().mesh;
    let scaled = |s: f32| {
        Mesh::with_normals(
            mesh.positions().iter().map(|p| p * s).collect(),
            mesh.normals().to_vec(),
            mesh.faces().to_vec(),
        )
        .unwrap()
    };
    let baked = bake(&mesh, 16);
    // Powers of two are exact, so are the bits.
    for s in [2.0_f32.powi(-13), 2.0_f32.powi(13), 2.0_f32.powi(-100), 2.0_f32.powi(100)] {
        assert!(bake(&scaled(s), 16) == baked, "scale {s}");
    }
    for s in [1e-4, 1e4] {
        let other = bake(&scaled(s), 16);
        let differ: u32 = other.words().iter().zip(baked.words()).map(|(a, b)| (a ^ b).count_ones()).sum();
        let rays = mesh.positions().len() * grid(16).len() / 2;
        assert!((differ as usize) < rays / 1_000, "scale {s}: {differ} of {rays}");
    }
}

#[test]
fn broken_geometry_is_survived() {
    let v = |x: f32, y: f32, z: f32| V::new(x, y, z);
    let meshes = [
        // No area at all, in one point, in one line.
        (vec![v(1., 2., 3.)], vec![[0, 0, 0]]),
        (vec![v(0., 0., 0.), v(1., 0., 0.), v(2., 0., 0.)], vec![[0, 1, 2], [2, 1, 0], [1, 1, 0]]),
        // Slivers and enormous or tiny sizes.
        (vec![v(0., 0., 0.), v(1., 0., 0.), v(0.5, 1e-30, 0.)], vec![[0, 1, 2]]),
        (vec![v(-3e38, 0., 0.), v(3e38, 0., 0.), v(0., 3e38, 3e38)], vec![[0, 1, 2]]),
        (vec![v(0., 0., 0.), v(1e-45, 0., 0.), v(0., 0., 1e-45)], vec![[0, 1, 2]]),
        // A vertex without a face, far away.
        (vec![v(0., 0., 0.), v(0., 0., 1e-20), v(1e-20, 0., 0.), v(0., 3e38, 0.)], vec![[0, 1, 2]]),
    ];
    for (k, (positions, faces)) in meshes.into_iter().enumerate() {
        let mesh = Mesh::new(positions, faces).unwrap();
        let baked = bake(&mesh, 8);
        for vertex in 0..baked.vertices() {
            let most = above(&mesh, grid(8), vertex).len();
            assert!(baked.count_ones(vertex) + 2 >= most, "mesh {k}, vertex {vertex}: {}", baked.count_ones(vertex));
        }
    }
    // A thousand copies of one face: a hierarchy that cannot be split.
    let same = Mesh::new(vec![v(0., 0., 0.), v(0., 0., 1.), v(1., 0., 0.)], vec![[0, 1, 2]; 1000]).unwrap();
    assert_eq!(bake(&same, 16).count_ones(0), 6 * 16 * 16 / 2);
}

#[test]
fn fractional_is_the_mean_of_the_finer_grid() {
    let mesh = Procedural::StackedSpheres.build(1_000).unwrap().mesh;
    for (side, samples) in [(1, 1), (5, 3), (16, 4), (3, 15)] {
        let fine = bake(&mesh, side * samples);
        let fractional = baker(&mesh, side).bake_fractional(samples, &()).unwrap();
        assert_eq!((fractional.samples(), fractional.vertices()), (samples, mesh.positions().len()));
        for vertex in (0..fractional.vertices()).step_by(101) {
            let mut counts = vec![0_u8; grid(side).len()];
            for texel in 0..fine.grid().len() {
                let (face, x, y) = fine.grid().texel(texel);
                counts[grid(side).index(face, x / samples, y / samples)] += u8::from(fine.sees(vertex, texel));
            }
            assert_eq!(fractional.vertex(vertex), counts, "side {side}, {samples} samples, vertex {vertex}");
        }
    }
    assert!(baker(&mesh, 4).bake_fractional(0, &()).is_err());
    assert!(baker(&mesh, 4).bake_fractional(16, &()).is_err());
    assert!(baker(&mesh, CubeGrid::MAX_SIDE).bake_fractional(2, &()).is_err());
}

#[test]
fn one_vertex_has_the_bits_of_all() {
    let mesh = Procedural::TorusKnotOnFloor.build(1_000).unwrap().mesh;
    for side in [1, 8, 9, 64, 65, 128] {
        let baker = baker(&mesh, 16).with_grid(grid(side));
        let mut words = vec![u64::MAX; baker.words_per_vertex()];
        let mut scratch = baker.scratch();
        let rays = baker.bake_vertex(500, &mut words, &mut scratch);
        assert_eq!(rays as usize, above(&mesh, grid(side), 500).len());
        let baked = BinaryVisibility::new(grid(side), words.clone()).unwrap();
        for texel in 0..grid(side).len() {
            if texel % 37 == 0 {
                assert_eq!(baked.sees(0, texel), baker.sees_brute_force(500, texel), "side {side}, texel {texel}");
            }
        }
        if side <= 16 {
            assert_eq!(baker.bake(&()).unwrap().vertex(500), words);
        }
    }
}

#[test]
#[should_panic(expected = "visibility words of a vertex: expected length 6, got 5")]
fn one_vertex_wants_its_words() {
    let mesh = room(1);
    let baker = baker(&mesh, 8);
    baker.bake_vertex(0, &mut [0; 5], &mut baker.scratch());
}

#[test]
fn settings_and_words_are_checked() {
    for offset in [-1e-9, 1.1, f64::NAN, f64::INFINITY] {
        let settings = VisibilitySettings::default().with_offset(offset);
        assert!(matches!(VisibilityBaker::new(&room(1), grid(4), settings), Err(Error::OutOfRange { .. })));
    }
    assert!(BinaryVisibility::new(grid(8), vec![u64::MAX; 12]).is_ok());
    assert!(matches!(BinaryVisibility::new(grid(8), vec![0; 7]), Err(Error::Length { expected: 12, got: 7, .. })));
    assert!(matches!(BinaryVisibility::new(grid(3), vec![1 << 9; 6]), Err(Error::OutOfRange { .. })));
    assert!(BinaryVisibility::new(grid(3), vec![0x1ff; 6]).is_ok());
}

#[test]
fn soft_visibility_of_others_comes_in() {
    let mesh = Procedural::StackedSpheres.build(1_000).unwrap().mesh;
    for (side, samples) in [(1, 1), (4, 3), (3, 15)] {
        let baked = baker(&mesh, side).bake_fractional(samples, &()).unwrap();
        let counts = FractionalVisibility::from_counts(grid(side), samples, baked.counts().to_vec());
        assert_eq!(counts.as_ref(), Ok(&baked));
        let values: Vec<f32> = (0..baked.vertices()).flat_map(|v| baked.values(v)).collect();
        assert_eq!(FractionalVisibility::from_values(grid(side), samples, &values).as_ref(), Ok(&baked));
    }
    let of = |samples: usize, values: &[f32]| FractionalVisibility::from_values(grid(1), samples, values);
    let levels = of(2, &[0.0, 0.12, 0.13, 0.5, 0.88, 1.0]).unwrap();
    assert_eq!(levels.vertex(0), [0, 0, 1, 2, 4, 4]);
    assert_eq!(of(15, &[f32::MIN_POSITIVE, -0.0, 1e-45, 1.0 - 1e-7, 0.5, 1.0]).unwrap().counts()[3], 225);
    assert_eq!(of(3, &[]).unwrap().vertices(), 0);
    for (k, bad) in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY].into_iter().enumerate() {
        let mut values = [0.5; 12];
        values[k + 5] = bad;
        assert_eq!(of(4, &values), Err(Error::NotFinite { what: "visibility of a texel", index: k + 5 }));
    }
    for bad in [-1e-45, 1.000_001, f32::MAX] {
        assert!(matches!(of(4, &[0.0, 1.0, bad, 0.0, 0.0, 0.0]), Err(Error::OutOfRange { .. })), "{bad}");
    }
    assert!(matches!(of(4, &[0.0; 7]), Err(Error::Length { expected: 12, got: 7, .. })));
    let counts = |samples: usize, count: u8| FractionalVisibility::from_counts(grid(1), samples, vec![count; 6]);
    assert!(counts(4, 16).is_ok() && counts(15, 225).is_ok());
    assert!(matches!(counts(4, 17), Err(Error::OutOfRange { got: 17.0, .. })));
    for samples in [0, 16, usize::MAX] {
        assert!(matches!(counts(samples, 0), Err(Error::OutOfRange { .. })));
        assert!(matches!(of(samples, &[0.0; 6]), Err(Error::OutOfRange { .. })));
    }
    assert!(matches!(FractionalVisibility::from_counts(grid(1), 2, vec![0; 5]), Err(Error::Length { .. })));
}

#[cfg(feature = "rayon")]
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let mesh = Procedural::Table.build(1_500).unwrap().mesh;
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| (bake(&mesh, 16), baker(&mesh, 8).bake_fractional(2, &()).unwrap()))
    };
    let one = on(1);
    assert!(on(2) == one && on(5) == one);
}

#[derive(Default)]
struct Watch {
    most: AtomicUsize,
    total: AtomicUsize,
    calls: AtomicUsize,
    stop_after: Option<usize>,
    stopped: AtomicBool,
}

impl Progress for Watch {
    fn advance(&self, done: usize, total: usize) {
        self.most.fetch_max(done, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
        self.calls.fetch_add(1, Ordering::Relaxed);
    }
    fn is_cancelled(&self) -> bool {
        let stop = self.stop_after.is_some_and(|n| self.calls.load(Ordering::Relaxed) >= n);
        self.stopped.fetch_or(stop, Ordering::Relaxed);
        stop
    }
}

#[test]
fn progress_reaches_its_total() {
    let mesh = Procedural::BasRelief.build(3_000).unwrap().mesh;
    let watch = Watch::default();
    baker(&mesh, 4).bake(&watch).unwrap();
    let vertices = mesh.positions().len();
    assert_eq!((watch.most.into_inner(), watch.total.into_inner()), (vertices, vertices));
    let calls = watch.calls.into_inner();
    assert!((100..=256).contains(&calls), "{calls}");
}

#[test]
fn baking_stops_when_told() {
    let mesh = Procedural::BasRelief.build(3_000).unwrap().mesh;
    for stop_after in [0, 3] {
        let watch = Watch { stop_after: Some(stop_after), ..Watch::default() };
        assert_eq!(baker(&mesh, 4).bake(&watch), Err(Error::Cancelled));
        assert!(watch.stopped.into_inner());
        assert!(watch.calls.into_inner() < 100);
        let watch = Watch { stop_after: Some(stop_after), ..Watch::default() };
        assert_eq!(baker(&mesh, 4).bake_fractional(2, &watch), Err(Error::Cancelled));
    }
}
