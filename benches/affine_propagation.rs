//! Carrying a 32² or 64² light to a place: routes, the dense operator and a summed-area table, against terms kept; and a zoom
//! without decompression.
//!
//! A place is one pair of maps, 64 of them in turn, as a renderer goes from vertex to vertex; s between ½ and 2. Times are per place.
//! `AFFINE_SWEEP=FILE` measures every route over terms kept at source and target, prints the engine's choice against the best and
//! writes FILE as CSV.
#![expect(clippy::print_stderr, reason = "the sweep is a table for people")]

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use haarmonic::Real;
use haarmonic::affine::{
    AffineMap, Atom, Mother, Propagation, PropagationRoute, PropagationScratch, PropagationSource, Targets,
    canonical_batch,
};
use haarmonic::haar::{Decomposition, Keep, Selection, SparseVector, Transform2d, forward_2d};

const PLACES: usize = 64;
const BASES: [Decomposition; 2] = [Decomposition::Standard, Decomposition::Nonstandard];

/// A textured lamp: a gradient, discs of several colours, a grid of bars and some grain.
fn light<T: Real>(side: usize, channel: usize) -> Vec<T> {
    let value = |x: usize, y: usize| {
        let (u, v) = ((x as f64 + 0.5) / side as f64, (y as f64 + 0.5) / side as f64);
        let mut sum = 0.3 + 0.3 * u * v + 0.05 * channel as f64;
        for k in 0..7usize {
            let (cu, cv) = (((k * 37 + 11) % 97) as f64 / 97.0, ((k * 53 + 29) % 89) as f64 / 89.0);
            if (u - cu).hypot(v - cv) < 0.06 + 0.012 * k as f64 {
                sum += 1.0 + 0.3 * ((channel + k) % 3) as f64;
            }
        }
        sum + if (u * 11.0).fract() < 0.2 { 0.1 } else { 0.0 }
            + 0.02 * (((x * 7919 + y * 104_729) % 101) as f64 / 101.0)
    };
    (0..side * side).map(|i| T::of(value(i % side, i / side))).collect()
}

/// Numbers in [0, 1) that do not repeat soon.
struct Weyl(f64);

impl Weyl {
    fn next(&mut self) -> f64 {
        self.0 = (self.0 + 0.754_877_666_246_692_8).fract();
        self.0
    }
}

/// Places whose view shows most of the light.
fn places() -> Vec<[AffineMap; 2]> {
    let mut random = Weyl(0.31);
    let mut place = || {
        let s = (4.0f64).powf(random.next() - 0.5);
        [0, 1].map(|_| AffineMap::new(s, 0.5 - 0.5 * s + 0.6 * (random.next() - 0.5)).expect("s is near 1"))
    };
    (0..PLACES).map(|_| place()).collect()
}

/// One setting: a source of some terms, targets, memory.
struct Case<T, const C: usize> {
    plan: Propagation<T>,
    source: PropagationSource<T, C>,
    targets: Targets,
    places: Vec<[AffineMap; 2]>,
    out: Vec<T>,
    scratch: PropagationScratch<T>,
}

impl<T: Real, const C: usize> Case<T, C> {
    fn new(side: usize, basis: Decomposition, source_terms: usize, target_terms: usize) -> Self {
        let coefs: [Vec<T>; C] = std::array::from_fn(|c| forward_2d(&light(side, c), side, side, basis).expect("2^k"));
        let selection = Selection::new(Keep::Terms(source_terms));
        let terms: [SparseVector<T>; C] =
            selection.apply_channels(coefs.each_ref().map(Vec::as_slice)).expect("one length");
        let source = PropagationSource::new(side, basis, terms.each_ref()).expect("2^k");
        let plan = Propagation::new(side, basis).expect("2^k");
        let all = Targets::all(side, basis).expect("2^k");
        let places = places();
        let mut scratch = PropagationScratch::new();
        let targets = if target_terms == side * side {
            all
        } else {
            // The targets that hold the most energy over all places.
            let mut energy = vec![0.0; side * side];
            let mut out = vec![T::zero(); C * side * side];
            for &maps in &places {
                plan.apply_by(
                    PropagationRoute::Pixels,
                    &source,
                    maps,
                    &all,
                    planes(&mut out, side * side),
                    &mut scratch,
                );
                out.iter().enumerate().for_each(|(k, l)| energy[k % (side * side)] += l.widen() * l.widen());
            }
            let mut order: Vec<u32> = (0..(side * side) as u32).collect();
            order.sort_by(|&a, &b| energy[b as usize].total_cmp(&energy[a as usize]));
            order.truncate(target_terms);
            order.sort_unstable();
            Targets::new(side, basis, &order).expect("indices of the image")
        };
        let out = vec![T::zero(); C * targets.len()];
        Self { plan, source, targets, places, out, scratch }
    }

    /// All places once, by a route or by the engine's choice.
    fn run(&mut self, route: Option<PropagationRoute>) {
        let Self { plan, source, targets, places, out, scratch } = self;
        for &maps in places.iter() {
            let (maps, out) = (black_box(maps), planes(out, targets.len()));
            match route {
                None => plan.apply(source, maps, targets, out, scratch),
                Some(route) => plan.apply_by(route, source, maps, targets, out, scratch),
            }
        }
        black_box(out);
    }

    /// How often the engine picks each route.
    fn choices(&self) -> [usize; 3] {
        let mut count = [0; 3];
        for &maps in &self.places {
            count[self.plan.route(&self.source, maps, &self.targets) as usize] += 1;
        }
        count
    }
}

fn planes<T, const C: usize>(all: &mut [T], len: usize) -> [&mut [T]; C] {
    let mut rest = all;
    std::array::from_fn(|_| {
        let (plane, others) = std::mem::take(&mut rest).split_at_mut(len);
        rest = others;
        plane
    })
}

/// The dense operator: every coupling of two axes by the batch, then two dense matrix products.
struct Dense {
    side: usize,
    /// [mother][function]: t + ½ and so on of the 1D basis.
    atoms: Vec<Atom>,
    r: Vec<f64>,
    c: Vec<f64>,
    m: Vec<f64>,
    operator: [Vec<f32>; 2],
    half: Vec<f32>,
}

impl Dense {
    fn new(side: usize) -> Self {
        let atoms = (0..side).map(Atom::from_flat).collect();
        let zeros = vec![0.0; side];
        let operator = [vec![0.0; side * side], vec![0.0; side * side]];
        Self { side, atoms, r: zeros.clone(), c: zeros.clone(), m: zeros, operator, half: vec![0.0; side * side] }
    }

    fn set(&mut self, axis: usize, map: AffineMap) {
        let n = self.side;
        for i in 0..n {
            let source = self.atoms[i];
            let width = (-(source.level as f64)).exp2();
            let centre = map.solve((source.offset as f64 + 0.5) * width);
            let radius = 0.5 * width / map.scale();
            for j in 0..n {
                let cells = (self.atoms[j].level as f64).exp2();
                (self.r[j], self.c[j]) = (radius * cells, centre * cells - self.atoms[j].offset as f64);
            }
            canonical_batch(source.mother, Mother::Scaling, &self.r[..1], &self.c[..1], &mut self.m[..1]);
            canonical_batch(source.mother, Mother::Wavelet, &self.r[1..], &self.c[1..], &mut self.m[1..]);
            for j in 0..n {
                let factor = ((f64::from(source.level) - f64::from(self.atoms[j].level)) / 2.0).exp2();
                self.operator[axis][j * n + i] = (factor * self.m[j]) as f32;
            }
        }
    }

    fn apply(&mut self, light: &[f32], maps: [AffineMap; 2], out: &mut [f32]) {
        self.set(0, maps[0]);
        self.set(1, maps[1]);
        let n = self.side;
        // L = D_y F D_xᵀ, rows of F by y.
        multiply(n, &self.operator[1], light, &mut self.half);
        for (row, out) in self.half.chunks_exact(n).zip(out.chunks_exact_mut(n)) {
            for (k, out) in out.iter_mut().enumerate() {
                let d = &self.operator[0][k * n..][..n];
                *out = d.iter().zip(row).map(|(d, f)| d * f).sum();
            }
        }
    }
}

fn multiply(n: usize, a: &[f32], b: &[f32], out: &mut [f32]) {
    out.fill(0.0);
    for y in 0..n {
        let row = &mut out[y * n..][..n];
        for k in 0..n {
            let w = a[y * n + k];
            row.iter_mut().zip(&b[k * n..][..n]).for_each(|(out, b)| *out += w * b);
        }
    }
}

/// The honest pixel route by a summed-area table: averages over the targets' cells as differences of four bilinear look-ups.
struct Table {
    side: usize,
    sums: Vec<f64>,
    corners: Vec<f64>,
    pixels: Vec<f32>,
    transform: Transform2d<f32>,
    scratch: Vec<f32>,
}

impl Table {
    fn new(side: usize, basis: Decomposition) -> Self {
        let transform = Transform2d::new(side, side, basis).expect("2^k");
        let scratch = vec![0.0; transform.scratch_len()];
        let corners = vec![0.0; (side + 1) * (side + 1)];
        Self { side, sums: corners.clone(), corners, pixels: vec![0.0; side * side], transform, scratch }
    }

    fn set(&mut self, pixels: &[f32]) {
        let (n, pitch) = (self.side, self.side + 1);
        for y in 0..n {
            let mut row = 0.0;
            for x in 0..n {
                row += f64::from(pixels[y * n + x]);
                self.sums[(y + 1) * pitch + x + 1] = self.sums[y * pitch + x + 1] + row;
            }
        }
    }

    fn resample(&mut self, maps: [AffineMap; 2]) {
        let (n, pitch) = (self.side, self.side + 1);
        let place = |k: usize, map: AffineMap| {
            let x = (map.apply(k as f64 / n as f64) * n as f64).clamp(0.0, n as f64);
            let cell = (x as usize).min(n - 1);
            (cell, x - cell as f64)
        };
        for ky in 0..pitch {
            let (y, fy) = place(ky, maps[1]);
            for kx in 0..pitch {
                let (x, fx) = place(kx, maps[0]);
                let at = y * pitch + x;
                let (s, t) = (&self.sums[at..][..2], &self.sums[at + pitch..][..2]);
                let (upper, lower) = (s[0] + fx * (s[1] - s[0]), t[0] + fx * (t[1] - t[0]));
                self.corners[ky * pitch + kx] = upper + fy * (lower - upper);
            }
        }
        let area = 1.0 / (maps[0].scale() * maps[1].scale());
        for y in 0..n {
            for x in 0..n {
                let (s, t) = (&self.corners[y * pitch + x..][..2], &self.corners[(y + 1) * pitch + x..][..2]);
                self.pixels[y * n + x] = (((t[1] - t[0]) - (s[1] - s[0])) * area) as f32;
            }
        }
    }

    fn apply(&mut self, maps: [AffineMap; 2], out: &mut [f32]) {
        self.resample(maps);
        self.transform.forward(&self.pixels, out, &mut self.scratch);
    }
}

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
            let mut table = Table::new(side, basis);
            table.set(&image);
            let (places, mut out) = (places(), vec![0.0; area]);
            group.bench_function("all terms, summed-area table", |b| {
                b.iter_custom(|n| {
                    per_place(n, || places.iter().for_each(|&maps| table.apply(black_box(maps), &mut out)))
                });
            });
            if basis == Decomposition::Standard {
                let coefs = forward_2d(&image, side, side, basis).expect("2^k");
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

/// A window of a compressed image, four times as large: in the wavelet domain, and by decompression, resampling and transformation.
///
/// Neither side selects terms of the result. The peer resamples by a summed-area table, or by the bands of the engine's pixel route.
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
            let (mut table, mut image, mut out) = (Table::new(side, basis), vec![0.0; area], vec![0.0; area]);
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
                        table.set(&image);
                        table.apply(black_box(window), &mut out);
                    });
                });
            }
            group.finish();
        }
    }
}

/// A round is PLACES places; criterion wants the time of n of them.
fn per_place(n: u64, mut round: impl FnMut()) -> Duration {
    let rounds = n.div_ceil(PLACES as u64);
    let start = Instant::now();
    (0..rounds).for_each(|_| round());
    start.elapsed().mul_f64(n as f64 / (rounds * PLACES as u64) as f64)
}

/// Nanoseconds a place of each contender: the best of rounds taken in turn, so that all of them see the same machine.
fn best_of(contenders: &mut [&mut dyn FnMut()]) -> Vec<f64> {
    let mut best = vec![f64::INFINITY; contenders.len()];
    contenders.iter_mut().for_each(|run| run());
    for _ in 0..15 {
        for (run, best) in contenders.iter_mut().zip(&mut best) {
            let start = Instant::now();
            run();
            *best = best.min(start.elapsed().as_secs_f64() * 1e9 / PLACES as f64);
        }
    }
    best
}

fn sweep_case<T: Real, const C: usize>(side: usize, basis: Decomposition, percent: [f64; 2], csv: &mut String) -> f64 {
    let terms = percent.map(|p| ((side * side) as f64 * p / 100.0).ceil() as usize);
    let mut cases: Vec<Case<T, C>> = (0..4).map(|_| Case::new(side, basis, terms[0], terms[1])).collect();
    let choices = cases[0].choices();
    let [wavelets, pixels, lookups, chosen] = &mut cases[..] else { unreachable!() };
    let time = best_of(&mut [
        &mut || wavelets.run(Some(PropagationRoute::Wavelets)),
        &mut || pixels.run(Some(PropagationRoute::Pixels)),
        &mut || lookups.run(Some(PropagationRoute::Lookups)),
        &mut || chosen.run(None),
    ]);
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
}

criterion_group! {
    name = affine_propagation;
    config = Criterion::default().warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(800));
    targets = all
}
criterion_main!(affine_propagation);
