//! The cluster that approximates a row best.
//!
//! |x − m|² − Σ_j (u_j·(x − m))² for every cluster is a product of the row with all means and components; common to all
//! clusters and left out is |x|². Everything is about the mean of the matrix and scaled, so that the sums, in the
//! matrix's precision, lose little. What rounding may still confuse are clusters that are equally good; the squared
//! error itself is taken from the row in `f64`.

use pulp::{Arch, Simd, WithSimd};

use super::super::dense::{Factors, Part, Rows, Scaling, dot, times_some_rows};
use super::bases::Bases;
use crate::parallel::Watch;
use crate::{Real, Result, parallel};

/// Rows of a task: all means and components pass by it once.
const CHUNK: usize = 192;

/// A plan for [`nearest`](Self::nearest).
pub(super) struct Nearest<'a, T> {
    bases: &'a Bases<T>,
    factors: Factors<T>,
    /// |m|² of each cluster; infinite for one that takes no rows.
    mean_squares: Vec<T>,
    /// m·u_j of each cluster.
    mean_weights: Vec<T>,
    shift: Vec<T>,
    scaling: Scaling,
    arch: Arch,
}

/// The cluster of a row and its squared distance from the row, scaled as the matrix is in products.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Place {
    pub label: u32,
    pub error: f64,
}

impl<'a, T: Real> Nearest<'a, T> {
    pub fn new(bases: &'a Bases<T>, centre: &[T], scaling: Scaling) -> Self {
        let (columns, stride) = (bases.columns, bases.components + 1);
        let factor = T::of(scaling.factor());
        let shift: Vec<T> = centre.iter().map(|&x| x * factor).collect();
        let mut data = bases.data.clone();
        let (mut mean_squares, mut mean_weights) = (Vec::new(), Vec::new());
        for (c, basis) in data.chunks_exact_mut(columns * stride).enumerate() {
            let (mean, components) = basis.split_at_mut(columns);
            mean.iter_mut().zip(&shift).for_each(|(m, &s)| *m = *m * factor - s);
            let wide: Vec<f64> = mean.iter().map(|m| m.widen()).collect();
            let square = if bases.sizes[c] == 0 { f64::INFINITY } else { dot(&wide, &wide) };
            mean_squares.push(T::of(square));
            mean_weights
                .extend(components.chunks_exact(columns).map(|u| T::of(super::super::dense::dot_wide(&wide, u))));
        }
        Self {
            bases,
            factors: Factors::plain(&data, columns),
            mean_squares,
            mean_weights,
            shift,
            scaling,
            arch: Arch::new(),
        }
    }

    /// Moves each row to the cluster nearest to it, unless the one that `places` names is as near.
    ///
    /// # Errors
    /// [`Error::Cancelled`], and `places` are of no use.
    pub fn nearest(&self, matrix: &[T], places: &mut [Place], watch: &Watch) -> Result<()> {
        let rows = Rows::new(matrix, &self.shift, self.scaling);
        parallel::try_chunks(
            places,
            CHUNK,
            || (),
            |chunk, places, ()| {
                watch.check()?;
                let mut products = vec![T::zero(); places.len() * self.factors.len()];
                times_some_rows(self.arch, &rows, &self.factors, (chunk * CHUNK, Part::All), &mut products);
                let rows = &matrix[chunk * CHUNK * self.bases.columns..];
                self.arch.dispatch(Choose { plan: self, rows, products: &products, places });
                watch.advance(places.len());
                Ok(())
            },
        )
    }

    /// The cluster with the least |m|² − 2 x·m − Σ (x·u − m·u)²; the first of equals.
    #[inline(always)]
    fn best(&self, products: &[T]) -> usize {
        let k = self.bases.components;
        let (mut best, mut least) = (0, T::infinity());
        for (c, products) in products.chunks_exact(k + 1).enumerate() {
            let mut value = self.mean_squares[c] - (products[0] + products[0]);
            for (&x, &m) in products[1..].iter().zip(&self.mean_weights[c * k..][..k]) {
                value -= (x - m) * (x - m);
            }
            if value < least {
                (best, least) = (c, value);
            }
        }
        best
    }
}

struct Choose<'a, 'b, T> {
    plan: &'a Nearest<'b, T>,
    rows: &'a [T],
    products: &'a [T],
    places: &'a mut [Place],
}

impl<T: Real> WithSimd for Choose<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { plan, rows, products, places } = self;
        let bases = plan.bases;
        let (mut difference, factor) = (vec![0.0; bases.columns], plan.scaling.factor());
        let products = products.chunks_exact(plan.factors.len());
        for ((place, row), products) in places.iter_mut().zip(rows.chunks_exact(bases.columns)).zip(products) {
            let best = plan.best(products) as u32;
            let error = bases.distance(best as usize, row, factor, &mut difference, &mut []);
            let stay = place.label as usize;
            let before = if best == place.label || stay >= bases.clusters() || bases.sizes[stay] == 0 {
                f64::INFINITY
            } else {
                bases.distance(stay, row, factor, &mut difference, &mut [])
            };
            *place = if before <= error { Place { error: before, ..*place } } else { Place { label: best, error } };
        }
    }
}
