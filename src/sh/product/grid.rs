//! Products by quadrature for any numbers of bands: what the straight-line text does, in loops.
//!
//! At a circle of constant z both factors are trigonometric polynomials Σ α_m e^{imφ}, α_m = c_m − i s_m; the product's
//! are
//!
//! ```math
//! H_0 = α_0 β_0 + 2 Re Σ_{m>0} α_m β̄_m
//! H_M = α_0 β_M + α_M β_0 + Σ_{0<m<M} α_m β_{M−m} + Σ_{m>0} (α_{M+m} β̄_m + ᾱ_m β_{M+m})
//! ```
//!
//! summed directly. A Fourier transform in azimuth would do fewer operations for many bands; it has not been tried.
//! Near the poles high orders vanish, N P_lm ~ sin^m θ, and are left out where they are below 1e-3 eps. Exact up to
//! rounding: the rule integrates every polynomial that occurs.

use std::any::Any;

use pulp::{Arch, Simd, WithSimd};

use super::nodes::{Rule, factors, normalized_legendre};
use super::text::Site;
use crate::sh::gamma::met;
use crate::sh::lane::Element;
use crate::{Error, Real, Result};

/// The most bands that can meet: the work space of a call is on the stack.
const MOST_BANDS: usize = 128;

/// Pairs of nodes that share their number of orders: at least the lanes of a register.
const GROUP: usize = 16;

/// Bands that meet, the nodes, and the harmonics there.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Nodes<T> {
    /// Of a, b and the product.
    bands: [usize; 3],
    /// b is a.
    square: bool,
    /// The most of them, for which the constants are.
    most: usize,
    pairs: usize,
    /// Constants of a pair of nodes: N P_lm to evaluate, then to project, order by order.
    constants: usize,
    /// Orders that matter, for each group of pairs.
    orders: Vec<usize>,
    /// Pair by pair.
    by_pair: Vec<T>,
    /// Group by group of pairs, constant by constant.
    by_constant: Vec<T>,
}

impl<T: Real> Nodes<T> {
    fn new(bands: [usize; 3], square: bool) -> Result<Self> {
        let bands = met(bands)?;
        let most = bands.into_iter().max().unwrap_or(1);
        if most > MOST_BANDS {
            let allowed = "at most 128 bands that meet";
            return Err(Error::OutOfRange { what: "bands", got: most as f64, allowed });
        }
        let rule = Rule::gauss(bands.iter().sum::<usize>() - 3)?;
        let (pairs, constants) = (rule.pairs.len(), most * (most + 1));
        let groups = pairs.div_ceil(GROUP);
        let (orders, by_pair, by_constant) = (vec![1; groups], Vec::new(), Vec::new());
        let mut nodes = Self { bands, square, most, pairs, constants, orders, by_pair, by_constant };
        let tiny = 1e-3 * T::epsilon().widen();
        for (k, &[z, weight]) in rule.pairs.iter().enumerate() {
            let values = normalized_legendre(most, z)?;
            for which in [0, 1] {
                let mut values = values.iter();
                for m in 0..most {
                    let factor = factors(m, weight)[which];
                    for _ in m..most {
                        let value = *values.next().expect("all (l, m)");
                        let zero = value.abs() < tiny;
                        nodes.by_pair.push(T::of(if zero { 0.0 } else { factor * value }));
                        if !zero {
                            nodes.orders[k / GROUP] = nodes.orders[k / GROUP].max(m + 1);
                        }
                    }
                }
            }
        }
        nodes.by_constant = vec![T::zero(); groups * constants * GROUP];
        for (at, value) in nodes.by_pair.iter().enumerate() {
            let (k, i) = (at / constants, at % constants);
            nodes.by_constant[((k / GROUP) * constants + i) * GROUP + k % GROUP] = *value;
        }
        Ok(nodes)
    }

    /// Multiplications of a product, those in vain in unused lanes not counted.
    fn multiplications(&self) -> usize {
        (0..self.pairs).map(|k| self.multiplications_of_pair(self.orders[k / GROUP])).sum()
    }

    fn multiplications_of_pair(&self, orders: usize) -> usize {
        let [a, b, out] = self.bands.map(|n| n.min(orders));
        let sums = |n: usize| (0..orders.min(n)).map(|m| (n - m) * if m == 0 { 1 } else { 2 }).sum::<usize>();
        let evaluated = if self.square { 0 } else { sums(self.bands[1]) };
        let convolution = (1..out).map(|m| {
            let constant = 2 * (usize::from(m < a) + usize::from(m < b));
            let below = m.min(a).saturating_sub(1.max((m + 1).saturating_sub(b)));
            let [above, other] = [[a, b], [b, a]].map(|[x, y]| y.min(x.saturating_sub(m)).saturating_sub(1));
            constant + 4 * (below + above + if self.square { 0 } else { other })
        });
        let whole = 2 * a.min(b) - 1 + convolution.sum::<usize>();
        sums(self.bands[0]) + evaluated + sums(self.bands[2]) + 2 * whole
    }
}

/// Fourier coefficients at a pair of nodes: cosines and sines at z, then at −z.
type Circles<R, const ROWS: usize> = [[[R; ROWS]; 2]; 2];

/// Of one factor, b or a.
#[inline(always)]
fn evaluate<P: Site, const ROWS: usize, const B: bool>(
    p: &P,
    (bands, most): (usize, usize),
    orders: usize,
    to: &mut Circles<P::Row, ROWS>,
) {
    let x = |i: usize| if B { p.b(i) } else { p.a(i) };
    let mut place = 0;
    for m in 0..orders.min(bands).min(ROWS) {
        let zero = p.literal(0.0);
        let (mut even, mut odd) = ([zero; 2], [zero; 2]);
        for l in (m..bands).step_by(2) {
            let (c, middle) = (p.constant(place + l - m), l * l + l);
            even = [even[0] + c * x(middle + m), even[1] + c * x(middle - m)];
            if l + 1 < bands {
                let (c, middle) = (p.constant(place + l + 1 - m), (l + 1) * (l + 2));
                odd = [odd[0] + c * x(middle + m), odd[1] + c * x(middle - m)];
            }
        }
        for part in 0..2 {
            to[0][part][m] = even[part] + odd[part];
            to[1][part][m] = even[part] - odd[part];
        }
        place += most - m;
    }
}

/// H_0.. of one circle. Sums are kept apart by the kind of their terms, for the processor's sake.
#[inline(always)]
fn convolve<P: Site, const ROWS: usize>(
    p: &P,
    [a, b, out]: [usize; 3],
    [[ac, a_s], [bc, bs]]: [&[[P::Row; ROWS]; 2]; 2],
    square: bool,
    [hc, hs]: &mut [[P::Row; ROWS]; 2],
) {
    let zero = p.literal(0.0);
    let (mut cc, mut ss) = (zero, zero);
    for m in 1..a.min(b).min(ROWS) {
        cc = cc + ac[m] * bc[m];
        ss = ss + a_s[m] * bs[m];
    }
    let half = cc + ss;
    hc[0] = ac[0] * bc[0] + (half + half);
    for order in 1..out.min(ROWS) {
        let (mut cc, mut ss, mut cs, mut sc) = (zero, zero, zero, zero);
        if order < b {
            cc = ac[0] * bc[order];
            cs = ac[0] * bs[order];
        }
        if order < a {
            cc = cc + ac[order] * bc[0];
            sc = a_s[order] * bc[0];
        }
        // α_m β_{M−m}
        let (first, end) = (1.max((order + 1).saturating_sub(b)), order.min(a));
        if first < end {
            let turned = order - (end - 1)..order - first + 1;
            let (rows_a, rows_b) =
                (ac[first..end].iter().zip(&a_s[first..end]), bc[turned.clone()].iter().zip(&bs[turned]));
            for ((c1, s1), (c2, s2)) in rows_a.zip(rows_b.rev()) {
                cc = cc + *c1 * *c2;
                ss = ss + *s1 * *s2;
                cs = cs + *c1 * *s2;
                sc = sc + *s1 * *c2;
            }
        }
        let (mut with, mut sine) = (cc - ss, cs + sc);
        // α_{M+m} β̄_m
        let end = b.min(a.saturating_sub(order)).max(1);
        let (mut cc, mut ss, mut cs, mut sc) = (zero, zero, zero, zero);
        let upper = ac[order..][1..end].iter().zip(&a_s[order..][1..end]);
        for ((c1, s1), (c2, s2)) in upper.zip(bc[1..end].iter().zip(&bs[1..end])) {
            cc = cc + *c1 * *c2;
            ss = ss + *s1 * *s2;
            cs = cs + *c1 * *s2;
            sc = sc + *s1 * *c2;
        }
        with = with + (cc + ss);
        sine = sine + (sc - cs);
        // ᾱ_m β_{M+m}, the same again in a square
        if square {
            hc[order] = with + (cc + ss);
            hs[order] = sine + (sc - cs);
            continue;
        }
        let end = a.min(b.saturating_sub(order)).max(1);
        let (mut cc, mut ss, mut cs, mut sc) = (zero, zero, zero, zero);
        let upper = bc[order..][1..end].iter().zip(&bs[order..][1..end]);
        for ((c1, s1), (c2, s2)) in ac[1..end].iter().zip(&a_s[1..end]).zip(upper) {
            cc = cc + *c1 * *c2;
            ss = ss + *s1 * *s2;
            cs = cs + *c1 * *s2;
            sc = sc + *s1 * *c2;
        }
        hc[order] = with + (cc + ss);
        hs[order] = sine + (cs - sc);
    }
}

/// Adds what a pair of nodes gives to the coefficients of the product.
#[inline(always)]
fn project<P: Site, const ROWS: usize>(
    p: &mut P,
    bands: usize,
    most: usize,
    orders: usize,
    from: &Circles<P::Row, ROWS>,
) {
    let mut place = most * (most + 1) / 2;
    for m in 0..orders.min(bands).min(ROWS) {
        for part in 0..if m == 0 { 1 } else { 2 } {
            let (north, south) = (from[0][part][m], from[1][part][m]);
            let [even, odd] = [north + south, north - south];
            for l in m..bands {
                let h = if (l - m) % 2 == 0 { even } else { odd };
                let at = if part == 0 { l * l + l + m } else { l * l + l - m };
                p.give(at, p.constant(place + l - m) * h);
            }
        }
        place += most - m;
    }
}

/// A block of vectors at one pair of nodes.
struct Block<'a, S: Simd, T> {
    simd: S,
    constants: &'a [T],
    count: usize,
    first: usize,
    a: &'a [T],
    b: &'a [T],
    out: &'a mut [T],
}

impl<S: Simd, T: Element> Site for Block<'_, S, T> {
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
        T::load(self.simd, &self.a[i * self.count + self.first..][..T::lanes::<S>()])
    }
    #[inline(always)]
    fn b(&self, i: usize) -> Self::Row {
        T::load(self.simd, &self.b[i * self.count + self.first..][..T::lanes::<S>()])
    }
    #[inline(always)]
    fn give(&mut self, i: usize, value: Self::Row) {
        let out = &mut self.out[i * self.count + self.first..][..T::lanes::<S>()];
        let sum = T::load(self.simd, out) + value;
        T::store::<S>(out, sum);
    }
}

/// One vector at as many pairs of nodes as a register has lanes, `width` of them real.
struct Lanes<'a, S: Simd, T> {
    simd: S,
    constants: &'a [[T; GROUP]],
    lane: usize,
    width: usize,
    /// The vector in its batch.
    count: usize,
    v: usize,
    a: &'a [T],
    b: &'a [T],
    out: &'a mut [T],
}

impl<S: Simd, T: Element> Site for Lanes<'_, S, T> {
    type Row = T::Reg<S>;
    #[inline(always)]
    fn constant(&self, i: usize) -> Self::Row {
        T::load(self.simd, &self.constants[i][self.lane..][..T::lanes::<S>()])
    }
    #[inline(always)]
    fn literal(&self, value: f64) -> Self::Row {
        T::splat(self.simd, T::of(value))
    }
    #[inline(always)]
    fn a(&self, i: usize) -> Self::Row {
        T::splat(self.simd, self.a[i * self.count + self.v])
    }
    #[inline(always)]
    fn b(&self, i: usize) -> Self::Row {
        T::splat(self.simd, self.b[i * self.count + self.v])
    }
    #[inline(always)]
    fn give(&mut self, i: usize, value: Self::Row) {
        let mut parts = [T::zero(); GROUP];
        T::store::<S>(&mut parts[..T::lanes::<S>()], value);
        let out = &mut self.out[i * self.count + self.v];
        *out = parts[..self.width].iter().fold(*out, |sum, part| sum + *part);
    }
}

struct Call<'a, T, const ROWS: usize> {
    nodes: &'a Nodes<T>,
    count: usize,
    factors: [&'a [T]; 2],
    out: &'a mut [T],
}

impl<T: Element, const ROWS: usize> WithSimd for Call<'_, T, ROWS> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let (count, lanes) = (self.count, T::lanes::<S>());
        let zero = T::splat(simd, T::zero());
        let mut space = [[[[zero; ROWS]; 2]; 2]; 3];
        self.out.fill(T::zero());
        if count < lanes {
            (0..count).for_each(|v| self.single(simd, v, &mut space));
            return;
        }
        for first in (0..count).step_by(lanes) {
            // The last block overlaps the one before rather than be narrower.
            let start = first.min(count - lanes);
            if start < first {
                let kept = self.nodes.bands[2] * self.nodes.bands[2];
                for row in self.out.chunks_exact_mut(count).take(kept) {
                    row[start..start + lanes].fill(T::zero());
                }
            }
            self.block(simd, start, &mut space);
        }
    }
}

impl<T: Element, const ROWS: usize> Call<'_, T, ROWS> {
    #[inline(always)]
    fn block<S: Simd>(&mut self, simd: S, first: usize, space: &mut [Circles<T::Reg<S>, ROWS>; 3]) {
        let (nodes, count, [a, b]) = (self.nodes, self.count, self.factors);
        for (k, constants) in nodes.by_pair.chunks_exact(nodes.constants).enumerate() {
            let site = Block { simd, constants, count, first, a, b, out: self.out };
            pair(site, nodes, nodes.orders[k / GROUP], space);
        }
    }

    #[inline(always)]
    fn single<S: Simd>(&mut self, simd: S, v: usize, space: &mut [Circles<T::Reg<S>, ROWS>; 3]) {
        let (nodes, count, [a, b], lanes) = (self.nodes, self.count, self.factors, T::lanes::<S>());
        for first in (0..nodes.pairs).step_by(lanes) {
            let (group, lane, width) = (first / GROUP, first % GROUP, lanes.min(nodes.pairs - first));
            let constants = &nodes.by_constant.as_chunks().0[group * nodes.constants..][..nodes.constants];
            let site = Lanes { simd, constants, lane, width, count, v, a, b, out: self.out };
            pair(site, nodes, nodes.orders[group], space);
        }
    }
}

/// All that is to be done at a pair of nodes.
#[inline(always)]
fn pair<T: Element, P: Site, const ROWS: usize>(
    mut p: P,
    nodes: &Nodes<T>,
    orders: usize,
    [a, b, h]: &mut [Circles<P::Row, ROWS>; 3],
) {
    let [bands_a, bands_b, bands_out] = nodes.bands;
    evaluate::<P, ROWS, false>(&p, (bands_a, nodes.most), orders, a);
    if !nodes.square {
        evaluate::<P, ROWS, true>(&p, (bands_b, nodes.most), orders, b);
    }
    let b = if nodes.square { &*a } else { &*b };
    for side in 0..2 {
        let bands = nodes.bands.map(|n| n.min(orders));
        convolve(&p, bands, [&a[side], &b[side]], nodes.square, &mut h[side]);
    }
    project(&mut p, bands_out, nodes.most, orders, h);
}

type Run<T> = fn(&Nodes<T>, Arch, usize, [&[T]; 2], &mut [T]);

fn run<T: Element, const ROWS: usize>(nodes: &Nodes<T>, arch: Arch, count: usize, factors: [&[T]; 2], out: &mut [T]) {
    arch.dispatch(Call::<T, ROWS> { nodes, count, factors, out });
}

/// A product by quadrature.
#[derive(Debug, Clone)]
pub(super) struct Grid<T> {
    nodes: Nodes<T>,
    run: Run<T>,
}

impl<T: Real> Grid<T> {
    pub fn new(bands: [usize; 3], square: bool) -> Result<Self> {
        let nodes = Nodes::new(bands, square)?;
        let run = choose(nodes.most);
        Ok(Self { nodes, run })
    }

    pub fn multiplications(&self) -> usize {
        self.nodes.multiplications()
    }

    /// `count` vectors; the lengths have been checked.
    pub fn run(&self, arch: Arch, count: usize, factors: [&[T]; 2], out: &mut [T]) {
        (self.run)(&self.nodes, arch, count, factors, out);
    }
}

/// Compiled here for `f32` and `f64` once.
fn choose<T: Real>(most: usize) -> Run<T> {
    fn typed<T: Element>(most: usize) -> Run<T> {
        if most <= 24 { run::<T, 24> } else { run::<T, MOST_BANDS> }
    }
    let (single, double) = (typed::<f32>(most), typed::<f64>(most));
    let found = [&single as &dyn Any, &double].into_iter().find_map(|run| run.downcast_ref::<Run<T>>().copied());
    found.expect("T is f32 or f64")
}
