//! The order in which the pixels of a map are taken.

use crate::error::check_length;
use crate::{Error, Result};

/// A path through the pixels of a map.
///
/// On 16 × 16 blocks behind half-planes and discs, paths of neighbours save two changes in five (docs/compress.md).
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum ScanOrder {
    /// Row by row, each from the left.
    #[default]
    RowMajor,
    /// Row by row, every second from the right: each pixel is a neighbour of the one before it.
    Serpentine,
    /// Hilbert's curve, from the top left to the top right: neighbours, and any stretch of the path is a compact
    /// region. Squares of 2^k a side.
    Hilbert,
}

/// A [`ScanOrder`] of one size, planned once.
///
/// # Example
/// ```
/// use haarmonic::compress::{Scan, ScanOrder};
/// let scan = Scan::new(ScanOrder::Serpentine, 2, 2)?;
/// assert_eq!(scan.pixels(), [0, 1, 3, 2]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Scan {
    order: ScanOrder,
    pixels: Vec<u32>,
    is_row_major: bool,
}

impl Scan {
    /// Plans the path through `width` × `height` pixels.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless there are from 1 to 2³² pixels; for Hilbert's curve [`Error::NotPowerOfTwo`] unless
    /// the width is one, [`Error::Length`] unless the height is the same.
    pub fn new(order: ScanOrder, width: usize, height: usize) -> Result<Self> {
        let len = width.checked_mul(height).filter(|&len| len > 0 && len as u64 <= 1 << 32);
        let Some(len) = len else {
            let got = width as f64 * height as f64;
            return Err(Error::OutOfRange { what: "pixels of a map", got, allowed: "from 1 to 2^32" });
        };
        if order == ScanOrder::Hilbert {
            if !width.is_power_of_two() {
                return Err(Error::NotPowerOfTwo { what: "side of a Hilbert curve", got: width });
            }
            if width != height {
                return Err(Error::Length { what: "height of a Hilbert curve", expected: width, got: height });
            }
        }
        let pixel = |i: usize| match order {
            ScanOrder::RowMajor => i,
            ScanOrder::Serpentine if i / width % 2 == 1 => i / width * width + (width - 1 - i % width),
            ScanOrder::Serpentine => i,
            ScanOrder::Hilbert => hilbert(width, i),
        };
        let is_row_major = order == ScanOrder::RowMajor;
        Ok(Self { order, pixels: (0..len).map(|i| pixel(i) as u32).collect(), is_row_major })
    }

    /// The same path turned about the diagonal: down columns where [`new`](Self::new) goes along rows.
    ///
    /// An edge that is nearly level changes a path along rows in few places, one that is nearly upright a path down
    /// columns: the better of two serpentines has half the changes of either, and little more than half of Hilbert's
    /// curve's (docs/block_product.md).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn turned(order: ScanOrder, width: usize, height: usize) -> Result<Self> {
        let Self { mut pixels, .. } = Self::new(order, height, width)?;
        for pixel in &mut pixels {
            let (x, y) = (*pixel as usize / height, *pixel as usize % height);
            *pixel = (y * width + x) as u32;
        }
        Ok(Self { order, pixels, is_row_major: false })
    }

    /// The order of the path.
    #[inline]
    pub fn order(&self) -> ScanOrder {
        self.order
    }

    /// The row-major pixel at each place of the path.
    #[inline]
    pub fn pixels(&self) -> &[u32] {
        &self.pixels
    }

    /// An image along the path: `out[i] = image[pixels[i]]`.
    ///
    /// # Panics
    /// If a length is not the number of pixels.
    #[track_caller]
    pub fn apply<T: Copy>(&self, image: &[T], out: &mut [T]) {
        check_length("pixels", self.pixels.len(), image.len());
        check_length("path", self.pixels.len(), out.len());
        if self.is_row_major {
            return out.copy_from_slice(image);
        }
        for (out, &pixel) in out.iter_mut().zip(&self.pixels) {
            *out = image[pixel as usize];
        }
    }

    /// Back from the path: `image[pixels[i]] = path[i]`.
    ///
    /// # Panics
    /// As [`apply`](Self::apply).
    #[track_caller]
    pub fn undo<T: Copy>(&self, path: &[T], image: &mut [T]) {
        check_length("path", self.pixels.len(), path.len());
        check_length("pixels", self.pixels.len(), image.len());
        for (value, &pixel) in path.iter().zip(&self.pixels) {
            image[pixel as usize] = *value;
        }
    }

    /// [`apply`](Self::apply) to bits, in the order of
    /// [`CodedBinaryMaps::push_bits`](crate::compress::CodedBinaryMaps::push_bits): pixel i is bit i mod 64 of word i /
    /// 64.
    ///
    /// # Panics
    /// If a length is not ⌈pixels/64⌉.
    #[track_caller]
    pub fn apply_bits(&self, image: &[u64], out: &mut [u64]) {
        let words = self.pixels.len().div_ceil(64);
        check_length("words of pixels", words, image.len());
        check_length("words of the path", words, out.len());
        if self.is_row_major {
            return out.copy_from_slice(image);
        }
        for (out, pixels) in out.iter_mut().zip(self.pixels.chunks(64)) {
            let bit = |pixel: u32| image[pixel as usize / 64] >> (pixel % 64) & 1;
            *out = pixels.iter().rev().fold(0, |word, &pixel| word << 1 | bit(pixel));
        }
    }
}

/// The row-major pixel at place `i` of the curve on `side`².
///
/// From the finest digits of i in base 4 to the coarsest: the quadrants are visited in the order (0,0), (0,1), (1,1),
/// (1,0) of (x, y), the curve in the first transposed and in the last transposed about the other diagonal, so that ends
/// meet.
fn hilbert(side: usize, i: usize) -> usize {
    let (mut x, mut y, mut rest, mut size) = (0, 0, i, 1);
    while size < side {
        let (right, low) = (rest / 2 % 2, (rest ^ (rest / 2)) % 2);
        if low == 0 {
            if right == 1 {
                (x, y) = (size - 1 - x, size - 1 - y);
            }
            (x, y) = (y, x);
        }
        x += right * size;
        y += low * size;
        rest /= 4;
        size *= 2;
    }
    y * side + x
}
