//! One coupling, from what the constant pieces of two atoms have in common.
//!
//! On a piece [a, b] of the source atom and a piece [c, d] of the target atom the integrand is ± the product of both
//! amplitudes. In source space, x = s v + o, where nothing has been divided by s,
//!
//! ```math
//! ∫ f(s v + o) g(v) dv = 2^{(l_i + l_j)/2}/|s| Σ ± |[a, b] ∩ (s [c, d] + o)|.
//! ```
//!
//! An overlap is the least of b − a, |s| (d − c) and the two distances from the beginning of one piece to the end of
//! the other, or 0. Lengths are exact, distances are of the form x − s v − o and known to a few ε of themselves
//! ([`separation`]): so is every overlap, for all s and o. Where overlaps of opposite sign cancel, the sum is made
//! without rounding.

use super::atom::root_power;
use super::exact_sum::{exact_product, separation};
use super::zero::exact_integral;
use super::{AffineMap, Atom, Mother};

/// Overlaps of which more than this share cancels are summed without rounding: their errors would come through
/// eightfold.
const CANCELLED: f64 = 0.125;

/// The constant pieces of an atom: [where it begins, where it ends] among its breakpoints.
fn pieces(mother: Mother) -> &'static [[usize; 2]] {
    match mother {
        Mother::Scaling => &[[0, 2]],
        Mother::Wavelet => &[[0, 1], [1, 2]],
    }
}

/// x_k − (s v_n + o) of breakpoints x_k of the source and v_n of the target, n counted along x; exact in sign, to a few
/// ε of itself.
struct Separations([[f64; 3]; 3]);

impl Separations {
    fn new(source: [f64; 3], mut target: [f64; 3], map: AffineMap) -> Self {
        if map.scale() < 0.0 {
            target.reverse();
        }
        let images = target.map(|v| exact_product(map.scale(), v));
        Self(source.map(|x| images.map(|image| separation(x, image, (map.offset(), 0.0)))))
    }

    /// Whether piece [a, b] of the source lies in the image of piece [c, d] of the target.
    fn inside(&self, [a, b]: [usize; 2], [c, d]: [usize; 2]) -> bool {
        self.0[a][c] >= 0.0 && self.0[b][d] <= 0.0
    }

    /// Whether piece [a, b] of the source covers the image of piece [c, d] of the target.
    fn covers(&self, [a, b]: [usize; 2], [c, d]: [usize; 2]) -> bool {
        self.0[a][c] <= 0.0 && self.0[b][d] >= 0.0
    }
}

/// ∫ f(s v + o) g(v) dv to a few ε of itself; 0 if and only if it is 0 for the numbers that `map` holds.
pub(super) fn integral(source: Atom, target: Atom, map: AffineMap) -> f64 {
    let (x, v, s) = (source.breakpoints(), target.breakpoints(), map.scale().abs());
    let apart = Separations::new(x, v, map);
    const WHOLE: [usize; 2] = [0, 2];
    if apart.0[2][0] <= 0.0 || apart.0[0][2] >= 0.0 {
        return 0.0;
    }
    // A wavelet inside a constant piece of the other atom: its mean is zero.
    let (sources, targets) = (pieces(source.mother), pieces(target.mother));
    let lost = source.mother == Mother::Wavelet && targets.iter().any(|&piece| apart.inside(WHOLE, piece));
    if lost || (target.mother == Mother::Wavelet && sources.iter().any(|&piece| apart.covers(piece, WHOLE))) {
        return 0.0;
    }
    let (mut sum, mut all) = (0.0, 0.0);
    for (p, &[a, b]) in sources.iter().enumerate() {
        for (q, &[c, d]) in targets.iter().enumerate() {
            let lengths = (x[b] - x[a]).min(s * (v[d] - v[c]));
            let overlap = lengths.min(apart.0[b][c]).min(-apart.0[a][d]).max(0.0);
            sum += if (p + q) & 1 == 0 { overlap } else { -overlap };
            all += overlap;
        }
    }
    if target.mother == Mother::Wavelet && map.scale() < 0.0 {
        sum = -sum; // its pieces were counted along x
    }
    let (up, down) = (source.level as i32, target.level as i32);
    if sum.abs() < CANCELLED * all {
        return root_power(up - down) * (exact_integral(source, target, map) / s);
    }
    root_power(up + down) * (sum / s)
}

/// The values of a target atom beside each breakpoint of the source, on the side to which its velocity (by sign)
/// points: of the mother, without the amplitude.
///
/// Exact, whatever the breakpoints' distance to those of the target.
pub(super) fn values_beside(source: Atom, target: Atom, map: AffineMap, velocity: [f64; 3]) -> [f64; 3] {
    let images = target.breakpoints().map(|v| exact_product(map.scale(), v));
    let x = source.breakpoints();
    std::array::from_fn(|k| {
        let beyond = images.map(|image| separation(x[k], image, (map.offset(), 0.0)) * map.scale().signum());
        target.mother.beside(beyond, velocity[k])
    })
}
