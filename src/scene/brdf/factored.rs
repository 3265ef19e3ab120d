//! Any BRDF as a sum of products.

use nalgebra::{DMatrix, Vector2, Vector3};

use super::{Brdf, off_surface};
use crate::sphere::ConcentricSquare;
use crate::{Error, Result, parallel};

/// A BRDF as Σ_k g_k(wi) h_k(wo): what lets the view change without integrating anew [Wang 2004, Liu 2004].
///
/// The factors are tables over the hemisphere, looked up bilinearly on the [`ConcentricSquare`]: g in RGB, h scalar.
/// They are the singular vectors of the matrix of values at the cells' centres, directions wo down and channels of wi
/// across, each weighted by √(cos θ_i cos θ_o), so that K terms are the best that K terms can be for ∫∫ (f − Σ)² cos
/// θ_i cos θ_o dω_i dω_o on these cells.
///
/// [`errors`](Self::errors) has that error for 1, 2, … terms; between the cells' centres the interpolation's comes on
/// top ([`cell_error`](Self::cell_error)), which more cells lessen: lobes narrower than a cell are lost. Sums of few
/// terms may be negative, and are not reciprocal.
///
/// Cost: the values, and a Gram matrix of cells² × cells² whose eigenvectors are found; 16 cells take about a second.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Vector3, scene::{Brdf, FactoredBrdf, Lambert, Phong}};
/// // A diffuse surface is one term; a lobe needs some.
/// let matt = FactoredBrdf::new(&Lambert::new([0.5; 3])?, 6, 1)?;
/// assert!(matt.errors()[0] < 1e-7);
/// let lobe = FactoredBrdf::new(&Phong::new([0.5; 3], 8.0)?, 6, 12)?;
/// assert!(lobe.errors()[11] < 0.5 * lobe.errors()[1]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FactoredBrdf {
    cells: usize,
    /// [term][cell].
    incident: Vec<Vec<Vector3<f64>>>,
    outgoing: Vec<Vec<f64>>,
    errors: Vec<f64>,
    cell_error: f64,
}

impl FactoredBrdf {
    /// The most cells along the square.
    pub const MAX_CELLS: usize = 32;

    /// The best `terms` products on `cells`² directions of light and of view.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 2 ≤ `cells` ≤ [`MAX_CELLS`](Self::MAX_CELLS) and 1 ≤ `terms` ≤ cells²;
    /// [`Error::NotFinite`] if a value of the BRDF is NaN or infinite (the index is that of wo's cell).
    pub fn new(brdf: &dyn Brdf, cells: usize, terms: usize) -> Result<Self> {
        if !(2..=Self::MAX_CELLS).contains(&cells) {
            return Err(Error::OutOfRange {
                what: "cells of a factored BRDF", got: cells as f64, allowed: "in 2…32"
            });
        }
        let n = cells * cells;
        if !(1..=n).contains(&terms) {
            let what = "terms of a factored BRDF";
            return Err(Error::OutOfRange { what, got: terms as f64, allowed: "in 1…the square of the cells" });
        }
        let directions: Vec<Vector3<f64>> =
            (0..n).map(|i| ConcentricSquare::cell_direction(cells, i).into_inner()).collect();
        let weights: Vec<f64> = directions.iter().map(|d| d.z.sqrt()).collect();
        let rows: Vec<Vec<f64>> = parallel::map(n, |o| {
            let value = |i: usize| brdf.eval(&directions[i], &directions[o]) * (weights[i] * weights[o]);
            (0..n).flat_map(|i| <[f64; 3]>::from(value(i))).collect()
        });
        if let Some(index) = rows.iter().position(|row| !row.iter().all(|v| v.is_finite())) {
            return Err(Error::NotFinite { what: "value of BRDF for the view of cell", index });
        }
        let matrix = DMatrix::from_fn(n, 3 * n, |o, i| rows[o][i]);
        // f = Σ u_k (u_kᵀ f): only the left singular vectors are wanted, the eigenvectors of f fᵀ.
        let eigen = (&matrix * matrix.transpose()).symmetric_eigen();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let (mut incident, mut outgoing) = (Vec::new(), Vec::new());
        let mut rest = matrix.clone();
        let (whole, mut errors) = (matrix.norm(), Vec::new());
        for &k in &order[..terms] {
            let mut left = eigen.eigenvectors.column(k).into_owned();
            // The sign that makes the sum positive, so that it does not depend on how vectors were found.
            if left.sum() < 0.0 {
                left.neg_mut();
            }
            let right = rest.tr_mul(&left);
            rest.ger(-1.0, &left, &right, 1.0);
            let rgb = |i: usize| Vector3::new(right[3 * i], right[3 * i + 1], right[3 * i + 2]) / weights[i];
            incident.push((0..n).map(rgb).collect());
            outgoing.push((0..n).map(|o| left[o] / weights[o]).collect());
            errors.push(if whole > 0.0 { rest.norm() / whole } else { 0.0 });
        }
        let mut factored = Self { cells, incident, outgoing, errors, cell_error: 0.0 };
        factored.cell_error = factored.distance_between_cells(brdf);
        Ok(factored)
    }

    /// Cells along the square.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// How many products there are.
    pub fn terms(&self) -> usize {
        self.incident.len()
    }

    /// The error of the first 1, 2, … terms at the cells' centres: ‖f − Σ‖/‖f‖ with both cosines as weights.
    pub fn errors(&self) -> &[f64] {
        &self.errors
    }

    /// The same error of all terms at the corners between cells, where look-ups are farthest from what was tabulated.
    pub fn cell_error(&self) -> f64 {
        self.cell_error
    }

    /// g_k(wi) in RGB; 0 below the horizon.
    ///
    /// # Panics
    /// If there is no such term.
    #[track_caller]
    pub fn incident(&self, term: usize, wi: &Vector3<f64>) -> Vector3<f64> {
        self.look_up(wi).map_or(Vector3::zeros(), |corners| {
            corners.iter().map(|&(cell, weight)| self.incident[term][cell] * weight).sum()
        })
    }

    /// g_k(wi) of the first terms at once, as many as there is room for; 0 below the horizon.
    ///
    /// # Panics
    /// If there are fewer terms.
    #[track_caller]
    pub fn incident_terms(&self, wi: &Vector3<f64>, out: &mut [Vector3<f64>]) {
        let (corners, tables) = (self.look_up(wi), &self.incident[..out.len()]);
        for (out, table) in out.iter_mut().zip(tables) {
            *out = corners
                .map_or(Vector3::zeros(), |corners| corners.iter().map(|&(cell, weight)| table[cell] * weight).sum());
        }
    }

    /// h_k(wo); 0 below the horizon.
    ///
    /// # Panics
    /// If there is no such term.
    #[track_caller]
    pub fn outgoing(&self, term: usize, wo: &Vector3<f64>) -> f64 {
        self.look_up(wo)
            .map_or(0.0, |corners| corners.iter().map(|&(cell, weight)| self.outgoing[term][cell] * weight).sum())
    }

    /// [`outgoing`](Self::outgoing) of the first terms at once, as many as there is room for.
    ///
    /// # Panics
    /// If there are fewer terms.
    #[track_caller]
    pub fn outgoing_terms(&self, wo: &Vector3<f64>, out: &mut [f64]) {
        let (corners, tables) = (self.look_up(wo), &self.outgoing[..out.len()]);
        for (out, table) in out.iter_mut().zip(tables) {
            *out = corners.map_or(0.0, |corners| corners.iter().map(|&(cell, weight)| table[cell] * weight).sum());
        }
    }

    /// For a file: cells, terms, then all numbers.
    #[allow(dead_code, reason = "for those back ends whose files hold factors")]
    pub(crate) fn to_numbers(&self) -> (usize, usize, Vec<f64>) {
        let incident = self.incident.iter().flatten().flat_map(|g| <[f64; 3]>::from(*g));
        let outgoing = self.outgoing.iter().flatten().copied();
        let rest = self.errors.iter().copied().chain([self.cell_error]);
        (self.cells, self.terms(), incident.chain(outgoing).chain(rest).collect())
    }

    /// How many numbers a file has of so many cells and terms; none if there are no such factors.
    #[allow(dead_code, reason = "for those back ends whose files hold factors")]
    pub(crate) fn numbers(cells: usize, terms: usize) -> Option<usize> {
        let is_possible = (2..=Self::MAX_CELLS).contains(&cells) && (1..=cells * cells).contains(&terms);
        is_possible.then(|| 4 * terms * cells * cells + terms + 1)
    }

    /// What [`to_numbers`](Self::to_numbers) gave; none for another number of numbers, or one that is not finite.
    #[allow(dead_code, reason = "for those back ends whose files hold factors")]
    pub(crate) fn from_numbers(cells: usize, terms: usize, numbers: &[f64]) -> Option<Self> {
        if Self::numbers(cells, terms) != Some(numbers.len()) || !numbers.iter().all(|x| x.is_finite()) {
            return None;
        }
        let n = cells * cells;
        let (incident, rest) = numbers.split_at(3 * terms * n);
        let (outgoing, rest) = rest.split_at(terms * n);
        let incident: Vec<Vector3<f64>> = incident.as_chunks::<3>().0.iter().map(|&g| g.into()).collect();
        Some(Self {
            cells,
            incident: incident.chunks_exact(n).map(<[_]>::to_vec).collect(),
            outgoing: outgoing.chunks_exact(n).map(<[_]>::to_vec).collect(),
            errors: rest[..terms].to_vec(),
            cell_error: rest[terms],
        })
    }

    /// The four cells around a direction and their weights; `None` below the horizon.
    fn look_up(&self, direction: &Vector3<f64>) -> Option<[(usize, f64); 4]> {
        if !(direction.z > 0.0) {
            return None;
        }
        let point = ConcentricSquare::point(&nalgebra::Unit::new_normalize(*direction));
        let last = (self.cells - 1) as f64;
        let place = |x: f64| {
            let at = ((x + 1.0) * 0.5 * self.cells as f64 - 0.5).clamp(0.0, last);
            let first = (at as usize).min(self.cells - 2);
            (first, at - first as f64)
        };
        let ((i, s), (j, t)) = (place(point.x), place(point.y));
        let cell = |i: usize, j: usize| j * self.cells + i;
        Some([
            (cell(i, j), (1.0 - s) * (1.0 - t)),
            (cell(i + 1, j), s * (1.0 - t)),
            (cell(i, j + 1), (1.0 - s) * t),
            (cell(i + 1, j + 1), s * t),
        ])
    }

    fn distance_between_cells(&self, brdf: &dyn Brdf) -> f64 {
        let n = self.cells - 1;
        let line = |i: usize| 2.0 * (i + 1) as f64 / self.cells as f64 - 1.0;
        let corner = |i: usize| ConcentricSquare::direction(&Vector2::new(line(i % n), line(i / n))).into_inner();
        let sums: Vec<[f64; 2]> = parallel::map(n * n, |o| {
            let wo = corner(o);
            (0..n * n).fold([0.0; 2], |[off, all], i| {
                let (wi, weight) = (corner(i), wo.z);
                let (exact, got) = (brdf.eval(&wi, &wo), self.eval(&wi, &wo));
                let weight = weight * wi.z;
                [off + (got - exact).norm_squared() * weight, all + exact.norm_squared() * weight]
            })
        });
        let [off, all] = sums.iter().fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
        if all > 0.0 { (off / all).sqrt() } else { 0.0 }
    }
}

impl Brdf for FactoredBrdf {
    fn eval(&self, wi: &Vector3<f64>, wo: &Vector3<f64>) -> Vector3<f64> {
        if let Some(value) = off_surface(wi, wo) {
            return value;
        }
        let (Some(light), Some(view)) = (self.look_up(wi), self.look_up(wo)) else { return Vector3::zeros() };
        let mut sum = Vector3::zeros();
        for (g, h) in self.incident.iter().zip(&self.outgoing) {
            let g: Vector3<f64> = light.iter().map(|&(cell, weight)| g[cell] * weight).sum();
            let h: f64 = view.iter().map(|&(cell, weight)| h[cell] * weight).sum();
            sum += g * h;
        }
        sum
    }
}
