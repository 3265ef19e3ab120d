//! How to bicluster.

use crate::{Error, Result};

/// Where each bicluster begins; the paper chooses at random.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Seeds {
    /// The first element that is left, rows before columns.
    #[default]
    First,
    /// Elements in an order shuffled by this seed; those that biclusters leave behind follow as in
    /// [`First`](Self::First).
    Random(u64),
}

/// Settings of [`Biclustering`](crate::compress::Biclustering).
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(try_from = "Unchecked"))]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct BiclusterSettings {
    /// Where biclusters begin.
    pub seeds: Seeds,
    /// Most rows of a group, default 4,096. Biclusters do not reach across groups, so that groups are independent work
    /// and time is linear in the rows.
    ///
    /// Too small and biclusters end at the border of their group: at 1,024 rows a product of the bunny's transfer
    /// matrix costs 8 % more than at 4,096, without groups 1 % less. Too large and there is less to do in parallel, and
    /// each step walks longer columns.
    pub group_rows: usize,
}

/// What stored settings say of themselves.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Unchecked {
    seeds: Seeds,
    group_rows: usize,
}

#[cfg(feature = "serde")]
impl TryFrom<Unchecked> for BiclusterSettings {
    type Error = Error;

    fn try_from(Unchecked { seeds, group_rows }: Unchecked) -> Result<Self> {
        let settings = Self { seeds, group_rows };
        settings.check().map(|()| settings)
    }
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
