//! Means of a binary image at any node, straight from its bits.

use super::super::wavelet_tree::morton;
use super::first_node;
use crate::error::check_length;
use crate::{Error, Real, Result};

/// A binary image (visibility, 1 = unoccluded) as bits in Morton order with the means of its 8×8 blocks and everything
/// above.
///
/// Texel (x, y) is bit m mod 64 of word m / 64, m = the interleaved bits of x (even places) and y (odd places). Every
/// square of the quadtree is then a run of bits, so the four means below any node are bit tests or population counts of
/// one word, or one record of the small table above. Memory at side 64: 512 bytes of bits and 344 of table, against
/// 21.8 kB for a float pyramid.
#[derive(Debug, Clone, PartialEq)]
pub struct BitPyramid {
    levels: u32,
    words: Vec<u64>,
    upper: Vec<[f32; 4]>,
}

/// A borrowed [`BitPyramid`], for callers that keep many in one buffer.
#[derive(Debug, Clone, Copy)]
pub struct BitPyramidRef<'a> {
    levels: u32,
    words: &'a [u64],
    upper: &'a [[f32; 4]],
}

/// log₂ of the number of 64-texel blocks along a side.
const fn block_levels(levels: u32) -> u32 {
    levels.saturating_sub(3)
}

impl BitPyramid {
    /// How many words of bits an image has: side² / 64, at least 1.
    pub const fn words_len(side: usize) -> usize {
        (side * side).div_ceil(64)
    }

    /// How many records of four means the table has: (4^(levels − 3) − 1)/3 + 1, so 22 at side 64 and 1 up to side 8.
    ///
    /// # Panics
    /// If `side` is 0.
    #[track_caller]
    pub const fn upper_len(side: usize) -> usize {
        first_node(block_levels(side.ilog2())) + 1
    }

    /// An image of zeros.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `side` is one; [`Error::OutOfRange`] above 4096 (f32 counts exactly up to 2²⁴
    /// texels).
    pub fn zeros(side: usize) -> Result<Self> {
        let levels = super::levels_of(side)?;
        if levels > 12 {
            return Err(Error::OutOfRange { what: "side of a bit pyramid", got: side as f64, allowed: "at most 4096" });
        }
        let upper = vec![[0.0; 4]; Self::upper_len(side)];
        Ok(Self { levels, words: vec![0; Self::words_len(side)], upper })
    }

    /// An image from row-major bits: texel (x, y) is bit i mod 64 of word i / 64, i = y · side + x.
    ///
    /// That is how a face of a binary cube map is stored. Spare bits of the last word are ignored.
    ///
    /// # Errors
    /// As [`Self::zeros`]; [`Error::Length`] unless there are [`Self::words_len`] words.
    pub fn from_rows(side: usize, rows: &[u64]) -> Result<Self> {
        let mut pyramid = Self::zeros(side)?;
        if rows.len() != pyramid.words.len() {
            return Err(Error::Length { what: "words of bits", expected: pyramid.words.len(), got: rows.len() });
        }
        pyramid.fill_from_rows(rows);
        Ok(pyramid)
    }

    /// An image from bits in Morton order.
    ///
    /// # Errors
    /// As [`Self::from_rows`].
    pub fn from_morton(side: usize, words: &[u64]) -> Result<Self> {
        let mut pyramid = Self::zeros(side)?;
        if words.len() != pyramid.words.len() {
            return Err(Error::Length { what: "words of bits", expected: pyramid.words.len(), got: words.len() });
        }
        pyramid.fill_from_morton(words);
        Ok(pyramid)
    }

    /// Overwrites the image with row-major bits; allocates nothing.
    ///
    /// # Panics
    /// If the number of words is wrong.
    #[track_caller]
    pub fn fill_from_rows(&mut self, rows: &[u64]) {
        check_length("words of bits", self.words.len(), rows.len());
        Self::morton_from_rows(self.side(), rows, &mut self.words);
        self.count();
    }

    /// Overwrites the image with bits in Morton order; allocates nothing.
    ///
    /// # Panics
    /// If the number of words is wrong.
    #[track_caller]
    pub fn fill_from_morton(&mut self, words: &[u64]) {
        check_length("words of bits", self.words.len(), words.len());
        self.words.copy_from_slice(words);
        self.words[0] &= valid_bits(self.side());
        self.count();
    }

    /// Fills the table of means of Morton-ordered bits; for callers that keep many images in one buffer.
    ///
    /// # Panics
    /// If a length is not [`Self::words_len`] or [`Self::upper_len`].
    #[track_caller]
    pub fn upper_from_words(side: usize, words: &[u64], upper: &mut [[f32; 4]]) {
        check_length("words of bits", Self::words_len(side), words.len());
        check_length("table of means", Self::upper_len(side), upper.len());
        let texels = (side * side).min(64) as f32;
        let flat = upper.as_flattened_mut();
        let first = first_node(block_levels(side.ilog2()));
        flat[..3].fill(0.0);
        for (mean, word) in flat[first + 3..].iter_mut().zip(words) {
            *mean = word.count_ones() as f32 / texels;
        }
        for n in (0..first).rev() {
            let at = 4 * (n + 1);
            flat[n + 3] = 0.25 * (flat[at] + flat[at + 1] + flat[at + 2] + flat[at + 3]);
        }
    }

    /// Reorders row-major bits (as in a face of a binary cube map) to Morton order.
    ///
    /// # Panics
    /// If `side` is no power of two or a length is not [`Self::words_len`].
    #[track_caller]
    pub fn morton_from_rows(side: usize, rows: &[u64], words: &mut [u64]) {
        assert!(side.is_power_of_two(), "side {side} is no power of two");
        check_length("words of row-major bits", Self::words_len(side), rows.len());
        check_length("words of Morton bits", rows.len(), words.len());
        if side < 8 {
            words[0] = 0;
            for y in 0..side {
                for x in 0..side {
                    words[0] |= (rows[0] >> (y * side + x) & 1) << morton(x, y);
                }
            }
            return;
        }
        let blocks = side / 8;
        for by in 0..blocks {
            for bx in 0..blocks {
                let mut block = 0;
                for r in 0..8 {
                    let byte = (by * 8 + r) * blocks + bx;
                    block |= (rows[byte / 8] >> (8 * (byte % 8)) & 0xff) << (8 * r);
                }
                words[morton(bx, by)] = morton_block(block);
            }
        }
    }

    /// Rebuilds the table from the words.
    fn count(&mut self) {
        Self::upper_from_words(self.side(), &self.words, &mut self.upper);
    }

    /// The side of the image.
    #[inline]
    pub fn side(&self) -> usize {
        1 << self.levels
    }

    /// The bits in Morton order.
    #[inline]
    pub fn words(&self) -> &[u64] {
        &self.words
    }

    /// The table of means.
    #[inline]
    pub fn upper(&self) -> &[[f32; 4]] {
        &self.upper
    }

    /// A borrowed view of this image.
    #[inline]
    pub fn view(&self) -> BitPyramidRef<'_> {
        BitPyramidRef { levels: self.levels, words: &self.words, upper: &self.upper }
    }
}

impl<'a> BitPyramidRef<'a> {
    /// A view of words in Morton order and their table, as [`BitPyramid::words`] and [`BitPyramid::upper`] gave them.
    ///
    /// # Panics
    /// If `side` is no power of two or a length is not [`BitPyramid::words_len`] or [`BitPyramid::upper_len`].
    #[track_caller]
    #[inline]
    pub fn new(side: usize, words: &'a [u64], upper: &'a [[f32; 4]]) -> Self {
        assert!(side.is_power_of_two(), "side {side} is no power of two");
        check_length("words of bits", BitPyramid::words_len(side), words.len());
        check_length("table of means", BitPyramid::upper_len(side), upper.len());
        Self { levels: side.ilog2(), words, upper }
    }

    /// log₂ of the side.
    #[inline]
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// The bits in Morton order.
    #[inline]
    pub fn words(&self) -> &'a [u64] {
        self.words
    }

    /// The table of means.
    #[inline]
    pub fn upper(&self) -> &'a [[f32; 4]] {
        self.upper
    }

    /// The mean of the whole image.
    #[inline]
    pub fn mean(&self) -> f32 {
        self.upper[0][3]
    }

    /// How many words are not all zero, from the table (words of 64 texels are its last level).
    #[inline]
    pub(super) fn seen_words(&self) -> u64 {
        let flat = self.upper.as_flattened();
        flat[flat.len() - self.words.len()..].iter().map(|&mean| u32::from(mean > 0.0)).sum::<u32>().into()
    }

    /// The means of the four children of node `n`, numbered as in [`MeanTree`](super::MeanTree).
    ///
    /// Exact. Cost: a few instructions, no loop.
    ///
    /// # Panics
    /// If there is no such node.
    #[track_caller]
    #[inline]
    pub fn child_means<T: Real>(&self, n: usize) -> [T; 4] {
        let level = super::nodes::level_of(n as u32);
        assert!(level < self.levels, "node {n} is not above the texels");
        let m = n - first_node(level);
        match self.levels - level {
            1 => nibble_means(self.words, m),
            2 => short_means(self.words, m),
            3 => word_means(self.words, m),
            _ => self.upper[n + 1].map(|x| T::of(f64::from(x))),
        }
    }
}

/// The four bit fields of `mask[c]`, each times `scale[c]`: shifts by powers of two done in the scale, where a vector
/// can do them.
#[inline(always)]
fn fields<T: Real>(bits: u32, mask: [u32; 4], scale: [f64; 4]) -> [T; 4] {
    let bits = mask.map(|mask| (bits & mask) as i32);
    [
        T::of(f64::from(bits[0])) * T::of(scale[0]),
        T::of(f64::from(bits[1])) * T::of(scale[1]),
        T::of(f64::from(bits[2])) * T::of(scale[2]),
        T::of(f64::from(bits[3])) * T::of(scale[3]),
    ]
}

/// Means of the children of node m of the finest level: the four texels.
#[inline(always)]
pub(super) fn nibble_means<T: Real>(words: &[u64], m: usize) -> [T; 4] {
    let bits = (words[m >> 4] >> (4 * (m & 15))) as u32;
    fields(bits, [1, 2, 4, 8], [1.0, 0.5, 0.25, 0.125])
}

/// Means of the children of node m of the second finest level: nibbles.
#[inline(always)]
pub(super) fn short_means<T: Real>(words: &[u64], m: usize) -> [T; 4] {
    let x = (words[m >> 2] >> (16 * (m & 3))) as u32;
    let pairs = x - (x >> 1 & 0x5555_5555);
    let nibbles = (pairs & 0x3333_3333) + (pairs >> 2 & 0x3333_3333);
    fields(nibbles, [0xf, 0xf0, 0xf00, 0xf000], [0.25, 0.25 / 16.0, 0.25 / 256.0, 0.25 / 4096.0])
}

/// Means of the children of node m of the third finest level: quarters of a word.
#[inline(always)]
pub(super) fn word_means<T: Real>(words: &[u64], m: usize) -> [T; 4] {
    let x = words[m];
    let x = x - (x >> 1 & 0x5555_5555_5555_5555);
    let x = (x & 0x3333_3333_3333_3333) + (x >> 2 & 0x3333_3333_3333_3333);
    let x = (x + (x >> 4)) & 0x0f0f_0f0f_0f0f_0f0f;
    let x = x + (x >> 8);
    let quarters = [x & 31, x >> 16 & 31, x >> 32 & 31, x >> 48 & 31];
    quarters.map(|count| T::of(f64::from(count as i32)) * T::of(0.0625))
}

/// The bits of word 0 that are texels.
const fn valid_bits(side: usize) -> u64 {
    if side < 8 { (1 << (side * side)) - 1 } else { !0 }
}

/// An 8×8 block from row-major to Morton order.
///
/// A bit's place y₂y₁y₀x₂x₁x₀ becomes y₂x₂y₁x₁y₀x₀ by three exchanges of two digits of the place, each a delta swap.
#[inline]
fn morton_block(mut x: u64) -> u64 {
    // Places with digit i = 0 and digit j = 1 move up by 2^i − 2^j.
    for (shift, mask) in [(12, 0x0000_f0f0_0000_f0f0), (4, 0x00f0_00f0_00f0_00f0), (2, 0x0c0c_0c0c_0c0c_0c0c)] {
        let moved = (x >> shift ^ x) & mask;
        x ^= moved ^ moved << shift;
    }
    x
}
