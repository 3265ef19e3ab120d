//! Summed-area tables and visibility distance tables, f32 and bytes in, the caller's buffers out: this crate, its naive twins, a plain
//! two-loop table and the bound, a copy. Peers that are not Rust: benches/peers/tables.py. Divide by the pixels of the id:
//! criterion's throughput is in pixels.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::Real;
use haarmonic::reference::table as twin;
use haarmonic::table::{
    BinaryMap, Border, Coverage, DiskGrid, Rectangle, SummedArea, SummedAreaPlan, VisibilityDistance,
    VisibilityDistancePlan, VisibilityDistanceScratch,
};

/// Numbers in [0, 1) without a pattern.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// What one writes first: a running sum of the row, added to the row above.
fn plain<T: Real>(width: usize, samples: &[f32], table: &mut [T]) {
    table[..=width].fill(T::zero());
    for (y, row) in samples.chunks_exact(width).enumerate() {
        let (above, below) = table[y * (width + 1)..].split_at_mut(width + 1);
        below[0] = T::zero();
        let mut sum = T::zero();
        for x in 0..width {
            sum += T::of(f64::from(row[x]));
            below[x + 1] = above[x + 1] + sum;
        }
    }
}

fn build<T: Real>(c: &mut Criterion, name: &str, sizes: &[usize]) {
    let mut group = c.benchmark_group(format!("summed_area_{name}"));
    for &n in sizes {
        let mut numbers = Numbers(1);
        let samples: Vec<f32> = (0..n * n).map(|_| numbers.next() as f32).collect();
        let plan = SummedAreaPlan::new(n, n).unwrap();
        let (mut table, mut scratch) = (vec![T::zero(); plan.table_len()], vec![T::zero(); plan.scratch_len()]);
        group.throughput(Throughput::Elements((n * n) as u64));
        group.bench_function(BenchmarkId::new("build", n), |b| {
            b.iter(|| plan.build(black_box(&samples), black_box(&mut table), &mut scratch));
        });
        group.bench_function(BenchmarkId::new("build_parallel", n), |b| {
            b.iter(|| plan.build_parallel(black_box(&samples), black_box(&mut table)));
        });
        group.bench_function(BenchmarkId::new("plain_loops", n), |b| {
            b.iter(|| plain(n, black_box(&samples), black_box(&mut table)));
        });
        let mut copy = vec![T::zero(); n * n];
        let source = copy.clone();
        group.bench_function(BenchmarkId::new("copy_of_the_output", n), |b| {
            b.iter(|| black_box(&mut copy).copy_from_slice(black_box(&source)));
        });
    }
    group.finish();
}

fn summed_area(c: &mut Criterion) {
    build::<f32>(c, "f32_f32", &[32, 256, 1024, 4096]);
    build::<f64>(c, "f32_f64", &[32, 256, 1024, 4096]);
    let samples: Vec<f64> = (0..32 * 32).map(|i| f64::from(i % 7)).collect();
    let mut group = c.benchmark_group("summed_area_twin");
    group.throughput(Throughput::Elements(1024));
    group.sample_size(10);
    group.bench_function("naive_twin/32", |b| b.iter(|| twin::summed_area(32, 32, black_box(&samples))));
    group.finish();
}

fn blobs(n: usize, numbers: &mut Numbers) -> Vec<u8> {
    let n = n as f64;
    let discs: Vec<[f64; 3]> =
        (0..12).map(|_| [numbers.next() * n, numbers.next() * n, (0.04 + 0.12 * numbers.next()) * n]).collect();
    let side = n as usize;
    let inside = |x: f64, y: f64| discs.iter().any(|d| (x - d[0]).hypot(y - d[1]) < d[2]);
    (0..side * side).map(|i| u8::from(inside((i % side) as f64, (i / side) as f64))).collect()
}

fn noise(n: usize, numbers: &mut Numbers) -> Vec<u8> {
    (0..n * n).map(|_| u8::from(numbers.next() < 0.5)).collect()
}

fn distances(c: &mut Criterion) {
    let mut group = c.benchmark_group("visibility_distance");
    for (n, count) in [(32, 256), (64, 64), (256, 4), (1024, 1)] {
        let plan = VisibilityDistancePlan::new(n, n, Border::Zero).unwrap();
        let mut numbers = Numbers(1);
        let kinds: [(&str, Vec<u8>); 2] = [
            ("blobs", (0..count).flat_map(|_| blobs(n, &mut numbers)).collect()),
            ("noise", (0..count).flat_map(|_| noise(n, &mut numbers)).collect()),
        ];
        for (kind, maps) in kinds {
            group.throughput(Throughput::Elements(maps.len() as u64));
            let (mut out, mut scratch) = (vec![0.0_f32; maps.len()], VisibilityDistanceScratch::default());
            group.bench_function(BenchmarkId::new(format!("distances_{kind}"), n), |b| {
                b.iter(|| plan.distances(BinaryMap::Bytes(black_box(&maps)), black_box(&mut out), &mut scratch));
            });
            let mut squares = vec![0; maps.len()];
            group.bench_function(BenchmarkId::new(format!("squares_{kind}"), n), |b| {
                b.iter(|| plan.squares(BinaryMap::Bytes(black_box(&maps)), black_box(&mut squares), &mut scratch));
            });
        }
    }
    let map: Vec<bool> = blobs(32, &mut Numbers(1)).into_iter().map(|v| v != 0).collect();
    group.throughput(Throughput::Elements(1024));
    group.sample_size(10);
    group.bench_function("naive_twin/32", |b| b.iter(|| twin::signed_squares(32, 32, black_box(&map), true)));
    group.finish();
}

/// One square light: four forms of one look-up in the distances, and the four look-ups of a summed-area table.
fn look_ups(c: &mut Criterion) {
    let mut group = c.benchmark_group("square_coverage");
    let mut map = blobs(32, &mut Numbers(1));
    let grid = DiskGrid::new(32).unwrap();
    grid.mask(&mut map);
    let values: Vec<f32> = map.iter().map(|&v| f32::from(v)).collect();
    let distances = VisibilityDistance::new([32, 32], map.as_slice(), Border::Zero).unwrap();
    let sums: SummedArea<f32> = SummedArea::new(32, 32, &values).unwrap();
    let mut numbers = Numbers(7);
    let squares: Vec<([f64; 2], f64)> =
        (0..1024).map(|_| ([32.0 * numbers.next(), 32.0 * numbers.next()], 1.0 + 8.0 * numbers.next())).collect();
    group.throughput(Throughput::Elements(1024));
    for form in [Coverage::Gradient, Coverage::Mean, Coverage::Smoothstep, Coverage::Linear] {
        group.bench_function(format!("{form:?}"), |b| {
            b.iter(|| squares.iter().map(|&(at, e)| distances.as_ref().coverage(at, e, form)).sum::<f64>());
        });
    }
    group.bench_function("summed_area", |b| {
        b.iter(|| squares.iter().map(|&(at, e)| sums.mean(Rectangle::square(at, e))).sum::<f64>());
    });
    group.finish();
}

criterion_group!(benches, summed_area, distances, look_ups);
criterion_main!(benches);
