//! The triple-product integral of [Ng, Ramamoorthi & Hanrahan 2004]: a recursion over the quadtree with parent sums.

use crate::error::check_length;
use crate::haar::SparseVector;
use crate::haar::triple::levels_of;
use crate::haar::wavelet_tree::{NONE, morton};
use crate::{Error, Real, Result};

/// A sparse 2D signal as a quadtree of details, the form that [`NgTripleProduct`] traverses.
#[derive(Debug, Clone, PartialEq)]
pub struct NgTree<T> {
    levels: u32,
    mean: T,
    nodes: Vec<NgNode<T>>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct NgNode<T> {
    details: [T; 3],
    children: [u32; 4],
}

impl<T: Real> NgTree<T> {
    /// The tree of sparse nonstandard coefficients: nodes with details and their ancestors.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless the dense length is the square of one; [`Error::OutOfRange`] above a side of
    /// 2¹⁴.
    pub fn new(coefficients: &SparseVector<T>) -> Result<Self> {
        let len = coefficients.len();
        if !len.is_power_of_two() || len.ilog2() % 2 == 1 {
            return Err(Error::NotPowerOfTwo { what: "the side of a 2D signal", got: len });
        }
        let mut tree = Self { levels: levels_of(1 << (len.ilog2() / 2))?, mean: T::zero(), nodes: Vec::new() };
        for (flat, value) in coefficients.iter() {
            let Some(log) = flat.checked_ilog2() else {
                tree.mean = value;
                continue;
            };
            let level = log / 2;
            let at = flat & ((1 << (2 * level)) - 1);
            let path = morton(at & ((1 << level) - 1), at >> level);
            let node = tree.node_at(level, path);
            tree.nodes[node].details[(flat >> (2 * level)) - 1] = value;
        }
        Ok(tree)
    }

    /// The node at the end of a path, made if need be.
    fn node_at(&mut self, level: u32, path: usize) -> usize {
        let empty = NgNode { details: [T::zero(); 3], children: [NONE; 4] };
        if self.nodes.is_empty() {
            self.nodes.push(empty);
        }
        let mut at = 0;
        for up in (0..level).rev() {
            let child = path >> (2 * up) & 3;
            if self.nodes[at].children[child] == NONE {
                self.nodes[at].children[child] = self.nodes.len() as u32;
                self.nodes.push(empty);
            }
            at = self.nodes[at].children[child] as usize;
        }
        at
    }

    fn root(&self) -> u32 {
        if self.nodes.is_empty() { NONE } else { 0 }
    }
}

/// ∫ L B V with L and B sparse and V dense, as published: the comparison for everything faster.
///
/// With parent sums s_X (the mean of X over the node) carried down, a node of level l contributes
///
/// ```math
/// s_L Σ_k B_k V_k + s_B Σ_k L_k V_k + s_V Σ_k L_k B_k + 2^l Σ_perm L_h B_v V_d               [Ng et al. 2004, §6.2]
/// ```
///
/// and a subtree where neither L nor B has a detail is skipped: there two of the three details are zero in every term.
/// Cost: linear in the nodes of L and B and their ancestors.
#[derive(Debug, Clone, Copy, Default)]
pub struct NgTripleProduct;

/// One node of the descent.
#[derive(Clone, Copy)]
struct At<T> {
    level: u32,
    x: usize,
    y: usize,
    light: u32,
    brdf: u32,
    sums: [T; 3],
}

impl NgTripleProduct {
    /// ∫ L B V over the unit square; V by its dense nonstandard coefficients.
    ///
    /// Accuracy: recursion in T, total in f64.
    ///
    /// # Panics
    /// If the sizes differ.
    #[track_caller]
    pub fn integral<T: Real>(light: &NgTree<T>, brdf: &NgTree<T>, visibility: &[T]) -> f64 {
        check_length("side of the BRDF's tree (log₂)", light.levels as usize, brdf.levels as usize);
        check_length("coefficients of the visibility", 1 << (2 * light.levels), visibility.len());
        let sums = [light.mean, brdf.mean, visibility[0]];
        let mut total = sums[0].widen() * sums[1].widen() * sums[2].widen();
        let root = At { level: 0, x: 0, y: 0, light: light.root(), brdf: brdf.root(), sums };
        if root.light != NONE || root.brdf != NONE {
            visit(light, brdf, visibility, root, &mut total);
        }
        total
    }
}

fn visit<T: Real>(light: &NgTree<T>, brdf: &NgTree<T>, visibility: &[T], at: At<T>, total: &mut f64) {
    let At { level, x, y, sums: [sl, sb, sv], .. } = at;
    let empty = NgNode { details: [T::zero(); 3], children: [NONE; 4] };
    let l = if at.light == NONE { &empty } else { &light.nodes[at.light as usize] };
    let b = if at.brdf == NONE { &empty } else { &brdf.nodes[at.brdf as usize] };
    let (count, offset) = (1usize << (2 * level), (y << level) + x);
    let v = [1, 2, 3].map(|kind| visibility[kind * count + offset]);
    let (p, q) = (l.details, b.details);
    let height = T::of(f64::from(1u32 << level));
    let dot = |f: [T; 3], g: [T; 3]| f[0] * g[0] + f[1] * g[1] + f[2] * g[2];
    let mixed =
        p[0] * (q[1] * v[2] + q[2] * v[1]) + p[1] * (q[0] * v[2] + q[2] * v[0]) + p[2] * (q[0] * v[1] + q[1] * v[0]);
    *total += (sl * dot(q, v) + sb * dot(p, v) + sv * dot(p, q) + height * mixed).widen();
    for child in 0..4 {
        let (next_light, next_brdf) = (l.children[child], b.children[child]);
        if next_light == NONE && next_brdf == NONE {
            continue;
        }
        let sum = |s: T, [h, v, d]: [T; 3]| {
            let h = if child & 1 == 0 { h } else { -h };
            let v = if child & 2 == 0 { v } else { -v };
            let d = if child == 0 || child == 3 { d } else { -d };
            s + height * (h + v + d)
        };
        let next = At {
            level: level + 1,
            x: 2 * x + (child & 1),
            y: 2 * y + (child >> 1),
            light: next_light,
            brdf: next_brdf,
            sums: [sum(sl, p), sum(sb, q), sum(sv, v)],
        };
        visit(light, brdf, visibility, next, total);
    }
}
