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

criterion_group!(benches, search, products);
criterion_main!(benches);
