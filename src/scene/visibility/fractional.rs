//! Visibility with shades between 0 and 1.

use crate::sphere::CubeGrid;

/// For every vertex and texel of a cube map, how many of `samples`² directions spread over the texel are unoccluded.
///
/// The directions are the centres of the texel's `samples` × `samples` parts, equal on the face of the cube. Texels are stored
/// in the order of [`CubeGrid`], vertex after vertex, one byte each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FractionalVisibility {
    grid: CubeGrid,
    samples: usize,
    counts: Vec<u8>,
}

impl FractionalVisibility {
    pub(super) fn from_counts(grid: CubeGrid, samples: usize, counts: Vec<u8>) -> Self {
        Self { grid, samples, counts }
    }

    /// The grid of the maps.
    pub fn grid(&self) -> CubeGrid {
        self.grid
    }

    /// Samples along an edge of a texel; a count is at most its square.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.counts.len() / self.grid.len()
    }

    /// The counts of one vertex, a texel each.
    ///
    /// # Panics
    /// If `vertex` is out of range.
    pub fn vertex(&self, vertex: usize) -> &[u8] {
        &self.counts[vertex * self.grid.len()..][..self.grid.len()]
    }

    /// The visibility in [0, 1] of every texel of one vertex.
    ///
    /// # Panics
    /// If `vertex` is out of range.
    pub fn values(&self, vertex: usize) -> impl ExactSizeIterator<Item = f32> {
        let most = (self.samples * self.samples) as f32;
        self.vertex(vertex).iter().map(move |&count| f32::from(count) / most)
    }
}
