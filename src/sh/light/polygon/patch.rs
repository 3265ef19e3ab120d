//! Integrals over the area of polygons that look small.

use nalgebra::Vector3;

use super::Nodes;
use super::outline::Outline;
use crate::Result;
use crate::numeric::GaussLegendre;

/// Nodes towards the middle and along an edge.
const RADIAL: usize = 6;
const ALONG: usize = 8;
/// Nodes an edge.
pub(super) const NODES: usize = RADIAL * ALONG;

/// Rules on [0, 1].
#[derive(Debug, Clone)]
pub(super) struct PatchRule {
    /// (r, w, weight · r): the point m + r ((a − m)(1 − w) + (b − m) w).
    nodes: Vec<[f64; 3]>,
}

impl PatchRule {
    pub(super) fn new() -> Result<Self> {
        let (radial, along) = (GaussLegendre::new(RADIAL)?, GaussLegendre::new(ALONG)?);
        let mut nodes = Vec::with_capacity(NODES);
        for (x, wx) in radial.nodes().iter().zip(radial.weights()) {
            for (y, wy) in along.nodes().iter().zip(along.weights()) {
                let r = 0.5 + 0.5 * x;
                nodes.push([r, 0.5 + 0.5 * y, 0.25 * wx * wy * r]);
            }
        }
        Ok(Self { nodes })
    }
}

/// The nodes of the triangles (m, a, b) between a point m in the middle and the edges.
///
/// With x on a triangle, ∫ y dω = det (m, a − m, b − m) ∫∫ y(x/|x|)/|x|³ r dr dw: the determinant is of small vectors,
/// and signed. An outline of radius ρ ≤ 1/20 and degree l ≤ 1/ρ: each rule sees frequencies up to 1 and, from |x|³, a
/// pole at 20 half-lengths or more.
pub(super) fn push_nodes(rule: &PatchRule, outline: &Outline, nodes: &mut Nodes) {
    let lengths = || outline.vertices().iter().map(|v| v.norm());
    let (near, far) = lengths().fold((f64::INFINITY, 0.0), |(near, far): (f64, f64), n| (near.min(n), far.max(n)));
    // Seen at a slant the distances differ; on the unit sphere they do not, at the price of rounding the vertices.
    let on_sphere = far > 1.2 * near;
    let place = |v: &Vector3<f64>| if on_sphere { v / v.norm() } else { *v };
    let count = outline.vertices().len() as f64;
    let m = outline.vertices().iter().map(place).sum::<Vector3<f64>>() / count;
    for (a, b) in outline.edges() {
        let (a, b) = (place(a) - m, place(b) - m);
        let determinant = m.dot(&a.cross(&(b - a)));
        for [r, w, weight] in &rule.nodes {
            let x = m + (a + (b - a) * *w) * *r;
            let length = 1.0 / x.norm();
            nodes.push((x * length).into(), [weight * determinant * (length * length * length), 0.0, 0.0]);
        }
    }
}
