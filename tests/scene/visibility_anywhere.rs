//! Visibility from any point, in any frame, of any directions, past any objects: against every face, the naive twin,
//! and geometry that is known.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use haarmonic::nalgebra::{Isometry3, Translation3, UnitQuaternion, UnitVector3, Vector3};
use haarmonic::reference::scene as naive;
use haarmonic::scene::{
    BackFaces, Bvh, Directions, LocalFrame, Mesh, Occluders, Procedural, Viewpoint, VisibilityTracer,
};
use haarmonic::sphere::{CubeGrid, TopFace};
use haarmonic::{Error, strategies};
use proptest::prelude::*;

use super::visibility::nearest_edge;
use crate::support::{Watch, cases, grid, soup};

type Pose = Isometry3<f64>;

/// A tracer past meshes that stand at poses.
fn tracer(objects: &[(Mesh, Pose)], directions: Directions, back_faces: BackFaces) -> VisibilityTracer {
    let objects = objects.iter().map(|(mesh, pose)| (Arc::new(Bvh::new(mesh)), *pose));
    VisibilityTracer::new(Occluders::new(objects).unwrap().with_back_faces(back_faces), directions)
}

fn trace(tracer: &VisibilityTracer, viewpoint: &Viewpoint) -> Vec<bool> {
    let mut words = vec![u64::MAX; tracer.directions().words()];
    tracer.trace(viewpoint, &mut words, &mut tracer.scratch());
    let ones: u32 = words.iter().map(|w| w.count_ones()).sum();
    let directions = tracer.directions();
    let bit = |i: usize| words[directions.bit(i) / 64] >> (directions.bit(i) % 64) & 1 == 1;
    let map: Vec<bool> = (0..directions.len()).map(bit).collect();
    assert_eq!(ones as usize, map.iter().filter(|b| **b).count(), "spare bits");
    map
}

fn pose() -> impl Strategy<Value = Pose> {
    let shift = prop::array::uniform3(-1.0..1.0_f64).prop_map(|t| Translation3::from(Vector3::from(t)));
    let turn = prop_oneof![
        Just(UnitQuaternion::identity()),
        strategies::rotation().prop_map(|r| UnitQuaternion::from_rotation_matrix(&r)),
    ];
    (shift, turn).prop_map(|(shift, turn)| Pose::from_parts(shift, turn))
}

/// One to three objects of loose triangles.
fn objects() -> impl Strategy<Value = Vec<(Mesh, Pose)>> {
    let object = (strategies::triangle_soup(12), pose()).prop_map(|(mesh, pose)| {
        // All of the size of the viewpoints' surroundings.
        let size = mesh.bounds().min.amax().max(mesh.bounds().max.amax());
        let positions = mesh.positions().iter().map(|p| p * (2.0 / size)).collect();
        (Mesh::new(positions, mesh.faces().to_vec()).unwrap(), pose)
    });
    prop::collection::vec(object, 1..4)
}

fn back_faces() -> impl Strategy<Value = BackFaces> {
    prop::sample::select(vec![BackFaces::Occlude, BackFaces::Ignore])
}

proptest! {
    #![proptest_config(cases(64))]

    /// Whatever the walk leaves out cannot matter.
    #[test]
    fn fast_path_has_the_bits_of_brute_force(
        objects in objects(), view in strategies::viewpoint(), directions in strategies::directions(),
        back_faces in back_faces(),
    ) {
        let tracer = tracer(&objects, directions, back_faces);
        let map = trace(&tracer, &view);
        for i in 0..map.len() {
            prop_assert_eq!(map[i], tracer.sees_brute_force(&view, i), "element {}", i);
        }
    }

    /// The twin in `f64` says the same but at edges, within the bound that their widening is documented to have.
    #[test]
    fn fast_path_agrees_with_the_naive_twin(
        objects in objects(), view in strategies::viewpoint(), directions in strategies::directions(),
        back_faces in back_faces(),
    ) {
        let tracer = tracer(&objects, directions.clone(), back_faces);
        let map = trace(&tracer, &view);
        let borrowed: Vec<_> = objects.iter().map(|(mesh, pose)| (mesh, *pose)).collect();
        for i in 0..map.len() {
            let Some(direction) = directions.direction(i) else {
                prop_assert!(!map[i]);
                continue;
            };
            if map[i] == naive::is_free(&borrowed, &view, &direction, back_faces) {
                continue;
            }
            let world = view.frame().map_or(*direction, |frame| frame.to_world(&direction));
            // The rounding of a direction, and of the horizon's place among rounded ones.
            let at_horizon = view.horizon().is_some_and(|n| n.dot(&world).abs() < 1e-6 * n.norm());
            let near = objects.iter().map(|(mesh, pose)| {
                let origin = pose.inverse_transform_point(&view.position().into()).coords;
                // The origin as it is used.
                let origin = origin.cast::<f32>().cast::<f64>();
                nearest_edge(mesh, &origin, &pose.inverse_transform_vector(&world))
            });
            let near = near.fold(f64::INFINITY, f64::min);
            // A top face of size 12 widens by 6 √3.
            prop_assert!(at_horizon || near < 12.0, "element {}: {} of the bound", i, near);
        }
    }

    /// A map of several samples is the sum of the map of its parts.
    #[test]
    fn counts_are_sums_over_parts(
        mesh in strategies::triangle_soup(12), view in strategies::viewpoint(), cells in 1..9_usize, samples in 1..5_usize,
    ) {
        let fine = cells * samples;
        let pairs = [
            (Directions::disk(cells).unwrap(), Directions::disk(fine).unwrap()),
            (Directions::square(cells).unwrap(), Directions::square(fine).unwrap()),
            (
                Directions::top_face(TopFace::new(3.0, cells).unwrap()),
                Directions::top_face(TopFace::new(3.0, fine).unwrap()),
            ),
        ];
        let occluders = Arc::new(Occluders::of_mesh(&mesh));
        for (coarse, fine_directions) in pairs {
            let coarse = VisibilityTracer::new(Arc::clone(&occluders), coarse.with_samples(samples).unwrap());
            let map = trace(&VisibilityTracer::new(Arc::clone(&occluders), fine_directions.clone()), &view);
            let (mut want, mut most) = (vec![0_u8; cells * cells], vec![0_u8; cells * cells]);
            for i in 0..map.len() {
                let element = i / fine / samples * cells + i % fine / samples;
                want[element] += u8::from(map[i]);
                most[element] += u8::from(fine_directions.direction(i).is_some());
            }
            let mut counts = vec![77; cells * cells];
            coarse.count(&view, &mut counts, &mut coarse.scratch());
            prop_assert_eq!(&counts, &want);
            prop_assert_eq!(coarse.directions().sample_counts(), most);
        }
    }
}

/// The world turned as a whole, objects and viewpoints, shows the same picture.
#[test]
fn a_scene_that_moves_with_its_viewer_looks_the_same() {
    let robot: Vec<(Mesh, Pose)> = [(0.0, 0.3), (1.5, -1.0), (-1.0, 2.0)]
        .map(|(x, angle)| {
            let mesh = Procedural::StackedSpheres.build(1_000).unwrap().mesh;
            (mesh, Pose::new(Vector3::new(x, 0.1 * x, -x), Vector3::new(angle, 0.2, -angle)))
        })
        .to_vec();
    let motion = Pose::new(Vector3::new(3.0, -40.0, 7.0), Vector3::new(0.4, 2.0, -1.1));
    let moved: Vec<_> = robot.iter().map(|(mesh, pose)| (mesh.clone(), motion * pose)).collect();
    let turned = |v: Vector3<f32>| (motion.rotation * v.cast::<f64>()).cast::<f32>();
    let kinds = [
        Directions::cube(grid(16)),
        Directions::disk(24).unwrap(),
        Directions::square(16).unwrap(),
        Directions::top_face(TopFace::new(10.0, 16).unwrap()),
    ];
    let (mut rays, mut hidden, mut differ) = (0, 0, 0);
    for directions in kinds {
        let (here, there) =
            (tracer(&robot, directions.clone(), BackFaces::Occlude), tracer(&moved, directions, BackFaces::Occlude));
        for k in 0..40 {
            let place = Vector3::new((k as f64 * 0.7).sin(), 0.02 * k as f64, (k as f64 * 1.3).cos()) * 2.0;
            let frame = LocalFrame::around(&UnitVector3::new_normalize(Vector3::new(0.3 * k as f64 - 4.0, 1.0, 0.5)));
            let view = Viewpoint::new(place).unwrap().with_frame(frame).unwrap();
            let frame = LocalFrame {
                tangent: turned(frame.tangent),
                bitangent: turned(frame.bitangent),
                normal: turned(frame.normal),
            };
            let moved = Viewpoint::new((motion * haarmonic::nalgebra::Point3::from(place)).coords).unwrap();
            let (a, b) = (trace(&here, &view), trace(&there, &moved.with_frame(frame).unwrap()));
            rays += a.len();
            differ += a.iter().zip(&b).filter(|(a, b)| a != b).count();
            hidden += a.iter().filter(|free| !**free).count();
        }
    }
    assert!(hidden * 10 > rays && hidden * 10 < 9 * rays, "{hidden} of {rays}");
    assert!(differ * 2000 < rays, "{differ} of {rays}");
}

/// Maps of equal areas see the share of the hemisphere that a very fine cube map sees, each in its own way.
#[test]
fn maps_of_any_kind_see_the_same_share() {
    let sphere = Procedural::StackedSpheres.build(4_000).unwrap().mesh;
    let occluders = Arc::new(Occluders::of_mesh(&sphere));
    let place = Viewpoint::new(Vector3::new(2.5, 0.4, 1.0)).unwrap();
    let towards = UnitVector3::new_normalize(Vector3::new(-2.5, 0.1, -0.7));
    let view = place.with_frame(LocalFrame::around(&towards)).unwrap().with_horizon(towards.into_inner()).unwrap();
    let share = |directions: Directions| {
        let tracer = VisibilityTracer::new(Arc::clone(&occluders), directions);
        let map = trace(&tracer, &view);
        let total = (0..map.len()).filter(|&i| tracer.directions().direction(i).is_some_and(|d| d.z > 0.0)).count();
        map.iter().filter(|b| **b).count() as f64 / total as f64
    };
    let fine = {
        let tracer = VisibilityTracer::new(Arc::clone(&occluders), Directions::cube(grid(256)));
        let (map, omega) = (trace(&tracer, &view), grid(256).face_solid_angles());
        map.iter().enumerate().filter(|(_, b)| **b).map(|(i, _)| omega[i % omega.len()]).sum::<f64>() / (2.0 * PI)
    };
    assert!(fine > 0.3 && fine < 0.9, "{fine}");
    for (name, share, tolerance) in [
        ("disk", share(Directions::disk(256).unwrap()), 5e-4),
        ("square", share(Directions::square(256).unwrap()), 1e-3),
        ("few on the disk", share(Directions::disk(32).unwrap()), 1e-2),
    ] {
        assert!((share - fine).abs() < tolerance, "{name}: {share} against {fine}");
    }
}

#[test]
fn one_object_of_several_and_objects_that_move() {
    let mesh = soup(20);
    let poses = [Pose::identity(), Pose::translation(3.0, 0.0, 0.5), Pose::rotation(Vector3::new(0.1, 0.2, 0.3))];
    let bvh = Arc::new(Bvh::new(&mesh));
    let all = Occluders::new(poses.map(|pose| (Arc::clone(&bvh), pose))).unwrap();
    let directions = Directions::cube(grid(12));
    let view = Viewpoint::new(Vector3::new(1.0, 0.3, -0.2)).unwrap();
    let map = |occluders: Occluders| trace(&VisibilityTracer::new(occluders, directions.clone()), &view);
    let each: Vec<Vec<bool>> = (0..3).map(|k| map(all.only(k))).collect();
    let together: Vec<bool> = (0..directions.len()).map(|i| each.iter().all(|one| one[i])).collect();
    assert_eq!(map(all.clone()), together);
    assert!(each[0] != each[1] && each[1] != each[2]);
    // The first where the second was.
    let mut moved = all.only(0);
    moved.set_pose(0, poses[1]).unwrap();
    assert_eq!(map(moved.clone()), each[1]);
    let bad = Pose::translation(f64::NAN, 0.0, 0.0);
    assert_eq!(moved.set_pose(0, bad), Err(Error::NotFinite { what: "pose of an occluder", index: 0 }));
    assert_eq!((map(moved.clone()), moved.pose(0)), (each[1].clone(), poses[1]));
    // Single rays through the same objects.
    for i in (0..directions.len()).step_by(7) {
        let direction = directions.direction(i).unwrap();
        let hit = all.closest_hit(&view.position(), &direction);
        assert_eq!(hit.is_some(), all.any_hit(&view.position(), &direction));
        if let Some((object, hit)) = hit {
            assert!(!each[object][i] && hit.distance > 0.0);
            let point = view.position() + direction.into_inner() * hit.distance;
            let local = poses[object].inverse_transform_point(&point.into()).coords;
            let corners = mesh.corners(hit.face as usize).map(|p| p.cast::<f64>());
            let on_face: Vector3<f64> = (0..3).map(|k| corners[k] * f64::from(hit.barycentric[k])).sum();
            assert!((on_face - local).norm() < 1e-5, "{on_face} {local}");
        }
    }
    assert!(matches!(Occluders::new([]), Err(Error::Empty { .. })));
    assert!(matches!(Occluders::new([(bvh, bad)]), Err(Error::NotFinite { index: 0, .. })));
}

/// Vertices of a mesh look along the world's axes as the baker has them.
#[test]
fn vertices_see_what_the_baker_says() {
    let mesh = Procedural::Table.build(1_000).unwrap().mesh;
    let baker = crate::support::baker(&mesh, 9);
    let baked = baker.bake(&()).unwrap();
    let views = Viewpoint::of_vertices(&mesh, 1.0 / 65536.0).unwrap();
    let tracer = VisibilityTracer::new(Occluders::of_mesh(&mesh), Directions::cube(grid(9)));
    assert_eq!(tracer.trace_batch(&views, &()).unwrap(), baked.words());
    // In another frame, the same directions one by one.
    let list: Vec<UnitVector3<f64>> = grid(9).directions();
    let as_list = VisibilityTracer::new(Occluders::of_mesh(&mesh), Directions::list(list).unwrap());
    let differ: usize = (0..views.len())
        .step_by(17)
        .map(|v| trace(&as_list, &views[v]).iter().enumerate().filter(|(i, b)| **b != baked.sees(v, *i)).count())
        .sum();
    // Directions exactly along an edge of the table may fall to either side.
    assert!(differ < views.len() / 17 * 486 / 2000, "{differ}");
}

#[test]
fn maps_are_streamed_once_each_and_stop_when_told() {
    let mesh = Procedural::BasRelief.build(1_000).unwrap().mesh;
    let views = Viewpoint::of_vertices(&mesh, 1.0 / 65536.0).unwrap();
    let tracer = VisibilityTracer::new(Occluders::of_mesh(&mesh), Directions::disk(10).unwrap());
    let local = |i: usize| views[i].with_frame(mesh.local_frame(i));
    let all: Vec<Viewpoint> = (0..views.len()).map(|i| local(i).unwrap()).collect();
    let stored = tracer.trace_batch(&all, &()).unwrap();
    let (seen, watch) = (Mutex::new(vec![0; views.len()]), Watch::new(views.len()));
    tracer
        .for_each(views.len(), local, &watch, |i, words| {
            assert_eq!(words, &stored[2 * i..2 * i + 2]);
            seen.lock().unwrap()[i] += 1;
        })
        .unwrap();
    assert!(seen.into_inner().unwrap().iter().all(|n| *n == 1));
    assert_eq!(watch.largest(), views.len());

    let calls = AtomicUsize::new(0);
    let stop = Watch::stopping_after(64, views.len());
    let stopped = tracer.for_each(views.len(), local, &stop, |_, _| {
        calls.fetch_add(1, Ordering::Relaxed);
    });
    assert_eq!(stopped, Err(Error::Cancelled));
    assert!(calls.into_inner() < views.len());
    assert_eq!(tracer.trace_batch(&all, &Watch::stopping_after(0, all.len())), Err(Error::Cancelled));
    // What a viewpoint refuses comes out.
    let refused = tracer.for_each(3, |_| Viewpoint::new(Vector3::repeat(f64::NAN)), &(), |_, _| {});
    assert!(matches!(refused, Err(Error::NotFinite { .. })));
    assert_eq!(tracer.for_each(0, local, &(), |_, _| panic!("nothing to see")), Ok(()));

    let soft = VisibilityTracer::new(Arc::clone(tracer.occluders()), tracer.directions().with_samples(3).unwrap());
    let counts = soft.count_batch(&all, &()).unwrap();
    soft.for_each_fractional(all.len(), local, &(), |i, got| assert_eq!(got, &counts[100 * i..100 * (i + 1)])).unwrap();
    let most = soft.directions().sample_counts();
    assert!(counts.chunks(100).all(|map| map.iter().zip(&most).all(|(c, m)| c <= m)));
}

#[test]
fn edges_of_what_can_be_asked() {
    for cells in [0, Directions::MAX_CELLS + 1, usize::MAX] {
        assert!(matches!(Directions::disk(cells), Err(Error::OutOfRange { .. })));
        assert!(matches!(Directions::square(cells), Err(Error::OutOfRange { .. })));
    }
    assert!(matches!(Directions::list(vec![]), Err(Error::Empty { .. })));
    let nan = UnitVector3::new_unchecked(Vector3::new(0.0, f64::NAN, 1.0));
    assert!(matches!(Directions::list(vec![Vector3::x_axis(), nan]), Err(Error::NotFinite { index: 1, .. })));
    let one = Directions::list(vec![-Vector3::y_axis()]).unwrap();
    assert_eq!((one.len(), one.words(), one.bit(0), one.direction(0)), (1, 1, 0, Some(-Vector3::y_axis())));
    assert!(one.with_samples(1).is_ok() && one.with_samples(2).is_err());
    for samples in [0, 16] {
        assert!(matches!(Directions::disk(2).unwrap().with_samples(samples), Err(Error::OutOfRange { .. })));
    }
    assert!(Directions::disk(Directions::MAX_CELLS).unwrap().with_samples(2).is_err());
    assert!(Directions::cube(CubeGrid::new(CubeGrid::MAX_SIDE).unwrap()).with_samples(2).is_err());
    // One cell looks straight up.
    for directions in [Directions::disk(1).unwrap(), Directions::square(1).unwrap()] {
        assert!((directions.direction(0).unwrap().into_inner() - Vector3::z()).norm() < 1e-15);
    }

    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(matches!(Viewpoint::new(Vector3::new(0.0, 0.0, bad)), Err(Error::NotFinite { index: 2, .. })));
        let at = Viewpoint::new(Vector3::zeros()).unwrap();
        assert!(matches!(at.with_horizon(Vector3::new(bad, 0.0, 0.0)), Err(Error::NotFinite { index: 0, .. })));
        let mut frame = LocalFrame::around(&Vector3::z_axis());
        frame.tangent.x = bad as f32;
        assert!(matches!(at.with_frame(frame), Err(Error::OutOfRange { .. })));
    }
    let skew = LocalFrame { tangent: Vector3::x(), bitangent: Vector3::new(0.1, 1.0, 0.0), normal: Vector3::z() };
    assert!(Viewpoint::new(Vector3::zeros()).unwrap().with_frame(skew).is_err());
    for offset in [-1e-9, 1.1, f64::NAN] {
        assert!(matches!(Viewpoint::of_vertices(&soup(1), offset), Err(Error::OutOfRange { .. })));
    }

    // From very far away nothing is in the way; a horizon of no length hides everything.
    let tracer = VisibilityTracer::new(Occluders::of_mesh(&soup(5)), Directions::cube(grid(3)));
    for far in [1e30, f64::MAX] {
        assert!(trace(&tracer, &Viewpoint::new(Vector3::repeat(far)).unwrap()).iter().all(|free| *free));
    }
    let nowhere = Viewpoint::new(Vector3::zeros()).unwrap().with_horizon(Vector3::zeros()).unwrap();
    assert!(trace(&tracer, &nowhere).iter().all(|free| !free));
    // Top faces as small and as large as they come.
    for size in [1e-6, 1e6] {
        let face = Directions::top_face(TopFace::new(size, 5).unwrap());
        let view = Viewpoint::new(Vector3::new(0.1, 5.0, 0.2)).unwrap();
        let tracer = VisibilityTracer::new(Occluders::of_mesh(&soup(5)), face);
        let up = view.with_frame(LocalFrame::around(&Vector3::y_axis())).unwrap();
        assert!(trace(&tracer, &up).iter().all(|free| *free), "size {size}");
    }
}

#[test]
#[should_panic(expected = "words of a visibility map: expected length 1, got 2")]
fn a_map_wants_its_words() {
    let tracer = VisibilityTracer::new(Occluders::of_mesh(&soup(1)), Directions::disk(4).unwrap());
    tracer.trace(&Viewpoint::new(Vector3::zeros()).unwrap(), &mut [0; 2], &mut tracer.scratch());
}

#[cfg(feature = "rayon")]
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let mesh = Procedural::Table.build(1_000).unwrap().mesh;
    let views = Viewpoint::of_vertices(&mesh, 1.0 / 65536.0).unwrap();
    let tracer = VisibilityTracer::new(Occluders::of_mesh(&mesh), Directions::square(8).unwrap());
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| tracer.trace_batch(&views, &()).unwrap())
    };
    assert!(on(1) == on(2) && on(1) == on(5));
}
