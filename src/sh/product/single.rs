//! One vector at a time: number by number where the text is the one by the tensor, four nodes side by side where it is by quadrature.
//!
//! Nothing is dispatched: the code is for the instructions that every machine has, among which are registers of four numbers on all that
//! matter. For a single vector wider ones would not be full, and the call that leads to them costs more than they save.

use std::hint::black_box;
use std::ops::{Add, Mul, Sub};

use super::kernel::{Constants, Site, Straight, at_poles, by_tensor, pair};
use crate::Real;
use crate::sh::lane::Lane;

/// Nodes side by side.
pub(super) const LANES: usize = 4;

/// A number, or some side by side. An array and not a register of `pulp`'s, which has none of this width without a dispatch.
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
        return pair::<K, _, SQUARE>(&mut Numbers { a, b, out });
    }
    let mut sums = [[T::zero(); 1]; N];
    if let Some(constants) = constants.poles.as_chunks().0.first_chunk::<C>() {
        at_poles::<K, _, SQUARE>(&mut Nodes { constants, a, b, out: &mut sums });
    }
    // A batch adds to 0, too, which takes the sign of a zero.
    *out = sums.map(|[sum]| T::zero() + sum);
    let mut rest = constants.pairs.len() / C;
    for constants in constants.lanes.as_chunks::<C>().0 {
        let mut parts = [[T::zero(); LANES]; N];
        pair::<K, _, SQUARE>(&mut Nodes { constants, a, b, out: &mut parts });
        // Has the parts written to memory, where the sums find them four at a time. Otherwise LLVM takes the lanes apart.
        black_box(parts.as_ptr());
        match rest {
            1 => add::<T, N, 1>(&parts, out),
            2 => add::<T, N, 2>(&parts, out),
            3 => add::<T, N, 3>(&parts, out),
            _ => add::<T, N, LANES>(&parts, out),
        }
        rest = rest.saturating_sub(LANES);
    }
}

/// Adds the first K of each four parts, one after the other.
#[inline(always)]
fn add<T: Real, const N: usize, const K: usize>(parts: &[[T; LANES]; N], sums: &mut [T; N]) {
    let (sums, last) = sums.as_chunks_mut::<LANES>();
    let (parts, last_parts) = parts.as_chunks::<LANES>();
    for (sums, parts) in sums.iter_mut().zip(parts) {
        for k in 0..K {
            for i in 0..LANES {
                sums[i] += parts[i][k];
            }
        }
    }
    for (sum, parts) in last.iter_mut().zip(last_parts) {
        parts[..K].iter().for_each(|part| *sum += *part);
    }
}
