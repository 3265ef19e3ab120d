//! A light as every route wants it, prepared once and shared by all maps.

use super::PropagationScratch;
use super::cost::Estimates;
use super::lookups::PrimitiveTable;
use super::pixels::transpose;
use crate::affine::Atom;
use crate::error::check_length;
use crate::haar::{Decomposition, SparseVector, Transform2d};
use crate::{Error, Real, Result};

/// Coefficients of C channels of one image, with what the routes of a [`Propagation`](super::Propagation) need of them:
/// the terms, grouped; the pixels; a summed-area table.
///
/// Size: 4 + 4·C bytes a term, (sizeof T + 8)·C bytes a pixel. Changing a light
/// ([`set`](Self::set)) costs an inverse transform and a table.
#[derive(Debug, Clone)]
pub struct PropagationSource<T, const C: usize> {
    pub(super) side: usize,
    pub(super) decomposition: Decomposition,
    transform: Transform2d<T>,
    pub(super) terms: Terms<T, C>,
    /// C planes, transposed: pixel (x, y) at x·side + y.
    pub(super) pixels: Vec<T>,
    pub(super) table: PrimitiveTable<C>,
}

/// The terms of a source, by ascending flat index.
#[derive(Debug, Clone, Default)]
pub(super) struct Terms<T, const C: usize> {
    pub(super) index: Vec<u32>,
    pub(super) value: Vec<[T; C]>,
    /// Standard basis: the flat 1D indices that occur along x and along y, ascending.
    pub(super) along: [Vec<u32>; 2],
    /// Standard basis: where each term's pair of 1D indices lies in `along`.
    pub(super) slot: Vec<[u32; 2]>,
    /// Standard basis: where each flat 1D index lies in `along`.
    place: [Vec<u32>; 2],
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
        let mut source = Self::empty(side, decomposition)?;
        source.set(channels, &mut PropagationScratch::new());
        Ok(source)
    }

    /// As [`new`](Self::new), from dense coefficients; zeros are dropped.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_dense(side: usize, decomposition: Decomposition, channels: [&[T]; C]) -> Result<Self> {
        let mut source = Self::empty(side, decomposition)?;
        check_channels(side, channels)?;
        source.set_dense(channels, &mut PropagationScratch::new());
        Ok(source)
    }

    /// As [`new`](Self::new), from pixels, row-major: the coefficients are theirs, zeros are dropped.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::PropagationSource;
    /// use haarmonic::haar::Decomposition::Standard;
    /// let source = PropagationSource::from_pixels(2, Standard, [&[3.0, 3.0, 1.0, 1.0]])?;
    /// assert_eq!(source.terms(), 2); // the mean, and the difference of the rows
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn from_pixels(side: usize, decomposition: Decomposition, channels: [&[T]; C]) -> Result<Self> {
        let mut source = Self::empty(side, decomposition)?;
        check_channels(side, channels)?;
        source.set_pixels(channels, &mut PropagationScratch::new());
        Ok(source)
    }

    /// Becomes the light of other coefficients, with the bits of a [`new`](Self::new) one: for a light that is painted
    /// anew in every frame.
    ///
    /// Its own memory and the scratch grow to the most terms so far; after that nothing is allocated. Cost: an inverse
    /// transform and a summed-area table a channel, a merge of the channels' terms.
    ///
    /// # Panics
    /// If a channel's dense length is not `side`².
    #[track_caller]
    pub fn set(&mut self, channels: [&SparseVector<T>; C], scratch: &mut PropagationScratch<T>) {
        for (c, channel) in channels.into_iter().enumerate() {
            check_length("coefficients of a channel", self.side * self.side, channel.len());
            let [image, _] = self.room(scratch);
            image.fill(T::zero());
            channel.iter().for_each(|(i, value)| image[i] = value);
            self.set_channel(c, scratch);
        }
        self.terms.set(self.side, self.decomposition, channels.map(SparseVector::iter));
    }

    /// As [`set`](Self::set), from dense coefficients; zeros are dropped.
    ///
    /// # Panics
    /// As [`set`](Self::set).
    #[track_caller]
    pub fn set_dense(&mut self, channels: [&[T]; C], scratch: &mut PropagationScratch<T>) {
        for (c, channel) in channels.into_iter().enumerate() {
            check_length("coefficients of a channel", self.side * self.side, channel.len());
            let [image, _] = self.room(scratch);
            image.copy_from_slice(channel);
            self.set_channel(c, scratch);
        }
        self.terms.set(self.side, self.decomposition, channels.map(nonzero));
    }

    /// As [`set`](Self::set), from pixels, row-major, with the bits of [`from_pixels`](Self::from_pixels).
    ///
    /// # Panics
    /// As [`set`](Self::set), of pixels.
    #[track_caller]
    pub fn set_pixels(&mut self, channels: [&[T]; C], scratch: &mut PropagationScratch<T>) {
        let area = self.side * self.side;
        for (c, pixels) in channels.into_iter().enumerate() {
            check_length("pixels of a channel", area, pixels.len());
            self.table.set(c, pixels);
            transpose([self.side; 2], pixels, &mut self.pixels[c * area..][..area]);
        }
        scratch.result.resize(C * area, T::zero());
        let PropagationScratch { result, transform, .. } = scratch;
        transform.resize(self.transform.scratch_len(), T::zero());
        for (pixels, coefs) in channels.into_iter().zip(result.chunks_exact_mut(area)) {
            self.transform.forward(pixels, coefs, transform);
        }
        let coefs = std::array::from_fn(|c| nonzero(&result[c * area..][..area]));
        self.terms.set(self.side, self.decomposition, coefs);
    }

    /// A light without terms.
    fn empty(side: usize, decomposition: Decomposition) -> Result<Self> {
        super::check_side(side)?;
        Ok(Self {
            side,
            decomposition,
            transform: Transform2d::new(side, side, decomposition)?,
            terms: Terms::default(),
            pixels: vec![T::zero(); C * side * side],
            table: PrimitiveTable::new(side),
        })
    }

    /// An image and the memory of a transform.
    fn room<'a>(&self, scratch: &'a mut PropagationScratch<T>) -> [&'a mut [T]; 2] {
        scratch.result.resize(self.side * self.side, T::zero());
        scratch.transform.resize(self.transform.scratch_len(), T::zero());
        [&mut scratch.result, &mut scratch.transform]
    }

    /// The pixels and the table of a channel, whose coefficients are in the scratch.
    fn set_channel(&mut self, c: usize, scratch: &mut PropagationScratch<T>) {
        let area = self.side * self.side;
        let [image, memory] = self.room(scratch);
        self.transform.inverse_in_place(image, memory);
        self.table.set(c, image);
        transpose([self.side; 2], image, &mut self.pixels[c * area..][..area]);
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

    /// Standard basis: the flat 1D indices that occur along x and along y, ascending.
    #[allow(dead_code, reason = "for those back ends that couple terms themselves")]
    pub(crate) fn along(&self) -> &[Vec<u32>; 2] {
        &self.terms.along
    }

    /// Standard basis: of every term where its pair of 1D indices lies in [`along`](Self::along), and its channels.
    #[allow(dead_code, reason = "for those back ends that couple terms themselves")]
    pub(crate) fn placed_terms(&self) -> impl Iterator<Item = ([u32; 2], [T; C])> + '_ {
        self.terms.slot.iter().copied().zip(self.terms.value.iter().copied())
    }

    /// How many basis functions have a term in some channel.
    #[inline]
    pub fn terms(&self) -> usize {
        self.terms.index.len()
    }
}

fn check_channels<T, const C: usize>(side: usize, channels: [&[T]; C]) -> Result<()> {
    match channels.into_iter().find(|channel| channel.len() != side * side) {
        Some(channel) => {
            let (expected, got) = (side * side, channel.len());
            Err(Error::Length { what: "coefficients of a channel", expected, got })
        }
        None => Ok(()),
    }
}

/// What is not zero, with its index.
fn nonzero<T: Real>(coefs: &[T]) -> impl Iterator<Item = (usize, T)> + '_ {
    coefs.iter().copied().enumerate().filter(|(_, value)| *value != T::zero())
}

impl<T: Real, const C: usize> Terms<T, C> {
    /// The terms of channels that give theirs by ascending index, in the memory that is there.
    fn set<I>(&mut self, side: usize, decomposition: Decomposition, channels: [I; C])
    where
        I: Iterator<Item = (usize, T)>,
    {
        self.index.clear();
        self.value.clear();
        let mut channels = channels.map(Iterator::peekable);
        while let Some(next) = channels.iter_mut().filter_map(|c| c.peek().map(|&(i, _)| i)).min() {
            let value = channels.each_mut().map(|c| c.next_if(|&(i, _)| i == next).map_or(T::zero(), |(_, v)| v));
            self.index.push(next as u32);
            self.value.push(value);
        }
        let level_1d = |k: usize| Atom::from_flat(k).level;
        let pair = |i: u32| [i as usize & (side - 1), i as usize >> side.ilog2()];
        if decomposition == Decomposition::Nonstandard {
            let level = |&i: &u32| Atom::from_nonstandard(i as usize)[0].level;
            self.by_level = Estimates::new(self.index.iter().map(level));
            return;
        }
        for axis in 0..2 {
            let (along, place) = (&mut self.along[axis], &mut self.place[axis]);
            place.clear();
            place.resize(side, ABSENT);
            self.index.iter().for_each(|&i| place[pair(i)[axis]] = 0);
            along.clear();
            for (k, place) in place.iter_mut().enumerate().filter(|(_, place)| **place != ABSENT) {
                *place = along.len() as u32;
                along.push(k as u32);
            }
            self.functions[axis] = Estimates::new(along.iter().map(|&k| level_1d(k as usize)));
        }
        self.slot.clear();
        let place = &self.place;
        self.slot.extend(self.index.iter().map(|&i| pair(i)).map(|[x, y]| [place[0][x], place[1][y]]));
        self.by_level = Estimates::new(self.index.iter().map(|&i| level_1d(pair(i)[0])));
    }
}

/// The place of a function that has no term.
const ABSENT: u32 = u32::MAX;
