//! Projection of maps onto spherical harmonics and back: the plans against fused accumulation over all directions, the
//! textbook loop (evaluate, store, multiply) and the naive twin; minima, deringing and fits.
//!
//! Run with RAYON_NUM_THREADS=1 for one core.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use haarmonic::nalgebra::{UnitVector3, Vector3};
use haarmonic::reference::sh as naive;
use haarmonic::sh::{
    Basis, CubeProjection, CubeReconstruction, Deringing, Extrema, LatLongProjection, LatLongReconstruction,
    ScatteredFit, TexelRule, eval, monte_carlo,
};
use haarmonic::sphere::{CubeGrid, CubeMap, LatLongGrid, LatLongMap, fibonacci_directions};

type Rgb = Vector3<f32>;

fn light(d: UnitVector3<f64>) -> Rgb {
    d.map(|c| (3.0 * c).exp() as f32)
}

/// x, y, z and solid angles of a grid's texels.
fn soa(grid: CubeGrid) -> [Vec<f32>; 4] {
    let omega = grid.face_solid_angles();
    let axis = |k: usize| grid.directions().iter().map(|d| d[k] as f32).collect();
    let solid = (0..grid.len()).map(|i| omega[i % omega.len()] as f32).collect();
    [axis(0), axis(1), axis(2), solid]
}

/// Evaluates a direction into a buffer, then multiplies each colour in, as programs do that have a function for one
/// direction.
fn textbook(basis: &Basis<f32>, [x, y, z, omega]: &[Vec<f32>; 4], texels: &[Rgb], out: &mut [[f32; 3]]) {
    let mut values = vec![0.0; out.len()];
    out.fill([0.0; 3]);
    for (i, texel) in texels.iter().enumerate() {
        basis.eval(&Vector3::new(x[i], y[i], z[i]), &mut values);
        let weighted = texel * omega[i];
        for (out, y) in out.iter_mut().zip(&values) {
            for (out, w) in out.iter_mut().zip(weighted.iter()) {
                *out += y * w;
            }
        }
    }
}

fn cube(c: &mut Criterion) {
    let mut group = c.benchmark_group("project_cube_rgb");
    group.sample_size(20);
    for side in [16, 64, 256] {
        let grid = CubeGrid::new(side).expect("a side in range");
        let map = CubeMap::from_fn(grid, light);
        let soa = soa(grid);
        for bands in [3, 6, 10, 20] {
            let id = |name: &str| BenchmarkId::new(format!("{name}_{bands}"), side);
            let plan = |rule| CubeProjection::<f32>::new(grid, bands, rule).expect("bands in range");
            let (centre, mean) = (plan(TexelRule::Centre), plan(TexelRule::Mean));
            group.bench_function(id("centre"), |b| b.iter(|| centre.project(&map)));
            group.bench_function(id("mean"), |b| b.iter(|| mean.project(&map)));
            let back = CubeReconstruction::<f32>::new(grid, bands, TexelRule::Centre).expect("bands in range");
            let coefficients = centre.project(&map);
            let refs = coefficients.each_ref().map(|c| &c[..]);
            let mut texels = map.texels().to_vec();
            group.bench_function(id("fill"), |b| b.iter(|| back.fill::<Rgb, 3>(refs, &mut texels)));
            if side == 256 && bands > 6 {
                continue;
            }
            let basis = Basis::<f32>::new(bands).expect("bands in range");
            let planes =
                map.planes().map(|p| p.into_texels().iter().zip(&soa[3]).map(|(t, w)| t * w).collect::<Vec<_>>());
            group.bench_function(id("accumulate_only"), |b| {
                let mut out = [vec![0f32; bands * bands], vec![0.0; bands * bands], vec![0.0; bands * bands]];
                b.iter(|| {
                    let [r, g, bl] = &mut out;
                    basis.accumulate(&soa[0], &soa[1], &soa[2], planes.each_ref().map(|p| &p[..]), [r, g, bl]);
                });
            });
            group.bench_function(id("textbook"), |b| {
                let mut out = vec![[0.0; 3]; bands * bands];
                b.iter(|| textbook(&basis, &soa, map.texels(), &mut out));
            });
            if side == 16 && bands == 6 {
                let wide = map.planes().map(|p| p.map(f64::from));
                group.bench_function(id("naive_twin"), |b| {
                    b.iter(|| wide.each_ref().map(|p| naive::project_cube(p, bands)));
                });
            }
        }
    }
    group.finish();
}

fn lat_long(c: &mut Criterion) {
    let mut group = c.benchmark_group("project_lat_long_rgb");
    group.sample_size(20);
    for height in [64, 512] {
        let grid = LatLongGrid::new(2 * height, height).expect("a size in range");
        let map = LatLongMap::from_fn(grid, light);
        for bands in [3, 6, 20] {
            let plan = LatLongProjection::<f32>::new(grid, bands, TexelRule::Centre).expect("bands in range");
            let back = LatLongReconstruction::<f32>::new(grid, bands, TexelRule::Centre).expect("bands in range");
            let coefficients = plan.project(&map);
            let refs = coefficients.each_ref().map(|c| &c[..]);
            let id = |name: &str| BenchmarkId::new(format!("{name}_{bands}"), height);
            group.bench_function(id("centre"), |b| b.iter(|| plan.project(&map)));
            let mut pixels = map.pixels().to_vec();
            group.bench_function(id("fill"), |b| b.iter(|| back.fill::<Rgb, 3>(refs, &mut pixels)));
        }
    }
    group.finish();
}

fn plans(c: &mut Criterion) {
    let mut group = c.benchmark_group("build_cube_plan");
    group.sample_size(10);
    let grid = CubeGrid::new(64).expect("a side in range");
    for bands in [3, 6, 20] {
        for rule in [TexelRule::Centre, TexelRule::Mean] {
            group.bench_function(BenchmarkId::new(format!("{rule:?}"), bands), |b| {
                b.iter(|| CubeProjection::<f32>::new(grid, bands, rule).expect("bands in range"));
            });
        }
    }
    group.finish();
}

fn extrema(c: &mut Criterion) {
    let mut group = c.benchmark_group("extrema");
    group.sample_size(10);
    for bands in [3, 4, 6, 10] {
        let lamp = eval(bands, &Vector3::new(0.6, 0.0, 0.8)).expect("bands in range");
        let mixed: Vec<f64> = lamp.iter().enumerate().map(|(i, c)| c + 0.2 * (2.3 * i as f64).sin()).collect();
        let finder = Extrema::new(bands).expect("bands in range");
        group.bench_function(BenchmarkId::new("minimum", bands), |b| b.iter(|| finder.minimum(&mixed)));
        group.bench_function(BenchmarkId::new("minimum_on_a_ring", bands), |b| b.iter(|| finder.minimum(&lamp)));
        let dering = Deringing::new(bands).expect("bands in range");
        let mut bright = mixed.clone();
        bright[0] += 1.0;
        group.bench_function(BenchmarkId::new("dering", bands), |b| b.iter(|| dering.window(&bright, 0.0)));
    }
    group.finish();
}

fn samples(c: &mut Criterion) {
    let mut group = c.benchmark_group("samples");
    group.sample_size(10);
    let directions = fibonacci_directions(10_000);
    let values: Vec<f64> = directions.iter().map(|d| (3.0 * d.x).exp()).collect();
    for bands in [3, 6, 10] {
        group.bench_function(BenchmarkId::new("fit_build_10k", bands), |b| {
            b.iter(|| ScatteredFit::new(bands, &directions, None, 1e-4));
        });
        let fit = ScatteredFit::new(bands, &directions, None, 1e-4).expect("enough samples");
        group.bench_function(BenchmarkId::new("fit_10k", bands), |b| b.iter(|| fit.fit([&values])));
        group.bench_function(BenchmarkId::new("monte_carlo_10k", bands), |b| {
            b.iter(|| monte_carlo(bands, 10_000, 1, |d| [d.z.max(0.0)]));
        });
    }
    group.finish();
}

criterion_group!(benches, cube, lat_long, plans, extrema, samples);
criterion_main!(benches);
