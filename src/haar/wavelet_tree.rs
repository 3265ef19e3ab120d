//! Sparse coefficients as a tree, for traversals that skip what is empty.

use super::SparseVector;
use crate::{Error, Real, Result};

/// No child: the function is constant there.
pub(crate) const NONE: u32 = u32::MAX;

/// A sparse signal as the tree of its wavelets: 2 children a node in 1D, 4 in 2D (nonstandard).
///
/// Stored are the nodes that have a non-zero detail and their ancestors, each with the deviations of its children's
/// means from its own mean: in 1D ±2^{l/2} d, in 2D 2^l (±h ± v ± d). Child c of a 2D node is column c mod 2, row
/// c / 2.
/// Memory: at most (number of terms × levels) nodes of 24 (1D, f32) or 32 bytes (2D, f32).
#[derive(Debug, Clone, PartialEq)]
pub struct WaveletTree<T, const CHILDREN: usize> {
    levels: u32,
    mean: T,
    nodes: Vec<Node<T, CHILDREN>>,
}

/// The tree of a 1D signal.
pub type BinaryTree<T> = WaveletTree<T, 2>;
/// The tree of a 2D signal in the nonstandard basis.
pub type Quadtree<T> = WaveletTree<T, 4>;

/// A node that has a detail, or a descendant that has one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Node<T, const CHILDREN: usize> {
    pub(crate) deviations: [T; CHILDREN],
    pub(crate) children: [u32; CHILDREN],
}

impl<T: Real, const CHILDREN: usize> WaveletTree<T, CHILDREN> {
    /// log₂ of the number of children: the dimension.
    const DIMENSION: u32 = {
        assert!(CHILDREN == 2 || CHILDREN == 4, "a wavelet tree has 2 or 4 children a node");
        CHILDREN.ilog2()
    };

    /// The tree of sparse coefficients (flat 1D index, or flat nonstandard index in 2D).
    ///
    /// Cost: O(terms × levels).
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless the dense length is a power of `CHILDREN` (1 is one);
    /// [`Error::OutOfRange`] above 2³⁰ coefficients.
    pub fn new(coefficients: &SparseVector<T>) -> Result<Self> {
        let len = coefficients.len();
        if !len.is_power_of_two() || !len.ilog2().is_multiple_of(Self::DIMENSION) {
            return Err(Error::NotPowerOfTwo { what: "the side of a wavelet tree's signal", got: len });
        }
        if len > 1 << 30 {
            let allowed = "at most 2^30 coefficients";
            return Err(Error::OutOfRange { what: "wavelet tree size", got: len as f64, allowed });
        }
        let mut tree = Self { levels: len.ilog2() / Self::DIMENSION, mean: T::zero(), nodes: Vec::new() };
        for (flat, value) in coefficients.iter() {
            if flat == 0 {
                tree.mean = value;
            } else if value != T::zero() {
                tree.insert(flat, value);
            }
        }
        Ok(tree)
    }

    fn insert(&mut self, flat: usize, value: T) {
        let (level, kind, path) = Self::locate(flat);
        if self.nodes.is_empty() {
            self.nodes.push(Node::empty());
        }
        let mut at = 0;
        for up in (0..level).rev() {
            let child = path >> (up * Self::DIMENSION) & (CHILDREN - 1);
            let next = self.nodes[at].children[child];
            at = if next == NONE {
                self.nodes[at].children[child] = self.nodes.len() as u32;
                self.nodes.push(Node::empty());
                self.nodes.len() - 1
            } else {
                next as usize
            };
        }
        let height = value * Self::amplitude(level);
        for (child, deviation) in self.nodes[at].deviations.iter_mut().enumerate() {
            *deviation += if is_negative(kind, child) { -height } else { height };
        }
    }

    /// Level, kind (1 ≤ kind < CHILDREN) and Morton path of a detail's flat index.
    fn locate(flat: usize) -> (u32, usize, usize) {
        let level = flat.ilog2() / Self::DIMENSION;
        let count = 1usize << (level * Self::DIMENSION);
        let offset = flat & (count - 1);
        let path = if CHILDREN == 4 { morton(offset & ((1 << level) - 1), offset >> level) } else { offset };
        (level, flat / count, path)
    }

    /// The flat index of a detail.
    pub(crate) fn flat(level: u32, kind: usize, path: usize) -> usize {
        let offset = if CHILDREN == 4 {
            let (x, y) = unmorton(path);
            (y << level) + x
        } else {
            path
        };
        (kind << (level * Self::DIMENSION)) + offset
    }

    /// The height of a detail function of a level, 2^{l·dimension/2}.
    pub(crate) fn amplitude(level: u32) -> T {
        let half = level * Self::DIMENSION;
        let root = if half & 1 == 1 { std::f64::consts::SQRT_2 } else { 1.0 };
        T::of(root * 2f64.powi((half / 2) as i32))
    }

    /// How many levels of details there are: the signal's side is 2^levels.
    #[inline]
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// How many coefficients the dense signal has.
    #[inline]
    pub fn len(&self) -> usize {
        1 << (self.levels * Self::DIMENSION)
    }

    /// Whether the signal is constant: no detail at all.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The mean of the signal (its coefficient 0).
    #[inline]
    pub fn mean(&self) -> T {
        self.mean
    }

    /// How many nodes are stored.
    #[inline]
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// The node of the root, or [`NONE`].
    #[inline]
    pub(crate) fn root(&self) -> u32 {
        if self.nodes.is_empty() { NONE } else { 0 }
    }

    #[inline]
    pub(crate) fn node(&self, at: u32) -> &Node<T, CHILDREN> {
        &self.nodes[at as usize]
    }
}

impl<T: Real, const CHILDREN: usize> Node<T, CHILDREN> {
    fn empty() -> Self {
        Self { deviations: [T::zero(); CHILDREN], children: [NONE; CHILDREN] }
    }
}

/// Whether detail `kind` is −1 on a child: the Walsh sign, parity of the bits that both have.
#[inline]
pub(crate) fn is_negative(kind: usize, child: usize) -> bool {
    (kind & child).count_ones() & 1 == 1
}

/// Interleaves the bits of x (even places) and y (odd places).
#[inline]
pub(crate) fn morton(x: usize, y: usize) -> usize {
    spread(x) | spread(y) << 1
}

/// (x, y) of a Morton index.
#[inline]
pub(crate) fn unmorton(m: usize) -> (usize, usize) {
    (squeeze(m), squeeze(m >> 1))
}

fn spread(x: usize) -> usize {
    let mut x = x as u64 & 0xffff_ffff;
    x = (x | x << 16) & 0x0000_ffff_0000_ffff;
    x = (x | x << 8) & 0x00ff_00ff_00ff_00ff;
    x = (x | x << 4) & 0x0f0f_0f0f_0f0f_0f0f;
    x = (x | x << 2) & 0x3333_3333_3333_3333;
    ((x | x << 1) & 0x5555_5555_5555_5555) as usize
}

fn squeeze(m: usize) -> usize {
    let mut x = m as u64 & 0x5555_5555_5555_5555;
    x = (x | x >> 1) & 0x3333_3333_3333_3333;
    x = (x | x >> 2) & 0x0f0f_0f0f_0f0f_0f0f;
    x = (x | x >> 4) & 0x00ff_00ff_00ff_00ff;
    x = (x | x >> 8) & 0x0000_ffff_0000_ffff;
    ((x | x >> 16) & 0xffff_ffff) as usize
}
