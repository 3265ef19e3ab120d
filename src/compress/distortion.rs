//! What compression with loss loses.

use crate::approx_eq::approx_by_parts;
use crate::numeric::SquareSum;
use crate::store::{Reader, Writer};
use crate::{Error, Real, Result, parallel};

/// How far numbers are from what compression made of them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Distortion {
    /// The largest difference.
    pub max: f64,
    /// √ of the mean squared difference.
    pub rms: f64,
    /// √(Σ (x − x')² / Σ x²): 0 if nothing is lost, 1 if all is; 0 for zeros that stay zeros, infinite for zeros that
    /// do not.
    pub relative: f64,
}

impl Distortion {
    /// Whether it can be one: no error is NaN or below 0.
    pub(super) fn check(self) -> Result<()> {
        match [self.max, self.rms, self.relative].into_iter().find(|error| !(*error >= 0.0)) {
            Some(got) => Err(Error::OutOfRange { what: "distortion", got, allowed: "at least 0" }),
            None => Ok(()),
        }
    }

    /// Writes the section `DIST`: max f64, rms f64, relative f64.
    pub(super) fn write(self, to: &mut Writer) -> Result<()> {
        to.section(*b"DIST", |s| s.array(&[self.max, self.rms, self.relative]))
    }

    /// Reads what [`write`](Self::write) wrote.
    pub(super) fn read(from: &mut Reader) -> Result<Self> {
        let mut section = from.section(*b"DIST")?;
        let [max, rms, relative] = [(); 3].map(|()| section.field("a distortion"));
        let distortion = Self { max: max?, rms: rms?, relative: relative? };
        section.end()?;
        Ok(distortion)
    }

    /// Of numbers and what is left of them, of any magnitude; all 0 if there are none. NaN in either makes `rms` NaN; a
    /// difference that overflows is infinite.
    ///
    /// # Panics
    /// If the lengths differ.
    #[track_caller]
    pub fn between<T: Real>(original: &[T], compressed: &[T]) -> Self {
        crate::error::check_length("compressed numbers", original.len(), compressed.len());
        Self::of_rows(original, 1, |first, _, out| out.copy_from_slice(&compressed[first..][..out.len()]))
    }

    /// Of rows; `with(first row, rows, out)` writes what is left of some of them. In chunks that are folded in order.
    pub(super) fn of_rows<T: Real>(
        original: &[T],
        columns: usize,
        with: impl Fn(usize, &[T], &mut [T]) + Sync + Send,
    ) -> Self {
        let chunk = (1usize << 16).div_ceil(columns) * columns;
        let pieces = parallel::map(original.len().div_ceil(chunk), |piece| {
            let rows = &original[piece * chunk..original.len().min((piece + 1) * chunk)];
            let mut out = vec![T::zero(); rows.len()];
            with(piece * chunk / columns, rows, &mut out);
            let pairs = || rows.iter().zip(&out).map(|(x, y)| (x.widen(), x.widen() - y.widen()));
            let plain = pairs().fold(([0.0f64; 2], [0.0; 2]), |([most, max], [energy, squares]), (x, d)| {
                ([most.max(x.abs()), max.max(d.abs())], [energy + x * x, squares + d * d])
            });
            let ([most, max], [energy, squares]) = plain;
            if SquareSum::is_plain(energy, most) && SquareSum::is_plain(squares, max) {
                return (max, SquareSum::plain(energy), SquareSum::plain(squares));
            }
            // Squares that leave the range, or NaN.
            let mut sums = (max, SquareSum::default(), SquareSum::default());
            for (x, d) in pairs() {
                sums.1.add(x);
                sums.2.add(d);
            }
            sums
        });
        let nothing = (0.0f64, SquareSum::default(), SquareSum::default());
        let sum = pieces.into_iter().fold(nothing, |a, b| (a.0.max(b.0), a.1.merge(b.1), a.2.merge(b.2)));
        let (max, energy, squares) = sum;
        Self { max, rms: squares.root_mean(original.len() as f64), relative: squares.root_ratio(energy) }
    }
}

approx_by_parts!([] Distortion, f64, |d| close [[d.max, d.rms, d.relative]] same []);
