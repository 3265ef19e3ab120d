//! A BRDF over directions of view and cells of the hemisphere.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::Vector3;

use super::hemisphere;
use crate::scene::{Axes, Brdf, LocalFrame};
use crate::{Error, Result, parallel};

/// How much a BRDF reflects, tabulated as a function of four numbers: directions of view × cells of the hemisphere
/// [Clarberg 2005; Sun 2008, §4.6.1].
///
/// A value is the length of the BRDF's RGB vector, its mean over 3 × 3 points of a cell; between the centres of cells
/// and between directions of view it is interpolated. It is a proposal only: estimates evaluate the BRDF itself.
///
/// Shapes: `views` elevations, equally spaced in the angle, times one azimuth (an isotropic BRDF) or 4 · `views`;
/// `cells`² cells of half an octahedron. Bytes: 4 views cells², anisotropic 16 views² cells². Cost: 9 values of the
/// BRDF an entry; 32 views of 64² cells are 0.5 MB, in some 50 ms.
#[derive(Debug, Clone, PartialEq)]
pub struct BrdfTable {
    elevations: usize,
    azimuths: usize,
    cells: usize,
    /// \[elevation\]\[azimuth\]\[row\]\[column\]
    values: Vec<f32>,
}

/// A BRDF of one direction of view, about a surface: what [`BrdfTable`] looks up.
pub(super) struct Slice<'a> {
    pub(super) cells: usize,
    pub(super) values: &'a [f32],
    /// The surface's axes, turned so that the slice's hemisphere stands on them.
    pub(super) axes: [Vector3<f64>; 3],
}

impl BrdfTable {
    /// The most bytes of a table: 2²⁸.
    pub const MAX_BYTES: usize = 1 << 28;

    /// The table of a BRDF, made in parallel.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for no views, a table of more than [`MAX_BYTES`](Self::MAX_BYTES) and more than 2048 cells
    /// along an edge; [`Error::NotPowerOfTwo`] unless `cells` is one; [`Error::NotFinite`] if the BRDF has a value that
    /// is NaN or infinite (the index is the entry's).
    pub fn new(brdf: &dyn Brdf, views: usize, cells: usize) -> Result<Self> {
        if !cells.is_power_of_two() {
            return Err(Error::NotPowerOfTwo { what: "cells along a BRDF table", got: cells });
        }
        if cells > 2048 {
            let got = cells as f64;
            return Err(Error::OutOfRange { what: "cells along a BRDF table", got, allowed: "at most 2048" });
        }
        let around = if brdf.is_isotropic() { 1 } else { 4_usize.saturating_mul(views) };
        let rows = views.saturating_mul(around);
        let bytes = rows.saturating_mul(4 * cells * cells);
        if views == 0 || bytes > Self::MAX_BYTES {
            let (what, got) = ("bytes of a BRDF table", bytes as f64);
            return Err(Error::OutOfRange { what, got, allowed: "of one view at least, and at most 2^28" });
        }
        let mut table = Self { elevations: views, azimuths: around, cells, values: vec![0.0; rows * cells * cells] };
        let viewers: Vec<Vector3<f64>> = (0..rows).map(|row| table.viewer(row)).collect();
        parallel::rows(&mut table.values, cells * cells, 1, |row, values| {
            values.iter_mut().enumerate().for_each(|(cell, value)| *value = mean(brdf, cells, cell, &viewers[row]));
        });
        match table.values.iter().position(|v| !v.is_finite()) {
            Some(index) => Err(Error::NotFinite { what: "entry of a BRDF table", index }),
            None => Ok(table),
        }
    }

    /// Cells along an edge of the hemisphere's square.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// Elevations and azimuths of the viewer.
    pub fn views(&self) -> [usize; 2] {
        [self.elevations, self.azimuths]
    }

    /// Bytes of the table.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.values[..])
    }

    /// The direction of view of a row.
    fn viewer(&self, row: usize) -> Vector3<f64> {
        let angle = (row / self.azimuths) as f64 + 0.5;
        let (sin, cos) = (angle / self.elevations as f64 * FRAC_PI_2).sin_cos();
        let azimuth = (row % self.azimuths) as f64 / self.azimuths as f64 * TAU;
        Vector3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
    }

    /// The BRDF as a viewer sees it, interpolated into `out`; `None` for one below the surface, with NaN or ∞.
    pub(super) fn slice<'a>(&self, frame: &LocalFrame, wo: &Vector3<f64>, out: &'a mut Vec<f32>) -> Option<Slice<'a>> {
        let axes = Axes::new(frame);
        let local = axes.to_local(wo);
        if !(local.z > 0.0 && local.norm_squared().is_finite()) {
            return None;
        }
        let flat = local.x.hypot(local.y);
        // Between the elevations' middles, constant beyond the first and the last.
        let height = flat.atan2(local.z) / FRAC_PI_2 * self.elevations as f64 - 0.5;
        let (low, above) = split(height.clamp(0.0, (self.elevations - 1) as f64), self.elevations);
        let high = (low + 1).min(self.elevations - 1);
        out.resize(self.cells * self.cells, 0.0);
        let row = |elevation: usize, azimuth: usize| {
            let len = self.cells * self.cells;
            &self.values[(elevation * self.azimuths + azimuth) * len..][..len]
        };
        let (cos, sin) = if flat > 0.0 { (local.x / flat, local.y / flat) } else { (1.0, 0.0) };
        let turned = if self.azimuths == 1 {
            mix([(row(low, 0), 1.0 - above), (row(high, 0), above)], out);
            // Turned until the viewer's azimuth is 0.
            [Vector3::new(cos, sin, 0.0), Vector3::new(-sin, cos, 0.0), Vector3::z()]
        } else {
            let around = (sin.atan2(cos) / TAU).rem_euclid(1.0) * self.azimuths as f64;
            let (left, beyond) = split(around, self.azimuths + 1);
            let [left, right] = [left, left + 1].map(|azimuth| azimuth % self.azimuths);
            let weight = |upper: f32, other: f32| upper * other;
            mix(
                [
                    (row(low, left), weight(1.0 - above, 1.0 - beyond)),
                    (row(low, right), weight(1.0 - above, beyond)),
                    (row(high, left), weight(above, 1.0 - beyond)),
                    (row(high, right), weight(above, beyond)),
                ],
                out,
            );
            [Vector3::x(), Vector3::y(), Vector3::z()]
        };
        Some(Slice { cells: self.cells, values: out, axes: turned.map(|axis| axes.to_world(&axis)) })
    }
}

/// The cell below a place and how far beyond its middle it is.
fn split(at: f64, cells: usize) -> (usize, f32) {
    let cell = (at as usize).min(cells - 1);
    (cell, (at - cell as f64) as f32)
}

fn mix<const N: usize>(rows: [(&[f32], f32); N], out: &mut [f32]) {
    for (i, out) in out.iter_mut().enumerate() {
        *out = rows.iter().map(|(row, weight)| row[i] * weight).sum();
    }
}

/// The mean over a cell, NaN if a value is not finite.
fn mean(brdf: &dyn Brdf, cells: usize, cell: usize, wo: &Vector3<f64>) -> f32 {
    let offsets = [1.0 / 6.0, 0.5, 5.0 / 6.0];
    let at = |u: f64, v: f64| {
        let w = [(cell % cells) as f64 + u, (cell / cells) as f64 + v].map(|w| w / cells as f64);
        brdf.eval(&hemisphere::point(w).normalize(), wo).norm()
    };
    let sum: f64 = offsets.iter().flat_map(|&u| offsets.iter().map(move |&v| (u, v))).map(|(u, v)| at(u, v)).sum();
    (sum / 9.0) as f32
}

impl Slice<'_> {
    /// The value at a direction of the surface, of any length and not below it, times its height over the surface.
    #[inline(always)]
    pub(super) fn value_times_height(&self, x: f32, y: f32, z: f32) -> f32 {
        // Negated, so that NaN is dark.
        if !(z > 0.0) {
            return 0.0;
        }
        let scale = 0.5 * self.cells as f32;
        let half_cells = scale - 0.5;
        let last = (self.cells - 1) as f32;
        let per = scale / (x.abs() + y.abs() + z);
        let u = ((x + y) * per + half_cells).clamp(0.0, last);
        let v = ((x - y) * per + half_cells).clamp(0.0, last);
        let (column, row) =
            ((u as usize).min(self.cells.saturating_sub(2)), (v as usize).min(self.cells.saturating_sub(2)));
        let (s, t) = (u - column as f32, v - row as f32);
        let at = row * self.cells + column;
        let (right, down) = (usize::from(self.cells > 1), if self.cells > 1 { self.cells } else { 0 });
        let p = self.values;
        let upper = p[at] + s * (p[at + right] - p[at]);
        let lower = p[at + down] + s * (p[at + down + right] - p[at + down]);
        (upper + t * (lower - upper)) * z
    }
}
