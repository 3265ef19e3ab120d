//! How wrong a reflectance with few samples a block is, measured before it is used.
//!
//! The error of l × l samples on a block is e = ρ̃ − Σ_j ρ̃(node_j) φ_j, and what it does to the radiance is at most
//!   |Σ L V e| ≤ ‖L‖ ‖e‖                                           (Cauchy and Schwarz; ‖L‖ over the block, V ≤ 1).
//! The root mean square of e is tabulated for l = 0 (nothing at all), 1, 2 and 4; ‖L‖ is a number a block, new with each light.
//!
//! | lobe | table over | why that is enough |
//! |---|---|---|
//! | about the mirror direction m | angle of the block's centre to m | ρ̃ = f(m·ω) n·ω: the error is n · (error of f(m·ω) ω), so that the norm of that *vector* bounds all normals |
//! | any other | elevations of viewer and block, azimuth between them; both azimuths unless isotropic | every shape of block in two orientations, the largest of neighbouring cells |

use nalgebra::{Rotation3, Unit, Vector3};
#[cfg(feature = "rayon")]
use rayon::prelude::*;

use super::interpolation::Interpolation;
use super::layout::BlockLayout;
use crate::scene::Brdf;

/// Errors of 0, 1, 4 and 16 samples as logarithms: 0 is exactly none, [`NEVER`] more than can be said, k + 1 is twice k's to the
/// eighth root.
pub(super) type Codes = [u8; 4];

/// Above every threshold.
pub(super) const NEVER: u8 = u8::MAX;
const STEPS: f64 = 8.0;
const ZERO: f64 = 200.0;

/// Rounded up: an error is never less than its code says.
fn code(error: f64) -> u8 {
    match error {
        e if e == 0.0 => 0,
        e if e < f64::INFINITY => (ZERO + STEPS * e.log2()).ceil().clamp(1.0, f64::from(NEVER)) as u8,
        _ => NEVER,
    }
}

/// The codes of errors and a tenth more, because they are measured at single places: the smallest error of up to so many samples,
/// so that the codes that are too large count the samples that are needed.
fn codes(errors: [f64; 4]) -> Codes {
    let mut least = NEVER;
    errors.map(|error| {
        least = least.min(code(1.1 * error));
        least
    })
}

/// The code of the largest error that is allowed, rounded down; to be lessened by [`offset`]s.
pub(super) fn threshold(allowed: f64) -> f32 {
    (ZERO + STEPS * allowed.log2()).floor() as f32
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
        Self { interpolation: interpolation.clone(), shapes: blocks.iter().map(shape).collect(), radius }
    }

    /// The largest radius of a block.
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// Root mean squares of the error of 0, 1, 4 and 16 samples, over pixels `first`, `first` + `stride`, … of a shape.
    ///
    /// `f` is None below the horizon, where no pixel counts and no sample can be taken.
    fn errors(&self, shape: &Shape, stride: usize, f: impl Fn(&Vector3<f64>) -> Option<Values>) -> [f64; 4] {
        let mut sums = [0.0; 4];
        let nodes = shape.nodes.each_ref().map(|nodes| nodes.iter().map(&f).collect::<Option<Vec<Values>>>());
        // A stride of 3 does not divide a row: all columns have their turn.
        let pixels = shape.pixels.iter().skip(stride / 2).step_by(stride);
        let mut count = 0;
        for (direction, pixel) in pixels {
            count += 1;
            let Some(value) = f(direction) else { continue };
            sums[0] += value.norm_squared();
            for ((sum, nodes), level) in sums[1..].iter_mut().zip(&nodes).zip(self.interpolation.levels()) {
                if let Some(nodes) = nodes {
                    let guess: Values = nodes.iter().zip(&level.cardinals).map(|(v, c)| v * c[*pixel]).sum();
                    *sum += (value - guess).norm_squared();
                }
            }
        }
        let mut errors = sums.map(|sum| (sum / f64::from(count)).sqrt());
        for (error, nodes) in errors[1..].iter_mut().zip(&nodes) {
            if nodes.is_none() {
                *error = f64::INFINITY;
            }
        }
        errors
    }
}

/// The largest of two sets of errors.
fn worst(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    std::array::from_fn(|k| a[k].max(b[k]))
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
    pub(super) fn edges(gauge: &Gauge, exponent: f64) -> Vec<[f64; 4]> {
        let edge = |i: usize| {
            let theta = 2.0 * (i as f64 / MIRROR_CELLS as f64).min(1.0).asin();
            let azimuths = (0..4).map(|k| (k as f64 * 0.5 + 0.25) * std::f64::consts::FRAC_PI_2);
            let mut most = [0.0; 4];
            for azimuth in azimuths {
                let (s, c) = theta.sin_cos();
                let mirror = Vector3::new(s * azimuth.cos(), s * azimuth.sin(), c);
                for shape in &gauge.shapes {
                    let lobe = |d: &Vector3<f64>| {
                        Some(d * mirror.dot(d).max(0.0).powf(exponent) * f64::from(mirror.dot(d) > 0.0))
                    };
                    most = worst(most, gauge.errors(shape, 1, lobe));
                }
            }
            most
        };
        each(MIRROR_CELLS + 1, edge)
    }

    /// The worse of two exponents' errors, and of a cell's two edges.
    pub(super) fn between(low: &[[f64; 4]], high: &[[f64; 4]]) -> Self {
        let both = |i: usize| worst(low[i], high[i]);
        let cell = |i: usize| codes(worst(both(i), both(i + 1)));
        Self { cells: (0..MIRROR_CELLS).map(cell).collect() }
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
        let cells = (0..raw.len()).map(|cell| codes(Self::widest(&raw, isotropic, cell))).collect();
        Self { isotropic, cells }
    }

    /// The worse of both, cell by cell.
    ///
    /// # Panics
    /// If only one is isotropic.
    pub(super) fn worse(mut self, other: &Self) -> Self {
        assert_eq!(self.isotropic, other.isotropic, "bounds of lobes of one kind");
        for (a, b) in self.cells.iter_mut().zip(&other.cells) {
            a.iter_mut().zip(b).for_each(|(a, b)| *a = (*a).max(*b));
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
    fn measure(gauge: &Gauge, brdf: &dyn Brdf, isotropic: bool, cell: usize) -> [f64; 4] {
        let counts = Self::counts(isotropic);
        let parts = Self::split(isotropic, cell);
        let coloured = brdf.colour().is_none();
        let at = |k: usize| (parts[k] as f64 + 0.5) / counts[k] as f64;
        let wo = direction(at(0) * 0.5_f64.sqrt(), if isotropic { 0.0 } else { 4.0 * at(1) });
        let centre =
            Unit::new_normalize(direction(at(2) * Self::lowest(gauge), at(3) * if isotropic { 2.0 } else { 4.0 }));
        let place = Rotation3::rotation_between(&Vector3::z_axis(), &centre).unwrap_or_else(Rotation3::identity);
        let mut most = [0.0; 4];
        for roll in [0.0, std::f64::consts::FRAC_PI_4] {
            let turn = place * Rotation3::from_axis_angle(&Vector3::z_axis(), roll);
            for shape in [&gauge.shapes[0], &gauge.shapes[gauge.shapes.len() - 1]] {
                let value = |d: &Vector3<f64>| {
                    let wi = turn * d;
                    let value = (wi.z > 0.0).then(|| brdf.eval(&wi, &wo) * wi.z);
                    value.map(|v| if coloured { v } else { Vector3::new(v.max(), 0.0, 0.0) })
                };
                most = worst(most, gauge.errors(shape, 3, value));
            }
        }
        most
    }

    /// sin(θ/2) of the lowest centre of a block that still reaches the horizon.
    fn lowest(gauge: &Gauge) -> f64 {
        (0.5 * (std::f64::consts::FRAC_PI_2 + gauge.radius)).sin()
    }

    /// The largest errors of a cell and its neighbours: azimuths go round, or are mirrored at the ends of a half.
    fn widest(raw: &[[f64; 4]], isotropic: bool, cell: usize) -> [f64; 4] {
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
        let mut most = [0.0; 4];
        for a in near(0) {
            for b in near(1) {
                for c in near(2) {
                    for d in near(3) {
                        most = worst(most, raw[((a * counts[1] + b) * counts[2] + c) * counts[3] + d]);
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
fn each(count: usize, one: impl Fn(usize) -> [f64; 4] + Send + Sync) -> Vec<[f64; 4]> {
    #[cfg(feature = "rayon")]
    return (0..count).into_par_iter().map(one).collect();
    #[cfg(not(feature = "rayon"))]
    return (0..count).map(one).collect();
}
