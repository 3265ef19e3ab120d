//! What the products read of coded maps.

use super::suffix::{Lanes, MomentSums, MomentTable, NodeSums, Table};
use super::tiles::{TILE, TilePath};
use crate::compress::{CodedBinaryMaps, CodedGrayMaps, MapIndex, MapState};

/// Places of the largest block.
pub(super) const MOST_PLACES: usize = 32 * 32;

/// A bit for each tile of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct TileBits(u128);

impl TileBits {
    /// The first `count`.
    #[inline(always)]
    pub(super) fn all(count: usize) -> Self {
        Self(u128::MAX >> (128 - count))
    }

    /// Those whose entry is 1 and not 0; they are eight or a multiple of eight.
    #[inline(always)]
    pub(super) fn of(entries: &[u32]) -> Self {
        let mut bits = 0;
        for (k, eight) in entries.as_chunks::<8>().0.iter().enumerate() {
            let byte = (0..8).fold(0, |byte, lane| byte | eight[lane] << lane);
            bits |= u128::from(byte) << (8 * k);
        }
        Self(bits)
    }

    /// Those whose byte is not 0.
    #[inline(always)]
    fn of_bytes(words: &[u64]) -> Self {
        const LOW: u64 = 0x7f7f_7f7f_7f7f_7f7f;
        let mut bits = 0;
        for (k, &word) in words.iter().enumerate() {
            // The highest bit of each byte that is not 0; a product brings the eight together.
            let highest = (((word & LOW) + LOW) | word) & !LOW;
            bits |= u128::from((highest >> 7).wrapping_mul(0x0102_0408_1020_4080) >> 56) << (8 * k);
        }
        Self(bits)
    }

    #[inline(always)]
    pub(super) fn set(&mut self, tile: usize) {
        self.0 |= 1 << tile;
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
static LANES_OF: [[f32; TILE]; 256] = {
    let mut lanes = [[0.0; TILE]; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut bit = 0;
        while bit < TILE {
            lanes[byte][bit] = (byte >> bit & 1) as f32;
            bit += 1;
        }
        byte += 1;
    }
    lanes
};

/// Room for the visibility of a block.
#[derive(Debug, Clone)]
pub(super) struct Room {
    /// Slots of a block / 64.
    words: usize,
    bits: [u64; MOST_PLACES / 64],
    levels: Vec<[f32; TILE]>,
}

impl Room {
    pub(super) fn new(block_len: usize) -> Self {
        Self { words: block_len / 64, bits: [0; MOST_PLACES / 64], levels: vec![[0.0; TILE]; block_len / TILE] }
    }
}

/// Maps that a product runs through.
pub(super) trait Visible: Sync {
    /// A change of visibility.
    type Change: Copy + Send + Sync;
    /// Whether a map is constant.
    fn state(&self, map: usize) -> MapState;
    /// How often a map changes.
    fn count(&self, map: usize) -> usize;
    /// Appends the changes of a map.
    fn append_changes(&self, map: usize, to: &mut Vec<Self::Change>);
    /// Adds Σ V L of the map of some changes to `sum`, from suffix sums of L.
    fn add_changes<T: Table>(&self, changes: &[Self::Change], sums: T, sum: &mut T::Sum);
    /// Σ V L of a map, from suffix sums of L.
    fn sum(&self, map: usize, sums: &[NodeSums]) -> NodeSums;
    /// The same from suffix sums of L ω.
    fn moments(&self, map: usize, sums: MomentTable<'_, [Lanes], [f32]>) -> MomentSums;
    /// Puts the visibility of every slot into `room`; returns the tiles where some is visible.
    fn expand(&self, map: usize, path: &TilePath, room: &mut Room) -> TileBits;
    /// The visibility of a tile of the map that was expanded last.
    fn levels<'r>(&self, room: &'r Room, tile: usize) -> &'r [f32; TILE];
}

impl<I: MapIndex> Visible for CodedBinaryMaps<I> {
    type Change = I;

    #[inline(always)]
    fn state(&self, map: usize) -> MapState {
        self.map(map).state()
    }

    #[inline(always)]
    fn count(&self, map: usize) -> usize {
        self.map(map).changes().len()
    }

    fn append_changes(&self, map: usize, to: &mut Vec<I>) {
        to.extend_from_slice(self.map(map).changes());
    }

    #[inline(always)]
    fn add_changes<T: Table>(&self, changes: &[I], sums: T, sum: &mut T::Sum) {
        // A copy that stays in registers.
        let mut total = *sum;
        let (runs, rest) = changes.as_chunks::<2>();
        for &[on, off] in runs {
            sums.run(&mut total, on.place(), off.place());
        }
        if let &[on] = rest {
            sums.step(&mut total, on.place(), 1.0);
        }
        *sum = total;
    }

    #[inline(always)]
    fn sum(&self, map: usize, sums: &[NodeSums]) -> NodeSums {
        let (changes, mut sum) = (self.map(map).changes(), [0.0; 12]);
        // A table that is as long as an index can say needs no check of each look-up.
        match sums.first_chunk::<256>() {
            Some(sums) if I::LONGEST == 256 => self.add_changes(changes, sums, &mut sum),
            _ => self.add_changes(changes, sums, &mut sum),
        }
        sum
    }

    #[inline(always)]
    fn moments(&self, map: usize, sums: MomentTable<'_, [Lanes], [f32]>) -> MomentSums {
        let mut sum = MomentSums::default();
        self.add_changes(self.map(map).changes(), sums, &mut sum);
        sum
    }

    #[inline(always)]
    fn expand(&self, map: usize, path: &TilePath, room: &mut Room) -> TileBits {
        let changes = self.map(map).changes();
        if room.words == 4 {
            // 16² places: as many bits as a register holds.
            let (rows, mut bits) = (path.suffixes.as_chunks::<4>().0, [0; 4]);
            for change in changes {
                let row = &rows[change.place()];
                for k in 0..4 {
                    bits[k] ^= row[k];
                }
            }
            room.bits[..4].copy_from_slice(&bits);
        } else {
            room.bits.fill(0);
            for change in changes {
                let row = &path.suffixes[change.place() * room.words..][..room.words];
                room.bits.iter_mut().zip(row).for_each(|(bits, row)| *bits ^= row);
            }
        }
        TileBits::of_bytes(&room.bits[..room.words])
    }

    #[inline(always)]
    fn levels<'r>(&self, room: &'r Room, tile: usize) -> &'r [f32; TILE] {
        &LANES_OF[usize::from((room.bits[tile / 8] >> (tile % 8 * 8)) as u8)]
    }
}

/// Where a map of several levels changes, and by how many.
#[derive(Debug, Clone, Copy)]
pub(super) struct GrayChange<I> {
    place: I,
    difference: i16,
}

impl<I: MapIndex> Visible for CodedGrayMaps<I> {
    type Change = GrayChange<I>;

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
    fn count(&self, map: usize) -> usize {
        self.map(map).changes().len()
    }

    fn append_changes(&self, map: usize, to: &mut Vec<GrayChange<I>>) {
        let differences = self.map(map).differences();
        to.extend(differences.map(|(place, difference)| GrayChange { place: I::of(place), difference }));
    }

    #[inline(always)]
    fn add_changes<T: Table>(&self, changes: &[GrayChange<I>], sums: T, sum: &mut T::Sum) {
        let scale = 1.0 / f32::from(self.top());
        let mut total = *sum;
        for change in changes {
            sums.step(&mut total, change.place.place(), f32::from(change.difference) * scale);
        }
        *sum = total;
    }

    #[inline(always)]
    fn sum(&self, map: usize, sums: &[NodeSums]) -> NodeSums {
        let scale = 1.0 / f32::from(self.top());
        let mut total = [0.0; 12];
        for (place, difference) in self.map(map).differences() {
            sums.step(&mut total, place, f32::from(difference) * scale);
        }
        total
    }

    #[inline(always)]
    fn moments(&self, map: usize, sums: MomentTable<'_, [Lanes], [f32]>) -> MomentSums {
        let scale = 1.0 / f32::from(self.top());
        let mut total = MomentSums::default();
        for (place, difference) in self.map(map).differences() {
            sums.step(&mut total, place, f32::from(difference) * scale);
        }
        total
    }

    #[inline(always)]
    fn expand(&self, map: usize, path: &TilePath, room: &mut Room) -> TileBits {
        room.levels.fill([0.0; TILE]);
        let (map, slots) = (self.map(map), room.levels.as_flattened_mut());
        let top = f64::from(map.top());
        for (span, level) in map.spans() {
            let level = (f64::from(level) / top) as f32;
            path.slots[span].iter().for_each(|&slot| slots[slot as usize] = level);
        }
        let mut tiles = TileBits::default();
        for (g, levels) in room.levels.iter().enumerate() {
            if *levels != [0.0; TILE] {
                tiles.set(g);
            }
        }
        tiles
    }

    #[inline(always)]
    fn levels<'r>(&self, room: &'r Room, tile: usize) -> &'r [f32; TILE] {
        &room.levels[tile]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(mut bits: TileBits) -> Vec<usize> {
        std::iter::from_fn(|| bits.pop()).collect()
    }

    #[test]
    fn tiles_are_those_of_bytes_and_entries_that_are_not_0() {
        let words = [0x0100_0000_ff00_0080_u64, 0, !0, 0x0000_8000_0000_0001];
        let bytes = words.iter().flat_map(|word| word.to_le_bytes());
        let expected: Vec<usize> = bytes.enumerate().filter(|&(_, byte)| byte != 0).map(|(k, _)| k).collect();
        assert_eq!(taken(TileBits::of_bytes(&words)), expected);
        let mut entries = [0; 32];
        expected.iter().for_each(|&k| entries[k] = 1);
        assert_eq!(taken(TileBits::of(&entries)), expected);
        // The largest block has 128 tiles.
        assert_eq!(taken(TileBits::of_bytes(&[!0; 16])), (0..128).collect::<Vec<_>>());
        assert_eq!(taken(TileBits::of(&[1; 128]).and(TileBits::all(8))), (0..8).collect::<Vec<_>>());
    }
}
