//! Products of spherical harmonics in f64, and of many bands in f32: one vector, a batch in cache, squares; plans, the
//! naive twin. Those of few bands in f32 are jobs of the bench `sh`. Times of a batch are those of all its vectors:
//! criterion's throughput is in vectors.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::Real;
use haarmonic::reference::sh as naive;
use haarmonic::sh::{Product, Square};

/// Ordinary numbers in −1..1 without a pattern.
fn numbers<T: Real>(len: usize) -> Vec<T> {
    let mut state = 1u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        T::of(f64::from(state >> 8) / f64::from(1 << 23) - 1.0)
    };
    (0..len).map(|_| next()).collect()
}

/// Vectors that fit the nearest caches, an odd number of registers so that rows do not share cache sets.
fn batch_size(size: usize) -> usize {
    ((2000 / size).max(8) / 8).div_ceil(2) * 16 - 8
}

fn forms<T: Real>(c: &mut Criterion, name: &str, bands: &[usize]) {
    let mut group = c.benchmark_group(name);
    for &bands in bands {
        let size = bands * bands;
        let (product, square) =
            (Product::<T>::new(bands, bands, bands).unwrap(), Square::<T>::new(bands, bands).unwrap());
        let count = batch_size(size);
        let (a, b, mut out) = (numbers(count * size), numbers(count * size), numbers(count * size));
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(BenchmarkId::new("batch", bands), |bench| {
            bench.iter(|| product.apply_batch(count, black_box(&a), black_box(&b), black_box(&mut out)));
        });
        let (c, mut integrals) = (numbers(count * size), numbers(3 * count));
        let mut scratch = numbers(product.scratch_len(count));
        group.bench_function(BenchmarkId::new("integral_batch_rgb", bands), |bench| {
            bench.iter(|| {
                let mut rest = integrals.chunks_exact_mut(count);
                let rgb = [(); 3].map(|()| rest.next().unwrap());
                product.integral_batch(count, black_box(&a), &b, [&c, &a, &b], rgb, &mut scratch);
            });
        });
        group.bench_function(BenchmarkId::new("square_batch", bands), |bench| {
            bench.iter(|| square.apply_batch(count, black_box(&a), black_box(&mut out)));
        });
        group.throughput(Throughput::Elements(1));
        let (a, b, out) = (&a[..size], &b[..size], &mut out[..size]);
        group.bench_function(BenchmarkId::new("single", bands), |bench| {
            bench.iter(|| product.apply(black_box(a), black_box(b), black_box(out)));
        });
        group.bench_function(BenchmarkId::new("square_single", bands), |bench| {
            bench.iter(|| square.apply(black_box(a), black_box(out)));
        });
        if bands <= 8 {
            let mut matrix = numbers(size * size);
            group.bench_function(BenchmarkId::new("matrix", bands), |bench| {
                bench.iter(|| product.matrix(black_box(a), black_box(&mut matrix)));
            });
        }
    }
    group.finish();
}

fn products(c: &mut Criterion) {
    forms::<f32>(c, "sh_product", &[10, 16, 32, 64]);
    forms::<f64>(c, "sh_product_f64", &[2, 3, 4, 5, 6, 7, 8, 10, 16, 32, 64]);
}

fn plans_and_twins(c: &mut Criterion) {
    let mut group = c.benchmark_group("sh_product_plan");
    for bands in [4usize, 8, 16, 64] {
        group.bench_function(BenchmarkId::new("new", bands), |bench| {
            bench.iter(|| Product::<f32>::new(black_box(bands), bands, bands).unwrap());
        });
    }
    group.finish();
    let mut group = c.benchmark_group("sh_product_naive");
    group.sample_size(10);
    for bands in [2usize, 4, 6] {
        let (a, b) = (numbers::<f64>(bands * bands), numbers::<f64>(bands * bands));
        group.bench_function(BenchmarkId::new("twin", bands), |bench| {
            bench.iter(|| naive::product(black_box(&a), black_box(&b), bands));
        });
    }
    group.finish();
}

criterion_group!(benches, products, plans_and_twins);
criterion_main!(benches);
