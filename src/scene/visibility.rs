//! Which directions a vertex sees.

use crate::sphere::CubeGrid;

/// One bit a texel of a cube map for every vertex: 1 = unoccluded.
///
/// A face is `words_per_face` = ⌈side²/64⌉ words, bit (y · side + x) of the face at bit (i mod 64) of word (i / 64);
/// spare bits are 0. Faces follow each other in the order of [`Face::ALL`](crate::sphere::Face::ALL), vertices likewise.
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
}
