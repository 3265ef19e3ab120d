//! Canonical couplings by the thousand; whole operators of one axis, against a scan of all pairs and the naive twin.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::Real;
use haarmonic::affine::{
    AffineMap, MapGrid, Mother, Operator1d, Parameter, StoredCouplings, canonical, canonical_batch, coupling_1d,
};
use haarmonic::reference::affine as naive;

/// 64 maps, s between ½ and 2, most of the source in sight.
fn maps() -> Vec<AffineMap> {
    let weyl = |k: usize, a: f64| (0.31 + a * k as f64).fract();
    let map = |k| {
        let s = 4f64.powf(weyl(k, 0.754_877_666_246_692_8) - 0.5);
        AffineMap::new(s, 0.5 - 0.5 * s + 0.6 * (weyl(k, 0.569_840_290_998_053_2) - 0.5)).expect("s is near 1")
    };
    (0..64).map(map).collect()
}

fn couplings<T: Real>(criterion: &mut Criterion, scalar: &str) {
    let mut group = criterion.benchmark_group(format!("canonical coupling, {scalar}"));
    const COUNT: usize = 1024;
    group.throughput(Throughput::Elements(COUNT as u64));
    let r: Vec<T> = (0..COUNT).map(|k| T::of(0.0011 * (k + 1) as f64)).collect();
    let c: Vec<T> = (0..COUNT).map(|k| T::of(((k * 37) % COUNT) as f64 / 512.0 - 0.5)).collect();
    let mut out = vec![T::zero(); COUNT];
    for (f, g) in Mother::ALL.into_iter().flat_map(|f| Mother::ALL.map(|g| (f, g))) {
        group.bench_function(format!("batch, {f:?} with {g:?}"), |b| {
            b.iter(|| canonical_batch(f, g, black_box(&r), black_box(&c), black_box(&mut out)));
        });
    }
    group.bench_function("one by one, Wavelet with Wavelet", |b| {
        b.iter(|| {
            for (out, (&r, &c)) in out.iter_mut().zip(r.iter().zip(&c)) {
                *out = canonical(Mother::Wavelet, Mother::Wavelet, black_box(r), c);
            }
        });
    });
    group.bench_function("naive twin, Wavelet with Wavelet", |b| {
        b.iter(|| {
            for (out, (r, c)) in out.iter_mut().zip(r.iter().zip(&c)) {
                *out = T::of(naive::canonical(Mother::Wavelet, Mother::Wavelet, r.widen(), c.widen()));
            }
        });
    });
    group.finish();
}

fn operators(criterion: &mut Criterion) {
    let maps = maps();
    for size in [8, 32, 128, 512] {
        let mut group = criterion.benchmark_group(format!("operator of one axis, N = {size}"));
        let mut turn = 0;
        let mut next = || {
            turn = (turn + 1) % maps.len();
            maps[turn]
        };
        let mut operator = Operator1d::<f32>::new(size, maps[0]).expect("2^k");
        group.bench_function("set", |b| b.iter(|| operator.set(black_box(next()))));
        group.bench_function("set derivative", |b| {
            b.iter(|| operator.set_derivative(black_box(next()), Parameter::Scale));
        });
        operator.set(maps[7]);
        let (light, mut seen) = (vec![0.5f32; size], vec![0.0; size]);
        group.bench_function("apply", |b| b.iter(|| operator.apply(black_box(&light), &mut seen)));
        if size <= 32 {
            let mut all = vec![0.0f32; size * size];
            group.bench_function("scan of all pairs", |b| {
                b.iter(|| {
                    let map = black_box(next());
                    for (k, d) in all.iter_mut().enumerate() {
                        *d = coupling_1d(k / size, k % size, map) as f32;
                    }
                });
            });
            group.bench_function("naive twin", |b| {
                b.iter(|| {
                    let map = black_box(next());
                    for (k, d) in all.iter_mut().enumerate() {
                        *d = naive::coupling_1d(k / size, k % size, map) as f32;
                    }
                });
            });
            let grid = MapGrid::new([0.25, 4.0], [128, 128]).expect("a range of scales");
            let stored = StoredCouplings::new(size, grid, 1 << 30).expect("a small table");
            group.bench_function("stored couplings, applied", |b| {
                b.iter(|| {
                    seen.fill(0.0);
                    if let Some(operator) = stored.operator(black_box(next())) {
                        operator.add_to(&light, &mut seen);
                    }
                });
            });
            group.bench_function("set and apply", |b| {
                b.iter(|| {
                    operator.set(black_box(next()));
                    operator.apply(&light, &mut seen);
                });
            });
        }
        group.finish();
    }
}

fn all(criterion: &mut Criterion) {
    couplings::<f64>(criterion, "f64");
    couplings::<f32>(criterion, "f32");
    operators(criterion);
}

criterion_group! {
    name = affine;
    config = Criterion::default().warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(700));
    targets = all
}
criterion_main!(affine);
