//! A grid of maps: where tables over (s, o) have their entries.

use super::AffineMap;
use crate::{Error, Result};

/// Representative maps, geometric in s and uniform in the offsets at which anything of the signal is in sight.
///
/// F(s v + o) meets the target interval 0 < v < 1 for −max(s, 0) < o < 1 − min(s, 0) only: 1 + |s| of offsets, which
/// are divided evenly at every scale. Cells are then about equally good everywhere: a step of (Δs, Δo) moves the
/// picture on the target by (v Δs + Δo)/s.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, MapGrid, NearestMap};
/// let grid = MapGrid::new([0.5, 2.0], [2, 3])?;
/// assert!((grid.map(1, 1).scale() - 2f64.sqrt()).abs() < 1e-15);
/// assert_eq!(grid.nearest(AffineMap::new(1.5, 0.9)?), NearestMap::Cell { scale: 1, offset: 2 });
/// assert_eq!(grid.nearest(AffineMap::new(1.5, 1.1)?), NearestMap::Dark);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapGrid {
    scales: [f64; 2],
    resolution: [usize; 2],
}

/// What a [`MapGrid`] has for a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NearestMap {
    /// The cell of the grid that is nearest to the map.
    Cell {
        /// Its place along s.
        scale: usize,
        /// Its place along o.
        offset: usize,
    },
    /// Nothing of the signal is in sight: all couplings are zero.
    Dark,
    /// No cell: the map's scale is outside the grid.
    Outside,
}

impl MapGrid {
    /// Cells between two scales of one sign; `resolution` is [along s, along o].
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the scales ascend, have one sign and are scales of a map, and 1 ≤
    /// resolution ≤ 65536.
    pub fn new(scales: [f64; 2], resolution: [usize; 2]) -> Result<Self> {
        for scale in scales {
            AffineMap::new(scale, 0.0)?;
        }
        let [low, high] = scales;
        if !(low < high && low * high > 0.0) {
            let allowed = "above the lower one and of its sign";
            return Err(Error::OutOfRange { what: "upper scale of a grid of maps", got: high, allowed });
        }
        for n in resolution {
            if !(1..=65536).contains(&n) {
                let allowed = "in 1…65536";
                return Err(Error::OutOfRange { what: "resolution of a grid of maps", got: n as f64, allowed });
            }
        }
        Ok(Self { scales, resolution })
    }

    /// Lowest and highest scale.
    #[inline]
    pub fn scales(&self) -> [f64; 2] {
        self.scales
    }

    /// The numbers of cells along s and along o.
    #[inline]
    pub fn resolution(&self) -> [usize; 2] {
        self.resolution
    }

    /// The map at the centre of a cell.
    ///
    /// # Panics
    /// Unless `scale` and `offset` are below the resolution.
    #[track_caller]
    pub fn map(&self, scale: usize, offset: usize) -> AffineMap {
        self.within([scale, offset], [0.5; 2])
    }

    /// A map inside a cell: the shares go from 0 to 1 across it.
    pub(super) fn within(&self, cell: [usize; 2], share: [f64; 2]) -> AffineMap {
        assert!(cell[0] < self.resolution[0] && cell[1] < self.resolution[1], "a cell outside the grid of maps");
        let [u, v] = [0, 1].map(|k| (cell[k] as f64 + share[k]) / self.resolution[k] as f64);
        let s = self.scales[0] * (self.scales[1] / self.scales[0]).powf(u);
        AffineMap::new(s, v * (1.0 + s.abs()) - s.max(0.0)).expect("between two scales that are allowed")
    }

    /// The cell whose centre is nearest, on the axes in which the grid is uniform.
    pub fn nearest(&self, map: AffineMap) -> NearestMap {
        let [low, high] = self.scales;
        if !(low..=high).contains(&map.scale()) {
            return NearestMap::Outside;
        }
        match self.nearest_offset(map) {
            Some(offset) => NearestMap::Cell { scale: self.nearest_scale(map), offset },
            None => NearestMap::Dark,
        }
    }

    /// The place along s, clamped to the grid.
    pub(super) fn nearest_scale(&self, map: AffineMap) -> usize {
        let [low, high] = self.scales;
        let share = (map.scale() / low).ln() / (high / low).ln();
        // NaN (the other sign) and what is below become 0.
        ((share * self.resolution[0] as f64) as usize).min(self.resolution[0] - 1)
    }

    /// The place along o, if anything is in sight.
    pub(super) fn nearest_offset(&self, map: AffineMap) -> Option<usize> {
        let (s, o) = (map.scale(), map.offset());
        let share = (o + s.max(0.0)) / (1.0 + s.abs());
        let cell = (share * self.resolution[1] as f64) as usize;
        (share > 0.0 && share < 1.0).then(|| cell.min(self.resolution[1] - 1))
    }
}
