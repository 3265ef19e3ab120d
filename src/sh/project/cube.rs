//! Cube maps: the rows of a face are meridians about an axis in the face's plane.
//!
//! A row of texels lies on a half great circle through the face's ± right axis. With that axis as the pole, the row is
//! a meridian β = atan v, the position in it a latitude α, and every harmonic is Σ_k D_k {cos, sin} kα · {cos, sin} mβ.
//! So a row's texels meet only bands cosines and as many sines, whatever the number of coefficients; the rest is for
//! each row (mβ) or for each face (D, and permutations of the axes). Nothing is approximated, and every factor is
//! bounded by 1.
//!
//! The faces ±X have their poles on z, the others on x: two frames.

use super::frame::{AxesTurn, Meridians};
use super::rows::{RowTable, Use, class, for_each_slot, mirrored_pairs, padded};
use super::texel_rule::{check_bands, tolerance};
use super::{Channels, TexelRule};
use crate::error::check_length;
use crate::sphere::{CubeGrid, CubeMap, Face};
use crate::{Real, Result};

/// Projects cube maps of one grid onto the harmonics of `bands`; built once, for any number of maps.
///
/// ```math
/// c_i = Σ f_t Ω_t y_i(ω_t)   or   Σ f_t ∫_t y_i dω  (TexelRule)
/// ```
///
/// Shapes: `f32`, `f64` or RGB maps; a vector of bands² coefficients, index l(l+1) + m, for each channel.
/// A NaN texel makes every coefficient of its channel NaN, an infinite one makes them infinite or NaN
/// ([`CubeMap::first_not_finite`] finds it).
///
/// Accuracy: the sum, for texels in [0, 1], to 3e-15 in `f64` and 6e-8 in `f32`, whatever the size, up to 64 bands. The
/// sum against the integral of what the map was sampled from: see the table in docs/sh.md; both rules err by the square
/// of the texel's size.
/// Cost: bands multiplications a texel and channel ([`Basis::accumulate`](crate::sh::Basis::accumulate): bands²),
/// texels that mirror each other sharing theirs, and 4·bands² a row. Memory: side²·bands/2 scalars times the rule's
/// nodes. Parallel over rows, the same bits for any number of threads.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Vector3, sh::{CubeProjection, TexelRule}, sphere::{CubeGrid, CubeMap}};
/// let grid = CubeGrid::new(64)?;
/// let sky = CubeMap::from_fn(grid, |d| Vector3::new(1.0f32, 2.0, d.y as f32));
/// let [red, _, blue] = CubeProjection::new(grid, 3, TexelRule::Centre)?.project(&sky);
/// assert!((red[0] - (4.0 * std::f32::consts::PI).sqrt()).abs() < 1e-5); // a constant: only the first coefficient
/// assert!(red[1].abs() < 1e-5 && (blue[1] - 2.0467).abs() < 1e-3); // y is √(4π/3) y_{1,−1}
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct CubeProjection<T> {
    grid: CubeGrid,
    table: RowTable<T>,
    axes: CubeAxes,
}

/// The coefficients of a cube map, `bands`² for each channel, by the rule of texel centres. One shot: for many maps
/// keep a [`CubeProjection`].
///
/// # Errors
/// As [`CubeProjection::new`].
pub fn project_cube<P: Channels<C>, const C: usize>(map: &CubeMap<P>, bands: usize) -> Result<[Vec<P::Scalar>; C]> {
    Ok(CubeProjection::new(map.grid(), bands, TexelRule::Centre)?.project(map))
}

impl<T: Real> CubeProjection<T> {
    /// The plan for maps on `grid`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless 1 ≤ `bands` ≤ 128.
    pub fn new(grid: CubeGrid, bands: usize, rule: TexelRule) -> Result<Self> {
        let axes = CubeAxes::new::<T>(grid, bands, rule)?;
        let table = axes.table(Use::Gather, grid);
        Ok(Self { grid, table, axes })
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.axes.bands
    }

    /// The coefficients of `map`, a vector for each channel.
    ///
    /// # Panics
    /// If the map's grid is not the plan's.
    #[track_caller]
    pub fn project<P: Channels<C, Scalar = T>, const C: usize>(&self, map: &CubeMap<P>) -> [Vec<T>; C] {
        check_length("cube map side", self.grid.side(), map.grid().side());
        let moments = self.row_moments(map.texels());
        self.axes.coefficients::<C>(&moments).map(|c| c.into_iter().map(T::of).collect())
    }

    /// `[row pair][face][node][channel][class][function]`.
    fn row_moments<P: Channels<C, Scalar = T>, const C: usize>(&self, texels: &[P]) -> Vec<f64> {
        let (side, nodes) = (self.grid.side(), self.axes.nodes.len());
        let slot = nodes * C * class(2, 0, padded(self.axes.bands));
        let mut moments = vec![0.0; 6 * side.div_ceil(2) * slot];
        let operations = nodes * C * side * self.axes.bands;
        for_each_slot(&mut moments, slot, operations, |i, out| {
            let (pair, face) = (i / 6, i % 6);
            let row = |y: usize| &texels[(face * side + y) * side..][..side];
            self.table.gather([row(pair), row(side - 1 - pair)], pair * nodes, out);
        });
        moments
    }
}

/// Cube maps of one grid from coefficients of `bands`: the inverse plan of [`CubeProjection`].
///
/// ```math
/// f_t = Σ c_i y_i(ω_t)   or   Σ c_i ∫_t y_i dω / Ω_t  (TexelRule)
/// ```
///
/// It is the transpose of projection: Σ_t Ω_t f_t g_t = Σ c_i d_i for the map f of c and the projection d of any map g.
///
/// Accuracy: tested to 7e-14 in `f64` and 2e-6 in `f32` for coefficients of 1/(l + 1), up to 17 bands. Projection of
/// the map gives the coefficients back to 8e-5 (3 bands) and 1.4e-4 (6 bands) at side 64 by centres, to 3e-4 and 1.5e-3
/// by means; four times less at twice the side.
/// Cost: bands multiplications a texel and channel ([`Basis::reconstruct`](crate::sh::Basis::reconstruct): bands²).
/// Parallel over rows, the same bits for any number of threads.
///
/// # Example
/// ```
/// use haarmonic::{sh::{CubeReconstruction, TexelRule}, sphere::{CubeGrid, CubeMap}};
/// let plan = CubeReconstruction::<f64>::new(CubeGrid::new(8)?, 2, TexelRule::Centre)?;
/// let map: CubeMap<f64> = plan.reconstruct([&[(4.0 * std::f64::consts::PI).sqrt(), 0.0, 0.0, 0.0]]);
/// assert!(map.texels().iter().all(|t| (t - 1.0).abs() < 1e-14));
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct CubeReconstruction<T> {
    grid: CubeGrid,
    table: RowTable<T>,
    axes: CubeAxes,
}

impl<T: Real> CubeReconstruction<T> {
    /// The plan for maps on `grid`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless 1 ≤ `bands` ≤ 128.
    pub fn new(grid: CubeGrid, bands: usize, rule: TexelRule) -> Result<Self> {
        let axes = CubeAxes::new::<T>(grid, bands, rule)?;
        let table = axes.table(Use::Spread, grid);
        Ok(Self { grid, table, axes })
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.axes.bands
    }

    /// The map of an expansion for each channel.
    ///
    /// # Panics
    /// If an expansion is not bands² long.
    #[track_caller]
    pub fn reconstruct<P: Channels<C, Scalar = T>, const C: usize>(&self, coefficients: [&[T]; C]) -> CubeMap<P> {
        let mut texels = vec![P::zero(); self.grid.len()];
        self.fill(coefficients, &mut texels);
        CubeMap::new(self.grid, texels).expect("one value a texel")
    }

    /// [`reconstruct`](Self::reconstruct) into texels that are there, such as [`CubeMap::texels_mut`]: fresh memory for
    /// a large map can take longer than its values.
    ///
    /// # Panics
    /// If an expansion is not bands² long or there is not one texel for each of the grid's.
    #[track_caller]
    pub fn fill<P: Channels<C, Scalar = T>, const C: usize>(&self, coefficients: [&[T]; C], texels: &mut [P]) {
        check_length("texels", self.grid.len(), texels.len());
        for c in coefficients {
            check_length("coefficients", self.axes.bands * self.axes.bands, c.len());
        }
        let (side, nodes) = (self.grid.side(), self.axes.nodes.len());
        let slot = nodes * C * class(2, 0, padded(self.axes.bands));
        let series = self.axes.series(coefficients);
        let mut pairs: Vec<_> = texels.chunks_exact_mut(side * side).flat_map(|f| mirrored_pairs(f, side)).collect();
        let half = side.div_ceil(2);
        for_each_slot(&mut pairs, 1, nodes * C * side * (self.axes.bands + 4), |i, pair| {
            let (face, row) = (i / half, i % half);
            let [top, bottom] = &mut pair[0];
            self.table.spread([top, bottom], row * nodes, &series[(row * 6 + face) * slot..][..slot]);
        });
    }
}

/// Where a face lies in its frame: its centre at azimuth `quarter` · 90°, down at `turn` · 90° from there, right along
/// `pole` · z'.
#[derive(Debug, Clone, Copy)]
struct FacePose {
    frame: usize,
    pole: f64,
    quarter: usize,
    turn: f64,
}

impl FacePose {
    fn new(face: Face) -> Self {
        let [right, down, out] = face.axes();
        // Axes of the two frames in the world: (x, y, z) and (y, z, x).
        let frame = usize::from(right[2] == 0.0);
        let across = [0, 1].map(|k| (k + frame) % 3);
        let azimuth = |d: [f64; 3]| match across.map(|axis| d[axis] as i32) {
            [1, _] => 0,
            [_, 1] => 1,
            [-1, _] => 2,
            _ => 3,
        };
        let quarter = azimuth(out);
        let turn = if azimuth(down) == (quarter + 1) % 4 { 1.0 } else { -1.0 };
        Self { frame, pole: right[(2 + frame) % 3], quarter, turn }
    }

    /// [[a, b], [c, d]] with cos mφ = a cos mβ + b sin mβ, sin mφ = c cos mβ + d sin mβ for φ = quarter·π/2 + turn·β.
    fn azimuth(self, m: usize) -> [[f64; 2]; 2] {
        let (cos, sin) = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][self.quarter * m % 4];
        [[cos, -self.turn * sin], [sin, self.turn * cos]]
    }
}

/// What projection and reconstruction share: everything beyond the rows.
#[derive(Debug, Clone)]
struct CubeAxes {
    bands: usize,
    rule: TexelRule,
    /// Nodes across a texel, [−1, 1], and weights that sum to 1.
    nodes: Vec<(f64, f64)>,
    /// cos mβ, sin mβ for each row pair, node and m.
    longitudes: Vec<[f64; 2]>,
    meridians: Meridians,
    turn: AxesTurn,
}

impl CubeAxes {
    fn new<T: Real>(grid: CubeGrid, bands: usize, rule: TexelRule) -> Result<Self> {
        check_bands(bands)?;
        // Across a row α depends on β with a slope below ½: 1.5 bands waves.
        let nodes = rule.nodes(1.5 * bands as f64, 1.0 / grid.side() as f64, tolerance::<T>())?;
        let (meridians, turn) = (Meridians::new(bands)?, AxesTurn::new(bands)?);
        let mut axes = Self { bands, rule, nodes, longitudes: Vec::new(), meridians, turn };
        for row in 0..grid.side().div_ceil(2) {
            for (beta, _) in axes.row_nodes(grid, row) {
                axes.longitudes.extend((0..bands).map(|m| {
                    let (sin, cos) = (m as f64 * beta).sin_cos();
                    [cos, sin]
                }));
            }
        }
        Ok(axes)
    }

    /// {cos, sin} kα for the columns on the + side: times solid angles to gather, averaged to spread.
    fn table<T: Real>(&self, use_for: Use, grid: CubeGrid) -> RowTable<T> {
        let (side, count) = (grid.side(), self.nodes.len());
        let half = side.div_ceil(2);
        // A row or column that is its own mirror is summed twice.
        let own = |i: usize| if 2 * i + 1 == side && use_for == Use::Gather { 0.5 } else { 1.0 };
        RowTable::new(use_for, [self.bands, half, half * count], |slot, column, entry| {
            let row = slot / count;
            let nodes = self.row_nodes(grid, row).into_iter();
            let arcs: Vec<_> = nodes.map(|(beta, weight)| (weight, self.arc(grid, column, beta))).collect();
            let whole = match (use_for, self.rule) {
                (Use::Gather, TexelRule::Mean) => 1.0,
                (Use::Gather, TexelRule::Centre) => arcs[0].1.solid_angle() / grid.solid_angle(column, row),
                (Use::Spread, _) => arcs.iter().map(|(weight, arc)| weight * arc.solid_angle()).sum(),
            };
            let (weight, arc) = arcs[slot % count];
            for &(node, node_weight) in &self.nodes {
                let (sin, cos) = (arc.centre + node * arc.half).sin_cos();
                let density = if self.rule == TexelRule::Centre { arc.solid_angle() } else { 2.0 * arc.half * cos };
                let weight = own(row) * own(column) * weight * node_weight * density / whole;
                let (mut c, mut s) = (1.0, 0.0);
                for entry in entry.iter_mut() {
                    entry[0] += weight * c;
                    entry[1] += weight * s;
                    (c, s) = (c * cos - s * sin, c * sin + s * cos);
                }
            }
        })
    }

    /// The meridians β of a row of the + side, and their weights: one through the centres, or Gauss nodes in β.
    fn row_nodes(&self, grid: CubeGrid, row: usize) -> Vec<(f64, f64)> {
        let [near, far] = [row + 1, row].map(|i| (-grid.line(i)).atan());
        let (centre, half) = match self.rule {
            TexelRule::Centre => ((-grid.centre(row)).atan(), 0.0),
            TexelRule::Mean => (0.5 * (near + far), 0.5 * (far - near)),
        };
        let width = if self.rule == TexelRule::Centre { 1.0 } else { 2.0 * half };
        self.nodes.iter().map(|&(node, weight)| (centre + node * half, width * weight)).collect()
    }

    /// The part of a meridian in a column of the + side: tan α = u cos β.
    fn arc(&self, grid: CubeGrid, column: usize, beta: f64) -> Arc {
        let latitude = |u: f64| (u * beta.cos()).atan();
        let [near, far] = [column + 1, column].map(|i| latitude(-grid.line(i)));
        let centre = match self.rule {
            TexelRule::Centre => latitude(-grid.centre(column)),
            TexelRule::Mean => 0.5 * (near + far),
        };
        Arc { centre, half: 0.5 * (far - near) }
    }

    /// Coefficients from the moments of all rows.
    fn coefficients<const C: usize>(&self, moments: &[f64]) -> [Vec<f64>; C] {
        let functions = padded(self.bands);
        let waves_len = 2 * self.bands * functions;
        let mut waves = vec![0.0; 6 * C * waves_len];
        let operations = self.longitudes.len() * functions;
        for_each_slot(&mut waves, waves_len, operations, |i, waves| self.face_waves(moments, [i / C, i % C, C], waves));
        std::array::from_fn(|channel| {
            let mut frames = [vec![0.0; waves_len], vec![0.0; waves_len]];
            for (face, pose) in Face::ALL.into_iter().map(FacePose::new).enumerate() {
                let waves = &waves[(face * C + channel) * waves_len..][..waves_len];
                self.pose(pose, |[to, from], factor| frames[pose.frame][to] += factor * waves[from]);
            }
            let size = self.bands * self.bands;
            let mut out = vec![0.0; size];
            let mut turned = vec![0.0; size];
            self.meridians.analyse(&frames[0], functions, &mut out);
            self.meridians.analyse(&frames[1], functions, &mut turned);
            self.turn.add_turned_back(&turned, &mut out);
            out
        })
    }

    /// Series for all rows, laid out as their moments.
    fn series<T: Real, const C: usize>(&self, coefficients: [&[T]; C]) -> Vec<T> {
        let functions = padded(self.bands);
        let waves_len = 2 * self.bands * functions;
        let mut waves = vec![0.0; 6 * C * waves_len];
        for (channel, c) in coefficients.into_iter().enumerate() {
            let world: Vec<f64> = c.iter().map(|c| c.widen()).collect();
            let mut turned = vec![0.0; c.len()];
            self.turn.add_turned(&world, &mut turned);
            let frames = [world, turned].map(|c| {
                let mut waves = vec![0.0; waves_len];
                self.meridians.synthesise(&c, functions, &mut waves);
                waves
            });
            for (face, pose) in Face::ALL.into_iter().map(FacePose::new).enumerate() {
                let waves = &mut waves[(face * C + channel) * waves_len..][..waves_len];
                self.pose(pose, |[from, to], factor| waves[to] += factor * frames[pose.frame][from]);
            }
        }
        let slot = class(2, 0, functions);
        let rows = self.longitudes.len() / self.bands / self.nodes.len();
        let mut series = vec![T::zero(); rows * 6 * self.nodes.len() * C * slot];
        for_each_slot(&mut series, slot, 2 * self.bands * functions, |i, series| {
            let (channel, node, face, row) =
                (i % C, i / C % self.nodes.len(), i / C / self.nodes.len() % 6, i / C / self.nodes.len() / 6);
            let waves = &waves[(face * C + channel) * waves_len..][..waves_len];
            let longitudes = &self.longitudes[(row * self.nodes.len() + node) * self.bands..][..self.bands];
            self.row_series(waves, longitudes, series);
        });
        series
    }

    /// Entries (frame's, face's) of the waves `(2m + sign)·functions + k` and the factor between them.
    fn pose(&self, pose: FacePose, mut visit: impl FnMut([usize; 2], f64)) {
        let functions = padded(self.bands);
        for m in 0..self.bands {
            let azimuth = pose.azimuth(m);
            for k in 0..self.bands {
                // sin kα is odd in the pole's direction; it goes with odd k − m.
                let pole = if (k + m) % 2 == 1 { pose.pole } else { 1.0 };
                for (i, row) in azimuth.iter().enumerate() {
                    for (j, &factor) in row.iter().enumerate() {
                        if factor != 0.0 {
                            visit([(2 * m + i) * functions + k, (2 * m + j) * functions + k], pole * factor);
                        }
                    }
                }
            }
        }
    }

    /// Σ over rows of a face's moments times {cos, sin} mβ. Of the moments with k, those with cosines go with k − m
    /// even.
    fn face_waves(&self, moments: &[f64], [face, channel, channels]: [usize; 3], waves: &mut [f64]) {
        let functions = padded(self.bands);
        let slot = class(2, 0, functions);
        let mut mixed = vec![0.0; slot];
        for (i, longitudes) in self.longitudes.chunks_exact(self.bands).enumerate() {
            let (row, node) = (i / self.nodes.len(), i % self.nodes.len());
            let at = ((row * 6 + face) * self.nodes.len() + node) * channels + channel;
            mix(&moments[at * slot..][..slot], functions, &mut mixed);
            for (m, (longitude, waves)) in longitudes.iter().zip(waves.chunks_exact_mut(2 * functions)).enumerate() {
                for (sign, waves) in waves.chunks_exact_mut(functions).enumerate() {
                    let moments = &mixed[class(sign, m % 2, functions)..][..functions];
                    for (wave, moment) in waves.iter_mut().zip(moments) {
                        *wave += longitude[sign] * moment;
                    }
                }
            }
        }
    }

    fn row_series<T: Real>(&self, waves: &[f64], longitudes: &[[f64; 2]], series: &mut [T]) {
        let functions = padded(self.bands);
        let mut mixed = vec![0.0; series.len()];
        for (m, (longitude, waves)) in longitudes.iter().zip(waves.chunks_exact(2 * functions)).enumerate() {
            for (sign, waves) in waves.chunks_exact(functions).enumerate() {
                let series = &mut mixed[class(sign, m % 2, functions)..][..functions];
                for (wave, sum) in waves.iter().zip(series) {
                    *sum += longitude[sign] * wave;
                }
            }
        }
        let mut unmixed = vec![0.0; series.len()];
        mix(&mixed, functions, &mut unmixed);
        for (out, value) in series.iter_mut().zip(unmixed) {
            *out = T::of(value);
        }
    }
}

/// A piece of a meridian.
#[derive(Debug, Clone, Copy)]
struct Arc {
    centre: f64,
    half: f64,
}

impl Arc {
    /// ∫ cos α dα, the solid angle for each unit of β.
    fn solid_angle(self) -> f64 {
        2.0 * self.centre.cos() * self.half.sin()
    }
}

/// Swaps the parity of the column for that of m: cosines (class 0) of k go with m ≡ k, sines with m ≢ k. Its own
/// inverse.
fn mix(from: &[f64], functions: usize, to: &mut [f64]) {
    for row in 0..2 {
        for parity in 0..2 {
            let even = &from[class(row, parity, functions)..][..functions];
            let odd = &from[class(row, 1 - parity, functions)..][..functions];
            let to = &mut to[class(row, parity, functions)..][..functions];
            for k in (0..functions).step_by(2) {
                to[k] = even[k];
                to[k + 1] = odd[k + 1];
            }
        }
    }
}
