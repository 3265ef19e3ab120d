//! How wrong a reflectance with few samples a block is, measured before it is used.
//!
//! The error of l × l samples on a block of N pixels is e = ρ̃ − Σ_j ρ̃(node_j) φ_j. What it does to the radiance is at most
//!   free          |Σ L e|   ≤ |Σ L| |mean e| + √(N Σ (L − mean L)²) rms e
//!   partly hidden |Σ L V e| ≤ the less of  √(N Σ L²) rms e  and  N max |L| mean |e|        (Cauchy and Schwarz, Hölder; 0 ≤ V ≤ 1)
//! The three norms of e are tabulated for l = 0 (nothing at all), 1, 2 and 4; those of the light are numbers a block, new with each
//! light. Under a smooth sky a free block so needs few samples of a sharp lobe, where the sun stands it needs them all.
//!
//! | lobe | table over | why that is enough |
//! |---|---|---|
//! | about the mirror direction m | angle of the block's centre to m | ρ̃ = f(m·ω) n·ω: the error is n · (error of f(m·ω) ω), so that the norm of that *vector* bounds all normals |
//! | any other | elevations of viewer and block, azimuth between them; both azimuths unless isotropic | the largest and the smallest shape of block in two orientations, the largest of neighbouring cells |

use nalgebra::{Rotation3, Unit, Vector3};
#[cfg(feature = "rayon")]
use rayon::prelude::*;

use super::interpolation::Interpolation;
use super::layout::BlockLayout;
use crate::scene::Brdf;

/// Norms of the errors of 0, 1, 4 and 16 samples.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Errors {
    rms: [f64; 4],
    /// |mean e|
    bias: [f64; 4],
    /// mean |e|
    mean: [f64; 4],
}

impl Errors {
    /// The larger of each.
    fn worst(self, other: Self) -> Self {
        let larger = |a: [f64; 4], b: [f64; 4]| std::array::from_fn(|k| a[k].max(b[k]));
        Self {
            rms: larger(self.rms, other.rms),
            bias: larger(self.bias, other.bias),
            mean: larger(self.mean, other.mean),
        }
    }
}

impl Errors {
    /// The errors where a function reaches `nearest` somewhere in a block of `side`²: if less was measured than one pixel of that
    /// makes, the places of measurement missed it.
    fn with_a_pixel_of(mut self, nearest: f64, side: usize) -> Self {
        let (rms, mean) = (nearest / side as f64, nearest / (side * side) as f64);
        if self.rms[0] < rms {
            for k in 0..4 {
                self.rms[k] = self.rms[k].max(rms);
                self.bias[k] = self.bias[k].max(mean);
                self.mean[k] = self.mean[k].max(mean);
            }
        }
        self
    }
}

/// [`Errors`] as logarithms: 0 is exactly none, [`NEVER`] more than can be said, k + 1 is k's times the eighth root of 2.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Codes {
    rms: [u8; 4],
    bias: [u8; 4],
    mean: [u8; 4],
}

impl Codes {
    /// Of errors and a tenth more, because they are measured at single places.
    fn new(errors: Errors) -> Self {
        let codes = |errors: [f64; 4]| errors.map(|error| code(1.1 * error));
        Self { rms: codes(errors.rms), bias: codes(errors.bias), mean: codes(errors.mean) }
    }

    fn worse(self, other: Self) -> Self {
        let larger = |a: [u8; 4], b: [u8; 4]| std::array::from_fn(|k| a[k].max(b[k]));
        Self {
            rms: larger(self.rms, other.rms),
            bias: larger(self.bias, other.bias),
            mean: larger(self.mean, other.mean),
        }
    }

    /// The fewest samples of a free block: none, 1, 4, 16, pixels.
    #[inline(always)]
    pub(super) fn free(&self, limits: &Limits, offset: f32) -> u8 {
        let (bias, rms) = (limit(limits.bias - offset), limit(limits.deviation - offset));
        first(std::array::from_fn(|k| self.bias[k] <= bias && self.rms[k] <= rms))
    }

    /// The same of a block that is partly hidden.
    #[inline(always)]
    pub(super) fn mixed(&self, limits: &Limits, offset: f32) -> u8 {
        let (rms, mean) = (limit(limits.rms - offset), limit(limits.mean - offset));
        first(std::array::from_fn(|k| self.rms[k] <= rms || self.mean[k] <= mean))
    }
}

/// The index of the first that holds, or 4.
#[inline(always)]
fn first(holds: [bool; 4]) -> u8 {
    let bits = holds.iter().enumerate().fold(16, |bits, (k, &holds)| bits | u32::from(holds) << k);
    bits.trailing_zeros() as u8
}

/// A limit as a code; an error of 0 is always allowed, one of [`NEVER`] never.
#[inline(always)]
fn limit(limit: f32) -> u8 {
    limit.clamp(0.0, f32::from(NEVER) - 1.0) as u8
}

/// The largest errors that a block's light allows, as codes without offset; see [`threshold`].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Limits {
    /// Of |mean e| and of rms e, in a free block.
    bias: f32,
    deviation: f32,
    /// Of rms e or of mean |e|, in one that is partly hidden.
    rms: f32,
    mean: f32,
    /// How much smaller errors of one sign must be.
    spread: f32,
}

/// √(blocks/2): the sum of as many equal errors as there are blocks above a horizon, over that of independent ones.
pub(super) fn spread(blocks: usize) -> f64 {
    (blocks as f64 / 2.0).sqrt()
}

impl Limits {
    /// `allowed`: the error of the radiance by one of so many blocks.
    pub(super) fn new(allowed: f64, norms: &Norms, blocks: usize) -> Self {
        Self {
            spread: offset(spread(blocks)),
            bias: threshold(0.5 * allowed / norms.sum),
            deviation: threshold(0.5 * allowed / norms.deviation),
            rms: threshold(allowed / norms.rms),
            mean: threshold(allowed / norms.largest),
        }
    }

    /// log₂ of what a pixel may reflect, times the factor of `offset`, and still be left out.
    #[inline(always)]
    pub(super) fn darkness(&self, offset: f32) -> f32 {
        (self.rms.max(self.mean) - self.spread - offset - ZERO as f32) / STEPS as f32
    }
}

/// Norms of the light of a block of N pixels, of its brightest channel.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Norms {
    /// |Σ L|
    pub(super) sum: f64,
    /// √(N Σ (L − mean L)²)
    pub(super) deviation: f64,
    /// √(N Σ L²)
    pub(super) rms: f64,
    /// N max |L|
    pub(super) largest: f64,
}

impl Norms {
    /// Of one channel.
    pub(super) fn new(light: &[f64]) -> Self {
        let n = light.len() as f64;
        let sum: f64 = light.iter().sum();
        let (mut squares, mut deviations, mut largest) = (0.0, 0.0, 0.0_f64);
        for &x in light {
            squares += x * x;
            deviations += (x - sum / n).powi(2);
            largest = largest.max(x.abs());
        }
        Self { sum: sum.abs(), deviation: (n * deviations).sqrt(), rms: (n * squares).sqrt(), largest: n * largest }
    }

    /// The larger of each.
    pub(super) fn larger(self, other: Self) -> Self {
        Self {
            sum: self.sum.max(other.sum),
            deviation: self.deviation.max(other.deviation),
            rms: self.rms.max(other.rms),
            largest: self.largest.max(other.largest),
        }
    }
}

/// Above every threshold.
const NEVER: u8 = u8::MAX;
const STEPS: f64 = 8.0;
const ZERO: f64 = 200.0;

/// Rounded up: an error is never less than its code says.
fn code(error: f64) -> u8 {
    match error {
        0.0 => 0,
        e if e < f64::INFINITY => (ZERO + STEPS * e.log2()).ceil().clamp(1.0, f64::from(NEVER)) as u8,
        _ => NEVER,
    }
}

/// The code of the largest error that is allowed, rounded down; to be lessened by [`offset`]s.
fn threshold(allowed: f64) -> f32 {
    // 0/0, no error allowed of no light: nothing depends on it.
    if allowed.is_nan() { f32::INFINITY } else { (ZERO + STEPS * allowed.log2()).floor() as f32 }
}

/// What a factor of the error adds to its code, rounded up.
pub(super) fn offset(factor: f64) -> f32 {
    (STEPS * factor.log2()).ceil() as f32
}

/// A block's directions where an error is measured, about its centre on +z.
#[derive(Debug, Clone)]
struct Shape {
    /// Directions of pixels, and which pixels they are.
    pixels: Vec<(Vector3<f64>, usize)>,
    /// Directions of the nodes of 1, 4 and 16 samples.
    nodes: [Vec<Vector3<f64>>; 3],
}

/// Blocks of every shape and how functions on them are interpolated.
#[derive(Debug, Clone)]
pub(super) struct Gauge {
    interpolation: Interpolation,
    shapes: Vec<Shape>,
    radius: f64,
    /// Pixels along an edge of a block.
    side: usize,
    /// See [`spread`].
    spread: f64,
}

/// Values of a function, or the components of a vector.
type Values = Vector3<f64>;

impl Gauge {
    pub(super) fn new(layout: &BlockLayout, interpolation: &Interpolation) -> Self {
        let side = layout.side();
        let shape = |&block: &usize| {
            let centre = Unit::new_normalize(layout.centre(block));
            let turn =
                Rotation3::rotation_between(&centre, &Vector3::z_axis()).expect("the centre of +X's block is not -z");
            let at = |x: f64, y: f64| turn * layout.direction(block, x, y);
            let pixels = (0..side * side).map(|p| (at((p % side) as f64, (p / side) as f64), p)).collect();
            let nodes =
                interpolation.levels().each_ref().map(|level| level.nodes.iter().map(|n| at(n[0], n[1])).collect());
            Shape { pixels, nodes }
        };
        let blocks = layout.shapes();
        let radius = blocks.iter().map(|&block| layout.radius(block)).fold(0.0, f64::max);
        Self {
            interpolation: interpolation.clone(),
            shapes: blocks.iter().map(shape).collect(),
            radius,
            side,
            spread: spread(layout.blocks()),
        }
    }

    /// The largest radius of a block.
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// The errors over every `stride`-th pixel of a shape.
    ///
    /// `f` is None below the horizon, where no pixel counts and no sample can be taken.
    fn errors(&self, shape: &Shape, stride: usize, f: impl Fn(&Vector3<f64>) -> Option<Values>) -> Errors {
        let nodes = shape.nodes.each_ref().map(|nodes| nodes.iter().map(&f).collect::<Option<Vec<Values>>>());
        let (mut rms, mut bias, mut mean) = ([0.0; 4], [Values::zeros(); 4], [0.0; 4]);
        let mut count = 0.0;
        // A stride of 3 does not divide a row: all columns have their turn.
        for (direction, pixel) in shape.pixels.iter().skip(stride / 2).step_by(stride) {
            count += 1.0;
            let Some(value) = f(direction) else { continue };
            for k in 0..4 {
                let guess = match k {
                    0 => Values::zeros(),
                    _ => {
                        let Some(nodes) = &nodes[k - 1] else { continue };
                        let cardinals = &self.interpolation.levels()[k - 1].cardinals;
                        nodes.iter().zip(cardinals).map(|(v, c)| v * c[*pixel]).sum()
                    }
                };
                let error: Values = value - guess;
                rms[k] += error.norm_squared();
                mean[k] += error.norm();
                bias[k] += error;
            }
        }
        // What is left out is of one sign: such errors add up over the blocks, others average out.
        let never = |k: usize, x: f64| match k {
            0 => x * self.spread,
            _ if nodes[k - 1].is_none() => f64::INFINITY,
            _ => x,
        };
        Errors {
            rms: std::array::from_fn(|k| never(k, (rms[k] / count).sqrt())),
            bias: std::array::from_fn(|k| never(k, bias[k].norm() / count)),
            mean: std::array::from_fn(|k| never(k, mean[k] / count)),
        }
    }
}

/// Errors for lobes about the mirror direction, over sin(θ/2) of the angle θ between it and a block's centre.
#[derive(Debug, Clone)]
pub(super) struct MirrorBounds {
    cells: Vec<Codes>,
}

/// Cells of a [`MirrorBounds`].
pub(super) const MIRROR_CELLS: usize = 128;

impl MirrorBounds {
    /// Errors of max(cos, 0)^n at the edges of the cells.
    pub(super) fn edges(gauge: &Gauge, exponent: f64) -> Vec<Errors> {
        let edge = |i: usize| {
            let theta = 2.0 * (i as f64 / MIRROR_CELLS as f64).min(1.0).asin();
            let azimuths = (0..4).map(|k| (k as f64 * 0.5 + 0.25) * std::f64::consts::FRAC_PI_2);
            let mut most = Errors::default();
            for azimuth in azimuths {
                let (s, c) = theta.sin_cos();
                let mirror = Vector3::new(s * azimuth.cos(), s * azimuth.sin(), c);
                for shape in &gauge.shapes {
                    let lobe = |d: &Vector3<f64>| {
                        Some(d * mirror.dot(d).max(0.0).powf(exponent) * f64::from(mirror.dot(d) > 0.0))
                    };
                    most = most.worst(gauge.errors(shape, 1, lobe));
                }
            }
            // From here to the next edge towards the mirror direction.
            let before = 2.0 * ((i as f64 - 1.0) / MIRROR_CELLS as f64).max(0.0).asin();
            let nearest = (before - gauge.radius).max(0.0).cos();
            most.with_a_pixel_of(if nearest > 0.0 { nearest.powf(exponent) } else { 0.0 }, gauge.side)
        };
        each(MIRROR_CELLS + 1, edge)
    }

    /// The worse of two exponents' errors, and of a cell's two edges.
    pub(super) fn between(low: &[Errors], high: &[Errors]) -> Self {
        let both = |i: usize| low[i].worst(high[i]);
        Self { cells: (0..MIRROR_CELLS).map(|i| Codes::new(both(i).worst(both(i + 1)))).collect() }
    }

    pub(super) fn cells(&self) -> &[Codes] {
        &self.cells
    }
}

/// Errors for other lobes.
#[derive(Debug, Clone)]
pub(super) struct WideBounds {
    isotropic: bool,
    cells: Vec<Codes>,
}

/// Cells along the elevation of the viewer, his azimuth, the elevation of the block, its azimuth (half of it if isotropic).
const WIDE: [usize; 4] = [10, 16, 14, 24];

impl WideBounds {
    /// Measures a BRDF.
    pub(super) fn new(gauge: &Gauge, brdf: &dyn Brdf, isotropic: bool) -> Self {
        let counts = Self::counts(isotropic);
        let raw = each(counts.iter().product(), |cell| Self::measure(gauge, brdf, isotropic, cell));
        let cells = (0..raw.len()).map(|cell| Codes::new(Self::widest(&raw, isotropic, cell))).collect();
        Self { isotropic, cells }
    }

    /// The worse of both, cell by cell.
    ///
    /// # Panics
    /// If only one is isotropic.
    pub(super) fn worse(mut self, other: &Self) -> Self {
        assert_eq!(self.isotropic, other.isotropic, "bounds of lobes of one kind");
        for (a, b) in self.cells.iter_mut().zip(&other.cells) {
            *a = a.worse(*b);
        }
        self
    }

    fn counts(isotropic: bool) -> [usize; 4] {
        if isotropic { [WIDE[0], 1, WIDE[2], WIDE[3] / 2] } else { WIDE }
    }

    fn split(isotropic: bool, mut cell: usize) -> [usize; 4] {
        let counts = Self::counts(isotropic);
        let mut parts = [0; 4];
        for k in (0..4).rev() {
            parts[k] = cell % counts[k];
            cell /= counts[k];
        }
        parts
    }

    /// The errors with viewer and block in the middle of their cells.
    fn measure(gauge: &Gauge, brdf: &dyn Brdf, isotropic: bool, cell: usize) -> Errors {
        let counts = Self::counts(isotropic);
        let parts = Self::split(isotropic, cell);
        let coloured = brdf.colour().is_none();
        let at = |k: usize| (parts[k] as f64 + 0.5) / counts[k] as f64;
        let wo = direction(at(0) * 0.5_f64.sqrt(), if isotropic { 0.0 } else { 4.0 * at(1) });
        let centre =
            Unit::new_normalize(direction(at(2) * Self::lowest(gauge), at(3) * if isotropic { 2.0 } else { 4.0 }));
        let place = Rotation3::rotation_between(&Vector3::z_axis(), &centre).unwrap_or_else(Rotation3::identity);
        let mut most = Errors::default();
        for roll in [0.0, std::f64::consts::FRAC_PI_4] {
            let turn = place * Rotation3::from_axis_angle(&Vector3::z_axis(), roll);
            for shape in [&gauge.shapes[0], &gauge.shapes[gauge.shapes.len() - 1]] {
                let value = |d: &Vector3<f64>| {
                    let wi = turn * d;
                    let value = (wi.z > 0.0).then(|| brdf.eval(&wi, &wo) * wi.z);
                    value.map(|v| if coloured { v } else { Vector3::new(v.max(), 0.0, 0.0) })
                };
                most = most.worst(gauge.errors(shape, 3, value));
            }
        }
        // The peak of a lobe that is narrower than a pixel.
        let mirror = Vector3::new(-wo.x, -wo.y, wo.z);
        let peak = if mirror.angle(&centre) <= gauge.radius { brdf.eval(&mirror, &wo).max() * mirror.z } else { 0.0 };
        most.with_a_pixel_of(peak, gauge.side)
    }

    /// sin(θ/2) of the lowest centre of a block that still reaches the horizon.
    fn lowest(gauge: &Gauge) -> f64 {
        (0.5 * (std::f64::consts::FRAC_PI_2 + gauge.radius)).sin()
    }

    /// The largest errors of a cell and its neighbours: azimuths go round, or are mirrored at the ends of a half.
    fn widest(raw: &[Errors], isotropic: bool, cell: usize) -> Errors {
        let counts = Self::counts(isotropic);
        let parts = Self::split(isotropic, cell);
        let near = |k: usize| {
            let (n, p, round) = (counts[k], parts[k], !isotropic && k % 2 == 1);
            let before = if p > 0 {
                p - 1
            } else if round {
                n - 1
            } else {
                p
            };
            let after = if p + 1 < n {
                p + 1
            } else if round {
                0
            } else {
                p
            };
            [before, p, after]
        };
        let mut most = Errors::default();
        for a in near(0) {
            for b in near(1) {
                for c in near(2) {
                    for d in near(3) {
                        most = most.worst(raw[((a * counts[1] + b) * counts[2] + c) * counts[3] + d]);
                    }
                }
            }
        }
        most
    }

    /// A look-up for one viewer.
    pub(super) fn seen_from(&self, radius: f64, wo: &Vector3<f64>) -> WideView<'_> {
        let counts = Self::counts(self.isotropic);
        let elevation = cell_of(half_sine(wo.z as f32) * std::f32::consts::SQRT_2, counts[0]);
        let azimuth = if self.isotropic { 0 } else { cell_of(0.25 * diamond(wo.x as f32, wo.y as f32), counts[1]) };
        let plane = counts[2] * counts[3];
        let flat = (wo.x * wo.x + wo.y * wo.y).sqrt();
        // An isotropic lobe is looked up in the viewer's own azimuth.
        let along = if self.isotropic && flat > 0.0 { [wo.x / flat, wo.y / flat] } else { [1.0, 0.0] };
        WideView {
            cells: &self.cells[(elevation * counts[1] + azimuth) * plane..][..plane],
            counts: [counts[2], counts[3]],
            scale: 1.0 / (0.5 * (std::f64::consts::FRAC_PI_2 + radius)).sin() as f32,
            along: along.map(|x| x as f32),
            isotropic: self.isotropic,
        }
    }
}

/// The errors of a lobe for one viewer.
#[derive(Debug, Clone, Copy)]
pub(super) struct WideView<'a> {
    cells: &'a [Codes],
    counts: [usize; 2],
    scale: f32,
    along: [f32; 2],
    isotropic: bool,
}

impl WideView<'_> {
    /// The errors of a block whose centre is at `d`, in local coordinates.
    #[inline(always)]
    pub(super) fn codes(&self, d: [f32; 3]) -> Codes {
        let elevation = cell_of(half_sine(d[2]) * self.scale, self.counts[0]);
        let (x, y) = (d[0] * self.along[0] + d[1] * self.along[1], d[1] * self.along[0] - d[0] * self.along[1]);
        let turn = if self.isotropic { 0.5 * diamond(x, y.abs()) } else { 0.25 * diamond(x, y) };
        self.cells[elevation * self.counts[1] + cell_of(turn, self.counts[1])]
    }
}

#[inline(always)]
fn cell_of(at: f32, count: usize) -> usize {
    ((at * count as f32) as usize).min(count - 1)
}

/// sin(θ/2) from cos θ.
#[inline(always)]
fn half_sine(cosine: f32) -> f32 {
    (0.5 - 0.5 * cosine).max(0.0).sqrt()
}

/// A number in [0, 4) that grows with the azimuth of (x, y), without trigonometry: the way round a square. 0 for the centre.
#[inline(always)]
fn diamond(x: f32, y: f32) -> f32 {
    let size = x.abs() + y.abs();
    let t = if size > 0.0 { y / size } else { 0.0 };
    match (x >= 0.0, t >= 0.0) {
        (true, true) => t,
        (false, _) => 2.0 - t,
        (true, false) => 4.0 + t,
    }
}

/// The direction of sin(θ/2) and of a way round the square.
fn direction(half_sine: f64, diamond: f64) -> Vector3<f64> {
    let (quarter, t) = (diamond as usize % 4, diamond.fract());
    let (x, y) = match quarter {
        0 => (1.0 - t, t),
        1 => (-t, 1.0 - t),
        2 => (t - 1.0, -t),
        _ => (t, t - 1.0),
    };
    let (z, size) = (1.0 - 2.0 * half_sine * half_sine, x.hypot(y));
    let flat = (1.0 - z * z).max(0.0).sqrt();
    Vector3::new(flat * x / size, flat * y / size, z)
}

/// Runs `one` for 0…count, in parallel.
fn each(count: usize, one: impl Fn(usize) -> Errors + Send + Sync) -> Vec<Errors> {
    #[cfg(feature = "rayon")]
    return (0..count).into_par_iter().map(one).collect();
    #[cfg(not(feature = "rayon"))]
    return (0..count).map(one).collect();
}
