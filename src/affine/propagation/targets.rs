//! Which coefficients of the transformed image are wanted.

use crate::haar::Decomposition;
use crate::{Error, Result};

/// The target coefficients of a propagation: all, or a list.
///
/// # Example
/// ```
/// use haarmonic::affine::Targets;
/// use haarmonic::haar::Decomposition;
/// let few = Targets::new(32, Decomposition::Standard, &[0, 1, 32, 33])?;
/// assert_eq!(few.len(), 4);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Targets {
    pub(super) side: usize,
    pub(super) decomposition: Decomposition,
    pub(super) chosen: Option<Chosen>,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Chosen {
    /// Flat indices, strictly ascending.
    pub(super) index: Vec<u32>,
    /// Standard basis: (k_y, end of its targets in `index`), for the rows that have any.
    pub(super) rows: Vec<(u32, u32)>,
    /// Nonstandard basis: place in `index` + 1 of each flat index, 0 where it is not wanted.
    pub(super) place: Vec<u32>,
    /// Standard basis: how many rows are computed whole, and how many targets alone.
    pub(super) whole_rows: usize,
    pub(super) alone: usize,
}

/// Whether the wanted targets of a row are computed one by one.
#[inline(always)]
pub(super) fn is_sparse_row(side: usize, wanted: usize) -> bool {
    wanted * SINGLE < side || side < BLOCK
}

/// Of a row with fewer than a SINGLE-th of its targets wanted, each is computed alone.
const SINGLE: usize = 10;
/// Columns at a time otherwise.
pub(super) const BLOCK: usize = 32;

impl Targets {
    /// All coefficients of `side`² images, in flat order.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `side` is one; [`Error::OutOfRange`] above 4096.
    pub fn all(side: usize, decomposition: Decomposition) -> Result<Self> {
        super::check_side(side)?;
        Ok(Self { side, decomposition, chosen: None })
    }

    /// The coefficients of the given flat indices, in that order.
    ///
    /// # Errors
    /// As [`all`](Self::all); [`Error::OutOfRange`] unless the indices ascend strictly and are below `side`².
    pub fn new(side: usize, decomposition: Decomposition, indices: &[u32]) -> Result<Self> {
        let mut targets = Self::all(side, decomposition)?;
        targets.set(indices)?;
        Ok(targets)
    }

    /// Wants other coefficients of the same images, as [`new`](Self::new), in the memory that is there: it grows to the
    /// longest list so far (nonstandard basis: and a number a pixel), then nothing is allocated.
    ///
    /// Cost: proportional to the lists, the one before and this one.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the indices ascend strictly and are below `side`²; the list before stays, then.
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::Targets;
    /// use haarmonic::haar::Decomposition::Standard;
    /// let mut targets = Targets::new(32, Standard, &[0, 1, 32, 33])?;
    /// targets.set(&[0, 7])?;
    /// assert_eq!(targets, Targets::new(32, Standard, &[0, 7])?);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn set(&mut self, indices: &[u32]) -> Result<()> {
        self.check(indices)?;
        self.set_checked(indices);
        Ok(())
    }

    /// Whether the indices ascend strictly and are of the image.
    pub(super) fn check(&self, indices: &[u32]) -> Result<()> {
        let mut next = 0u64;
        for &i in indices {
            if u64::from(i) < next || i as usize >= self.side * self.side {
                let allowed = "above the index before it and below the image's area";
                return Err(Error::OutOfRange { what: "target index", got: f64::from(i), allowed });
            }
            next = u64::from(i) + 1;
        }
        Ok(())
    }

    /// As [`set`](Self::set), of indices that are known to ascend and to be of the image.
    pub(in crate::affine) fn set_checked(&mut self, indices: &[u32]) {
        let (side, chosen) = (self.side, self.chosen.get_or_insert_default());
        match self.decomposition {
            Decomposition::Standard => {
                chosen.rows.clear();
                for (at, &i) in indices.iter().enumerate() {
                    let k = i >> side.ilog2();
                    match chosen.rows.last_mut() {
                        Some((row, end)) if *row == k => *end = at as u32 + 1,
                        _ => chosen.rows.push((k, at as u32 + 1)),
                    }
                }
            }
            Decomposition::Nonstandard => {
                chosen.place.resize(side * side, 0);
                for &i in &chosen.index {
                    chosen.place[i as usize] = 0;
                }
                for (at, &i) in indices.iter().enumerate() {
                    chosen.place[i as usize] = at as u32 + 1;
                }
            }
        }
        chosen.index.clear();
        chosen.index.extend_from_slice(indices);
        (chosen.whole_rows, chosen.alone) = (0, 0);
        let mut begin = 0;
        for &(_, end) in &chosen.rows {
            let wanted = (end - begin) as usize;
            begin = end;
            if is_sparse_row(side, wanted) { chosen.alone += wanted } else { chosen.whole_rows += 1 }
        }
    }

    /// How many targets there are.
    #[inline]
    pub fn len(&self) -> usize {
        self.chosen.as_ref().map_or(self.side * self.side, |chosen| chosen.index.len())
    }

    /// Whether there are no targets.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The side of the images.
    #[inline]
    pub fn side(&self) -> usize {
        self.side
    }

    /// The basis.
    #[inline]
    pub fn decomposition(&self) -> Decomposition {
        self.decomposition
    }
}
