//! Affine couplings and triplings of the Fourier basis, for comparison with Haar.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use nalgebra::{Complex, DMatrix};

use crate::affine::AffineMap;
use crate::affine::exact_sum::exact_product;

/// Affine coupling of two functions φ_p(v) = (2π)^{−1/2} e^{ipv} of the Fourier basis on [0, 2π].
///
/// ```math
/// D_pq(s, o) = ∫₀^{2π} φ_p(sv + o) φ_q*(v) dv = e^{ipo} E(sp − q),
/// E(x) = (e^{2πix} − 1)/(2πix) = e^{iπx} sin(πx)/(πx)
/// ```
///
/// φ_p is not cut off outside [0, 2π]. [Sun 2008, eq. 4.18] has e^{ipo} δ_{sp,q}, which holds only where sp is an
/// integer: for other s the basis is not closed under the map and every D_pq of a row differs from 0 (docs/errata.md).
/// E is evaluated from the distance of sp to the nearest integer, so that its zeros are exact and nothing cancels
/// beside them or beside 1; the products sp and po are kept to 106 bits.
///
/// Accuracy: a few ε relative to |D|.
///
/// # Example
/// ```
/// use haarmonic::affine::AffineMap;
/// use haarmonic::reference::affine::fourier_basis::fourier_coupling;
/// let twice = AffineMap::new(2.0, 0.0)?;
/// assert_eq!(fourier_coupling(3, 6, twice).re, 1.0);
/// assert_eq!(fourier_coupling(3, 5, twice).norm(), 0.0);
/// let half = AffineMap::new(0.5, 0.0)?; // e^{iv/2} is no sum of few e^{iqv}
/// assert!((fourier_coupling(1, 0, half).im - 2.0 / std::f64::consts::PI).abs() < 1e-15);
/// # Ok::<(), haarmonic::Error>(())
/// ```
pub fn fourier_coupling(p: i64, q: i64, map: AffineMap) -> Complex<f64> {
    Row::new(p, map).coupling(q)
}

/// Affine tripling of three functions of the Fourier basis.
///
/// ```math
/// D_npq(s, o) = ∫₀^{2π} φ_n(sv + o) φ_p(v) φ_q*(v) dv
///   = (2π)^{−1/2} e^{ino} E(sn + p − q) = (2π)^{−1/2} D_{n, q−p}(s, o)
/// ```
///
/// with E and D_pq of [`fourier_coupling`]. [Sun 2008, eq. 4.19] has δ_{sn+p,q} for E; see there.
///
/// # Panics
/// If q − p leaves the range of `i64`.
#[track_caller]
pub fn fourier_tripling(n: i64, p: i64, q: i64, map: AffineMap) -> Complex<f64> {
    let difference = q.checked_sub(p).expect("q − p is an i64");
    fourier_coupling(n, difference, map) * TAU.sqrt().recip()
}

/// The matrix of [`fourier_coupling`] over a range of frequencies: element (row q, column p) takes the coefficient p of
/// F to the coefficient q of F(sv + o).
///
/// The coefficients of F(sv + o) are those of F times this, up to what the range cuts off. Cost: N² complex products
/// and 16 N² bytes.
pub fn fourier_coupling_matrix(frequencies: Range<i64>, map: AffineMap) -> DMatrix<Complex<f64>> {
    let size = frequencies.clone().count();
    let values = frequencies.clone().flat_map(|p| {
        let row = Row::new(p, map);
        frequencies.clone().map(move |q| row.coupling(q))
    });
    DMatrix::from_iterator(size, size, values)
}

/// Every (p, q, D_pq ≠ 0) over a range of frequencies, by p, then q.
///
/// A row p has one non-zero element at most, q = sp, where sp is an integer, and is full otherwise: N elements for an
/// integer s (the case of [Sun 2008, eq. 4.18]), about N²(1 − 1/b) for s = a/b in lowest terms, and N² − N + 1 for a
/// generic s (p = 0 couples with q = 0 only). Cost: proportional to the output, plus N.
///
/// # Example
/// ```
/// use haarmonic::affine::AffineMap;
/// use haarmonic::reference::affine::fourier_basis::fourier_coupling_nonzeros;
/// let count = |s| fourier_coupling_nonzeros(-8..8, AffineMap::new(s, 0.3).unwrap()).count();
/// assert_eq!((count(1.0), count(2.0), count(1.1)), (16, 8, 16 * 16 - 15));
/// ```
pub fn fourier_coupling_nonzeros(
    frequencies: Range<i64>,
    map: AffineMap,
) -> impl Iterator<Item = (i64, i64, Complex<f64>)> {
    frequencies.clone().flat_map(move |p| {
        let row = Row::new(p, map);
        row.support(&frequencies).map(move |q| (p, q, row.coupling(q)))
    })
}

/// How many (n, p, q) over a range of frequencies have D_npq ≠ 0 ([`fourier_tripling`]): Θ(N²) for an integer s, Θ(N³)
/// otherwise; `u64::MAX` where there are more. Cost: N steps.
pub fn fourier_tripling_count(frequencies: Range<i64>, map: AffineMap) -> u64 {
    let size = if frequencies.is_empty() { 0 } else { frequencies.end.abs_diff(frequencies.start) };
    let pairs = |n| match Row::new(n, map).integer() {
        // q − p = sn: as many pairs as the range and the range moved by sn have in common.
        Some(integer) => size.saturating_sub(integer.abs() as u64),
        None => size.saturating_mul(size),
    };
    frequencies.map(pairs).fold(0, u64::saturating_add)
}

/// What the couplings of one p share.
#[derive(Clone, Copy)]
struct Row {
    /// e^{ipo}.
    phase: Complex<f64>,
    /// sp = nearest + beside, nearest an integer.
    nearest: f64,
    beside: f64,
    /// e^{ipo} e^{iπ·beside} sin(π·beside)/π: D_pq = wave/(sp − q), as the signs (−1)^{nearest − q} of the two factors
    /// cancel.
    wave: Complex<f64>,
}

impl Row {
    fn new(p: i64, map: AffineMap) -> Self {
        let (turn, rest) = exact_product(map.offset(), p as f64);
        let phase = Complex::cis(turn) * Complex::cis(rest);
        let (high, low) = exact_product(map.scale(), p as f64);
        // Where low is not below ½, high is an integer beyond 2^52.
        let beside = (high - high.round()) + (low - low.round());
        let (sin, cos) = (PI * beside).sin_cos();
        let wave = phase * Complex::new(cos, sin) * (sin / PI);
        Self { phase, nearest: high.round() + low.round(), beside, wave }
    }

    /// sp if it is an integer.
    fn integer(&self) -> Option<f64> {
        (self.beside == 0.0).then_some(self.nearest)
    }

    /// The q of the range with D_pq ≠ 0.
    fn support(&self, frequencies: &Range<i64>) -> Range<i64> {
        match self.integer() {
            None => frequencies.clone(),
            Some(q) if q.abs() < 2f64.powi(62) && frequencies.contains(&(q as i64)) => q as i64..q as i64 + 1,
            Some(_) => 0..0,
        }
    }

    fn coupling(&self, q: i64) -> Complex<f64> {
        let x = (self.nearest - q as f64) + self.beside;
        if x == 0.0 { self.phase } else { self.wave / x }
    }
}
