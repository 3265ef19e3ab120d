//! The built-in scenes of several objects.

use std::collections::HashMap;

use haarmonic::Error;
use haarmonic::nalgebra::{Point3, Vector3};
use haarmonic::scene::{Bvh, LocalLight, Mesh, Stage};

/// Whether every edge has as many faces that run along it one way as the other, corners at one place being one.
fn is_closed(mesh: &Mesh) -> bool {
    let mut first: HashMap<[u32; 3], u32> = HashMap::new();
    let place = |i: u32| <[f32; 3]>::from(mesh.positions()[i as usize]).map(|c| (c + 0.0).to_bits());
    (0..mesh.positions().len() as u32).for_each(|i| {
        first.entry(place(i)).or_insert(i);
    });
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for face in mesh.faces() {
        let corners = face.map(|i| first[&place(i)]);
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    edges.values().all(|sum| *sum == 0)
}

#[test]
fn stages_are_what_they_say() {
    let counts = [
        (Stage::Robot, 13, 0, 0),
        (Stage::KitchenTable, 6, 1, 0),
        (Stage::Street, 11, 6, 0),
        (Stage::WalkingFigure, 11, 0, 60),
        (Stage::Crowd, 161, 0, 960),
        (Stage::Temple, 19, 0, 0),
    ];
    assert_eq!(counts.map(|c| c.0), Stage::ALL);
    for (stage, objects, lights, spheres) in counts {
        let staged = stage.build(5_000, 0.3).unwrap();
        assert_eq!((staged.objects.len(), staged.lights.len()), (objects, lights), "{stage:?}");
        assert_eq!(staged.spheres.len(), spheres, "{stage:?}");
        assert_eq!(Stage::from_name(stage.name()), Some(stage));
        let mut shapes: Vec<&Mesh> = vec![];
        for object in &staged.objects {
            if !shapes.iter().any(|mesh| std::ptr::eq(*mesh, &*object.mesh)) {
                shapes.push(&object.mesh);
            }
            assert!(object.name == "ground" || is_closed(&object.mesh), "{stage:?}: {}", object.name);
        }
        assert!(staged.objects.iter().all(|object| object.mesh.uv().is_some()));
        let vertices: usize = shapes.iter().map(|mesh| mesh.positions().len()).sum();
        assert!((4_250..=5_750).contains(&vertices), "{stage:?}: {vertices}");
        // As one mesh, and as what stops rays: the same hits.
        let (merged, occluders) = (staged.merged().unwrap(), staged.occluders().unwrap());
        assert_eq!(occluders.len(), objects);
        let bvh = Bvh::new(&merged);
        let mut hits = 0;
        for k in 0..60 {
            let direction = Vector3::new((k as f64 * 0.9).sin() * 0.3, (k as f64 * 1.7).cos() * 0.2, 0.0)
                - (staged.camera.eye() - Vector3::y()).normalize();
            let (a, b) = (
                bvh.closest_hit(&staged.camera.eye(), &direction),
                occluders.closest_hit(&staged.camera.eye(), &direction),
            );
            let (a, b) = (a.map(|hit| hit.distance), b.map(|(_, hit)| hit.distance));
            hits += usize::from(a.is_some());
            let is_near = (a.unwrap_or(0.0) - b.unwrap_or(0.0)).abs() < 1e-4;
            assert!(a.is_some() == b.is_some() && is_near, "{stage:?}: {a:?} {b:?}");
        }
        assert!(hits > 20, "{stage:?}: {hits}");
        // Nothing reaches far below the ground.
        assert!(merged.bounds().min.y > -0.2, "{stage:?}: {}", merged.bounds().min.y);
    }
    for vertices in [0, 1_999, 2_000_001, usize::MAX] {
        assert!(matches!(Stage::Robot.build(vertices, 0.0), Err(Error::OutOfRange { .. })));
    }
    for phase in [f64::NAN, f64::INFINITY] {
        assert!(matches!(Stage::Crowd.build(4_000, phase), Err(Error::NotFinite { .. })));
    }
}

/// A walk is periodic and smooth, keeps its joints together and a foot on the ground.
#[test]
fn figures_walk() {
    let at = |phase: f64| Stage::WalkingFigure.build(2_500, phase).unwrap();
    let [a, b, c] = [0.2, 1.2, 0.201].map(at);
    for ((x, y), z) in a.objects.iter().zip(&b.objects).zip(&c.objects) {
        assert!((x.pose.to_homogeneous() - y.pose.to_homogeneous()).amax() < 1e-12, "{}", x.name);
        assert!((x.pose.to_homogeneous() - z.pose.to_homogeneous()).amax() < 0.02, "{}", x.name);
    }
    let joints = [
        ("left upper arm", "left forearm", 0.29),
        ("right upper arm", "right forearm", 0.29),
        ("left thigh", "left shin", 0.42),
        ("right thigh", "right shin", 0.42),
    ];
    for phase in [0.0, 0.1, 0.25, 0.4, 0.63, 0.9] {
        let staged = at(phase);
        let pose = |name: &str| staged.objects.iter().find(|object| object.name == name).unwrap().pose;
        for (upper, lower, length) in joints {
            let joint = pose(upper) * Point3::new(0.0, -length, 0.0);
            assert!((joint - pose(lower) * Point3::origin()).norm() < 1e-12, "{upper} at {phase}");
        }
        let lowest = staged.spheres.iter().map(|(centre, radius)| centre.y - radius).fold(f64::INFINITY, f64::min);
        assert!((0.0..0.03).contains(&lowest), "{phase}: {lowest}");
        assert!(staged.spheres.iter().all(|(centre, radius)| centre.y < 2.0 && *radius > 0.03 && *radius < 0.2));
    }
    let street = Stage::Street.build(3_000, 0.0).unwrap();
    assert!(street.lights.iter().all(|light| matches!(light, LocalLight::Spot(spot) if spot.position().y > 3.0)));
}
