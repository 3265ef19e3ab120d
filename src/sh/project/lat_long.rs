//! Latitude–longitude maps: Fourier sums of each row, then Legendre functions across the rows.
//!
//! The map's pole is +y. In the frame with axes (x', y', z') = (z, x, y) the azimuth of image coordinate u is −2πu, so
//! a row's texels meet only bands cosines and as many sines; the Legendre functions are for each row, and the axes are
//! permuted at last.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::frame::AxesTurn;
use super::rows::{RowTable, Use, class, for_each_slot, mirrored_pairs, padded};
use super::texel_rule::{check_bands, tolerance};
use super::{Channels, TexelRule};
use crate::error::check_length;
use crate::sh::Basis;
use crate::sphere::{LatLongGrid, LatLongMap};
use crate::{Real, Result};

/// Projects latitude–longitude maps of one grid onto the harmonics of `bands`; built once, for any number of maps.
///
/// ```math
/// c_i = Σ f_p Ω_p y_i(ω_p)   or   Σ f_p ∫_p y_i dω  (TexelRule)
/// ```
///
/// Shapes and NaN: as [`CubeProjection`](super::CubeProjection).
///
/// Accuracy: as [`CubeProjection`](super::CubeProjection); tested to 3e-13 in `f64`, 1.4e-5 in `f32`, up to 17 bands.
/// Cost: bands multiplications a pixel and channel ([`Basis::accumulate`]: bands²), pixels that mirror each other
/// sharing theirs, and bands² a row. Memory: height·bands²/4 numbers. Parallel over rows, the same bits for any number
/// of threads.
///
/// # Example
/// ```
/// use haarmonic::{sh::{LatLongProjection, TexelRule}, sphere::{LatLongGrid, LatLongMap}};
/// let grid = LatLongGrid::new(64, 32)?;
/// let map = LatLongMap::from_fn(grid, |d| d.x);
/// let [c] = LatLongProjection::new(grid, 2, TexelRule::Centre)?.project(&map);
/// assert!((c[3] - 2.0467).abs() < 2e-3); // x is √(4π/3) y_{1,1}
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct LatLongProjection<T> {
    grid: LatLongGrid,
    table: RowTable<T>,
    rows: Parallels,
}

/// The coefficients of a latitude–longitude map, `bands`² for each channel, by the rule of pixel centres. One shot: for
/// many maps keep a [`LatLongProjection`].
///
/// # Errors
/// As [`LatLongProjection::new`].
pub fn project_lat_long<P: Channels<C>, const C: usize>(
    map: &LatLongMap<P>,
    bands: usize,
) -> Result<[Vec<P::Scalar>; C]> {
    Ok(LatLongProjection::new(map.grid(), bands, TexelRule::Centre)?.project(map))
}

impl<T: Real> LatLongProjection<T> {
    /// The plan for maps on `grid`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless 1 ≤ `bands` ≤ 128.
    pub fn new(grid: LatLongGrid, bands: usize, rule: TexelRule) -> Result<Self> {
        let rows = Parallels::new::<T>(grid, bands, rule)?;
        Ok(Self { grid, table: azimuths(Use::Gather, grid, bands, rule), rows })
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.rows.bands
    }

    /// The coefficients of `map`, a vector for each channel.
    ///
    /// # Panics
    /// If the map's grid is not the plan's.
    #[track_caller]
    pub fn project<P: Channels<C, Scalar = T>, const C: usize>(&self, map: &LatLongMap<P>) -> [Vec<T>; C] {
        check_length("lat-long width", self.grid.width(), map.grid().width());
        check_length("lat-long height", self.grid.height(), map.grid().height());
        let (width, height, bands) = (self.grid.width(), self.grid.height(), self.bands());
        let slot = class(2, 0, padded(bands));
        let mut moments = vec![0.0; height.div_ceil(2) * C * slot];
        for_each_slot(&mut moments, C * slot, C * width * bands, |pair, out| {
            let row = |y: usize| &map.pixels()[y * width..][..width];
            self.table.gather([row(pair), row(height - 1 - pair)], 0, out);
        });
        let mut local = vec![0.0; C * bands * bands];
        for_each_slot(&mut local, bands * bands, 4 * height * bands * bands, |channel, local| {
            for (row, moments) in moments.chunks_exact(C * slot).enumerate() {
                let moments = &moments[channel * slot..][..slot];
                let weight = self.rows.solid_angle(self.grid, row);
                self.rows.walk(row, |i, at, y| local[i] += weight * y * moments[at]);
            }
        });
        std::array::from_fn(|channel| {
            let mut out = vec![0.0; bands * bands];
            self.rows.turn.add_turned(&local[channel * bands * bands..][..bands * bands], &mut out);
            out.into_iter().map(T::of).collect()
        })
    }
}

/// Latitude–longitude maps of one grid from coefficients of `bands`: the inverse plan of [`LatLongProjection`], and its
/// transpose in the sense of [`CubeReconstruction`](super::CubeReconstruction).
///
/// Accuracy: as [`CubeReconstruction`](super::CubeReconstruction); back to 5e-5 (3 bands) and 1e-4 (6 bands) at 256 ×
/// 128 by centres. Cost: bands multiplications a pixel and channel, bands² a row. Parallel over rows, the same bits for
/// any number of threads.
#[derive(Debug, Clone)]
pub struct LatLongReconstruction<T> {
    grid: LatLongGrid,
    table: RowTable<T>,
    rows: Parallels,
}

impl<T: Real> LatLongReconstruction<T> {
    /// The plan for maps on `grid`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless 1 ≤ `bands` ≤ 128.
    pub fn new(grid: LatLongGrid, bands: usize, rule: TexelRule) -> Result<Self> {
        let rows = Parallels::new::<T>(grid, bands, rule)?;
        Ok(Self { grid, table: azimuths(Use::Spread, grid, bands, rule), rows })
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.rows.bands
    }

    /// The map of an expansion for each channel.
    ///
    /// # Panics
    /// If an expansion is not bands² long.
    #[track_caller]
    pub fn reconstruct<P: Channels<C, Scalar = T>, const C: usize>(&self, coefficients: [&[T]; C]) -> LatLongMap<P> {
        let mut pixels = vec![P::zero(); self.grid.len()];
        self.fill(coefficients, &mut pixels);
        LatLongMap::new(self.grid, pixels).expect("one value a pixel")
    }

    /// [`reconstruct`](Self::reconstruct) into pixels that are there: fresh memory for a large map can take longer than
    /// its values.
    ///
    /// # Panics
    /// If an expansion is not bands² long or there is not one pixel for each of the grid's.
    #[track_caller]
    pub fn fill<P: Channels<C, Scalar = T>, const C: usize>(&self, coefficients: [&[T]; C], pixels: &mut [P]) {
        check_length("pixels", self.grid.len(), pixels.len());
        let bands = self.bands();
        let local = coefficients.map(|c| {
            check_length("coefficients", bands * bands, c.len());
            let world: Vec<f64> = c.iter().map(|c| c.widen()).collect();
            let mut local = vec![0.0; bands * bands];
            self.rows.turn.add_turned_back(&world, &mut local);
            local
        });
        let slot = class(2, 0, padded(bands));
        let width = self.grid.width();
        let operations = C * (width * (bands + 4) + 4 * bands * bands);
        for_each_slot(&mut mirrored_pairs(pixels, width), 1, operations, |row, pair| {
            let mut sums = vec![0.0; C * slot];
            for (local, sums) in local.iter().zip(sums.chunks_exact_mut(slot)) {
                self.rows.walk(row, |i, at, y| sums[at] += y * local[i]);
            }
            let series: Vec<T> = sums.into_iter().map(T::of).collect();
            let [top, bottom] = &mut pair[0];
            self.table.spread([top, bottom], 0, &series);
        });
    }
}

/// {cos, sin} mφ at the columns of the + side, averaged over the pixel's width for means.
fn azimuths<T: Real>(use_for: Use, grid: LatLongGrid, bands: usize, rule: TexelRule) -> RowTable<T> {
    let width = grid.width();
    RowTable::new(use_for, [bands, width.div_ceil(2), 1], |_, column, entry| {
        // A column that is its own mirror is summed twice.
        let own = if 2 * column + 1 == width && use_for == Use::Gather { 0.5 } else { 1.0 };
        for (m, entry) in entry.iter_mut().enumerate() {
            let half = PI * m as f64 / width as f64;
            let mean = if m == 0 || rule == TexelRule::Centre { 1.0 } else { half.sin() / half };
            let (sin, cos) = ((2 * column + 1) as f64 * half).sin_cos();
            *entry = [own * mean * cos, own * mean * sin];
        }
    })
}

/// Legendre functions at the rows of the + (southern) side: y_{l,m} at azimuth 0, averaged over the row for means.
#[derive(Debug, Clone)]
struct Parallels {
    bands: usize,
    /// For each row m = 0…, l = m….
    values: Vec<f64>,
    turn: AxesTurn,
}

impl Parallels {
    fn new<T: Real>(grid: LatLongGrid, bands: usize, rule: TexelRule) -> Result<Self> {
        check_bands(bands)?;
        let half_width = 0.5 * PI / grid.height() as f64;
        let nodes = rule.nodes(bands as f64, half_width, tolerance::<T>())?;
        let basis = Basis::<f64>::new(bands)?;
        let mut y = vec![0.0; bands * bands];
        let mut values = Vec::new();
        for row in 0..grid.height().div_ceil(2) {
            // From the south pole.
            let centre = (2 * row + 1) as f64 * half_width;
            let total: f64 = nodes.iter().map(|&(x, w)| w * (centre + x * half_width).sin()).sum();
            let mut means = vec![0.0; bands * bands];
            for &(node, weight) in &nodes {
                let (sin, cos) = (centre + node * half_width).sin_cos();
                basis.eval(&Vector3::new(sin, 0.0, -cos), &mut y);
                means.iter_mut().zip(&y).for_each(|(mean, y)| *mean += weight * sin / total * y);
            }
            values.extend((0..bands).flat_map(|m| (m..bands).map(move |l| l * (l + 1) + m)).map(|i| means[i]));
        }
        Ok(Self { bands, values, turn: AxesTurn::new(bands)? })
    }

    /// The solid angle of a pixel; a row that is its own mirror is summed twice.
    fn solid_angle(&self, grid: LatLongGrid, row: usize) -> f64 {
        let own = if 2 * row + 1 == grid.height() { 0.5 } else { 1.0 };
        own * grid.solid_angle(row)
    }

    /// Visits coefficients with the place of their moment and their value: y_{l,m} has the parity of l − m across the
    /// equator.
    #[inline(always)]
    fn walk(&self, row: usize, mut visit: impl FnMut(usize, usize, f64)) {
        let functions = padded(self.bands);
        let size = self.bands * (self.bands + 1) / 2;
        let mut values = self.values[row * size..][..size].iter();
        for m in 0..self.bands {
            for (l, &y) in (m..self.bands).zip(values.by_ref()) {
                visit(l * (l + 1) + m, class((l - m) % 2, 0, functions) + m, y);
                if m > 0 {
                    visit(l * (l + 1) - m, class((l - m) % 2, 1, functions) + m, y);
                }
            }
        }
    }
}
