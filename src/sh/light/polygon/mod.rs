//! Polygons of constant radiance.

mod arcs;
mod outline;
mod patch;

use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

use self::arcs::{ArcRules, Coupling};
use self::outline::Outline;
use crate::error::check_length;
use crate::sh::basis::kernel::{Accumulate, Table, walk};
use crate::{Error, Real, Result};

/// Points that run through one walk over the basis.
const LANES: usize = 8;

/// From which sides a polygon sheds light.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Sides {
    /// Both: the order of the vertices does not matter.
    #[default]
    Both,
    /// The one from which the vertices run counterclockwise; from behind there is no light.
    Front,
}

/// The coefficients `∫_Ω y_lm dω` of polygons of radiance 1, seen from a point, analytically.
///
/// Since Δy = −l(l+1) y, the divergence theorem turns the integral over the polygon's solid angle into one along its
/// outline. Edges are great-circle arcs; p, the unit normal of an arc's plane, points into Ω, and there ∇y_l · p is ∂_p
/// of the solid harmonic r^l y_l, whose values on the sphere are of degree l − 1:
///
/// ```text
/// ∫_Ω y_lm dω = 1/(l(l+1)) Σ_arcs p · ∫ ∇(r^l y_lm) ds = Σ_{k, m′} G^k_{lm,m′} Σ_arcs p_k ∫ y_{l−1,m′} ds
/// ```
///
/// G has at most five entries a row. Along an arc y is a trigonometric polynomial of degree bands − 2; a Gauss–Legendre
/// rule chosen by the arc's length integrates it to rounding. Degree 0 is the spherical excess. Polygons that look
/// small, where the terms of the outline cancel, are integrated over their area instead: Gauss–Legendre rules on the
/// triangles about their middle. (The same coefficients as in Wang & Ramamoorthi 2018 and Belcour et al. 2018, by
/// another way.)
///
/// Vertices: any number, convex or not, in a plane or not: what counts is the outline seen from the point. It must lie
/// in an open half-space, as that of every polygon does that is seen from outside its plane. Where the outline crosses
/// itself, parts count as often as it runs around them. From within the plane, from a vertex or an edge there is no
/// light or a finite part of it.
///
/// Units: coefficients are in sr; times the radiance they are those of the light. Computed in `f64` whatever the
/// scalar. Accuracy, of the largest coefficient: 1e-14 at any size of the polygon up to 16 bands, measured against
/// brute force; slivers less (docs/sh.md).
/// Cost, counted: per arc about 6 + bands · length/2 evaluations of bands − 1 bands. Immutable; calls do not allocate
/// but for a scratch that sees more vertices than before.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Vector3, sh::PolygonLight};
/// let light = PolygonLight::new(3)?;
/// let octant = [Vector3::x(), Vector3::y(), Vector3::z()];
/// let mut out = [0.0; 9];
/// let solid_angle = light.eval(&octant, None, &mut out, &mut light.scratch());
/// assert!((solid_angle - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
/// // ∫ z over the octant is π/4.
/// assert!((out[2] - (0.75 / std::f64::consts::PI).sqrt() * std::f64::consts::FRAC_PI_4).abs() < 1e-15);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct PolygonLight {
    bands: usize,
    sides: Sides,
    /// Of all bands, for areas, and of one less, for arcs: a table of fewer bands is not the start of one of more.
    tables: [Table<f64>; 2],
    rules: ArcRules,
    patch: patch::PatchRule,
    coupling: Coupling,
    arch: Arch,
}

/// What a call to [`PolygonLight`] writes between: one for each thread.
#[derive(Debug, Clone, Default)]
pub struct PolygonScratch {
    outline: Vec<Vector3<f64>>,
    nodes: Vec<Node>,
    lanes: Vec<[f64; LANES]>,
    sums: Vec<[f64; 3]>,
    result: Vec<f64>,
}

/// `LANES` points with three weights each.
#[derive(Debug, Clone, Copy)]
struct Node {
    direction: [[f64; LANES]; 3],
    weights: [[f64; LANES]; 3],
}

/// Fills nodes one point after the other.
struct Nodes<'a> {
    blocks: &'a mut Vec<Node>,
    used: usize,
}

impl<'a> Nodes<'a> {
    fn new(blocks: &'a mut Vec<Node>) -> Self {
        blocks.clear();
        Self { blocks, used: LANES }
    }

    /// Adds a point; lanes without one are the north pole with no weight.
    #[inline]
    fn push(&mut self, direction: [f64; 3], weights: [f64; 3]) {
        if self.used == LANES {
            let zero = [0.0; LANES];
            self.blocks.push(Node { direction: [zero, zero, [1.0; LANES]], weights: [zero; 3] });
            self.used = 0;
        }
        let block = self.blocks.last_mut().expect("one was pushed");
        for k in 0..3 {
            block.direction[k][self.used] = direction[k];
            block.weights[k][self.used] = weights[k];
        }
        self.used += 1;
    }
}

impl PolygonLight {
    /// The largest number of bands.
    pub const MAX_BANDS: usize = 128;

    /// A plan for polygons of `bands` bands.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 1 ≤ `bands` ≤ [`MAX_BANDS`](Self::MAX_BANDS).
    pub fn new(bands: usize) -> Result<Self> {
        if !(1..=Self::MAX_BANDS).contains(&bands) {
            return Err(Error::OutOfRange { what: "bands", got: bands as f64, allowed: "1 to 128" });
        }
        Ok(Self {
            bands,
            sides: Sides::default(),
            tables: [Table::new(bands), Table::new(bands.saturating_sub(1).max(1))],
            rules: ArcRules::new(bands.saturating_sub(2))?,
            patch: patch::PatchRule::new()?,
            coupling: Coupling::new(bands),
            arch: Arch::new(),
        })
    }

    /// The same with light from these sides.
    pub fn with_sides(mut self, sides: Sides) -> Self {
        self.sides = sides;
        self
    }

    /// The number of bands.
    #[inline]
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// Scratch for calls, large enough for a polygon of eight vertices.
    pub fn scratch(&self) -> PolygonScratch {
        let count = self.bands * self.bands;
        PolygonScratch {
            outline: Vec::with_capacity(12),
            nodes: Vec::with_capacity(12 * (self.rules.largest().max(patch::NODES)).div_ceil(LANES)),
            lanes: vec![[0.0; LANES]; 3 * count],
            sums: vec![[0.0; 3]; count],
            result: vec![0.0; count],
        }
    }

    /// The coefficients of a polygon seen from the origin; returns its solid angle.
    ///
    /// `vertices` are relative to the point that sees them, at any scale, each at its own. With a `horizon` only what
    /// lies above it counts, n · ω > 0: a surface of normal n, of any length, sees no more; a normal of length 0 cuts
    /// nothing. Vertices at the origin are left out. Fewer than three vertices, and a polygon that looks like a line,
    /// give 0; NaN or infinity in a vertex or the horizon gives NaN.
    ///
    /// # Panics
    /// If `out.len()` is not bands².
    #[track_caller]
    pub fn eval<T: Real>(
        &self,
        vertices: &[Vector3<T>],
        horizon: Option<&Vector3<T>>,
        out: &mut [T],
        scratch: &mut PolygonScratch,
    ) -> T {
        check_length("coefficients", self.bands * self.bands, out.len());
        scratch.outline.clear();
        let wide = vertices.iter().map(|v| v.map(T::widen));
        outline::outline(wide, horizon.map(|n| n.map(T::widen)), &mut scratch.outline);
        self.integrate(scratch);
        for (out, &value) in out.iter_mut().zip(&scratch.result) {
            *out = T::of(value);
        }
        T::of(scratch.result[0] * (4.0 * std::f64::consts::PI).sqrt())
    }

    /// The coefficients of one polygon seen from many points, coefficient-major: coefficient i at point v at i·count +
    /// v.
    ///
    /// `vertices` and `points` are in one frame; differences are taken in `f64`. With `normals` the surface of each
    /// point clips as the horizon of [`eval`](Self::eval).
    ///
    /// # Panics
    /// If there are `normals` and not as many as points, or `out.len()` is not bands² times their number.
    #[track_caller]
    pub fn eval_batch<T: Real>(
        &self,
        vertices: &[Vector3<T>],
        points: &[Vector3<T>],
        normals: Option<&[Vector3<T>]>,
        out: &mut [T],
        scratch: &mut PolygonScratch,
    ) {
        let count = points.len();
        check_length("normals", count, normals.map_or(count, <[_]>::len));
        check_length("coefficients", (self.bands * self.bands).saturating_mul(count), out.len());
        for (p, point) in points.iter().enumerate() {
            scratch.outline.clear();
            let point = point.map(T::widen);
            // Only directions matter: halves where the difference overflows.
            let seen = vertices.iter().map(|v| {
                let (v, away) = (v.map(T::widen), v.map(T::widen) - point);
                if away.iter().all(|c| c.is_finite()) { away } else { v * 0.5 - point * 0.5 }
            });
            outline::outline(seen, normals.map(|n| n[p].map(T::widen)), &mut scratch.outline);
            self.integrate(scratch);
            for (i, &value) in scratch.result.iter().enumerate() {
                out[i * count + p] = T::of(value);
            }
        }
    }

    /// From the outline to the result.
    fn integrate(&self, scratch: &mut PolygonScratch) {
        let PolygonScratch { outline, nodes, lanes, sums, result } = scratch;
        let count = self.bands * self.bands;
        lanes.resize(3 * count, [0.0; LANES]);
        sums.resize(count, [0.0; 3]);
        result.resize(count, 0.0);
        result.fill(0.0);
        if outline.iter().any(|v| !v.iter().all(|c| c.is_finite())) {
            return result.fill(f64::NAN);
        }
        let Some(outline) = Outline::new(outline) else { return };
        let mut fill = Nodes::new(nodes);
        if outline.radius() * self.bands.max(20) as f64 <= 1.0 {
            patch::push_nodes(&self.patch, &outline, &mut fill);
            self.sum::<1>(self.bands, nodes, lanes, sums);
            result.iter_mut().zip(&*sums).for_each(|(r, s)| *r = s[0]);
        } else {
            let moment = arcs::push_nodes(&self.rules, &outline, &mut fill);
            result[0] = outline.solid_angle(&moment) / (4.0 * std::f64::consts::PI).sqrt();
            if self.bands > 1 {
                self.sum::<3>(self.bands - 1, nodes, lanes, sums);
                self.coupling.apply(sums, result);
            }
        }
        if result[0] < 0.0 && self.sides == Sides::Both {
            result.iter_mut().for_each(|r| *r = -*r);
        } else if result[0] > 0.0 && self.sides == Sides::Front {
            result.fill(0.0);
        } else if self.sides == Sides::Front {
            result.iter_mut().for_each(|r| *r = -*r);
        }
    }

    /// `sums[i][k]` = Σ w_k y_i over all nodes, k < C, i below `bands`.
    fn sum<const C: usize>(&self, bands: usize, nodes: &[Node], lanes: &mut [[f64; LANES]], sums: &mut [[f64; 3]]) {
        let lanes = &mut lanes[..C * bands * bands];
        lanes.fill([0.0; LANES]);
        let table = &self.tables[usize::from(bands < self.bands)];
        self.arch.dispatch(Sum::<C> { table, bands, nodes, lanes });
        for (sum, lanes) in sums.iter_mut().zip(lanes.as_chunks::<C>().0) {
            for k in 0..C {
                sum[k] = lanes[k].iter().sum();
            }
        }
    }
}

struct Sum<'a, const C: usize> {
    table: &'a Table<f64>,
    bands: usize,
    nodes: &'a [Node],
    lanes: &'a mut [[f64; LANES]],
}

impl<const C: usize> WithSimd for Sum<'_, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let zero = [[0.0; LANES]; C];
        for node in self.nodes {
            let [x, y, z] = node.direction.each_ref();
            let mut weights = zero;
            weights.copy_from_slice(&node.weights[..C]);
            let mut sum = Accumulate { lanes: &mut *self.lanes, weights, even: zero, odd: zero };
            walk(self.table, self.bands, [x, y, z], &mut sum);
        }
    }
}
