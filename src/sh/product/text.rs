//! What the straight-line text is written against: where it takes its numbers, and the constants of its nodes.

use super::nodes::{Rule, factors, normalized_legendre};
use crate::Real;
use crate::sh::lane::Lane;

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
pub(super) fn pair<K: Straight, P: Site, const SQUARE: bool>(p: &mut P) {
    if SQUARE { K::square(p) } else { K::product(p) }
}

#[inline(always)]
pub(super) fn at_poles<K: Straight, P: Site, const SQUARE: bool>(p: &mut P) {
    if SQUARE { K::square_at_poles(p) } else { K::product_at_poles(p) }
}

/// Constants of the nodes, `C` to a pair: N P_lm to evaluate, then to project.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Constants<T> {
    pub poles: Vec<T>,
    /// Pair by pair.
    pub pairs: Vec<T>,
    /// `C` for each [`lanes`] pairs, side by side; zeros where there are fewer.
    pub lanes: Vec<T>,
}

impl<T: Real> Constants<T> {
    pub(super) fn new(bands: usize) -> Self {
        let degree = 3 * (bands - 1);
        let gauss = Rule::gauss(degree).expect("at least one node");
        let lobatto = Rule::lobatto(degree);
        let rule = if lobatto.pairs.len() < gauss.pairs.len() { lobatto } else { gauss };
        let of = |z: f64, weight: f64| {
            let values = normalized_legendre(bands, z).expect("a size in range");
            let orders = (0..bands).flat_map(|m| std::iter::repeat_n(m, bands - m));
            [0, 1].into_iter().flat_map(move |which| {
                let orders = orders.clone();
                values.clone().into_iter().zip(orders).map(move |(p, m)| T::of(p * factors(m, weight)[which]))
            })
        };
        let pairs: Vec<T> = rule.pairs.iter().flat_map(|&[z, weight]| of(z, weight)).collect();
        let count = bands * (bands + 1);
        let width = lanes(bands * bands);
        let mut lanes = vec![T::zero(); rule.pairs.len().div_ceil(width) * count * width];
        for (k, constants) in pairs.chunks_exact(count).enumerate() {
            let group = lanes[k / width * count * width..].chunks_exact_mut(width);
            constants.iter().zip(group).for_each(|(c, lanes)| lanes[k % width] = *c);
        }
        let poles = if rule.poles > 0.0 { of(1.0, rule.poles).collect() } else { Vec::new() };
        Self { poles, pairs, lanes }
    }
}

/// Whether the text is the one by the tensor. That has no constants of nodes, and is run with `c` = 1.
pub(super) const fn by_tensor(c: usize) -> bool {
    c == 1
}

/// Pairs of nodes side by side, up to six bands and above.
pub(super) const FEW: usize = 4;
pub(super) const MANY: usize = 8;

/// Pairs of nodes side by side for vectors of `size`.
pub(super) const fn lanes(size: usize) -> usize {
    if size <= 36 { FEW } else { MANY }
}
