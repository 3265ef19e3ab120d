//! Least and greatest values of an expansion, with a proof.
//!
//! Let h = f − (max f + min f)/2, so that ‖h‖ = R is half the range and is attained at the minimum. Along any great
//! circle h is a trigonometric polynomial of degree L = bands − 1, and near a point where it attains its least value −R
//! such a polynomial stays below −R cos(Ls) at distance s ≤ π/L [M. Riesz 1914]. So a point within δ of the minimum has
//!
//! ```math
//! f ≤ min f + R (1 − cos Lδ).
//! ```
//!
//! A grid of covering radius δ therefore brackets the minimum, and R itself: R ≤ (half the range on the grid)/cos Lδ.
//! Cells of the grid whose centre lies above the best value seen by more than that margin cannot hold the minimum; the
//! others are cut into four, until the margin is small. Newton's method from the best cell makes the value accurate.

use nalgebra::{Matrix2, UnitVector3, Vector2, Vector3};

use super::{CubeReconstruction, TexelRule};
use crate::approx_eq::approx_by_parts;
use crate::error::check_length;
use crate::sh::Basis;
use crate::sphere::{CubeGrid, CubeMap, Face};
use crate::{Error, Real, Result};

/// Finds the global minimum and maximum of expansions of `bands`; built once.
///
/// Accuracy: values to 1e-14 of Σ|c| and directions to 1e-7 where the extremum is curved (planted minima). Certainty:
/// [`Extremum::bound`].
/// Cost: about 30, 50, 200 µs at 3, 6, 10 bands; an extremum along a whole circle, as zonal functions have, costs up to
/// a thousand times more.
///
/// # Example
/// ```
/// use haarmonic::sh::Extrema;
/// // −y, whose minimum lies at +y.
/// let least = Extrema::new(2)?.minimum(&[0.0, -1.0, 0.0, 0.0])?;
/// assert!(least.direction.y > 1.0 - 1e-12);
/// let truth = -(0.75f64 / std::f64::consts::PI).sqrt();
/// assert!((least.value - truth).abs() < 1e-15 && least.bound <= truth && least.bound > truth - 1e-5);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Extrema {
    basis: Basis<f64>,
    grid: CubeGrid,
    values: CubeReconstruction<f64>,
    /// Bounds the angle from a texel's centre to its corners.
    radius: f64,
}

/// Where an expansion is least (or greatest), and how low (high) it can be anywhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extremum {
    /// Where the value is attained.
    pub direction: UnitVector3<f64>,
    /// The least (greatest) value found.
    pub value: f64,
    /// No value on the sphere is below (above) this, up to rounding of 1e-13 Σ|c|. It is within 1e-6 of half the range
    /// from `value`; where so many cells are nearly extreme that the search stops early, within 1/8 of it.
    pub bound: f64,
}

/// A square on a face of the cube: face, centre, half width.
type Cell = (Face, [f64; 2], f64);

impl Extrema {
    /// L δ on the first grid: smaller costs points there, larger costs cells later.
    const REACH: f64 = 0.5;
    /// The margin at which cutting ends, of half the range.
    const MARGIN: f64 = 1e-6;
    /// Cells of one cut for each cell of the first grid, and at least a thousand: the search ends beyond.
    const CELLS: usize = 16;

    /// The plan for `bands`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 1 ≤ `bands` ≤ 128.
    pub fn new(bands: usize) -> Result<Self> {
        let degree = bands.saturating_sub(1) as f64;
        // No angle is larger than its length on the plane of the face: half a diagonal, √2/side.
        let side = (2f64.sqrt() * degree / Self::REACH).ceil().max(2.0);
        let grid = CubeGrid::new(side as usize)?;
        let values = CubeReconstruction::new(grid, bands, TexelRule::Centre)?;
        Ok(Self { basis: Basis::new(bands)?, grid, values, radius: 2f64.sqrt() / side })
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.basis.bands()
    }

    /// The minimum of Σ c_i y_i over the sphere.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a coefficient is NaN or infinite, or the values overflow.
    ///
    /// # Panics
    /// If `coefficients.len()` is not bands².
    #[track_caller]
    pub fn minimum<T: Real>(&self, coefficients: &[T]) -> Result<Extremum> {
        self.extremum(coefficients.iter().map(|c| c.widen()).collect())
    }

    /// The maximum of Σ c_i y_i over the sphere.
    ///
    /// # Errors
    /// As [`minimum`](Self::minimum).
    ///
    /// # Panics
    /// If `coefficients.len()` is not bands².
    #[track_caller]
    pub fn maximum<T: Real>(&self, coefficients: &[T]) -> Result<Extremum> {
        let least = self.extremum(coefficients.iter().map(|c| -c.widen()).collect())?;
        Ok(Extremum { value: -least.value, bound: -least.bound, ..least })
    }

    #[track_caller]
    fn extremum(&self, c: Vec<f64>) -> Result<Extremum> {
        check_length("coefficients", self.basis.coefficient_count(), c.len());
        if let Some(index) = c.iter().position(|c| !c.is_finite()) {
            return Err(Error::NotFinite { what: "coefficient", index });
        }
        let map: CubeMap<f64> = self.values.reconstruct([&c]);
        if let Some(index) = map.first_not_finite() {
            return Err(Error::NotFinite { what: "value on the grid", index });
        }
        let (least, greatest) = map
            .texels()
            .iter()
            .enumerate()
            .fold(((0, f64::INFINITY), f64::NEG_INFINITY), |(least, greatest), (i, &v)| {
                (if v < least.1 { (i, v) } else { least }, greatest.max(v))
            });
        let degree = (self.bands() - 1) as f64;
        let half_range = 0.5 * (greatest - least.1) / (degree * self.radius).cos();
        let start = self.grid.direction(least.0);
        let mut best = self.polish(&c, (start, self.basis.dot(&c, &start)));
        let margin = |radius: f64| 2.0 * half_range * (0.5 * degree * radius).sin().powi(2);
        let rounding = 1e-13 * c.iter().map(|c| c.abs()).sum::<f64>();
        let mut radius = self.radius;
        let mut cells: Vec<Cell> = (0..self.grid.len())
            .filter(|&i| map.texels()[i] <= best.1 + margin(radius) + rounding)
            .map(|i| self.cell(i))
            .collect();
        let most = (Self::CELLS * self.grid.len()).max(1000);
        while margin(radius) > Self::MARGIN * half_range && cells.len() <= most {
            (cells, radius, best) = self.cut(&c, &cells, best, &|radius| margin(radius) + rounding);
        }
        Ok(Extremum { direction: best.0, value: best.1, bound: best.1 - margin(radius) - rounding })
    }

    fn cell(&self, texel: usize) -> Cell {
        let (face, x, y) = self.grid.texel(texel);
        (face, [self.grid.centre(x), self.grid.centre(y)], 1.0 / self.grid.side() as f64)
    }

    /// Four cells for each, without those that are too high; their radius; the best point so far.
    fn cut(
        &self,
        c: &[f64],
        cells: &[Cell],
        mut best: (UnitVector3<f64>, f64),
        margin: &dyn Fn(f64) -> f64,
    ) -> (Vec<Cell>, f64, (UnitVector3<f64>, f64)) {
        let quarters: Vec<Cell> = cells
            .iter()
            .flat_map(|&(face, [u, v], half)| {
                let h = 0.5 * half;
                [[-h, -h], [h, -h], [-h, h], [h, h]].map(|[du, dv]| (face, [u + du, v + dv], h))
            })
            .collect();
        let directions: Vec<_> =
            quarters.iter().map(|&(face, [u, v], _)| UnitVector3::new_normalize(face.point(u, v))).collect();
        let [x, y, z] = super::function::components(&directions);
        let mut values = vec![0.0; quarters.len()];
        self.basis.reconstruct(c, &x, &y, &z, &mut values);
        let lowest = (0..values.len()).fold(0, |low, i| if values[i] < values[low] { i } else { low });
        if values[lowest] < best.1 {
            best = self.polish(c, (directions[lowest], values[lowest]));
        }
        let radius = quarters.first().map_or(0.0, |cell| 2f64.sqrt() * cell.2);
        let allowed = best.1 + margin(radius);
        let kept = quarters.into_iter().zip(values).filter(|(_, value)| *value <= allowed).map(|(cell, _)| cell);
        (kept.collect(), radius, best)
    }

    /// Newton's method on the sphere, downhill only.
    fn polish(&self, c: &[f64], start: (UnitVector3<f64>, f64)) -> (UnitVector3<f64>, f64) {
        let degree = (self.bands() - 1) as f64;
        let mut best = start;
        for _ in 0..30 {
            let d = best.0.into_inner();
            let first = if d.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() }.cross(&d).normalize();
            let tangents = [first, d.cross(&first)];
            let along = |g: Vector3<f64>| Vector2::new(g.dot(&tangents[0]), g.dot(&tangents[1]));
            let slope = along(self.slope(c, &best.0));
            // The error of the differences is step² and eps/step of the Hessian.
            let step = 1e-5 / degree.max(1.0);
            let column = |t: Vector3<f64>| {
                let at = |s: f64| along(self.slope(c, &UnitVector3::new_normalize(d + t * s)));
                (at(step) - at(-step)) / (2.0 * step)
            };
            let [a, b] = tangents.map(column);
            let cross = 0.5 * (a.y + b.x);
            let hessian = Matrix2::new(a.x, cross, cross, b.y);
            let newton = hessian.cholesky().map(|h| -h.solve(&slope));
            // Without a curved bowl: downhill by the length that the largest curvature allows.
            let mut step = newton.unwrap_or_else(|| -slope / (hessian.norm() + f64::MIN_POSITIVE));
            let limit = 0.5 / degree.max(1.0);
            if step.norm() > limit {
                step *= limit / step.norm();
            }
            let Some(next) = self.downhill(c, best, tangents[0] * step.x + tangents[1] * step.y) else { break };
            best = next;
        }
        best
    }

    /// The first of six halvings of a step that leads down.
    fn downhill(
        &self,
        c: &[f64],
        from: (UnitVector3<f64>, f64),
        step: Vector3<f64>,
    ) -> Option<(UnitVector3<f64>, f64)> {
        (0..6).find_map(|halvings| {
            let at = UnitVector3::new_normalize(from.0.into_inner() + step * 0.5f64.powi(halvings));
            let value = self.basis.dot(c, &at);
            (value < from.1).then_some((at, value))
        })
    }

    /// The tangent gradient.
    fn slope(&self, c: &[f64], d: &UnitVector3<f64>) -> Vector3<f64> {
        let size = self.basis.coefficient_count();
        let (mut values, mut gradients) = (vec![0.0; size], vec![Vector3::zeros(); size]);
        self.basis.gradient(d, &mut values, &mut gradients);
        c.iter().zip(gradients).map(|(c, g)| g * *c).sum()
    }
}

approx_by_parts!([] Extremum, f64, |e| close [[e.value, e.bound], e.direction.as_slice()] same []);
