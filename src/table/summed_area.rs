//! Building summed-area tables.

use pulp::{Arch, Simd, WithSimd};

use super::prefix;
use crate::error::check_length;
use crate::numeric::{align_stack, arch_256};
use crate::{Error, Real, Result, parallel};

/// How to build summed-area tables of one image size into the caller's memory, one or many.
/// ```math
/// S(r, c) = Σ_{y < r, x < c} f(x, y)            [Xu 2006 eq. 2, with the exclusive table that its indices need]
/// ```
///
/// Shapes: samples row-major, width·height of them; a table has (height + 1) rows of width + 1 entries, row 0 and
/// column 0 zero. The source and the table each are `f32` or `f64`; sums run in the table's type.
/// Accuracy: an entry is within ((width/8 + height/64 + 64 + 8)·ε) of Σ|f|, ε of the table's type. An `f32` table loses
/// that much even where its entries are right to the last bit, because a small sum is a difference of large ones: `f64`
/// for anything larger than a few hundred pixels a side.
/// Cost: reads each sample once, writes each entry once. The same bits on every machine, alone, in a batch or on many
/// threads. NaN and infinities reach exactly the entries right of and below their pixel; rectangles that end before it
/// stay right.
///
/// # Example
/// ```
/// # fn main() -> Result<(), haarmonic::Error> {
/// use haarmonic::table::{SummedAreaPlan, SummedAreaRef};
/// let plan = SummedAreaPlan::new(2, 2)?;
/// let (mut table, mut scratch) = (vec![0.0_f64; plan.table_len()], vec![0.0; plan.scratch_len()]);
/// plan.build(&[1.0_f32, 2.0, 3.0, 4.0], &mut table, &mut scratch);
/// assert_eq!(table, [0.0, 0.0, 0.0, 0.0, 1.0, 3.0, 0.0, 4.0, 10.0]);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct SummedAreaPlan {
    width: usize,
    height: usize,
    arch: Arch,
}

impl SummedAreaPlan {
    /// Plans tables of `width` × `height` images; either may be 0.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a table cannot be addressed.
    pub fn new(width: usize, height: usize) -> Result<Self> {
        // Of 65 bits each: the product of the largest two does not fit 128.
        let entries = (width as u128 + 1).saturating_mul(height as u128 + 1);
        if entries > (isize::MAX as u128) / 16 {
            return Err(Error::OutOfRange { what: "summed-area table", got: entries as f64, allowed: "addressable" });
        }
        Ok(Self { width, height, arch: Arch::new() })
    }

    /// The width of an image.
    #[inline]
    pub fn width(&self) -> usize {
        self.width
    }

    /// The height of an image.
    #[inline]
    pub fn height(&self) -> usize {
        self.height
    }

    /// The number of samples of an image.
    #[inline]
    pub fn samples_len(&self) -> usize {
        self.width * self.height
    }

    /// The number of entries of a table: (width + 1)·(height + 1).
    #[inline]
    pub fn table_len(&self) -> usize {
        (self.width + 1) * (self.height + 1)
    }

    /// How much scratch [`build`](Self::build) wants, at least: two rows.
    #[inline]
    pub fn scratch_len(&self) -> usize {
        2 * self.width
    }

    /// Fills `table` with the summed-area table of an image.
    ///
    /// # Panics
    /// If `samples.len()` is not [`samples_len`](Self::samples_len), `table.len()` not [`table_len`](Self::table_len),
    /// or `scratch` shorter than [`scratch_len`](Self::scratch_len).
    #[track_caller]
    pub fn build<S: Real, T: Real>(&self, samples: &[S], table: &mut [T], scratch: &mut [T]) {
        check_length("samples", self.samples_len(), samples.len());
        self.build_batch(samples, table, scratch);
    }

    /// The tables of images that lie one after another: as many as `table` holds.
    ///
    /// # Panics
    /// If `table.len()` is not a multiple of [`table_len`](Self::table_len), `samples.len()` not that number of images,
    /// or `scratch` shorter than [`scratch_len`](Self::scratch_len).
    #[track_caller]
    pub fn build_batch<S: Real, T: Real>(&self, samples: &[S], table: &mut [T], scratch: &mut [T]) {
        self.check(samples.len(), table.len());
        if scratch.len() < self.scratch_len() {
            crate::error::length_mismatch("scratch", self.scratch_len(), scratch.len());
        }
        let (above, rest) = scratch.split_at_mut(self.width);
        let columns = [above, &mut rest[..self.width]];
        self.arch::<S, T>().dispatch(Tables { height: self.height, samples, tables: table, columns });
    }

    /// [`build_batch`](Self::build_batch) on all threads (feature `rayon`; on one without it), with scratch of its own.
    /// The same bits.
    ///
    /// # Panics
    /// As [`build_batch`](Self::build_batch), but for the scratch.
    #[track_caller]
    pub fn build_batch_parallel<S: Real, T: Real>(&self, samples: &[S], table: &mut [T]) {
        self.check(samples.len(), table.len());
        let scratch = || vec![T::zero(); self.scratch_len()];
        // Some 64 KiB of samples a task: enough to hide its start, little enough to balance.
        let images = ((1 << 14) / self.samples_len().max(1)).max(1);
        parallel::chunks(table, images * self.table_len(), scratch, |k, table, scratch| {
            let samples = &samples[k * images * self.samples_len()..];
            let here = table.len() / self.table_len() * self.samples_len();
            self.build_batch(&samples[..here], table, scratch);
        });
    }

    /// [`build`](Self::build) of one image on all threads (feature `rayon`; on one without it). The same bits.
    ///
    /// It sums everything twice, and allocates a row for each 64 of the image: for images of a million samples on more
    /// than two threads.
    ///
    /// # Panics
    /// As [`build`](Self::build), but for the scratch.
    #[track_caller]
    pub fn build_parallel<S: Real, T: Real>(&self, samples: &[S], table: &mut [T]) {
        check_length("samples", self.samples_len(), samples.len());
        check_length("table", self.table_len(), table.len());
        if parallel::pieces() > 1 && self.width > 0 && self.height > prefix::BAND {
            return self.build_bands(samples, table);
        }
        self.build(samples, table, &mut vec![T::zero(); self.scratch_len()]);
    }

    fn build_bands<S: Real, T: Real>(&self, samples: &[S], table: &mut [T]) {
        let (width, band) = (self.width, prefix::BAND);
        let samples_of = |k: usize| &samples[k * band * width..samples.len().min((k + 1) * band * width)];
        let scratch = || vec![T::zero(); 2 * width + 1];
        // The table's rows above each band: what the bands add, apart, and then one after the other.
        let mut above = vec![T::zero(); self.height.div_ceil(band) * width];
        parallel::chunks(&mut above[width..], width, scratch, |k, sums, scratch| {
            self.arch::<S, T>().dispatch(Sums { samples: samples_of(k), scratch, sums });
        });
        for start in (width..above.len()).step_by(width) {
            let (before, this) = above.split_at_mut(start);
            for (sum, &before) in this[..width].iter_mut().zip(&before[start - width..]) {
                *sum = before + *sum;
            }
        }
        let (first, rest) = table.split_at_mut(width + 1);
        first.fill(T::zero());
        parallel::chunks(rest, band * (width + 1), scratch, |k, table, scratch| {
            let (above, sums) = (&above[k * width..][..width], &mut scratch[..width]);
            self.arch::<S, T>().dispatch(Band { samples: samples_of(k), above, sums, table });
        });
    }

    /// Two rows of sixteen columns are for registers of 256 bits: with those of 512 they take 1.2 times as long.
    fn arch<S, T>(&self) -> Arch {
        if prefix::by_two::<S, T>() { arch_256() } else { self.arch }
    }

    #[track_caller]
    fn check(&self, samples: usize, table: usize) {
        if table % self.table_len() != 0 {
            crate::error::length_mismatch("tables, a multiple of", self.table_len(), table);
        }
        check_length("samples", table / self.table_len() * self.samples_len(), samples);
    }
}

/// A batch, one table after another.
struct Tables<'a, S, T> {
    height: usize,
    samples: &'a [S],
    tables: &'a mut [T],
    columns: [&'a mut [T]; 2],
}

impl<S: Real, T: Real> WithSimd for Tables<'_, S, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(self, _: V) {
        align_stack();
        let [above, band] = self.columns;
        let (width, pitch) = (above.len(), above.len() + 1);
        if width == 0 || self.height == 0 {
            return self.tables.fill(T::zero());
        }
        let images = self.samples.chunks_exact(width * self.height);
        for (samples, table) in images.zip(self.tables.chunks_exact_mut(pitch * (self.height + 1))) {
            above.fill(T::zero());
            let (first, rest) = table.split_at_mut(pitch);
            first.fill(T::zero());
            let bands = samples.chunks(prefix::BAND * width).zip(rest.chunks_mut(prefix::BAND * pitch));
            for (k, (samples, table)) in bands.enumerate() {
                if k > 0 {
                    for (above, &band) in above.iter_mut().zip(&*band) {
                        *above += band;
                    }
                }
                band.fill(T::zero());
                prefix::band(samples, above, band, table);
            }
        }
    }
}

/// What a band adds to the table's row above it; the table's own rows are left in scratch, zeros followed by a row.
struct Sums<'a, S, T> {
    samples: &'a [S],
    scratch: &'a mut [T],
    sums: &'a mut [T],
}

impl<S: Real, T: Real> WithSimd for Sums<'_, S, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(self, _: V) {
        align_stack();
        let width = self.sums.len();
        let (zeros, row) = self.scratch.split_at_mut(width);
        for samples in self.samples.chunks_exact(width) {
            prefix::band(samples, zeros, self.sums, row);
        }
    }
}

struct Band<'a, S, T> {
    samples: &'a [S],
    above: &'a [T],
    sums: &'a mut [T],
    table: &'a mut [T],
}

impl<S: Real, T: Real> WithSimd for Band<'_, S, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(self, _: V) {
        align_stack();
        self.sums.fill(T::zero());
        prefix::band(self.samples, self.above, self.sums, self.table);
    }
}
