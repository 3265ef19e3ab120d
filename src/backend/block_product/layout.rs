//! Where the texels of a cube map lie in blocks, and blocks in the database.

use nalgebra::Vector3;

use crate::compress::{Scan, ScanOrder};
use crate::sphere::{CubeGrid, Face};
use crate::{Error, Result};

/// A cube map cut into square blocks, the pixels of each taken along a path or along the same path turned about the
/// diagonal.
///
/// Block (by · blocks + bx) of face f has the number f · blocks² + by · blocks + bx, where `blocks` = side / block
/// side; the *place* of a pixel in its block is its position along the path. 64² × 6 texels in blocks of 16² are 96
/// blocks.
///
/// # Example
/// ```
/// use haarmonic::{backend::block_product::BlockLayout, compress::ScanOrder, sphere::CubeGrid};
/// let layout = BlockLayout::new(CubeGrid::new(64)?, 16, ScanOrder::Serpentine)?;
/// assert_eq!((layout.blocks(), layout.block_len()), (96, 256));
/// assert_eq!(layout.texels(0, 0)[16], 64 + 15); // the second row runs backwards
/// assert_eq!(layout.texels(1, 0)[16], 64 * 15 + 1); // the second column upwards
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BlockLayout {
    grid: CubeGrid,
    side: usize,
    scans: [Scan; 2],
    /// [course][place]; a *course* is a block and one of its paths, number block + blocks · path.
    texels: Vec<u32>,
}

impl BlockLayout {
    /// The largest side of a cube map.
    pub const MAX_SIDE: usize = 1024;

    /// Cuts `grid` into blocks of `side`².
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless `side` is 8, 16 or 32 and divides the side of the grid, which is at most
    /// [`MAX_SIDE`](Self::MAX_SIDE).
    pub fn new(grid: CubeGrid, side: usize, order: ScanOrder) -> Result<Self> {
        if ![8, 16, 32].contains(&side) {
            return Err(Error::OutOfRange { what: "side of a block", got: side as f64, allowed: "8, 16 or 32" });
        }
        if grid.side() % side != 0 || grid.side() > Self::MAX_SIDE {
            let (got, allowed) = (grid.side() as f64, "a multiple of the block's, at most 1024");
            return Err(Error::OutOfRange { what: "side of the cube map", got, allowed });
        }
        let scans = [Scan::new(order, side, side)?, Scan::turned(order, side, side)?];
        let along = grid.side() / side;
        let mut texels = Vec::with_capacity(2 * grid.len());
        for (scan, block) in scans.iter().flat_map(|scan| (0..6 * along * along).map(move |block| (scan, block))) {
            texels.extend(scan.pixels().iter().map(|&pixel| texel(grid, side, block, pixel as usize) as u32));
        }
        Ok(Self { grid, side, scans, texels })
    }

    /// The grid of the cube map.
    #[inline]
    pub fn grid(&self) -> CubeGrid {
        self.grid
    }

    /// Pixels along an edge of a block.
    #[inline]
    pub fn side(&self) -> usize {
        self.side
    }

    /// Pixels of a block.
    #[inline]
    pub fn block_len(&self) -> usize {
        self.side * self.side
    }

    /// Blocks of the cube map.
    #[inline]
    pub fn blocks(&self) -> usize {
        self.grid.len() / self.block_len()
    }

    /// The path through a block, and the same turned.
    #[inline]
    pub fn scans(&self) -> &[Scan; 2] {
        &self.scans
    }

    /// The flat texel of each place of a block, along path 0 or 1 of [`scans`](Self::scans).
    ///
    /// # Panics
    /// If `path` or `block` is out of range.
    #[track_caller]
    #[inline]
    pub fn texels(&self, path: usize, block: usize) -> &[u32] {
        assert!(path < 2 && block < self.blocks(), "block {block} along path {path} of {} blocks", self.blocks());
        &self.texels[(path * self.blocks() + block) * self.block_len()..][..self.block_len()]
    }

    /// The flat texel of a pixel of a block, row after row.
    pub(super) fn texel(&self, block: usize, pixel: usize) -> usize {
        texel(self.grid, self.side, block, pixel)
    }

    /// The unit direction at (x, y) of a block, in pixels from the centre of its first; pixel centres are whole
    /// numbers.
    ///
    /// # Panics
    /// If `block` is out of range.
    #[track_caller]
    pub fn direction(&self, block: usize, x: f64, y: f64) -> Vector3<f64> {
        let along = self.grid.side() / self.side;
        let (face, by, bx) = (block / (along * along), block / along % along, block % along);
        let on_face =
            |block: usize, at: f64| ((block * self.side) as f64 + at + 0.5) * 2.0 / self.grid.side() as f64 - 1.0;
        Face::ALL[face].point(on_face(bx, x), on_face(by, y)).normalize()
    }

    /// The direction of a block's centre.
    ///
    /// # Panics
    /// If `block` is out of range.
    #[track_caller]
    pub fn centre(&self, block: usize) -> Vector3<f64> {
        let middle = 0.5 * self.side as f64 - 0.5;
        self.direction(block, middle, middle)
    }

    /// The largest angle between a block's centre and a point of it, in radians.
    ///
    /// # Panics
    /// If `block` is out of range.
    #[track_caller]
    pub fn radius(&self, block: usize) -> f64 {
        let (first, last) = (-0.5, self.side as f64 - 0.5);
        let centre = self.centre(block);
        let corners = [[first, first], [first, last], [last, first], [last, last]];
        corners.map(|[x, y]| centre.angle(&self.direction(block, x, y))).into_iter().fold(0.0, f64::max)
    }

    /// The number of a block's shape among [`shapes`](Self::shapes).
    pub(super) fn shape_of(&self, block: usize) -> usize {
        let along = self.grid.side() / self.side;
        let near = |at: usize| at.min(along - 1 - at);
        let (x, y) = (near(block % along), near(block / along % along));
        let (low, high) = (x.min(y), x.max(y));
        // Rows of `shapes` become shorter by one each.
        let half = along.div_ceil(2);
        (0..low).map(|row| half - row).sum::<usize>() + high - low
    }

    /// One block of every shape that there is up to the symmetries of the cube.
    pub(super) fn shapes(&self) -> Vec<usize> {
        let along = self.grid.side() / self.side;
        let half = along.div_ceil(2);
        (0..half).flat_map(|by| (by..half).map(move |bx| by * along + bx)).collect()
    }
}

/// The flat texel of a pixel of a block of `side`².
fn texel(grid: CubeGrid, side: usize, block: usize, pixel: usize) -> usize {
    let along = grid.side() / side;
    let (face, by, bx) = (block / (along * along), block / along % along, block % along);
    grid.index(Face::ALL[face], bx * side + pixel % side, by * side + pixel / side)
}
