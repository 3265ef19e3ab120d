//! The triple-product tensor Γ_ijk = ∫ y_i y_j y_k of the real spherical harmonics.
//!
//! Selection rules, with i = (l₁, m₁) and so on: Γ vanishes unless
//!
//! 1. |l₁ − l₂| ≤ l₃ ≤ l₁ + l₂ and l₁ + l₂ + l₃ is even,
//! 2. the largest of |m₁|, |m₂|, |m₃| is the sum of the other two,
//! 3. an even number of the three orders is negative (sines).
//!
//! Some of what they allow vanishes all the same: *accidental* zeros, found here because the sum that decides is one of
//! integers.
//!
//! Derivation. Write y_{lm} = c_m(φ) Θ_l^{|m|}(θ), c_0 = 1, c_m = √2 cos mφ, c_{−m} = √2 sin mφ. With M the largest
//! |m|, at place 3, and the other two m₁, m₂ ≥ 0, so that M = m₁ + m₂, Gaunt's integral of complex harmonics (its
//! Condon–Shortley sign (−1)^M taken out) gives
//!
//! ```math
//! Γ = A (−1)^M √(Π(2l+1)/4π) (l₁ l₂ l₃; 0 0 0) (l₁ l₂ l₃; m₁ m₂ −M),   A the mean of c_{m₁} c_{m₂} c_{m₃} over φ.
//! ```
//!
//! Racah's sum for the second 3j symbol is, in binomials, with a = l₁+l₂−l₃, b = l₁−l₂+l₃, c = −l₁+l₂+l₃, J =
//! l₁+l₂+l₃ = 2g,
//!
//! ```math
//! (−1)^{l₁−l₂+M} S √(Π(l+m)!(l−m)! / (a! b! c! (J+1)!)),   S = Σ_k (−1)^k C(a, k) C(b, l₁−m₁−k) C(c, l₂+m₂−k),
//! ```
//!
//! and the first is (−1)^g √(a! b! c!/(J+1)!) g!/((g−l₁)! (g−l₂)! (g−l₃)!). The roots of a! b! c! cancel:
//!
//! ```math
//! Γ = A (−1)^{l₁−l₂+g} S · g!/Π(g−l)! · Π√((2l+1)/C(2l, l+m)) · √(Π(2l)!)/(J+1)! / √4π.
//! ```
//!
//! S and the multinomial are integers (|S| ≤ 2^J), exact in 128 bits up to J = 126; what is left is a product of
//! positive numbers, without cancellation. Sources: [Sun 2008, §2.4]; the 3j symbols are Racah's.

use std::sync::OnceLock;

use crate::{Error, Result};

/// The largest l₁ + l₂ + l₃ of which S fits an `i128`.
const MAX_DEGREE_SUM: usize = 126;

/// 1/√4π = Γ_0jj, correctly rounded.
pub(super) const CONSTANT: f64 = std::f64::consts::FRAC_2_SQRT_PI / 4.0;

/// Degree and order of a flat index.
pub(super) fn degree_order(flat: usize) -> (usize, isize) {
    let l = flat.isqrt();
    (l, flat as isize - (l * (l + 1)) as isize)
}

fn flat(l: usize, m: isize) -> usize {
    ((l * (l + 1)) as isize + m) as usize
}

/// Pascal's triangle and factorials.
struct Tables {
    binomials: Vec<u128>,
    factorials: Vec<f64>,
}

impl Tables {
    fn shared() -> &'static Self {
        static TABLES: OnceLock<Tables> = OnceLock::new();
        TABLES.get_or_init(Self::new)
    }

    fn new() -> Self {
        let mut binomials: Vec<u128> = Vec::with_capacity((MAX_DEGREE_SUM + 1) * (MAX_DEGREE_SUM + 2) / 2);
        for n in 0..=MAX_DEGREE_SUM {
            for k in 0..=n {
                let above = n.wrapping_sub(1) * n / 2;
                binomials.push(if k == 0 || k == n { 1 } else { binomials[above + k - 1] + binomials[above + k] });
            }
        }
        // In pairs hi + lo, so that every factorial is right to the last bit or nearly: 127 roundings would cost 1e-15.
        let (mut factorials, mut hi, mut lo) = (vec![1.0], 1.0f64, 0.0f64);
        for n in 1..=MAX_DEGREE_SUM + 1 {
            let n = n as f64;
            let product = hi * n;
            lo = lo * n + hi.mul_add(n, -product);
            hi = product + lo;
            lo -= hi - product;
            factorials.push(hi);
        }
        Self { binomials, factorials }
    }

    /// C(n, k), 0 for k outside 0..=n.
    fn binomial(&self, n: usize, k: isize) -> u128 {
        match usize::try_from(k) {
            Ok(k) if k <= n => self.binomials[n * (n + 1) / 2 + k],
            _ => 0,
        }
    }

    /// Racah's sum S of degrees `l` and orders m₁, m₂ ≥ 0, m₃ = −(m₁+m₂): 0 exactly if Γ is.
    fn racah(&self, l: [usize; 3], m: [usize; 2]) -> i128 {
        let [l1, l2, l3] = l;
        let (a, b, c) = (l1 + l2 - l3, l1 + l3 - l2, l2 + l3 - l1);
        let (first, second) = (l1 as isize - m[0] as isize, (l2 + m[1]) as isize);
        // The three binomials are at most 2^a, 2^b, 2^c, and the sum of the terms' magnitudes is at most 2^J < 2^127.
        (0..=a as isize).fold(0, |sum, k| {
            let term = self.binomial(a, k) * self.binomial(b, first - k) * self.binomial(c, second - k);
            if k & 1 == 0 { sum + term as i128 } else { sum - term as i128 }
        })
    }

    /// Γ of three harmonics that the selection rules allow.
    fn allowed_gamma(&self, l: [usize; 3], m: [isize; 3]) -> f64 {
        let mut order: [usize; 3] = [0, 1, 2];
        order.sort_by_key(|&i| (m[i].unsigned_abs(), l[i])); // the largest |m| last, whatever the caller's order
        let (l, m) = (order.map(|i| l[i]), order.map(|i| m[i]));
        if let Some(zero) = l.iter().position(|&l| l == 0) {
            debug_assert!(m[zero] == 0);
            return CONSTANT;
        }
        let absolute = m.map(isize::unsigned_abs);
        let sum = self.racah(l, [absolute[0], absolute[1]]);
        if sum == 0 {
            return 0.0;
        }
        let degrees: usize = l.iter().sum();
        let half = degrees / 2;
        let multinomial = self.binomial(half, (half - l[0]) as isize) * self.binomial(l[0], (half - l[1]) as isize);
        let orders: f64 = (0..3)
            .map(|i| {
                let choices = self.binomial(2 * l[i], (l[i] + absolute[i]) as isize);
                (2 * l[i] + 1) as f64 / choices as f64
            })
            .product();
        // (2l)!/(J+1)! twice, so that nothing overflows or vanishes: every partial product is within 10^±220.
        let whole = self.factorials[degrees + 1];
        let [f1, f2, f3] = l.map(|l| self.factorials[2 * l]);
        let degree_part = f1 / whole * f2 * (f3 / whole);
        let magnitude = sum as f64 * multinomial as f64 * (orders * degree_part).sqrt() * CONSTANT;
        let negative = (l[0] + l[1] + half) & 1 == 1;
        azimuth(m) * if negative { -magnitude } else { magnitude }
    }
}

/// Mean over φ of c_{m₁} c_{m₂} c_{m₃}, the largest |m| last, for orders that the selection rules allow.
///
/// From 2√2 · ¼ with all cosines or one of the smaller and the largest a sine, −2√2 · ¼ with the two smaller as sines.
fn azimuth(m: [isize; 3]) -> f64 {
    if m[0] == 0 {
        1.0
    } else if m[0] < 0 && m[1] < 0 {
        -std::f64::consts::FRAC_1_SQRT_2
    } else {
        std::f64::consts::FRAC_1_SQRT_2
    }
}

/// Every j below `bands`² with which the selection rules allow Γ_ijk, ascending, and its value (0 for an accidental
/// zero).
///
/// The effective degrees must have been checked with [`check_degrees`].
pub(super) fn partners(i: usize, k: usize, bands: usize, mut emit: impl FnMut(usize, f64)) {
    let tables = Tables::shared();
    let ((l1, m1), (l3, m3)) = (degree_order(i), degree_order(k));
    let (near, far) = (m1.abs().abs_diff(m3.abs()) as isize, m1.abs() + m3.abs());
    // An even number of sines: the partner is one if and only if just one of i and k is; order 0 is no sine.
    let orders = match ((m1 < 0) != (m3 < 0), near == far) {
        (true, true) => [None, Some(-far).filter(|m| *m != 0)],
        (true, false) => [Some(-far), Some(-near).filter(|m| *m != 0)],
        (false, true) => [Some(far), None],
        (false, false) => [Some(near), Some(far)],
    };
    let mut l2 = l1.abs_diff(l3);
    while l2 <= l1 + l3 && l2 < bands {
        for m2 in orders.into_iter().flatten().filter(|m2| m2.unsigned_abs() <= l2) {
            emit(flat(l2, m2), tables.allowed_gamma([l1, l2, l3], [m1, m2, m3]));
        }
        l2 += 2;
    }
}

/// The parts of three expansions that can meet in a triple product, as bands.
///
/// # Errors
/// [`Error::OutOfRange`] if one of `bands` is 0.
pub(super) fn met(bands: [usize; 3]) -> Result<[usize; 3]> {
    if bands.contains(&0) {
        return Err(Error::OutOfRange { what: "bands", got: 0.0, allowed: "at least 1" });
    }
    let [a, b, c] = bands;
    Ok([a.min((b - 1).saturating_add(c)), b.min((a - 1).saturating_add(c)), c.min((a - 1).saturating_add(b))])
}

/// The parts that can [meet](met), if Γ can be had for all of them.
///
/// # Errors
/// [`Error::OutOfRange`] if one of `bands` is 0 or the degrees that meet add up to more than 126.
pub(super) fn check_degrees(bands: [usize; 3]) -> Result<[usize; 3]> {
    let met = met(bands)?;
    // l₁ + l₂ + l₃ is even: an odd sum of the largest degrees is not reached.
    let degrees = met.iter().fold(0usize, |sum, n| sum.saturating_add(n - 1)) & !1;
    if degrees > MAX_DEGREE_SUM {
        let allowed = "at most 126 (64 bands untruncated from 32 and 32, 43 from 43 and 43)";
        return Err(Error::OutOfRange { what: "sum of the three degrees", got: degrees as f64, allowed });
    }
    Ok(met)
}

/// Γ_ijk = ∫ y_i y_j y_k over the sphere, of three flat indices l(l+1)+m in any order.
///
/// ```math
/// Γ = √(Π(2l+1)/4π) (l₁ l₂ l₃; 0 0 0) (l₁ l₂ l₃; m₁ m₂ −M) × sign and mean over azimuth     [Gaunt; Racah]
/// ```
///
/// Zeros are exact, the accidental ones too; the same value in any order of the indices, and in the convention with the
/// Condon–Shortley phase. Accuracy: 2e-15 relative (some fifteen roundings), tested so against 20-digit values below 8
/// bands and to 3e-14 absolute against quadrature up to degree 63. Cost: a sum of at most l₁+l₂−l₃+1 integer terms.
///
/// # Errors
/// [`Error::OutOfRange`] if the selection rules allow Γ and the three degrees add up to more than 126.
///
/// # Example
/// ```
/// use haarmonic::sh::gamma;
/// // Two of the degree-1 harmonics make the zonal one of degree 2: Γ(z, z, 20) = 1/√(5π).
/// assert!((gamma(2, 2, 6)? - (5.0 * std::f64::consts::PI).sqrt().recip()).abs() < 1e-16);
/// assert_eq!(gamma(6, 10, 10)?, 0.0); // an accidental zero
/// # Ok::<(), haarmonic::Error>(())
/// ```
pub fn gamma(i: usize, j: usize, k: usize) -> Result<f64> {
    let ([(l1, m1), (l2, m2), (l3, m3)], degrees) = {
        let lm = [i, j, k].map(degree_order);
        (lm, lm.iter().fold(0usize, |sum, lm| sum.saturating_add(lm.0)))
    };
    let mut orders = [m1, m2, m3].map(isize::unsigned_abs);
    orders.sort_unstable();
    let sines = [m1, m2, m3].iter().filter(|m| **m < 0).count();
    let triangle = l3 >= l1.abs_diff(l2) && l3 <= l1.saturating_add(l2) && degrees & 1 == 0;
    if !triangle || orders[0] + orders[1] != orders[2] || sines & 1 == 1 {
        return Ok(0.0);
    }
    if degrees > MAX_DEGREE_SUM {
        let allowed = "at most 126";
        return Err(Error::OutOfRange { what: "sum of the three degrees", got: degrees as f64, allowed });
    }
    Ok(Tables::shared().allowed_gamma([l1, l2, l3], [m1, m2, m3]))
}

/// Every non-zero Γ_ijk of the harmonics below `bands`, once for i ≤ j ≤ k, in lexicographic order.
///
/// | bands | 1 | 2 | 3 | 4 | 5 | 6 | 7 | 8 |
/// |---|---|---|---|---|---|---|---|---|
/// | stored, i ≤ j ≤ k | 1 | 4 | 25 | 77 | 238 | 549 | 1196 | 2300 |
/// | non-zero, ordered (i, j, k) | 1 | 10 | 83 | 353 | 1158 | 2907 | 6460 | 12868 |
/// | allowed by the selection rules, ordered | 1 | 10 | 83 | 359 | 1164 | 2961 | 6586 | 13018 |
///
/// The last row is what [Sun 2008, §2.4] tabulates (with 369 misprinted for 359): some triples that the rules allow
/// vanish.
#[derive(Debug, Clone, PartialEq)]
pub struct TripleTensor {
    bands: usize,
    indices: Vec<[u16; 3]>,
    values: Vec<f64>,
    allowed: u64,
}

impl TripleTensor {
    /// The tensor of `bands`² harmonics. Cost: Θ(bands⁵) in memory, one short integer sum an entry.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless `bands` is in 1..=43.
    pub fn new(bands: usize) -> Result<Self> {
        check_degrees([bands; 3])?;
        let mut tensor = Self { bands, indices: Vec::new(), values: Vec::new(), allowed: 0 };
        for i in 0..bands * bands {
            for j in i..bands * bands {
                partners(i, j, bands, |k, value| {
                    if k < j {
                        return;
                    }
                    tensor.allowed += orderings([i, j, k]);
                    if value != 0.0 {
                        tensor.indices.push([i, j, k].map(|i| i as u16));
                        tensor.values.push(value);
                    }
                });
            }
        }
        Ok(tensor)
    }

    /// The bands of the basis.
    #[inline]
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// How many values are stored: the non-zeros with i ≤ j ≤ k.
    #[inline]
    pub fn nnz(&self) -> usize {
        self.values.len()
    }

    /// How many of the bands⁶ ordered triples have Γ ≠ 0.
    pub fn ordered_nnz(&self) -> u64 {
        self.entries().map(|(triple, _)| orderings(triple)).sum()
    }

    /// How many of the bands⁶ ordered triples the selection rules allow, accidental zeros included.
    pub fn ordered_allowed(&self) -> u64 {
        self.allowed
    }

    /// The stored ([i, j, k], Γ_ijk), i ≤ j ≤ k, in lexicographic order.
    pub fn entries(&self) -> impl ExactSizeIterator<Item = ([usize; 3], f64)> + Clone + '_ {
        self.indices.iter().map(|triple| triple.map(usize::from)).zip(self.values.iter().copied())
    }

    /// Γ_ijk in any order of the indices. Cost: a binary search.
    ///
    /// # Panics
    /// Unless i, j, k < bands².
    #[track_caller]
    pub fn value(&self, i: usize, j: usize, k: usize) -> f64 {
        let mut triple = [i, j, k];
        triple.sort_unstable();
        let size = self.bands * self.bands;
        assert!(triple[2] < size, "harmonic {} of {size}", triple[2]);
        self.indices.binary_search(&triple.map(|i| i as u16)).map_or(0.0, |at| self.values[at])
    }
}

/// How many orders a sorted triple has.
fn orderings([i, j, k]: [usize; 3]) -> u64 {
    if i == k {
        1
    } else if i == j || j == k {
        3
    } else {
        6
    }
}
