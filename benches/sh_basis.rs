//! Evaluation of the basis in f64, a point at a time and in batches; sums over it; the naive twin. Evaluation in f32 is
//! a job of the bench `sh`.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::Real;
use haarmonic::nalgebra::{UnitVector3, Vector3};
use haarmonic::reference::sh as naive;
use haarmonic::sh::Basis;
use haarmonic::sphere::fibonacci_directions;

const BANDS: [usize; 8] = [2, 3, 4, 5, 6, 10, 21, 51];

fn soa<T: Real>(directions: &[UnitVector3<f64>]) -> [Vec<T>; 3] {
    [0, 1, 2].map(|k| directions.iter().map(|d| T::of(d[k])).collect())
}

/// In cache: `points` × bands² values fit the second one.
fn batches<T: Real>(c: &mut Criterion, scalar: &str) {
    let mut group = c.benchmark_group(format!("basis {scalar}, in cache"));
    for bands in BANDS {
        let points = if bands > 10 { 32 } else { 512 };
        let [x, y, z] = soa::<T>(&fibonacci_directions(points));
        let (n, basis) = (bands * bands, Basis::<T>::new(bands).expect("a size in range"));
        let mut out = vec![T::zero(); n * points];
        let coefficients: Vec<T> = (0..n).map(|i| T::of((i as f64).sin())).collect();
        let mut sums = [0; 3].map(|_| vec![T::zero(); n]);
        group.throughput(Throughput::Elements(points as u64));
        group.bench_function(BenchmarkId::new("reconstruct", bands), |b| {
            b.iter(|| basis.reconstruct(&coefficients, black_box(&x), &y, &z, black_box(&mut out[..points])));
        });
        group.bench_function(BenchmarkId::new("accumulate RGB", bands), |b| {
            let [red, green, blue] = &mut sums;
            b.iter(|| basis.accumulate(black_box(&x), &y, &z, [&z, &x, &y], [red, green, blue]));
        });
        if size_of::<T>() == size_of::<f32>() {
            continue;
        }
        group.bench_function(BenchmarkId::new("rows", bands), |b| {
            b.iter(|| basis.eval_batch(black_box(&x), &y, &z, black_box(&mut out)));
        });
        group.bench_function(BenchmarkId::new("points", bands), |b| {
            b.iter(|| basis.eval_points(black_box(&x), &y, &z, black_box(&mut out)));
        });
        group.bench_function(BenchmarkId::new("one at a time", bands), |b| {
            b.iter(|| {
                for (p, out) in out.chunks_exact_mut(n).enumerate() {
                    basis.eval(black_box(&Vector3::new(x[p], y[p], z[p])), out);
                }
            });
        });
    }
    group.finish();
}

fn twin(c: &mut Criterion) {
    let d = UnitVector3::new_normalize(Vector3::new(0.3, -0.5, 0.7));
    for bands in [3, 6, 21] {
        c.bench_function(&format!("basis, naive twin/{bands}"), |b| b.iter(|| naive::basis(bands, black_box(&d))));
    }
}

fn basis(c: &mut Criterion) {
    batches::<f32>(c, "f32");
    batches::<f64>(c, "f64");
    twin(c);
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_millis(200));
    targets = basis
}
criterion_main!(benches);
