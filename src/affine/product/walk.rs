//! One traversal of the trees of the fixed factors, with the transformed one integrated cell by cell.

use crate::Real;
use crate::affine::atom::power;
use crate::haar::WaveletTree;
use crate::haar::wavelet_tree::NONE;

/// A number, or an array of them, that can be added up with a factor.
pub(super) trait Linear: Copy {
    const ZERO: Self;

    fn add(&mut self, factor: f64, other: &Self);
}

impl Linear for f64 {
    const ZERO: Self = 0.0;

    #[inline(always)]
    fn add(&mut self, factor: f64, other: &Self) {
        *self += factor * other;
    }
}

impl<L: Linear, const M: usize> Linear for [L; M] {
    const ZERO: Self = [L::ZERO; M];

    #[inline(always)]
    fn add(&mut self, factor: f64, other: &Self) {
        for (sum, x) in self.iter_mut().zip(other) {
            sum.add(factor, x);
        }
    }
}

/// A dyadic interval (y = 0) or square of the target.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    level: u32,
    at: [usize; 2],
}

impl Cell {
    const ROOT: Self = Self { level: 0, at: [0, 0] };

    #[inline(always)]
    fn child(self, child: usize) -> Self {
        Self { level: self.level + 1, at: [2 * self.at[0] + (child & 1), 2 * self.at[1] + (child >> 1)] }
    }

    /// Where it begins, is half over and ends along an axis.
    #[inline(always)]
    pub(super) fn cuts(self, axis: usize) -> [f64; 3] {
        let (width, t) = (power(-(self.level as i32)), self.at[axis] as f64);
        [t * width, (t + 0.5) * width, (t + 1.0) * width]
    }
}

/// The transformed function on a cell.
pub(super) enum Seen<S, const CHILDREN: usize> {
    /// 0 there, and just beside the present s and o too.
    Nothing,
    /// One value there: its integral over the cell.
    Constant(S),
    /// Its integral over each child.
    Parts([S; CHILDREN]),
}

/// A transformed function, ready to be integrated over cells.
pub(super) trait Source<const CHILDREN: usize> {
    /// An integral, or several, or with derivatives.
    type Sum: Linear;

    fn seen(&self, cell: Cell) -> Seen<Self::Sum, CHILDREN>;
}

/// A factor on the current cell: its node there, if it varies, and its mean.
#[derive(Debug, Clone, Copy)]
struct Cursor {
    node: u32,
    mean: f64,
}

/// ∫ F(s v + o) Π_k G_k(v) dv.
pub(super) fn integrate<S: Source<CHILDREN>, T: Real, const CHILDREN: usize, const K: usize>(
    source: &S,
    factors: [&WaveletTree<T, CHILDREN>; K],
) -> S::Sum {
    let cursors = factors.map(|tree| Cursor { node: tree.root(), mean: tree.mean().widen() });
    let mut sum = S::Sum::ZERO;
    walk(source, &factors, &cursors, Cell::ROOT, &mut sum);
    sum
}

fn walk<S: Source<CHILDREN>, T: Real, const CHILDREN: usize, const K: usize>(
    source: &S,
    factors: &[&WaveletTree<T, CHILDREN>; K],
    cursors: &[Cursor; K],
    cell: Cell,
    sum: &mut S::Sum,
) {
    let parts = match source.seen(cell) {
        Seen::Nothing => return,
        Seen::Constant(whole) => return sum.add(mean(factors, cursors), &whole),
        Seen::Parts(parts) => parts,
    };
    for child in 0..CHILDREN {
        let (below, constant, varies) = descend(factors, cursors, child);
        if varies && constant != 0.0 {
            walk(source, factors, &below, cell.child(child), sum);
        } else {
            sum.add(constant, &parts[child]);
        }
    }
}

/// The factors on a child; the product of those that are constant there; whether any is not.
#[inline(always)]
fn descend<T: Real, const CHILDREN: usize, const K: usize>(
    factors: &[&WaveletTree<T, CHILDREN>; K],
    cursors: &[Cursor; K],
    child: usize,
) -> ([Cursor; K], f64, bool) {
    let (mut constant, mut varies) = (1.0, false);
    let mut below = *cursors;
    for (factor, cursor) in factors.iter().zip(&mut below) {
        if cursor.node != NONE {
            let node = factor.node(cursor.node);
            *cursor = Cursor { node: node.children[child], mean: cursor.mean + node.deviations[child].widen() };
        }
        if cursor.node == NONE {
            constant *= cursor.mean;
        } else {
            varies = true;
        }
    }
    (below, constant, varies)
}

/// The mean over the current cell of the product of the factors.
fn mean<T: Real, const CHILDREN: usize, const K: usize>(
    factors: &[&WaveletTree<T, CHILDREN>; K],
    cursors: &[Cursor; K],
) -> f64 {
    if cursors.iter().filter(|c| c.node != NONE).count() <= 1 {
        return cursors.iter().map(|c| c.mean).product();
    }
    let part = |child| {
        let (below, constant, varies) = descend(factors, cursors, child);
        if varies && constant != 0.0 { mean(factors, &below) } else { constant }
    };
    (0..CHILDREN).map(part).sum::<f64>() / CHILDREN as f64
}
