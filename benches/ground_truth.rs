//! BRDF slices per direction, and ground truth per vertex.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{
    AshikhminShirley, BinaryVisibility, BlinnPhong, Brdf, BrdfFn, CookTorrance, DirectionTable, GroundTruth, Lambert,
    LocalFrame, Materials, Mesh, Phong, TexelVisibility, View, Ward,
};
use haarmonic::sphere::{CubeGrid, CubeMap};

/// f · cos of a 64² cube map's directions, one channel; the naive twin is `eval` in f64, direction by direction.
fn slices(c: &mut Criterion) {
    let table = DirectionTable::new(CubeGrid::new(64).unwrap());
    let normal = Vector3::new(0.36_f32, 0.48, 0.8);
    let tangent = Vector3::new(0.8, -0.6, 0.0_f32);
    let frame = LocalFrame { tangent, bitangent: normal.cross(&tangent), normal };
    let wo = Vector3::new(0.1, 0.9, 0.4).normalize();
    let phong = Phong::new([1.0; 3], 50.0).unwrap();
    let models: [(&str, Arc<dyn Brdf>); 7] = [
        ("lambert", Arc::new(Lambert::new([0.8; 3]).unwrap())),
        ("phong", Arc::new(phong)),
        ("blinn_phong", Arc::new(BlinnPhong::new([1.0; 3], 100.0).unwrap())),
        ("ward", Arc::new(Ward::new([1.0; 3], 0.2, 0.5).unwrap())),
        ("ggx", Arc::new(CookTorrance::isotropic([1.0; 3], 0.3).unwrap())),
        ("ashikhmin_naive", Arc::new(AshikhminShirley::new([0.5; 3], [0.1; 3], 100.0, 1000.0).unwrap())),
        ("phong_naive", Arc::new(BrdfFn::grey(move |i: &Vector3<f64>, o: &Vector3<f64>| phong.eval(i, o).x))),
    ];
    let mut group = c.benchmark_group("brdf_slice");
    group.throughput(Throughput::Elements(table.len() as u64));
    let mut out = vec![0.0; table.len()];
    for (name, brdf) in &models {
        group.bench_function(BenchmarkId::new(*name, 64), |b| {
            b.iter(|| brdf.sample_cos(black_box(&frame), &wo, &table, black_box(&mut out)));
        });
    }
    let mut out = vec![0.0; 3 * table.len()];
    for (name, brdf) in &models[..2] {
        group.bench_function(BenchmarkId::new(format!("{name}_rgb"), 64), |b| {
            b.iter(|| brdf.sample_cos(black_box(&frame), &wo, &table, black_box(&mut out)));
        });
    }
    group.finish();
}

/// A bumpy sphere's vertices, visibility of whole upper hemispheres with a third blocked in runs.
fn truth(c: &mut Criterion) {
    let grid = CubeGrid::new(64).unwrap();
    let (rings, sectors) = (20, 50);
    let point = |i: usize| {
        let theta = (i / sectors) as f32 / rings as f32 * 3.0 + 0.07;
        let phi = (i % sectors) as f32 / sectors as f32 * std::f32::consts::TAU;
        Vector3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin())
    };
    let positions: Vec<_> = (0..rings * sectors).map(point).collect();
    let corner = |ring: usize, sector: usize| (ring * sectors + sector % sectors) as u32;
    let faces = (0..(rings - 1) * sectors)
        .flat_map(|i| {
            let (r, s) = (i / sectors, i % sectors);
            let [a, b, c, d] = [corner(r, s), corner(r, s + 1), corner(r + 1, s), corner(r + 1, s + 1)];
            [[a, b, c], [b, d, c]]
        })
        .collect();
    let mesh = Mesh::new(positions, faces).unwrap();
    let vertices = mesh.positions().len();
    let visibility = BinaryVisibility::from_fn(grid, vertices, |v, words| {
        for (i, w) in words.iter_mut().enumerate() {
            *w = if (i * 7 + v) % 3 == 0 { 0xffff_0000_ff00_0000 } else { u64::MAX };
        }
    });
    let light = CubeMap::from_fn(grid, |d| Vector3::new(1.0, 2.0 + d.y as f32, 3.0));
    let view = View::towards(Vector3::new(0.3, 1.0, 0.5)).unwrap();
    let mut group = c.benchmark_group("ground_truth");
    group.sample_size(10);
    group.throughput(Throughput::Elements(vertices as u64));
    for (name, materials) in [
        ("lambert", Materials::uniform(Lambert::new([0.8; 3]).unwrap())),
        ("phong", Materials::uniform(Phong::new([1.0; 3], 50.0).unwrap())),
        ("ggx", Materials::uniform(CookTorrance::isotropic([1.0; 3], 0.3).unwrap())),
    ] {
        let truth = GroundTruth { mesh: &mesh, materials: &materials, view: &view, light: &light };
        group.bench_function(BenchmarkId::new(name, "1000 vertices, 64"), |b| {
            b.iter(|| truth.radiance(&TexelVisibility::Binary(black_box(&visibility)), &()).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, slices, truth);
criterion_main!(benches);
