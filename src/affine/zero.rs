//! Integrals of two atoms without rounding: whether a coupling is exactly zero, and what it is where nearly all of it
//! cancels.
//!
//! Breakpoints that fall on the ends of cells, and wavelets that are centred on one another, make couplings that are
//! zero only because parts of them cancel; a rounded breakpoint leaves 1e-17 of them. So a value below the reach of
//! rounding is decided in source space, x = s v + o, where no division is needed: with y_k = 2^m (b_k − o)/s − u of a
//! target atom (m, u) and breakpoints b_k of the source,
//!
//! ```math
//! s Σ_k w_k G(y_k),   s Λ(y) = z − s u or s (u + 1) − z,   z = 2^m (b_k − o),
//! ```
//!
//! a sum of a dozen products of two `f64`, added without rounding.

use super::atom::{power, root_power};
use super::exact_sum::{exact_product, sum_of};
use super::{AffineMap, Atom, Mother};

/// 2^m (b − o) − s·n as four numbers without rounding.
fn distance(b: f64, n: f64, cells: f64, map: AffineMap) -> [f64; 4] {
    let (high, low) = exact_product(map.scale(), n);
    [cells * b, -cells * map.offset(), -high, -low]
}

/// |s| 2^{(m − l)/2} ∫ f(s v + o) g(v) dv of a source atom of level l and a target atom of level m: to an ε or so of itself, and 0 if
/// and only if the integral is, for the numbers that `map` holds.
#[cold]
pub(super) fn exact_integral(source: Atom, target: Atom, map: AffineMap) -> f64 {
    let (cells, from) = (power(target.level as i32), target.offset as f64);
    let weights = source.mother.weights();
    let breakpoints = source.breakpoints();
    let mut terms = [0.0; 12];
    for (k, terms) in terms.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let part = |n: f64| distance(breakpoints[k], n, cells, map);
        // y ≥ n − u, whatever the sign of s.
        let beyond = |n: f64| sum_of(part(n)) * map.scale() >= 0.0;
        let s_times_primitive = match target.mother {
            _ if weights[k] == 0.0 || !beyond(from) => [0.0; 4],
            Mother::Scaling if beyond(from + 1.0) => [map.scale(), 0.0, 0.0, 0.0],
            Mother::Wavelet if beyond(from + 1.0) => [0.0; 4],
            Mother::Wavelet if beyond(from + 0.5) => part(from + 1.0).map(|x| -x),
            _ => part(from),
        };
        *terms = s_times_primitive.map(|x| weights[k] * x);
    }
    sum_of(terms)
}

/// The reach of rounding of a coupling: breakpoints are off by less than 4 ε (1 + |o/s|), and each moves the integral
/// by at most four times that times both amplitudes.
#[inline(always)]
fn reach(source: Atom, target: Atom, map: AffineMap) -> f64 {
    let amplitudes = root_power((source.level + target.level) as i32);
    16.0 * f64::EPSILON * amplitudes * (1.0 + (map.offset() / map.scale()).abs())
}

/// Whether the coupling of which `value` is the rounded form is exactly zero.
#[inline(always)]
pub(super) fn vanishes(source: Atom, target: Atom, map: AffineMap, value: f64) -> bool {
    value == 0.0 || (value.abs() <= reach(source, target, map) && exact_integral(source, target, map) == 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_of_the_interval_is_seen_alike_by_both_halves() {
        let map = AffineMap::new(3.0, -1.0).unwrap();
        let [phi, psi] = [0, 1].map(Atom::from_flat);
        let zero = |source, target, map| exact_integral(source, target, map) == 0.0;
        assert!(zero(phi, psi, map) && !zero(psi, psi, map) && !zero(phi, phi, map));
        let beside = AffineMap::new(3.0, -1.0 + f64::EPSILON).unwrap();
        assert!(!zero(phi, psi, beside));
    }
}
