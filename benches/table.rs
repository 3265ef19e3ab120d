//! Nanoseconds a pixel, or a look-up, of tables and the block transform, in turn: this crate, its naive twins, two
//! plain loops and the bound, a copy. Peers that are not Rust: peers/tables.py.
//!
//! Run with: cargo bench -p haarmonic-benches --bench table [-- WORDS]: jobs whose name holds all the words.

use std::hint::black_box;
use std::sync::Arc;

use haarmonic::Real;
use haarmonic::dct::BlockDct;
use haarmonic::reference::table as twin;
use haarmonic::table::{
    BinaryMap, Border, Coverage, DiskGrid, Rectangle, SummedArea, SummedAreaPlan, VisibilityDistance,
    VisibilityDistancePlan, VisibilityDistanceScratch,
};
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

fn summed_area<T: Real>(jobs: &mut Jobs, name: &str) {
    for n in [32, 256, 1024, 4096] {
        let plan = SummedAreaPlan::new(n, n).expect("a size in range");
        let samples: Arc<[f32]> = Numbers(1).samples(n * n).into();
        let table = || vec![T::one(); plan.table_len()];
        let (mut out, mut scratch) = (table(), vec![T::zero(); plan.scratch_len()]);
        let (x, single) = (samples.clone(), plan.clone());
        jobs.add(format!("summed area {name} {n}"), n * n, move || {
            single.build(black_box(&x), black_box(&mut out), &mut scratch);
        });
        // peers/tables.py asks for the jobs of "summed": only those above may bear the word.
        let (mut out, x, parallel) = (table(), samples.clone(), plan.clone());
        jobs.add(format!("parallel build {name} {n}"), n * n, move || {
            parallel.build_parallel(black_box(&x), black_box(&mut out));
        });
        let mut out = table();
        jobs.add(format!("plain loops {name} {n}"), n * n, move || plain(n, black_box(&samples), black_box(&mut out)));
        let (source, mut copy) = (table(), table());
        jobs.add(format!("copy of the table {name} {n}"), n * n, move || {
            black_box(&mut copy).copy_from_slice(black_box(&source));
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
            let (roots, bytes) = (plan.clone(), maps.clone());
            jobs.add(format!("signed distance {kind} {n}"), maps.len(), move || {
                roots.distances(BinaryMap::Bytes(black_box(&bytes)), black_box(&mut out), &mut scratch);
            });
            let (mut out, mut scratch) = (vec![0; maps.len()], VisibilityDistanceScratch::default());
            let squares = plan.clone();
            jobs.add(format!("squared distance {kind} {n}"), maps.len(), move || {
                squares.squares(BinaryMap::Bytes(black_box(&maps)), black_box(&mut out), &mut scratch);
            });
        }
    }
}

/// One square light: four forms of one look-up in the distances, and the four look-ups of a summed-area table.
fn look_ups(jobs: &mut Jobs) {
    let mut map = Numbers(1).blobs(32);
    DiskGrid::new(32).expect("a size in range").mask(&mut map);
    let values: Vec<f32> = map.iter().map(|&v| f32::from(v)).collect();
    let bits: Vec<bool> = map.iter().map(|&v| v != 0).collect();
    let distances = VisibilityDistance::new([32, 32], bits.as_slice(), Border::Zero).expect("a size in range");
    let sums: SummedArea<f32> = SummedArea::new(32, 32, &values).expect("a size in range");
    let mut numbers = Numbers(7);
    let squares: Vec<([f64; 2], f64)> =
        (0..1024).map(|_| ([32.0 * numbers.next(), 32.0 * numbers.next()], 1.0 + 8.0 * numbers.next())).collect();
    for form in [Coverage::Gradient, Coverage::Mean, Coverage::Smoothstep, Coverage::Linear] {
        let (distances, squares) = (distances.clone(), squares.clone());
        jobs.add(format!("coverage {form:?}"), squares.len(), move || {
            let all = black_box(&squares).iter().map(|&(at, edge)| distances.as_ref().coverage(at, edge, form));
            black_box(all.sum::<f64>());
        });
    }
    jobs.add("coverage by four sums", squares.len(), move || {
        let all = black_box(&squares).iter().map(|&(at, edge)| sums.mean(Rectangle::square(at, edge)));
        black_box(all.sum::<f64>());
    });
}

fn twins(jobs: &mut Jobs) {
    let samples: Vec<f64> = (0..32 * 32).map(|i| f64::from(i % 7)).collect();
    jobs.add("naive twin, table of sums 32", samples.len(), move || {
        black_box(twin::summed_area(32, 32, black_box(&samples)));
    });
    let map: Vec<bool> = Numbers(1).blobs(32).into_iter().map(|v| v != 0).collect();
    jobs.add("naive twin, squared distance 32", map.len(), move || {
        black_box(twin::signed_squares(32, 32, black_box(&map), true));
    });
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
    look_ups(&mut jobs);
    twins(&mut jobs);
    transforms(&mut jobs);
    jobs.run();
}
