//! What the products read of coded maps.

use std::ops::Range;

use super::light::Record;
use crate::compress::{BinaryMaps, GrayMaps, MapIndex, MapState};

/// Maps that a product runs through.
pub(super) trait Visible: Sync {
    /// Whether a map is constant.
    fn state(&self, map: usize) -> MapState;
    /// Adds Σ V L to `sum`, from suffix sums of L.
    fn add(&self, map: usize, sums: &[Record], sum: &mut Record);
    /// The index-th run of places of one level in [0, 1], in order; None after the last.
    // An index and not an iterator or a callback: what is inlined into neither is compiled without vectors.
    fn run(&self, map: usize, index: usize) -> Option<(Range<usize>, f32)>;
}

impl<I: MapIndex> Visible for BinaryMaps<I> {
    #[inline(always)]
    fn state(&self, map: usize) -> MapState {
        self.map(map).state()
    }

    #[inline(always)]
    fn add(&self, map: usize, sums: &[Record], sum: &mut Record) {
        let (pairs, rest) = self.map(map).changes().as_chunks::<2>();
        // A copy that stays in registers.
        let mut total = *sum;
        for [on, off] in pairs {
            let (on, off) = (&sums[on.place()], &sums[off.place()]);
            for k in 0..12 {
                total[k] += on[k] - off[k];
            }
        }
        if let [on] = rest {
            let on = &sums[on.place()];
            for k in 0..12 {
                total[k] += on[k];
            }
        }
        *sum = total;
    }

    #[inline(always)]
    fn run(&self, map: usize, index: usize) -> Option<(Range<usize>, f32)> {
        let map = self.map(map);
        let start = map.changes().get(2 * index)?.place();
        let end = map.changes().get(2 * index + 1).map_or(map.len(), |end| end.place());
        Some((start..end, 1.0))
    }
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
    fn run(&self, map: usize, index: usize) -> Option<(Range<usize>, f32)> {
        let map = self.map(map);
        let start = map.changes().get(index)?.place();
        let end = map.changes().get(index + 1).map_or(map.len(), |end| end.place());
        Some((start..end, f32::from(map.levels()[index]) / f32::from(map.top())))
    }
}
