//! Exponentials and logarithms of spherical harmonic expansions, every method, one vector and batches, beside the naive
//! twin.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::reference::sh as naive;
use haarmonic::sh::{CapFit, CapLog, ExpMethod, Exponential, LogMethod, Logarithm};

const COUNT: usize = 1024;

/// A vector with ‖f̂‖ = 2, that needs four squarings, and a constant part.
fn vector(bands: usize, seed: usize) -> Vec<f64> {
    let mut f: Vec<f64> =
        (0..bands * bands).map(|i| ((i * 7919 + seed * 104_729) % 1009) as f64 / 504.5 - 1.0).collect();
    let norm = f[1..].iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
    f.iter_mut().for_each(|x| *x *= 2.0 / norm);
    f[0] = -1.0;
    f
}

fn methods() -> [(&'static str, ExpMethod, f64); 7] {
    [
        ("ps_9", ExpMethod::Series { degree: 9 }, 0.125),
        ("ps_star_2", ExpMethod::ScaledSeries { degree: 2 }, 0.125),
        ("ps_star_2_half", ExpMethod::ScaledSeries { degree: 2 }, 0.5),
        ("ps_star_3", ExpMethod::ScaledSeries { degree: 3 }, 0.125),
        ("ol", ExpMethod::OptimalLinear, 0.125),
        ("hyb", ExpMethod::Hybrid, 0.125),
        ("grid", ExpMethod::Grid, 0.125),
    ]
}

fn exponentials(c: &mut Criterion) {
    let plan = |bands, method, norm| Exponential::<f32>::new(bands, method).unwrap().with_scaled_norm(norm).unwrap();
    let mut group = c.benchmark_group("sh_exp");
    for bands in 2..=6 {
        let size = bands * bands;
        let f: Vec<f32> = vector(bands, 1).iter().map(|&x| x as f32).collect();
        let mut out = vec![0.0; size];
        for (name, method, norm) in methods() {
            let plan = plan(bands, method, norm);
            group.bench_function(BenchmarkId::new(name, bands), |b| b.iter(|| plan.apply(black_box(&f), &mut out)));
        }
        let wide = vector(bands, 1);
        group.bench_function(BenchmarkId::new("naive_ps_star_2", bands), |b| {
            b.iter(|| naive::exp_scaled_series(black_box(&wide), 2, 0.125));
        });
    }
    group.finish();
    let mut group = c.benchmark_group("sh_exp_batch");
    group.throughput(Throughput::Elements(COUNT as u64));
    for bands in 2..=6 {
        let vectors: Vec<Vec<f64>> = (0..COUNT).map(|v| vector(bands, v)).collect();
        let rows: Vec<f32> = (0..bands * bands * COUNT).map(|i| vectors[i % COUNT][i / COUNT] as f32).collect();
        let mut out = vec![0.0; rows.len()];
        for (name, method, norm) in methods() {
            let plan = plan(bands, method, norm);
            let mut scratch = vec![0.0; plan.scratch_len()];
            group.bench_function(BenchmarkId::new(name, bands), |b| {
                b.iter(|| plan.apply_batch(COUNT, black_box(&rows), &mut out, &mut scratch));
            });
        }
    }
    group.finish();
}

fn logarithms(c: &mut Criterion) {
    let mut group = c.benchmark_group("sh_log");
    for bands in [3, 4, 6] {
        let log = Logarithm::new(bands, LogMethod::default()).unwrap();
        let table = CapLog::new(bands, CapFit::default()).unwrap();
        let (mut g, mut zonal) = (vec![0.0f64; bands * bands], vec![0.0f32; bands]);
        g[0] = 2.5;
        g[2] = -0.5;
        let mut out = g.clone();
        group.bench_function(BenchmarkId::new("eigenvalues", bands), |b| b.iter(|| log.apply(black_box(&g), &mut out)));
        let of_zonal: Vec<f32> = (0..bands).map(|l| g[l * l + l] as f32).collect();
        group.bench_function(BenchmarkId::new("zonal", bands), |b| {
            b.iter(|| log.apply_zonal(black_box(&of_zonal), &mut zonal));
        });
        group.bench_function(BenchmarkId::new("cap_table", bands), |b| {
            b.iter(|| table.eval(black_box(0.4), &mut zonal))
        });
    }
    group.finish();
}

criterion_group!(benches, exponentials, logarithms);
criterion_main!(benches);
