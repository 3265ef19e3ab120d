//! Visibility as bits.

use crate::sphere::CubeGrid;
use crate::{Error, Result};

/// One bit a texel of a cube map for every vertex: 1 = unoccluded.
///
/// A face is `words_per_face` = ⌈side²/64⌉ words, bit (y · side + x) of the face at bit (i mod 64) of word (i / 64);
/// spare bits are 0. Faces follow each other in the order of [`Face::ALL`](crate::sphere::Face::ALL), vertices
/// likewise.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BinaryVisibility {
    grid: CubeGrid,
    words: Vec<u64>,
}

impl BinaryVisibility {
    /// The grid of the maps.
    pub fn grid(&self) -> CubeGrid {
        self.grid
    }

    /// Words of one face of one vertex.
    pub fn words_per_face(grid: CubeGrid) -> usize {
        grid.face_len().div_ceil(64)
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.words.len() / (6 * Self::words_per_face(self.grid))
    }

    /// The words of one vertex, six faces.
    ///
    /// # Panics
    /// If `vertex` is out of range.
    #[track_caller]
    pub fn vertex(&self, vertex: usize) -> &[u64] {
        let n = 6 * Self::words_per_face(self.grid);
        &self.words[vertex * n..][..n]
    }

    /// A map for every vertex from a function that fills its (zeroed) words.
    pub fn from_fn(grid: CubeGrid, vertices: usize, mut fill: impl FnMut(usize, &mut [u64])) -> Self {
        let n = 6 * Self::words_per_face(grid);
        let mut words = vec![0; n * vertices];
        words.chunks_exact_mut(n).enumerate().for_each(|(v, w)| fill(v, w));
        Self { grid, words }
    }

    /// A map for every vertex from its words.
    ///
    /// # Errors
    /// [`Error::Length`] unless `words` is a whole number of vertices; [`Error::OutOfRange`] if a spare bit is set.
    pub fn new(grid: CubeGrid, words: Vec<u64>) -> Result<Self> {
        let per_face = Self::words_per_face(grid);
        if !words.len().is_multiple_of(6 * per_face) {
            let expected = words.len().next_multiple_of(6 * per_face);
            return Err(Error::Length { what: "visibility words", expected, got: words.len() });
        }
        let used = grid.face_len() - 64 * (per_face - 1);
        if used < 64 && words.chunks_exact(per_face).any(|face| face[per_face - 1] >> used != 0) {
            return Err(Error::OutOfRange { what: "spare bits of a visibility map", got: 1.0, allowed: "0" });
        }
        Ok(Self { grid, words })
    }

    /// As [`new`](Self::new), of words that are known to be right.
    pub(super) fn from_parts(grid: CubeGrid, words: Vec<u64>) -> Self {
        Self { grid, words }
    }

    /// All words, vertex after vertex.
    pub fn words(&self) -> &[u64] {
        &self.words
    }

    /// Whether a vertex sees a texel (a flat index of the grid).
    ///
    /// # Panics
    /// If `vertex` or `texel` is out of range.
    #[track_caller]
    pub fn sees(&self, vertex: usize, texel: usize) -> bool {
        let (face, within) = (texel / self.grid.face_len(), texel % self.grid.face_len());
        let word = self.vertex(vertex)[face * Self::words_per_face(self.grid) + within / 64];
        word >> (within % 64) & 1 == 1
    }

    /// How many texels a vertex sees.
    ///
    /// # Panics
    /// If `vertex` is out of range.
    #[track_caller]
    pub fn count_ones(&self, vertex: usize) -> usize {
        self.vertex(vertex).iter().map(|w| w.count_ones() as usize).sum()
    }
}
