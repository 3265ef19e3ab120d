//! Binary maps in the forms they come in.

use crate::{Error, Result};

/// A borrowed binary map, or many of one size one after another: 1 = unoccluded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BinaryMap<'a> {
    /// One `bool` a pixel, row-major.
    Bools(&'a [bool]),
    /// One byte a pixel, row-major: 1 unless it is 0.
    Bytes(&'a [u8]),
    /// One bit a pixel, row-major: pixel i is bit i mod 64 of word i / 64. Each map starts a word; spare bits are
    /// ignored.
    Bits(&'a [u64]),
}

impl<'a> From<&'a [bool]> for BinaryMap<'a> {
    fn from(map: &'a [bool]) -> Self {
        Self::Bools(map)
    }
}

impl<'a> From<&'a [u8]> for BinaryMap<'a> {
    fn from(map: &'a [u8]) -> Self {
        Self::Bytes(map)
    }
}

impl<'a> From<&'a [u64]> for BinaryMap<'a> {
    fn from(map: &'a [u64]) -> Self {
        Self::Bits(map)
    }
}

impl<'a> BinaryMap<'a> {
    /// The length of one map of `pixels` pixels in this form.
    pub(super) fn unit(&self, pixels: usize) -> usize {
        match self {
            Self::Bools(_) | Self::Bytes(_) => pixels,
            Self::Bits(_) => pixels.div_ceil(64),
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Bools(map) => map.len(),
            Self::Bytes(map) => map.len(),
            Self::Bits(map) => map.len(),
        }
    }

    /// Checks that there are `count` maps of `pixels` pixels.
    pub(super) fn length_error(&self, pixels: usize, count: usize) -> Result<()> {
        let expected = self.unit(pixels) * count;
        if self.len() == expected {
            return Ok(());
        }
        let what = if matches!(self, Self::Bits(_)) { "words of bits" } else { "pixels of a binary map" };
        Err(Error::Length { what, expected, got: self.len() })
    }

    /// Maps `first` to `first + count` of those of `pixels` pixels.
    pub(super) fn part(&self, pixels: usize, first: usize, count: usize) -> Self {
        let unit = self.unit(pixels);
        let range = first * unit..(first + count) * unit;
        match self {
            Self::Bools(map) => Self::Bools(&map[range]),
            Self::Bytes(map) => Self::Bytes(&map[range]),
            Self::Bits(map) => Self::Bits(&map[range]),
        }
    }

    /// Pixels `start..` of a single map as 0 or 1.
    #[inline(always)]
    pub(super) fn row(&self, start: usize, row: &mut [u16]) {
        let count = row.len();
        match self {
            Self::Bools(map) => {
                widen(&map[start..][..count], row, |pixel| pixel);
            }
            Self::Bytes(map) => {
                widen(&map[start..][..count], row, |pixel| pixel != 0);
            }
            Self::Bits(map) => {
                for (k, row) in row.chunks_mut(16).enumerate() {
                    let bits = sixteen_bits(map, start + 16 * k);
                    (0..row.len()).for_each(|i| row[i] = u16::from(bits & (1 << i) != 0));
                }
            }
        }
    }
}

/// In steps of a fixed length: the vector loop that LLVM makes of a length it does not know is longer than a row of a
/// small map.
#[inline(always)]
fn widen<P: Copy>(map: &[P], row: &mut [u16], is_one: impl Fn(P) -> bool) {
    let ((map, map_rest), (row, row_rest)) = (map.as_chunks::<16>(), row.as_chunks_mut::<16>());
    for (map, row) in map.iter().zip(row) {
        let mut step = [0; 16];
        for i in 0..16 {
            step[i] = if is_one(map[i]) { 1 } else { 0 };
        }
        *row = step;
    }
    map_rest.iter().zip(row_rest).for_each(|(&pixel, row)| *row = u16::from(is_one(pixel)));
}

/// Bits `start..`; zeros follow the last word.
#[inline(always)]
fn sixteen_bits(words: &[u64], start: usize) -> u16 {
    let (word, shift) = (start / 64, start % 64);
    let low = words[word] >> shift;
    let high = words.get(word + 1).map_or(0, |next| if shift == 0 { 0 } else { next << (64 - shift) });
    (low | high) as u16
}
