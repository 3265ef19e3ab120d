//! Maps of several levels.

use std::ops::Range;

use super::bytes::{self, Reader};
use super::index::{MapIndex, check_changes, check_map_length, slice_ends};
use super::stats::RunStats;
use super::sums::Sample;
use crate::error::check_length;
use crate::{Error, Real, Result};

/// A quantised map by the places where it changes and the levels it changes to, borrowed.
/// ```math
/// V = level / top, level 0 before the first change
/// ```
///
/// The *new level* is stored rather than the difference [Inger 2013, §4.2]: differences of 8-bit levels need 9 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CodedGrayMap<'a, I> {
    changes: &'a [I],
    levels: &'a [u8],
    len: usize,
    top: u8,
}

impl<'a, I: MapIndex> CodedGrayMap<'a, I> {
    /// Where the map changes, rising.
    #[inline]
    pub fn changes(self) -> &'a [I] {
        self.changes
    }

    /// The level from each change on.
    #[inline]
    pub fn levels(self) -> &'a [u8] {
        self.levels
    }

    /// The number of pixels.
    #[inline]
    #[expect(clippy::len_without_is_empty, reason = "a map is never empty")]
    pub fn len(self) -> usize {
        self.len
    }

    /// The level that stands for 1.
    #[inline]
    pub fn top(self) -> u8 {
        self.top
    }

    /// V_d, the differences that are not 0: (place, level − level before).
    pub fn differences(self) -> impl ExactSizeIterator<Item = (usize, i16)> + 'a {
        let mut before = 0;
        self.changes.iter().zip(self.levels).map(move |(change, &level)| {
            let difference = i16::from(level) - i16::from(before);
            before = level;
            (change.place(), difference)
        })
    }

    /// The ranges where the level is not 0, and their levels, in order.
    #[inline]
    pub fn spans(self) -> GraySpans<'a, I> {
        GraySpans { map: self }
    }

    /// Σ V L from the [`suffix_sums`](crate::compress::suffix_sums) of L, without decoding.
    /// ```math
    /// Σ_i V_i L_i = Σ_d V_d L_int[c_d]                                         [Inger 2013, eq. 5, 6]
    /// ```
    ///
    /// Accuracy: as [`CodedBinaryMap::dot`](crate::compress::CodedBinaryMap::dot), times the differences. Cost: a
    /// look-up a change.
    ///
    /// # Panics
    /// If `sums.len()` is not the map's.
    #[inline]
    #[track_caller]
    pub fn dot<S: Sample>(self, sums: &[S]) -> S {
        check_length("suffix sums", self.len, sums.len());
        let (mut total, mut before) = (S::ZERO, 0);
        for (change, &level) in self.changes.iter().zip(self.levels) {
            total = sums[change.place()].add(total, f64::from(i32::from(level) - before));
            before = i32::from(level);
        }
        S::narrow(total, 1.0 / f64::from(self.top))
    }

    /// Σ V L ρ, by running along the spans.
    ///
    /// # Panics
    /// If `light.len()` or `weights.len()` is not the map's.
    #[track_caller]
    pub fn masked_dot<S: Sample>(self, light: &[S], weights: &[S::Scalar]) -> S {
        check_length("light", self.len, light.len());
        check_length("weights", self.len, weights.len());
        let mut total = S::ZERO;
        for (span, level) in self.spans() {
            let level = f64::from(level);
            for (light, weight) in light[span.clone()].iter().zip(&weights[span]) {
                total = light.add(total, level * weight.widen());
            }
        }
        S::narrow(total, 1.0 / f64::from(self.top))
    }

    /// Writes the pixels of the map as V, between 0 and 1.
    ///
    /// # Panics
    /// If `out.len()` is not the map's.
    #[track_caller]
    pub fn decode<T: Real>(self, out: &mut [T]) {
        check_length("decoded map", self.len, out.len());
        out.fill(T::zero());
        let top = f64::from(self.top);
        self.spans().for_each(|(span, level)| out[span].fill(T::of(f64::from(level) / top)));
    }

    /// Writes the pixels of the map as levels.
    ///
    /// # Panics
    /// If `out.len()` is not the map's.
    #[track_caller]
    pub fn decode_levels(self, out: &mut [u8]) {
        check_length("decoded map", self.len, out.len());
        out.fill(0);
        self.spans().for_each(|(span, level)| out[span].fill(level));
    }
}

/// The ranges where a gray map is not 0, and their levels; made by [`CodedGrayMap::spans`].
#[derive(Debug, Clone)]
pub struct GraySpans<'a, I> {
    map: CodedGrayMap<'a, I>,
}

impl<I: MapIndex> Iterator for GraySpans<'_, I> {
    type Item = (Range<usize>, u8);

    #[inline]
    fn next(&mut self) -> Option<(Range<usize>, u8)> {
        let map = &mut self.map;
        while let ([start, changes @ ..], [level, levels @ ..]) = (map.changes, map.levels) {
            (map.changes, map.levels) = (changes, levels);
            if *level != 0 {
                let end = changes.first().map_or(map.len, |end| end.place());
                return Some((start.place()..end, *level));
            }
        }
        None
    }
}

/// Many gray maps of one length, coded: one array of changes, one of levels, one of where each map's end.
///
/// Quantise the *map* and then take differences, as this does: quantised differences would add up to a drift.
/// Memory: `size_of::<I>()` + 1 bytes a change and 4 a map.
///
/// # Example
/// ```
/// use haarmonic::compress::CodedGrayMaps;
/// # fn main() -> Result<(), haarmonic::Error> {
/// let mut maps = CodedGrayMaps::<u8>::with_bits(4, 2)?; // V = 0, 1/3, 2/3, 1
/// maps.push_values(&[0.0, 0.3, 0.35, 1.0]);
/// assert_eq!(maps.map(0).differences().collect::<Vec<_>>(), [(1, 1), (3, 2)]);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct CodedGrayMaps<I> {
    map_len: usize,
    top: u8,
    ends: Vec<u32>,
    changes: Vec<I>,
    levels: Vec<u8>,
}

impl<I: MapIndex> CodedGrayMaps<I> {
    /// No maps yet, of `map_len` pixels each, with V = level/top for the levels 0…`top`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless `map_len` is positive and its places fit `I`, and `top` is positive.
    pub fn new(map_len: usize, top: u8) -> Result<Self> {
        check_map_length::<I>(map_len)?;
        if top == 0 {
            return Err(Error::OutOfRange { what: "top level of gray maps", got: 0.0, allowed: "from 1 to 255" });
        }
        Ok(Self { map_len, top, ends: Vec::new(), changes: Vec::new(), levels: Vec::new() })
    }

    /// The same with all levels of `bits` bits: `top` = 2^bits − 1. Six bits do for anti-aliased shadows [Inger 2013].
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless `bits` is from 1 to 8, or as [`new`](Self::new).
    pub fn with_bits(map_len: usize, bits: u32) -> Result<Self> {
        if !(1..=8).contains(&bits) {
            let got = f64::from(bits);
            return Err(Error::OutOfRange { what: "bits of gray maps", got, allowed: "from 1 to 8" });
        }
        Self::new(map_len, ((1u32 << bits) - 1) as u8)
    }

    /// The number of pixels of each map.
    #[inline]
    pub fn map_len(&self) -> usize {
        self.map_len
    }

    /// The level that stands for 1.
    #[inline]
    pub fn top(&self) -> u8 {
        self.top
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
    pub fn map(&self, index: usize) -> CodedGrayMap<'_, I> {
        let end = self.ends[index] as usize;
        let start = if index == 0 { 0 } else { self.ends[index - 1] as usize };
        let (changes, levels) = (&self.changes[start..end], &self.levels[start..end]);
        CodedGrayMap { changes, levels, len: self.map_len, top: self.top }
    }

    /// All maps, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = CodedGrayMap<'_, I>> + '_ {
        (0..self.len()).map(|index| self.map(index))
    }

    /// Rounds each value to the nearest level and appends the map. Values are clamped to [0, 1]; NaN counts as 0.
    ///
    /// Accuracy: V to 1/(2·top).
    ///
    /// # Panics
    /// If `values.len()` is not the maps' length, or the changes of all maps reach 2³².
    #[track_caller]
    pub fn push_values<T: Real>(&mut self, values: &[T]) {
        check_length("values of a map", self.map_len, values.len());
        // A cast to integer saturates and takes NaN to 0.
        let top = f64::from(self.top);
        self.push_each(values.iter().map(|v| (v.widen().clamp(0.0, 1.0) * top).round() as u8));
    }

    /// Appends a map of levels.
    ///
    /// # Panics
    /// If a level is above [`top`](Self::top), or as [`push_values`](Self::push_values).
    #[track_caller]
    pub fn push_levels(&mut self, levels: &[u8]) {
        check_length("levels of a map", self.map_len, levels.len());
        if let Some(&level) = levels.iter().find(|&&level| level > self.top) {
            panic!("level of a gray map: {level} is above the top level {}", self.top);
        }
        self.push_each(levels.iter().copied());
    }

    #[track_caller]
    fn push_each(&mut self, levels: impl Iterator<Item = u8>) {
        let mut before = 0;
        for (place, level) in levels.enumerate() {
            if level != before {
                self.changes.push(I::of(place));
                self.levels.push(level);
                before = level;
            }
        }
        let end = self.fits();
        self.ends.push(end);
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
        let levels = self.levels[changes.clone()].to_vec();
        Self { ends, levels, changes: self.changes[changes].to_vec(), ..*self }
    }

    /// Appends the maps of another, such as one that another thread filled.
    ///
    /// # Panics
    /// If the lengths or top levels differ, or the changes of all maps reach 2³².
    #[track_caller]
    pub fn append(&mut self, other: &Self) {
        check_length("pixels of a map", self.map_len, other.map_len);
        check_length("top level of a map", self.top.into(), other.top.into());
        let start = self.changes.len();
        self.changes.extend_from_slice(&other.changes);
        self.levels.extend_from_slice(&other.levels);
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

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.ends[..]) + size_of_val(&self.changes[..]) + size_of_val(&self.levels[..])
    }

    /// Counts and sizes.
    pub fn stats(&self) -> RunStats {
        let mut stats = RunStats::default();
        for map in self.iter() {
            let all_one =
                matches!((map.changes, map.levels), ([first], &[level]) if first.place() == 0 && level == self.top);
            stats.count(map.changes.len(), all_one);
        }
        stats.bytes_in_memory = self.bytes();
        stats.bytes_in_file = self.to_bytes().len();
        stats
    }

    /// The file form, as [`CodedBinaryMaps::to_bytes`](crate::compress::CodedBinaryMaps::to_bytes), with a byte for
    /// each new level.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = bytes::header(bytes::GRAY, self.map_len, self.len());
        out.push(self.top);
        for map in self.iter() {
            bytes::write_varint(map.changes.len() as u64, &mut out);
            bytes::encode_gaps(map.changes, &mut out);
            out.extend_from_slice(map.levels);
        }
        out
    }

    /// Reads [`to_bytes`](Self::to_bytes).
    ///
    /// # Errors
    /// As [`CodedBinaryMaps::from_bytes`](crate::compress::CodedBinaryMaps::from_bytes); [`Error::Damaged`] for a level
    /// above the top or equal to the one before it, too.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let mut reader = Reader::new("coded gray maps", bytes);
        let (map_len, count) = reader.header(bytes::GRAY)?;
        let mut maps = Self::new(map_len, reader.byte()?)?;
        for _ in 0..count {
            let changes = reader.count(map_len)?;
            reader.gaps(changes, map_len, &mut maps.changes)?;
            let mut before = 0;
            for &level in reader.take(changes)? {
                if level == before || level > maps.top {
                    return Err(reader.damaged("a level that is none"));
                }
                before = level;
                maps.levels.push(level);
            }
            let end = u32::try_from(maps.changes.len()).map_err(|_| reader.damaged("more than 2^32 changes"))?;
            maps.ends.push(end);
        }
        reader.finish()?;
        debug_assert!(maps.iter().all(|map| check_changes(map.changes, map_len).is_ok()));
        Ok(maps)
    }
}
