//! Whether a coupling is exactly zero, where its rounded value is too small to tell.
//!
//! Breakpoints that fall on the ends of cells, and wavelets that are centred on one another, make couplings that are zero only because parts
//! of them cancel; a rounded breakpoint leaves 1e-17 of them. So a value below the reach of rounding is decided in source space,
//! x = s v + o, where no division is needed: with y_k = 2^m (b_k − o)/s − u of a target atom (m, u) and breakpoints b_k of the source,
//!
//!   s Σ_k w_k G(y_k),   s Λ(y) = z − s u or s (u + 1) − z,   z = 2^m (b_k − o),
//!
//! a sum of a dozen products of two `f64`, added without rounding.

use super::atom::{power, root_power};
use super::exact_sum::{exact_product, exact_sum};
use super::{AffineMap, Atom, Mother};

/// The sign of a sum, and 0 if and only if it is 0: grown into an expansion of parts that do not overlap [Shewchuk 1997].
fn sign_of_sum(terms: impl IntoIterator<Item = f64>) -> f64 {
    let (mut parts, mut count) = ([0.0; 24], 0);
    for term in terms {
        let mut carry = term;
        for part in &mut parts[..count] {
            (carry, *part) = exact_sum(carry, *part);
        }
        parts[count] = carry;
        count += 1;
    }
    parts[..count].iter().rev().copied().find(|&part| part != 0.0).unwrap_or(0.0)
}

/// 2^m (b − o) − s·n as four numbers without rounding.
fn distance(b: f64, n: f64, cells: f64, map: AffineMap) -> [f64; 4] {
    let (high, low) = exact_product(map.scale(), n);
    [cells * b, -cells * map.offset(), -high, -low]
}

/// Whether ∫ f(s v + o) g(v) dv = 0 exactly, for the numbers that `map` holds.
#[cold]
fn exactly_zero(source: Atom, target: Atom, map: AffineMap) -> bool {
    let (cells, from) = (power(target.level as i32), target.offset as f64);
    let weights = match source.mother {
        Mother::Wavelet => [-1.0, 2.0, -1.0],
        Mother::Scaling => [-1.0, 0.0, 1.0],
    };
    let breakpoints = source.breakpoints();
    let terms = (0..3).filter(|&k| weights[k] != 0.0).flat_map(|k| {
        let part = |n: f64| distance(breakpoints[k], n, cells, map);
        // y ≥ n − u, whatever the sign of s.
        let beyond = |n: f64| sign_of_sum(part(n)) * map.scale() >= 0.0;
        let s_times_primitive = match target.mother {
            _ if !beyond(from) => [0.0; 4],
            Mother::Scaling if beyond(from + 1.0) => [map.scale(), 0.0, 0.0, 0.0],
            Mother::Wavelet if beyond(from + 1.0) => [0.0; 4],
            Mother::Wavelet if beyond(from + 0.5) => part(from + 1.0).map(|x| -x),
            _ => part(from),
        };
        s_times_primitive.map(|x| weights[k] * x)
    });
    sign_of_sum(terms) == 0.0
}

/// The reach of rounding of a coupling: breakpoints are off by less than 4 ε (1 + |o/s|), and each moves the integral by at most
/// four times that times both amplitudes.
#[inline(always)]
fn reach(source: Atom, target: Atom, map: AffineMap) -> f64 {
    let amplitudes = root_power((source.level + target.level) as i32);
    16.0 * f64::EPSILON * amplitudes * (1.0 + (map.offset() / map.scale()).abs())
}

/// Whether the coupling of which `value` is the rounded form is exactly zero.
#[inline(always)]
pub(super) fn vanishes(source: Atom, target: Atom, map: AffineMap, value: f64) -> bool {
    value == 0.0 || (value.abs() <= reach(source, target, map) && exactly_zero(source, target, map))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_that_cancel_are_zero_and_others_keep_their_sign() {
        assert_eq!(sign_of_sum([1e300, 1.0, -1e300, -1.0]), 0.0);
        assert!(sign_of_sum([1e300, 1e-300, -1e300]) > 0.0);
        assert!(sign_of_sum([0.1, 0.2, -0.3, -1e-16]) < 0.0); // 0.1 + 0.2 − 0.3 = 2.8e-17 as f64
    }

    #[test]
    fn a_third_of_the_interval_is_seen_alike_by_both_halves() {
        let map = AffineMap::new(3.0, -1.0).unwrap();
        let [phi, psi] = [0, 1].map(Atom::from_flat);
        assert!(exactly_zero(phi, psi, map) && !exactly_zero(psi, psi, map) && !exactly_zero(phi, phi, map));
        let beside = AffineMap::new(3.0, -1.0 + f64::EPSILON).unwrap();
        assert!(!exactly_zero(phi, psi, beside));
    }
}
