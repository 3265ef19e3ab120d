//! Which blocks a vertex sees.

use super::visible::Visible;
use crate::compress::MapState;

/// A block that is not hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Live {
    pub(super) block: u32,
    /// Whether all of it is visible.
    pub(super) free: bool,
}

/// The blocks of every vertex that are not hidden, two bits a block.
#[derive(Debug, Clone)]
pub(super) struct LiveBlocks {
    /// Words of 64 blocks a vertex.
    words: usize,
    /// [vertex][word]: whether some of a block is visible, and whether all of it is.
    bits: Vec<[u64; 2]>,
}

impl LiveBlocks {
    /// Of maps [vertex][block].
    pub(super) fn new<V: Visible>(maps: &V, vertices: usize, blocks: usize) -> Self {
        let words = blocks.div_ceil(64);
        let mut bits = vec![[0; 2]; vertices * words];
        for (vertex, bits) in bits.chunks_exact_mut(words).enumerate() {
            for block in 0..blocks {
                let state = maps.state(vertex * blocks + block);
                let [some, all] = &mut bits[block / 64];
                *some |= u64::from(state != MapState::AllZero) << (block % 64);
                *all |= u64::from(state == MapState::AllOne) << (block % 64);
            }
        }
        Self { words, bits }
    }

    /// Bytes in memory.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.bits[..])
    }

    /// Lists those of a vertex in order.
    #[inline]
    pub(super) fn list(&self, vertex: usize, list: &mut Vec<Live>) {
        list.clear();
        for (word, &[mut some, all]) in self.bits[vertex * self.words..][..self.words].iter().enumerate() {
            while some != 0 {
                let bit = some.trailing_zeros();
                some &= some - 1;
                list.push(Live { block: word as u32 * 64 + bit, free: all >> bit & 1 != 0 });
            }
        }
    }
}
