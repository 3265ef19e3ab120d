//! Couplings without rounding, for every map: sums of `f64` in a fixed-point number as long as their range.
//!
//! As in [`exact`](super::exact) everything is compared and measured in source space, x = s·v + o, where nothing is
//! divided. A point there is the exact sum of a few `f64`.

use num_traits::Float;

use super::steps::{Function, Steps, pieces};
use crate::affine::AffineMap;

/// Σ limb_k 2^(32k − LOWEST), limbs of any sign and size [Kulisch].
struct LongSum([i64; Self::LIMBS]);

impl LongSum {
    const LIMBS: usize = 72;
    const LOWEST: i32 = 1120;

    fn of(terms: impl IntoIterator<Item = f64>) -> Self {
        let mut limbs = [0; Self::LIMBS];
        for term in terms {
            let (mantissa, exponent, sign) = term.integer_decode();
            let place = (i32::from(exponent) + Self::LOWEST) as usize;
            let bits = u128::from(mantissa) << (place % 32);
            for k in 0..3 {
                limbs[place / 32 + k] += i64::from(sign) * ((bits >> (32 * k)) as u32 as i64);
            }
        }
        Self(limbs)
    }

    /// Limbs from 0 to 2^32 and the sign.
    fn carried(mut self) -> (i32, [i64; Self::LIMBS]) {
        let carry = |limbs: &mut [i64; Self::LIMBS]| {
            let mut carry = 0;
            for limb in limbs {
                carry += *limb;
                *limb = carry & 0xffff_ffff;
                carry >>= 32;
            }
            carry
        };
        let original = self.0;
        if carry(&mut self.0) >= 0 {
            return (i32::from(self.0.iter().any(|&limb| limb != 0)), self.0);
        }
        let mut negated = original.map(|limb| -limb);
        carry(&mut negated);
        (-1, negated)
    }

    fn sign(self) -> i32 {
        self.carried().0
    }

    /// To half an ε or so.
    fn value(self) -> f64 {
        let (sign, limbs) = self.carried();
        let Some(top) = (0..Self::LIMBS).rev().find(|&k| limbs[k] != 0) else { return 0.0 };
        let low = top.saturating_sub(3);
        let bits = (low..=top).rev().fold(0u128, |bits, k| bits << 32 | limbs[k] as u128);
        let exponent = 32 * low as i32 - Self::LOWEST;
        f64::from(sign) * (bits as f64) * 2f64.powi(exponent / 2) * 2f64.powi(exponent - exponent / 2)
    }
}

/// The exact sum of its parts.
#[derive(Debug, Clone, Copy)]
struct Point([f64; 4]);

impl Point {
    fn minus(self, other: Self) -> impl Iterator<Item = f64> {
        self.0.into_iter().chain(other.0.map(|x| -x))
    }
}

impl PartialEq for Point {
    fn eq(&self, other: &Self) -> bool {
        self.partial_cmp(other).is_some_and(|order| order.is_eq())
    }
}

impl PartialOrd for Point {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(LongSum::of(self.minus(*other)).sign().cmp(&0))
    }
}

/// a·b as two numbers.
fn product(a: f64, b: f64) -> [f64; 2] {
    [a * b, a.mul_add(b, -(a * b))]
}

/// A change of s and of o, far below anything that a map and a breakpoint of level 40 can tell apart.
const STEP: f64 = f64::from_bits((1023 - 900) << 52);

/// Σ ± lengths of the pieces of the product of a moved function with fixed ones, in source space, for s + ds and o +
/// do: terms of an exact sum.
fn lengths(source: &Function, targets: &[Function], map: AffineMap, [ds, d_o]: [f64; 2]) -> Vec<f64> {
    let signs = |f: Steps<Point, f64>| Steps { at: f.at, values: f.values.into_iter().map(f64::signum).collect() };
    let mut factors = vec![signs(source.moved(false, |x| Point([x, -d_o, 0.0, 0.0])))];
    for target in targets {
        let image = |v: f64| {
            let [high, low] = product(map.scale(), v);
            Point([high, low, map.offset(), ds * v])
        };
        factors.push(signs(target.moved(map.scale() < 0.0, image)));
    }
    let pieces = pieces(&factors.iter().collect::<Vec<_>>());
    pieces.into_iter().flat_map(|(a, b, sign)| b.minus(a).map(move |x| sign * x)).collect()
}

/// The product of the heights of the functions.
fn amplitudes(source: &Function, targets: &[Function]) -> f64 {
    let squares = |f: &Function| (f.values[0] * f.values[0]).round();
    (targets.iter().map(squares).product::<f64>() * squares(source)).sqrt()
}

fn value(source: &Function, targets: &[Function], map: AffineMap) -> f64 {
    let sum = LongSum::of(lengths(source, targets, map, [0.0; 2])).value();
    amplitudes(source, targets) * (sum / map.scale().abs())
}

/// [∂/∂s, ∂/∂o] to the right: D = A N/|s| with N made of lengths that are linear in s and o up to the next kink, so
/// that ∂D/∂o = A N′/|s|, ∂D/∂s = A (s N′ − N)/(s |s|), and N′ is an exact difference over a step that reaches no kink.
fn slopes(source: &Function, targets: &[Function], map: AffineMap) -> [f64; 2] {
    let s = map.scale();
    let here = lengths(source, targets, map, [0.0; 2]);
    let change = |along: [f64; 2]| {
        let there = lengths(source, targets, map, along.map(|d| d * STEP));
        LongSum::of(there.into_iter().chain(here.iter().map(|x| -x))).value() / STEP
    };
    let [high, low] = product(s, change([1.0, 0.0]));
    let by_scale = LongSum::of([high, low].into_iter().chain(here.iter().map(|x| -x))).value();
    let amplitudes = amplitudes(source, targets);
    [amplitudes * (by_scale / s / s.abs()), amplitudes * change([0.0, 1.0]) / s.abs()]
}

/// D_ij of the 1D basis for the numbers that `map` holds, to an ε or so of itself, and 0 if and only if it is 0;
/// indices below 2^40.
pub fn exact_coupling_1d(i: usize, j: usize, map: AffineMap) -> f64 {
    value(&Function::haar(i), &[Function::haar(j)], map)
}

/// D_ijk of the 1D basis, exact as [`exact_coupling_1d`].
pub fn exact_tripling_1d(i: usize, j: usize, k: usize, map: AffineMap) -> f64 {
    value(&Function::haar(i), &[j, k].map(Function::haar), map)
}

/// D_ij of the 2D nonstandard basis, exact as [`exact_coupling_1d`] on each axis.
pub fn exact_coupling_nonstandard(i: usize, j: usize, maps: [AffineMap; 2]) -> f64 {
    let ([fx, fy], [gx, gy]) = (Function::nonstandard(i), Function::nonstandard(j));
    value(&fx, &[gx], maps[0]) * value(&fy, &[gy], maps[1])
}

/// D_ij of the orthonormal pixels, exact as [`exact_coupling_1d`]; `size` must be a power of two.
pub fn exact_pixel_coupling(size: usize, i: usize, j: usize, map: AffineMap) -> f64 {
    size as f64 * value(&Function::cell(size, i, 1.0), &[Function::cell(size, j, 1.0)], map)
}

/// [∂D_ij/∂s, ∂D_ij/∂o] of the 1D basis, right-hand at kinks, exact as [`exact_coupling_1d`].
pub fn exact_coupling_gradient_1d(i: usize, j: usize, map: AffineMap) -> [f64; 2] {
    slopes(&Function::haar(i), &[Function::haar(j)], map)
}

/// [∂D_ij/∂s, ∂D_ij/∂o] of the orthonormal pixels, right-hand at kinks; `size` must be a power of two.
pub fn exact_pixel_gradient(size: usize, i: usize, j: usize, map: AffineMap) -> [f64; 2] {
    slopes(&Function::cell(size, i, 1.0), &[Function::cell(size, j, 1.0)], map).map(|d| size as f64 * d)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_sum_forgets_nothing() {
        assert_eq!(LongSum::of([1e300, 1e-300, -1e300]).value(), 1e-300);
        assert_eq!(LongSum::of([1e300, -1e-300, -1e300]).value(), -1e-300);
        assert_eq!(LongSum::of([0.1, 0.2, -0.3]).value(), 2f64.powi(-55)); // of the numbers that 0.1, 0.2 and 0.3 are
        assert_eq!(LongSum::of([]).value(), 0.0);
        assert_eq!(LongSum::of([f64::MAX, 5e-324, -f64::MAX]).sign(), 1);
        for x in [1.0, -0.1, 1e100, -1e-100, 0.0] {
            assert_eq!(LongSum::of([x]).value(), x);
        }
    }

    #[test]
    fn slopes_of_the_scaling_function() {
        // ∫ φ(s v + o) φ(v) dv = (1 − o)/s for s > 1, o ≥ 0.
        let map = AffineMap::new(2.0, 0.25).unwrap();
        assert_eq!((exact_coupling_1d(0, 0, map), exact_coupling_gradient_1d(0, 0, map)), (0.375, [-0.1875, -0.5]));
    }
}
