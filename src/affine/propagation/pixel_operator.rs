//! The affine map of an image in the pixel basis: exact areas, no transform.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::band::{Band, Weights};
use super::pixels::{transpose, transpose_part};
use super::{Axis, check_side};
use crate::affine::{AffineMap, Parameter};
use crate::error::check_length;
use crate::{Real, Result};

/// L(x, y) = F(s_x x + o_x, s_y y + o_y) of an image in pixels: its mean over each target pixel, by exact areas of
/// overlap.
///
/// These are the couplings of the pixel basis, a band of weights along each axis. Whatever is met by L in the end may
/// just as well be met here: by Parseval ⟨L, T⟩ is the same sum in pixels as in wavelets, and no transform is needed
/// for it. [`inner_products`](Self::inner_products) goes one step further and carries T to the source, once for all
/// channels.
///
/// Shapes: source images are row by row, pixel (x, y) at y·`source_side` + x; target images are column by column, (x,
/// y) at x·`side` + y, so that both passes run along memory. F is 0 outside [0, 1)².
///
/// Cost: 2 (⌈s⌉ + 1) `side` · (`side` + `source_side`) multiply-adds at most, fewer where the light is small. After
/// [`set`](Self::set) has seen its largest s nothing is allocated.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, PixelOperator};
/// let mut operator = PixelOperator::new(2, 2)?;
/// operator.set([AffineMap::new(0.5, 0.5)?, AffineMap::IDENTITY]); // the right half
/// let mut seen = [0.0; 4];
/// operator.apply(&[0.0, 4.0, 0.0, 8.0], &mut seen);
/// assert_eq!(seen, [4.0, 8.0, 4.0, 8.0]); // column by column
/// assert_eq!(operator.inner_products([&[0.0, 4.0, 0.0, 8.0]], &[1.0, 0.0, 0.0, 10.0]), [4.0 + 80.0]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct PixelOperator<T> {
    /// Of the source and of the target.
    sides: [usize; 2],
    bands: [Band<T>; 2],
    /// Two planes of the larger side.
    planes: [Vec<T>; 2],
    arch: Arch,
}

impl<T: Real> PixelOperator<T> {
    /// An operator from `source_side`² to `side`² pixels that shows nothing until it is [`set`](Self::set).
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`](crate::Error::NotPowerOfTwo) unless both are,
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) above 4096.
    pub fn new(source_side: usize, side: usize) -> Result<Self> {
        check_side(source_side)?;
        check_side(side)?;
        let area = source_side.max(side).pow(2);
        let planes = [(); 2].map(|()| vec![T::zero(); area]);
        Ok(Self { sides: [source_side, side], bands: [Band::new(), Band::new()], planes, arch: Arch::new() })
    }

    /// The side of target images.
    #[inline]
    pub fn side(&self) -> usize {
        self.sides[1]
    }

    /// The side of source images.
    #[inline]
    pub fn source_side(&self) -> usize {
        self.sides[0]
    }

    /// Becomes the operator of a pair of maps, x first.
    pub fn set(&mut self, maps: [AffineMap; 2]) {
        self.set_weights(maps, [Weights::Value; 2]);
    }

    /// Becomes the derivative of that operator in the scale or offset of one axis, right-hand where it has a kink.
    pub fn set_derivative(&mut self, (axis, parameter): (Axis, Parameter), maps: [AffineMap; 2]) {
        let mut weights = [Weights::Value; 2];
        weights[axis as usize] = Weights::Slope(parameter);
        self.set_weights(maps, weights);
    }

    fn set_weights(&mut self, maps: [AffineMap; 2], weights: [Weights; 2]) {
        let (sides, bands) = (self.sides, &mut self.bands);
        self.arch.dispatch(Set { sides, maps, weights, bands });
    }

    /// L of one channel.
    ///
    /// # Panics
    /// If a length is not the square of its side.
    #[track_caller]
    pub fn apply(&mut self, source: &[T], out: &mut [T]) {
        self.check(source, out);
        let Self { sides, bands, planes, arch } = self;
        arch.dispatch(Apply { sides: *sides, bands, planes, source, out });
    }

    /// The transpose of [`apply`](Self::apply): ⟨apply(F), g⟩ = ⟨F, adjoint(g)⟩.
    ///
    /// # Panics
    /// As [`apply`](Self::apply).
    #[track_caller]
    pub fn adjoint(&mut self, cotangent: &[T], out: &mut [T]) {
        self.check(out, cotangent);
        let Self { sides, bands, planes, arch } = self;
        arch.dispatch(AdjointImage { adjoint: Adjoint { sides: *sides, bands, planes, cotangent }, out });
    }

    /// ⟨L_c, g⟩ of all channels, one target image g for all: sums of products of pixels.
    ///
    /// # Panics
    /// As [`apply`](Self::apply).
    #[track_caller]
    pub fn inner_products<const C: usize>(&mut self, sources: [&[T]; C], cotangent: &[T]) -> [T; C] {
        for source in sources {
            self.check(source, cotangent);
        }
        let Self { sides, bands, planes, arch } = self;
        arch.dispatch(InnerProducts { adjoint: Adjoint { sides: *sides, bands, planes, cotangent }, sources })
    }

    #[track_caller]
    fn check(&self, source: &[T], target: &[T]) {
        check_length("pixels of the source", self.sides[0].pow(2), source.len());
        check_length("pixels of the target", self.sides[1].pow(2), target.len());
    }
}

struct Set<'a, T> {
    sides: [usize; 2],
    maps: [AffineMap; 2],
    weights: [Weights; 2],
    bands: &'a mut [Band<T>; 2],
}

impl<T: Real> WithSimd for Set<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for axis in 0..2 {
            self.bands[axis].set(self.sides[0], self.sides[1], self.maps[axis], self.weights[axis]);
        }
    }
}

struct Apply<'a, T> {
    sides: [usize; 2],
    bands: &'a [Band<T>; 2],
    planes: &'a mut [Vec<T>; 2],
    source: &'a [T],
    out: &'a mut [T],
}

impl<T: Real> WithSimd for Apply<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { sides: [from, side], bands, planes: [first, second], source, out } = self;
        let half = side * from;
        bands[1].combine(from, source, &mut first[..half]);
        transpose([side, from], &first[..half], &mut second[..half]);
        bands[0].combine(side, &second[..half], out);
    }
}

/// What an image of the target becomes in the source.
struct Adjoint<'a, T> {
    sides: [usize; 2],
    bands: &'a [Band<T>; 2],
    planes: &'a mut [Vec<T>; 2],
    cotangent: &'a [T],
}

/// Pixels that are worked on together.
const LANES: usize = 8;

/// A range, and to where whole groups of lanes take it.
#[inline(always)]
fn whole(range: Range<usize>, side: usize) -> Range<usize> {
    let step = LANES.min(side);
    range.start / step * step..range.end.next_multiple_of(step)
}

impl<'a, T: Real> Adjoint<'a, T> {
    /// The adjoint, row by row, and the rows and columns in which it is; elsewhere it is 0 and was not written.
    #[inline(always)]
    fn run(self) -> (&'a [T], [Range<usize>; 2]) {
        let Self { sides: [from, side], bands: [along_x, along_y], planes: [first, second], cotangent } = self;
        let (columns, rows) = (whole(along_x.reached(from), from), along_y.reached(from));
        if columns.is_empty() || rows.is_empty() {
            return (&[], [0..0, 0..0]);
        }
        // Columns of the source by rows of the target; transposed; rows of the source.
        let seen = whole(along_y.active(), side);
        along_x.scatter(columns.clone(), seen.clone(), side, cotangent, first);
        transpose_part([columns.clone(), seen], [side, from], first, second);
        along_y.scatter(rows.clone(), columns.clone(), from, second, first);
        (first, [rows, columns])
    }
}

struct AdjointImage<'a, T> {
    adjoint: Adjoint<'a, T>,
    out: &'a mut [T],
}

impl<T: Real> WithSimd for AdjointImage<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let (width, out) = (self.adjoint.sides[0], self.out);
        let (image, [rows, columns]) = self.adjoint.run();
        out.fill(T::zero());
        for y in rows {
            let part = y * width + columns.start..y * width + columns.end;
            out[part.clone()].copy_from_slice(&image[part]);
        }
    }
}

struct InnerProducts<'a, T, const C: usize> {
    adjoint: Adjoint<'a, T>,
    sources: [&'a [T]; C],
}

impl<T: Real, const C: usize> WithSimd for InnerProducts<'_, T, C> {
    type Output = [T; C];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [T; C] {
        let width = self.adjoint.sides[0];
        let (image, [rows, columns]) = self.adjoint.run();
        let mut lanes = [[T::zero(); LANES]; C];
        let mut rest = [T::zero(); C];
        for y in rows {
            let part = y * width + columns.start..y * width + columns.end;
            let (image, image_rest) = image[part.clone()].as_chunks::<LANES>();
            for c in 0..C {
                let (source, source_rest) = self.sources[c][part.clone()].as_chunks::<LANES>();
                for (f, g) in source.iter().zip(image) {
                    for k in 0..LANES {
                        lanes[c][k] += f[k] * g[k];
                    }
                }
                rest[c] += source_rest.iter().zip(image_rest).map(|(&f, &g)| f * g).sum();
            }
        }
        std::array::from_fn(|c| lanes[c].iter().copied().sum::<T>() + rest[c])
    }
}
