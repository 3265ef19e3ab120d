//! How the straight-line text runs over a batch, a register of vectors at a time, and over one vector:
//! [`single`](super::single). One text makes both, so a batch has the bits of single calls.

use std::any::Any;

use pulp::{Arch, Simd, WithSimd};

use super::generated::{
    quadrature_4::Quadrature4, quadrature_5::Quadrature5, quadrature_6::Quadrature6, quadrature_7::Quadrature7,
    quadrature_8::Quadrature8, tensor_2::Tensor2, tensor_3::Tensor3,
};
use super::single::one;
use super::text::{Constants, Site, Straight, at_poles, by_tensor, pair};
use crate::Real;
use crate::numeric::align_stack;
use crate::sh::lane::Element;

/// A block of vectors, for the text by quadrature.
struct Block<'a, S: Simd, T: Element, const N: usize, const C: usize> {
    simd: S,
    constants: &'a [T; C],
    a: &'a [T::Reg<S>; N],
    b: &'a [T::Reg<S>; N],
    out: &'a mut [T::Reg<S>; N],
}

impl<S: Simd, T: Element, const N: usize, const C: usize> Site for Block<'_, S, T, N, C> {
    type Row = T::Reg<S>;
    #[inline(always)]
    fn constant(&self, i: usize) -> Self::Row {
        T::splat(self.simd, self.constants[i])
    }
    #[inline(always)]
    fn literal(&self, value: f64) -> Self::Row {
        T::splat(self.simd, T::of(value))
    }
    #[inline(always)]
    fn a(&self, i: usize) -> Self::Row {
        self.a[i]
    }
    #[inline(always)]
    fn b(&self, i: usize) -> Self::Row {
        self.b[i]
    }
    #[inline(always)]
    fn give(&mut self, i: usize, value: Self::Row) {
        self.out[i] = self.out[i] + value;
    }
}

/// Where a batch lies: coefficient i of the factors and of the product, from vector `first` on.
trait Batch<T: Element> {
    fn load<S: Simd>(&self, simd: S, factor: usize, i: usize, first: usize) -> T::Reg<S>;
    fn store<S: Simd>(&mut self, i: usize, first: usize, value: T::Reg<S>);
}

/// Rows one after the other: good for many of them, each access is checked.
struct Whole<'a, T> {
    count: usize,
    factors: [&'a [T]; 2],
    out: &'a mut [T],
}

impl<T: Element> Batch<T> for Whole<'_, T> {
    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, factor: usize, i: usize, first: usize) -> T::Reg<S> {
        T::load(simd, &self.factors[factor][i * self.count + first..][..T::lanes::<S>()])
    }
    #[inline(always)]
    fn store<S: Simd>(&mut self, i: usize, first: usize, value: T::Reg<S>) {
        T::store::<S>(&mut self.out[i * self.count + first..][..T::lanes::<S>()], value);
    }
}

/// A slice for each row, all of one length: a place that is good in one is good in all, so one check serves them.
struct Rows<'a, T, const N: usize> {
    factors: [[&'a [T]; N]; 2],
    out: [&'a mut [T]; N],
}

impl<'a, T, const N: usize> Rows<'a, T, N> {
    #[inline(always)]
    fn new(whole: Whole<'a, T>) -> Self {
        let factors = whole.factors.map(|x| {
            let mut rows = x.chunks_exact(whole.count);
            std::array::from_fn(|_| rows.next().expect("a row of a factor"))
        });
        let mut out = whole.out.chunks_exact_mut(whole.count);
        Self { factors, out: std::array::from_fn(|_| out.next().expect("a row of the product")) }
    }
}

impl<T: Element, const N: usize> Batch<T> for Rows<'_, T, N> {
    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, factor: usize, i: usize, first: usize) -> T::Reg<S> {
        T::load(simd, &self.factors[factor][i][first..][..T::lanes::<S>()])
    }
    #[inline(always)]
    fn store<S: Simd>(&mut self, i: usize, first: usize, value: T::Reg<S>) {
        T::store::<S>(&mut self.out[i][first..][..T::lanes::<S>()], value);
    }
}

/// A block of vectors, for the text by the tensor.
struct Tile<'a, S: Simd, T: Element, const N: usize> {
    simd: S,
    a: &'a [T::Reg<S>; N],
    b: &'a [T::Reg<S>; N],
    out: &'a mut [T::Reg<S>; N],
}

impl<S: Simd, T: Element, const N: usize> Site for Tile<'_, S, T, N> {
    type Row = T::Reg<S>;
    #[inline(always)]
    fn constant(&self, _: usize) -> Self::Row {
        unreachable!("the text by the tensor has literals")
    }
    #[inline(always)]
    fn literal(&self, value: f64) -> Self::Row {
        T::splat(self.simd, T::of(value))
    }
    #[inline(always)]
    fn a(&self, i: usize) -> Self::Row {
        self.a[i]
    }
    #[inline(always)]
    fn b(&self, i: usize) -> Self::Row {
        self.b[i]
    }
    #[inline(always)]
    fn give(&mut self, i: usize, value: Self::Row) {
        self.out[i] = value;
    }
}

/// One call of a kernel.
struct Call<'a, K, T, const N: usize, const C: usize, const SQUARE: bool> {
    kernel: std::marker::PhantomData<K>,
    constants: &'a Constants<T>,
    count: usize,
    a: &'a [T],
    b: &'a [T],
    out: &'a mut [T],
}

impl<K: Straight, T: Element, const N: usize, const C: usize, const SQUARE: bool> WithSimd
    for Call<'_, K, T, N, C, SQUARE>
{
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        align_stack();
        let count = self.count;
        if count < T::lanes::<S>() {
            return self.few();
        }
        let factors = [self.a, if SQUARE { self.a } else { self.b }];
        let mut whole = Whole { count, factors, out: self.out };
        if N <= FEW_ROWS {
            Self::blocks(simd, self.constants, count, &mut Rows::<T, N>::new(whole));
        } else {
            Self::blocks(simd, self.constants, count, &mut whole);
        }
    }
}

/// Rows up to which [`Rows`] pays.
const FEW_ROWS: usize = 4;

impl<K: Straight, T: Element, const N: usize, const C: usize, const SQUARE: bool> Call<'_, K, T, N, C, SQUARE> {
    const BY_TENSOR: bool = by_tensor(C);

    /// The last block overlaps the one before rather than be narrower.
    #[inline(always)]
    fn blocks<S: Simd>(simd: S, constants: &Constants<T>, count: usize, batch: &mut impl Batch<T>) {
        let lanes = T::lanes::<S>();
        let mut first = 0;
        while first < count {
            Self::block(simd, constants, batch, first.min(count - lanes));
            first += lanes;
        }
    }

    #[inline(always)]
    fn block<S: Simd>(simd: S, constants: &Constants<T>, batch: &mut impl Batch<T>, first: usize) {
        let zero = T::splat(simd, T::zero());
        let (mut a, mut b, mut out) = ([zero; N], [zero; N], [zero; N]);
        for i in 0..N {
            a[i] = batch.load(simd, 0, i, first);
            if !SQUARE {
                b[i] = batch.load(simd, 1, i, first);
            }
        }
        if Self::BY_TENSOR {
            pair::<K, _, SQUARE>(&mut Tile::<S, T, N> { simd, a: &a, b: &b, out: &mut out });
        } else {
            if let Some(constants) = constants.poles.first_chunk() {
                at_poles::<K, _, SQUARE>(&mut Block::<S, T, N, C> { simd, constants, a: &a, b: &b, out: &mut out });
            }
            for constants in constants.pairs.as_chunks::<C>().0 {
                pair::<K, _, SQUARE>(&mut Block::<S, T, N, C> { simd, constants, a: &a, b: &b, out: &mut out });
            }
        }
        for (i, value) in out.into_iter().enumerate() {
            batch.store::<S>(i, first, value);
        }
    }

    /// Fewer vectors than a register has lanes.
    #[inline(never)]
    fn few(self) {
        let (count, b) = (self.count, if SQUARE { self.a } else { self.b });
        for v in 0..count {
            let [a, b] = [self.a, b].map(|x| std::array::from_fn(|i| x[i * count + v]));
            let mut out = [T::zero(); N];
            one::<K, T, N, C, SQUARE>(self.constants, [&a, &b], &mut out);
            for i in 0..N {
                self.out[i * count + v] = out[i];
            }
        }
    }
}

/// A kernel for `T`, chosen by its number of bands.
type Run<T> = fn(&Constants<T>, Arch, usize, [&[T]; 2], &mut [T]);

/// The function and its multiplications, of a pair of nodes and of the poles.
type Found<T> = Option<(Run<T>, [usize; 2])>;

fn run<K: Straight, T: Element, const N: usize, const C: usize, const SQUARE: bool>(
    constants: &Constants<T>,
    arch: Arch,
    count: usize,
    [a, b]: [&[T]; 2],
    out: &mut [T],
) {
    if let ([Some(a), Some(b)], Some(out), 1) =
        ([a, b].map(|x| x.first_chunk::<N>()), out.first_chunk_mut::<N>(), count)
    {
        return one::<K, T, N, C, SQUARE>(constants, [a, b], out);
    }
    let kernel = std::marker::PhantomData::<K>;
    arch.dispatch(Call::<K, T, N, C, SQUARE> { kernel, constants, count, a, b, out });
}

/// A straight-line product or square.
#[derive(Debug, Clone)]
pub(super) struct Kernel<T> {
    constants: Constants<T>,
    run: Run<T>,
    multiplications: usize,
}

impl<T: Real> Kernel<T> {
    /// The kernel for equal bands, if there is one.
    pub fn new(bands: usize, square: bool) -> Option<Self> {
        let (run, multiplications) = choose::<T>(bands, square)?;
        let mut kernel = Self { constants: Constants::default(), run, multiplications: multiplications[0] };
        if multiplications[1] > 0 {
            kernel.constants = Constants::new(bands);
            let pairs = kernel.constants.pairs.len() / (bands * (bands + 1));
            kernel.multiplications *= pairs;
            if !kernel.constants.poles.is_empty() {
                kernel.multiplications += multiplications[1];
            }
        }
        Some(kernel)
    }

    pub fn multiplications(&self) -> usize {
        self.multiplications
    }

    /// `count` vectors; the lengths have been checked.
    pub fn run(&self, arch: Arch, count: usize, factors: [&[T]; 2], out: &mut [T]) {
        (self.run)(&self.constants, arch, count, factors, out);
    }
}

fn choose<T: Real>(bands: usize, square: bool) -> Found<T> {
    let (single, double) = (choose_f32(bands, square), choose_f64(bands, square));
    [&single as &dyn Any, &double].into_iter().find_map(|found| *found.downcast_ref::<Found<T>>()?)
}

/// Not generic, so that the text is compiled in this crate and not again in each that calls it.
#[inline(never)]
fn choose_f32(bands: usize, square: bool) -> Found<f32> {
    choose_typed(bands, square)
}

/// As [`choose_f32`].
#[inline(never)]
fn choose_f64(bands: usize, square: bool) -> Found<f64> {
    choose_typed(bands, square)
}

fn choose_typed<T: Element>(bands: usize, square: bool) -> Found<T> {
    macro_rules! table {
        ($($kernel: ident, $n: literal, $constants: literal;)*) => {
            match (bands, square) {
                $(
                    ($n, false) => Some((run::<$kernel, T, { $n * $n }, $constants, false>, [$kernel::PRODUCT, $kernel::PRODUCT_AT_POLES])),
                    ($n, true) => Some((run::<$kernel, T, { $n * $n }, $constants, true>, [$kernel::SQUARE, $kernel::SQUARE_AT_POLES])),
                )*
                _ => None,
            }
        };
    }
    table! {
        Tensor2, 2, 1;
        Tensor3, 3, 1;
        Quadrature4, 4, 20;
        Quadrature5, 5, 30;
        Quadrature6, 6, 42;
        Quadrature7, 7, 56;
        Quadrature8, 8, 72;
    }
}
