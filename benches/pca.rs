//! Principal components of 10000 × 1024 f32, k = 32: this crate and the same algorithm on faer (one sketch of 42
//! columns, two power iterations, as `benches/peers/pca.py` does with numpy); exact methods; clustered components.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use faer::{Mat, MatRef, Side};
use haarmonic::Progress;
use haarmonic::compress::{ClusteredPca, ClusteredPcaSettings, Pca, PcaMethod, PcaSettings};
use haarmonic::reference::compress::NaivePca;

/// Numbers in (−1, 1) without a pattern.
fn numbers() -> impl FnMut() -> f32 {
    let mut state = 1u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 11) as f64 / (1u64 << 52) as f64 - 1.0) as f32
    }
}

/// Rows around `groups` means, along `plane` directions of each, and noise.
fn rows(count: usize, columns: usize, groups: usize, plane: usize) -> Vec<f32> {
    let mut next = numbers();
    let bases: Vec<f32> = (0..groups * (plane + 1) * columns).map(|_| next()).collect();
    let mut out = Vec::with_capacity(count * columns);
    for i in 0..count {
        let basis = &bases[i % groups * (plane + 1) * columns..][..(plane + 1) * columns];
        let weights: Vec<f32> = (0..plane).map(|j| next() / (1.0 + j as f32)).collect();
        for c in 0..columns {
            let sum: f32 = weights.iter().enumerate().map(|(j, w)| w * basis[(j + 1) * columns + c]).sum();
            out.push(basis[c] + sum + 0.05 * next());
        }
    }
    out
}

/// A random sketch of the rows, orthonormalised between the rounds; eigenvectors of the small Gram matrix.
fn faer_randomised(matrix: MatRef<f32>, k: usize) -> (Mat<f32>, Vec<f32>) {
    let (n, columns) = (matrix.nrows(), matrix.ncols());
    let sums = Mat::<f32>::from_fn(1, n, |_, _| 1.0 / n as f32) * matrix;
    // Row-major, as the matrix.
    let mut centred = Vec::with_capacity(n * columns);
    for r in 0..n {
        let row = matrix.row(r);
        centred.extend((0..columns).map(|c| row[c] - sums[(0, c)]));
    }
    let centred = MatRef::from_row_major_slice(&centred, n, columns);
    let mut next = numbers();
    let omega = Mat::<f32>::from_fn(n, k + 10, |_, _| next());
    let mut q = (centred.transpose() * &omega).qr().compute_thin_Q();
    for _ in 0..2 {
        let y = centred * &q;
        q = (centred.transpose() * &y).qr().compute_thin_Q();
    }
    let y = centred * &q;
    let eigen = (y.transpose() * &y).self_adjoint_eigen(Side::Lower).expect("converges");
    let components = &q * eigen.U().subcols(10, k);
    let variances = (0..k).map(|j| eigen.S()[k + 9 - j] / n as f32).collect();
    (components, variances)
}

fn faer_exact(matrix: MatRef<f32>, k: usize) -> Mat<f32> {
    let eigen = (matrix.transpose() * matrix).self_adjoint_eigen(Side::Lower).expect("converges");
    eigen.U().subcols(matrix.ncols() - k, k).to_owned()
}

fn pca(c: &mut Criterion) {
    let mut group = c.benchmark_group("pca");
    group.sample_size(10);
    let (n, columns, k) = (10_000, 1024, 32);
    let matrix = rows(n, columns, 40, 3);
    let faer = MatRef::from_row_major_slice(&matrix, n, columns);
    group.throughput(Throughput::Elements((n * columns) as u64));
    let settings = PcaSettings::new(k);
    group.bench_function("randomised", |b| b.iter(|| Pca::new(black_box(&matrix), columns, &settings)));
    group.bench_function("faer_randomised", |b| b.iter(|| faer_randomised(black_box(faer), k)));
    let exact = settings.with_method(PcaMethod::Exact);
    group.bench_function("exact", |b| b.iter(|| Pca::new(black_box(&matrix), columns, &exact)));
    group.bench_function("faer_exact_uncentred_f32", |b| b.iter(|| faer_exact(black_box(faer), k)));
    let pca = Pca::new(&matrix, columns, &settings).unwrap();
    assert!(
        (pca.variances()[0] / f64::from(faer_randomised(faer, k).1[0]) - 1.0).abs() < 1e-3,
        "the peer does the same"
    );
    let mut weights = vec![0.0; n * pca.len()];
    let mut back = vec![0.0; matrix.len()];
    group.bench_function("project", |b| b.iter(|| pca.project(black_box(&matrix), black_box(&mut weights))));
    group.bench_function("reconstruct", |b| b.iter(|| pca.reconstruct(black_box(&weights), black_box(&mut back))));
    let small: Vec<f32> = rows(100, 24, 3, 3);
    let naive: Vec<Vec<f64>> = small.chunks(24).map(|row| row.iter().map(|&x| f64::from(x)).collect()).collect();
    group.throughput(Throughput::Elements(small.len() as u64));
    group.bench_function("exact/100x24", |b| b.iter(|| Pca::new(black_box(&small), 24, &exact)));
    group.bench_function("naive_twin/100x24", |b| b.iter(|| NaivePca::new(black_box(&naive), None)));
    group.finish();
}

/// Progress as lines, a tenth of a stage each.
struct Lines(std::sync::atomic::AtomicUsize);

impl Progress for Lines {
    #[expect(clippy::print_stdout, reason = "progress is to be seen")]
    fn advance(&self, done: usize, total: usize) {
        let tenth = 10 * done / total.max(1);
        if self.0.swap(tenth, std::sync::atomic::Ordering::Relaxed) != tenth {
            println!("{tenth}/10");
        }
    }
}

/// Seconds of 40,000 × 1024 maps in 256 clusters of 8 components.
#[expect(clippy::print_stdout, reason = "the report is what it is for")]
fn goal() {
    let (n, columns) = (40_000, 1024);
    let matrix = rows(n, columns, 512, 6);
    let start = std::time::Instant::now();
    let coded = ClusteredPca::new(&matrix, columns, &ClusteredPcaSettings::new(256, 8), &Lines(Default::default()));
    let (seconds, coded) = (start.elapsed().as_secs_f64(), coded.expect("finite maps"));
    println!("clustered components, 40000 × 1024, 256 × 8: {seconds:.1} s, {:?}", coded.stats());
}

fn clustered(c: &mut Criterion) {
    if std::env::var_os("CLUSTERED_PCA_GOAL").is_some() {
        return goal();
    }
    let mut group = c.benchmark_group("clustered_pca");
    group.sample_size(10);
    let columns = 1024;
    for (n, clusters) in [(4000, 32)] {
        let matrix = rows(n, columns, clusters * 2, 6);
        let settings = ClusteredPcaSettings::new(clusters, 8);
        group.throughput(Throughput::Elements(matrix.len() as u64));
        let id = format!("{n}x{columns}_{clusters}x8");
        group.bench_function(BenchmarkId::new("build", &id), |b| {
            b.iter(|| ClusteredPca::new(black_box(&matrix), columns, &settings, &()));
        });
        let coded = ClusteredPca::new(&matrix, columns, &settings, &()).unwrap();
        for sides in [1, 3] {
            let x: Vec<f32> = matrix[..columns * sides].to_vec();
            let (mut out, mut scratch) = (vec![0.0; n * sides], vec![0.0; coded.scratch_len(sides)]);
            group.bench_function(BenchmarkId::new("multiply", format!("{id}_{sides}")), |b| {
                b.iter(|| coded.multiply_batch(sides, black_box(&x), &mut out, &mut scratch));
            });
            group.bench_function(BenchmarkId::new("dense", format!("{id}_{sides}")), |b| {
                b.iter(|| dense(black_box(&matrix), &x, sides, &mut out));
            });
        }
    }
    group.finish();
}

/// Elements without their rows, of 4000 × 1024 in 32 components and in 32 clusters of 8: 4000 of each kind, and all
/// rows decoded.
fn entries(c: &mut Criterion) {
    let mut group = c.benchmark_group("pca_entries");
    let (n, columns) = (4000, 1024);
    let matrix = rows(n, columns, 64, 6);
    let pca = Pca::new(&matrix, columns, &PcaSettings::new(32)).unwrap();
    let coded = ClusteredPca::new(&matrix, columns, &ClusteredPcaSettings::new(32, 8), &()).unwrap();
    let mut weights = vec![0.0; n * pca.len()];
    pca.project(&matrix, &mut weights);
    let places: Vec<(usize, usize)> = (0..n).map(|i| (i * 7919 % n, i * 104_729 % columns)).collect();
    let all: Vec<usize> = (0..n).collect();
    let picked: Vec<usize> = (0..n).map(|i| i * 104_729 % columns).collect();
    let (mut out, mut row) = (vec![0.0; n], vec![0.0; columns]);
    group.throughput(Throughput::Elements(n as u64));
    group.bench_function("entries", |b| b.iter(|| pca.entries(&weights, black_box(&places), &mut out)));
    group.bench_function("row", |b| b.iter(|| pca.row_entries(&weights[..pca.len()], black_box(&picked), &mut out)));
    let mut scratch = vec![0.0; pca.len() + 1];
    group.bench_function("column", |b| b.iter(|| pca.column_entries(&weights, black_box(5), &mut out, &mut scratch)));
    group.bench_function("decoding", |b| {
        b.iter(|| {
            for (&(at, column), out) in black_box(&places).iter().zip(&mut out) {
                pca.reconstruct(&weights[at * pca.len()..][..pca.len()], &mut row);
                *out = row[column];
            }
        });
    });
    group.bench_function("clustered_entries", |b| b.iter(|| coded.entries(black_box(&places), &mut out)));
    group.bench_function("clustered_row", |b| b.iter(|| coded.row_entries(7, black_box(&picked), &mut out)));
    let mut scratch = vec![0.0; coded.scratch_len(1)];
    group.bench_function("clustered_column", |b| {
        b.iter(|| coded.column_entries(black_box(5), &all, &mut out, &mut scratch));
    });
    group.bench_function("clustered_decoding", |b| {
        b.iter(|| {
            for (&(at, column), out) in black_box(&places).iter().zip(&mut out) {
                coded.reconstruct(at, &mut row);
                *out = row[column];
            }
        });
    });
    group.finish();
}

/// The rows as they are, on all threads as the coded product.
fn dense(matrix: &[f32], x: &[f32], sides: usize, out: &mut [f32]) {
    use rayon::prelude::*;
    let columns = x.len() / sides;
    out.par_chunks_mut(sides).zip(matrix.par_chunks(columns)).for_each(|(out, row)| {
        let mut sums = [[0.0f32; 8]; 3];
        let (row, _) = row.as_chunks::<8>();
        for (i, row) in row.iter().enumerate() {
            for s in 0..sides {
                (0..8).for_each(|l| sums[s][l] += row[l] * x[(i * 8 + l) * sides + s]);
            }
        }
        (0..sides).for_each(|s| out[s] = sums[s].iter().sum());
    });
}

criterion_group!(benches, pca, clustered, entries);
criterion_main!(benches);
