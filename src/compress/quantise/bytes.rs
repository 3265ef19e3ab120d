//! 8 bits a number, with an offset and a step for numbers that belong together.

use super::super::distortion::Distortion;
use crate::error::check_length;
use crate::{Error, Real, Result, parallel};

/// Which numbers of a row-major matrix share an offset and a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ByteBlocks {
    /// A row: rows that differ in size, such as components.
    Rows,
    /// A column: numbers whose size goes by their place, such as weights of principal components.
    Columns,
    /// This many numbers one after the other, whatever the rows; the last block may be shorter.
    Runs(usize),
}

/// Numbers as 8 bits each.
/// ```math
/// x ≈ offset + step·q,   offset = min,   step = (max − min)/255,   q = round((x − offset)/step)
/// ```
///
/// Within half a step of each number, but for rounding in `T` (2 ε of the block's largest magnitude): the ends are met,
/// a block of equal numbers is exact.
///
/// # Example
/// ```
/// use haarmonic::compress::{ByteBlocks, QuantisedBytes};
/// let weights = [0.0f32, 100.0, 2.55, 400.0, 1.0, 355.0]; // three rows of two
/// let bytes = QuantisedBytes::new(&weights, 2, ByteBlocks::Columns)?;
/// assert_eq!((bytes.codes()[2], bytes.block(0)), (255, (0.0, 0.01)));
/// assert!(bytes.distortion().max <= 300.0 / 255.0 / 2.0);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct QuantisedBytes<T> {
    codes: Vec<u8>,
    columns: usize,
    blocks: ByteBlocks,
    offsets: Vec<T>,
    steps: Vec<T>,
    distortion: Distortion,
}

impl<T: Real> QuantisedBytes<T> {
    /// Quantises a row-major matrix; for [`ByteBlocks::Runs`] `columns` may be 1. No numbers are allowed.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for NaN and infinity; [`Error::OutOfRange`] for no columns, more than 65536 without rows,
    /// runs of none and blocks whose max − min is more than half the largest number; [`Error::Length`] unless rows are
    /// whole.
    pub fn new(values: &[T], columns: usize, blocks: ByteBlocks) -> Result<Self> {
        let count = count_blocks(values.len(), columns, blocks)?;
        if let Some(index) = values.iter().position(|x| !x.is_finite()) {
            return Err(Error::NotFinite { what: "number", index });
        }
        let mut all = Self {
            codes: vec![0; values.len()],
            columns,
            blocks,
            offsets: vec![T::infinity(); count],
            steps: vec![T::neg_infinity(); count], // the largest, first
            distortion: Distortion::default(),
        };
        for (i, &x) in values.iter().enumerate() {
            let block = all.block_of(i);
            all.offsets[block] = all.offsets[block].min(x);
            all.steps[block] = all.steps[block].max(x);
        }
        for (offset, step) in all.offsets.iter_mut().zip(&mut all.steps) {
            if *offset > *step {
                (*offset, *step) = (T::zero(), T::zero()); // a column without rows
            }
            let range = *step - *offset;
            // Twice, so that rounding does not carry a decoded number out of the scalar.
            if !(range + range).is_finite() {
                return Err(Error::OutOfRange {
                    what: "range of a block",
                    got: range.widen(),
                    allowed: "half the largest number at most",
                });
            }
            *step = T::of(range.widen() / 255.0);
        }
        let mut codes = std::mem::take(&mut all.codes);
        parallel::rows(&mut codes, 1, 4096, |i, code| code[0] = all.code(i, values[i]));
        all.codes = codes;
        all.distortion = Distortion::of_rows(values, 1, |first, _, out| {
            out.iter_mut().enumerate().for_each(|(i, out)| *out = all.value(first + i));
        });
        Ok(all)
    }

    /// From codes, offsets and steps, and how far quantisation moved the numbers (the default, if that is not known):
    /// for those that were stored.
    ///
    /// # Errors
    /// As [`new`](Self::new) for the shape; [`Error::Length`] unless every block has an offset and a step;
    /// [`Error::NotFinite`] unless these are finite, and so is what the largest code stands for; [`Error::OutOfRange`]
    /// for a step below 0, and a distortion that is NaN or below 0.
    pub fn from_parts(
        codes: Vec<u8>,
        columns: usize,
        blocks: ByteBlocks,
        offsets: Vec<T>,
        steps: Vec<T>,
        distortion: Distortion,
    ) -> Result<Self> {
        distortion.check()?;
        let expected = count_blocks(codes.len(), columns, blocks)?;
        for (what, got) in [("offsets of blocks", offsets.len()), ("steps of blocks", steps.len())] {
            if got != expected {
                return Err(Error::Length { what, expected, got });
            }
        }
        for (index, (offset, step)) in offsets.iter().zip(&steps).enumerate() {
            if *step < T::zero() {
                return Err(Error::OutOfRange { what: "step of a block", got: step.widen(), allowed: "at least 0" });
            }
            let end = T::of(offset.widen() + 255.0 * step.widen());
            if !(offset.is_finite() && step.is_finite() && end.is_finite()) {
                return Err(Error::NotFinite { what: "end of block", index });
            }
        }
        Ok(Self { codes, columns, blocks, offsets, steps, distortion })
    }

    /// Numbers of a row.
    #[inline]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Which numbers share an offset and a step.
    #[inline]
    pub fn blocks(&self) -> ByteBlocks {
        self.blocks
    }

    /// The offset of each block.
    #[inline]
    pub fn offsets(&self) -> &[T] {
        &self.offsets
    }

    /// The step of each block.
    #[inline]
    pub fn steps(&self) -> &[T] {
        &self.steps
    }

    #[inline]
    fn block_of(&self, i: usize) -> usize {
        match self.blocks {
            ByteBlocks::Rows => i / self.columns,
            ByteBlocks::Columns => i % self.columns,
            ByteBlocks::Runs(len) => i / len,
        }
    }

    #[inline]
    fn code(&self, i: usize, x: T) -> u8 {
        let block = self.block_of(i);
        let (offset, step) = (self.offsets[block].widen(), self.steps[block].widen());
        // A step of 0 gives NaN or infinity, as u8 0 or 255: both stand for the offset.
        ((x.widen() - offset) / step).round() as u8
    }

    #[inline]
    fn value(&self, i: usize) -> T {
        let block = self.block_of(i);
        let (offset, step) = (self.offsets[block].widen(), self.steps[block].widen());
        T::of(offset + step * f64::from(self.codes[i]))
    }

    /// How many numbers there are.
    #[inline]
    pub fn len(&self) -> usize {
        self.codes.len()
    }

    /// Whether there are no numbers.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.codes.is_empty()
    }

    /// The code q of each number.
    #[inline]
    pub fn codes(&self) -> &[u8] {
        &self.codes
    }

    /// Offset and step of a block.
    ///
    /// # Panics
    /// If there is no such block.
    #[inline]
    #[track_caller]
    pub fn block(&self, block: usize) -> (T, T) {
        (self.offsets[block], self.steps[block])
    }

    /// The numbers that the codes stand for.
    ///
    /// # Panics
    /// If `out` has another length.
    #[track_caller]
    pub fn decode(&self, out: &mut [T]) {
        check_length("numbers", self.codes.len(), out.len());
        parallel::rows(out, 1, 4096, |i, out| out[0] = self.value(i));
    }

    /// How far rounding moved the numbers.
    #[inline]
    pub fn distortion(&self) -> Distortion {
        self.distortion
    }

    /// One for each number, and offset and step for each block.
    #[inline]
    pub fn bytes(&self) -> usize {
        self.codes.len() + 2 * self.offsets.len() * size_of::<T>()
    }
}

/// How many blocks there are, for `len` numbers in rows of `columns`.
fn count_blocks(len: usize, columns: usize, blocks: ByteBlocks) -> Result<usize> {
    for (what, got) in [("columns", columns), ("run", if let ByteBlocks::Runs(run) = blocks { run } else { 1 })] {
        if got == 0 {
            return Err(Error::OutOfRange { what, got: 0.0, allowed: "at least 1" });
        }
    }
    if len % columns != 0 {
        let expected = len.next_multiple_of(columns);
        return Err(Error::Length { what: "matrix", expected, got: len });
    }
    // Only of a matrix without rows can the columns be more than its numbers.
    if columns > len.max(1 << 16) {
        let (got, allowed) = (columns as f64, "at most 65536 without rows");
        return Err(Error::OutOfRange { what: "columns", got, allowed });
    }
    Ok(match blocks {
        ByteBlocks::Rows => len / columns,
        ByteBlocks::Columns => columns,
        ByteBlocks::Runs(run) => len.div_ceil(run),
    })
}
