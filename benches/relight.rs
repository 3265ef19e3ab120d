//! Frames of the wavelet back end on the built-in scene with about 5,000 vertices, 64² × 6 texels, all threads: time a
//! vertex.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::backend::wavelet_double as double;
use haarmonic::backend::wavelet_triple::{self as triple, Slices};
use haarmonic::haar::{Keep, Weighting};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{
    EnvironmentLight, GroundTruth, Lambert, Materials, Phong, Procedural, Sky, TexelVisibility, View, VisibilityBaker,
    VisibilitySettings,
};
use haarmonic::sphere::CubeGrid;

fn relight(criterion: &mut Criterion) {
    let model = Procedural::TorusKnotOnFloor.build(5000).expect("the size is allowed");
    let grid = CubeGrid::new(64).expect("the side is allowed");
    let baker = VisibilityBaker::new(&model.mesh, grid, VisibilitySettings::default()).expect("the mesh is sound");
    let visibility = baker.bake(&()).expect("nothing cancels");
    let light = EnvironmentLight::from_sky(Sky::default()).expect("the sky is sound").to_cube(grid);
    let view = View::eye(model.camera.eye().cast()).expect("the eye is finite");
    let mut out = vec![Vector3::zeros(); visibility.vertices()];
    let transport = triple::Transport::from_binary(visibility.clone()).expect("64 is a power of two");

    let mut group = criterion.benchmark_group("relight");
    group.throughput(Throughput::Elements(out.len() as u64));
    let materials = [
        ("lambert", Materials::uniform(Lambert::new([0.8; 3]).expect("allowed"))),
        ("phong50", Materials::uniform(Phong::new([0.8; 3], 50.0).expect("allowed"))),
    ];
    for (name, materials) in &materials {
        let truth = GroundTruth { mesh: &model.mesh, materials, view: &view, light: &light };
        group.bench_function(BenchmarkId::new("ground_truth", name), |b| {
            b.iter(|| black_box(truth.radiance(&TexelVisibility::Binary(&visibility), &()).expect("sound")));
        });
        let double = double::BakeSettings::default();
        let double = double::Transport::bake(&model.mesh, &visibility, &view, materials, double, &()).expect("sound");
        let settings = double::Settings { light_terms: Keep::Fraction(0.01), weighting: Weighting::Integral };
        let mut relighter = double::Relighter::new(&double, settings).expect("sound");
        group.bench_function(BenchmarkId::new("double_1%", name), |b| {
            b.iter(|| {
                relighter.set_light(&light).expect("sound");
                relighter.relight(&view, materials, &mut out).expect("sound");
            });
        });
        let tabulated = ("triple_table16_1%", Keep::Fraction(0.01), Slices::Tabulated(16));
        let sampled = [
            ("triple_sampled_1%", Keep::Fraction(0.01), Slices::Sampled),
            ("triple_sampled_all", Keep::Fraction(1.0), Slices::Sampled),
        ];
        // A table of slices by normal and view is no gain where every vertex has a view of its own.
        let with_table = (*name == "lambert").then_some(tabulated);
        for (method, terms, slices) in sampled.into_iter().chain(with_table) {
            let weighting = Weighting::Integral;
            let settings = triple::Settings { light_terms: terms, brdf_terms: terms, weighting, slices };
            let mut relighter = triple::Relighter::new(&model.mesh, &transport, settings).expect("sound");
            group.bench_function(BenchmarkId::new(method, name), |b| {
                b.iter(|| {
                    relighter.set_light(&light).expect("sound");
                    relighter.relight(&view, materials, &mut out).expect("sound");
                });
            });
        }
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = relight
}
criterion_main!(benches);
