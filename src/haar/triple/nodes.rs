//! Sparse details, node by node, as the flat merge reads them.

use super::super::SparseVector;
use super::super::wavelet_tree::{is_negative, morton};
use super::first_node;
use crate::{Error, Real, Result};

/// The details of C sparse 2D signals that share one set of nodes, sorted by node.
///
/// Nodes are numbered as in [`MeanTree`](super::MeanTree). For each stored node n of level l and each channel there are
/// four weights, ¼ 4^{−l} (±h ± v ± d) 2^l: what each child's mean deviates from the node's own, times the child's
/// area. So ∫ f g = a_f a_g + Σ_n ⟨weights_f(n), child means of g(n)⟩.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SparseNodes<T, const C: usize = 1> {
    levels: u32,
    means: [T; C],
    nodes: Vec<u32>,
    weights: Vec<[[T; 4]; C]>,
    /// Position of the first stored node of each level, and the number of nodes.
    starts: Vec<u32>,
}

impl<T: Real, const C: usize> SparseNodes<T, C> {
    /// The nodes of sparse nonstandard coefficients, one vector a channel.
    ///
    /// Cost: O(terms log terms).
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless the dense length is the square of one; [`Error::OutOfRange`] above a side of
    /// 2¹⁴; [`Error::Length`] unless the channels agree; [`Error::Empty`] if there is no channel.
    pub(super) fn new(coefficients: [&SparseVector<T>; C]) -> Result<Self> {
        let Some(first) = coefficients.first() else { return Err(Error::Empty { what: "the list of channels" }) };
        let len = first.len();
        if !len.is_power_of_two() || len.ilog2() % 2 == 1 {
            return Err(Error::NotPowerOfTwo { what: "the side of a 2D signal", got: len });
        }
        let levels = super::levels_of(1 << (len.ilog2() / 2))?;
        let mut means = [T::zero(); C];
        let mut terms = Vec::new();
        for (channel, c) in coefficients.into_iter().enumerate() {
            if c.len() != len {
                return Err(Error::Length { what: "coefficients of a channel", expected: len, got: c.len() });
            }
            for (flat, value) in c.iter() {
                match flat.checked_ilog2() {
                    None => means[channel] = value,
                    Some(_) if value == T::zero() => {}
                    Some(log) => {
                        let level = log / 2;
                        let at = flat & ((1 << (2 * level)) - 1);
                        let m = morton(at & ((1 << level) - 1), at >> level);
                        terms.push(((first_node(level) + m) as u32, channel, flat >> (2 * level), value));
                    }
                }
            }
        }
        terms.sort_unstable_by_key(|&(node, channel, kind, _)| (node, channel, kind));
        Ok(Self::gather(levels, means, &terms))
    }

    fn gather(levels: u32, means: [T; C], terms: &[(u32, usize, usize, T)]) -> Self {
        let mut nodes = Vec::new();
        let mut weights: Vec<[[T; 4]; C]> = Vec::new();
        for &(node, channel, kind, value) in terms {
            if nodes.last() != Some(&node) {
                nodes.push(node);
                weights.push([[T::zero(); 4]; C]);
            }
            // ¼ 4^{−l} 2^l = 2^{−l−2}
            let weight = value * T::of(0.5f64.powi(level_of(node) as i32 + 2));
            let four = &mut weights.last_mut().expect("pushed above")[channel];
            for (child, w) in four.iter_mut().enumerate() {
                *w += if is_negative(kind, child) { -weight } else { weight };
            }
        }
        let starts = (0..=levels).map(|l| nodes.partition_point(|&n| (n as usize) < first_node(l)) as u32).collect();
        Self { levels, means, nodes, weights, starts }
    }

    /// The side of the signals.
    #[inline]
    pub(super) fn side(&self) -> usize {
        1 << self.levels
    }

    /// log₂ of the side.
    #[inline]
    pub(super) fn levels(&self) -> u32 {
        self.levels
    }

    /// The mean of a channel (its coefficient 0).
    ///
    /// # Panics
    /// If there is no such channel.
    #[track_caller]
    #[inline]
    pub(super) fn mean(&self, channel: usize) -> T {
        self.means[channel]
    }

    /// How many nodes have a detail.
    #[inline]
    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// The nodes, ascending.
    #[inline]
    pub(super) fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// The four weights of each channel, node after node.
    #[inline]
    pub(super) fn weights(&self) -> &[[[T; 4]; C]] {
        &self.weights
    }

    /// Nodes and weights of one level.
    pub(crate) fn level(&self, level: u32) -> impl Iterator<Item = (&u32, &[[T; 4]; C])> {
        self.range(level, level + 1)
    }

    /// Where the nodes of the levels from `from` up to, not including, `to` are stored.
    #[inline]
    pub(crate) fn span(&self, from: u32, to: u32) -> std::ops::Range<usize> {
        self.starts[from as usize] as usize..self.starts[to as usize] as usize
    }

    fn range(&self, from: u32, to: u32) -> impl Iterator<Item = (&u32, &[[T; 4]; C])> {
        let span = self.span(from, to);
        self.nodes[span.clone()].iter().zip(&self.weights[span])
    }
}

/// The level of a node: 4^l ≤ 3n + 1.
#[inline]
pub(crate) fn level_of(node: u32) -> u32 {
    (3 * u64::from(node) + 1).ilog2() / 2
}
