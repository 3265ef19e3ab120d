//! The blocks of one rotation times many vectors, in registers of vectors.
//!
//! Two registers of vectors meet R rows of a block: 2R sums stay in registers, and R + 2 loads feed 2R multiplications.
//! Multiplication and addition are apart (no FMA), so the bound is two multiplications a cycle; R ≥ 4 keeps the loads
//! below it, R ≤ 5 the sums and what they are made of in 16 registers.

use std::any::Any;

use pulp::{Arch, Simd, WithSimd};

use super::sizes::{MAX_BANDS, block_start};
use crate::Real;
use crate::numeric::align_stack;
use crate::sh::lane::Element;

/// Bands whose degrees are unrolled.
const UNROLLED: usize = 6;

/// Rows of a tile at most.
const ROWS: usize = 5;

/// The tiles of a degree, up to [`ROWS`] rows each and as even as can be: so many, those with a row more, the rows of
/// the others.
#[inline(always)]
const fn shares(l: usize) -> [usize; 3] {
    let size = 2 * l + 1;
    let tiles = size.div_ceil(ROWS);
    [tiles, size % tiles, size / tiles]
}

/// The blocks tile by tile, each column by column.
pub(super) fn tiles<T: Real>(bands: usize, blocks: &[T]) -> Vec<T> {
    let mut out = Vec::with_capacity(blocks.len());
    for l in 0..bands {
        let (size, [tiles, larger, least]) = (2 * l + 1, shares(l));
        let mut rest = &blocks[block_start(l)..block_start(l + 1)];
        for tile in 0..tiles {
            let rows = least + usize::from(tile < larger);
            let (block, below) = rest.split_at(rows * size);
            out.extend((0..size * rows).map(|k| block[k % rows * size + k / rows]));
            rest = below;
        }
    }
    out
}

/// Tiles of `bands`, times `count` vectors, at least [`least`] of them.
pub(super) type Run<T> = fn(Arch, (usize, &[T]), usize, &[T], &mut [T]);

/// The least vectors of a batch in registers.
pub(super) const fn least<T>() -> usize {
    2 * 64 / size_of::<T>()
}

fn run<T: Element>(arch: Arch, (bands, tiles): (usize, &[T]), count: usize, f: &[T], out: &mut [T]) {
    arch.dispatch(Batch { bands, tiles, count, f, out });
}

/// Compiled here for `f32` and `f64` once.
pub(super) fn choose<T: Real>() -> Run<T> {
    let (single, double): (Run<f32>, Run<f64>) = (run::<f32>, run::<f64>);
    let found = [&single as &dyn Any, &double].into_iter().find_map(|run| run.downcast_ref::<Run<T>>().copied());
    found.expect("T is f32 or f64")
}

/// A batch; run by `pulp` with the instructions that the machine has.
struct Batch<'a, T> {
    bands: usize,
    tiles: &'a [T],
    count: usize,
    f: &'a [T],
    out: &'a mut [T],
}

impl<T: Element> WithSimd for Batch<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        align_stack();
        match T::lanes::<S>() {
            16 => self.run::<S, 32>(simd),
            8 => self.run::<S, 16>(simd),
            4 => self.run::<S, 8>(simd),
            2 => self.run::<S, 4>(simd),
            _ => self.run::<S, 2>(simd),
        }
    }
}

impl<T: Element> Batch<'_, T> {
    /// Degree by degree, W vectors, two registers, at once; the last W vectors are whole, too, some for the second
    /// time.
    #[inline(always)]
    fn run<S: Simd, const W: usize>(self, simd: S) {
        let Self { bands, tiles, count, f, out } = self;
        macro_rules! degrees {
            ($($l:literal: $($rows:literal)*;)*) => {$(
                if bands > $l {
                    const N: usize = 2 * $l + 1;
                    let rows = $l * $l * count..($l + 1) * ($l + 1) * count;
                    let low = &mut Low::<S, T, N>::new(simd, &f[rows.clone()], &mut out[rows], count);
                    let block = &tiles[block_start($l)..][..N * N];
                    let mut at = 0;
                    while at < count {
                        let first = if at + W <= count { at } else { count - W };
                        let vectors = low.load(first);
                        let to = &mut windows::<T, N, W>(&mut low.out, first);
                        let mut row = 0;
                        $(
                            multiply::<S, T, N, $rows, W>(simd, &block[row * N..][..$rows * N], &vectors, &mut to[row..row + $rows]);
                            #[allow(unused_assignments, reason = "the last one's")]
                            {
                                row += $rows;
                            }
                        )*
                        at += W;
                    }
                }
            )*};
        }
        degrees!(0: 1; 1: 3; 2: 5; 3: 4 3; 4: 5 4; 5: 4 4 3;);
        if bands > UNROLLED {
            let mut local = [[T::splat(simd, T::zero()); 2]; 2 * MAX_BANDS];
            for l in UNROLLED..bands {
                let rows = l * l * count..(l + 1) * (l + 1) * count;
                let mut high = High { simd, out: &mut out[rows.clone()], count, first: 0 };
                let (block, local, f) = (&tiles[block_start(l)..block_start(l + 1)], &mut local[..2 * l + 1], &f[rows]);
                let mut at = 0;
                while at < count {
                    high.first = if at + W <= count { at } else { count - W };
                    high.load(f, local);
                    high.multiply_all(block, local, shares(l));
                    at += W;
                }
            }
        }
    }
}

/// The N rows of a degree, in and out: a row known by its slice is checked once.
struct Low<'a, S, T, const N: usize> {
    simd: S,
    f: [&'a [T]; N],
    out: [&'a mut [T]; N],
}

impl<'a, S: Simd, T: Element, const N: usize> Low<'a, S, T, N> {
    #[inline(always)]
    fn new(simd: S, f: &'a [T], out: &'a mut [T], count: usize) -> Self {
        let (mut f, mut out) = (f.chunks_exact(count), out.chunks_exact_mut(count));
        Self {
            simd,
            f: std::array::from_fn(|_| f.next().expect("N rows")),
            out: std::array::from_fn(|_| out.next().expect("N rows")),
        }
    }

    #[inline(always)]
    fn load(&self, first: usize) -> [[T::Reg<S>; 2]; N] {
        let lanes = T::lanes::<S>();
        let mut vectors = [[T::splat(self.simd, T::zero()); 2]; N];
        for j in 0..N {
            let (a, b) = self.f[j][first..][..2 * lanes].split_at(lanes);
            vectors[j] = [T::load(self.simd, a), T::load(self.simd, b)];
        }
        vectors
    }
}

/// The places of all rows, before anything is computed, and of a length that is known: with a check between two rows
/// LLVM would compute one row after the other.
#[inline(always)]
fn windows<'a, T, const N: usize, const W: usize>(out: &'a mut [&mut [T]; N], first: usize) -> [&'a mut [T; W]; N] {
    let mut rows = out.iter_mut();
    std::array::from_fn(
        #[inline(always)]
        |_| rows.next().expect("N rows")[first..].first_chunk_mut().expect("W vectors"),
    )
}

/// R rows of a block times the vectors.
#[inline(always)]
fn multiply<S: Simd, T: Element, const N: usize, const R: usize, const W: usize>(
    simd: S,
    block: &[T],
    vectors: &[[T::Reg<S>; 2]; N],
    to: &mut [&mut [T; W]],
) {
    let mut sums = [vectors[0]; R];
    for j in 0..N {
        for r in 0..R {
            let entry = T::splat(simd, block[j * R + r]);
            for h in 0..2 {
                let term = entry * vectors[j][h];
                sums[r][h] = if j == 0 { term } else { sums[r][h] + term };
            }
        }
    }
    for r in 0..R {
        let (a, b) = to[r].split_at_mut(T::lanes::<S>());
        T::store(a, sums[r][0]);
        T::store(b, sums[r][1]);
    }
}

/// Vectors first.. of the rows of a degree.
struct High<'a, S, T> {
    simd: S,
    out: &'a mut [T],
    count: usize,
    first: usize,
}

impl<S: Simd, T: Element> High<'_, S, T> {
    #[inline(always)]
    fn load(&self, f: &[T], local: &mut [[T::Reg<S>; 2]]) {
        let lanes = T::lanes::<S>();
        for (row, to) in f.chunks_exact(self.count).zip(local) {
            let (a, b) = row[self.first..][..2 * lanes].split_at(lanes);
            *to = [T::load(self.simd, a), T::load(self.simd, b)];
        }
    }

    #[inline(always)]
    fn multiply_all(&mut self, block: &[T], local: &[[T::Reg<S>; 2]], [tiles, larger, least]: [usize; 3]) {
        let (mut row, mut rest) = (0, block);
        for tile in 0..tiles {
            let rows = least + usize::from(tile < larger);
            let (head, below) = rest.split_at(rows * local.len());
            match rows {
                3 => self.multiply::<3>(head, local, row),
                4 => self.multiply::<4>(head, local, row),
                _ => self.multiply::<5>(head, local, row),
            }
            row += rows;
            rest = below;
        }
    }

    /// A tile of R rows, from `row` on, times the vectors.
    #[inline(always)]
    fn multiply<const R: usize>(&mut self, tile: &[T], local: &[[T::Reg<S>; 2]], row: usize) {
        let (columns, _) = tile.as_chunks::<R>();
        let (Some((entries, columns)), Some((&[a, b], local))) = (columns.split_first(), local.split_first()) else {
            return;
        };
        let mut sums = [[a, b]; R];
        for r in 0..R {
            let entry = T::splat(self.simd, entries[r]);
            sums[r] = [entry * a, entry * b];
        }
        for (entries, &[a, b]) in columns.iter().zip(local) {
            for r in 0..R {
                let entry = T::splat(self.simd, entries[r]);
                sums[r] = [sums[r][0] + entry * a, sums[r][1] + entry * b];
            }
        }
        let lanes = T::lanes::<S>();
        for (sums, to) in sums.iter().zip(self.out[row * self.count..].chunks_exact_mut(self.count)) {
            let (a, b) = to[self.first..][..2 * lanes].split_at_mut(lanes);
            T::store(a, sums[0]);
            T::store(b, sums[1]);
        }
    }
}
