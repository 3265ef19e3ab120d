//! The transform of square blocks.

use pulp::{Arch, Simd, WithSimd};

use super::kernels::{self, Pass, Work};
use super::tables::Tables;
use crate::error::{check_length, length_mismatch};
use crate::numeric::align_stack;
use crate::{Error, Real, Result, parallel};

/// Where the samples of the blocks are. Coefficients always lie block after block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Layout {
    /// Block after block, each row-major.
    Blocks,
    /// Tiles of an image, in row-major order of tiles.
    Tiles { width: usize, stride: usize },
}

/// Orthonormal DCT-II of square blocks and its inverse (DCT-III), planned once, applied to batches.
/// ```math
/// C_vu = Σ_yx f_yx c_v(y) c_u(x),   c_u(x) = √((2 − δ_u0)/n) cos((2x + 1)uπ/2n)
/// ```
///
/// The basis that [Inger 2013, §4.1] means: the cosines printed in eq. 4 are not a basis (docs/errata.md). Orthonormal
/// over the samples, so Σ f g = Σ C_f C_g ([`product_integral`](crate::dct::product_integral)) and a constant block has
/// the one coefficient C_00 = n · value.
///
/// Shapes: coefficients block after block, row-major, C_vu at `v·low + u`; `low` = n for whole transforms. Samples of
/// [`new`](Self::new) block after block, row-major; of [`tiles`](Self::tiles), the image's.
/// Accuracy: each coefficient to a few ε of the block's norm √Σ f², and back.
/// Cost: n = 16 takes 21 multiplications a sample, its 4 × 4 lowest 2.3.
/// The same bits on every machine, alone, in a batch, tiled or on any number of threads.
///
/// # Example
/// ```
/// # fn main() -> Result<(), haarmonic::Error> {
/// let plan = haarmonic::dct::BlockDct::<f64>::new(16)?;
/// let block: Vec<f64> = (0..256).map(|i| f64::from(i % 16)).collect();
/// let mut coefs = vec![0.0; 256];
/// plan.forward(&block, &mut coefs);
/// assert!((coefs[0] - 16.0 * 7.5).abs() < 1e-12);
/// let energy = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
/// assert!((energy(&coefs) / energy(&block) - 1.0).abs() < 1e-14);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct BlockDct<T> {
    side: usize,
    layout: Layout,
    tables: Tables<T>,
    arch: Arch,
}

/// Columns that are worked on at a time: a register of AVX2.
fn lanes<T: Real>(side: usize) -> usize {
    side.min(32 / size_of::<T>())
}

/// What a batch does.
#[derive(Clone, Copy)]
enum Data<'a, T> {
    Forward(&'a [T]),
    Inverse(&'a [T]),
}

impl<T: Real> BlockDct<T> {
    /// Plans transforms of blocks that lie one after another.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `side` is one; [`Error::OutOfRange`] unless it is from 4 to 64.
    pub fn new(side: usize) -> Result<Self> {
        if !side.is_power_of_two() {
            return Err(Error::NotPowerOfTwo { what: "block side", got: side });
        }
        if !(4..=64).contains(&side) {
            return Err(Error::OutOfRange { what: "block side", got: side as f64, allowed: "4, 8, 16, 32 or 64" });
        }
        Ok(Self { side, layout: Layout::Blocks, tables: Tables::new(side, lanes::<T>(side)), arch: Arch::new() })
    }

    /// Plans transforms of the tiles of an image `width` samples wide, whose rows start `stride` samples apart, in
    /// row-major order of tiles. Six faces of a cube map one below another are such an image; so is a slice that starts
    /// inside a larger one.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`Error::OutOfRange`] unless `width` is a positive multiple of `side`, and `stride` at
    /// least `width`.
    pub fn tiles(side: usize, width: usize, stride: usize) -> Result<Self> {
        let plan = Self::new(side)?;
        if width == 0 || width % side != 0 {
            let allowed = "a positive multiple of the block side";
            return Err(Error::OutOfRange { what: "width of a tiled image", got: width as f64, allowed });
        }
        if stride < width || stride.checked_mul(side).is_none() {
            let allowed = "at least the width, and addressable";
            return Err(Error::OutOfRange { what: "stride of a tiled image", got: stride as f64, allowed });
        }
        Ok(Self { layout: Layout::Tiles { width, stride }, ..plan })
    }

    /// The side n of a block.
    #[inline]
    pub fn side(&self) -> usize {
        self.side
    }

    /// The number of samples of a block: n².
    #[inline]
    #[expect(clippy::len_without_is_empty, reason = "a plan's length is never 0")]
    pub fn len(&self) -> usize {
        self.side * self.side
    }

    /// Samples → all coefficients of any number of blocks.
    ///
    /// # Panics
    /// If `coefs.len()` is not a number of blocks times n² (for tiles: of whole rows of tiles), or `samples` is not as
    /// long as they need: the same length for blocks; for tiles `stride` a row, where the last may end after `width`.
    #[track_caller]
    pub fn forward(&self, samples: &[T], coefs: &mut [T]) {
        self.forward_low(self.side, samples, coefs);
    }

    /// All coefficients → samples of any number of blocks. Between the tiles, samples stay as they are.
    ///
    /// # Panics
    /// As [`forward`](Self::forward).
    #[track_caller]
    pub fn inverse(&self, coefs: &[T], samples: &mut [T]) {
        self.inverse_low(self.side, coefs, samples);
    }

    /// Samples → the `low` × `low` coefficients of lowest frequency of each block, without the others.
    ///
    /// # Panics
    /// If `low` is 0 or above n, or the lengths do not fit as in [`forward`](Self::forward), with `low`² a block.
    #[track_caller]
    pub fn forward_low(&self, low: usize, samples: &[T], coefs: &mut [T]) {
        self.check(low, samples.len(), coefs.len());
        self.run(low, Data::Forward(samples), coefs);
    }

    /// `low` × `low` coefficients of each block, the others being 0 → samples.
    ///
    /// # Panics
    /// As [`forward_low`](Self::forward_low).
    #[track_caller]
    pub fn inverse_low(&self, low: usize, coefs: &[T], samples: &mut [T]) {
        self.check(low, samples.len(), coefs.len());
        self.run(low, Data::Inverse(coefs), samples);
    }

    /// [`forward_low`](Self::forward_low) on all threads (feature `rayon`; on one without it), for big batches. The
    /// same bits.
    ///
    /// # Panics
    /// As [`forward_low`](Self::forward_low).
    #[track_caller]
    pub fn forward_low_parallel(&self, low: usize, samples: &[T], coefs: &mut [T]) {
        self.check(low, samples.len(), coefs.len());
        let [samples_each, coefs_each] = self.task(low);
        parallel::chunks(
            coefs,
            coefs_each,
            || (),
            |k, coefs, ()| {
                self.run(low, Data::Forward(chunk_of(samples, k, samples_each)), coefs);
            },
        );
    }

    /// [`inverse_low`](Self::inverse_low) on all threads, as [`forward_low_parallel`](Self::forward_low_parallel).
    ///
    /// # Panics
    /// As [`forward_low`](Self::forward_low).
    #[track_caller]
    pub fn inverse_low_parallel(&self, low: usize, coefs: &[T], samples: &mut [T]) {
        self.check(low, samples.len(), coefs.len());
        let [samples_each, coefs_each] = self.task(low);
        parallel::chunks(
            samples,
            samples_each,
            || (),
            |k, samples, ()| {
                self.run(low, Data::Inverse(chunk_of(coefs, k, coefs_each)), samples);
            },
        );
    }

    /// Samples and coefficients of a task: some 64 KiB, or one row of tiles.
    fn task(&self, low: usize) -> [usize; 2] {
        match self.layout {
            Layout::Blocks => [self.len(), low * low].map(|each| each * ((1 << 14) / self.len()).max(1)),
            Layout::Tiles { width, stride } => [self.side * stride, width / self.side * low * low],
        }
    }

    #[track_caller]
    fn check(&self, low: usize, samples: usize, coefs: usize) {
        if low == 0 || low > self.side {
            length_mismatch("frequencies kept on an axis (from 1 to the block side)", self.side, low);
        }
        let each = low * low;
        match self.layout {
            Layout::Blocks => {
                let blocks = coefs / each;
                check_length("coefficients of whole blocks", blocks * each, coefs);
                check_length("samples", blocks * self.len(), samples);
            }
            Layout::Tiles { width, stride } => {
                let each = width / self.side * each;
                let rows = coefs / each * self.side;
                check_length("coefficients of whole rows of tiles", coefs / each * each, coefs);
                let shortest = rows.saturating_sub(1) * stride + if rows == 0 { 0 } else { width };
                if samples < shortest || samples > rows * stride {
                    length_mismatch("samples of a tiled image", rows * stride, samples);
                }
            }
        }
    }

    /// A dispatch for each side, so that each is a function of its own.
    fn run(&self, low: usize, input: Data<'_, T>, output: &mut [T]) {
        match (self.side, lanes::<T>(self.side)) {
            (4, _) => self.run_side::<4, 4>(low, input, output),
            (8, 8) => self.run_side::<8, 8>(low, input, output),
            (8, _) => self.run_side::<8, 4>(low, input, output),
            (16, 8) => self.run_side::<16, 8>(low, input, output),
            (16, _) => self.run_side::<16, 4>(low, input, output),
            (32, 8) => self.run_side::<32, 8>(low, input, output),
            (32, _) => self.run_side::<32, 4>(low, input, output),
            (_, 8) => self.run_side::<64, 8>(low, input, output),
            _ => self.run_side::<64, 4>(low, input, output),
        }
    }

    fn run_side<const N: usize, const L: usize>(&self, low: usize, input: Data<'_, T>, output: &mut [T]) {
        match input {
            Data::Forward(samples) => {
                self.arch.dispatch(Forward::<T, N, L> { plan: self, low, samples, coefs: output })
            }
            Data::Inverse(coefs) => self.arch.dispatch(Inverse::<T, N, L> { plan: self, low, coefs, samples: output }),
        }
    }

    /// Where block number `index` starts among the samples, and the distance of its rows.
    #[inline(always)]
    fn place(&self, index: usize) -> (usize, usize) {
        match self.layout {
            Layout::Blocks => (index * self.side * self.side, self.side),
            Layout::Tiles { width, stride } => {
                let across = width / self.side;
                (index / across * self.side * stride + index % across * self.side, stride)
            }
        }
    }
}

/// A batch of blocks of side N, L columns at a time; the lengths are checked.
struct Forward<'a, T, const N: usize, const L: usize> {
    plan: &'a BlockDct<T>,
    low: usize,
    samples: &'a [T],
    coefs: &'a mut [T],
}

impl<T: Real, const N: usize, const L: usize> Forward<'_, T, N, L> {
    #[inline(always)]
    fn run(self, low: usize) {
        let Self { plan, samples, coefs, .. } = self;
        let mut work = Work::<T, N, L>::new();
        for (index, coefs) in coefs.chunks_exact_mut(low * low).enumerate() {
            let (start, stride) = plan.place(index);
            let pass = Pass { tables: &plan.tables, low, stride };
            kernels::forward(pass, &samples[start..], coefs, &mut work);
        }
    }
}

impl<T: Real, const N: usize, const L: usize> WithSimd for Forward<'_, T, N, L> {
    type Output = ();

    /// `low` is constant where that pays.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        align_stack();
        match self.low {
            low if low == N => self.run(N),
            4 if N == 16 => self.run(4),
            low => self.run(low),
        }
    }
}

/// As [`Forward`], back.
struct Inverse<'a, T, const N: usize, const L: usize> {
    plan: &'a BlockDct<T>,
    low: usize,
    coefs: &'a [T],
    samples: &'a mut [T],
}

impl<T: Real, const N: usize, const L: usize> Inverse<'_, T, N, L> {
    #[inline(always)]
    fn run(self, low: usize) {
        let Self { plan, samples, coefs, .. } = self;
        let mut work = Work::<T, N, L>::new();
        for (index, coefs) in coefs.chunks_exact(low * low).enumerate() {
            let (start, stride) = plan.place(index);
            let pass = Pass { tables: &plan.tables, low, stride };
            kernels::inverse(pass, coefs, &mut samples[start..], &mut work);
        }
    }
}

impl<T: Real, const N: usize, const L: usize> WithSimd for Inverse<'_, T, N, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        align_stack();
        match self.low {
            low if low == N => self.run(N),
            4 if N == 16 => self.run(4),
            low => self.run(low),
        }
    }
}

/// All coefficients of one block, its `side` from its length; plans each time, for tests and single blocks.
///
/// # Errors
/// As [`BlockDct::new`]; [`Error::Length`] unless the block is square.
pub fn forward<T: Real>(block: &[T]) -> Result<Vec<T>> {
    let (plan, mut out) = (plan_of(block)?, vec![T::zero(); block.len()]);
    plan.forward(block, &mut out);
    Ok(out)
}

/// The samples of one block from all its coefficients, as [`forward`].
///
/// # Errors
/// As [`forward`].
pub fn inverse<T: Real>(coefs: &[T]) -> Result<Vec<T>> {
    let (plan, mut out) = (plan_of(coefs)?, vec![T::zero(); coefs.len()]);
    plan.inverse(coefs, &mut out);
    Ok(out)
}

fn plan_of<T: Real>(block: &[T]) -> Result<BlockDct<T>> {
    let side = block.len().isqrt();
    if side * side != block.len() {
        return Err(Error::Length { what: "samples of a square block", expected: side * side, got: block.len() });
    }
    BlockDct::new(side)
}

/// Chunk number `k` of so many elements each, the last one with what is left.
fn chunk_of<T>(all: &[T], k: usize, each: usize) -> &[T] {
    &all[k * each..all.len().min((k + 1) * each)]
}
