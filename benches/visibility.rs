//! Visibility of one vertex: rays a second on the built-in scenes of 100,000 vertices, 64² texels a face unless said
//! otherwise.
//!
//! `local-cube`: the same texels in the vertex's frame. `faces-32`, `disk-32`, `top-face-32`: maps of fewer rays, which
//! share what it costs to walk the scene: 6 · 32², the disk's cells, and 32² cells of a plane of size 4.
//! `faces`: the baker, which traces a face of the cube at once. `ray`: the crate's single rays, one a texel above the
//! horizon. `obvhs-cwbvh`: the peer's eight-wide hierarchy with its own triangle test, any hit.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{
    Directions, Model, Procedural, Viewpoint, VisibilityBaker, VisibilitySettings, VisibilityTracer,
};
use haarmonic::sphere::{CubeGrid, TopFace};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::Ray;
use obvhs::triangle::Triangle;

/// Runs of 16 neighbours, as a bake visits them, spread over the mesh.
fn sample(vertices: usize) -> Vec<usize> {
    (0..vertices).step_by(vertices / 12).flat_map(|v| v..(v + 16).min(vertices)).collect()
}

/// Origin and directions of every ray.
fn rays(model: &Model, baker: &VisibilityBaker) -> Vec<(Vector3<f64>, Vec<Vector3<f64>>)> {
    let directions = baker.grid().directions();
    let one = |v: usize| {
        let normal = model.mesh.normals()[v].cast::<f64>();
        let above = directions.iter().filter(|d| normal.dot(d) > 0.0).map(|d| d.into_inner()).collect();
        (baker.origin(v), above)
    };
    sample(baker.vertices()).into_iter().map(one).collect()
}

/// Other maps at the same vertices, in their frames.
fn maps(group: &mut BenchmarkGroup<'_, WallTime>, model: &Model, baker: &VisibilityBaker, scene: &str) {
    let settings = VisibilitySettings::default();
    let views = Viewpoint::of_vertices(&model.mesh, settings.offset).unwrap();
    let occluders = Arc::clone(baker.tracer().occluders());
    let cube = |side: usize| Directions::cube(CubeGrid::new(side).unwrap());
    let face = TopFace::new(4.0, 32).unwrap();
    let kinds = [
        ("local-cube", cube(64), true),
        ("faces-32", cube(32), false),
        ("disk-32", Directions::disk(32).unwrap(), true),
        ("top-face-32", Directions::top_face(face), true),
    ];
    for (name, directions, is_local) in kinds {
        let tracer = VisibilityTracer::new(Arc::clone(&occluders), directions);
        let (mut words, mut scratch) = (vec![0; tracer.directions().words()], tracer.scratch());
        let view = |v: usize| match is_local {
            true => views[v].with_frame(model.mesh.local_frame(v)).unwrap(),
            false => views[v],
        };
        let views: Vec<Viewpoint> = sample(baker.vertices()).into_iter().map(view).collect();
        let count: u64 = views.iter().map(|view| tracer.trace(view, &mut words, &mut scratch)).sum();
        group.throughput(Throughput::Elements(count));
        group.bench_function(BenchmarkId::new(name, scene), |b| {
            b.iter(|| {
                for view in &views {
                    tracer.trace(view, &mut words, &mut scratch);
                    black_box(&words);
                }
            });
        });
    }
}

fn visibility(c: &mut Criterion) {
    for scene in Procedural::ALL {
        let model = scene.build(100_000).unwrap();
        let grid = CubeGrid::new(64).unwrap();
        let baker = VisibilityBaker::new(&model.mesh, grid, VisibilitySettings::default()).unwrap();
        let rays = rays(&model, &baker);
        let count: usize = rays.iter().map(|(_, directions)| directions.len()).sum();
        let mut group = c.benchmark_group("visibility");
        group.sample_size(10).throughput(Throughput::Elements(count as u64));
        group.warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(4));

        let (mut words, mut scratch) = (vec![0; baker.words_per_vertex()], baker.scratch());
        let vertices = sample(baker.vertices());
        group.bench_function(BenchmarkId::new("faces", scene.name()), |b| {
            b.iter(|| {
                for &vertex in &vertices {
                    baker.bake_vertex(vertex, &mut words, &mut scratch);
                    black_box(&words);
                }
            });
        });
        maps(&mut group, &model, &baker, scene.name());
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(BenchmarkId::new("ray", scene.name()), |b| {
            b.iter(|| {
                let hits = |(origin, directions): &(Vector3<f64>, Vec<Vector3<f64>>)| {
                    directions.iter().filter(|d| baker.bvh().any_hit(origin, d)).count()
                };
                rays.iter().map(hits).sum::<usize>()
            });
        });

        // The peer's own vectors, whichever glam it has.
        let array = |v: &Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32];
        let triangle = |f: usize| {
            let [v0, v1, v2] = model.mesh.corners(f).map(|p| array(&p.cast()).into());
            Triangle { v0, v1, v2 }
        };
        let triangles: Vec<_> = (0..model.mesh.faces().len()).map(triangle).collect();
        let peer = build_cwbvh_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Duration::default());
        let triangles: Vec<_> = peer.primitive_indices.iter().map(|&i| triangles[i as usize]).collect();
        group.bench_function(BenchmarkId::new("obvhs-cwbvh", scene.name()), |b| {
            b.iter(|| {
                let hits = |(origin, directions): &(Vector3<f64>, Vec<Vector3<f64>>)| {
                    let hit = |d: &&Vector3<f64>| {
                        let ray = Ray::new_inf(array(origin).into(), array(d).into());
                        !peer.ray_traverse_miss(ray, |ray, i| triangles[i].intersect(ray))
                    };
                    directions.iter().filter(hit).count()
                };
                rays.iter().map(hits).sum::<usize>()
            });
        });
        group.finish();
    }
}

criterion_group!(benches, visibility);
criterion_main!(benches);
