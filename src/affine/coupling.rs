//! Affine coupling coefficients D_ij(s, o), one by one and all that are not zero.

use super::atom::root_power;
use super::met::{Column, Met, Row};
use super::overlap::{integral, values_beside};
use super::{AffineMap, Atom};
use crate::haar::{Index2d, WaveletKind};
use crate::{Error, Result};

/// Affine coupling of two atoms of any level.
///
/// ```math
/// D(s, o) = ∫ f_{l_i,t_i}(s v + o) g_{l_j,t_j}(v) dv = 2^{(l_i − l_j)/2} M_fg(r, c)      [Sun 2008, eqs. 4.20–4.23]
/// ```
///
/// r = 2^{l_j − l_i − 1}/s, c = 2^{l_j}((t_i + ½) 2^{−l_i} − o)/s − t_j (where 2^{l_j} o is 2^{l_i} o in print); the
/// atoms are zero outside their supports. r and c, once rounded, have lost the coupling where |s| is small, so it is
/// made of what the pieces of both atoms have in common (the derivation is in the source, `overlap.rs`).
///
/// Accuracy: below 3 ε of D itself (measured: 1.6) for every map and levels up to 51, and 0 if and only if D is 0 for
/// the numbers that the map holds. Above level 51 the offset of an atom is rounded to `f64`. Cost: some 50 ns; those of
/// a whole row or operator come at a tenth of that, [`Nonzeros1d`], [`Operator1d`](super::Operator1d).
///
/// # Panics
/// If a level is above 63.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, Atom, coupling};
/// // The first half of φ, drawn twice as large, is φ again.
/// let map = AffineMap::new(0.5, 0.0)?;
/// assert_eq!(coupling(Atom::from_flat(0), Atom::from_flat(0), map), 1.0);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[track_caller]
pub fn coupling(source: Atom, target: Atom, map: AffineMap) -> f64 {
    source.check();
    target.check();
    integral(source, target, map)
}

/// [∂D/∂s, ∂D/∂o] of [`coupling`], each the right-hand derivative where D has a kink.
///
/// D is piecewise linear in o and piecewise a + b/s in s. A breakpoint b_k = (x_k − o)/s moves it by its weight w_k
/// times the target's value g_k on the side to which it moves: with the amplitudes 2^{(l_i + l_j)/2} and the signs g_k
/// decided without rounding,
///
/// ```math
/// ∂D/∂s = −2^{(l_i + l_j)/2} (Σ w_k g_k x_k − o Σ w_k g_k)/(s |s|),    ∂D/∂o = −2^{(l_i + l_j)/2} Σ w_k g_k/|s|.
/// ```
///
/// Accuracy: below 4 ε of each derivative itself, at the kinks of the numbers that the map holds and nowhere else.
///
/// # Panics
/// If a level is above 63.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, Atom, coupling_gradient};
/// let phi = Atom::from_flat(0);
/// // ∫ φ(s v + o) φ(v) dv = min(1, (1 − o)/s) = 1/s for s > 1, o = 0.
/// assert_eq!(coupling_gradient(phi, phi, AffineMap::new(2.0, 0.0)?), [-0.25, -0.5]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[track_caller]
pub fn coupling_gradient(source: Atom, target: Atom, map: AffineMap) -> [f64; 2] {
    source.check();
    target.check();
    let (s, o, x) = (map.scale(), map.offset(), source.breakpoints());
    let (amplitudes, weights) = (root_power((source.level + target.level) as i32), source.mother.weights());
    // db/ds = (o − x)/s², db/do = −1/s: a breakpoint that does not move contributes nothing.
    let moments = |velocity: [f64; 3]| {
        let values = values_beside(source, target, map, velocity);
        let (mut count, mut moment) = (0.0, 0.0);
        for k in (0..3).filter(|&k| velocity[k] != 0.0) {
            count += weights[k] * values[k];
            moment += weights[k] * values[k] * x[k];
        }
        (count, moment)
    };
    let (count, moment) = moments(x.map(|x| o - x));
    let scale = amplitudes * o.mul_add(count, -moment) / (s * s.abs());
    let (count, _) = moments([-s; 3]);
    [scale, -amplitudes * count / s.abs()]
}

/// D_ij of two functions of the 1D basis, by flat index; see [`coupling`].
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, coupling_1d};
/// assert_eq!(coupling_1d(5, 5, AffineMap::IDENTITY), 1.0);
/// assert_eq!(coupling_1d(5, 6, AffineMap::IDENTITY), 0.0);
/// ```
pub fn coupling_1d(i: usize, j: usize, map: AffineMap) -> f64 {
    coupling(Atom::from_flat(i), Atom::from_flat(j), map)
}

/// [∂D_ij/∂s, ∂D_ij/∂o] in the 1D basis, by flat index; see [`coupling_gradient`].
pub fn coupling_gradient_1d(i: usize, j: usize, map: AffineMap) -> [f64; 2] {
    coupling_gradient(Atom::from_flat(i), Atom::from_flat(j), map)
}

/// D_ij of the Q-dimensional standard basis: the product over the axes                    [Sun 2008, eq. 4.31].
///
/// `i` and `j` hold one flat 1D index an axis.
pub fn coupling_standard<const Q: usize>(i: [usize; Q], j: [usize; Q], maps: [AffineMap; Q]) -> f64 {
    (0..Q).map(|q| coupling_1d(i[q], j[q], maps[q])).product()
}

/// [∂/∂s_q, ∂/∂o_q] of [`coupling_standard`] for each axis q, right-hand as [`coupling_gradient`].
///
/// D is a product of which each axis moves one factor: ∂D/∂s_q = ∂D_q/∂s_q Π_{r≠q} D_r.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, coupling_gradient_standard};
/// let maps = [AffineMap::new(2.0, 0.0)?, AffineMap::new(1.0, 0.5)?];
/// // 1/s_x (1 − o_y) of two means.
/// assert_eq!(coupling_gradient_standard([0, 0], [0, 0], maps), [[-0.125, -0.25], [-0.25, -0.5]]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
pub fn coupling_gradient_standard<const Q: usize>(i: [usize; Q], j: [usize; Q], maps: [AffineMap; Q]) -> [[f64; 2]; Q] {
    gradient_of_product(
        std::array::from_fn(|q| coupling_1d(i[q], j[q], maps[q])),
        std::array::from_fn(|q| coupling_gradient_1d(i[q], j[q], maps[q])),
    )
}

/// The gradient of a product of one factor an axis, from the factors and their gradients; no factor is divided by.
pub(super) fn gradient_of_product<const Q: usize>(value: [f64; Q], gradient: [[f64; 2]; Q]) -> [[f64; 2]; Q] {
    std::array::from_fn(|q| {
        let others: f64 = (0..Q).filter(|&r| r != q).map(|r| value[r]).product();
        gradient[q].map(|d| d * others)
    })
}

/// D_ij of the 2D nonstandard basis, by flat index; maps of x and y.
pub fn coupling_nonstandard(i: usize, j: usize, maps: [AffineMap; 2]) -> f64 {
    let ([ix, iy], [jx, jy]) = (Atom::from_nonstandard(i), Atom::from_nonstandard(j));
    coupling(ix, jx, maps[0]) * coupling(iy, jy, maps[1])
}

/// log₂ of a size that is a power of two.
pub(super) fn levels_of(what: &'static str, size: usize) -> Result<u32> {
    if !size.is_power_of_two() {
        return Err(Error::NotPowerOfTwo { what, got: size });
    }
    Ok(size.ilog2())
}

/// The non-zero affine couplings of the 1D basis of one size, found without looking at a zero one.
///
/// An atom seen through a map has three breakpoints, and meets at most three wavelets a level: those that a breakpoint
/// falls into (the derivation is in the source, `steps.rs`). A row or column takes O(log N), a whole operator time
/// proportional to its non-zeros, of which there are Θ(N): 36, 89, 204, 445, 940, … at most near s = 1 for N = 8, 16,
/// 32, …, the scaling function included (29, 80, 193, 432, 925 without); [Sun 2008, fig. 4.6] gives the bound N log N
/// of overlapping pairs.
///
/// Values are visited in ascending order. A column has those of [`coupling_1d`], all that are not exactly zero. A row,
/// made for speed, has them to 4 ε·2^{(l_i + l_j)/2}; what is exactly zero is not visited, nor what rounds to 0.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, Nonzeros1d};
/// let nonzeros = Nonzeros1d::new(32)?;
/// assert_eq!(nonzeros.count(AffineMap::IDENTITY), 32); // orthonormal
/// let mut row = Vec::new();
/// nonzeros.row(0, AffineMap::new(1.0, 0.25)?, |j, d| row.push((j, d)));
/// assert_eq!(row, [(0, 0.75), (1, 0.25), (3, 0.3535533905932738)]); // φ moved to [−¼, ¾)
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Nonzeros1d {
    levels: u32,
}

impl Nonzeros1d {
    /// The enumeration for signals of `size` coefficients.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `size` is one.
    pub fn new(size: usize) -> Result<Self> {
        Ok(Self { levels: levels_of("size of a signal", size)? })
    }

    /// The number of coefficients of a signal.
    #[inline]
    pub fn size(self) -> usize {
        1 << self.levels
    }

    /// Visits (j, D_ij) of one source function i.
    #[inline]
    pub fn row(self, i: usize, map: AffineMap, visit: impl FnMut(usize, f64)) {
        Row::new(Atom::from_flat(i), map).basis(self.levels, visit);
    }

    /// Visits (i, D_ij) of one target function j.
    #[inline]
    pub fn column(self, j: usize, map: AffineMap, visit: impl FnMut(usize, f64)) {
        Column::new(Atom::from_flat(j), map).basis(self.levels, visit);
    }

    /// Visits (i, j, D_ij) of the whole operator, row by row.
    pub fn all(self, map: AffineMap, mut visit: impl FnMut(usize, usize, f64)) {
        for i in 0..self.size() {
            self.row(i, map, |j, value| visit(i, j, value));
        }
    }

    /// How many couplings are not zero.
    pub fn count(self, map: AffineMap) -> usize {
        let mut count = 0;
        self.all(map, |_, _, _| count += 1);
        count
    }
}

/// The non-zero affine couplings of the 2D nonstandard basis of one side, found without looking at a zero one.
///
/// The products, level by level, of what the two factors of a function meet: a wavelet factor at most three wavelets
/// and, at its edges and inside, the scaling functions of the level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NonzerosNonstandard {
    levels: u32,
}

impl NonzerosNonstandard {
    /// The enumeration for images of `side`² coefficients.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `side` is one; [`Error::OutOfRange`] above 2¹⁵.
    pub fn new(side: usize) -> Result<Self> {
        if side > 1 << 15 {
            return Err(Error::OutOfRange { what: "side of an image", got: side as f64, allowed: "at most 32768" });
        }
        Ok(Self { levels: levels_of("side of an image", side)? })
    }

    /// The side of an image.
    #[inline]
    pub fn side(self) -> usize {
        1 << self.levels
    }

    /// Visits (j, D_ij) of one source function i, level by level.
    #[inline]
    pub fn row(self, i: usize, maps: [AffineMap; 2], visit: impl FnMut(usize, f64)) {
        let [x, y] = Atom::from_nonstandard(i);
        self.products([Row::new(x, maps[0]), Row::new(y, maps[1])], visit);
    }

    /// Visits (i, D_ij) of one target function j, level by level.
    #[inline]
    pub fn column(self, j: usize, maps: [AffineMap; 2], visit: impl FnMut(usize, f64)) {
        let [x, y] = Atom::from_nonstandard(j);
        self.products([Column::new(x, maps[0]), Column::new(y, maps[1])], visit);
    }

    /// Visits (i, j, D_ij) of the whole operator, row by row.
    pub fn all(self, maps: [AffineMap; 2], mut visit: impl FnMut(usize, usize, f64)) {
        for i in 0..self.side() * self.side() {
            self.row(i, maps, |j, value| visit(i, j, value));
        }
    }

    /// How many couplings are not zero.
    pub fn count(self, maps: [AffineMap; 2]) -> usize {
        let mut count = 0;
        self.all(maps, |_, _, _| count += 1);
        count
    }

    #[inline(always)]
    fn products(self, [x, y]: [impl Met; 2], mut visit: impl FnMut(usize, f64)) {
        x.scalings(0, |_, a| y.scalings(0, |_, b| visit(0, a * b)));
        for level in 0..self.levels {
            let mut emit = |kind, x, y, value| visit(Index2d::Detail { level, kind, x, y }.flat(), value);
            y.scalings(level, |ty, b| {
                x.wavelets(level, |tx, a| emit(WaveletKind::Horizontal, tx.offset, ty.offset, a * b))
            });
            y.wavelets(level, |ty, b| {
                x.scalings(level, |tx, a| emit(WaveletKind::Vertical, tx.offset, ty.offset, a * b))
            });
            y.wavelets(level, |ty, b| {
                x.wavelets(level, |tx, a| emit(WaveletKind::Diagonal, tx.offset, ty.offset, a * b))
            });
        }
    }
}
