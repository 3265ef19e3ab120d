//! One vector at a time: number by number where the text is the one by the tensor, all nodes side by side where it is
//! by quadrature.
//!
//! Four to six bands have at most four pairs of nodes and nothing is dispatched: registers of four numbers are what
//! every machine has. Seven and eight bands have five pairs, which want wider ones.

use std::hint::black_box;
use std::marker::PhantomData;
use std::ops::{Add, Mul, Sub};

use pulp::{Arch, Simd, WithSimd};

use super::text::{Constants, FEW, MANY, Site, Straight, at_poles, by_tensor, lanes, pair};
use crate::Real;
use crate::numeric::{align_stack, arch_256};
use crate::sh::lane::Lane;

/// A number, or some side by side. An array and not a register of `pulp`'s, which has none of this width without a
/// dispatch.
#[derive(Clone, Copy)]
pub(super) struct Wide<T, const L: usize>([T; L]);

impl<T: Real, const L: usize> Wide<T, L> {
    #[inline(always)]
    fn with(self, other: Self, operation: impl Fn(T, T) -> T) -> Self {
        let mut out = self;
        for i in 0..L {
            out.0[i] = operation(self.0[i], other.0[i]);
        }
        out
    }
}

macro_rules! operators {
    ($($op: ident $name: ident)*) => {$(
        impl<T: Real, const L: usize> $op for Wide<T, L> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                self.with(other, T::$name)
            }
        }
    )*};
}

operators!(Add add Sub sub Mul mul);

impl<T: Real, const L: usize> Lane for Wide<T, L> {}

/// One vector, for the text by the tensor.
pub(super) struct Numbers<'a, T, const N: usize> {
    pub a: &'a [T; N],
    pub b: &'a [T; N],
    pub out: &'a mut [T; N],
}

impl<T: Real, const N: usize> Site for Numbers<'_, T, N> {
    type Row = Wide<T, 1>;
    #[inline(always)]
    fn constant(&self, _: usize) -> Self::Row {
        unreachable!("the text by the tensor has literals")
    }
    #[inline(always)]
    fn literal(&self, value: f64) -> Self::Row {
        Wide([T::of(value)])
    }
    #[inline(always)]
    fn a(&self, i: usize) -> Self::Row {
        Wide([self.a[i]])
    }
    #[inline(always)]
    fn b(&self, i: usize) -> Self::Row {
        Wide([self.b[i]])
    }
    #[inline(always)]
    fn give(&mut self, i: usize, value: Self::Row) {
        [self.out[i]] = value.0;
    }
}

/// `L` pairs of nodes of one vector, for the text by quadrature.
struct Nodes<'a, T, const L: usize, const N: usize, const C: usize> {
    constants: &'a [[T; L]; C],
    a: &'a [T; N],
    b: &'a [T; N],
    out: &'a mut [[T; L]; N],
}

impl<T: Real, const L: usize, const N: usize, const C: usize> Site for Nodes<'_, T, L, N, C> {
    type Row = Wide<T, L>;
    #[inline(always)]
    fn constant(&self, i: usize) -> Self::Row {
        Wide(self.constants[i])
    }
    #[inline(always)]
    fn literal(&self, value: f64) -> Self::Row {
        Wide([T::of(value); L])
    }
    #[inline(always)]
    fn a(&self, i: usize) -> Self::Row {
        Wide([self.a[i]; L])
    }
    #[inline(always)]
    fn b(&self, i: usize) -> Self::Row {
        Wide([self.b[i]; L])
    }
    #[inline(always)]
    fn give(&mut self, i: usize, value: Self::Row) {
        self.out[i] = value.0;
    }
}

/// The product or the square of one vector, whose nodes are added up in their order as in a batch.
#[inline(always)]
pub(super) fn one<K: Straight, T: Real, const N: usize, const C: usize, const SQUARE: bool>(
    constants: &Constants<T>,
    [a, b]: [&[T; N]; 2],
    out: &mut [T; N],
) {
    if by_tensor(C) {
        let by_numbers = ByNumbers::<K, T, N, SQUARE> { kernel: PhantomData, a, b, out };
        // Instructions of three operands and more registers are worth the call from three bands on.
        return if N > 4 { Arch::new().dispatch(by_numbers) } else { by_numbers.run() };
    }
    let by_nodes = ByNodes::<K, T, N, C, SQUARE> { kernel: PhantomData, constants, a, b, out };
    if lanes(N) == FEW { by_nodes.run::<FEW>() } else { arch_256().dispatch(by_nodes) }
}

/// One vector by the tensor.
struct ByNumbers<'a, K, T, const N: usize, const SQUARE: bool> {
    kernel: PhantomData<K>,
    a: &'a [T; N],
    b: &'a [T; N],
    out: &'a mut [T; N],
}

impl<K: Straight, T: Real, const N: usize, const SQUARE: bool> ByNumbers<'_, K, T, N, SQUARE> {
    #[inline(always)]
    fn run(self) {
        pair::<K, _, SQUARE>(&mut Numbers { a: self.a, b: self.b, out: self.out });
    }
}

impl<K: Straight, T: Real, const N: usize, const SQUARE: bool> WithSimd for ByNumbers<'_, K, T, N, SQUARE> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        align_stack();
        self.run();
    }
}

/// One vector by quadrature.
struct ByNodes<'a, K, T, const N: usize, const C: usize, const SQUARE: bool> {
    kernel: PhantomData<K>,
    constants: &'a Constants<T>,
    a: &'a [T; N],
    b: &'a [T; N],
    out: &'a mut [T; N],
}

impl<K: Straight, T: Real, const N: usize, const C: usize, const SQUARE: bool> WithSimd
    for ByNodes<'_, K, T, N, C, SQUARE>
{
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        align_stack();
        self.run::<MANY>();
    }
}

impl<K: Straight, T: Real, const N: usize, const C: usize, const SQUARE: bool> ByNodes<'_, K, T, N, C, SQUARE> {
    #[inline(always)]
    fn run<const L: usize>(self) {
        let Self { constants, a, b, out, .. } = self;
        let mut sums = [[T::zero(); 1]; N];
        if let Some(constants) = constants.poles.as_chunks().0.first_chunk::<C>() {
            at_poles::<K, _, SQUARE>(&mut Nodes { constants, a, b, out: &mut sums });
        }
        // A batch adds to 0, too, which takes the sign of a zero.
        *out = sums.map(|[sum]| T::zero() + sum);
        let pairs = constants.pairs.len() / C;
        // One group: there are as many lanes as nodes.
        if let Some(constants) = constants.lanes.as_chunks::<L>().0.first_chunk::<C>() {
            let mut parts = [[T::zero(); L]; N];
            pair::<K, _, SQUARE>(&mut Nodes { constants, a, b, out: &mut parts });
            // Has the parts written to memory, where the sums find them four at a time. Otherwise LLVM takes the lanes
            // apart.
            black_box(parts.as_ptr());
            match pairs {
                1 => add::<T, L, N, 1>(&parts, out),
                2 => add::<T, L, N, 2>(&parts, out),
                3 => add::<T, L, N, 3>(&parts, out),
                4 => add::<T, L, N, 4>(&parts, out),
                5 => add::<T, L, N, 5>(&parts, out),
                _ => unreachable!("a rule of up to 8 bands has up to 5 pairs of nodes"),
            }
        }
    }
}

/// Adds the first K of each L parts, one after the other.
#[inline(always)]
fn add<T: Real, const L: usize, const N: usize, const K: usize>(parts: &[[T; L]; N], sums: &mut [T; N]) {
    let (sums, last) = sums.as_chunks_mut::<4>();
    let (parts, last_parts) = parts.as_chunks::<4>();
    for (sums, parts) in sums.iter_mut().zip(parts) {
        for k in 0..K {
            for i in 0..4 {
                sums[i] += parts[i][k];
            }
        }
    }
    for (sum, parts) in last.iter_mut().zip(last_parts) {
        parts[..K].iter().for_each(|part| *sum += *part);
    }
}
