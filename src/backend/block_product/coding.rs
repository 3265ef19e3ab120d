//! Visibility of one vertex, block after block, as coded maps.

use std::ops::Range;

use nalgebra::Vector3;

use super::layout::BlockLayout;
use super::paths::Paths;
use crate::compress::{CodedBinaryMaps, CodedGrayMaps, MapIndex};
use crate::scene::BinaryVisibility;
use crate::{Error, Result};

/// What coded maps of both kinds do.
pub(super) trait Coded: Sized + Send + Sync {
    /// No maps, of `len` pixels and levels up to `top`.
    fn empty(len: usize, top: u8) -> Result<Self>;
    /// Reads [`section`](Self::section).
    fn parse(bytes: &[u8]) -> Result<Self>;
    /// A range of maps in the file form.
    fn section(&self, range: Range<usize>) -> Vec<u8>;
    /// Pixels of a map, top level, number of maps.
    fn shape(&self) -> (usize, u8, usize);
    /// Appends maps of the same shape.
    fn join(&mut self, other: &Self) -> Result<()>;
}

macro_rules! coded {
    ($maps:ident, $empty:expr, $top:expr) => {
        impl<I: MapIndex> Coded for $maps<I> {
            fn empty(len: usize, top: u8) -> Result<Self> {
                let empty: fn(usize, u8) -> Result<Self> = $empty;
                empty(len, top)
            }
            fn parse(bytes: &[u8]) -> Result<Self> {
                Self::from_bytes(bytes)
            }
            fn section(&self, range: Range<usize>) -> Vec<u8> {
                self.slice(range).to_bytes()
            }
            fn shape(&self) -> (usize, u8, usize) {
                let top: fn(&Self) -> u8 = $top;
                (self.map_len(), top(self), self.len())
            }
            fn join(&mut self, other: &Self) -> Result<()> {
                let changes = self.total_changes() + other.total_changes();
                if changes > u32::MAX as usize {
                    let what = "changes of all visibility maps";
                    return Err(Error::OutOfRange { what, got: changes as f64, allowed: "below 2^32" });
                }
                self.append(other);
                Ok(())
            }
        }
    };
}
coded!(CodedBinaryMaps, |len, _| Self::new(len), |_| 1);
coded!(CodedGrayMaps, Self::new, |maps| maps.top());

/// Maps of vertices and the paths that they take.
#[derive(Debug)]
pub(super) struct Pathed<M> {
    pub(super) maps: M,
    pub(super) paths: Paths,
}

impl<M: Coded> Pathed<M> {
    /// Of no vertices.
    pub(super) fn empty(len: usize, top: u8) -> Result<Self> {
        Ok(Self { maps: M::empty(len, top)?, paths: Paths::default() })
    }

    /// Appends vertices.
    pub(super) fn join(&mut self, other: &Self) -> Result<()> {
        self.paths.append(&other.paths);
        self.maps.join(&other.maps)
    }
}

/// Cuts packed faces into blocks along their paths.
#[derive(Debug, Clone)]
pub(super) struct BitCutter {
    layout: BlockLayout,
    rows: Vec<u64>,
    along: [Vec<u64>; 2],
}

impl BitCutter {
    pub(super) fn new(layout: &BlockLayout) -> Self {
        let words = layout.block_len() / 64;
        Self { layout: layout.clone(), rows: vec![0; words], along: [vec![0; words], vec![0; words]] }
    }

    /// Appends the blocks of a vertex; `words` as [`BinaryVisibility::vertex`] has them.
    pub(super) fn code<I: MapIndex>(&mut self, words: &[u64], to: &mut Pathed<CodedBinaryMaps<I>>) {
        let (side, along) = (self.layout.side(), self.layout.grid().side() / self.layout.side());
        let mask = u64::MAX >> (64 - side);
        to.paths.push_vertex(self.layout.blocks());
        for (f, face) in words.chunks_exact(BinaryVisibility::words_per_face(self.layout.grid())).enumerate() {
            for block in 0..along * along {
                self.rows.fill(0);
                for y in 0..side {
                    // Block sides divide 64 and the grid's side, so that a row of a block lies in one word.
                    let from = (block / along * side + y) * along * side + block % along * side;
                    let at = y * side;
                    self.rows[at / 64] |= (face[from / 64] >> (from % 64) & mask) << (at % 64);
                }
                self.push(f * along * along + block, to);
            }
        }
    }

    /// Appends the block of the rows along the path with fewer changes.
    fn push<I: MapIndex>(&mut self, block: usize, to: &mut Pathed<CodedBinaryMaps<I>>) {
        if self.rows.iter().all(|&w| w == 0) || self.rows.iter().all(|&w| w == u64::MAX) {
            return to.maps.push_bits(&self.rows);
        }
        for (scan, along) in self.layout.scans().iter().zip(&mut self.along) {
            scan.apply_bits(&self.rows, along);
        }
        let [first, turned] = self.along.each_ref().map(|along| bit_changes(along));
        if turned < first {
            to.paths.turn_last(block, self.layout.blocks());
        }
        to.maps.push_bits(&self.along[usize::from(turned < first)]);
    }
}

/// How often bits change along a path that starts with 0.
fn bit_changes(words: &[u64]) -> u32 {
    let mut carry = 0;
    let mut changes = 0;
    for &word in words {
        changes += (word ^ (word << 1 | carry)).count_ones();
        carry = word >> 63;
    }
    changes
}

/// Quantises shares of visible samples and cuts them into blocks.
#[derive(Debug, Clone)]
pub(super) struct GrayCutter {
    layout: BlockLayout,
    directions: Vec<Vector3<f64>>,
    /// Level of each count.
    levels: Vec<u8>,
    rows: Vec<u8>,
    along: [Vec<u8>; 2],
}

impl GrayCutter {
    /// For counts of up to `samples`².
    pub(super) fn new(layout: &BlockLayout, samples: usize, top: u8) -> Self {
        let most = samples * samples;
        let level = |count: usize| (count as f64 * f64::from(top) / most as f64).round() as u8;
        Self {
            directions: layout.grid().directions().into_iter().map(|d| d.into_inner()).collect(),
            levels: (0..=most).map(level).collect(),
            rows: vec![0; layout.block_len()],
            along: [vec![0; layout.block_len()], vec![0; layout.block_len()]],
            layout: layout.clone(),
        }
    }

    /// Appends the blocks of a vertex. A texel whose centre is below the horizon reflects nothing and counts as hidden.
    pub(super) fn code<I: MapIndex>(
        &mut self,
        counts: &[u8],
        normal: &Vector3<f32>,
        to: &mut Pathed<CodedGrayMaps<I>>,
    ) {
        let normal = normal.cast::<f64>();
        let blocks = self.layout.blocks();
        to.paths.push_vertex(blocks);
        for block in 0..blocks {
            for (pixel, level) in self.rows.iter_mut().enumerate() {
                let texel = self.layout.texel(block, pixel);
                let above = counts[texel] != 0 && normal.dot(&self.directions[texel]) > 0.0;
                *level = if above { self.levels[usize::from(counts[texel])] } else { 0 };
            }
            for (scan, along) in self.layout.scans().iter().zip(&mut self.along) {
                scan.apply(&self.rows, along);
            }
            let [first, turned] = self.along.each_ref().map(|along| level_changes(along));
            if turned < first {
                to.paths.turn_last(block, blocks);
            }
            to.maps.push_levels(&self.along[usize::from(turned < first)]);
        }
    }
}

/// How often levels change along a path that starts with 0.
fn level_changes(levels: &[u8]) -> usize {
    usize::from(levels[0] != 0) + levels.windows(2).filter(|pair| pair[0] != pair[1]).count()
}

/// Adds up the bits of a finer face: counts of the `samples`² rays of each texel of a face of `side`².
pub(super) fn count_samples(words: &[u64], side: usize, samples: usize, counts: &mut [u8]) {
    let fine = side * samples;
    for (y, row) in counts.chunks_exact_mut(side).enumerate() {
        for (x, count) in row.iter_mut().enumerate() {
            let bit = |at: usize| (words[at / 64] >> (at % 64) & 1) as u8;
            *count = (0..samples)
                .flat_map(|v| (0..samples).map(move |u| (y * samples + v) * fine + x * samples + u))
                .map(bit)
                .sum();
        }
    }
}
