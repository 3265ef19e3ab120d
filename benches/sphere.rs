//! Resampling of environment maps: exact areas against the naive twin's dense sampling and bilinear look-ups.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use haarmonic::nalgebra::{Rotation3, Vector3};
use haarmonic::reference::sphere as naive;
use haarmonic::scene::{EnvironmentLight, Sky};
use haarmonic::sphere::{CubeGrid, CubeMap, LatLongGrid, LatLongMap, Resampling};

fn lat_long(width: usize) -> LatLongMap<Vector3<f32>> {
    let grid = LatLongGrid::new(width, width / 2).expect("a size in range");
    LatLongMap::from_fn(grid, |d| d.map(|c| (3.0 * c).exp() as f32))
}

fn to_cube(c: &mut Criterion) {
    let mut group = c.benchmark_group("lat_long_to_cube_64");
    group.sample_size(10);
    let grid = CubeGrid::new(64).expect("a side in range");
    let turn = Rotation3::from_euler_angles(0.3, -1.2, 2.5);
    for width in [256, 1024, 2048] {
        let map = lat_long(width);
        for (name, rotation) in [("area", Rotation3::identity()), ("area_turned", turn)] {
            group.bench_function(BenchmarkId::new(name, width), |b| {
                b.iter(|| map.to_cube(grid, &rotation, Resampling::Area));
            });
        }
        group.bench_function(BenchmarkId::new("bilinear", width), |b| {
            b.iter(|| map.to_cube(grid, &turn, Resampling::Bilinear));
        });
    }
    // 16 × 16 nearest samples a texel, as renderers do it: energy to 1e-3 only.
    let map = lat_long(1024);
    group.bench_function(BenchmarkId::new("naive_256_samples", 1024), |b| {
        b.iter(|| {
            let texels = (0..grid.len()).map(|i| {
                naive::cube_texel_mean(64, i, 16, |d| {
                    f64::from(map.pixels()[naive::lat_long_nearest([1024, 512], d)].x)
                })
            });
            texels.sum::<f64>()
        });
    });
    group.finish();
}

fn turn_cube(c: &mut Criterion) {
    let mut group = c.benchmark_group("turn_cube");
    group.sample_size(10);
    let turn = Rotation3::from_euler_angles(0.3, -1.2, 2.5);
    for side in [32, 64, 128] {
        let map = CubeMap::from_fn(CubeGrid::new(side).expect("a side in range"), |d| d.map(|c| c as f32));
        for resampling in [Resampling::Area, Resampling::Bilinear] {
            group.bench_function(BenchmarkId::new(format!("{resampling:?}"), side), |b| {
                b.iter(|| map.to_cube(map.grid(), &turn, resampling));
            });
        }
        group.bench_function(BenchmarkId::new("to_lat_long", side), |b| {
            let grid = LatLongGrid::new(4 * side, 2 * side).expect("a size in range");
            b.iter(|| map.to_lat_long(grid, &turn, Resampling::Area));
        });
    }
    group.finish();
}

fn sky(c: &mut Criterion) {
    let mut group = c.benchmark_group("sky_to_cube");
    group.sample_size(10);
    for side in [16, 64, 256] {
        let light = EnvironmentLight::from_sky(Sky::default()).expect("a good sky");
        let grid = CubeGrid::new(side).expect("a side in range");
        group.bench_function(BenchmarkId::new("default", side), |b| b.iter(|| light.to_cube(grid)));
    }
    group.finish();
}

criterion_group!(benches, to_cube, turn_cube, sky);
criterion_main!(benches);
