//! The means of a 2D signal over every square of the quadtree, children side by side.

use super::super::SparseVector;
use super::super::wavelet_tree::{morton, unmorton};
use super::first_node;
use super::nodes::SparseNodes;
use crate::error::check_length;
use crate::{Error, Real, Result};

/// The mean pyramid of C 2D signals in quadtree order: one record for the four children of a node.
///
/// Node 0 is the whole square; the children of node n are 4n + 1 … 4n + 4 in the order (0,0), (1,0), (0,1), (1,1) of
/// (column, row). So a level's nodes follow each other in Morton order and the last level is the texels in Morton
/// order. `blocks[n + 1][channel]` holds the means of the children of node n: one 16-byte (f32) load gives what a node
/// of a product needs. For a row-major mean pyramid, see [`Pyramid`](super::super::Pyramid).
#[derive(Debug, Clone, PartialEq)]
pub struct MeanTree<T, const C: usize = 1> {
    levels: u32,
    blocks: Vec<[[T; 4]; C]>,
}

impl<T: Real, const C: usize> MeanTree<T, C> {
    /// The tree of zeros for `side`² texels.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `side` is one; [`Error::OutOfRange`] above 2¹⁴.
    pub fn zeros(side: usize) -> Result<Self> {
        let levels = super::levels_of(side)?;
        Ok(Self { levels, blocks: vec![[[T::zero(); 4]; C]; first_node(levels) + 1] })
    }

    /// The tree of images given row after row.
    ///
    /// # Errors
    /// As [`Self::zeros`]; [`Error::Length`] unless every channel has side² texels.
    pub fn from_pixels(side: usize, pixels: [&[T]; C]) -> Result<Self> {
        Self::check("pixels", side, &pixels)?;
        let mut tree = Self::zeros(side)?;
        for (channel, pixels) in pixels.into_iter().enumerate() {
            for (m, (x, y)) in (0..side * side).map(|m| (m, unmorton(m))) {
                tree.set(first_node(tree.levels) + m, channel, pixels[y * side + x]);
            }
        }
        tree.average();
        Ok(tree)
    }

    /// The tree of dense nonstandard coefficients.
    ///
    /// # Errors
    /// As [`Self::zeros`]; [`Error::Length`] unless every channel has side² coefficients.
    pub fn from_coefficients(side: usize, coefficients: [&[T]; C]) -> Result<Self> {
        Self::check("coefficients", side, &coefficients)?;
        let mut tree = Self::zeros(side)?;
        for (channel, c) in coefficients.into_iter().enumerate() {
            tree.set(0, channel, c[0]);
            for level in 0..tree.levels {
                let (count, height) = (1usize << (2 * level), T::of(f64::from(1u32 << level)));
                for m in 0..count {
                    let (x, y) = unmorton(m);
                    let at = (y << level) + x;
                    let [h, v, d] = [1, 2, 3].map(|kind| height * c[kind * count + at]);
                    let n = first_node(level) + m;
                    let a = tree.mean(n, channel);
                    tree.blocks[n + 1][channel] = children(a, h, v, d);
                }
            }
        }
        Ok(tree)
    }

    /// Checks lengths before anything of the size is allocated.
    fn check(what: &'static str, side: usize, channels: &[&[T]; C]) -> Result<()> {
        super::levels_of(side)?;
        match channels.iter().find(|channel| channel.len() != side * side) {
            Some(channel) => Err(Error::Length { what, expected: side * side, got: channel.len() }),
            None => Ok(()),
        }
    }

    /// The tree of sparse nonstandard coefficients, one vector a channel.
    ///
    /// # Errors
    /// As [`Factor::new`](super::Factor::new).
    pub fn from_sparse(coefficients: [&SparseVector<T>; C]) -> Result<Self> {
        let nodes = SparseNodes::new(coefficients)?;
        let mut tree = Self::zeros(nodes.side())?;
        tree.fill(&nodes);
        Ok(tree)
    }

    /// Overwrites the tree with the signal of `nodes`; allocates nothing.
    ///
    /// # Panics
    /// If the sides differ.
    #[track_caller]
    pub(super) fn fill(&mut self, nodes: &SparseNodes<T, C>) {
        check_length("side of the nodes", self.side(), nodes.side());
        for channel in 0..C {
            self.set(0, channel, nodes.mean(channel));
        }
        for level in 0..self.levels {
            let start = first_node(level);
            for n in start..first_node(level + 1) {
                let (record, place) = place(n);
                self.blocks[n + 1] = self.blocks[record].map(|four| [four[place]; 4]);
            }
            let scale = T::of(f64::from(4u32).powi(level as i32 + 1));
            for (&n, weighted) in nodes.level(level) {
                for (block, four) in self.blocks[n as usize + 1].iter_mut().zip(weighted) {
                    block.iter_mut().zip(four).for_each(|(mean, &w)| *mean += scale * w);
                }
            }
        }
    }

    /// Fills every level above the texels with the averages of the level below.
    fn average(&mut self) {
        let quarter = T::of(0.25);
        for n in (0..first_node(self.levels)).rev() {
            for channel in 0..C {
                let [a, b, c, d] = self.blocks[n + 1][channel];
                // Scaled before they are added, which changes no bit, or the sum of the largest numbers would overflow.
                self.set(n, channel, (quarter * a + quarter * b) + (quarter * c + quarter * d));
            }
        }
    }

    #[inline]
    fn set(&mut self, n: usize, channel: usize, value: T) {
        let (record, place) = place(n);
        self.blocks[record][channel][place] = value;
    }

    /// The mean of a channel over node `n`.
    ///
    /// # Panics
    /// If there is no such node or channel.
    #[track_caller]
    #[inline]
    pub fn mean(&self, n: usize, channel: usize) -> T {
        let (record, place) = place(n);
        self.blocks[record][channel][place]
    }

    /// The mean over the square (x, y) of a level; level 0 is the whole, level log₂ side the texels.
    ///
    /// # Panics
    /// If there is no such square or channel.
    #[track_caller]
    pub fn mean_at(&self, level: u32, x: usize, y: usize, channel: usize) -> T {
        assert!(level <= self.levels && x >> level == 0 && y >> level == 0, "no square ({x}, {y}) on level {level}");
        self.mean(first_node(level) + morton(x, y), channel)
    }

    /// The side of the image.
    #[inline]
    pub fn side(&self) -> usize {
        1 << self.levels
    }

    /// log₂ of the side.
    #[inline]
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// Record n + 1: the children of node n. Record 0 ends with the root.
    #[inline]
    pub fn blocks(&self) -> &[[[T; 4]; C]] {
        &self.blocks
    }

    /// Texels of a channel in Morton order.
    pub fn texels(&self, channel: usize) -> impl Iterator<Item = T> + '_ {
        let first = first_node(self.levels);
        (first..first + self.side() * self.side()).map(move |n| self.mean(n, channel))
    }
}

impl<T: Real> MeanTree<T> {
    /// All means, that of node n at n + 3 (the first three are 0).
    #[inline]
    pub(crate) fn flat(&self) -> &[T] {
        self.blocks.as_flattened().as_flattened()
    }

    /// The texels in Morton order.
    #[inline]
    pub fn morton_pixels(&self) -> &[T] {
        &self.flat()[first_node(self.levels) + 3..]
    }
}

/// The means of the children of a node of mean a and details h, v, d, by (column, row).
#[inline]
fn children<T: Real>(a: T, h: T, v: T, d: T) -> [T; 4] {
    let means = [a + h + v + d, a - h + v - d, a + h - v - d, a - h - v + d];
    if means.iter().all(|mean| mean.is_finite()) {
        return means;
    }
    // a ± h are means of halves and v ± d halves of differences between texels: what the texels can hold, these can.
    let (left, right) = (a + h, a - h);
    [left + (v + d), right + (v - d), left - (v + d), right - (v - d)]
}

/// The record of a node's mean and its place there: number n + 3 in the flat order.
#[inline]
const fn place(n: usize) -> (usize, usize) {
    ((n + 3) >> 2, (n + 3) & 3)
}
