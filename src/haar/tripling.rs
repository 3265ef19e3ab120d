//! Tripling coefficients C_ijk = ∫ ψ_i ψ_j ψ_k in closed form, and all the non-zero ones of a basis.
//!
//! Of three Haar functions the product of the two coarser ones is constant on the support of the finest unless the two
//! finest are one and the same function (1D) or live on one node (2D). So only these triples survive:
//!
//! | | triple | C_ijk |
//! |---|---|---|
//! | 1D, 2D | φ, φ, φ | 1 |
//! | 1D, 2D | φ, j, j | 1 |
//! | 1D | coarse i, fine j, j | ±2^{l_i/2}: the sign of ψ_i on the half that holds j |
//! | 2D | coarse i, fine j, j | ±2^{l_i}: the sign of ψ_i on the quarter that holds j |
//! | 2D | horizontal, vertical, diagonal of one node | 2^l |
//!
//! Sources: [Ng, Ramamoorthi & Hanrahan 2004, §5]; [Sun 2008, eq. 4.6].

use super::{Index1d, Index2d, WaveletKind};
use crate::{Error, Real, Result};

/// An exact tripling coefficient: 0 or ±2^{e/2}.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Tripling {
    sign: i8,
    half_exponent: u32,
}

impl Tripling {
    /// The value 0.
    pub const ZERO: Self = Self { sign: 0, half_exponent: 0 };

    const fn power(half_exponent: u32, negative: bool) -> Self {
        Self { sign: if negative { -1 } else { 1 }, half_exponent }
    }

    /// Whether the coefficient vanishes.
    #[inline]
    pub fn is_zero(self) -> bool {
        self.sign == 0
    }

    /// −1, 0 or 1.
    #[inline]
    pub fn sign(self) -> i32 {
        i32::from(self.sign)
    }

    /// The e of ±2^{e/2} (0 for the value 0).
    #[inline]
    pub fn half_exponent(self) -> u32 {
        self.half_exponent
    }

    /// The value, correctly rounded: a power of two times 1 or √2.
    #[inline]
    pub fn value<T: Real>(self) -> T {
        let root = if self.half_exponent & 1 == 1 { std::f64::consts::SQRT_2 } else { 1.0 };
        T::of(f64::from(self.sign) * root * 2f64.powi((self.half_exponent / 2) as i32))
    }
}

fn sorted(mut triple: [usize; 3]) -> [usize; 3] {
    triple.sort_unstable();
    triple
}

/// Tripling coefficient of three functions of the 1D basis, by flat index, in any order.
///
/// ```math
/// C_ijk = ∫₀¹ ψ_i ψ_j ψ_k dv                                                   [Sun 2008, eq. 4.6]
/// ```
///
/// Cost: a few integer operations.
///
/// # Example
/// ```
/// use haarmonic::haar::tripling_1d;
/// // The first half of ψ_{1,0} holds ψ_{2,0}: + 2^{1/2}.
/// assert_eq!(tripling_1d(4, 2, 4).value::<f64>(), 2f64.sqrt());
/// assert_eq!(tripling_1d(2, 3, 3).value::<f64>(), 0.0);
/// ```
pub fn tripling_1d(i: usize, j: usize, k: usize) -> Tripling {
    let [i, j, k] = sorted([i, j, k]);
    if j != k {
        return Tripling::ZERO;
    }
    match (Index1d::from_flat(i), Index1d::from_flat(k)) {
        (Index1d::Scaling, _) => Tripling::power(0, false),
        (Index1d::Detail { level: coarse, offset: at }, Index1d::Detail { level: fine, offset })
            if fine > coarse && offset >> (fine - coarse) == at =>
        {
            Tripling::power(coarse, offset >> (fine - coarse - 1) & 1 == 1)
        }
        _ => Tripling::ZERO,
    }
}

/// Tripling coefficient of three functions of the 2D nonstandard basis, by flat index, in any order.
///
/// ```math
/// C_ijk = ∫∫ Ψ_i Ψ_j Ψ_k dx dy                                   [Ng et al. 2004, §5.1, the three cases]
/// ```
///
/// Always an integer. Cost: a few integer operations.
///
/// # Example
/// ```
/// use haarmonic::haar::tripling_2d;
/// // The three details of one node of level 1 (flat 4, 8 and 12): 2^1.
/// assert_eq!(tripling_2d(12, 4, 8).value::<f64>(), 2.0);
/// ```
pub fn tripling_2d(i: usize, j: usize, k: usize) -> Tripling {
    let [i, j, k] = sorted([i, j, k]);
    let Index2d::Detail { level: li, kind, x: xi, y: yi } = Index2d::from_flat(i) else {
        return if j == k { Tripling::power(0, false) } else { Tripling::ZERO };
    };
    let Index2d::Detail { level, x, y, .. } = Index2d::from_flat(k) else { return Tripling::ZERO };
    if j == k {
        if level <= li || x >> (level - li) != xi || y >> (level - li) != yi {
            return Tripling::ZERO;
        }
        let right = x >> (level - li - 1) & 1;
        let low = y >> (level - li - 1) & 1;
        return Tripling::power(2 * li, negative(kind, right, low));
    }
    // Three different functions: only the three kinds of one node. Equal levels, offsets and i < j < k make them so.
    let area = 1usize << (2 * level);
    if li == level && j.checked_sub(i) == Some(area) && k - j == area {
        return Tripling::power(2 * level, false);
    }
    Tripling::ZERO
}

/// Whether a detail is −1 on the child of column `right` and row `low`.
fn negative(kind: WaveletKind, right: usize, low: usize) -> bool {
    (kind as usize & (right | low << 1)).count_ones() & 1 == 1
}

/// How many of the size³ ordered triples (i, j, k) of the 1D basis have C_ijk ≠ 0.
///
/// ```math
/// 1 + 3(N − 1) + 3 Σ_l l 2^l = 3N log₂N − 3N + 4: 52, 148, 388, 964 for N = 8, 16, 32, 64
/// ```
///
/// # Errors
/// [`Error::NotPowerOfTwo`] unless `size` is one; [`Error::OutOfRange`] above 2⁵⁶, where the number leaves 64 bits.
pub fn tripling_count_1d(size: usize) -> Result<u64> {
    let levels = log2("1D basis size", size)?;
    // Σ_{l<k} l 2^l = (k − 2) 2^k + 2, and 1 + 3(N−1) + 3((k−2)N + 2) = 3kN − 3N + 4.
    let (n, k) = (size as u128, u128::from(levels));
    let allowed = "at most 2^56, for a number of triples that fits 64 bits";
    u64::try_from(3 * k * n + 4 - 3 * n).map_err(|_| Error::OutOfRange {
        what: "1D basis size",
        got: size as f64,
        allowed,
    })
}

/// How many of the side⁶ ordered triples of the 2D nonstandard basis have C_ijk ≠ 0.
///
/// ```math
/// 1 + 3(N² − 1) + 6 (N² − 1)/3 + 27 Σ_l l 4^l: 1288 for side 8
/// ```
///
/// # Errors
/// [`Error::NotPowerOfTwo`] unless `side` is one; [`Error::OutOfRange`] above 2²⁸, where the number leaves 64 bits.
pub fn tripling_count_2d(side: usize) -> Result<u64> {
    let levels = log2("2D basis side", side)?;
    let allowed = "at most 2^28, for a number of triples that fits 64 bits";
    let refused = Error::OutOfRange { what: "2D basis side", got: side as f64, allowed };
    if levels > 31 {
        return Err(refused);
    }
    let details = (side as u128).pow(2) - 1;
    let nested: u128 = (0..u128::from(levels)).map(|l| l << (2 * l)).sum();
    u64::try_from(1 + 5 * details + 27 * nested).map_err(|_| refused)
}

fn log2(what: &'static str, size: usize) -> Result<u32> {
    if size.is_power_of_two() { Ok(size.ilog2()) } else { Err(Error::NotPowerOfTwo { what, got: size }) }
}

/// Every triple i ≤ j ≤ k of the 1D basis of `size` functions with C_ijk ≠ 0, in lexicographic order.
///
/// Cost: proportional to the output, Θ(N log N).
///
/// # Errors
/// [`Error::NotPowerOfTwo`] unless `size` is one.
///
/// # Example
/// ```
/// use haarmonic::haar::tripling_nonzeros_1d;
/// let ordered: usize = tripling_nonzeros_1d(8)?
///     .map(|([i, j, k], _)| if i == k { 1 } else if i == j || j == k { 3 } else { 6 })
///     .sum();
/// assert_eq!(ordered, 52);
/// # Ok::<(), haarmonic::Error>(())
/// ```
pub fn tripling_nonzeros_1d(size: usize) -> Result<impl Iterator<Item = ([usize; 3], Tripling)>> {
    let levels = log2("1D basis size", size)?;
    Ok((0..size).flat_map(move |i| {
        let own = Index1d::from_flat(i);
        let first = if let Index1d::Detail { level, .. } = own { level + 1 } else { 0 };
        let scaling = (i == 0).then_some(([0, 0, 0], Tripling::power(0, false)));
        scaling.into_iter().chain((first..levels).flat_map(move |fine| {
            let (below, at) = match own {
                Index1d::Scaling => (fine, 0),
                Index1d::Detail { level, offset } => (fine - level, offset),
            };
            (at << below..(at + 1) << below).map(move |offset| {
                let j = (1 << fine) + offset;
                let value = match own {
                    Index1d::Scaling => Tripling::power(0, false),
                    Index1d::Detail { level, .. } => Tripling::power(level, offset >> (below - 1) & 1 == 1),
                };
                ([i, j, j], value)
            })
        }))
    }))
}

/// Every triple i ≤ j ≤ k of the 2D nonstandard basis of side² functions with C_ijk ≠ 0, in lexicographic order.
///
/// Cost: proportional to the output, Θ(N log N) for N = side² functions.
///
/// # Errors
/// [`Error::NotPowerOfTwo`] unless `side` is one; [`Error::OutOfRange`] if side² does not fit `usize`.
pub fn tripling_nonzeros_2d(side: usize) -> Result<impl Iterator<Item = ([usize; 3], Tripling)>> {
    let levels = log2("2D basis side", side)?;
    if side.checked_mul(side).is_none() {
        return Err(Error::OutOfRange { what: "2D basis side", got: side as f64, allowed: "such that side^2 fits" });
    }
    Ok((0..side * side).flat_map(move |i| {
        let own = Index2d::from_flat(i);
        let (own_level, first) = match own {
            Index2d::Scaling => (0, 0),
            Index2d::Detail { level, .. } => (level, level + 1),
        };
        let alone = match own {
            Index2d::Scaling => Some(([0, 0, 0], Tripling::power(0, false))),
            Index2d::Detail { level, kind: WaveletKind::Horizontal, .. } => {
                let area = 1 << (2 * level);
                Some(([i, i + area, i + 2 * area], Tripling::power(2 * level, false)))
            }
            Index2d::Detail { .. } => None,
        };
        alone.into_iter().chain((first..levels).flat_map(move |fine| {
            let below = fine - own_level;
            WaveletKind::ALL.into_iter().flat_map(move |finer| {
                (0..1usize << below)
                    .flat_map(move |dy| (0..1usize << below).map(move |dx| nested_2d(i, own, fine, finer, dx, dy)))
            })
        }))
    }))
}

/// The triple of `own` and, twice, the detail of level `fine` at (dx, dy) inside it.
fn nested_2d(i: usize, own: Index2d, fine: u32, finer: WaveletKind, dx: usize, dy: usize) -> ([usize; 3], Tripling) {
    let (x, y, value) = match own {
        Index2d::Scaling => (dx, dy, Tripling::power(0, false)),
        Index2d::Detail { level, kind, x, y } => {
            let half = fine - level - 1;
            let value = Tripling::power(2 * level, negative(kind, dx >> half, dy >> half));
            ((x << (fine - level)) + dx, (y << (fine - level)) + dy, value)
        }
    };
    let j = Index2d::Detail { level: fine, kind: finer, x, y }.flat();
    ([i, j, j], value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn orderings([i, j, k]: [usize; 3]) -> u64 {
        if i == k {
            1
        } else if i == j || j == k {
            3
        } else {
            6
        }
    }

    #[test]
    fn enumeration_equals_the_closed_form_over_all_triples() {
        for size in [1, 2, 4, 8, 16, 32] {
            let listed: Vec<_> = tripling_nonzeros_1d(size).unwrap().collect();
            let mut all = Vec::new();
            for i in 0..size {
                for j in i..size {
                    for k in j..size {
                        let value = tripling_1d(k, i, j);
                        if !value.is_zero() {
                            all.push(([i, j, k], value));
                        }
                    }
                }
            }
            assert_eq!(listed, all, "size {size}");
            let ordered: u64 = listed.iter().map(|e| orderings(e.0)).sum();
            assert_eq!(ordered, tripling_count_1d(size).unwrap());
        }
        for side in [1, 2, 4, 8] {
            let listed: Vec<_> = tripling_nonzeros_2d(side).unwrap().collect();
            let n = side * side;
            let mut all = Vec::new();
            for i in 0..n {
                for j in i..n {
                    for k in j..n {
                        let value = tripling_2d(j, k, i);
                        if !value.is_zero() {
                            all.push(([i, j, k], value));
                        }
                    }
                }
            }
            assert_eq!(listed, all, "side {side}");
            let ordered: u64 = listed.iter().map(|e| orderings(e.0)).sum();
            assert_eq!(ordered, tripling_count_2d(side).unwrap());
        }
    }

    #[test]
    fn the_documented_counts_hold_and_bad_sizes_are_refused() {
        let counts: Vec<u64> = [8, 16, 32, 64].map(|n| tripling_count_1d(n).unwrap()).to_vec();
        assert_eq!(counts, [52, 148, 388, 964]);
        assert_eq!(tripling_count_2d(8).unwrap(), 1288);
        for bad in [0, 3, 12, usize::MAX] {
            assert!(tripling_count_1d(bad).is_err() && tripling_count_2d(bad).is_err());
            assert!(tripling_nonzeros_1d(bad).is_err() && tripling_nonzeros_2d(bad).is_err());
        }
        // 3kN − 3N + 4 with k = 56; the next is beyond 2^64.
        assert_eq!(tripling_count_1d(1 << 56).unwrap(), (165 << 56) + 4);
        // 1 + 5(4^28 − 1) + 27 Σ_{l<28} l 4^l with Σ_{l<k} l 4^l = ((3k − 4) 4^k + 4)/9.
        let area = 1u128 << 56;
        assert_eq!(u128::from(tripling_count_2d(1 << 28).unwrap()), 1 + 5 * (area - 1) + 3 * (80 * area + 4));
        for (large, side) in [(57, 29), (62, 31), (63, 32), (63, 63)] {
            assert!(matches!(tripling_count_1d(1 << large), Err(Error::OutOfRange { .. })));
            assert!(matches!(tripling_count_2d(1 << side), Err(Error::OutOfRange { .. })));
        }
        assert!(matches!(tripling_nonzeros_2d(1 << 32), Err(Error::OutOfRange { .. })));
    }
}
