//! Visibility with shades between 0 and 1.

use crate::sphere::CubeGrid;
use crate::{Error, Result};

/// For every vertex and texel of a cube map, how many of `samples`² directions spread over the texel are unoccluded.
///
/// The directions are the centres of the texel's `samples` × `samples` parts, equal on the face of the cube. Texels are
/// stored in the order of [`CubeGrid`], vertex after vertex, one byte each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FractionalVisibility {
    grid: CubeGrid,
    samples: usize,
    counts: Vec<u8>,
}

impl FractionalVisibility {
    /// A map for every vertex from its counts, in the order of [`vertex`](Self::vertex): how many of `samples`²
    /// directions of a texel are free.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 1 ≤ `samples` ≤ 15, and for a count above `samples`²; [`Error::Length`] unless
    /// `counts` is a whole number of vertices.
    pub fn from_counts(grid: CubeGrid, samples: usize, counts: Vec<u8>) -> Result<Self> {
        check_samples(samples)?;
        check_len(grid, counts.len())?;
        if let Some(&count) = counts.iter().find(|&&count| usize::from(count) > samples * samples) {
            let what = "free samples of a texel";
            return Err(Error::OutOfRange {
                what,
                got: f64::from(count),
                allowed: "at most the square of the samples",
            });
        }
        Ok(Self { grid, samples, counts })
    }

    /// A map for every vertex from the share in [0, 1] of every texel that is free, as another renderer has it.
    ///
    /// Each becomes the nearest multiple of 1/`samples`², an error of at most half of that: 15 samples keep 226 levels.
    /// [`values`](Self::values) of a map become the same map again.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 1 ≤ `samples` ≤ 15, and for a share outside of [0, 1]; [`Error::NotFinite`] for one
    /// that is NaN or infinite; [`Error::Length`] unless `values` is a whole number of vertices.
    ///
    /// # Example
    /// ```
    /// use haarmonic::{scene::FractionalVisibility, sphere::CubeGrid};
    /// let soft: Vec<f32> = (0..24).map(|texel| texel as f32 / 23.0).collect();
    /// let visibility = FractionalVisibility::from_values(CubeGrid::new(2)?, 15, &soft)?;
    /// assert!(visibility.values(0).zip(&soft).all(|(a, b)| (a - b).abs() <= 0.5 / 225.0 + 1e-6));
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn from_values(grid: CubeGrid, samples: usize, values: &[f32]) -> Result<Self> {
        check_samples(samples)?;
        check_len(grid, values.len())?;
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            return Err(Error::NotFinite { what: "visibility of a texel", index });
        }
        if let Some(&value) = values.iter().find(|value| !(0.0..=1.0).contains(*value)) {
            return Err(Error::OutOfRange { what: "visibility of a texel", got: value.into(), allowed: "in [0, 1]" });
        }
        let most = (samples * samples) as f32;
        let counts = values.iter().map(|value| (value * most).round() as u8).collect();
        Ok(Self { grid, samples, counts })
    }

    /// As [`from_counts`](Self::from_counts), of counts that are known to be right.
    pub(super) fn from_parts(grid: CubeGrid, samples: usize, counts: Vec<u8>) -> Self {
        Self { grid, samples, counts }
    }

    /// All counts, vertex after vertex.
    pub fn counts(&self) -> &[u8] {
        &self.counts
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
    #[track_caller]
    pub fn vertex(&self, vertex: usize) -> &[u8] {
        &self.counts[vertex * self.grid.len()..][..self.grid.len()]
    }

    /// The visibility in [0, 1] of every texel of one vertex.
    ///
    /// # Panics
    /// If `vertex` is out of range.
    #[track_caller]
    pub fn values(&self, vertex: usize) -> impl ExactSizeIterator<Item = f32> {
        let most = (self.samples * self.samples) as f32;
        self.vertex(vertex).iter().map(move |&count| f32::from(count) / most)
    }
}

/// Refuses more samples than a byte can count.
pub(super) fn check_samples(samples: usize) -> Result<()> {
    if (1..=15).contains(&samples) {
        return Ok(());
    }
    let what = "visibility samples along a texel's edge";
    Err(Error::OutOfRange { what, got: samples as f64, allowed: "in 1…15" })
}

fn check_len(grid: CubeGrid, got: usize) -> Result<()> {
    if got.is_multiple_of(grid.len()) {
        return Ok(());
    }
    Err(Error::Length { what: "texels with visibility", expected: got.next_multiple_of(grid.len()), got })
}
