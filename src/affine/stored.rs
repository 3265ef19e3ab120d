//! The memory approach: couplings of many maps computed beforehand.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::coupling::levels_of;
use super::{AffineMap, MapGrid, NearestMap, Nonzeros1d};
use crate::{Error, Result, parallel};

/// All non-zero 1D couplings D_ij(s, o) on a grid of maps                     [Sun 2008, §4.5.5, "memory based
/// approach"].
///
/// A map uses the couplings of the nearest cell of a [`MapGrid`]. Applying an operator of N = 32 that is stored takes a
/// tenth of computing and applying it with [`Operator1d`](super::Operator1d) while the table stays in the caches
/// (docs/performance.md); the price is the error below. 2D lights are carried faster, and exactly, by
/// [`Propagation`](super::Propagation).
///
/// # Layout
/// An entry has an 8-bit target index and an f32 value, 5 bytes; each cell adds 2(N + 1) bytes of row starts.
///
/// # Accuracy
/// Values are rounded to f32; what counts is the distance to the nearest cell. Mean relative L2 error of a transformed
/// light (rows of textured lights, N = 32, scales ¼…4), and bytes:
///
/// | cells | error | N = 8 | N = 16 | N = 32 | N = 64 |
/// |---|---|---|---|---|---|
/// | 64² | .145 | 0.55 MB | 1.18 MB | 2.44 MB | 4.99 MB |
/// | 128² | .071 | 2.22 MB | 4.71 MB | 9.76 MB | 19.96 MB |
/// | 256² | .035 | 8.88 MB | 18.83 MB | 39.05 MB | 79.83 MB |
/// | 512² | .017 | 35.5 MB | 75.3 MB | 156 MB | 319 MB |
/// | 1024² | .0087 | 142 MB | 301 MB | 625 MB | 1277 MB |
///
/// Twice the thesis' sizes: its ranges of (s, o) are not stated, and every cell of ours has something in sight. Size
/// and time are linear in N and in the number of cells.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, MapGrid, StoredCouplings};
/// let stored = StoredCouplings::new(32, MapGrid::new([0.25, 4.0], [16, 16])?, 1 << 20)?;
/// let operator = stored.operator(AffineMap::new(0.8, 0.1)?).expect("a scale of the grid");
/// let (targets, values) = operator.row(0);
/// assert_eq!((targets[0], values.len()), (0, targets.len()));
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct StoredCouplings {
    size: usize,
    grid: MapGrid,
    slabs: Vec<Slab>,
}

/// The cells of one scale.
#[derive(Debug, Clone, PartialEq, Default)]
struct Slab {
    /// Where each cell's entries begin, and the end.
    cells: Vec<u32>,
    /// N + 1 a cell: where each row begins, counted from the cell's beginning, and the end.
    rows: Vec<u16>,
    targets: Vec<u8>,
    values: Vec<f32>,
}

impl StoredCouplings {
    /// Computes the couplings of signals of `size` coefficients at the centre of each cell, on all threads; the bits
    /// are the same for any number.
    ///
    /// Cost: proportional to the non-zeros; 39 MB (N = 32, 256² cells) take 0.07 s on two cores, where the thesis has
    /// 1.06 s for 19 MB.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `size` is one. [`Error::OutOfRange`] if it is above 256, or if the table would
    /// take more than `limit` bytes; no more than that (and one scale a thread) is allocated to find out.
    pub fn new(size: usize, grid: MapGrid, limit: usize) -> Result<Self> {
        levels_of("size of a signal", size)?;
        if size > 256 {
            return Err(Error::OutOfRange { what: "size of a signal", got: size as f64, allowed: "at most 256" });
        }
        let nonzeros = Nonzeros1d::new(size)?;
        let scales = grid.resolution()[0];
        let bytes = AtomicUsize::new(0);
        let slab = |k: usize| {
            if bytes.load(Ordering::Relaxed) > limit {
                return Slab::default(); // lost already
            }
            let slab = Slab::new(nonzeros, &grid, k);
            bytes.fetch_add(slab.bytes(), Ordering::Relaxed);
            slab
        };
        let slabs = parallel::map(scales, slab);
        let bytes = bytes.into_inner();
        if bytes > limit {
            let allowed = "at most the stated limit";
            return Err(Error::OutOfRange { what: "bytes of stored couplings", got: bytes as f64, allowed });
        }
        Ok(Self { size, grid, slabs })
    }

    /// The number of coefficients of a signal.
    #[inline]
    pub fn size(&self) -> usize {
        self.size
    }

    /// The grid of maps that have an entry.
    #[inline]
    pub fn grid(&self) -> &MapGrid {
        &self.grid
    }

    /// How many couplings are stored.
    pub fn nonzeros(&self) -> usize {
        self.slabs.iter().map(|slab| slab.values.len()).sum()
    }

    /// Bytes of the table.
    pub fn bytes(&self) -> usize {
        self.slabs.iter().map(Slab::bytes).sum()
    }

    /// The couplings of the nearest cell; none at all where nothing of the signal is in sight. `None` for a scale
    /// outside the grid.
    pub fn operator(&self, map: AffineMap) -> Option<StoredOperator<'_>> {
        match self.grid.nearest(map) {
            NearestMap::Outside => None,
            NearestMap::Dark => Some(StoredOperator { rows: &[], targets: &[], values: &[], size: self.size }),
            NearestMap::Cell { scale, offset } => {
                let slab = &self.slabs[scale];
                let entries = slab.cells[offset] as usize..slab.cells[offset + 1] as usize;
                Some(StoredOperator {
                    rows: &slab.rows[offset * (self.size + 1)..][..self.size + 1],
                    targets: &slab.targets[entries.clone()],
                    values: &slab.values[entries],
                    size: self.size,
                })
            }
        }
    }
}

impl Slab {
    fn new(nonzeros: Nonzeros1d, grid: &MapGrid, scale: usize) -> Self {
        let mut slab = Self { cells: vec![0], ..Self::default() };
        for offset in 0..grid.resolution()[1] {
            let (map, start) = (grid.map(scale, offset), slab.values.len());
            slab.rows.push(0);
            for i in 0..nonzeros.size() {
                nonzeros.row(i, map, |j, value| {
                    slab.targets.push(j as u8);
                    slab.values.push(value as f32);
                });
                slab.rows.push((slab.values.len() - start) as u16);
            }
            slab.cells.push(slab.values.len() as u32);
        }
        slab.cells.shrink_to_fit();
        slab.rows.shrink_to_fit();
        slab.targets.shrink_to_fit();
        slab.values.shrink_to_fit();
        slab
    }

    fn bytes(&self) -> usize {
        4 * self.cells.len() + 2 * self.rows.len() + self.targets.len() + 4 * self.values.len()
    }
}

/// The couplings of one cell of [`StoredCouplings`], row by row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StoredOperator<'a> {
    rows: &'a [u16],
    targets: &'a [u8],
    values: &'a [f32],
    size: usize,
}

impl<'a> StoredOperator<'a> {
    /// The targets j, ascending, and the couplings D_ij of source function i.
    ///
    /// # Panics
    /// Unless `i` is below the size.
    #[track_caller]
    #[inline]
    pub fn row(&self, i: usize) -> (&'a [u8], &'a [f32]) {
        assert!(i < self.size, "a source function beyond the size");
        if self.rows.is_empty() {
            return (&[], &[]);
        }
        let entries = usize::from(self.rows[i])..usize::from(self.rows[i + 1]);
        (&self.targets[entries.clone()], &self.values[entries])
    }

    /// How many couplings the operator has.
    #[inline]
    pub fn nonzeros(&self) -> usize {
        self.values.len()
    }

    /// target_j += Σ_i source_i D_ij.
    ///
    /// Shapes: source, target of the signal's size.
    ///
    /// # Panics
    /// If a length differs.
    #[track_caller]
    pub fn add_to(&self, source: &[f32], target: &mut [f32]) {
        crate::error::check_length("source", self.size, source.len());
        crate::error::check_length("target", self.size, target.len());
        for (i, &f) in source.iter().enumerate().filter(|(_, f)| **f != 0.0) {
            let (targets, values) = self.row(i);
            for (&j, &value) in targets.iter().zip(values) {
                target[usize::from(j)] += f * value;
            }
        }
    }
}
