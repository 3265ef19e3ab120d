//! Which BRDF a vertex has.

use std::sync::Arc;

use super::Brdf;
use crate::{Error, Result};

/// One BRDF for each part of a mesh, and the part that each vertex belongs to.
#[derive(Debug, Clone)]
pub struct Materials {
    brdfs: Vec<Arc<dyn Brdf>>,
    /// Empty if every vertex belongs to part 0.
    parts: Vec<u32>,
}

impl Materials {
    /// The same BRDF everywhere.
    pub fn uniform(brdf: impl Brdf + 'static) -> Self {
        Self::uniform_shared(Arc::new(brdf))
    }

    /// The same shared BRDF everywhere, as [`BrdfSpec::build`](super::BrdfSpec::build) makes it.
    pub fn uniform_shared(brdf: Arc<dyn Brdf>) -> Self {
        Self { brdfs: vec![brdf], parts: Vec::new() }
    }

    /// BRDF `parts[v]` of the list for vertex v.
    ///
    /// # Errors
    /// [`Error::Empty`] without BRDFs or parts, [`Error::OutOfRange`] for a part without a BRDF.
    pub fn new(brdfs: Vec<Arc<dyn Brdf>>, parts: Vec<u32>) -> Result<Self> {
        if brdfs.is_empty() {
            return Err(Error::Empty { what: "list of BRDFs" });
        }
        if parts.is_empty() {
            return Err(Error::Empty { what: "list of the vertices' parts" });
        }
        if let Some(&bad) = parts.iter().find(|&&p| p as usize >= brdfs.len()) {
            return Err(Error::OutOfRange {
                what: "part of a vertex",
                got: f64::from(bad),
                allowed: "below the number of BRDFs",
            });
        }
        Ok(Self { brdfs, parts })
    }

    /// The BRDFs, one a part.
    pub fn brdfs(&self) -> &[Arc<dyn Brdf>] {
        &self.brdfs
    }

    /// The part of a vertex.
    ///
    /// # Panics
    /// If `vertex` is out of range of a list that is not uniform.
    #[track_caller]
    #[inline]
    pub fn part(&self, vertex: usize) -> usize {
        if self.parts.is_empty() { 0 } else { self.parts[vertex] as usize }
    }

    /// The BRDF of a vertex.
    ///
    /// # Panics
    /// If `vertex` is out of range of a list that is not uniform.
    #[track_caller]
    #[inline]
    pub fn brdf(&self, vertex: usize) -> &dyn Brdf {
        &*self.brdfs[self.part(vertex)]
    }

    /// Whether one channel is enough for every vertex: each BRDF is a colour times a scalar.
    pub fn is_single_channel(&self) -> bool {
        self.brdfs.iter().all(|b| b.colour().is_some())
    }

    /// Whether no BRDF depends on the view.
    pub fn is_view_independent(&self) -> bool {
        self.brdfs.iter().all(|b| b.is_view_independent())
    }

    /// Whether these are the same BRDF objects (not merely equal ones) on the same vertices.
    pub fn is_same(&self, other: &Self) -> bool {
        self.parts == other.parts
            && self.brdfs.len() == other.brdfs.len()
            && self.brdfs.iter().zip(&other.brdfs).all(|(a, b)| Arc::ptr_eq(a, b))
    }

    /// What says that the BRDF of a vertex, whose part is the index, has values that are NaN or infinite.
    pub(crate) fn not_finite(&self, vertex: usize) -> Error {
        Self::part_not_finite(self.part(vertex))
    }

    /// The same of the BRDF of a part.
    pub(crate) fn part_not_finite(index: usize) -> Error {
        Error::NotFinite { what: "value of BRDF", index }
    }

    /// Checks that there is a part for each of `vertices`.
    ///
    /// # Errors
    /// [`Error::Length`] if not; a uniform list fits every mesh.
    pub fn check(&self, vertices: usize) -> Result<()> {
        if self.parts.is_empty() || self.parts.len() == vertices {
            Ok(())
        } else {
            Err(Error::Length { what: "parts of the vertices", expected: vertices, got: self.parts.len() })
        }
    }
}
