//! A light as every route wants it, prepared once and shared by all maps.

use super::cost::Estimates;
use super::lookups::PrimitiveTable;
use crate::affine::Atom;
use crate::haar::{Decomposition, SparseVector, Transform2d};
use crate::{Error, Real, Result};

/// Coefficients of C channels of one image, with what the routes of a [`Propagation`](super::Propagation) need of them:
/// the terms, grouped; the pixels; a summed-area table.
///
/// Size: 4 + 4·C bytes a term, (sizeof T + 8)·C bytes a pixel. Changing a light costs an inverse transform and a table.
#[derive(Debug, Clone)]
pub struct PropagationSource<T, const C: usize> {
    pub(super) side: usize,
    pub(super) decomposition: Decomposition,
    pub(super) terms: Terms<T, C>,
    /// C planes, transposed: pixel (x, y) at x·side + y.
    pub(super) pixels: Vec<T>,
    pub(super) table: PrimitiveTable<C>,
}

/// The terms of a source, by ascending flat index.
#[derive(Debug, Clone)]
pub(super) struct Terms<T, const C: usize> {
    pub(super) index: Vec<u32>,
    pub(super) value: Vec<[T; C]>,
    /// Standard basis: the flat 1D indices that occur along x and along y, ascending.
    pub(super) along: [Vec<u32>; 2],
    /// Standard basis: where each term's pair of 1D indices lies in `along`.
    pub(super) slot: Vec<[u32; 2]>,
    /// Of `along`, and of the terms (standard: along x).
    pub(super) functions: [Estimates; 2],
    pub(super) by_level: Estimates,
}

impl<T: Real, const C: usize> PropagationSource<T, C> {
    /// Prepares the coefficients of C channels of a `side`² image; terms that a channel lacks are 0 there.
    ///
    /// A compressed light (source-level compression) is one with few terms: see [`Selection`](crate::haar::Selection).
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `side` is one; [`Error::OutOfRange`] above 4096; [`Error::Length`] if a
    /// channel's dense length is not `side`².
    pub fn new(side: usize, decomposition: Decomposition, channels: [&SparseVector<T>; C]) -> Result<Self> {
        super::check_side(side)?;
        for channel in channels {
            if channel.len() != side * side {
                let (expected, got) = (side * side, channel.len());
                return Err(Error::Length { what: "coefficients of a channel", expected, got });
            }
        }
        let plan = Transform2d::<T>::new(side, side, decomposition)?;
        let (mut image, mut scratch) = (vec![T::zero(); side * side], vec![T::zero(); plan.scratch_len()]);
        let mut pixels = vec![T::zero(); C * side * side];
        let mut table = PrimitiveTable::new(side);
        for (c, channel) in channels.iter().enumerate() {
            image.copy_from_slice(&channel.to_dense());
            plan.inverse_in_place(&mut image, &mut scratch);
            table.set(c, &image);
            let plane = &mut pixels[c * side * side..][..side * side];
            for (y, row) in image.chunks_exact(side).enumerate() {
                for (x, &value) in row.iter().enumerate() {
                    plane[x * side + y] = value;
                }
            }
        }
        Ok(Self { side, decomposition, terms: Terms::new(side, decomposition, channels), pixels, table })
    }

    /// As [`new`](Self::new), from dense coefficients; zeros are dropped.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_dense(side: usize, decomposition: Decomposition, channels: [&[T]; C]) -> Result<Self> {
        let sparse = channels.map(SparseVector::from_dense);
        Self::new(side, decomposition, sparse.each_ref())
    }

    /// The side of the image.
    #[inline]
    pub fn side(&self) -> usize {
        self.side
    }

    /// The basis.
    #[inline]
    pub fn decomposition(&self) -> Decomposition {
        self.decomposition
    }

    /// How many basis functions have a term in some channel.
    #[inline]
    pub fn terms(&self) -> usize {
        self.terms.index.len()
    }
}

impl<T: Real, const C: usize> Terms<T, C> {
    fn new(side: usize, decomposition: Decomposition, channels: [&SparseVector<T>; C]) -> Self {
        let mut index: Vec<u32> = channels.iter().flat_map(|c| c.indices().iter().copied()).collect();
        index.sort_unstable();
        index.dedup();
        let mut value = vec![[T::zero(); C]; index.len()];
        for (c, channel) in channels.iter().enumerate() {
            for (i, v) in channel.iter() {
                let at = index.binary_search(&(i as u32)).expect("every index of a channel is in the union");
                value[at][c] = v;
            }
        }
        let pair = |i: u32| [i % side as u32, i / side as u32];
        let mut along = [Vec::new(), Vec::new()];
        let mut slot = Vec::new();
        if decomposition == Decomposition::Standard {
            for axis in 0..2 {
                along[axis] = index.iter().map(|&i| pair(i)[axis]).collect();
                along[axis].sort_unstable();
                along[axis].dedup();
            }
            let place = |axis: usize, k: u32| along[axis].binary_search(&k).expect("every index is there") as u32;
            slot = index.iter().map(|&i| pair(i)).map(|[x, y]| [place(0, x), place(1, y)]).collect();
        }
        let levels = side.ilog2();
        let level_1d = |k: u32| Atom::from_flat(k as usize).level;
        let functions = along.each_ref().map(|along| Estimates::new(levels, along.iter().map(|&k| level_1d(k))));
        let by_level = match decomposition {
            Decomposition::Standard => Estimates::new(levels, index.iter().map(|&i| level_1d(pair(i)[0]))),
            Decomposition::Nonstandard => {
                Estimates::new(levels, index.iter().map(|&i| Atom::from_nonstandard(i as usize)[0].level))
            }
        };
        Self { index, value, along, slot, functions, by_level }
    }
}
