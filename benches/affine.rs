//! Affine wavelets: canonical couplings, whole operators of one axis.

use criterion::{Criterion, criterion_group, criterion_main};
use haarmonic::affine::{AffineMap, Mother, Operator1d, canonical, canonical_batch};
use std::hint::black_box;

fn maps(n: usize) -> Vec<AffineMap> {
    let mut x = 0.31f64;
    let mut next = move || {
        x = (x * 997.137).fract();
        x
    };
    (0..n).map(|_| AffineMap::new(0.4 + 1.6 * next(), next() - 0.5).unwrap()).collect()
}

fn benches(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("canonical");
    let r: Vec<f64> = (0..1024).map(|k| 0.001 * (k + 1) as f64).collect();
    let c: Vec<f64> = (0..1024).map(|k| ((k * 37) % 1024) as f64 / 512.0 - 0.5).collect();
    let mut out = vec![0.0; 1024];
    for f in Mother::ALL {
        for g in Mother::ALL {
            group.bench_function(format!("batch {f:?} {g:?} f64 1024"), |b| {
                b.iter(|| canonical_batch(f, g, black_box(&r), black_box(&c), black_box(&mut out)))
            });
        }
    }
    group.bench_function("one by one f64 1024", |b| {
        b.iter(|| {
            for k in 0..1024 {
                out[k] = canonical(Mother::Wavelet, Mother::Wavelet, black_box(r[k]), black_box(c[k]));
            }
        })
    });
    group.finish();
    let mut group = criterion.benchmark_group("operator");
    for size in [32, 256] {
        let maps = maps(64);
        let mut operator = Operator1d::<f32>::new(size, maps[0]).unwrap();
        let mut k = 0;
        group.bench_function(format!("set {size}"), |b| {
            b.iter(|| {
                k = (k + 1) % 64;
                operator.set(black_box(maps[k]));
            })
        });
        let mut nnz = 0;
        for m in &maps {
            operator.set(*m);
            nnz += operator.nnz();
        }
        println!("mean nnz {}", nnz / 64);
        let src = vec![1.0f32; size];
        let mut dst = vec![0.0f32; size];
        group.bench_function(format!("set and apply {size}"), |b| {
            b.iter(|| {
                k = (k + 1) % 64;
                operator.set(black_box(maps[k]));
                operator.apply(black_box(&src), &mut dst);
            })
        });
    }
}

criterion_group! {
    name = affine;
    config = Criterion::default().warm_up_time(std::time::Duration::from_millis(300)).measurement_time(std::time::Duration::from_secs(1));
    targets = benches
}
criterion_main!(affine);
