//! Errors of lobes of any kind.

use nalgebra::{Rotation3, Unit, Vector3};

use super::errors::{Codes, Errors};
use super::gauge::Gauge;
use super::{cell_of, each, half_sine};
use crate::scene::Brdf;

/// Errors for other lobes.
#[derive(Debug, Clone)]
pub(in crate::backend::block_product) struct WideBounds {
    isotropic: bool,
    cells: Vec<Codes>,
}

/// Cells along the elevation of the viewer, his azimuth, the elevation of the block, its azimuth (half of it if isotropic).
const WIDE: [usize; 4] = [10, 16, 14, 24];

impl WideBounds {
    /// Measures a BRDF.
    pub(in crate::backend::block_product) fn new(gauge: &Gauge, brdf: &dyn Brdf, isotropic: bool) -> Self {
        let counts = Self::counts(isotropic);
        let raw = each(counts.iter().product(), |cell| Self::measure(gauge, brdf, isotropic, cell));
        let cells = (0..raw.len()).map(|cell| Codes::new(Self::widest(&raw, isotropic, cell))).collect();
        Self { isotropic, cells }
    }

    /// The worse of both, cell by cell.
    ///
    /// # Panics
    /// If only one is isotropic.
    pub(in crate::backend::block_product) fn worse(mut self, other: &Self) -> Self {
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
    pub(in crate::backend::block_product) fn seen_from(&self, radius: f64, wo: &Vector3<f64>) -> WideView<'_> {
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
pub(in crate::backend::block_product) struct WideView<'a> {
    cells: &'a [Codes],
    counts: [usize; 2],
    scale: f32,
    along: [f32; 2],
    isotropic: bool,
}

impl WideView<'_> {
    /// The errors of a block whose centre is at `d`, in local coordinates.
    #[inline(always)]
    pub(in crate::backend::block_product) fn codes(&self, d: [f32; 3]) -> &Codes {
        let elevation = cell_of(half_sine(d[2]) * self.scale, self.counts[0]);
        let (x, y) = (d[0] * self.along[0] + d[1] * self.along[1], d[1] * self.along[0] - d[0] * self.along[1]);
        let turn = if self.isotropic { 0.5 * diamond(x, y.abs()) } else { 0.25 * diamond(x, y) };
        &self.cells[elevation * self.counts[1] + cell_of(turn, self.counts[1])]
    }
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
