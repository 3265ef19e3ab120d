//! Visibility of the built-in 100k-vertex scenes: the tracer that takes all rays of a vertex at once, and one ray at a time
//! through the same hierarchy. Throughput is in rays (texels above the horizon), one core.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::scene::{Procedural, VisibilityBaker, VisibilitySettings};
use haarmonic::sphere::CubeGrid;

/// Vertices looked at, spread over the mesh.
const SAMPLE: usize = 256;

fn visibility(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("visibility");
    for scene in Procedural::ALL {
        let model = scene.build(100_000).expect("the size is allowed");
        let n = model.mesh.positions().len();
        let sample: Vec<usize> = (0..SAMPLE).map(|i| i * n / SAMPLE).collect();
        for side in [16, 64] {
            let grid = CubeGrid::new(side).expect("the side is allowed");
            let baker =
                VisibilityBaker::new(&model.mesh, grid, VisibilitySettings::default()).expect("the mesh is sound");
            let mut words = vec![0; baker.words_per_vertex()];
            let mut scratch = baker.scratch();
            let mut bake = |vertex: usize| {
                words.fill(0);
                baker.bake_vertex_with_scratch(vertex, &mut words, &mut scratch)
            };
            let rays: u64 = sample.iter().map(|&v| bake(v)).sum();
            group.throughput(Throughput::Elements(rays));
            group.bench_function(BenchmarkId::new(format!("{}/all_at_once", scene.name()), side), |b| {
                b.iter(|| sample.iter().map(|&v| black_box(bake(v))).sum::<u64>());
            });
        }
        // One ray at a time is slow: 16 vertices at side 16.
        let grid = CubeGrid::new(16).expect("the side is allowed");
        let baker = VisibilityBaker::new(&model.mesh, grid, VisibilitySettings::default()).expect("the mesh is sound");
        let rays: Vec<_> = (0..16)
            .map(|i| i * n / 16)
            .flat_map(|v| {
                let normal = model.mesh.normals()[v].cast::<f64>();
                let origin = baker.origin(v);
                grid.directions().into_iter().filter(move |d| normal.dot(d) > 0.0).map(move |d| (origin, d))
            })
            .collect();
        group.throughput(Throughput::Elements(rays.len() as u64));
        group.bench_function(BenchmarkId::new(format!("{}/ray_by_ray", scene.name()), 16), |b| {
            b.iter(|| rays.iter().filter(|(origin, d)| baker.bvh().any_hit(origin, d)).count());
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = visibility
}
criterion_main!(benches);
