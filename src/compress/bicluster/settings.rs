//! How to bicluster.

use crate::{Error, Result};

/// Where each bicluster begins; the paper chooses at random.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Seeds {
    /// The first element that is left, rows before columns.
    #[default]
    First,
    /// Elements in an order shuffled by this seed; those that biclusters leave behind follow as in [`First`](Self::First).
    Random(u64),
}

/// Settings of [`Biclustering`](crate::compress::Biclustering).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct BiclusterSettings {
    /// Where biclusters begin.
    pub seeds: Seeds,
    /// Most rows of a group, default 4,096. Biclusters do not reach across groups, so that groups are independent work and time is linear in the
    /// rows.
    ///
    /// Too small and biclusters end at the border of their group: at 1,024 rows a product of the bunny's transfer matrix costs 8 % more than at
    /// 4,096, without groups 1 % less. Too large and there is less to do in parallel, and each step walks longer columns.
    pub group_rows: usize,
}

impl Default for BiclusterSettings {
    fn default() -> Self {
        Self { seeds: Seeds::default(), group_rows: 4096 }
    }
}

impl BiclusterSettings {
    /// The same with other seeds.
    #[must_use]
    pub fn with_seeds(self, seeds: Seeds) -> Self {
        Self { seeds, ..self }
    }

    /// The same with other groups; `usize::MAX` for a single one.
    #[must_use]
    pub fn with_group_rows(self, group_rows: usize) -> Self {
        Self { group_rows, ..self }
    }

    pub(super) fn check(&self) -> Result<()> {
        if self.group_rows == 0 {
            return Err(Error::OutOfRange { what: "rows of a group", got: 0.0, allowed: "at least 1" });
        }
        Ok(())
    }
}

/// A sequence of numbers without a pattern (SplitMix64): the same everywhere for the same seed.
pub(super) struct Shuffle(u64);

impl Shuffle {
    pub(super) fn new(seed: u64, stream: u64) -> Self {
        Self(seed ^ stream.wrapping_mul(0xd134_2543_de82_ef95))
    }

    /// A number below `limit` (which is at least 1); its bias, limit/2^64, does not matter here.
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((u128::from(z ^ (z >> 31)) * limit as u128) >> 64) as usize
    }

    pub(super) fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}
