//! Nanoseconds a pixel of the tables and the block transform against the goals of docs/performance.md; peers that are not Rust:
//! peers/tables.py.
//!
//! Run with: cargo bench -p haarmonic-benches --bench table_gates [-- WORDS]: jobs whose name holds all the words.

use std::hint::black_box;

use haarmonic::Real;
use haarmonic::dct::BlockDct;
use haarmonic::table::{BinaryMap, Border, SummedAreaPlan, VisibilityDistancePlan, VisibilityDistanceScratch};
use haarmonic_benches::Jobs;

/// The numbers of peers/tables.py, in [0, 1).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn samples(&mut self, len: usize) -> Vec<f32> {
        (0..len).map(|_| self.next() as f32).collect()
    }

    fn blobs(&mut self, n: usize) -> Vec<u8> {
        let side = n as f64;
        let discs: Vec<[f64; 3]> =
            (0..12).map(|_| [self.next() * side, self.next() * side, (0.04 + 0.12 * self.next()) * side]).collect();
        let inside = |x: f64, y: f64| discs.iter().any(|d| (x - d[0]).hypot(y - d[1]) < d[2]);
        (0..n * n).map(|i| u8::from(inside((i % n) as f64, (i / n) as f64))).collect()
    }
}

fn summed_area<T: Real>(jobs: &mut Jobs, name: &str) {
    for n in [256, 1024, 4096] {
        let plan = SummedAreaPlan::new(n, n).expect("a size in range");
        let samples = Numbers(1).samples(n * n);
        let (mut table, mut scratch) = (vec![T::zero(); plan.table_len()], vec![T::zero(); plan.scratch_len()]);
        jobs.add(format!("summed area {name} {n}"), n * n, move || {
            plan.build(black_box(&samples), black_box(&mut table), &mut scratch);
        });
    }
}

fn distances(jobs: &mut Jobs) {
    for (n, count) in [(32, 256), (64, 64), (256, 4), (1024, 1)] {
        let plan = VisibilityDistancePlan::new(n, n, Border::Zero).expect("a size in range");
        let mut numbers = Numbers(1);
        let blobs: Vec<u8> = (0..count).flat_map(|_| numbers.blobs(n)).collect();
        let noise = (0..blobs.len()).map(|_| u8::from(numbers.next() < 0.5)).collect();
        for (kind, maps) in [("blobs", blobs), ("noise", noise)] {
            let (mut out, mut scratch) = (vec![0.0f32; maps.len()], VisibilityDistanceScratch::default());
            let plan = plan.clone();
            jobs.add(format!("signed distance {kind} {n}"), maps.len(), move || {
                plan.distances(BinaryMap::Bytes(black_box(&maps)), black_box(&mut out), &mut scratch);
            });
        }
    }
}

fn transforms(jobs: &mut Jobs) {
    let x = Numbers(1).samples(10_000 * 256);
    let plan = BlockDct::<f32>::new(16).expect("a side in range");
    let (y, mut out, forward) = (x.clone(), x.clone(), plan.clone());
    jobs.add("dct 10000 blocks of 16² forward", x.len(), move || forward.forward(black_box(&y), black_box(&mut out)));
    let (mut out, low) = (vec![0.0; 10_000 * 16], plan.clone());
    jobs.add("dct 10000 blocks of 16² lowest 4²", x.len(), move || {
        low.forward_low(4, black_box(&x), black_box(&mut out));
    });
    let x = Numbers(1).samples(64 * 256);
    let (y, mut out, forward) = (x.clone(), x.clone(), plan.clone());
    jobs.add("dct 64 blocks of 16² forward", x.len(), move || forward.forward(black_box(&y), black_box(&mut out)));
    let mut out = vec![0.0; 64 * 16];
    jobs.add("dct 64 blocks of 16² lowest 4²", x.len(), move || {
        plan.forward_low(4, black_box(&x), black_box(&mut out));
    });
}

fn main() {
    let mut jobs = Jobs::default();
    summed_area::<f32>(&mut jobs, "f32 f32");
    summed_area::<f64>(&mut jobs, "f32 f64");
    distances(&mut jobs);
    transforms(&mut jobs);
    jobs.run();
}
