//! Binary maps.

use std::ops::Range;

use super::bytes::{self, Reader};
use super::index::{MapIndex, check_changes, check_map_length, slice_ends};
use super::stats::RunStats;
use super::sums::Sample;
use crate::error::check_length;
use crate::{Real, Result};

/// Whether a map is constant: the cases of algorithm 1 [Inger 2013].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MapState {
    /// 0 everywhere: contributes nothing.
    AllZero,
    /// 1 everywhere: the product with a map is the product without it.
    AllOne,
    /// The map has both values.
    Mixed,
}

/// A binary map by the places where it changes, borrowed.
///
/// # Example
/// ```
/// use haarmonic::compress::{CodedBinaryMap, suffix_sums};
/// # fn main() -> Result<(), haarmonic::Error> {
/// let map = CodedBinaryMap::<u8>::new(&[1, 3], 4)?; // 0 1 1 0
/// let light = [1.0, 10.0, 100.0, 1000.0];
/// let mut sums = [0.0; 4];
/// suffix_sums(4, &light, &mut sums);
/// assert_eq!(map.dot(&sums), 110.0);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CodedBinaryMap<'a, I> {
    changes: &'a [I],
    len: usize,
}

impl<'a, I: MapIndex> CodedBinaryMap<'a, I> {
    /// A map of `len` pixels that starts as 0 and changes at `changes`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless `len` is positive and fits `I`, and the changes rise
    /// strictly and stay below it.
    pub fn new(changes: &'a [I], len: usize) -> Result<Self> {
        check_map_length::<I>(len)?;
        check_changes(changes, len)?;
        Ok(Self { changes, len })
    }

    /// Where the map changes, rising.
    #[inline]
    pub fn changes(self) -> &'a [I] {
        self.changes
    }

    /// The number of pixels.
    #[inline]
    #[expect(clippy::len_without_is_empty, reason = "a map is never empty")]
    pub fn len(self) -> usize {
        self.len
    }

    /// Whether the map is constant.
    #[inline]
    pub fn state(self) -> MapState {
        match self.changes {
            [] => MapState::AllZero,
            [first] if first.place() == 0 => MapState::AllOne,
            _ => MapState::Mixed,
        }
    }

    /// The pixel ranges where the map is 1, in order.
    #[inline]
    pub fn runs(self) -> Runs<'a, I> {
        Runs { changes: self.changes, len: self.len }
    }

    /// How many pixels are 1.
    pub fn count_ones(self) -> usize {
        self.runs().map(|run| run.len()).sum()
    }

    /// Σ V L from the [`suffix_sums`](crate::compress::suffix_sums) of L, without decoding.
    /// ```math
    /// Σ_i V_i L_i = L_int[c_0] − L_int[c_1] + L_int[c_2] − …                  [Inger 2013, eq. 5, 6]
    /// ```
    ///
    /// Accuracy: the error of each sum that is looked up; the differences are taken in `f64`. Cost: a look-up a change.
    /// NaN and infinite samples are in all sums that begin before them, whether the map keeps them or not; not so in
    /// [`masked_dot`](Self::masked_dot).
    ///
    /// # Panics
    /// If `sums.len()` is not the map's.
    #[inline]
    #[track_caller]
    pub fn dot<S: Sample>(self, sums: &[S]) -> S {
        check_length("suffix sums", self.len, sums.len());
        let (pairs, rest) = self.changes.as_chunks::<2>();
        let mut total = S::ZERO;
        for [on, off] in pairs {
            total = sums[on.place()].add(total, 1.0);
            total = sums[off.place()].add(total, -1.0);
        }
        if let [on] = rest {
            total = sums[on.place()].add(total, 1.0);
        }
        S::narrow(total, 1.0)
    }

    /// Σ V L ρ, by running along the runs (line 11 of algorithm 1 [Inger 2013]).
    ///
    /// # Panics
    /// If `light.len()` or `weights.len()` is not the map's.
    #[track_caller]
    pub fn masked_dot<S: Sample>(self, light: &[S], weights: &[S::Scalar]) -> S {
        check_length("light", self.len, light.len());
        check_length("weights", self.len, weights.len());
        let mut total = S::ZERO;
        for run in self.runs() {
            for (light, weight) in light[run.clone()].iter().zip(&weights[run]) {
                total = light.add(total, weight.widen());
            }
        }
        S::narrow(total, 1.0)
    }

    /// Writes the pixels of the map as 0 and 1.
    ///
    /// # Panics
    /// If `out.len()` is not the map's.
    #[track_caller]
    pub fn decode<T: Real>(self, out: &mut [T]) {
        check_length("decoded map", self.len, out.len());
        out.fill(T::zero());
        self.runs().for_each(|run| out[run].fill(T::one()));
    }

    /// Writes bits: pixel i is bit i mod 64 of word i / 64. The bits beyond the map are 0.
    ///
    /// # Panics
    /// If `out.len()` is not ⌈len/64⌉.
    #[track_caller]
    pub fn decode_bits(self, out: &mut [u64]) {
        check_length("words of a decoded map", self.len.div_ceil(64), out.len());
        out.fill(0);
        for change in self.changes {
            out[change.place() / 64] |= 1 << (change.place() % 64);
        }
        // A pixel is 1 after an odd number of changes: running parity, within words by doubling.
        let mut carry = 0;
        for word in out.iter_mut() {
            for shift in [1, 2, 4, 8, 16, 32] {
                *word ^= *word << shift;
            }
            *word ^= carry;
            carry = ((*word as i64) >> 63) as u64;
        }
        if self.len % 64 != 0
            && let Some(last) = out.last_mut()
        {
            *last &= (1 << (self.len % 64)) - 1;
        }
    }
}

/// The pixel ranges where a binary map is 1; made by [`CodedBinaryMap::runs`].
#[derive(Debug, Clone)]
pub struct Runs<'a, I> {
    changes: &'a [I],
    len: usize,
}

impl<I: MapIndex> Iterator for Runs<'_, I> {
    type Item = Range<usize>;

    #[inline]
    fn next(&mut self) -> Option<Range<usize>> {
        let (on, off) = match self.changes {
            [] => return None,
            [on] => (on, self.len),
            [on, off, ..] => (on, off.place()),
        };
        self.changes = self.changes.get(2..).unwrap_or(&[]);
        Some(on.place()..off)
    }

    #[inline]
    fn size_hint(&self) -> (usize, Option<usize>) {
        let count = self.changes.len().div_ceil(2);
        (count, Some(count))
    }
}

impl<I: MapIndex> ExactSizeIterator for Runs<'_, I> {}

/// Many binary maps of one length, coded: one array of changes, one of where each map's end.
///
/// Memory: `size_of::<I>()` bytes a change and 4 a map.
///
/// # Example
/// ```
/// use haarmonic::compress::{CodedBinaryMaps, MapState};
/// # fn main() -> Result<(), haarmonic::Error> {
/// let mut maps = CodedBinaryMaps::<u8>::new(256)?;
/// maps.push_bits(&[!0, !0, 0, 0]);
/// maps.push_bits(&[!0, !0, !0, !0]);
/// assert_eq!(maps.map(0).changes(), [0, 128]);
/// assert_eq!(maps.map(1).state(), MapState::AllOne);
/// let bytes = maps.to_bytes();
/// assert_eq!(CodedBinaryMaps::<u8>::from_bytes(&bytes)?, maps);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct CodedBinaryMaps<I> {
    map_len: usize,
    ends: Vec<u32>,
    changes: Vec<I>,
}

impl<I: MapIndex> CodedBinaryMaps<I> {
    /// No maps yet, of `map_len` pixels each.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless `map_len` is positive and its places fit `I`.
    pub fn new(map_len: usize) -> Result<Self> {
        check_map_length::<I>(map_len)?;
        Ok(Self { map_len, ends: Vec::new(), changes: Vec::new() })
    }

    /// The number of pixels of each map.
    #[inline]
    pub fn map_len(&self) -> usize {
        self.map_len
    }

    /// The number of maps.
    #[inline]
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there are no maps.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Map number `index`.
    ///
    /// # Panics
    /// If there are not so many.
    #[inline]
    #[track_caller]
    pub fn map(&self, index: usize) -> CodedBinaryMap<'_, I> {
        let end = self.ends[index] as usize;
        let start = if index == 0 { 0 } else { self.ends[index - 1] as usize };
        CodedBinaryMap { changes: &self.changes[start..end], len: self.map_len }
    }

    /// All maps, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = CodedBinaryMap<'_, I>> + '_ {
        (0..self.len()).map(|index| self.map(index))
    }

    /// Codes and appends a map of bits: pixel i is bit i mod 64 of word i / 64; the bits beyond the map are ignored.
    ///
    /// Cost: a few instructions a word and some more a change.
    ///
    /// # Panics
    /// If `words.len()` is not ⌈map_len/64⌉, or the changes of all maps reach 2³².
    #[track_caller]
    pub fn push_bits(&mut self, words: &[u64]) {
        check_length("words of a map", self.map_len.div_ceil(64), words.len());
        let mut carry = 0;
        for (i, &word) in words.iter().enumerate() {
            let mut change = word ^ (word << 1 | carry);
            carry = word >> 63;
            let beyond = (i + 1) * 64;
            if beyond > self.map_len {
                change &= !0 >> (beyond - self.map_len);
            }
            while change != 0 {
                self.changes.push(I::of(i * 64 + change.trailing_zeros() as usize));
                change &= change - 1;
            }
        }
        self.close();
    }

    /// Codes and appends a map of booleans.
    ///
    /// # Panics
    /// If `values.len()` is not the maps' length, or the changes of all maps reach 2³².
    #[track_caller]
    pub fn push_bools(&mut self, values: &[bool]) {
        check_length("values of a map", self.map_len, values.len());
        let mut state = false;
        for (place, &value) in values.iter().enumerate() {
            if value != state {
                self.changes.push(I::of(place));
                state = value;
            }
        }
        self.close();
    }

    /// Appends a coded map.
    ///
    /// # Panics
    /// If its length differs from the maps', or the changes of all maps reach 2³².
    #[track_caller]
    pub fn push(&mut self, map: CodedBinaryMap<'_, I>) {
        check_length("pixels of a map", self.map_len, map.len);
        self.changes.extend_from_slice(map.changes);
        self.close();
    }

    /// Changes of all maps.
    #[inline]
    pub fn total_changes(&self) -> usize {
        self.changes.len()
    }

    /// Copies a range of maps.
    ///
    /// # Panics
    /// If the range is not within the maps.
    #[track_caller]
    pub fn slice(&self, range: Range<usize>) -> Self {
        let (changes, ends) = slice_ends(&self.ends, range);
        Self { ends, changes: self.changes[changes].to_vec(), ..*self }
    }

    /// Appends the maps of another, such as one that another thread filled.
    ///
    /// # Panics
    /// As [`push`](Self::push).
    #[track_caller]
    pub fn append(&mut self, other: &Self) {
        check_length("pixels of a map", self.map_len, other.map_len);
        let start = self.changes.len();
        self.changes.extend_from_slice(&other.changes);
        self.fits();
        self.ends.extend(other.ends.iter().map(|&end| start as u32 + end));
    }

    #[track_caller]
    fn fits(&self) -> u32 {
        match u32::try_from(self.changes.len()) {
            Ok(end) => end,
            Err(_) => panic!("coded maps: {} changes do not fit 32 bits", self.changes.len()),
        }
    }

    #[track_caller]
    fn close(&mut self) {
        let end = self.fits();
        self.ends.push(end);
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.ends[..]) + size_of_val(&self.changes[..])
    }

    /// Counts and sizes.
    pub fn stats(&self) -> RunStats {
        let mut stats = RunStats::default();
        self.iter().for_each(|map| stats.count(map.changes.len(), map.state() == MapState::AllOne));
        stats.bytes_in_memory = self.bytes();
        stats.bytes_in_file = self.to_bytes().len();
        stats
    }

    /// The file form: header, then for each map the number of its changes and their gaps, all varints.
    ///
    /// Without a checksum: a damaged number that still makes a map is read as that map. Put it where the file has one.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = bytes::header(bytes::BINARY, self.map_len, self.len());
        for map in self.iter() {
            bytes::write_varint(map.changes.len() as u64, &mut out);
            bytes::encode_gaps(map.changes, &mut out);
        }
        out
    }

    /// Reads [`to_bytes`](Self::to_bytes).
    ///
    /// # Errors
    /// [`Error::Damaged`](crate::Error::Damaged) for bytes that `to_bytes` does not write: another kind or version, cut
    /// short, followed by more, numbers longer than they need be, changes beyond the map;
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) if the maps' length does not fit `I`.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let mut reader = Reader::new("coded binary maps", bytes);
        let (map_len, count) = reader.header(bytes::BINARY)?;
        let mut maps = Self::new(map_len)?;
        for _ in 0..count {
            let changes = reader.count(map_len)?;
            reader.gaps(changes, map_len, &mut maps.changes)?;
            let end = u32::try_from(maps.changes.len()).map_err(|_| reader.damaged("more than 2^32 changes"))?;
            maps.ends.push(end);
        }
        reader.finish()?;
        Ok(maps)
    }
}
