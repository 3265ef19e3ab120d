//! The product of two signals, from coefficients to coefficients.
//!
//! With the means a_f, a_g of a node and S(n) = Σ f_j g_j over the details at and below n, the tripling coefficients
//! collapse to one pass down (means) and one up (S):
//!
//! ```text
//! 1D: (fg)_n = a_f g_n + a_g f_n + 2^{l/2} [S(left) − S(right)],   (fg)_0 = f_0 g_0 + S(root)
//! 2D: (fg)_{n,k} = a_f g_k + a_g f_k + 2^l [f_i g_j + f_j g_i + Σ_c ±_k S(child c)],   {i, j, k} = {h, v, d}
//! ```
//!
//! | signals | use | cost |
//! |---|---|---|
//! | dense | [`Product1d`], [`Product2d`] | O(N), no transform to samples and back |
//! | sparse | [`multiply_sparse_1d`], [`multiply_sparse_2d`] | O(terms × levels) |
//! | more than two | [`NFoldProduct`](super::NFoldProduct) | |

use super::wavelet_tree::WaveletTree;
use super::{NFoldProduct, SparseVector};
use crate::error::check_length;
use crate::{Error, Real, Result};

/// Product of two 1D signals given by dense coefficients.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Product1d {
    size: usize,
}

impl Product1d {
    /// A plan for signals of `size` coefficients.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `size` is one; [`Error::OutOfRange`] if the scratch cannot be addressed.
    pub fn new(size: usize) -> Result<Self> {
        match size.checked_mul(3) {
            _ if !size.is_power_of_two() => Err(Error::NotPowerOfTwo { what: "1D size", got: size }),
            None => {
                Err(Error::OutOfRange { what: "1D size", got: size as f64, allowed: "addressable, with its scratch" })
            }
            Some(_) => Ok(Self { size }),
        }
    }

    /// How many scalars of scratch [`Self::apply`] needs.
    pub fn scratch_len(&self) -> usize {
        3 * self.size
    }

    /// out = coefficients of f · g.
    ///
    /// Shapes: f, g, out: size, flat 1D index; scratch: [`Self::scratch_len`], its contents don't matter.
    /// Accuracy: a few eps times log₂ size times max|f| max|g|. Cost: O(size).
    ///
    /// # Panics
    /// If a length is wrong.
    #[track_caller]
    pub fn apply<T: Real>(&self, f: &[T], g: &[T], out: &mut [T], scratch: &mut [T]) {
        let n = self.size;
        check_length("f", n, f.len());
        check_length("g", n, g.len());
        check_length("out", n, out.len());
        check_length("scratch", self.scratch_len(), scratch.len());
        // Node n of the tree is the detail's own flat index; its children are 2n and 2n + 1.
        let (mean_f, rest) = scratch.split_at_mut(n);
        let (mean_g, below) = rest.split_at_mut(n);
        if n > 1 {
            (mean_f[1], mean_g[1]) = (f[0], g[0]);
        }
        for node in 1..n / 2 {
            let height = WaveletTree::<T, 2>::amplitude(node.ilog2());
            let (df, dg) = (height * f[node], height * g[node]);
            (mean_f[2 * node], mean_f[2 * node + 1]) = (mean_f[node] + df, mean_f[node] - df);
            (mean_g[2 * node], mean_g[2 * node + 1]) = (mean_g[node] + dg, mean_g[node] - dg);
        }
        for node in (1..n).rev() {
            let mut sum = f[node] * g[node];
            out[node] = mean_f[node] * g[node] + mean_g[node] * f[node];
            if 2 * node < n {
                let (left, right) = (below[2 * node], below[2 * node + 1]);
                out[node] += WaveletTree::<T, 2>::amplitude(node.ilog2()) * (left - right);
                sum += left + right;
            }
            below[node] = sum;
        }
        out[0] = f[0] * g[0] + if n > 1 { below[1] } else { T::zero() };
    }
}

/// Product of two 2D signals given by dense nonstandard coefficients.
///
/// # Example
/// ```
/// use haarmonic::haar::Product2d;
/// let plan = Product2d::new(2)?;
/// let (mut out, mut scratch) = ([0.0; 4], vec![0.0; plan.scratch_len()]);
/// // horizontal × vertical = diagonal on the root's node
/// plan.apply(&[0.0, 1.0, 0.0, 0.0], &[0.0, 0.0, 1.0, 0.0], &mut out, &mut scratch);
/// assert_eq!(out, [0.0, 0.0, 0.0, 1.0]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Product2d {
    side: usize,
}

impl Product2d {
    /// A plan for signals of `side`² coefficients.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `side` is one; [`Error::OutOfRange`] if an image cannot be addressed.
    pub fn new(side: usize) -> Result<Self> {
        match side.checked_mul(side) {
            _ if !side.is_power_of_two() => Err(Error::NotPowerOfTwo { what: "2D side", got: side }),
            None => Err(Error::OutOfRange { what: "2D side", got: side as f64, allowed: "addressable when squared" }),
            Some(_) => Ok(Self { side }),
        }
    }

    /// How many scalars of scratch [`Self::apply`] needs: three for each of the (side² − 1)/3 nodes.
    pub fn scratch_len(&self) -> usize {
        self.side * self.side - 1
    }

    /// out = coefficients of f · g.
    ///
    /// Shapes: f, g, out: side², flat nonstandard index; scratch: [`Self::scratch_len`], its contents don't matter.
    /// Accuracy: a few eps times log₂ side times max|f| max|g|. Cost: O(side²).
    ///
    /// # Panics
    /// If a length is wrong.
    #[track_caller]
    pub fn apply<T: Real>(&self, f: &[T], g: &[T], out: &mut [T], scratch: &mut [T]) {
        let n = self.side * self.side;
        check_length("f", n, f.len());
        check_length("g", n, g.len());
        check_length("out", n, out.len());
        check_length("scratch", self.scratch_len(), scratch.len());
        let levels = self.side.ilog2();
        let nodes = (n - 1) / 3;
        let (mean_f, rest) = scratch.split_at_mut(nodes);
        let (mean_g, below) = rest.split_at_mut(nodes);
        if nodes > 0 {
            (mean_f[0], mean_g[0]) = (f[0], g[0]);
        }
        for level in 0..levels.saturating_sub(1) {
            means_down(level, f, mean_f);
            means_down(level, g, mean_g);
        }
        for level in (0..levels).rev() {
            details_up(level, levels, [f, g], [mean_f, mean_g], below, out);
        }
        out[0] = f[0] * g[0] + if nodes > 0 { below[0] } else { T::zero() };
    }
}

/// First node of a level in the order level, y, x.
fn level_start(level: u32) -> usize {
    ((1 << (2 * level)) - 1) / 3
}

/// Nodes of the four children of (x, y).
fn children(level: u32, x: usize, y: usize) -> [usize; 4] {
    let first = level_start(level + 1) + ((2 * y) << (level + 1)) + 2 * x;
    [first, first + 1, first + (2 << level), first + (2 << level) + 1]
}

/// The three details of a node.
fn details<T: Real>(coefficients: &[T], level: u32, at: usize) -> [T; 3] {
    let count = 1 << (2 * level);
    std::array::from_fn(|kind| coefficients[(kind + 1) * count + at])
}

fn means_down<T: Real>(level: u32, coefficients: &[T], means: &mut [T]) {
    let height = WaveletTree::<T, 4>::amplitude(level);
    for y in 0..1 << level {
        for x in 0..1 << level {
            let at = (y << level) + x;
            let mean = means[level_start(level) + at];
            let [h, v, d] = details(coefficients, level, at).map(|c| height * c);
            let values = [mean + h + v + d, mean - h + v - d, mean + h - v - d, mean - h - v + d];
            for (child, value) in children(level, x, y).into_iter().zip(values) {
                means[child] = value;
            }
        }
    }
}

fn details_up<T: Real>(level: u32, levels: u32, [f, g]: [&[T]; 2], means: [&[T]; 2], below: &mut [T], out: &mut [T]) {
    let height = WaveletTree::<T, 4>::amplitude(level);
    let count = 1 << (2 * level);
    for y in 0..1usize << level {
        for x in 0..1usize << level {
            let at = (y << level) + x;
            let node = level_start(level) + at;
            let ([fh, fv, fd], [gh, gv, gd]) = (details(f, level, at), details(g, level, at));
            let (mf, mg) = (means[0][node], means[1][node]);
            let mut sum = fh * gh + fv * gv + fd * gd;
            let mut cross = [fv * gd + fd * gv, fh * gd + fd * gh, fh * gv + fv * gh];
            if level + 1 < levels {
                let [a, b, c, d] = children(level, x, y).map(|child| below[child]);
                cross[0] += a - b + c - d;
                cross[1] += a + b - c - d;
                cross[2] += a - b - c + d;
                sum += a + b + c + d;
            }
            out[count + at] = mf * gh + mg * fh + height * cross[0];
            out[2 * count + at] = mf * gv + mg * fv + height * cross[1];
            out[3 * count + at] = mf * gd + mg * fd + height * cross[2];
            below[node] = sum;
        }
    }
}

/// The coefficients of the product of two sparse 1D signals; builds trees for [`NFoldProduct`] and discards them.
///
/// # Errors
/// [`Error::Length`] unless the sizes agree, [`Error::NotPowerOfTwo`] unless they are powers of two.
pub fn multiply_sparse_1d<T: Real>(f: &SparseVector<T>, g: &SparseVector<T>) -> Result<SparseVector<T>> {
    multiply_sparse::<T, 2>(f, g)
}

/// The coefficients of the product of two sparse 2D signals (nonstandard basis).
///
/// # Errors
/// [`Error::Length`] unless the sizes agree, [`Error::NotPowerOfTwo`] unless their sides are powers of two.
pub fn multiply_sparse_2d<T: Real>(f: &SparseVector<T>, g: &SparseVector<T>) -> Result<SparseVector<T>> {
    multiply_sparse::<T, 4>(f, g)
}

fn multiply_sparse<T: Real, const CHILDREN: usize>(
    f: &SparseVector<T>,
    g: &SparseVector<T>,
) -> Result<SparseVector<T>> {
    if f.len() != g.len() {
        return Err(Error::Length { what: "coefficients of the second factor", expected: f.len(), got: g.len() });
    }
    let (f, g) = (WaveletTree::<T, CHILDREN>::new(f)?, WaveletTree::<T, CHILDREN>::new(g)?);
    Ok(NFoldProduct::new().coefficients(&[&f, &g]))
}
