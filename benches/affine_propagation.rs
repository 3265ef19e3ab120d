//! Carrying a 32² or 64² light to a place: routes, the dense operator and a summed-area table, against terms kept;
//! a zoom without decompression; and a transport that meets the light of many vertices, stored or on the fly.
//!
//! A place is one pair of maps, 64 of them in turn, as a renderer goes from vertex to vertex; s between ½ and 2. Times
//! are per place. `AFFINE_SWEEP=FILE` measures every route over terms kept at source and target, prints the engine's
//! choice against the best and writes FILE as CSV.
#![expect(clippy::print_stderr, reason = "the sweep and the bytes are for people")]

#[path = "../examples/affine/contenders.rs"]
mod contenders;

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::{Duration, Instant};

use contenders::{Case, Dense, PLACES, Table, best_of, light, places};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::Real;
use haarmonic::affine::{
    AffineMap, Propagation, PropagationRoute, PropagationScratch, PropagationSource, TargetLists, Targets,
};
use haarmonic::haar::{Decomposition, Keep, Selection, Transform2d, forward_2d};
use rayon::prelude::*;

const BASES: [Decomposition; 2] = [Decomposition::Standard, Decomposition::Nonstandard];

fn propagate(criterion: &mut Criterion) {
    for basis in BASES {
        for side in [32, 64] {
            let mut group = criterion.benchmark_group(format!("propagate {basis:?} {side}²"));
            let area = side * side;
            let mut full = Case::<f32, 1>::new(side, basis, area, area);
            for route in [PropagationRoute::Pixels, PropagationRoute::Wavelets] {
                group.bench_function(format!("all terms, {route:?}"), |b| {
                    b.iter_custom(|n| per_place(n, || full.run(Some(route))))
                });
            }
            let image = light(side, 0);
            let mut table = Table::new(side, basis, std::slice::from_ref(&image));
            let (places, mut out) = (places(), vec![0.0; area]);
            group.bench_function("all terms, summed-area table", |b| {
                b.iter_custom(|n| {
                    per_place(n, || places.iter().for_each(|&maps| table.apply(black_box(maps), &mut out)))
                });
            });
            if basis == Decomposition::Standard {
                let coefs = [forward_2d(&image, side, side, basis).expect("2^k")];
                let mut dense = Dense::new(side);
                group.bench_function("all terms, dense operator", |b| {
                    b.iter_custom(|n| {
                        per_place(n, || places.iter().for_each(|&maps| dense.apply(&coefs, black_box(maps), &mut out)))
                    });
                });
            }
            for (source, target) in [(1, 100), (1, 20), (5, 40), (20, 70), (100, 100)] {
                let mut case =
                    Case::<f32, 3>::new(side, basis, (area * source).div_ceil(100), (area * target).div_ceil(100));
                let id = BenchmarkId::new("RGB, chosen route", format!("{source} % to {target} %"));
                group.bench_function(id, |b| b.iter_custom(|n| per_place(n, || case.run(None))));
            }
            group.finish();
        }
    }
}

/// A window of a compressed image, four times as large: in the wavelet domain, and by decompression, resampling and
/// transformation.
///
/// Neither side selects terms of the result. The peer resamples by a summed-area table, or by the bands of the engine's
/// pixel route.
fn zoom(criterion: &mut Criterion) {
    for basis in BASES {
        for side in [256, 512] {
            let mut group = criterion.benchmark_group(format!("zoom {basis:?} {side}²"));
            let window =
                [AffineMap::new(0.25, 0.31).expect("s is not 0"), AffineMap::new(0.25, 0.42).expect("s is not 0")];
            let (area, plan) = (side * side, Propagation::<f32>::new(side, basis).expect("2^k"));
            let transform = Transform2d::<f32>::new(side, side, basis).expect("2^k");
            let (mut scratch, mut memory) = (PropagationScratch::new(), vec![0.0; transform.scratch_len()]);
            let coefs = forward_2d(&light(side, 0), side, side, basis).expect("2^k");
            let (mut table, mut image, mut out) =
                (Table::new(side, basis, &[light(side, 0)]), vec![0.0; area], vec![0.0; area]);
            let all = Targets::all(side, basis).expect("2^k");
            for percent in [1, 5, 20] {
                let terms = Selection::new(Keep::Terms(area * percent / 100)).apply(&coefs).expect("2^k");
                let (dense, source) = (terms.to_dense(), PropagationSource::new(side, basis, [&terms]).expect("2^k"));
                group.bench_function(BenchmarkId::new("wavelets", format!("{percent} %")), |b| {
                    b.iter(|| {
                        plan.apply_by(
                            PropagationRoute::Wavelets,
                            &source,
                            black_box(window),
                            &all,
                            [&mut out],
                            &mut scratch,
                        );
                    });
                });
                group.bench_function(BenchmarkId::new("decompress, bands, transform", format!("{percent} %")), |b| {
                    b.iter(|| {
                        transform.inverse(&dense, &mut image, &mut memory);
                        plan.apply_by(
                            PropagationRoute::Pixels,
                            &source,
                            black_box(window),
                            &all,
                            [&mut out],
                            &mut scratch,
                        );
                    });
                });
                group.bench_function(BenchmarkId::new("decompress, table, transform", format!("{percent} %")), |b| {
                    b.iter(|| {
                        transform.inverse(&dense, &mut image, &mut memory);
                        table.set(0, &image);
                        table.apply(black_box(window), &mut out);
                    });
                });
            }
            group.finish();
        }
    }
}

/// Light met by a transport at many vertices: on the fly, and by way of all propagated light in memory.
///
/// Times are per vertex. 4096 vertices, three channels; the memory of the stored way is printed, and what 68,000
/// vertices would take.
fn vertices(criterion: &mut Criterion) {
    const VERTICES: usize = 4096;
    let basis = Decomposition::Standard;
    for (from, side) in [(32, 32), (64, 32)] {
        let mut group = criterion.benchmark_group(format!("vertices {from}² to {side}²"));
        group.throughput(Throughput::Elements(VERTICES as u64)).sample_size(10);
        let area = side * side;
        let pixels: [Vec<f32>; 3] = std::array::from_fn(|c| light(from, c));
        let source = PropagationSource::from_pixels(from, basis, pixels.each_ref().map(Vec::as_slice)).expect("2^k");
        let plan = Propagation::<f32>::between(from, side, basis).expect("2^k");
        let maps: Vec<[AffineMap; 2]> = places().into_iter().cycle().take(VERTICES).collect();
        for kept in [area / 50, area / 5, area] {
            let lists = if kept == area {
                TargetLists::all(side, basis, VERTICES)
            } else {
                // Coarse terms of every vertex, and some that differ from one to the next.
                let list =
                    |v: usize| (0..kept).map(move |k| (if k < kept / 2 { k } else { k + v % (area - kept) }) as u32);
                let offsets: Vec<usize> = (0..=VERTICES).map(|v| v * kept).collect();
                let indices: Vec<u32> = (0..VERTICES).flat_map(list).collect();
                TargetLists::new(side, basis, &offsets, &indices)
            }
            .expect("indices of the image");
            let transport: Vec<f32> = (0..lists.len()).map(|k| ((k * 7919) % 101) as f32 / 101.0).collect();
            let mut out = vec![[0.0f32; 3]; VERTICES];
            let mut stored = vec![0.0f32; 3 * lists.len()];
            let bytes = size_of_val(&stored[..]);
            eprintln!(
                "{kept} targets: stored light {:.1} MB, of 68,000 vertices {:.0} MB",
                bytes as f64 / 1e6,
                bytes as f64 / 1e6 * 68_000.0 / VERTICES as f64
            );
            group.bench_function(BenchmarkId::new("on the fly", kept), |b| {
                b.iter(|| plan.inner_products(&source, black_box(&maps), &lists, &transport, &mut out));
            });
            group.bench_function(BenchmarkId::new("light alone", kept), |b| {
                b.iter(|| plan.apply_lists(&source, black_box(&maps), &lists, &mut stored));
            });
            group.bench_function(BenchmarkId::new("by way of stored light", kept), |b| {
                b.iter(|| {
                    plan.apply_lists(&source, black_box(&maps), &lists, &mut stored);
                    out.par_iter_mut().enumerate().for_each(|(v, out)| {
                        let (transport, light) = (&transport[v * kept..][..kept], &stored[3 * v * kept..]);
                        *out = std::array::from_fn(|c| {
                            light[c * kept..].iter().zip(transport).map(|(l, t)| l * t).sum::<f32>()
                        });
                    });
                });
            });
        }
        group.finish();
    }
}

/// A round is PLACES places; criterion wants the time of n of them.
fn per_place(n: u64, mut round: impl FnMut()) -> Duration {
    let rounds = n.div_ceil(PLACES as u64);
    let start = Instant::now();
    (0..rounds).for_each(|_| round());
    start.elapsed().mul_f64(n as f64 / (rounds * PLACES as u64) as f64)
}

fn sweep_case<T: Real, const C: usize>(side: usize, basis: Decomposition, percent: [f64; 2], csv: &mut String) -> f64 {
    let terms = percent.map(|p| ((side * side) as f64 * p / 100.0).ceil() as usize);
    let mut case = Case::<T, C>::new(side, basis, terms[0], terms[1]);
    let choices = case.choices();
    let time = best_of(4, 15, |k| case.run(PropagationRoute::ALL.get(k).copied()));
    let best = time[..3].iter().copied().fold(f64::INFINITY, f64::min);
    let width = 8 * size_of::<T>();
    let line = format!(
        "{basis:?},{side},f{width},{C},{},{},{},{:.0},{:.0},{:.0},{:.0},{:.3},{choices:?}",
        percent[0],
        percent[1],
        terms[0],
        time[0],
        time[1],
        time[2],
        time[3],
        time[3] / best
    );
    eprintln!("{line}");
    writeln!(csv, "{}", line.replace(", ", " ")).expect("a string takes any text");
    time[3] / best
}

fn sweep(file: &str) {
    let mut csv = String::from(
        "basis,side,scalar,channels,source %,target %,terms,wavelets,pixels,lookups,chosen,ratio,choices\n",
    );
    eprint!("{csv}");
    let mut ratios = Vec::new();
    for basis in BASES {
        for side in [16, 32, 64, 128] {
            for source in [0.1, 1.0, 3.0, 10.0, 30.0, 100.0] {
                for target in [1.0, 5.0, 20.0, 100.0] {
                    ratios.push(sweep_case::<f32, 1>(side, basis, [source, target], &mut csv));
                    ratios.push(sweep_case::<f32, 3>(side, basis, [source, target], &mut csv));
                    if side <= 32 {
                        ratios.push(sweep_case::<f64, 1>(side, basis, [source, target], &mut csv));
                    }
                }
            }
        }
    }
    ratios.sort_by(f64::total_cmp);
    let above = ratios.iter().filter(|&&r| r > 1.1).count();
    let (median, worst) = (ratios[ratios.len() / 2], ratios[ratios.len() - 1]);
    eprintln!("chosen against best: median {median:.3}, worst {worst:.3}, above 1.1: {above} of {}", ratios.len());
    std::fs::write(file, csv).expect("the CSV file can be written");
}

fn all(criterion: &mut Criterion) {
    if let Ok(file) = std::env::var("AFFINE_SWEEP") {
        sweep(&file);
        return;
    }
    propagate(criterion);
    zoom(criterion);
    vertices(criterion);
}

criterion_group! {
    name = affine_propagation;
    config = Criterion::default().warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(800));
    targets = all
}
criterion_main!(affine_propagation);
