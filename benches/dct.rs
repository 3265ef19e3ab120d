//! DCT of square blocks, f32: this crate, its naive twin, and rustdct by rows and columns. Throughput is in samples.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::dct::{BlockDct, LowProjection};
use rustdct::{Dct2, DctPlanner};

/// Ordinary numbers without a pattern.
fn samples(len: usize) -> Vec<f32> {
    let mut state = 1u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    (0..len).map(|_| next()).collect()
}

/// rustdct on the rows, a transpose, the columns, a transpose.
struct Peer {
    side: usize,
    plan: Arc<dyn Dct2<f32>>,
    turned: Vec<f32>,
    scratch: Vec<f32>,
}

impl Peer {
    fn new(side: usize) -> Self {
        let plan = DctPlanner::new().plan_dct2(side);
        let scratch = vec![0.0; rustdct::RequiredScratch::get_scratch_len(&*plan)];
        Self { side, plan, turned: vec![0.0; side * side], scratch }
    }

    fn forward(&mut self, blocks: &[f32], out: &mut [f32]) {
        let n = self.side;
        for (block, out) in blocks.chunks_exact(n * n).zip(out.chunks_exact_mut(n * n)) {
            out.copy_from_slice(block);
            out.chunks_exact_mut(n).for_each(|row| self.plan.process_dct2_with_scratch(row, &mut self.scratch));
            (0..n * n).for_each(|i| self.turned[i % n * n + i / n] = out[i]);
            let rows = self.turned.chunks_exact_mut(n);
            rows.for_each(|row| self.plan.process_dct2_with_scratch(row, &mut self.scratch));
            (0..n * n).for_each(|i| out[i % n * n + i / n] = self.turned[i]);
        }
    }
}

fn blocks(c: &mut Criterion) {
    let mut group = c.benchmark_group("dct");
    group.sample_size(20);
    // A batch that does not fit the cache at n = 16, as in the bench `table`, and about as many samples in cache at
    // every side.
    for (side, count) in [(16, 10_000), (4, 1024), (8, 256), (16, 64), (32, 16), (64, 4)] {
        let id = |name: &str| BenchmarkId::new(name, format!("{count}x{side}"));
        let x = samples(count * side * side);
        let mut out = vec![0.0f32; x.len()];
        let plan = BlockDct::<f32>::new(side).unwrap();
        group.throughput(Throughput::Elements(x.len() as u64));
        group.bench_function(id("forward"), |b| b.iter(|| plan.forward(black_box(&x), black_box(&mut out))));
        group.bench_function(id("inverse"), |b| b.iter(|| plan.inverse(black_box(&x), black_box(&mut out))));
        for low in [1, 2, 4] {
            let mut coefs = vec![0.0f32; count * low * low];
            group.bench_function(id(&format!("forward_low_{low}")), |b| {
                b.iter(|| plan.forward_low(low, black_box(&x), black_box(&mut coefs)));
            });
            group.bench_function(id(&format!("inverse_low_{low}")), |b| {
                b.iter(|| plan.inverse_low(low, black_box(&coefs), black_box(&mut out)));
            });
        }
        let mut peer = Peer::new(side);
        group.bench_function(id("rustdct"), |b| b.iter(|| peer.forward(black_box(&x), black_box(&mut out))));
        // The bound: read and write every sample once.
        group.bench_function(id("copy"), |b| b.iter(|| black_box(&mut out).copy_from_slice(black_box(&x))));
    }
    let block: Vec<f64> = samples(256).into_iter().map(f64::from).collect();
    group.throughput(Throughput::Elements(256));
    group.bench_function("naive_twin/1x16", |b| b.iter(|| haarmonic::reference::dct::forward(16, black_box(&block))));
    group.finish();
}

fn projections(c: &mut Criterion) {
    let mut group = c.benchmark_group("dct_projection");
    for low in [1, 2, 4] {
        let plan = LowProjection::<f32>::centres(16, low).unwrap();
        let x = samples(1000 * low * low);
        let mut out = vec![0.0f32; x.len()];
        group.throughput(Throughput::Elements(1000));
        group.bench_function(BenchmarkId::new("project_blocks", low), |b| {
            b.iter(|| plan.project(black_box(&x), black_box(&mut out)));
        });
    }
    group.finish();
}

criterion_group!(benches, blocks, projections);
criterion_main!(benches);
