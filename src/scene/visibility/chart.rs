//! How a patch lies in the plane of its cells.

use pulp::Simd;

use super::lanes::{Mask, Reg};

/// Boxes whose far side is no farther than this, in the scale of the hierarchy, are behind the origin: the least
/// number whose reciprocal is finite.
const NEAREST: f32 = f32::MIN_POSITIVE;

/// Products of two lengths below this have lost digits.
const LEAST_SQUARE: f32 = 1e-32;

/// A map from directions, given along right, down and out of a patch, to the square [−1, 1]² of its cells.
pub(super) trait Chart: Copy {
    /// Whether straight lines stay straight, so that a triangle lies between its corners.
    const STRAIGHT: bool;

    /// The interval of each coordinate that boxes cover, at least, and which boxes are there at all: of no meaning for
    /// the others.
    fn cover<S: Simd>(simd: S, low: [Reg<S>; 3], high: [Reg<S>; 3]) -> ([[Reg<S>; 2]; 2], Mask<S>);
}

/// u = x/z, v = y/z: a picture of the directions with z > 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Perspective;

impl Chart for Perspective {
    const STRAIGHT: bool = true;

    /// A box with z in [z₀, z₁], z₁ > 0 has its smallest x/z at z₀ if x₀ < 0 and at z₁ otherwise; −∞ if z₀ ≤ 0.
    #[inline(always)]
    fn cover<S: Simd>(simd: S, low: [Reg<S>; 3], high: [Reg<S>; 3]) -> ([[Reg<S>; 2]; 2], Mask<S>) {
        let [zero, one, nearest, infinity] = [0.0, 1.0, NEAREST, f32::INFINITY].map(
            #[inline(always)]
            |x| Reg::splat(simd, x),
        );
        let near = nearest.less(low[2]).select(one / low[2], infinity);
        let far = one / high[2].max(nearest);
        let mut ends = [[zero; 2]; 2];
        for k in 0..2 {
            let least = low[k] * low[k].less(zero).select(near, far);
            let most = high[k] * zero.less(high[k]).select(near, far);
            ends[k] = [least, most];
        }
        (ends, nearest.less(high[2]))
    }
}

/// The equal-area disk of the hemisphere z ≥ 0, [`HemisphereDisk`](crate::sphere::HemisphereDisk): p = (x, y)/√(r(r +
/// z)) with r the length of (x, y, z).
#[derive(Debug, Clone, Copy)]
pub(super) struct Disk;

impl Chart for Disk {
    const STRAIGHT: bool = false;

    /// For x ≥ 0 and z ≥ 0, p_x grows with x and falls with |y| and with z: the derivative of p_x² in x is x(2(y² + z²)
    /// + z(2r² − x²)/r)/(r(r + z))², that of r(r + z) in z is (r + z)²/r. So the ends are at corners of the box.
    #[inline(always)]
    fn cover<S: Simd>(simd: S, low: [Reg<S>; 3], high: [Reg<S>; 3]) -> ([[Reg<S>; 2]; 2], Mask<S>) {
        let [zero, one, least_square] = [0.0, 1.0, LEAST_SQUARE].map(
            #[inline(always)]
            |x| Reg::splat(simd, x),
        );
        let [z0, z1] = [low[2].max(zero), high[2].max(zero)];
        let mut ends = [[zero; 2]; 2];
        for k in 0..2 {
            let [x0, x1] = [low[k], high[k]];
            let [y0, y1] = [low[1 - k], high[1 - k]];
            // The least and the largest |y|.
            let near = y0.max(zero - y1).max(zero);
            let far = y0.abs().max(y1.abs());
            for (end, (outward, inward)) in [(zero - x0, x0), (x1, zero - x1)].into_iter().enumerate() {
                // Towards the rim if the box reaches to this side of the middle, else as near to the middle as it
                // comes.
                let beyond = zero.less(outward);
                let x = beyond.select(outward, inward.max(zero));
                let (y, z) = (beyond.select(near, far), beyond.select(z0, z1));
                let squared = x * x + y * y;
                let r = (squared + z * z).sqrt();
                let product = r * r + r * z;
                let p = x / product.max(least_square).sqrt();
                let p = least_square.less(product).select(p, beyond.select(one, zero));
                let p = beyond.select(p, zero - p);
                ends[k][end] = if end == 0 { zero - p } else { p };
            }
        }
        (ends, zero.less_or_equal(high[2]))
    }
}
