//! Which coefficients each of many vertices wants.

use super::targets::Targets;
use crate::haar::Decomposition;
use crate::{Error, Result};

/// The target coefficients of many vertices: all for each, or a list for each.
///
/// The lists follow one another; of a number for each of them, such as a transport's, that of entry e stands at e.
///
/// # Example
/// ```
/// use haarmonic::affine::TargetLists;
/// use haarmonic::haar::Decomposition::Standard;
/// // Three vertices, of which the second wants nothing.
/// let lists = TargetLists::new(32, Standard, &[0, 3, 3, 4], &[0, 1, 33, 7])?;
/// assert_eq!((lists.vertices(), lists.len()), (3, 4));
/// assert_eq!(lists.range(2), 3..4);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TargetLists {
    side: usize,
    decomposition: Decomposition,
    vertices: usize,
    /// The ends of the lists, from 0 on, and their indices.
    chosen: Option<(Vec<usize>, Vec<u32>)>,
}

impl TargetLists {
    /// All coefficients of `side`² images for each of `vertices`, in flat order.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `side` is one; [`Error::OutOfRange`] above 4096, and above 2⁴⁰ targets.
    pub fn all(side: usize, decomposition: Decomposition, vertices: usize) -> Result<Self> {
        super::check_side(side)?;
        if vertices > (1 << 40) / (side * side) {
            let allowed = "such that there are at most 2⁴⁰ targets";
            return Err(Error::OutOfRange { what: "vertices of lists of targets", got: vertices as f64, allowed });
        }
        Ok(Self { side, decomposition, vertices, chosen: None })
    }

    /// The list of vertex v is `indices[offsets[v]..offsets[v + 1]]`, of flat indices.
    ///
    /// # Errors
    /// As [`all`](Self::all); [`Error::Empty`] without offsets; [`Error::OutOfRange`] unless the offsets begin at 0 and
    /// never descend, and the indices of a list ascend strictly and are below `side`²; [`Error::Length`] unless the
    /// last offset is the number of indices.
    pub fn new(side: usize, decomposition: Decomposition, offsets: &[usize], indices: &[u32]) -> Result<Self> {
        let vertices = offsets.len().checked_sub(1).ok_or(Error::Empty { what: "offsets of lists of targets" })?;
        let descends = |&v: &usize| if v == 0 { offsets[0] != 0 } else { offsets[v] < offsets[v - 1] };
        if let Some(v) = (0..=vertices).find(descends) {
            let allowed = "0 at first, and not below the offset before it";
            return Err(Error::OutOfRange { what: "offset of a list of targets", got: offsets[v] as f64, allowed });
        }
        if offsets[vertices] != indices.len() {
            let (expected, got) = (offsets[vertices], indices.len());
            return Err(Error::Length { what: "indices of lists of targets", expected, got });
        }
        let list = Targets::all(side, decomposition)?;
        for ends in offsets.windows(2) {
            list.check(&indices[ends[0]..ends[1]])?;
        }
        Ok(Self { side, decomposition, vertices, chosen: Some((offsets.to_vec(), indices.to_vec())) })
    }

    /// How many vertices there are.
    #[inline]
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// How many targets there are of all vertices together.
    #[inline]
    pub fn len(&self) -> usize {
        self.end(self.vertices)
    }

    /// Whether no vertex has a target.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The entries of a vertex, counted over all lists.
    ///
    /// # Panics
    /// Unless `vertex` is below [`vertices`](Self::vertices).
    #[track_caller]
    #[inline]
    pub fn range(&self, vertex: usize) -> std::ops::Range<usize> {
        assert!(vertex < self.vertices, "vertex {vertex} of {}", self.vertices);
        self.end(vertex)..self.end(vertex + 1)
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

    /// Where the lists of so many vertices end.
    #[inline]
    pub(super) fn end(&self, vertices: usize) -> usize {
        match &self.chosen {
            Some((offsets, _)) => offsets[vertices],
            None => vertices * self.side * self.side,
        }
    }

    /// The flat index of each entry of a vertex.
    #[inline]
    pub(super) fn index(&self, vertex: usize, entry: usize) -> usize {
        match &self.chosen {
            Some((offsets, indices)) => indices[offsets[vertex] + entry] as usize,
            None => entry,
        }
    }

    /// Targets for one thread, to be given to [`set`](Self::set).
    pub(super) fn scratch(&self) -> Targets {
        Targets::all(self.side, self.decomposition).expect("the side has been checked")
    }

    /// Makes targets those of a vertex.
    pub(super) fn set(&self, vertex: usize, targets: &mut Targets) {
        if let Some((offsets, indices)) = &self.chosen {
            targets.set_checked(&indices[offsets[vertex]..offsets[vertex + 1]]);
        }
    }
}
