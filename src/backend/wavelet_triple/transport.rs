//! The transport of a static scene: its visibility.

use crate::backend::distant::read_dyadic_grid;
use crate::scene::{BinaryVisibility, VisibilityBaker};
use crate::sphere::CubeGrid;
use crate::store::parts::Parts;
use crate::store::{Kind, Reader, Writer};
use crate::{Error, Progress, Result};

/// Vertices of a section of a file.
const SECTION: usize = 4096;

/// The transport of a static scene: one visibility bit a texel of the cube map around each vertex, losslessly.
///
/// It knows neither light, nor view, nor materials. In memory and on disk: 6 side² / 8 bytes a vertex (3 KiB at side
/// 64).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Transport {
    visibility: BinaryVisibility,
}

/// What a [`Transport`] holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct TransportStats {
    /// Vertices.
    pub vertices: usize,
    /// Bytes in memory.
    pub bytes: usize,
}

impl Transport {
    /// Traces the visibility of every vertex. `progress` counts vertices.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] for a cube map whose side is none; as [`VisibilityBaker::bake`].
    pub fn bake(baker: &VisibilityBaker, progress: &dyn Progress) -> Result<Self> {
        check_grid(baker.grid())?;
        Self::from_binary(baker.bake(progress)?)
    }

    /// Takes visibility that is there.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] for a cube map whose side is none.
    pub fn from_binary(visibility: BinaryVisibility) -> Result<Self> {
        check_grid(visibility.grid())?;
        Ok(Self { visibility })
    }

    /// The visibility.
    pub fn visibility(&self) -> &BinaryVisibility {
        &self.visibility
    }

    /// The grid of the cube maps.
    pub fn grid(&self) -> CubeGrid {
        self.visibility.grid()
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.visibility.vertices()
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        size_of_val(self.visibility.words())
    }

    /// Counts and sizes.
    pub fn stats(&self) -> TransportStats {
        TransportStats { vertices: self.vertices(), bytes: self.bytes() }
    }
}

fn check_grid(grid: CubeGrid) -> Result<()> {
    match grid.side() {
        side if side.is_power_of_two() => Ok(()),
        got => Err(Error::NotPowerOfTwo { what: "side of the visibility's cube map", got }),
    }
}

/// ```text
/// SIZE  side of the cube map u64, vertices u64
/// WORD  for each 4096 vertices: words of visibility u64
/// ```
impl Parts for Transport {
    const KIND: Kind = Kind::WaveletTriple;

    fn write(&self, to: &mut Writer) -> Result<()> {
        to.section(*b"SIZE", |s| {
            s.field(self.grid().side() as u64);
            s.field(self.vertices() as u64);
        })?;
        let each = 6 * BinaryVisibility::words_per_face(self.grid());
        for words in self.visibility.words().chunks(SECTION * each) {
            to.section(*b"WORD", |s| s.array(words))?;
        }
        Ok(())
    }

    fn read(from: &mut Reader) -> Result<Self> {
        let mut size = from.section(*b"SIZE")?;
        let (grid, vertices) = (read_dyadic_grid(&mut size)?, size.count("vertices")?);
        size.end()?;
        let each = 6 * BinaryVisibility::words_per_face(grid);
        let mut words: Vec<u64> = Vec::new();
        let mut left = vertices;
        while left > 0 {
            let now = left.min(SECTION);
            let mut section = from.section(*b"WORD")?;
            words.extend(section.array::<u64>("words of visibility", now * each)?);
            section.end()?;
            left -= now;
        }
        let visibility = BinaryVisibility::new(grid, words).map_err(|e| from.wrong(e.to_string()))?;
        Ok(Self { visibility })
    }
}
