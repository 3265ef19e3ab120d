//! Which coefficients are exactly zero, decided in integers.
//!
//! An `f64` is an integer times a power of two, so everything is one in units of a small enough power of two. Comparing
//! in source space, x = s·v + o, avoids the division: the fixed functions move there, the transformed one stays, and
//! the integral changes by the positive factor |s| only. Of the functions only the signs count.

use num_traits::Float;

use super::steps::{Function, Steps, pieces};
use crate::affine::AffineMap;

/// Breakpoints of the Haar functions and pixels that are allowed here are multiples of 2^−12.
const GRID: i32 = 12;

type Signs = Steps<i128, i32>;

/// x = s·v + o in units of 2^−`unit` of the source, for v in units of 2^−`GRID`.
struct FixedPoint {
    scale: i128,
    offset: i128,
    one: i128,
}

/// (m, e) with x = m·2^e and m odd or 0.
fn decode(x: f64) -> (i128, i32) {
    let (mantissa, exponent, sign) = x.integer_decode();
    if mantissa == 0 {
        return (0, 0);
    }
    let zeros = mantissa.trailing_zeros();
    (i128::from(mantissa >> zeros) * i128::from(sign), i32::from(exponent) + zeros as i32)
}

impl FixedPoint {
    fn new(map: AffineMap) -> Self {
        let ((s, s_exp), (o, o_exp)) = (decode(map.scale()), decode(map.offset()));
        let unit = GRID + 0.max(-s_exp).max(-o_exp);
        let shifted = |m: i128, by: i32| {
            let bits = (128 - m.unsigned_abs().leading_zeros()) as i32 + by;
            assert!(bits <= 110, "scale and offset span too many bits for an exact decision: {map:?}");
            m << by
        };
        // v is counted in 2^−GRID, so s counts in 2^(GRID − unit).
        Self { scale: shifted(s, s_exp + unit - GRID), offset: shifted(o, o_exp + unit), one: shifted(1, unit) }
    }

    fn grid(x: f64) -> i128 {
        let steps = x * f64::from(1 << GRID);
        assert!(steps.fract() == 0.0, "a breakpoint is off the grid of 2^−{GRID}");
        steps as i128
    }

    fn signs(function: &Function, mirrored: bool, to: impl Fn(i128) -> i128) -> Signs {
        let moved = function.moved(mirrored, |x| to(Self::grid(x)));
        Signs { at: moved.at, values: moved.values.iter().map(|v| v.signum() as i32).collect() }
    }

    /// The transformed function, which stays in source space.
    fn source(&self, function: &Function) -> Signs {
        Self::signs(function, false, |x| x * (self.one >> GRID))
    }

    /// A fixed function, moved to source space.
    fn target(&self, function: &Function) -> Signs {
        Self::signs(function, self.scale < 0, |v| self.scale * v + self.offset)
    }
}

fn sign(factors: &[&Signs]) -> i32 {
    pieces(factors).into_iter().map(|(a, b, value)| (b - a) * i128::from(value)).sum::<i128>().signum() as i32
}

/// The sign of D_ij of the 1D basis, 0 if and only if it is exactly zero for the numbers that `map` holds.
///
/// For indices below 2048 and maps whose scale and offset, written in binary, span fewer than about 90 places together:
/// any 2^−8 ≤ |s| ≤ 2^8 with an offset of ordinary size. Panics otherwise.
pub fn coupling_sign_1d(i: usize, j: usize, map: AffineMap) -> i32 {
    let fixed = FixedPoint::new(map);
    sign(&[&fixed.source(&Function::haar(i)), &fixed.target(&Function::haar(j))])
}

/// The sign of D_ijk of the 1D basis, exact as in [`coupling_sign_1d`].
pub fn tripling_sign_1d(i: usize, j: usize, k: usize, map: AffineMap) -> i32 {
    let fixed = FixedPoint::new(map);
    let target = |j| fixed.target(&Function::haar(j));
    sign(&[&fixed.source(&Function::haar(i)), &target(j), &target(k)])
}

/// The sign of D_ij of the 2D nonstandard basis, exact as in [`coupling_sign_1d`].
pub fn coupling_sign_nonstandard(i: usize, j: usize, maps: [AffineMap; 2]) -> i32 {
    let [f, g] = [i, j].map(Function::nonstandard);
    let along = |axis: usize| {
        let fixed = FixedPoint::new(maps[axis]);
        sign(&[&fixed.source(&f[axis]), &fixed.target(&g[axis])])
    };
    along(0) * along(1)
}

fn tables(map: AffineMap, functions: &[Function]) -> [Vec<Signs>; 2] {
    let fixed = FixedPoint::new(map);
    [functions.iter().map(|f| fixed.source(f)).collect(), functions.iter().map(|f| fixed.target(f)).collect()]
}

fn count_pairs(map: AffineMap, functions: &[Function]) -> usize {
    let [sources, targets] = tables(map, functions);
    sources.iter().map(|f| targets.iter().filter(|g| sign(&[f, g]) != 0).count()).sum()
}

/// How many of the size² couplings D_ij of the 1D basis are not zero, exactly; see [`coupling_sign_1d`]. O(size²).
pub fn count_nonzeros_1d(size: usize, map: AffineMap) -> usize {
    count_pairs(map, &(0..size).map(Function::haar).collect::<Vec<_>>())
}

/// How many of the size² couplings of pixels are not zero, exactly; `size` must be a power of two up to 4096. O(size²).
pub fn count_pixel_nonzeros(size: usize, map: AffineMap) -> usize {
    count_pairs(map, &(0..size).map(|k| Function::cell(size, k, 1.0)).collect::<Vec<_>>())
}

/// How many of the size³ triplings D_ijk of the 1D basis, (j, k) and (k, j) apart, are not zero, exactly. O(size³).
pub fn count_tripling_nonzeros_1d(size: usize, map: AffineMap) -> usize {
    let [sources, targets] = tables(map, &(0..size).map(Function::haar).collect::<Vec<_>>());
    let row = |g: &Signs, h: &Signs| sources.iter().filter(|f| sign(&[f, g, h]) != 0).count();
    targets.iter().map(|g| targets.iter().map(|h| row(g, h)).sum::<usize>()).sum()
}

/// How many of the side⁴ couplings D_ij of the 2D nonstandard basis are not zero, exactly. O(side⁴).
pub fn count_nonzeros_nonstandard(side: usize, maps: [AffineMap; 2]) -> usize {
    let functions: Vec<_> = (0..side * side).map(Function::nonstandard).collect();
    let along = |axis: usize| {
        let factors: Vec<_> = functions.iter().map(|f| f[axis].clone()).collect();
        tables(maps[axis], &factors)
    };
    let [[fx, gx], [fy, gy]] = [along(0), along(1)];
    let coupled = |i: usize, j: usize| sign(&[&fx[i], &gx[j]]) != 0 && sign(&[&fy[i], &gy[j]]) != 0;
    (0..fx.len()).map(|i| (0..gx.len()).filter(|&j| coupled(i, j)).count()).sum()
}
