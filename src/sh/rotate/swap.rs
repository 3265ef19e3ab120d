//! The constant matrix P of the mirror (x, y, z) → (x, z, y), which turns turns about z into turns about y:
//!
//! ```math
//! R = R_z(α) R_y(β) R_z(γ),  R_y(β) = S R_z(−β) S,  so M(R) = Z(α) P Z(−β) P Z(γ)
//! ```
//!
//! P is symmetric, its own inverse, and three quarters of it are 0: S changes parity in y for parity in z and keeps
//! that in x. With i = l + m, entry (i, j) can differ from 0 only if (i ≥ l ⟺ j even) and (j ≥ l ⟺ i even).
//!
//! S is a quarter turn about x and a mirror, so the entries are Wigner's d at a right angle, M ≥ K the larger and the
//! smaller of |m|, |m'|:
//!
//! ```math
//! P = ± d^l_{MK}(π/2) · {1, √2, 2 for two, one or no zero among m, m'}
//! + if (M − K) mod 4 is 0 or 1, − otherwise; the other sign if both m and m' are negative
//! ```
//!
//! d is the Jacobi recurrence in l at fixed M, K [Varshalovich et al. 1988, §4.8], at cos β = 0:
//!
//! ```math
//! d^M_{MK} = 2^{−M} √C(2M, M+K),
//! w_{l+1} d^{l+1} = −(2l+1) M K/(l(l+1)) d^l − w_l d^{l−1},   w_l = √((l²−M²)(l²−K²))/l
//! ```
//!
//! P² = 1 holds to 2e-15 at 128 bands. The recurrence of blocks from block to block [Ivanic & Ruedenberg 1996] loses
//! digits exponentially: 1e-15 at 16 bands, 1e-11 at 64, 4e-6 at 128.

use crate::Real;

/// The non-zeros of P, degree by degree, four dense blocks each, row-major, in the order of [`CLASSES`].
#[derive(Debug, Clone)]
pub(super) struct Swap<T> {
    entries: Vec<T>,
    /// Where the entries of each degree begin, and the last one's end.
    starts: Vec<usize>,
    /// P once more as [`single`](super::single) wants it: degree by degree a matrix of quads, each with a lane for each
    /// class of rows.
    quads: Vec<[T; QUAD]>,
}

/// Rows of P side by side: those of even and odd m ≥ 0, of even and odd m < 0.
pub(super) const QUAD: usize = 4;

/// The quads that hold the orders of degree l.
#[inline(always)]
pub(super) const fn quads(l: usize) -> usize {
    l / 2 + 1
}

/// Quads before degree l: 1, 1, 4, 4, 9, 9, …
#[inline(always)]
const fn quad_start(l: usize) -> usize {
    let half = l / 2;
    half * (half + 1) * (2 * half + 1) / 3 + (l % 2) * (half + 1) * (half + 1)
}

/// Every other row or column of a degree: those of i ≥ l or i < l, i even or odd.
#[derive(Debug, Clone, Copy)]
pub(super) struct Comb {
    upper: bool,
    odd: usize,
}

impl Comb {
    const fn new(upper: bool, odd: usize) -> Self {
        Self { upper, odd }
    }

    /// The k-th i, by growing |i − l|.
    #[inline(always)]
    pub(super) const fn at(self, l: usize, k: usize) -> usize {
        if self.upper { l + (l + self.odd) % 2 + 2 * k } else { l - 1 - (l + 1 + self.odd) % 2 - 2 * k }
    }

    /// How many i there are.
    #[inline(always)]
    pub(super) const fn count(self, l: usize) -> usize {
        if self.upper { (l + 2 - (l + self.odd) % 2) / 2 } else { (l + 1 - self.odd) / 2 }
    }
}

/// The rows and the columns of the four blocks.
pub(super) const CLASSES: [[Comb; 2]; 4] = [
    [Comb::new(true, 0), Comb::new(true, 0)],
    [Comb::new(true, 1), Comb::new(false, 0)],
    [Comb::new(false, 0), Comb::new(true, 1)],
    [Comb::new(false, 1), Comb::new(false, 1)],
];

impl<T: Real> Swap<T> {
    pub(super) fn new(bands: usize) -> Self {
        let quarter = quarter_turns(bands);
        let (mut entries, mut starts, mut quads_of) = (Vec::new(), vec![0], Vec::new());
        for (l, d) in quarter.iter().enumerate() {
            for [rows, columns] in CLASSES {
                for r in 0..rows.count(l) {
                    entries.extend((0..columns.count(l)).map(|c| T::of(entry(d, l, rows.at(l, r), columns.at(l, c)))));
                }
            }
            starts.push(entries.len());
            let size = quads(l);
            // The lane of P's columns that meets each lane of its rows.
            let met = if l % 2 == 0 { [0, 2, 1, 3] } else { [3, 1, 2, 0] };
            let index = |quad: usize, lane: usize| {
                let m = 2 * quad + lane % 2;
                let exists = m <= l && (lane < 2 || m > 0);
                exists.then(|| if lane < 2 { l + m } else { l - m })
            };
            quads_of.extend((0..size * size).map(|at| {
                std::array::from_fn(|lane| match (index(at / size, lane), index(at % size, met[lane])) {
                    (Some(i), Some(j)) => T::of(entry(d, l, i, j)),
                    _ => T::zero(),
                })
            }));
        }
        Self { entries, starts, quads: quads_of }
    }

    /// The matrix of quads of degree l, row-major.
    #[inline(always)]
    pub(super) fn quads(&self, l: usize) -> &[[T; QUAD]] {
        &self.quads[quad_start(l)..quad_start(l + 1)]
    }

    /// The entries of degree l.
    #[inline(always)]
    pub(super) fn degree(&self, l: usize) -> &[T] {
        &self.entries[self.starts[l]..self.starts[l + 1]]
    }
}

/// P at row i, column j of degree l, one that can differ from 0.
fn entry(d: &[Vec<f64>], l: usize, i: usize, j: usize) -> f64 {
    let (a, b) = (i.abs_diff(l), j.abs_diff(l));
    let (large, small) = (a.max(b), a.min(b));
    let scale = if large == 0 {
        1.0
    } else if small == 0 {
        2f64.sqrt()
    } else {
        2.0
    };
    let negative = ((large - small) % 4 >= 2) != (i < l && j < l);
    d[large][small] * if negative { -scale } else { scale }
}

/// d^l_{MK}(π/2) for 0 ≤ K ≤ M ≤ l, at [l][M][K].
fn quarter_turns(bands: usize) -> Vec<Vec<Vec<f64>>> {
    let mut d: Vec<_> = (0..bands).map(|l| (0..=l).map(|m| vec![0.0; m + 1]).collect::<Vec<_>>()).collect();
    let mut central = 1.0;
    for m in 0..bands {
        // C(2m, m)/4^m, then C(2m, m + k)/4^m.
        if m > 0 {
            central *= 1.0 - 0.5 / m as f64;
        }
        let mut square = central;
        for k in 0..=m {
            let (mut value, mut before) = (square.sqrt(), 0.0);
            d[m][m][k] = value;
            for l in m + 1..bands {
                let up = weight(l, m, k);
                let turned = if m * k == 0 { 0.0 } else { (2 * l - 1) as f64 * (m * k) as f64 / (l * (l - 1)) as f64 };
                let next = -(turned * value + weight(l - 1, m, k) * before) / up;
                (before, value) = (value, next);
                d[l][m][k] = value;
            }
            square *= (m - k) as f64 / (m + k + 1) as f64;
        }
    }
    d
}

/// √((l²−m²)(l²−k²))/l, 0 at l = 0.
fn weight(l: usize, m: usize, k: usize) -> f64 {
    if l == 0 { 0.0 } else { (((l * l - m * m) * (l * l - k * k)) as f64).sqrt() / l as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dense(l: usize) -> Vec<Vec<f64>> {
        let swap = Swap::<f64>::new(l + 1);
        let mut entries = swap.degree(l).iter();
        let mut p = vec![vec![0.0; 2 * l + 1]; 2 * l + 1];
        for [rows, columns] in CLASSES {
            for r in 0..rows.count(l) {
                for c in 0..columns.count(l) {
                    p[rows.at(l, r)][columns.at(l, c)] = *entries.next().unwrap();
                }
            }
        }
        assert!(entries.next().is_none());
        p
    }

    #[test]
    fn is_symmetric_and_its_own_inverse() {
        for l in [0, 1, 2, 3, 4, 5, 17, 63, 127] {
            let p = dense(l);
            let mut worst = 0f64;
            for i in 0..2 * l + 1 {
                for j in 0..2 * l + 1 {
                    assert_eq!(p[i][j], p[j][i]);
                    let square: f64 = (0..2 * l + 1).map(|k| p[i][k] * p[k][j]).sum();
                    worst = worst.max((square - f64::from(u8::from(i == j))).abs());
                }
            }
            assert!(worst <= 4e-15, "l {l}: {worst:e}");
        }
    }

    #[test]
    fn a_quarter_can_differ_from_zero() {
        for l in 0..20usize {
            let count: usize = CLASSES.iter().map(|[rows, columns]| rows.count(l) * columns.count(l)).sum();
            assert_eq!(count, l * l + l + 1);
        }
    }
}
