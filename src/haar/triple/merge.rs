//! The flat merge: a triple-product integral from two sorted lists of nodes, without recursion.
//!
//! Write c_X(n) for the four child means of X at node n, a_X(n) for its mean there, δ_X = c_X − a_X. Summing by parts,
//! node by node,
//!
//! ```math
//! mean(c_L c_B c_V) − a_L a_B a_V = mean(δ_B c_L c_V) + a_B mean(δ_L c_V)
//! ```
//!
//! because mean(c_L c_B c_V) = mean(δ_B c_L c_V) + a_B mean(c_L c_V), mean(c_L c_V) = a_L a_V + mean(δ_L c_V).
//! Telescoped over the tree,
//!
//! ```math
//! ∫ L B V = a_L a_B a_V(root) + Σ_{n ∈ B} ⟨w_B, c_L c_V⟩(n) + Σ_{n ∈ L} a_B(n) ⟨w_L, c_V⟩(n),    w = 4^{−l−1} δ.
//! ```
//!
//! It is the sum over tripling coefficients of [Ng et al. 2004] regrouped: the nodes that L and B share need no
//! intersection and the six permutations h v d no shuffles. A node costs one record of V and one record (B's nodes) or
//! one number (L's nodes) of the other factor.

use std::ops::Range;

use pulp::{Arch, NullaryFnOnce};

use super::bits::{BitPyramidRef, nibble_means, short_means, word_means};
use super::first_node;
use super::mean_tree::MeanTree;
use super::nodes::SparseNodes;
use crate::Real;

/// Nodes of each list whose sums in T are folded into f64 at once.
const BLOCK: usize = 256;

/// Four partial sums a channel.
///
/// They are filled by one dispatched function, which is never inlined and returns the four side by side, through
/// memory. The compiler then keeps them in one register of four lanes from the first node to the last. If the function
/// also added the lanes up, the compiler would work on pairs of lanes instead, which is 1.5 times slower.
type Lanes<T, const C: usize> = [[T; 4]; C];

/// Some of L's nodes, and what Σ a_B(n) ⟨w_L, c_V⟩(n) reads: a_B by node.
#[derive(Clone, Copy)]
struct LightPart<'a, T, const C: usize> {
    nodes: &'a [u32],
    weights: &'a [[[T; 4]; C]],
    brdf: &'a [T],
}

/// Some of B's nodes, and what Σ ⟨w_B, c_L c_V⟩(n) reads: c_L by node.
#[derive(Clone, Copy)]
struct BrdfPart<'a, T, const C: usize> {
    nodes: &'a [u32],
    weights: &'a [[T; 4]],
    light: &'a [[[T; 4]; C]],
}

impl<T: Real, const C: usize> LightPart<'_, T, C> {
    #[inline(always)]
    fn add(&self, lanes: &mut Lanes<T, C>, span: Range<usize>, visibility: impl Fn(usize) -> [T; 4]) {
        for (&n, w) in self.nodes[span.clone()].iter().zip(&self.weights[span]) {
            self.add_node(lanes, n as usize, w, visibility(n as usize));
        }
    }

    #[inline(always)]
    fn add_node(&self, lanes: &mut Lanes<T, C>, n: usize, w: &[[T; 4]; C], v: [T; 4]) {
        let b = self.brdf[n];
        add_products(lanes, w, [b * v[0], b * v[1], b * v[2], b * v[3]]);
    }

    fn part(self, span: Range<usize>) -> Self {
        Self { nodes: &self.nodes[span.clone()], weights: &self.weights[span], ..self }
    }
}

impl<T: Real, const C: usize> BrdfPart<'_, T, C> {
    #[inline(always)]
    fn add(&self, lanes: &mut Lanes<T, C>, span: Range<usize>, visibility: impl Fn(usize) -> [T; 4]) {
        for (&n, w) in self.nodes[span.clone()].iter().zip(&self.weights[span]) {
            self.add_node(lanes, n as usize, w, visibility(n as usize));
        }
    }

    #[inline(always)]
    fn add_node(&self, lanes: &mut Lanes<T, C>, n: usize, w: &[T; 4], v: [T; 4]) {
        add_products(lanes, &self.light[n], [w[0] * v[0], w[1] * v[1], w[2] * v[2], w[3] * v[3]]);
    }

    fn part(self, span: Range<usize>) -> Self {
        Self { nodes: &self.nodes[span.clone()], weights: &self.weights[span], ..self }
    }
}

#[inline(always)]
fn add_products<T: Real, const C: usize>(lanes: &mut Lanes<T, C>, x: &[[T; 4]; C], y: [T; 4]) {
    for c in 0..C {
        for i in 0..4 {
            lanes[c][i] += x[c][i] * y[i];
        }
    }
}

#[inline(always)]
fn sum<T: Real, const C: usize>(mut x: Lanes<T, C>, y: Lanes<T, C>) -> Lanes<T, C> {
    for c in 0..C {
        for i in 0..4 {
            x[c][i] += y[c][i];
        }
    }
    x
}

/// Both lists' sums with V's means given.
struct SumMeans<'a, T, const C: usize> {
    light: LightPart<'a, T, C>,
    brdf: BrdfPart<'a, T, C>,
    visibility: &'a [[T; 4]],
}

impl<T: Real, const C: usize> NullaryFnOnce for SumMeans<'_, T, C> {
    type Output = Lanes<T, C>;

    #[inline(always)]
    fn call(self) -> Lanes<T, C> {
        let Self { light, brdf, visibility } = self;
        // Equal lengths, so that one bounds check a node serves both of its records.
        let light = LightPart { brdf: &light.brdf[..visibility.len()], ..light };
        let brdf = BrdfPart { light: &brdf.light[..visibility.len()], ..brdf };
        // One node of each list at a time: two chains of additions in flight instead of one.
        let both = light.nodes.len().min(brdf.nodes.len());
        let (mut of_light, mut of_brdf) = ([[T::zero(); 4]; C], [[T::zero(); 4]; C]);
        let lights = light.nodes[..both].iter().zip(&light.weights[..both]);
        let brdfs = brdf.nodes[..both].iter().zip(&brdf.weights[..both]);
        for ((&l, light_weights), (&b, brdf_weights)) in lights.zip(brdfs) {
            light.add_node(&mut of_light, l as usize, light_weights, visibility[l as usize]);
            brdf.add_node(&mut of_brdf, b as usize, brdf_weights, visibility[b as usize]);
        }
        light.add(&mut of_light, both..light.nodes.len(), |n| visibility[n]);
        brdf.add(&mut of_brdf, both..brdf.nodes.len(), |n| visibility[n]);
        sum(of_light, of_brdf)
    }
}

/// Both lists' sums with V as bits.
struct SumBits<'a, T, const C: usize> {
    light: LightPart<'a, T, C>,
    brdf: BrdfPart<'a, T, C>,
    visibility: BitPyramidRef<'a>,
    /// Where in the two lists the third finest, second finest and finest level begin.
    splits: [[usize; 3]; 2],
}

impl<T: Real, const C: usize> NullaryFnOnce for SumBits<'_, T, C> {
    type Output = Lanes<T, C>;

    #[inline(always)]
    fn call(self) -> Lanes<T, C> {
        let Self { light, brdf, visibility, splits: [l, b] } = self;
        let (words, upper) = (visibility.words(), visibility.upper());
        let [word, short, nibble] = [3, 2, 1].map(|by| first_node(visibility.levels().saturating_sub(by)));
        let (mut of_light, mut of_brdf) = ([[T::zero(); 4]; C], [[T::zero(); 4]; C]);
        let above = |n: usize| upper[n + 1].map(|x| T::of(f64::from(x)));
        light.add(&mut of_light, 0..l[0], above);
        brdf.add(&mut of_brdf, 0..b[0], above);
        light.add(&mut of_light, l[0]..l[1], |n| word_means(words, n - word));
        brdf.add(&mut of_brdf, b[0]..b[1], |n| word_means(words, n - word));
        light.add(&mut of_light, l[1]..l[2], |n| short_means(words, n - short));
        brdf.add(&mut of_brdf, b[1]..b[2], |n| short_means(words, n - short));
        light.add(&mut of_light, l[2]..light.nodes.len(), |n| nibble_means(words, n - nibble));
        brdf.add(&mut of_brdf, b[2]..brdf.nodes.len(), |n| nibble_means(words, n - nibble));
        sum(of_light, of_brdf)
    }
}

#[inline(always)]
fn fold<T: Real, const C: usize>(total: &mut [f64; C], lanes: &Lanes<T, C>) {
    for (total, [a, b, c, d]) in total.iter_mut().zip(lanes) {
        *total += (a.widen() + c.widen()) + (b.widen() + d.widen());
    }
}

/// The two factors in the forms that the merge reads.
pub(super) struct Pair<'a, T, const C: usize> {
    pub(super) light: &'a SparseNodes<T, C>,
    pub(super) light_means: &'a MeanTree<T, C>,
    pub(super) brdf: &'a SparseNodes<T>,
    pub(super) brdf_means: &'a MeanTree<T>,
}

impl<'a, T: Real, const C: usize> Pair<'a, T, C> {
    #[inline]
    fn root(&self, visibility: f64) -> [f64; C] {
        let b = self.brdf.mean(0).widen() * visibility;
        std::array::from_fn(|c| self.light.mean(c).widen() * b)
    }

    #[inline]
    fn parts(&self) -> (LightPart<'a, T, C>, BrdfPart<'a, T, C>) {
        let (nodes, weights) = (self.light.nodes(), self.light.weights());
        let light = LightPart { nodes, weights, brdf: &self.brdf_means.flat()[3..] };
        let (nodes, weights) = (self.brdf.nodes(), self.brdf.weights().as_flattened());
        (light, BrdfPart { nodes, weights, light: &self.light_means.blocks()[1..] })
    }

    /// With V's means given.
    #[inline]
    pub(super) fn with_means(&self, arch: Arch, visibility: &MeanTree<T>) -> [f64; C] {
        let mut total = self.root(visibility.mean(0, 0).widen());
        let (light, brdf) = self.parts();
        let visibility = &visibility.blocks().as_flattened()[1..];
        for_blocks(light.nodes.len(), brdf.nodes.len(), |l, b| {
            let (light, brdf) = (light.part(l), brdf.part(b));
            fold(&mut total, &arch.dispatch(SumMeans { light, brdf, visibility }));
        });
        total
    }

    /// With V as bits.
    #[inline]
    pub(super) fn with_bits(&self, arch: Arch, visibility: BitPyramidRef<'_>) -> [f64; C] {
        let mut total = self.root(f64::from(visibility.mean()));
        let (light, brdf) = self.parts();
        let up = |by: u32| visibility.levels().saturating_sub(by);
        let l = [3, 2, 1].map(|by| self.light.span(0, up(by)).end);
        let b = [3, 2, 1].map(|by| self.brdf.span(0, up(by)).end);
        for_blocks(light.nodes.len(), brdf.nodes.len(), |ls, bs| {
            let clamp = |splits: [usize; 3], span: &Range<usize>| {
                splits.map(|split| split.clamp(span.start, span.end) - span.start)
            };
            let splits = [clamp(l, &ls), clamp(b, &bs)];
            let (light, brdf) = (light.part(ls), brdf.part(bs));
            fold(&mut total, &arch.dispatch(SumBits { light, brdf, visibility, splits }));
        });
        total
    }
}

/// Calls `f` with spans of at most [`BLOCK`] positions of two lists, together all of them.
#[inline(always)]
fn for_blocks(light: usize, brdf: usize, mut f: impl FnMut(Range<usize>, Range<usize>)) {
    let mut start = 0;
    loop {
        let span = |len: usize| start.min(len)..(start + BLOCK).min(len);
        f(span(light), span(brdf));
        start += BLOCK;
        if start >= light.max(brdf) {
            return;
        }
    }
}
