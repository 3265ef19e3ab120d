//! What the products read of coded maps.

use super::light::Record;
use super::tables::GROUP;
use crate::compress::{BinaryMaps, GrayMaps, MapIndex, MapState};

/// Places of the largest block.
pub(super) const MOST_PLACES: usize = 32 * 32;

/// A bit for each group of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct GroupBits(u128);

impl GroupBits {
    /// The first `count`.
    #[inline(always)]
    pub(super) fn all(count: usize) -> Self {
        Self(u128::MAX >> (128 - count))
    }

    #[inline(always)]
    pub(super) fn set(&mut self, group: usize) {
        self.0 |= 1 << group;
    }

    #[inline(always)]
    pub(super) fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Takes the first off.
    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<usize> {
        let first = self.0.trailing_zeros() as usize;
        if self.0 == 0 {
            return None;
        }
        self.0 &= self.0 - 1;
        Some(first)
    }
}

/// The bits of a byte as numbers.
static LANES_OF: [[f32; GROUP]; 256] = {
    let mut lanes = [[0.0; GROUP]; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut bit = 0;
        while bit < GROUP {
            lanes[byte][bit] = (byte >> bit & 1) as f32;
            bit += 1;
        }
        byte += 1;
    }
    lanes
};

/// Maps that a product runs through.
pub(super) trait Visible: Sync {
    /// Whether a map is constant.
    fn state(&self, map: usize) -> MapState;
    /// Adds Σ V L to `sum`, from suffix sums of L.
    fn add(&self, map: usize, sums: &[Record], sum: &mut Record);
    /// Visibility of every place, eight on end a group; `levels` may hold anything where no place of a group is visible.
    ///
    /// Sets bit g of `groups` if a place of group g is visible.
    fn expand(&self, map: usize, levels: &mut [[f32; GROUP]], groups: &mut GroupBits);
}

impl<I: MapIndex> Visible for BinaryMaps<I> {
    #[inline(always)]
    fn state(&self, map: usize) -> MapState {
        self.map(map).state()
    }

    #[inline(always)]
    fn add(&self, map: usize, sums: &[Record], sum: &mut Record) {
        let changes = self.map(map).changes();
        // A table that is as long as an index can say needs no check of each look-up.
        match sums.first_chunk::<256>() {
            Some(sums) if I::LONGEST == 256 => {
                add_runs(changes, |change| &sums[usize::from(change.place() as u8)], sum)
            }
            _ => add_runs(changes, |change| &sums[change.place()], sum),
        }
    }

    #[inline(always)]
    fn expand(&self, map: usize, levels: &mut [[f32; GROUP]], groups: &mut GroupBits) {
        let mut words = [0_u64; MOST_PLACES / 64];
        let words = &mut words[..levels.len() * GROUP / 64];
        self.map(map).decode_bits(words);
        *groups = GroupBits::default();
        for (w, (&word, levels)) in words.iter().zip(levels.chunks_exact_mut(8)).enumerate() {
            for (k, (byte, levels)) in word.to_le_bytes().into_iter().zip(levels).enumerate() {
                if byte != 0 {
                    *levels = LANES_OF[usize::from(byte)];
                    groups.set(w * 8 + k);
                }
            }
        }
    }
}

/// Adds the sums where runs begin and takes those off where they end.
#[inline(always)]
fn add_runs<'a, I: MapIndex>(changes: &[I], at: impl Fn(I) -> &'a Record, sum: &mut Record) {
    let (pairs, rest) = changes.as_chunks::<2>();
    // A copy that stays in registers.
    let mut total = *sum;
    for &[on, off] in pairs {
        let (on, off) = (at(on), at(off));
        for k in 0..12 {
            total[k] += on[k] - off[k];
        }
    }
    if let &[on] = rest {
        let on = at(on);
        for k in 0..12 {
            total[k] += on[k];
        }
    }
    *sum = total;
}

impl<I: MapIndex> Visible for GrayMaps<I> {
    #[inline(always)]
    fn state(&self, map: usize) -> MapState {
        let map = self.map(map);
        match (map.changes(), map.levels()) {
            ([], _) => MapState::AllZero,
            ([first], &[level]) if first.place() == 0 && level == map.top() => MapState::AllOne,
            _ => MapState::Mixed,
        }
    }

    #[inline(always)]
    fn add(&self, map: usize, sums: &[Record], sum: &mut Record) {
        let map = self.map(map);
        let scale = 1.0 / f32::from(map.top());
        let (mut total, mut before) = (*sum, 0.0);
        for (change, &level) in map.changes().iter().zip(map.levels()) {
            let (level, sums) = (f32::from(level), &sums[change.place()]);
            let weight = (level - before) * scale;
            before = level;
            for k in 0..12 {
                total[k] += weight * sums[k];
            }
        }
        *sum = total;
    }

    #[inline(always)]
    fn expand(&self, map: usize, levels: &mut [[f32; GROUP]], groups: &mut GroupBits) {
        self.map(map).decode(levels.as_flattened_mut());
        *groups = GroupBits::default();
        for (g, levels) in levels.iter().enumerate() {
            if *levels != [0.0; GROUP] {
                groups.set(g);
            }
        }
    }
}
