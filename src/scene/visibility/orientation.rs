//! How a patch of directions lies in the world of the triangles.

use nalgebra::{Matrix3, Vector3};
use pulp::Simd;

use super::lanes::Reg;
use crate::scene::bvh::{Leaf, WideNode};
use crate::sphere::Face;

/// The rounding of a turned coordinate, relative to the sum of the absolute values of its terms: 8 unit roundoffs, of
/// which the relative position has one, the matrix one, products and sums three.
const TURN_TOLERANCE: f32 = 8.0 * 0.5 * f32::EPSILON;

/// An orientation says where an origin and the three axes of a patch, right, down and out, lie among the triangles.
///
/// Edge functions are computed in axes of the orientation's choice and then turned, so that two triangles always agree
/// about the edge that they share.
pub(super) trait Orientation: Copy {
    /// Whether coordinates along the patch are rounded, and come with a bound.
    const ROUNDED: bool;

    /// 1 if a positive volume in the axes of the edge functions faces the origin, −1 if it turns its back.
    const HAND: f32;

    /// What the tolerance of edge functions is multiplied by.
    fn widening(&self) -> f32;

    /// The smallest and largest coordinates along right, down, out of a node's children, relative to the origin.
    fn boxes<S: Simd>(&self, simd: S, node: &WideNode, part: usize) -> [[Reg<S>; 3]; 2];

    /// A leaf's corners relative to the origin, in the axes of the edge functions.
    fn corner<S: Simd>(&self, simd: S, leaf: &Leaf, corner: usize, part: usize) -> [Reg<S>; 3];

    /// The edge from one corner to another from the positions themselves, in the axes of the edge functions.
    fn edge<S: Simd>(&self, simd: S, leaf: &Leaf, ends: [usize; 2], part: usize) -> [Reg<S>; 3];

    /// Such a corner's coordinates along right, down, out, and the bounds of their rounding.
    fn along<S: Simd>(&self, simd: S, corner: [Reg<S>; 3]) -> [[Reg<S>; 3]; 2];

    /// (n · right, n · down, n · out) of a vector in the axes of the edge functions.
    fn turn<S: Simd>(&self, simd: S, normal: [Reg<S>; 3]) -> [Reg<S>; 3];
}

/// A face of the cube along the world's axes: coordinates change places and signs, and nothing is rounded.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aligned {
    axis: [usize; 3],
    sign: [f32; 3],
    /// Along right, down, outward, with the sign of the world axis.
    origin: [f32; 3],
}

impl Aligned {
    pub(super) fn new(face: Face, origin: [f32; 3]) -> Self {
        let axes = face.axes();
        let axis = axes.map(|a| {
            if a[0] != 0.0 {
                0
            } else if a[1] != 0.0 {
                1
            } else {
                2
            }
        });
        let sign = [0, 1, 2].map(|k: usize| axes[k][axis[k]] as f32);
        Self { axis, sign, origin: axis.map(|a| origin[a]) }
    }
}

impl Orientation for Aligned {
    const ROUNDED: bool = false;

    // Right, down, outward is left-handed.
    const HAND: f32 = 1.0;

    #[inline(always)]
    fn widening(&self) -> f32 {
        1.0
    }

    #[inline(always)]
    fn boxes<S: Simd>(&self, simd: S, node: &WideNode, part: usize) -> [[Reg<S>; 3]; 2] {
        let zero = Reg::splat(simd, 0.0);
        let (mut low, mut high) = ([zero; 3], [zero; 3]);
        for k in 0..3 {
            let axis = self.axis[k];
            let (sign, origin) = (Reg::splat(simd, self.sign[k]), Reg::splat(simd, self.origin[k]));
            let (a, b) = if self.sign[k] > 0.0 { (axis, axis + 3) } else { (axis + 3, axis) };
            low[k] = sign * (Reg::load(simd, &node.bounds[a], part) - origin);
            high[k] = sign * (Reg::load(simd, &node.bounds[b], part) - origin);
        }
        [low, high]
    }

    #[inline(always)]
    fn corner<S: Simd>(&self, simd: S, leaf: &Leaf, corner: usize, part: usize) -> [Reg<S>; 3] {
        let mut p = [Reg::splat(simd, 0.0); 3];
        for k in 0..3 {
            let position = Reg::load(simd, &leaf.corners[corner][self.axis[k]], part);
            p[k] = Reg::splat(simd, self.sign[k]) * (position - Reg::splat(simd, self.origin[k]));
        }
        p
    }

    #[inline(always)]
    fn edge<S: Simd>(&self, simd: S, leaf: &Leaf, [from, to]: [usize; 2], part: usize) -> [Reg<S>; 3] {
        let mut e = [Reg::splat(simd, 0.0); 3];
        for k in 0..3 {
            let from = Reg::load(simd, &leaf.corners[from][self.axis[k]], part);
            let to = Reg::load(simd, &leaf.corners[to][self.axis[k]], part);
            e[k] = Reg::splat(simd, self.sign[k]) * (to - from);
        }
        e
    }

    #[inline(always)]
    fn along<S: Simd>(&self, simd: S, corner: [Reg<S>; 3]) -> [[Reg<S>; 3]; 2] {
        [corner, [Reg::splat(simd, 0.0); 3]]
    }

    #[inline(always)]
    fn turn<S: Simd>(&self, _: S, normal: [Reg<S>; 3]) -> [Reg<S>; 3] {
        normal
    }
}

/// A patch in any pose and of any size.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turned {
    origin: [f32; 3],
    /// Right, down, out.
    axes: [[f32; 3]; 3],
    /// The inverse: what turns a position into coordinates along right, down, out.
    dual: [[f32; 3]; 3],
    widening: f32,
}

impl Turned {
    /// `axes` in the triangles' world; they need not be of length 1 but must span the space.
    pub(super) fn new(axes: &Matrix3<f64>, dual: &Matrix3<f64>, origin: [f32; 3]) -> Self {
        let columns = [0, 1, 2].map(|k| axes.column(k).into_owned().cast::<f32>());
        let across = columns.iter().fold(Vector3::zeros(), |sum, a| sum + a.abs());
        let rows = [0, 1, 2].map(|k| dual.row(k).transpose().cast::<f32>().into());
        // Sums of products of rounded numbers: one rounding more than `edge` counts.
        let widening = across.amax() * 1.01;
        Self { origin, axes: columns.map(Into::into), dual: rows, widening }
    }
}

impl Orientation for Turned {
    const ROUNDED: bool = true;

    // The triangles' world is right-handed.
    const HAND: f32 = -1.0;

    #[inline(always)]
    fn widening(&self) -> f32 {
        self.widening
    }

    #[inline(always)]
    fn boxes<S: Simd>(&self, simd: S, node: &WideNode, part: usize) -> [[Reg<S>; 3]; 2] {
        let [zero, half, rounding] = [0.0, 0.5, TURN_TOLERANCE].map(
            #[inline(always)]
            |x| Reg::splat(simd, x),
        );
        // Middles and half lengths.
        let (mut middle, mut extent) = ([zero; 3], [zero; 3]);
        for j in 0..3 {
            let origin = Reg::splat(simd, self.origin[j]);
            let low = Reg::load(simd, &node.bounds[j], part) - origin;
            let high = Reg::load(simd, &node.bounds[j + 3], part) - origin;
            (middle[j], extent[j]) = ((low + high) * half, (high - low) * half);
        }
        let (mut low, mut high) = ([zero; 3], [zero; 3]);
        for k in 0..3 {
            let (mut along, mut reach, mut size) = (zero, zero, zero);
            for j in 0..3 {
                let d = Reg::splat(simd, self.dual[k][j]);
                along = along + d * middle[j];
                reach = reach + d.abs() * extent[j];
                size = size + d.abs() * middle[j].abs();
            }
            let reach = reach + (size + reach) * rounding;
            (low[k], high[k]) = (along - reach, along + reach);
        }
        [low, high]
    }

    #[inline(always)]
    fn corner<S: Simd>(&self, simd: S, leaf: &Leaf, corner: usize, part: usize) -> [Reg<S>; 3] {
        let mut p = [Reg::splat(simd, 0.0); 3];
        for k in 0..3 {
            p[k] = Reg::load(simd, &leaf.corners[corner][k], part) - Reg::splat(simd, self.origin[k]);
        }
        p
    }

    #[inline(always)]
    fn edge<S: Simd>(&self, simd: S, leaf: &Leaf, [from, to]: [usize; 2], part: usize) -> [Reg<S>; 3] {
        let mut e = [Reg::splat(simd, 0.0); 3];
        for k in 0..3 {
            e[k] = Reg::load(simd, &leaf.corners[to][k], part) - Reg::load(simd, &leaf.corners[from][k], part);
        }
        e
    }

    #[inline(always)]
    fn along<S: Simd>(&self, simd: S, corner: [Reg<S>; 3]) -> [[Reg<S>; 3]; 2] {
        let zero = Reg::splat(simd, 0.0);
        let (mut along, mut bound) = ([zero; 3], [zero; 3]);
        for k in 0..3 {
            let mut size = zero;
            for j in 0..3 {
                let term = Reg::splat(simd, self.dual[k][j]) * corner[j];
                (along[k], size) = (along[k] + term, size + term.abs());
            }
            bound[k] = size * Reg::splat(simd, TURN_TOLERANCE);
        }
        [along, bound]
    }

    #[inline(always)]
    fn turn<S: Simd>(&self, simd: S, normal: [Reg<S>; 3]) -> [Reg<S>; 3] {
        let mut out = [Reg::splat(simd, 0.0); 3];
        for k in 0..3 {
            let [x, y, z] = self.axes[k];
            out[k] =
                Reg::splat(simd, x) * normal[0] + (Reg::splat(simd, y) * normal[1] + Reg::splat(simd, z) * normal[2]);
        }
        out
    }
}
