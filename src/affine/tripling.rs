//! Affine tripling coefficients D_ijk(s, o), one by one and all that are not zero.
//!
//! The product of two atoms is ± an atom ([`Atom::product`]), so a tripling coefficient is ± a coupling coefficient,
//! and the non-zero ones are enumerated with the same three breakpoints. For one source function i and j < k, D_ijk =
//! ±2^{l_j/2} D_ik for the ancestors j of every k that i meets; D_ikk = 2^{l_k/2} ∫ f φ_{l_k,t_k}.

use super::atom::root_power;
use super::coupling::{gradient_of_product, levels_of};
use super::met::{Column, Met, Row};
use super::{AffineMap, Atom, NonzerosNonstandard, coupling, coupling_gradient};
use crate::Result;
use crate::haar::{Index1d, Index2d, WaveletKind};

/// Affine tripling of three atoms of any level, the first of which is transformed.
///
/// ```math
/// D(s, o) = ∫ f(s v + o) g(v) h(v) dv = ±2^{l/2} ∫ f(s v + o) (atom)(v) dv       [Sun 2008, eqs. 4.10, 4.29]
/// ```
///
/// by [`Atom::product`] of g and h. For wavelets j ≠ k, n the coarse and m the fine one, this is σ 2^{(l_i − l_m +
/// l_n)/2} M(r, c) with σ = −1 where bit l_m − l_n − 1 of t_m is set; for j = k it is 2^{l_i/2} M_ψφ(r, c). The thesis
/// (Property 2) has lost σ, and the case j = k.
///
/// Accuracy: below 5 ε of D itself, and 0 if and only if D is, as [`coupling`].
///
/// # Panics
/// If a level is above 63.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, Atom, tripling};
/// let [phi, psi] = [0, 1].map(Atom::from_flat);
/// // ψ² = 1, so this is ∫₀¹ φ(v + ¼) dv.
/// assert_eq!(tripling(phi, psi, psi, AffineMap::new(1.0, 0.25)?), 0.75);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[track_caller]
pub fn tripling(source: Atom, first: Atom, second: Atom, map: AffineMap) -> f64 {
    first.product(second).map_or(0.0, |p| p.factor() * coupling(source, p.atom, map))
}

/// [∂D/∂s, ∂D/∂o] of [`tripling`], each the right-hand derivative where D has a kink.
///
/// # Panics
/// If a level is above 63.
#[track_caller]
pub fn tripling_gradient(source: Atom, first: Atom, second: Atom, map: AffineMap) -> [f64; 2] {
    first.product(second).map_or([0.0; 2], |p| coupling_gradient(source, p.atom, map).map(|d| p.factor() * d))
}

/// D_ijk of three functions of the 1D basis, by flat index; see [`tripling`].
///
/// Symmetric in j and k. At s = 1, o = 0 it is [`haar::tripling_1d`](crate::haar::tripling_1d). Lemma 1 of [Sun 2008],
/// D_ijk = Σ_{l<N} D_il C_ljk, holds exactly where j and k are below N.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, tripling_1d};
/// let map = AffineMap::new(1.5, -0.2)?;
/// assert!((tripling_1d(1, 3, 3, map) - -0.6).abs() < 1e-15);
/// # Ok::<(), haarmonic::Error>(())
/// ```
pub fn tripling_1d(i: usize, j: usize, k: usize, map: AffineMap) -> f64 {
    tripling(Atom::from_flat(i), Atom::from_flat(j), Atom::from_flat(k), map)
}

/// [∂D_ijk/∂s, ∂D_ijk/∂o] in the 1D basis, by flat index; see [`tripling_gradient`].
pub fn tripling_gradient_1d(i: usize, j: usize, k: usize, map: AffineMap) -> [f64; 2] {
    tripling_gradient(Atom::from_flat(i), Atom::from_flat(j), Atom::from_flat(k), map)
}

/// D_ijk of the Q-dimensional standard basis: the product over the axes                   [Sun 2008, eq. 4.32].
///
/// `i`, `j` and `k` hold one flat 1D index an axis.
pub fn tripling_standard<const Q: usize>(i: [usize; Q], j: [usize; Q], k: [usize; Q], maps: [AffineMap; Q]) -> f64 {
    (0..Q).map(|q| tripling_1d(i[q], j[q], k[q], maps[q])).product()
}

/// [∂/∂s_q, ∂/∂o_q] of [`tripling_standard`] for each axis q, right-hand as [`tripling_gradient`]: the product rule, as
/// in [`coupling_gradient_standard`](super::coupling_gradient_standard).
pub fn tripling_gradient_standard<const Q: usize>(
    i: [usize; Q],
    j: [usize; Q],
    k: [usize; Q],
    maps: [AffineMap; Q],
) -> [[f64; 2]; Q] {
    gradient_of_product(
        std::array::from_fn(|q| tripling_1d(i[q], j[q], k[q], maps[q])),
        std::array::from_fn(|q| tripling_gradient_1d(i[q], j[q], k[q], maps[q])),
    )
}

/// D_ijk of the 2D nonstandard basis, by flat index; maps of x and y.
///
/// Of the product of Ψ_j and Ψ_k each axis keeps ± one atom, now and then a scaling function of a level above 0.
pub fn tripling_nonstandard(i: usize, j: usize, k: usize, maps: [AffineMap; 2]) -> f64 {
    let [i, j, k] = [i, j, k].map(Atom::from_nonstandard);
    tripling(i[0], j[0], k[0], maps[0]) * tripling(i[1], j[1], k[1], maps[1])
}

/// [[∂/∂s_x, ∂/∂o_x], [∂/∂s_y, ∂/∂o_y]] of [`tripling_nonstandard`], right-hand as [`tripling_gradient`].
pub fn tripling_gradient_nonstandard(i: usize, j: usize, k: usize, maps: [AffineMap; 2]) -> [[f64; 2]; 2] {
    let [i, j, k] = [i, j, k].map(Atom::from_nonstandard);
    let value = |q: usize| tripling(i[q], j[q], k[q], maps[q]);
    let slope = |q: usize, other: f64| tripling_gradient(i[q], j[q], k[q], maps[q]).map(|d| d * other);
    [slope(0, value(1)), slope(1, value(0))]
}

/// The wavelets above ψ_{level,t} and φ, by ascending flat index: (index, the value that it has there).
#[inline(always)]
fn ancestors(level: u32, t: usize, mut visit: impl FnMut(usize, f64)) {
    visit(0, 1.0);
    for up in 0..level {
        let below = level - up;
        let amplitude = root_power(up as i32);
        let negative = t >> (below - 1) & 1 == 1;
        visit((1 << up) + (t >> below), if negative { -amplitude } else { amplitude });
    }
}

/// The non-zero affine triplings of the 1D basis of one size, found without looking at a zero one.
///
/// Time is proportional to the output, and O(log N) for two given indices. A whole operator has Θ(N log N) non-zeros;
/// [Sun 2008, §4.4.3] gives the bound N log² N.
///
/// D_ijk is symmetric in j and k: visited are those with j ≤ k. A column has the values of [`tripling_1d`], all that
/// are not exactly zero; a row and [`partners`](Self::partners) have them to rounding, as those of
/// [`Nonzeros1d`](super::Nonzeros1d).
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, TripleNonzeros1d};
/// let nonzeros = TripleNonzeros1d::new(8)?;
/// assert_eq!(nonzeros.ordered_count(AffineMap::IDENTITY), 52); // as `haar::tripling_count_1d`
/// let mut column = Vec::new();
/// nonzeros.column(1, 1, AffineMap::new(1.0, 0.25)?, |i, d| column.push((i, d)));
/// assert_eq!(column, [(0, 0.75), (1, -0.25), (2, -0.3535533905932738)]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TripleNonzeros1d {
    levels: u32,
}

impl TripleNonzeros1d {
    /// The enumeration for signals of `size` coefficients.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`](crate::Error::NotPowerOfTwo) unless `size` is one.
    pub fn new(size: usize) -> Result<Self> {
        Ok(Self { levels: levels_of("size of a signal", size)? })
    }

    /// The number of coefficients of a signal.
    #[inline]
    pub fn size(self) -> usize {
        1 << self.levels
    }

    /// Visits (j, k, D_ijk), j ≤ k, of one source function i, level by level of k.
    #[inline]
    pub fn row(self, i: usize, map: AffineMap, mut visit: impl FnMut(usize, usize, f64)) {
        let f = Row::new(Atom::from_flat(i), map);
        f.scalings(0, |_, value| visit(0, 0, value));
        for level in 0..self.levels {
            let (count, amplitude) = (1usize << level, root_power(level as i32));
            f.wavelets(level, |k, value| {
                ancestors(level, k.offset, |j, there| visit(j, count + k.offset, there * value));
            });
            f.scalings(level, |k, value| visit(count + k.offset, count + k.offset, amplitude * value));
        }
    }

    /// Visits (i, D_ijk), ascending, of two target functions j and k.
    #[inline]
    pub fn column(self, j: usize, k: usize, map: AffineMap, mut visit: impl FnMut(usize, f64)) {
        if let Some(product) = Atom::from_flat(j).product(Atom::from_flat(k)) {
            let factor = product.factor();
            Column::new(product.atom, map).basis(self.levels, |i, value| visit(i, factor * value));
        }
    }

    /// Visits (k, D_ijk), ascending, of a source function i and a target function j; k above and below j alike.
    ///
    /// These are the coefficients of ψ_i(s v + o) ψ_j(v): what a light field needs.
    #[inline]
    pub fn partners(self, i: usize, j: usize, map: AffineMap, mut visit: impl FnMut(usize, f64)) {
        let f = Row::new(Atom::from_flat(i), map);
        let Index1d::Detail { level, offset } = Index1d::from_flat(j) else {
            return f.basis(self.levels, visit);
        };
        f.wavelets(level, |met, value| {
            if met.offset == offset {
                ancestors(level, offset, |k, there| visit(k, there * value));
            }
        });
        let amplitude = root_power(level as i32);
        let mean = f.scaling(level, offset);
        if mean != 0.0 {
            visit(j, amplitude * mean);
        }
        for fine in level + 1..self.levels {
            let below = fine - level;
            f.wavelets(fine, |met, value| {
                if met.offset >> below == offset {
                    let negative = met.offset >> (below - 1) & 1 == 1;
                    visit((1 << fine) + met.offset, if negative { -amplitude * value } else { amplitude * value });
                }
            });
        }
    }

    /// Visits (i, j, k, D_ijk), j ≤ k, of the whole operator, row by row.
    pub fn all(self, map: AffineMap, mut visit: impl FnMut(usize, usize, usize, f64)) {
        for i in 0..self.size() {
            self.row(i, map, |j, k, value| visit(i, j, k, value));
        }
    }

    /// How many triplings with j ≤ k are not zero.
    pub fn count(self, map: AffineMap) -> usize {
        let mut count = 0;
        self.all(map, |_, _, _, _| count += 1);
        count
    }

    /// How many triplings are not zero, of any order of j and k.
    pub fn ordered_count(self, map: AffineMap) -> usize {
        let mut count = 0;
        self.all(map, |_, j, k, _| count += if j == k { 1 } else { 2 });
        count
    }
}

/// The non-zero affine triplings of the 2D nonstandard basis of one side, found without looking at a zero one.
///
/// As [`TripleNonzeros1d`]: of one cell, kinds multiply like the bits of their numbers under exclusive or (a kind with
/// itself: φφ).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TripleNonzerosNonstandard {
    levels: u32,
}

impl TripleNonzerosNonstandard {
    /// The enumeration for images of `side`² coefficients.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`](crate::Error::NotPowerOfTwo) unless `side` is one;
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) above 2¹⁵.
    pub fn new(side: usize) -> Result<Self> {
        NonzerosNonstandard::new(side)?;
        Ok(Self { levels: side.ilog2() })
    }

    /// The side of an image.
    #[inline]
    pub fn side(self) -> usize {
        1 << self.levels
    }

    /// Visits (i, D_ijk), level by level, of two target functions j and k.
    #[inline]
    pub fn column(self, j: usize, k: usize, maps: [AffineMap; 2], mut visit: impl FnMut(usize, f64)) {
        let (j, k) = (Atom::from_nonstandard(j), Atom::from_nonstandard(k));
        if let (Some(x), Some(y)) = (j[0].product(k[0]), j[1].product(k[1])) {
            let factor = x.factor() * y.factor();
            let axes = [Column::new(x.atom, maps[0]), Column::new(y.atom, maps[1])];
            axes[0].scalings(0, |_, a| axes[1].scalings(0, |_, b| visit(0, factor * (a * b))));
            for level in 0..self.levels {
                each_detail(&axes, level, |i, _, value| visit(i, factor * value));
            }
        }
    }

    /// Visits (j, k, D_ijk), j ≤ k, of one source function i, level by level of k.
    pub fn row(self, i: usize, maps: [AffineMap; 2], mut visit: impl FnMut(usize, usize, f64)) {
        let [x, y] = Atom::from_nonstandard(i);
        let axes = [Row::new(x, maps[0]), Row::new(y, maps[1])];
        axes[0].scalings(0, |_, a| axes[1].scalings(0, |_, b| visit(0, 0, a * b)));
        for level in 0..self.levels {
            let (count, amplitude) = (1usize << (2 * level), root_power(2 * level as i32));
            each_detail(&axes, level, |k, cell, value| {
                // The product of two different kinds of a cell is the third.
                let kind = k / count;
                let others = [1, 2, 3].map(|other| k - kind * count + other * count);
                let [j, l] = [[others[1], others[2]], [others[0], others[2]], [others[0], others[1]]][kind - 1];
                visit(j, l, amplitude * value);
                visit(0, k, value);
                for up in 0..level {
                    above(cell, level, up, |j, there| visit(j, k, there * value));
                }
            });
            let [x, y] = &axes;
            y.scalings(level, |ty, b| {
                x.scalings(level, |tx, a| {
                    for kind in WaveletKind::ALL {
                        let k = Index2d::Detail { level, kind, x: tx.offset, y: ty.offset }.flat();
                        visit(k, k, amplitude * (a * b));
                    }
                });
            });
        }
    }

    /// Visits (i, j, k, D_ijk), j ≤ k, of the whole operator, row by row.
    pub fn all(self, maps: [AffineMap; 2], mut visit: impl FnMut(usize, usize, usize, f64)) {
        for i in 0..self.side() * self.side() {
            self.row(i, maps, |j, k, value| visit(i, j, k, value));
        }
    }

    /// How many triplings with j ≤ k are not zero.
    pub fn count(self, maps: [AffineMap; 2]) -> usize {
        let mut count = 0;
        self.all(maps, |_, _, _, _| count += 1);
        count
    }
}

/// Visits the details of a level that are met: (flat index, offset in x and y, product of the couplings).
#[inline(always)]
fn each_detail<M: Met>([x, y]: &[M; 2], level: u32, mut visit: impl FnMut(usize, [usize; 2], f64)) {
    let mut emit = |kind, tx: Atom, ty: Atom, value| {
        visit(Index2d::Detail { level, kind, x: tx.offset, y: ty.offset }.flat(), [tx.offset, ty.offset], value);
    };
    y.scalings(level, |ty, b| x.wavelets(level, |tx, a| emit(WaveletKind::Horizontal, tx, ty, a * b)));
    y.wavelets(level, |ty, b| x.scalings(level, |tx, a| emit(WaveletKind::Vertical, tx, ty, a * b)));
    y.wavelets(level, |ty, b| x.wavelets(level, |tx, a| emit(WaveletKind::Diagonal, tx, ty, a * b)));
}

/// The three details of level `up` above the cell (tx, ty) of `level`: (index, the value that it has there).
#[inline(always)]
fn above([tx, ty]: [usize; 2], level: u32, up: u32, mut visit: impl FnMut(usize, f64)) {
    let below = level - up;
    let halves = (tx >> (below - 1) & 1) | (ty >> (below - 1) & 1) << 1;
    let amplitude = root_power(2 * up as i32);
    for kind in WaveletKind::ALL {
        let negative = (kind as usize & halves).count_ones() & 1 == 1;
        let j = Index2d::Detail { level: up, kind, x: tx >> below, y: ty >> below }.flat();
        visit(j, if negative { -amplitude } else { amplitude });
    }
}
