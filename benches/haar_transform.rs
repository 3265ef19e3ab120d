//! 2D Haar transforms, full depth, f32: this crate, its naive twin, and osclet (the fastest other Rust crate) level by
//! level. Divide by the pixels of the id: criterion's throughput is in pixels.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::haar::{Decomposition, Keep, Pyramid, Selection, SelectionScratch, Transform2d};
use osclet::{BorderMode, DaubechiesFamily, Dwt2DExecutor, FilterBank2D, Osclet};

/// Ordinary numbers without a pattern.
fn pixels(len: usize) -> Vec<f32> {
    let mut state = 1u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    (0..len).map(|_| next()).collect()
}

/// osclet's single-level 2D step, repeated on the approximation, with buffers kept.
struct Peer {
    step: Arc<dyn Dwt2DExecutor<f32> + Send + Sync>,
    size: usize,
    approximations: Vec<Vec<f32>>,
    details: Vec<[Vec<f32>; 3]>,
    scratch: Vec<f32>,
}

impl Peer {
    fn new(size: usize) -> Self {
        let filter = Osclet::make_daubechies_f32(DaubechiesFamily::Db1, BorderMode::Wrap);
        let step = Osclet::make_2d_dwt_f32(filter);
        let sides: Vec<usize> = (0..size.ilog2()).map(|l| size >> (l + 1)).collect();
        let scratch = vec![0.0; step.required_scratch_size(size, size)];
        let approximations = sides.iter().map(|s| vec![0.0; s * s]).collect();
        let details = sides.iter().map(|s| std::array::from_fn(|_| vec![0.0; s * s])).collect();
        Self { step, size, approximations, details, scratch }
    }

    fn forward(&mut self, image: &[f32]) {
        let mut side = self.size;
        for level in 0..self.details.len() {
            let (done, rest) = self.approximations.split_at_mut(level);
            let src = done.last().map_or(image, |a| a.as_slice());
            let [lh, hl, hh] = &mut self.details[level];
            self.step.execute_forward(src, side, side, &mut rest[0], lh, hl, hh, &mut self.scratch).unwrap();
            side /= 2;
        }
    }

    fn inverse(&mut self, image: &mut [f32]) {
        for level in (0..self.details.len()).rev() {
            let side = self.size >> level;
            let (finer, rest) = self.approximations.split_at_mut(level);
            let dst = finer.last_mut().map_or(&mut *image, |a| a.as_mut_slice());
            let [lh, hl, hh] = &self.details[level];
            let bank = FilterBank2D { ll_band: &rest[0], lh_band: lh, hl_band: hl, hh_band: hh };
            self.step.execute_inverse(dst, &bank, side, side, &mut self.scratch).unwrap();
        }
    }
}

fn transforms(c: &mut Criterion) {
    let mut group = c.benchmark_group("haar_2d");
    for size in [32usize, 64, 256, 1024] {
        let image = pixels(size * size);
        let mut out = vec![0.0f32; image.len()];
        group.throughput(Throughput::Elements(image.len() as u64));
        for (basis, forward, inverse) in [
            (Decomposition::Nonstandard, "nonstandard_forward", "nonstandard_inverse"),
            (Decomposition::Standard, "standard_forward", "standard_inverse"),
        ] {
            let plan = Transform2d::<f32>::new(size, size, basis).unwrap();
            let mut scratch = vec![0.0; plan.scratch_len()];
            group.bench_function(BenchmarkId::new(forward, size), |b| {
                b.iter(|| plan.forward(black_box(&image), black_box(&mut out), &mut scratch));
            });
            group.bench_function(BenchmarkId::new(inverse, size), |b| {
                b.iter(|| plan.inverse(black_box(&image), black_box(&mut out), &mut scratch));
            });
        }
        let plan = Transform2d::<f32>::new(size, size, Decomposition::Nonstandard).unwrap();
        let mut scratch = vec![0.0; plan.scratch_len()];
        // Forward and inverse in turn, so that the numbers stay ordinary: divide by two.
        group.bench_function(BenchmarkId::new("nonstandard_in_place_both", size), |b| {
            out.copy_from_slice(&image);
            b.iter(|| {
                plan.forward_in_place(black_box(&mut out), &mut scratch);
                plan.inverse_in_place(black_box(&mut out), &mut scratch);
            });
        });
        // The bound: read and write every pixel once.
        group.bench_function(BenchmarkId::new("copy", size), |b| {
            b.iter(|| black_box(&mut out).copy_from_slice(black_box(&image)));
        });
        let mut pyramid = Pyramid::<f32>::new(size).unwrap();
        group.bench_function(BenchmarkId::new("pyramid_from_pixels", size), |b| {
            b.iter(|| black_box(&mut pyramid).set_pixels(black_box(&image)));
        });
        group.bench_function(BenchmarkId::new("pyramid_from_coefficients", size), |b| {
            b.iter(|| black_box(&mut pyramid).set_coefficients(black_box(&image)));
        });
        let mut peer = Peer::new(size);
        group.bench_function(BenchmarkId::new("osclet_forward", size), |b| {
            b.iter(|| peer.forward(black_box(&image)));
        });
        group.bench_function(BenchmarkId::new("osclet_inverse", size), |b| {
            b.iter(|| peer.inverse(black_box(&mut out)));
        });
    }
    let wide: Vec<f64> = pixels(1024).into_iter().map(f64::from).collect();
    group.throughput(Throughput::Elements(1024));
    group.sample_size(10);
    group.bench_function(BenchmarkId::new("naive_twin_forward", 32), |b| {
        b.iter(|| haarmonic::reference::haar::forward_nonstandard(black_box(&wide)));
    });
    group.finish();
}

fn batches(c: &mut Criterion) {
    let mut group = c.benchmark_group("haar_2d_batch");
    group.sample_size(10);
    let (size, count) = (32, 10_000);
    let images = pixels(size * size * count);
    let mut out = vec![0.0f32; images.len()];
    let plan = Transform2d::<f32>::new(size, size, Decomposition::Nonstandard).unwrap();
    let mut scratch = vec![0.0; plan.scratch_len()];
    group.throughput(Throughput::Elements(images.len() as u64));
    group.bench_function("forward/10000x32", |b| {
        b.iter(|| plan.forward_batch(black_box(&images), black_box(&mut out), &mut scratch));
    });
    group.bench_function("inverse/10000x32", |b| {
        b.iter(|| plan.inverse_batch(black_box(&images), black_box(&mut out), &mut scratch));
    });
    group.bench_function("forward_parallel/10000x32", |b| {
        b.iter(|| plan.forward_batch_parallel(black_box(&images), black_box(&mut out)));
    });
    group.bench_function("copy/10000x32", |b| {
        b.iter(|| black_box(&mut out).copy_from_slice(black_box(&images)));
    });
    let mut peer = Peer::new(size);
    group.bench_function("osclet_forward/10000x32", |b| {
        b.iter(|| images.chunks_exact(size * size).for_each(|image| peer.forward(black_box(image))));
    });
    group.finish();
}

fn selection(c: &mut Criterion) {
    let mut group = c.benchmark_group("haar_select");
    let coefs: Vec<f32> = pixels(6 * 64 * 64).into_iter().map(|x| x - 0.5).collect();
    group.throughput(Throughput::Elements(coefs.len() as u64));
    let rule = Selection::new(Keep::Fraction(0.01)).with_blocks_of(64 * 64);
    let mut work = SelectionScratch::default();
    group.bench_function("one_percent/6x64", |b| {
        b.iter(|| rule.indices(black_box(&[&coefs, &coefs, &coefs]), &mut work).unwrap().len());
    });
    group.finish();
}

criterion_group!(benches, transforms, batches, selection);
criterion_main!(benches);
