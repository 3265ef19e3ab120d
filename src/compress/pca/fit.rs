//! Finding components.

use super::super::dense::{
    Factors, Left, Part, Rows, Scaling, combine, largest_positive, orthonormalise, symmetric_eigen, there_and_back,
    times_rows, transpose_times,
};
use super::super::random::Random;
use super::settings::{PcaMethod, PcaSettings};
use crate::Real;

/// Orthonormal components, one a row, and σ² of the scaled, shifted matrix for each, descending.
pub(in super::super) struct Fit {
    pub components: Vec<f64>,
    pub values: Vec<f64>,
}

/// What components are sought of: rows of a matrix less a mean.
#[derive(Clone, Copy)]
pub(in super::super) struct Source<'a, T> {
    pub data: &'a [T],
    /// As many numbers as the matrix has columns.
    pub mean: &'a [T],
    pub scaling: Scaling,
    /// Which rows; all if `None`.
    pub order: Option<&'a [u32]>,
}

impl<T: Real> Source<'_, T> {
    fn shift<E: Real>(&self) -> Vec<E> {
        let factor = E::of(self.scaling.factor());
        self.mean.iter().map(|m| E::of(m.widen()) * factor).collect()
    }

    fn rows<'a, E: Real>(&'a self, shift: &'a [E]) -> Rows<'a, T, E> {
        let rows = Rows::new(self.data, shift, self.scaling);
        match self.order {
            Some(order) => rows.only(order),
            None => rows,
        }
    }

    fn len(&self) -> usize {
        self.order.map_or(self.data.len() / self.mean.len(), <[u32]>::len)
    }
}

/// The components of largest variance, at most `settings.components`; signs are such that the entry of largest
/// magnitude is positive.
pub(in super::super) fn fit<T: Real>(source: &Source<T>, settings: &PcaSettings) -> Fit {
    let side = source.len().min(source.mean.len());
    let sketch = settings.components.saturating_add(settings.oversampling).min(side);
    let exact = match settings.method {
        PcaMethod::Auto => side <= 2 * sketch,
        PcaMethod::Exact => true,
        PcaMethod::Randomised => false,
    };
    let mut fit = match settings.components.min(side) {
        0 => Fit { components: Vec::new(), values: Vec::new() },
        _ if exact => exact_fit(source, settings.components),
        _ => randomised_fit(source, settings, sketch),
    };
    fit.components.chunks_exact_mut(source.mean.len()).for_each(largest_positive);
    fit
}

/// How many of the largest σ² are components: at most `wanted`, and none that rounding may have made.
///
/// Rounding of the elements of the matrix makes singular values of about 2 ε σ_1, sums of 256 of them 16 times as much;
/// the Gram matrix in `f64` makes eigenvalues of a few dozen of its own ε.
fn rank<T: Real>(values: &[f64], wanted: usize) -> usize {
    let noise = (32.0 * T::epsilon().widen()).powi(2).max(64.0 * f64::EPSILON);
    let least = values.first().map_or(0.0, |largest| largest * noise);
    values.iter().take(wanted).take_while(|&&value| value > least).count()
}

fn exact_fit<T: Real>(source: &Source<T>, wanted: usize) -> Fit {
    let shift = source.shift::<f64>();
    let rows = source.rows(&shift);
    let (count, columns) = (rows.len(), rows.columns());
    if count >= columns {
        // Aᵀ A: its eigenvectors are the components.
        let mut found = symmetric_eigen(&transpose_times(&rows, Left::Itself(Part::Lower)), columns);
        let kept = rank::<T>(&found.values, wanted);
        found.values.truncate(kept);
        found.vectors.truncate(kept * columns);
        return Fit { components: found.vectors, values: found.values };
    }
    // A Aᵀ: its eigenvectors u give the components Aᵀ u/σ.
    let mut gram = vec![0.0; count * count];
    times_rows(&rows, &Factors::new(&rows), Part::Lower, &mut gram);
    let mut found = symmetric_eigen(&gram, count);
    let kept = rank::<T>(&found.values, wanted);
    found.values.truncate(kept);
    let u: Vec<f64> = (0..count * kept).map(|at| found.vectors[at % kept * count + at / kept]).collect();
    let mut components = transpose_times(&rows, Left::Matrix(&u, kept));
    // Their lengths are σ; what is small next to σ_1 is not quite orthogonal.
    let kept = orthonormalise(&mut components, columns);
    found.values.truncate(kept);
    Fit { components, values: found.values }
}

/// Q = orthonormal rows of Ω A (Aᵀ A)^q, Ω random; components are those of A in the span of Q.
///
/// Only Q is made orthonormal, not A Qᵀ on the way back: after the first round its rows are nearly singular vectors, so
/// that the columns of A Qᵀ are nearly orthogonal by themselves, and rounding costs what lies below ε σ_1 only.
fn randomised_fit<T: Real>(source: &Source<T>, settings: &PcaSettings, sketch: usize) -> Fit {
    let shift = source.shift::<T>();
    let rows = source.rows(&shift);
    let columns = rows.columns();
    let mut y = random_matrix(rows.len(), sketch, settings.seed);
    let mut q = transpose_times(&rows, Left::Matrix(&y, sketch));
    for round in 0..=settings.power_iterations {
        let kept = orthonormalise(&mut q, columns);
        if kept == 0 {
            return Fit { components: Vec::new(), values: Vec::new() };
        }
        let narrow: Vec<T> = q.iter().map(|&x| T::of(x)).collect();
        let factors = Factors::plain(&narrow, columns);
        if round < settings.power_iterations {
            q = there_and_back(&rows, &factors);
        } else {
            y.resize(rows.len() * kept, T::zero());
            times_rows(&rows, &factors, Part::All, &mut y);
        }
    }
    let kept = q.len() / columns;
    let zeros = vec![0.0; kept];
    let projected = Rows::<T, f64>::new(&y, &zeros, Scaling::of::<f64>(0.0));
    let mut found = symmetric_eigen(&transpose_times(&projected, Left::Itself(Part::Lower)), kept);
    let rank = rank::<T>(&found.values, settings.components);
    found.values.truncate(rank);
    Fit { components: combine(&found.vectors[..rank * kept], &q, kept), values: found.values }
}

/// `rows` × `columns` numbers in (−1, 1), a sequence for each row. Not signs: square matrices of few signs are often
/// singular.
fn random_matrix<T: Real>(rows: usize, columns: usize, seed: u64) -> Vec<T> {
    let row = |row: usize| {
        let mut random = Random::new(seed, row as u64);
        (0..columns).map(move |_| T::of(2.0 * random.unit() - 1.0))
    };
    (0..rows).flat_map(row).collect()
}
