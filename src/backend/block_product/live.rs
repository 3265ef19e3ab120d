//! Which blocks a vertex sees.

use super::paths::Paths;
use super::visible::Visible;
use crate::compress::MapState;

/// A block that is not hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Live {
    pub(super) block: u32,
    /// The block along the path that its map takes.
    pub(super) course: u32,
    /// Whether all of it is visible.
    pub(super) free: bool,
}

/// The blocks of every vertex that are not hidden, three bits a block.
#[derive(Debug, Clone)]
pub(super) struct LiveBlocks {
    blocks: usize,
    /// Words of 64 blocks a vertex.
    words: usize,
    /// [vertex][word]: whether some of a block is visible, whether all of it is, whether its path is turned.
    bits: Vec<[u64; 3]>,
}

impl LiveBlocks {
    /// Of maps [vertex][block].
    pub(super) fn new<V: Visible>(maps: &V, paths: &Paths, blocks: usize) -> Self {
        let words = Paths::words(blocks);
        let mut bits: Vec<[u64; 3]> = paths.turned().iter().map(|&turned| [0, 0, turned]).collect();
        for (vertex, bits) in bits.chunks_exact_mut(words).enumerate() {
            for block in 0..blocks {
                let state = maps.state(vertex * blocks + block);
                let [some, all, _] = &mut bits[block / 64];
                *some |= u64::from(state != MapState::AllZero) << (block % 64);
                *all |= u64::from(state == MapState::AllOne) << (block % 64);
            }
        }
        Self { blocks, words, bits }
    }

    /// Bytes in memory.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.bits[..])
    }

    /// Lists those of a vertex in order, of the blocks whose bit is set in `among`.
    #[inline]
    pub(super) fn list(&self, vertex: usize, among: &[u64], list: &mut Vec<Live>) {
        list.clear();
        let words = self.bits[vertex * self.words..][..self.words].iter().zip(among);
        for (word, (&[some, all, turned], among)) in words.enumerate() {
            let mut some = some & among;
            while some != 0 {
                let bit = some.trailing_zeros();
                some &= some - 1;
                let block = word as u32 * 64 + bit;
                let course = block + (turned >> bit & 1) as u32 * self.blocks as u32;
                list.push(Live { block, course, free: all >> bit & 1 != 0 });
            }
        }
    }
}
