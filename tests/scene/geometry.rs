//! Meshes, built-in scenes, cameras and pictures.

use std::collections::HashMap;

use approx::assert_relative_eq;
use haarmonic::Error;
use haarmonic::nalgebra::{Affine3, Matrix4, Vector2, Vector3};
use haarmonic::reference::scene as naive;
use haarmonic::scene::{BackFaces, Bvh, Camera, Mesh, MeshRepair, Picture, PixelSample, Procedural};

type V = Vector3<f32>;

fn square() -> (Vec<V>, Vec<[u32; 3]>) {
    let corners = [[0., 0., 0.], [0., 0., 1.], [1., 0., 1.], [1., 0., 0.]].map(V::from);
    (corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
}

#[test]
fn parts_that_do_not_fit_are_errors() {
    let (positions, faces) = square();
    assert_eq!(Mesh::new(vec![], faces.clone()), Err(Error::Empty { what: "mesh vertices" }));
    assert_eq!(Mesh::new(positions.clone(), vec![]), Err(Error::Empty { what: "mesh faces" }));
    let error = Mesh::new(positions.clone(), vec![[0, 1, 2], [0, 1, 4]]).unwrap_err();
    assert_eq!(error, Error::Index { what: "vertex index of mesh face", at: 1, got: 4, count: 4 });
    assert_eq!(error.to_string(), "vertex index of mesh face 1 must be below 4, got 4");
    let mut broken = positions.clone();
    broken[2].y = f32::INFINITY;
    assert!(matches!(Mesh::new(broken, faces.clone()), Err(Error::NotFinite { index: 2, .. })));
    let short = Mesh::with_normals(positions.clone(), vec![V::y()], faces.clone());
    assert!(matches!(short, Err(Error::Length { expected: 4, got: 1, .. })));
    let mesh = Mesh::new(positions, faces).unwrap();
    assert!(matches!(mesh.with_tangents(vec![]), Err(Error::Length { expected: 4, got: 0, .. })));
}

#[test]
fn unusable_normals_come_from_the_faces() {
    let (positions, faces) = square();
    let given = vec![V::zeros(), V::repeat(f32::NAN), V::new(0.0, 3e30, 4e30), V::new(0.0, 0.0, -1e-30)];
    let mesh = Mesh::with_normals(positions, given, faces).unwrap();
    let expected = [V::y(), V::y(), V::new(0.0, 0.6, 0.8), -V::z()];
    mesh.normals().iter().zip(expected).for_each(|(n, e)| assert_relative_eq!(*n, e, max_relative = 1e-6));
}

#[test]
fn tangents_are_made_perpendicular() {
    let (positions, faces) = square();
    let given = vec![V::new(2.0, 5.0, 0.0), V::y(), V::repeat(f32::NAN), V::zeros()];
    let mesh = Mesh::new(positions, faces).unwrap().with_tangents(given).unwrap();
    assert_relative_eq!(mesh.tangents()[0], V::x(), max_relative = 1e-6);
    for v in 0..4 {
        let frame = mesh.local_frame(v);
        assert!((frame.tangent.norm() - 1.0).abs() < 1e-6 && frame.tangent.dot(&frame.normal).abs() < 1e-6);
        assert_relative_eq!(frame.tangent.cross(&frame.bitangent), frame.normal, epsilon = 1e-6);
    }
}

#[test]
fn repair_says_what_it_did() {
    let (mut positions, mut faces) = square();
    positions.push(V::new(f32::NAN, 0.0, 0.0));
    positions.push(V::new(0.5, 0.0, 0.5));
    faces.extend([[0, 0, 1], [0, 5, 2], [0, 1, 77], [1, 4, 2], [2, 2, 2]]);
    let mut normals = vec![V::y(); 5];
    normals[1] = V::zeros();
    let (mesh, notes) = Mesh::repair(positions, Some(normals), faces).unwrap();
    assert_eq!(mesh.faces(), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.positions().len(), 6);
    assert_eq!(mesh.positions()[4], V::zeros());
    let expected = [
        MeshRepair::OutOfRangeFaces { count: 1, first: 4 },
        MeshRepair::NonFinitePositions { count: 1, first: 4 },
        MeshRepair::DegenerateFaces { count: 3, first: 2 },
        MeshRepair::Normals { count: 2, first: 1 },
    ];
    assert_eq!(notes, expected);
    let (positions, faces) = square();
    let (mesh, notes) = Mesh::repair(positions.clone(), None, faces.clone()).unwrap();
    assert!(notes.is_empty());
    assert_eq!(mesh, Mesh::new(positions, faces).unwrap());
}

#[test]
fn nothing_left_to_repair_is_an_error() {
    let (positions, _) = square();
    assert!(matches!(Mesh::repair(positions.clone(), None, vec![]), Err(Error::Empty { .. })));
    assert!(matches!(Mesh::repair(positions, None, vec![[0, 0, 0], [9, 9, 9]]), Err(Error::Empty { .. })));
    assert!(matches!(Mesh::repair(vec![], None, vec![[0, 1, 2]]), Err(Error::Empty { .. })));
    let nan = vec![V::repeat(f32::NAN); 3];
    assert!(matches!(Mesh::repair(nan, None, vec![[0, 1, 2]]), Err(Error::Empty { .. })));
}

#[test]
fn bounds_and_areas() {
    let (mut positions, faces) = square();
    positions.push(V::repeat(1e20));
    let mesh = Mesh::new(positions, faces).unwrap();
    // The vertex without a face does not count.
    assert_eq!((mesh.bounds().min, mesh.bounds().max), (V::zeros(), V::new(1.0, 0.0, 1.0)));
    assert!((mesh.bounds().radius() - 0.5_f64.sqrt()).abs() < 1e-15);
    assert_eq!(mesh.face_areas(), [0.5, 0.5]);
    assert!((mesh.vertex_areas().iter().sum::<f64>() - 1.0).abs() < 1e-15);
    assert_eq!(mesh.vertex_areas()[4], 0.0);
}

#[test]
fn a_mirrored_mesh_keeps_its_outside() {
    let mesh = Procedural::StackedSpheres.build(1_000).unwrap().mesh;
    let mirror = Matrix4::new_nonuniform_scaling(&Vector3::new(-2.0, 1.0, 0.5)).append_translation(&Vector3::x());
    let mirrored = mesh.transformed(&Affine3::from_matrix_unchecked(mirror)).unwrap();
    for face in 0..mirrored.faces().len() {
        let [a, b, c] = mirrored.corners(face);
        let normal = mirrored.normals()[mirrored.faces()[face][0] as usize];
        assert!((b - a).cross(&(c - a)).dot(&normal) > 0.0, "face {face}");
    }
    let back = mirrored.transformed(&Affine3::from_matrix_unchecked(mirror.try_inverse().unwrap())).unwrap();
    assert_relative_eq!(back, mesh, epsilon = 2e-6);
    let flat = Affine3::from_matrix_unchecked(Matrix4::new_nonuniform_scaling(&Vector3::new(1.0, 0.0, 1.0)));
    assert!(matches!(mesh.transformed(&flat), Err(Error::OutOfRange { got: 0.0, .. })));
}

#[test]
fn merged_meshes_follow_each_other() {
    let (positions, faces) = square();
    let mesh = Mesh::new(positions, faces).unwrap();
    let both = Mesh::merge([&mesh, &mesh]).unwrap();
    assert_eq!(both.faces()[2..], [[4, 5, 6], [4, 6, 7]]);
    assert_eq!(both.positions().len(), 8);
    assert!(matches!(Mesh::merge([]), Err(Error::Empty { .. })));
}

#[test]
fn built_in_scenes_hit_their_vertex_count() {
    for scene in Procedural::ALL {
        for target in [1_000, 1_700, 10_000, 100_000, 600_000] {
            if target > 100_000 && scene != Procedural::TorusKnotOnFloor {
                continue;
            }
            let model = scene.build(target).unwrap();
            let vertices = model.mesh.positions().len();
            assert!(vertices.abs_diff(target) * 10 <= target, "{}: {vertices} for {target}", scene.name());
            assert_eq!(model.parts.len(), vertices);
            assert!(model.parts.iter().all(|&p| (p as usize) < model.part_names.len()));
        }
        assert_eq!(scene.build(2_000).unwrap(), scene.build(2_000).unwrap());
        assert_eq!(Procedural::from_name(scene.name()), Some(scene));
        assert!(scene.build(999).is_err() && scene.build(2_000_001).is_err());
    }
}

#[test]
fn built_in_faces_look_outwards() {
    for scene in Procedural::ALL {
        for vertices in [1_000, 20_000] {
            let mesh = scene.build(vertices).unwrap().mesh;
            let mut wrong = 0;
            for (face, indices) in mesh.faces().iter().enumerate() {
                let [a, b, c] = mesh.corners(face);
                let across = (b - a).cross(&(c - a));
                wrong += indices.iter().filter(|&&i| across.dot(&mesh.normals()[i as usize]) <= 0.0).count();
            }
            // A coarse relief has cells that a whole carved edge crosses: 1.8 % of the corners at worst.
            let allowed = if scene == Procedural::BasRelief { 3 * mesh.faces().len() / 40 } else { 0 };
            assert!(wrong <= allowed, "{}: {wrong} of {}", scene.name(), mesh.faces().len());
        }
    }
}

#[test]
fn built_in_solids_are_closed() {
    for scene in [Procedural::TorusKnotOnFloor, Procedural::StackedSpheres, Procedural::Table] {
        for vertices in [1_000, 9_000] {
            let model = scene.build(vertices).unwrap();
            let mut edges: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
            for face in model.mesh.faces().iter().filter(|f| model.parts[f[0] as usize] > 0) {
                // −0 + 0 = 0: one set of bits for each position.
                let corners =
                    face.map(|i| <[f32; 3]>::from(model.mesh.positions()[i as usize]).map(|c| (c + 0.0).to_bits()));
                for k in 0..3 {
                    let (a, b) = (corners[k], corners[(k + 1) % 3]);
                    *edges.entry(if a < b { [a, b] } else { [b, a] }).or_default() += if a < b { 1 } else { -1 };
                }
            }
            let open = edges.values().filter(|&&n| n != 0).count();
            assert_eq!(open, 0, "{} with {vertices} vertices: of {} edges", scene.name(), edges.len());
        }
    }
}

#[test]
fn camera_projects_what_it_looks_along() {
    let eye = Vector3::new(1.0, 2.0, 5.0);
    let camera = Camera::look_at(eye, Vector3::new(0.0, 0.5, 0.0), Vector3::y(), 0.7).unwrap();
    for [x, y] in [[0.0, 0.0], [1.0, 0.0], [-0.3, 0.9], [1.7, -1.0]] {
        let seen = camera.project(&(eye + camera.direction(x, y).into_inner() * 3.0)).unwrap();
        assert!((seen[0] - x).abs() < 1e-14 && (seen[1] - y).abs() < 1e-14, "{seen:?}");
    }
    // y up, x to the right of somebody who looks along −z.
    let camera = Camera::look_at(Vector3::z(), Vector3::zeros(), Vector3::y(), 1.0).unwrap();
    assert!(camera.direction(0.5, 0.0).x > 0.0 && camera.direction(0.0, 0.5).y > 0.0);
    assert_eq!(camera.project(&Vector3::new(0.0, 0.0, 2.0)), None);
}

#[test]
fn camera_refuses_what_has_no_view() {
    let (o, z, up) = (Vector3::zeros(), Vector3::z(), Vector3::y());
    assert!(Camera::look_at(o, o, up, 1.0).is_err());
    assert!(Camera::look_at(z, o, up, 0.0).is_err());
    assert!(Camera::look_at(z, o, up, f64::NAN).is_err());
    assert!(matches!(Camera::look_at(z, o, up * f64::NAN, 1.0), Err(Error::NotFinite { index: 2, .. })));
    // Up along the view, or zero: another up.
    for up in [z, -z, o, z * 1e300] {
        let camera = Camera::look_at(z * 2.0, o, up, 1.0).unwrap();
        assert!((camera.direction(0.3, 0.4).norm() - 1.0).abs() < 1e-14);
    }
}

#[test]
fn framing_shows_every_vertex_and_little_more() {
    for scene in Procedural::ALL {
        let mesh = scene.build(1_000).unwrap().mesh;
        for (view, aspect) in [([0.3, 0.5, 1.0], 1.5), ([0.0, 1.0, 0.0], 1.0), ([-1.0, 0.1, 0.0], 0.4)] {
            let camera = Camera::framing(&mesh, &Vector3::from(view), &Vector3::y(), 0.6, aspect).unwrap();
            let most = mesh.positions().iter().fold(0.0_f64, |most, p| {
                let [x, y] = camera.project(&p.cast()).unwrap();
                most.max(x.abs() / aspect).max(y.abs())
            });
            assert!((0.9..=1.0).contains(&most), "{}: {most}", scene.name());
        }
    }
}

#[test]
fn rays_hit_what_the_naive_twin_hits() {
    let model = Procedural::Table.build(1_500).unwrap();
    let bvh = Bvh::new(&model.mesh);
    let (mut hits, mut different) = (0, 0);
    for i in 0..4_000_u32 {
        // A Weyl sequence over origins around the scene and targets in it.
        let at = |k: f64| (f64::from(i) * k).fract() * 2.0 - 1.0;
        let origin = Vector3::new(at(0.754_877), 0.6 + at(0.569_840), at(0.430_159)) * 1.5;
        let direction = Vector3::new(at(0.819_172), 0.4 + 0.4 * at(0.671_043), at(0.549_700)) - origin;
        let expected = naive::closest_hit(&model.mesh, &origin, &direction, BackFaces::Occlude);
        let found = bvh.closest_hit(&origin, &direction);
        assert_eq!(found.is_some(), bvh.any_hit(&origin, &direction));
        match (expected, found) {
            (Some((_, distance)), Some(hit)) => {
                hits += 1;
                // Roundings of f64 against the ray's slant on the face.
                different += u32::from((hit.distance - distance).abs() > 1e-11);
                let [a, b, c] = model.mesh.corners(hit.face as usize).map(|p| p.cast::<f64>());
                let [u, v, w] = hit.barycentric.map(f64::from);
                let point = origin + direction * hit.distance;
                let error = (a * u + b * v + c * w - point).norm();
                // Weights are f32.
                assert!(error < 5e-7, "{error}");
            }
            (None, None) => {}
            _ => different += 1,
        }
    }
    assert!(hits > 1_000, "{hits}");
    // Silhouettes to 1e-6 rad: none met by these rays.
    assert_eq!(different, 0);
}

#[test]
fn rays_that_are_none_hit_nothing() {
    let model = Procedural::StackedSpheres.build(1_000).unwrap();
    let bvh = Bvh::new(&model.mesh);
    let inside = Vector3::new(0.0, 0.4, 0.0);
    for direction in [Vector3::zeros(), Vector3::repeat(f64::NAN), Vector3::repeat(f64::INFINITY)] {
        assert_eq!(bvh.closest_hit(&inside, &direction), None);
        assert!(!bvh.any_hit(&inside, &direction));
    }
    assert_eq!(bvh.closest_hit(&Vector3::new(0.0, f64::NAN, 0.0), &Vector3::x()), None);
    assert_eq!(bvh.closest_hit(&inside, &Vector3::new(1.0, f64::NAN, 0.0)), None);
    assert_eq!(bvh.closest_hit(&Vector3::repeat(1e300), &-Vector3::x()), None);
    let far = bvh.closest_hit(&Vector3::new(0.0, 1e5, 0.05), &-Vector3::y()).unwrap();
    // The pile is 1.7 high; a distant origin costs no accuracy.
    let near = bvh.closest_hit(&Vector3::new(0.0, 10.0, 0.05), &-Vector3::y()).unwrap();
    assert!((far.distance - near.distance - 99_990.0).abs() < 1e-6, "{far:?} {near:?}");
}

#[test]
fn nothing_slips_through_a_closed_sphere() {
    // From inside a closed surface every ray must hit, also through edges and corners, which these aim at.
    let model = Procedural::StackedSpheres.build(3_000).unwrap();
    let bvh = Bvh::new(&model.mesh);
    let centre = Vector3::new(0.0, 0.4, 0.231);
    for face in (0..model.mesh.faces().len()).filter(|&f| model.parts[model.mesh.faces()[f][0] as usize] == 1) {
        let [a, b, c] = model.mesh.corners(face).map(|p| p.cast::<f64>());
        for target in [a, b, (a + b) * 0.5, (b + c) * 0.5, a * 0.9 + c * 0.1] {
            assert!(bvh.any_hit(&centre, &(target - centre)), "face {face}");
        }
    }
}

#[test]
fn picture_interpolates_colours() {
    // A unit square seen from above fills the picture; its colours are its positions.
    let (positions, faces) = square();
    let mesh = Mesh::new(positions.clone(), faces).unwrap();
    let fov = 2.0 * 0.5_f64.atan();
    let camera = Camera::look_at(Vector3::new(0.5, 1.0, 0.5), Vector3::new(0.5, 0.0, 0.5), -Vector3::z(), fov).unwrap();
    let picture = Picture::new(&mesh, &Bvh::new(&mesh), &camera, [16, 8], 3).unwrap();
    let pixels = picture.shade(&positions, |d| Vector3::repeat(-d.y as f32));
    for (i, pixel) in pixels.iter().enumerate() {
        let (x, y) = ((i % 16) as f32, (i / 16) as f32);
        if (4.0..12.0).contains(&x) {
            let expected = V::new((x - 4.0 + 0.5) / 8.0, 0.0, (y + 0.5) / 8.0);
            assert_relative_eq!(*pixel, expected, epsilon = 1e-5);
        } else {
            assert!(pixel.x > 0.5 && pixel.x == pixel.y, "sky at {x} {y}");
        }
    }
    let coverage = picture.coverage();
    assert_eq!(coverage.iter().sum::<f32>(), 64.0);
    assert!(Picture::new(&mesh, &Bvh::new(&mesh), &camera, [0, 8], 1).is_err());
    assert!(Picture::new(&mesh, &Bvh::new(&mesh), &camera, [8, 8], 17).is_err());
}

#[test]
#[should_panic(expected = "colours of a picture: expected length 4, got 3")]
fn picture_wants_one_colour_a_vertex() {
    let (positions, faces) = square();
    let mesh = Mesh::new(positions, faces).unwrap();
    let camera = Camera::framing(&mesh, &Vector3::y(), &Vector3::z(), 1.0, 1.0).unwrap();
    let _ = Picture::new(&mesh, &Bvh::new(&mesh), &camera, [2, 2], 1).unwrap().shade(&[V::x(); 3], |_| V::zeros());
}
/// What a picture shows is public: the place of every sample, and how it moves from pixel to pixel.
#[test]
fn hits_of_a_picture_are_places_of_the_mesh() {
    let model = Procedural::TorusKnotOnFloor.build(1_000).unwrap();
    let (mesh, bvh) = (&model.mesh, Bvh::new(&model.mesh));
    let picture = Picture::new(mesh, &bvh, &model.camera, [40, 30], 2).unwrap();
    assert_eq!((picture.size(), picture.samples()), ([40, 30], 2));
    let (mut seen, mut compared) = (0, 0);
    for (pixel, sample) in (0..40 * 30 * 4).map(|i| ([i / 4 % 40, i / 160], i % 4)) {
        let found = picture.sample(pixel, sample);
        assert_eq!((found.pixel, found.sample), (pixel, sample));
        let exact = bvh.closest_hit(&model.camera.eye(), &found.direction);
        assert_eq!(found.hit.map(|hit| hit.face), exact.map(|hit| hit.face));
        let differentials = picture.differentials(mesh, pixel, sample);
        let Some(hit) = found.hit else {
            assert_eq!(differentials, None);
            continue;
        };
        seen += 1;
        let place = hit.interpolate(mesh, mesh.positions()).cast::<f64>();
        let along = model.camera.eye() + found.direction.into_inner() * f64::from(hit.depth);
        assert!((place - along).norm() < 1e-4 * f64::from(hit.depth), "{pixel:?} {sample}");
        // To the same place of the next pixel, if that shows the same face: half of two central differences.
        let next = (pixel[0] + 1 < 40).then(|| picture.sample([pixel[0] + 1, pixel[1]], sample));
        if let (Some([right, down]), Some(PixelSample { hit: Some(next), .. })) = (differentials, next)
            && next.face == hit.face
        {
            compared += 1;
            let after = picture.differentials(mesh, [pixel[0] + 1, pixel[1]], sample).unwrap()[0];
            for k in 0..3 {
                let step = f64::from(next.barycentric[k] - hit.barycentric[k]);
                let mean = 0.5 * (right[k] + after[k]);
                assert!((step - mean).abs() < 0.02 * (1.0 + step.abs()), "{pixel:?}: {step} against {mean}");
            }
            assert!(right.iter().sum::<f64>().abs() < 1e-9 && down.iter().sum::<f64>().abs() < 1e-9);
        }
    }
    assert!(seen > 1000 && compared > 300, "{seen} {compared}");

    // A wall across the view: a pixel is 2 tan(fov/2)/height of its distance, everywhere.
    let corners = [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0]].map(Vector3::from);
    let wall = Mesh::new(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
    let camera = Camera::look_at(Vector3::z() * 2.0, Vector3::zeros(), Vector3::y(), 0.8).unwrap();
    let picture = Picture::new(&wall, &Bvh::new(&wall), &camera, [7, 5], 1).unwrap();
    let [right, down] = picture.differentials(&wall, [5, 1], 0).unwrap();
    let moved = |d: [f64; 3]| -> Vector3<f64> { (0..3).map(|k| wall.corners(0)[k].cast::<f64>() * d[k]).sum() };
    let pixel = 2.0 * 2.0 * 0.4_f64.tan() / 5.0;
    assert!((moved(right) - Vector3::x() * pixel).norm() < 1e-12, "{}", moved(right));
    assert!((moved(down) + Vector3::y() * pixel).norm() < 1e-12, "{}", moved(down));

    // Texture coordinates that are a multiple of the place have the footprint of a pixel.
    assert_eq!(picture.footprint(&wall, [5, 1], 0), None);
    let uv = wall.positions().iter().map(|p| p.xy() * 0.5).collect();
    let textured = wall.clone().with_uv(uv).unwrap();
    let footprint = picture.footprint(&textured, [5, 1], 0).unwrap();
    assert!((footprint.right - Vector2::new(0.5 * pixel, 0.0)).norm() < 1e-9, "{footprint:?}");
    assert!((footprint.down + Vector2::new(0.0, 0.5 * pixel)).norm() < 1e-9, "{footprint:?}");
    let place = picture.sample([5, 1], 0).hit.unwrap().interpolate(&wall, wall.positions());
    assert!((footprint.uv - place.xy().cast() * 0.5).norm() < 1e-6);

    // A colour a sample: its mean over a pixel.
    let depth = picture.shade_samples(|sample| Vector3::repeat(sample.hit.map_or(-1.0, |hit| hit.depth)));
    assert!((depth[2 * 7 + 3].x - 2.0).abs() < 1e-6);
}
