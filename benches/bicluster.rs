//! Biclustering: the search against its naive twin, and products with a light through compressed rows and through
//! biclusters. The matrix is the transfer matrix of the example of the same name.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::compress::{BiclusterSettings, Biclustering, SparseMatrix};
use haarmonic::reference::compress as twin;
use haarmonic::scene::Procedural;

#[path = "../examples/bicluster/transfer.rs"]
mod transfer;

fn matrix(vertices: usize) -> SparseMatrix {
    let mesh = Procedural::TorusKnotOnFloor.build(vertices).expect("enough vertices").mesh;
    transfer::transfer_matrix(&mesh, &()).expect("small enough")
}

/// The most used columns of rows that share one of them: dense enough for the twin.
fn corner(matrix: &SparseMatrix, size: usize) -> SparseMatrix {
    let rows: Vec<usize> = (0..matrix.rows()).filter(|&row| matrix.level(row, 2500) != 0).take(size).collect();
    let mut counts: Vec<(usize, usize)> = (0..matrix.columns()).map(|k| (0, k)).collect();
    rows.iter().for_each(|&row| matrix.row(row).0.iter().for_each(|&k| counts[k as usize].0 += 1));
    counts.sort_by_key(|&(count, k)| (std::cmp::Reverse(count), k));
    let columns: Vec<usize> = counts.iter().take(size).map(|c| c.1).collect();
    let entry = |i: usize| (i / size, i % size, matrix.level(rows[i / size], columns[i % size]));
    SparseMatrix::from_triplets(size, size, matrix.scale(), (0..size * rows.len()).map(entry)).expect("small levels")
}

fn search(c: &mut Criterion) {
    let mut group = c.benchmark_group("bicluster_search");
    group.sample_size(10);
    let settings = BiclusterSettings::default();
    for vertices in [1000, 2000] {
        let matrix = matrix(vertices);
        group.throughput(Throughput::Elements(matrix.nnz() as u64));
        group.bench_function(BenchmarkId::new("groups", vertices), |b| {
            b.iter(|| Biclustering::new(black_box(&matrix), &settings, &()));
        });
        if vertices > 1000 {
            continue;
        }
        let small = corner(&matrix, 24);
        let row = |j| (0..24).map(|k| i64::from(small.level(j, k))).collect();
        let dense: Vec<Vec<i64>> = (0..24).map(row).collect();
        group.throughput(Throughput::Elements(small.nnz() as u64));
        group.bench_function("fast/24x24", |b| b.iter(|| Biclustering::new(black_box(&small), &settings, &())));
        group.bench_function("twin/24x24", |b| b.iter(|| twin::bicluster(black_box(&dense), twin::first_nonzero)));
    }
    group.finish();
}

fn products(c: &mut Criterion) {
    let mut group = c.benchmark_group("bicluster_product");
    let matrix = matrix(2000);
    let biclusters = Biclustering::new(&matrix, &BiclusterSettings::default(), &()).expect("not cancelled");
    let plan = biclusters.multiplier::<f32>();
    for sides in [1, 3, 16] {
        let x: Vec<f32> = (0..matrix.columns() * sides).map(|i| (i as f32 * 0.618_034).fract()).collect();
        let mut out = vec![0.0; matrix.rows() * sides];
        let mut scratch = vec![0.0; plan.scratch_len(sides)];
        group.throughput(Throughput::Elements((matrix.nnz() * sides) as u64));
        group
            .bench_function(BenchmarkId::new("rows", sides), |b| b.iter(|| matrix.multiply_batch(sides, &x, &mut out)));
        group.bench_function(BenchmarkId::new("biclusters", sides), |b| {
            b.iter(|| plan.multiply_batch(sides, &x, &mut out, &mut scratch));
        });
    }
    group.finish();
}

/// Storage against error of a transfer matrix, all elements weighing the same.
#[expect(clippy::print_stdout, reason = "the report is what it is for")]
fn curve() {
    let mesh = Procedural::TorusKnotOnFloor.build(4000).expect("enough vertices").mesh;
    let matrix = transfer::transfer_matrix(&mesh, &()).expect("small enough");
    let all = Biclustering::new(&matrix, &BiclusterSettings::default(), &()).expect("not cancelled");
    let start = std::time::Instant::now();
    let (pruning, stats) = (all.pruning(), all.stats());
    println!("{} steps in {:.1} s; {stats:?}", pruning.curve().len(), start.elapsed().as_secs_f64());
    let levels = (0..matrix.rows()).flat_map(|row| matrix.row(row).1);
    let energy = matrix.scale().powi(2) * levels.map(|&t| f64::from(t) * f64::from(t)).sum::<f64>();
    let share = |part: usize, whole: usize| 100.0 * part as f64 / whole as f64;
    for relative in [0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3] {
        let (left, point) = pruning.within(relative * relative * energy).expect("small levels");
        println!(
            "relative L2 error at most {relative}: {:.5}, {:.1} % of compressed rows, {:.1} % of dense bytes, {:.1} % of \
             the operations, {} biclusters",
            (point.squared_error / energy).sqrt(),
            share(point.bytes, stats.matrix_bytes),
            share(point.bytes, stats.dense_bytes),
            share(point.flops, stats.matrix_flops),
            left.len()
        );
    }
}

fn pruning(c: &mut Criterion) {
    if std::env::var_os("BICLUSTER_PRUNING").is_some() {
        return curve();
    }
    let mut group = c.benchmark_group("bicluster_pruning");
    group.sample_size(10);
    let matrix = matrix(1000);
    let all = Biclustering::new(&matrix, &BiclusterSettings::default(), &()).expect("not cancelled");
    group.throughput(Throughput::Elements(matrix.nnz() as u64));
    group.bench_function("curve/1000", |b| b.iter(|| black_box(&all).pruning()));
    let pruning = all.pruning();
    let bound = 0.01 * pruning.curve().last().expect("the whole").squared_error;
    group.bench_function("within/1000", |b| b.iter(|| pruning.within(black_box(bound))));
    group.finish();
}

criterion_group!(benches, search, products, pruning);
criterion_main!(benches);
