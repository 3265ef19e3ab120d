//! What carries a light to a place, against the clock: the engine's routes, a dense operator, a summed-area table.
//!
//! The bench `affine_propagation` uses this file too.

use std::hint::black_box;
use std::time::{Duration, Instant};

use haarmonic::Real;
use haarmonic::affine::{
    AffineMap, Atom, Mother, Propagation, PropagationRoute, PropagationScratch, PropagationSource, Targets,
    canonical_batch,
};
use haarmonic::haar::{Decomposition, Keep, Selection, SparseVector, Transform2d, forward_2d};
use pulp::Arch;

/// Places of a round.
pub const PLACES: usize = 64;
/// The least time of a contender's turn.
const TURN: Duration = Duration::from_millis(2);

/// A textured lamp: a gradient, discs of several colours, a grid of bars and some grain.
pub fn light<T: Real>(side: usize, channel: usize) -> Vec<T> {
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
pub fn places() -> Vec<[AffineMap; 2]> {
    let mut random = Weyl(0.31);
    let mut place = || {
        let s = (4.0f64).powf(random.next() - 0.5);
        [0, 1].map(|_| AffineMap::new(s, 0.5 - 0.5 * s + 0.6 * (random.next() - 0.5)).expect("s is near 1"))
    };
    (0..PLACES).map(|_| place()).collect()
}

/// One setting: a source of some terms, targets, memory.
pub struct Case<T, const C: usize> {
    plan: Propagation<T>,
    source: PropagationSource<T, C>,
    targets: Targets,
    pub places: Vec<[AffineMap; 2]>,
    /// The last result, channel by channel.
    pub out: Vec<T>,
    scratch: PropagationScratch<T>,
}

impl<T: Real, const C: usize> Case<T, C> {
    pub fn new(side: usize, basis: Decomposition, source_terms: usize, target_terms: usize) -> Self {
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
    pub fn run(&mut self, route: Option<PropagationRoute>) {
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
    pub fn choices(&self) -> [usize; 3] {
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

/// The dense operator: every coupling of two axes by the batch, then two dense matrix products a channel.
pub struct Dense {
    side: usize,
    /// [mother][function]: t + ½ and so on of the 1D basis.
    atoms: Vec<Atom>,
    r: Vec<f64>,
    c: Vec<f64>,
    m: Vec<f64>,
    /// D_xᵀ and D_y.
    operator: [Vec<f32>; 2],
    half: Vec<f32>,
    arch: Arch,
}

impl Dense {
    pub fn new(side: usize) -> Self {
        let atoms = (0..side).map(Atom::from_flat).collect();
        let zeros = vec![0.0; side];
        let operator = [vec![0.0; side * side], vec![0.0; side * side]];
        let [r, c, m] = [zeros.clone(), zeros.clone(), zeros];
        Self { side, atoms, r, c, m, operator, half: vec![0.0; side * side], arch: Arch::new() }
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
                self.operator[axis][[i * n + j, j * n + i][axis]] = (factor * self.m[j]) as f32;
            }
        }
    }

    /// Carries a light's channels (coefficients) to a place.
    pub fn apply(&mut self, channels: &[Vec<f32>], maps: [AffineMap; 2], out: &mut [f32]) {
        self.set(0, maps[0]);
        self.set(1, maps[1]);
        let (n, [x, y], half) = (self.side, &self.operator, &mut self.half);
        for (light, out) in channels.iter().zip(out.chunks_exact_mut(n * n)) {
            // L = D_y F D_xᵀ, rows of F by y.
            self.arch.dispatch(|| {
                multiply(n, y, light, half);
                multiply(n, half, x, out);
            });
        }
    }
}

#[inline(always)]
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

/// The honest pixel route by a summed-area table: averages over the targets' cells as differences of four bilinear
/// look-ups, then the Haar transform.
pub struct Table {
    side: usize,
    /// One table a channel.
    sums: Vec<Vec<f64>>,
    /// Cell and share of it, of each column of corners.
    columns: Vec<(usize, f64)>,
    corners: Vec<f64>,
    pixels: Vec<f32>,
    transform: Transform2d<f32>,
    scratch: Vec<f32>,
    arch: Arch,
}

impl Table {
    /// A light's channels (pixels), tabulated.
    pub fn new(side: usize, basis: Decomposition, channels: &[Vec<f32>]) -> Self {
        let transform = Transform2d::new(side, side, basis).expect("2^k");
        let scratch = vec![0.0; transform.scratch_len()];
        let (pitch, columns) = (side + 1, vec![(0, 0.0); side + 1]);
        let sums = channels.iter().map(|_| vec![0.0; pitch * pitch]).collect();
        let (corners, pixels) = (vec![0.0; pitch * pitch], vec![0.0; side * side]);
        let mut table = Self { side, sums, columns, corners, pixels, transform, scratch, arch: Arch::new() };
        channels.iter().enumerate().for_each(|(c, pixels)| table.set(c, pixels));
        table
    }

    /// Tabulates another image as a channel.
    pub fn set(&mut self, channel: usize, pixels: &[f32]) {
        let (side, pitch, sums) = (self.side, self.side + 1, &mut self.sums[channel]);
        for y in 0..side {
            let mut row = 0.0;
            for x in 0..side {
                row += f64::from(pixels[y * side + x]);
                sums[(y + 1) * pitch + x + 1] = sums[y * pitch + x + 1] + row;
            }
        }
    }

    /// Carries all channels to a place.
    pub fn apply(&mut self, maps: [AffineMap; 2], out: &mut [f32]) {
        let n = self.side;
        let place = |k: usize, map: AffineMap| {
            let x = (map.apply(k as f64 / n as f64) * n as f64).clamp(0.0, n as f64);
            let cell = (x as usize).min(n - 1);
            (cell, x - cell as f64)
        };
        self.columns.iter_mut().enumerate().for_each(|(k, column)| *column = place(k, maps[0]));
        let area = 1.0 / (maps[0].scale() * maps[1].scale());
        let Self { sums, columns, corners, pixels, transform, scratch, arch, .. } = self;
        for (sums, out) in sums.iter().zip(out.chunks_exact_mut(n * n)) {
            arch.dispatch(|| {
                for (ky, corners) in corners.chunks_exact_mut(n + 1).enumerate() {
                    look_up(sums, columns, place(ky, maps[1]), corners);
                }
                differences(n, corners, area, pixels);
            });
            transform.forward(pixels, out, scratch);
        }
    }
}

/// One row of corners.
#[inline(always)]
fn look_up(sums: &[f64], columns: &[(usize, f64)], (y, fy): (usize, f64), corners: &mut [f64]) {
    let pitch = columns.len();
    let (upper, lower) = (&sums[y * pitch..][..pitch], &sums[(y + 1) * pitch..][..pitch]);
    for (corner, &(x, fx)) in corners.iter_mut().zip(columns) {
        let (s, t) = (&upper[x..][..2], &lower[x..][..2]);
        let (s, t) = (s[0] + fx * (s[1] - s[0]), t[0] + fx * (t[1] - t[0]));
        *corner = s + fy * (t - s);
    }
}

#[inline(always)]
fn differences(n: usize, corners: &[f64], area: f64, pixels: &mut [f32]) {
    for (y, pixels) in pixels.chunks_exact_mut(n).enumerate() {
        let [s, t] = [y, y + 1].map(|y| &corners[y * (n + 1)..][..n + 1]);
        for (x, pixel) in pixels.iter_mut().enumerate() {
            *pixel = (((t[x + 1] - t[x]) - (s[x + 1] - s[x])) * area) as f32;
        }
    }
}

/// Nanoseconds a place of each contender: the best of rounds taken in turn, so that all of them see the same machine.
///
/// A turn is one run over all places, more while they take less than [`TURN`]: the first finds the caches full of
/// another's data.
pub fn best_of(contenders: usize, rounds: usize, mut run: impl FnMut(usize)) -> Vec<f64> {
    let mut best = vec![f64::INFINITY; contenders];
    for _ in 0..rounds {
        for (k, best) in best.iter_mut().enumerate() {
            let turn = Instant::now();
            loop {
                let start = Instant::now();
                run(k);
                *best = best.min(start.elapsed().as_secs_f64() * 1e9 / PLACES as f64);
                if turn.elapsed() >= TURN {
                    break;
                }
            }
        }
    }
    best
}
