//! The flat merge: a triple-product integral from two sorted lists of nodes, without recursion.
//!
//! Write c_X(n) for the four child means of X at node n, a_X(n) for its mean there, δ_X = c_X − a_X. Summing by parts, node by node,
//!
//!   mean(c_L c_B c_V) − a_L a_B a_V = mean(δ_B c_L c_V) + a_B mean(δ_L c_V)
//!
//! because mean(c_L c_B c_V) = mean(δ_B c_L c_V) + a_B mean(c_L c_V), mean(c_L c_V) = a_L a_V + mean(δ_L c_V). Telescoped over the tree,
//!
//!   ∫ L B V = a_L a_B a_V(root) + Σ_{n ∈ B} ⟨w_B, c_L c_V⟩(n) + Σ_{n ∈ L} a_B(n) ⟨w_L, c_V⟩(n),    w = 4^{−l−1} δ.
//!
//! It is the sum over tripling coefficients of [Ng et al. 2004] regrouped: the nodes that L and B share need no intersection and the
//! six permutations h v d no shuffles. A node costs one record of V and one record (B's nodes) or one number (L's nodes) of the other factor.

use super::bits::{BitPyramidRef, nibble_means, short_means, word_means};
use super::mean_tree::{MeanTree, first_node};
use super::nodes::SparseNodes;
use crate::Real;

/// Nodes whose f32 sums are folded into f64 at once.
const BLOCK: usize = 256;

/// Four partial sums a channel, in T; folded into f64 now and then.
struct Lanes<T, const C: usize>([[T; 4]; C]);

impl<T: Real, const C: usize> Lanes<T, C> {
    #[inline(always)]
    fn zero() -> Self {
        Self([[T::zero(); 4]; C])
    }

    #[inline(always)]
    fn fold(&self, total: &mut [f64; C]) {
        for (total, [a, b, c, d]) in total.iter_mut().zip(self.0) {
            *total += (a.widen() + b.widen()) + (c.widen() + d.widen());
        }
    }
}

/// Σ_{n ∈ L} a_B(n) ⟨w_L, c_V⟩(n) over some of L's nodes.
#[inline(always)]
fn light_part<T: Real, const C: usize>(
    nodes: &[u32],
    weights: &[[[T; 4]; C]],
    brdf_means: &[T],
    visibility: impl Fn(usize) -> [T; 4],
    total: &mut [f64; C],
) {
    for (nodes, weights) in nodes.chunks(BLOCK).zip(weights.chunks(BLOCK)) {
        let mut lanes = Lanes::<T, C>::zero();
        for (&n, w) in nodes.iter().zip(weights) {
            let v = visibility(n as usize);
            let b = brdf_means[n as usize + 3];
            let v = [b * v[0], b * v[1], b * v[2], b * v[3]];
            for c in 0..C {
                for i in 0..4 {
                    lanes.0[c][i] += w[c][i] * v[i];
                }
            }
        }
        lanes.fold(total);
    }
}

/// Σ_{n ∈ B} ⟨w_B, c_L c_V⟩(n) over some of B's nodes.
#[inline(always)]
fn brdf_part<T: Real, const C: usize>(
    nodes: &[u32],
    weights: &[[[T; 4]; 1]],
    light: &[[[T; 4]; C]],
    visibility: impl Fn(usize) -> [T; 4],
    total: &mut [f64; C],
) {
    for (nodes, weights) in nodes.chunks(BLOCK).zip(weights.chunks(BLOCK)) {
        let mut lanes = Lanes::<T, C>::zero();
        for (&n, [w]) in nodes.iter().zip(weights) {
            let v = visibility(n as usize);
            let l = &light[n as usize + 1];
            let v = [w[0] * v[0], w[1] * v[1], w[2] * v[2], w[3] * v[3]];
            for c in 0..C {
                for i in 0..4 {
                    lanes.0[c][i] += l[c][i] * v[i];
                }
            }
        }
        lanes.fold(total);
    }
}

/// The two factors in the forms that the merge reads.
pub(super) struct Pair<'a, T, const C: usize> {
    pub(super) light: &'a SparseNodes<T, C>,
    pub(super) light_means: &'a MeanTree<T, C>,
    pub(super) brdf: &'a SparseNodes<T>,
    pub(super) brdf_means: &'a MeanTree<T>,
}

impl<T: Real, const C: usize> Pair<'_, T, C> {
    #[inline(always)]
    fn root(&self, visibility: f64) -> [f64; C] {
        let b = self.brdf.mean(0).widen() * visibility;
        std::array::from_fn(|c| self.light.mean(c).widen() * b)
    }

    /// With V's means given.
    #[inline(always)]
    pub(super) fn with_means(&self, visibility: &MeanTree<T>) -> [f64; C] {
        let mut total = self.root(visibility.mean(0, 0).widen());
        let blocks = visibility.blocks().as_flattened();
        let record = |n: usize| blocks[n + 1];
        light_part(self.light.nodes(), self.light.weights(), self.brdf_means.flat(), record, &mut total);
        brdf_part(self.brdf.nodes(), self.brdf.weights(), self.light_means.blocks(), record, &mut total);
        total
    }

    /// With V as bits.
    #[inline(always)]
    pub(super) fn with_bits(&self, bits: BitPyramidRef<'_>) -> [f64; C] {
        let mut total = self.root(f64::from(bits.mean()));
        let (levels, words, upper) = (bits.levels(), bits.words(), bits.upper());
        let above = levels.saturating_sub(3);
        self.levels(0, above, |n| upper[n + 1].map(|x| T::of(f64::from(x))), &mut total);
        if levels >= 3 {
            let first = first_node(levels - 3);
            self.levels(levels - 3, levels - 2, |n| word_means(words, n - first), &mut total);
        }
        if levels >= 2 {
            let first = first_node(levels - 2);
            self.levels(levels - 2, levels - 1, |n| short_means(words, n - first), &mut total);
        }
        if levels >= 1 {
            let first = first_node(levels - 1);
            self.levels(levels - 1, levels, |n| nibble_means(words, n - first), &mut total);
        }
        total
    }

    /// Both sums over the nodes of some levels.
    #[inline(always)]
    fn levels(&self, from: u32, to: u32, visibility: impl Fn(usize) -> [T; 4] + Copy, total: &mut [f64; C]) {
        let (l, b) = (self.light.span(from, to), self.brdf.span(from, to));
        let (nodes, weights) = (&self.light.nodes()[l.clone()], &self.light.weights()[l]);
        light_part(nodes, weights, self.brdf_means.flat(), visibility, total);
        let (nodes, weights) = (&self.brdf.nodes()[b.clone()], &self.brdf.weights()[b]);
        brdf_part(nodes, weights, self.light_means.blocks(), visibility, total);
    }
}
