//! Mean, total variance and largest magnitude of rows, in one pass.

use pulp::{Arch, Simd, WithSimd};

use crate::{Error, Real, Result, parallel};

/// First and second moments of the columns about a row of the matrix, and the largest magnitude.
pub(in super::super) struct Moments {
    /// Mean of each column.
    pub mean: Vec<f64>,
    /// Σ (x − mean)², all elements.
    pub deviation: f64,
    /// Σ x², all elements.
    pub energy: f64,
    /// max |x|.
    pub largest: f64,
}

impl Moments {
    /// Moments about the first row r: the mean is r + Σ(x − r)/n, exact where all rows are equal, and Σ(x − mean)² =
    /// Σ(x − r)² − n (mean − r)² cancels by a factor of n at most, because r is one of the rows. In chunks of rows,
    /// folded in order.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::OutOfRange`] for magnitudes above 1e140, whose squares are not finite.
    pub(in super::super) fn of<T: Real>(data: &[T], columns: usize) -> Result<Self> {
        const CHUNK: usize = 512;
        let rows = data.len() / columns;
        let arch = Arch::new();
        let pieces = parallel::map(rows.div_ceil(CHUNK), |piece| {
            let chunk = &data[piece * CHUNK * columns..data.len().min((piece + 1) * CHUNK * columns)];
            arch.dispatch(Piece { reference: &data[..columns], chunk })
        });
        let (mut first, mut second) = (vec![0.0; columns], vec![0.0; columns]);
        let (mut energy, mut largest) = (0.0, 0.0f64);
        for sums in pieces {
            for c in 0..columns {
                first[c] += sums.first[c];
                second[c] += sums.second[c];
            }
            energy += sums.energy;
            largest = if sums.largest > largest || sums.largest.is_nan() { sums.largest } else { largest };
        }
        // Sums are finite if and only if all elements are and none is too large.
        if !(largest <= 1e140 && energy.is_finite()) {
            return Err(offender(data));
        }
        let n = rows as f64;
        let deviation = (0..columns).map(|c| (second[c] - first[c] * first[c] / n).max(0.0)).sum();
        let mean = (0..columns).map(|c| data[c].widen() + first[c] / n).collect();
        Ok(Self { mean, deviation, energy, largest })
    }
}

#[cold]
fn offender<T: Real>(data: &[T]) -> Error {
    match data.iter().position(|x| !x.is_finite()) {
        Some(index) => Error::NotFinite { what: "matrix element", index },
        None => {
            let got = data.iter().map(|x| x.widen()).find(|x| x.abs() > 1e140).unwrap_or(f64::INFINITY);
            Error::OutOfRange { what: "matrix element", got, allowed: "at most 1e140 in magnitude" }
        }
    }
}

struct Sums {
    first: Vec<f64>,
    second: Vec<f64>,
    energy: f64,
    largest: f64,
}

struct Piece<'a, T> {
    reference: &'a [T],
    chunk: &'a [T],
}

impl<T: Real> WithSimd for Piece<'_, T> {
    type Output = Sums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Sums {
        const L: usize = 4;
        let columns = self.reference.len();
        let (mut first, mut second) = (vec![0.0; columns], vec![0.0; columns]);
        let (mut energies, mut most) = ([0.0; L], [T::zero(); L]);
        let (reference, reference_rest) = self.reference.as_chunks::<L>();
        for row in self.chunk.chunks_exact(columns) {
            let (row, rest) = row.as_chunks::<L>();
            let ((first, first_rest), (second, second_rest)) =
                (first.as_chunks_mut::<L>(), second.as_chunks_mut::<L>());
            for (((row, reference), first), second) in row.iter().zip(reference).zip(first).zip(second) {
                // One operation a loop, or LLVM leaves them scalar.
                let x = row.map(|x| x.widen());
                let mut d = [0.0; L];
                for l in 0..L {
                    d[l] = x[l] - reference[l].widen();
                }
                for l in 0..L {
                    first[l] += d[l];
                }
                for l in 0..L {
                    second[l] += d[l] * d[l];
                }
                for l in 0..L {
                    energies[l] += x[l] * x[l];
                }
                for l in 0..L {
                    most[l] = if row[l].abs() > most[l] { row[l].abs() } else { most[l] };
                }
            }
            for (((x, r), first), second) in rest.iter().zip(reference_rest).zip(first_rest).zip(second_rest) {
                let (x, d) = (x.widen(), x.widen() - r.widen());
                *first += d;
                *second += d * d;
                energies[0] += x * x;
                most[0] = most[0].max(T::of(x.abs()));
            }
        }
        let energy = energies.iter().sum();
        Sums { first, second, energy, largest: most.iter().fold(0.0, |max: f64, x| max.max(x.widen())) }
    }
}
