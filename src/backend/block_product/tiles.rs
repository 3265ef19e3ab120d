//! The order in which pixels are summed up one by one.

use super::layout::BlockLayout;

/// Places that are taken or left together.
pub(super) const TILE: usize = 8;

/// N numbers of each pixel of a tile.
pub(super) type Eight<const N: usize> = [[f32; TILE]; N];

/// Pixels of a block in tiles of 4 × 2, which lie closer together than eight on end of a path.
///
/// The *slot* of a pixel is its number in that order.
#[derive(Debug, Clone)]
pub(super) struct Tiles {
    /// The row-major pixel of each slot.
    pixels: Vec<u32>,
    paths: [TilePath; 2],
}

/// Where the places of a path lie in tiles.
#[derive(Debug, Clone)]
pub(super) struct TilePath {
    /// The slot of each place.
    pub(super) slots: Vec<u32>,
    /// [place][word]: a bit for the slot of each place from there on. A binary map is the exclusive or of those where
    /// it changes.
    pub(super) suffixes: Vec<u64>,
}

impl Tiles {
    pub(super) fn new(layout: &BlockLayout) -> Self {
        let (side, len) = (layout.side(), layout.block_len());
        let pixels: Vec<u32> = (0..len)
            .map(|slot| {
                let (tile, x, y) = (slot / TILE, slot % 4, slot % TILE / 4);
                let (across, down) = (tile % (side / 4), tile / (side / 4));
                ((2 * down + y) * side + 4 * across + x) as u32
            })
            .collect();
        let mut slot_of = vec![0; len];
        pixels.iter().enumerate().for_each(|(slot, &pixel)| slot_of[pixel as usize] = slot as u32);
        let path = |scan: &crate::compress::Scan| {
            let slots: Vec<u32> = scan.pixels().iter().map(|&pixel| slot_of[pixel as usize]).collect();
            let words = len / 64;
            let mut suffixes = vec![0; len * words];
            let mut bits = vec![0; words];
            for (place, &slot) in slots.iter().enumerate().rev() {
                bits[slot as usize / 64] |= 1 << (slot % 64);
                suffixes[place * words..][..words].copy_from_slice(&bits);
            }
            TilePath { slots, suffixes }
        };
        Self { pixels, paths: layout.scans().each_ref().map(path) }
    }

    /// The row-major pixel of each slot.
    pub(super) fn pixels(&self) -> &[u32] {
        &self.pixels
    }

    #[inline(always)]
    pub(super) fn path(&self, turned: bool) -> &TilePath {
        &self.paths[usize::from(turned)]
    }
}
