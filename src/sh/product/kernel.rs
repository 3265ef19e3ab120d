//! What the straight-line text is written against, and how it runs: over a batch, eight vectors to a register, or over one
//! vector, where the lanes are the nodes.
//!
//! One text makes both, so a batch has the bits of single calls.

use std::any::Any;

use pulp::{Arch, Simd, WithSimd};

use super::generated::{
    quadrature_4::Quadrature4, quadrature_5::Quadrature5, quadrature_6::Quadrature6, quadrature_7::Quadrature7,
    quadrature_8::Quadrature8, tensor_2::Tensor2, tensor_3::Tensor3,
};
use super::lane::{Element, Lane};
use super::nodes::{Rule, factors, normalized_legendre};
use crate::Real;

/// Where the text takes its numbers and leaves its results.
pub(super) trait Site {
    type Row: Lane;
    /// A constant of the pair of nodes.
    fn constant(&self, i: usize) -> Self::Row;
    /// A constant of the text.
    fn literal(&self, value: f64) -> Self::Row;
    fn a(&self, i: usize) -> Self::Row;
    fn b(&self, i: usize) -> Self::Row;
    /// To coefficient i of the product: all of it (tensor), or what is to be added (quadrature).
    fn give(&mut self, i: usize, value: Self::Row);
}

/// The text for a number of bands; the constants are counts of multiplications.
pub(super) trait Straight: 'static {
    const PRODUCT: usize;
    const SQUARE: usize;
    const PRODUCT_AT_POLES: usize = 0;
    const SQUARE_AT_POLES: usize = 0;
    fn product<P: Site>(p: &mut P);
    fn square<P: Site>(p: &mut P);
    #[inline(always)]
    fn product_at_poles<P: Site>(_: &mut P) {}
    #[inline(always)]
    fn square_at_poles<P: Site>(_: &mut P) {}
}

#[inline(always)]
fn pair<K: Straight, P: Site, const SQUARE: bool>(p: &mut P) {
    if SQUARE { K::square(p) } else { K::product(p) }
}

#[inline(always)]
fn at_poles<K: Straight, P: Site, const SQUARE: bool>(p: &mut P) {
    if SQUARE { K::square_at_poles(p) } else { K::product_at_poles(p) }
}

/// Room for the pairs of nodes of one kernel, whatever a register holds.
const MOST_PAIRS: usize = 16;

/// Constants of the nodes, `C` to a pair: N P_lm to evaluate, then to project.
#[derive(Debug, Clone, Default, PartialEq)]
struct Constants<T> {
    poles: Vec<T>,
    /// Pair by pair.
    pairs: Vec<T>,
    /// Constant by constant, `MOST_PAIRS` places each.
    rows: Vec<T>,
}

impl<T: Real> Constants<T> {
    fn new(bands: usize) -> Self {
        let degree = 3 * (bands - 1);
        let gauss = Rule::gauss(degree).expect("at least one node");
        let lobatto = Rule::lobatto(degree);
        let rule = if lobatto.pairs.len() < gauss.pairs.len() { lobatto } else { gauss };
        let of = |z: f64, weight: f64| {
            let values = normalized_legendre(bands, z);
            let orders = (0..bands).flat_map(|m| std::iter::repeat_n(m, bands - m));
            [0, 1].into_iter().flat_map(move |which| {
                let orders = orders.clone();
                values.clone().into_iter().zip(orders).map(move |(p, m)| T::of(p * factors(m, weight)[which]))
            })
        };
        let pairs: Vec<T> = rule.pairs.iter().flat_map(|&[z, weight]| of(z, weight)).collect();
        let count = bands * (bands + 1);
        let mut rows = vec![T::zero(); count * MOST_PAIRS];
        for (k, constants) in pairs.chunks_exact(count).enumerate() {
            constants.iter().enumerate().for_each(|(i, c)| rows[i * MOST_PAIRS + k] = *c);
        }
        let poles = if rule.poles > 0.0 { of(1.0, rule.poles).collect() } else { Vec::new() };
        Self { poles, pairs, rows }
    }
}

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

/// Nodes in lanes, for one vector by quadrature.
struct Nodes<'a, S: Simd, T: Element, const N: usize> {
    simd: S,
    first: usize,
    rows: &'a [[T; MOST_PAIRS]],
    a: &'a [T; N],
    b: &'a [T; N],
    out: &'a mut [[T; MOST_PAIRS]; N],
}

impl<S: Simd, T: Element, const N: usize> Site for Nodes<'_, S, T, N> {
    type Row = T::Reg<S>;
    #[inline(always)]
    fn constant(&self, i: usize) -> Self::Row {
        T::load(self.simd, &self.rows[i][self.first..][..T::lanes::<S>()])
    }
    #[inline(always)]
    fn literal(&self, value: f64) -> Self::Row {
        T::splat(self.simd, T::of(value))
    }
    #[inline(always)]
    fn a(&self, i: usize) -> Self::Row {
        T::splat(self.simd, self.a[i])
    }
    #[inline(always)]
    fn b(&self, i: usize) -> Self::Row {
        T::splat(self.simd, self.b[i])
    }
    #[inline(always)]
    fn give(&mut self, i: usize, value: Self::Row) {
        T::store::<S>(&mut self.out[i][self.first..][..T::lanes::<S>()], value);
    }
}

/// Columns of a batch as they lie, for the text by the tensor.
struct Columns<'a, S: Simd, T> {
    simd: S,
    count: usize,
    first: usize,
    a: &'a [T],
    b: &'a [T],
    out: &'a mut [T],
}

impl<S: Simd, T: Element> Site for Columns<'_, S, T> {
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
        T::load(self.simd, &self.a[i * self.count + self.first..][..T::lanes::<S>()])
    }
    #[inline(always)]
    fn b(&self, i: usize) -> Self::Row {
        T::load(self.simd, &self.b[i * self.count + self.first..][..T::lanes::<S>()])
    }
    #[inline(always)]
    fn give(&mut self, i: usize, value: Self::Row) {
        T::store::<S>(&mut self.out[i * self.count + self.first..][..T::lanes::<S>()], value);
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
    fn with_simd<S: Simd>(mut self, simd: S) {
        let (count, lanes) = (self.count, T::lanes::<S>());
        if count < lanes {
            self.few(simd);
        } else {
            let mut first = 0;
            while first < count {
                // The last block overlaps the one before rather than be narrower.
                self.block(simd, first.min(count - lanes));
                first += lanes;
            }
        }
    }
}

impl<K: Straight, T: Element, const N: usize, const C: usize, const SQUARE: bool> Call<'_, K, T, N, C, SQUARE> {
    /// The text by the tensor is run with `C` = 1: it has no constants of nodes.
    const BY_TENSOR: bool = C == 1;

    #[inline(always)]
    fn block<S: Simd>(&mut self, simd: S, first: usize) {
        let count = self.count;
        if Self::BY_TENSOR {
            let (a, b) = (self.a, self.b);
            return pair::<K, _, SQUARE>(&mut Columns { simd, count, first, a, b, out: self.out });
        }
        let zero = T::splat(simd, T::zero());
        let (mut a, mut b, mut out) = ([zero; N], [zero; N], [zero; N]);
        for i in 0..N {
            a[i] = T::load(simd, &self.a[i * count + first..][..T::lanes::<S>()]);
            if !SQUARE {
                b[i] = T::load(simd, &self.b[i * count + first..][..T::lanes::<S>()]);
            }
        }
        if let Some(constants) = self.constants.poles.first_chunk() {
            at_poles::<K, _, SQUARE>(&mut Block::<S, T, N, C> { simd, constants, a: &a, b: &b, out: &mut out });
        }
        for constants in self.constants.pairs.as_chunks::<C>().0 {
            pair::<K, _, SQUARE>(&mut Block::<S, T, N, C> { simd, constants, a: &a, b: &b, out: &mut out });
        }
        for (i, value) in out.into_iter().enumerate() {
            T::store::<S>(&mut self.out[i * count + first..][..T::lanes::<S>()], value);
        }
    }

    /// One vector or a few, fewer than a register has lanes.
    #[inline(always)]
    fn few<S: Simd>(&mut self, simd: S) {
        let count = self.count;
        if Self::BY_TENSOR {
            let (simd, a, b) = (pulp::Scalar::new(), self.a, self.b);
            if count == 1
                && let ([Some(a), Some(b)], Some(out)) =
                    ([a, b].map(|x| x.first_chunk::<N>()), self.out.first_chunk_mut::<N>())
            {
                // Known lengths need no checks.
                return pair::<K, _, SQUARE>(&mut Columns { simd, count: 1, first: 0, a, b, out });
            }
            for first in 0..count {
                pair::<K, _, SQUARE>(&mut Columns { simd, count, first, a, b, out: self.out });
            }
            return;
        }
        for v in 0..count {
            let (mut a, mut b, mut out) = ([T::zero(); N], [T::zero(); N], [T::zero(); N]);
            for i in 0..N {
                a[i] = self.a[i * count + v];
                b[i] = if SQUARE { T::zero() } else { self.b[i * count + v] };
            }
            Self::single(simd, self.constants, &a, &b, &mut out);
            for i in 0..N {
                self.out[i * count + v] = out[i];
            }
        }
    }

    /// One vector by quadrature: nodes in lanes, added up in the order of the nodes.
    #[inline(always)]
    fn single<S: Simd>(simd: S, constants: &Constants<T>, a: &[T; N], b: &[T; N], out: &mut [T; N]) {
        let scalar = pulp::Scalar::new();
        let mut parts = [[T::zero(); MOST_PAIRS]; N];
        let (rows, pairs) = (constants.rows.as_chunks().0, constants.pairs.len() / C);
        for first in (0..pairs).step_by(T::lanes::<S>()) {
            pair::<K, _, SQUARE>(&mut Nodes { simd, first, rows: &rows[..C], a, b, out: &mut parts });
        }
        let mut sums = [T::zero(); N];
        if let Some(poles) = constants.poles.first_chunk::<C>() {
            let zero = T::splat(scalar, T::zero());
            let (mut lane_a, mut lane_b, mut lane_out) = ([zero; N], [zero; N], [zero; N]);
            for i in 0..N {
                (lane_a[i], lane_b[i]) = (T::splat(scalar, a[i]), T::splat(scalar, b[i]));
            }
            let constants = poles;
            at_poles::<K, _, SQUARE>(&mut Block::<pulp::Scalar, T, N, C> {
                simd: scalar,
                constants,
                a: &lane_a,
                b: &lane_b,
                out: &mut lane_out,
            });
            for i in 0..N {
                T::store::<pulp::Scalar>(&mut sums[i..=i], lane_out[i]);
            }
        }
        for i in 0..N {
            out[i] = parts[i][..pairs].iter().fold(sums[i], |sum, part| sum + *part);
        }
    }
}

/// A kernel for `T`, chosen by its number of bands.
type Run<T> = fn(&Constants<T>, Arch, usize, [&[T]; 2], &mut [T]);

fn run<K: Straight, T: Element, const N: usize, const C: usize, const SQUARE: bool>(
    constants: &Constants<T>,
    arch: Arch,
    count: usize,
    [a, b]: [&[T]; 2],
    out: &mut [T],
) {
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

/// The function and its multiplications, of a pair of nodes and of the poles. Compiled here for `f32` and `f64` once.
fn choose<T: Real>(bands: usize, square: bool) -> Option<(Run<T>, [usize; 2])> {
    fn typed<T: Element>(bands: usize, square: bool) -> Option<(Run<T>, [usize; 2])> {
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
    let (single, double): (Option<(Run<f32>, _)>, Option<(Run<f64>, _)>) = (typed(bands, square), typed(bands, square));
    [&single as &dyn Any, &double]
        .into_iter()
        .find_map(|found| *found.downcast_ref::<Option<(Run<T>, [usize; 2])>>()?)
}
