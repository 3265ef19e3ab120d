//! Building visibility distance tables.

use pulp::{Arch, Simd, WithSimd};

use super::binary_map::BinaryMap;
use super::distance_rows::{Buffers, FromSquare, Ring};
use crate::error::check_length;
use crate::numeric::align_stack;
use crate::{Error, Result, parallel};

/// Whether the border of a map is a boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Border {
    /// It is no boundary: nothing is known of what is outside.
    #[default]
    Open,
    /// Pixels outside are 0: the border is a boundary of every 1 that touches it. Changes the distances of 1-pixels
    /// only.
    Zero,
}

/// Scratch memory of [`VisibilityDistancePlan`]; it grows once, to some three bytes a pixel.
#[derive(Debug, Clone, Default)]
pub struct VisibilityDistanceScratch {
    buffers: Buffers,
}

/// How to build visibility distance tables of one map size: exact signed Euclidean distances, one map or many.
/// ```math
/// D = ±d, + where the map is 1; d from a pixel's centre to the nearest boundary of 0 and 1          [Xu 2006 §4.3]
/// ```
///
/// The boundary runs along the sides of pixels, so that d is the distance to the closed unit square of the nearest
/// unlike pixel: next to a straight edge ½, 1½, … (distances between centres would be 1, 2, …, and off by a half on
/// both sides). A map without boundary has D = ±[`bound`](Self::bound), the diagonal √(width² + height²), which no
/// distance reaches.
///
/// Shapes: row-major, width·height. Units: pixels ([`distances`](Self::distances)), or (2d)², integers that are exact
/// ([`squares`](Self::squares)).
/// Accuracy: exact; distances are the exact ones rounded to `f32`. The same bits on every machine.
/// Cost: linear in the pixels, whatever the map.
///
/// # Example
/// ```
/// # fn main() -> Result<(), haarmonic::Error> {
/// use haarmonic::table::{Border, VisibilityDistancePlan};
/// let plan = VisibilityDistancePlan::new(4, 1, Border::Open)?;
/// let mut table = [0.0; 4];
/// plan.distances([1_u8, 1, 1, 0][..].into(), &mut table, &mut Default::default());
/// assert_eq!(table, [2.5, 1.5, 0.5, -0.5]);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct VisibilityDistancePlan {
    width: usize,
    height: usize,
    border: Border,
    arch: Arch,
}

impl VisibilityDistancePlan {
    /// Plans tables of `width` × `height` maps; either may be 0.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 4(width² + height²) fits 31 bits: 16383 a side if square.
    pub fn new(width: usize, height: usize, border: Border) -> Result<Self> {
        let longest = width.max(height);
        let square = |n: usize| 4 * (n as u64).pow(2);
        if longest > 16_384 || square(width) + square(height) > i32::MAX as u64 {
            let allowed = "such that 4(width^2 + height^2) < 2^31, and no side above 16384";
            return Err(Error::OutOfRange { what: "side of a distance table", got: longest as f64, allowed });
        }
        Ok(Self { width, height, border, arch: Arch::new() })
    }

    /// The width of a map.
    #[inline]
    pub fn width(&self) -> usize {
        self.width
    }

    /// The height of a map.
    #[inline]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Whether the border is a boundary.
    #[inline]
    pub fn border(&self) -> Border {
        self.border
    }

    /// The number of pixels of a map.
    #[inline]
    #[expect(clippy::len_without_is_empty, reason = "a size, not a container")]
    pub fn len(&self) -> usize {
        self.width * self.height
    }

    /// |D| of a map without boundary: its diagonal, in pixels.
    #[inline]
    pub fn bound(&self) -> f32 {
        f32::of(self.square_bound())
    }

    /// (2D)² of a map without boundary: 4(width² + height²).
    #[inline]
    pub fn square_bound(&self) -> i32 {
        (4 * (self.width * self.width + self.height * self.height)) as i32
    }

    /// Signed squares ±(2d)² of a map, or of as many one after another as `out` holds.
    ///
    /// # Panics
    /// If `out.len()` is not a multiple of [`len`](Self::len), or `maps` is not as many maps (see [`BinaryMap`] for
    /// their lengths).
    #[track_caller]
    pub fn squares(&self, maps: BinaryMap<'_>, out: &mut [i32], scratch: &mut VisibilityDistanceScratch) {
        self.run(maps, out, scratch);
    }

    /// Signed distances in pixels of a map, or of as many one after another as `out` holds.
    ///
    /// # Panics
    /// As [`squares`](Self::squares).
    #[track_caller]
    pub fn distances(&self, maps: BinaryMap<'_>, out: &mut [f32], scratch: &mut VisibilityDistanceScratch) {
        self.run(maps, out, scratch);
    }

    /// [`squares`](Self::squares) on all threads (feature `rayon`; on one without it), for many maps. The same bits.
    ///
    /// # Panics
    /// As [`squares`](Self::squares).
    #[track_caller]
    pub fn squares_parallel(&self, maps: BinaryMap<'_>, out: &mut [i32]) {
        self.run_parallel(maps, out);
    }

    /// [`distances`](Self::distances) on all threads, as [`squares_parallel`](Self::squares_parallel).
    ///
    /// # Panics
    /// As [`squares`](Self::squares).
    #[track_caller]
    pub fn distances_parallel(&self, maps: BinaryMap<'_>, out: &mut [f32]) {
        self.run_parallel(maps, out);
    }

    #[track_caller]
    fn run<O: FromSquare>(&self, maps: BinaryMap<'_>, out: &mut [O], scratch: &mut VisibilityDistanceScratch) {
        let count = self.count(&maps, out.len());
        scratch.buffers.resize(self.width, self.height);
        let ring = match self.border {
            Border::Open => Ring::Open,
            Border::Zero => Ring::Zero,
        };
        let (width, bound, buffers) = (self.width, self.square_bound(), &mut scratch.buffers);
        if count > 0 {
            self.arch.dispatch(Maps { width, ring, bound, maps, out, len: self.len(), buffers });
        }
    }

    #[track_caller]
    fn run_parallel<O: FromSquare>(&self, maps: BinaryMap<'_>, out: &mut [O]) {
        self.count(&maps, out.len());
        if out.is_empty() {
            return;
        }
        // Some 16 Ki pixels a task.
        let some = ((1 << 14) / self.len()).max(1);
        parallel::chunks(out, some * self.len(), VisibilityDistanceScratch::default, |k, out, scratch| {
            self.run(maps.part(self.len(), k * some, out.len() / self.len()), out, scratch);
        });
    }

    /// The number of maps.
    #[track_caller]
    fn count(&self, maps: &BinaryMap<'_>, out: usize) -> usize {
        if self.len() == 0 {
            check_length("distances", 0, out);
        } else if out % self.len() != 0 {
            crate::error::length_mismatch("distances, a multiple of", self.len(), out);
        }
        let count = out.checked_div(self.len()).unwrap_or(0);
        if let Err(Error::Length { what, expected, got }) = maps.length_error(self.len(), count) {
            crate::error::length_mismatch(what, expected, got);
        }
        count
    }
}

struct Maps<'a, O> {
    width: usize,
    len: usize,
    ring: Ring,
    bound: i32,
    maps: BinaryMap<'a>,
    out: &'a mut [O],
    buffers: &'a mut Buffers,
}

impl<O: FromSquare> WithSimd for Maps<'_, O> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        align_stack();
        for (k, out) in self.out.chunks_exact_mut(self.len).enumerate() {
            let map = self.maps.part(self.len, k, 1);
            self.buffers.downwards(self.width, self.len / self.width, self.ring, map);
            self.buffers.upwards(self.width, self.ring, map, out, self.bound);
        }
    }
}
