//! What a polygon looks like from the origin.

use nalgebra::Vector3;

/// 2^100: vertices farther apart in size than this are brought to one size. Products of four of them then neither over-
/// nor underflow.
const WIDEST: f64 = 1.267_650_600_228_229_4e30;

/// The outline to integrate: [clipped](clip) vertices of comfortable sizes, or one of NaN if a number is NaN or
/// infinite.
///
/// Only the directions of vertices matter, so that each may be scaled by a power of two, which rounds nothing. All are
/// by the same one, for the differences of neighbours to stay exact, but those that are smaller than the largest by a
/// factor of 2^100.
pub(super) fn outline(
    vertices: impl DoubleEndedIterator<Item = Vector3<f64>> + Clone,
    horizon: Option<Vector3<f64>>,
    out: &mut Vec<Vector3<f64>>,
) {
    let is_finite = |v: &Vector3<f64>| v.iter().all(|c| c.is_finite());
    if !vertices.clone().chain(horizon).all(|v| is_finite(&v)) {
        return out.push(Vector3::repeat(f64::NAN));
    }
    let largest = vertices.clone().fold(0.0, |size: f64, v| size.max(v.amax()));
    let sized = vertices.map(|v| {
        let size = v.amax();
        let own = if size < largest / WIDEST { size } else { largest };
        if (1.0 / WIDEST..=WIDEST).contains(&own) || size == 0.0 { v } else { scaled(&v, own) }
    });
    clip(sized, horizon.map(|n| if n.amax() > 0.0 { scaled(&n, n.amax()) } else { n }), out);
}

/// A vector over the power of two that is next below `size`, in two steps, for it may be out of range itself.
fn scaled(v: &Vector3<f64>, size: f64) -> Vector3<f64> {
    let half = -size.log2().floor() * 0.5;
    (v * half.floor().exp2()) * half.ceil().exp2()
}

/// The part of a closed outline above a plane through the origin [Sutherland & Hodgman 1974]; all of it without one.
///
/// Where a part that is not convex falls apart, its pieces stay joined along the plane, there and back: such arcs
/// cancel.
fn clip(
    vertices: impl DoubleEndedIterator<Item = Vector3<f64>> + Clone,
    horizon: Option<Vector3<f64>>,
    out: &mut Vec<Vector3<f64>>,
) {
    let Some(normal) = horizon else { return out.extend(vertices) };
    let Some(mut before) = vertices.clone().next_back() else { return };
    let mut height_before = normal.dot(&before);
    for vertex in vertices {
        let height = normal.dot(&vertex);
        let (above, above_before) = (height >= 0.0, height_before >= 0.0);
        if above != above_before {
            out.push((before * height - vertex * height_before) / (height - height_before));
        }
        if above {
            out.push(vertex);
        }
        (before, height_before) = (vertex, height);
    }
}

/// A closed outline of at least three vertices, none of them at the origin.
pub(super) struct Outline<'a> {
    vertices: &'a [Vector3<f64>],
    /// Σ of the unit directions to the vertices.
    middle: Vector3<f64>,
}

impl<'a> Outline<'a> {
    /// Scales the vertices to a size that neither over- nor underflows and drops those at the origin. `None` if fewer
    /// than three are left.
    pub(super) fn new(vertices: &'a mut Vec<Vector3<f64>>) -> Option<Self> {
        let size = vertices.iter().fold(0.0, |size: f64, v| size.max(v.amax()));
        if size == 0.0 {
            return None;
        }
        vertices.iter_mut().for_each(|v| *v = scaled(v, size));
        vertices.retain(|v| v.amax() > 0.0);
        if vertices.len() < 3 {
            return None;
        }
        let middle = vertices.iter().map(|v| v / v.norm()).sum();
        Some(Self { vertices, middle })
    }

    pub(super) fn vertices(&self) -> &[Vector3<f64>] {
        self.vertices
    }

    /// The edges (a, b).
    pub(super) fn edges(&self) -> impl Iterator<Item = (&Vector3<f64>, &Vector3<f64>)> {
        let n = self.vertices.len();
        self.vertices.iter().enumerate().map(move |(i, a)| (a, &self.vertices[if i + 1 == n { 0 } else { i + 1 }]))
    }

    /// The edges as great-circle arcs: pairs of vectors of like size along a and b. Of unlike ones b − a would lose the
    /// shorter.
    pub(super) fn arcs(&self) -> impl Iterator<Item = (Vector3<f64>, Vector3<f64>)> {
        self.edges().map(|(a, b)| {
            let (size_a, size_b) = (a.amax(), b.amax());
            // Vertices that are close together keep their exact difference.
            if size_a <= 4.0 * size_b && size_b <= 4.0 * size_a {
                (*a, *b)
            } else {
                (scaled(a, size_a), scaled(b, size_b))
            }
        })
    }

    /// The largest chord from the middle to a vertex, on the unit sphere; ∞ where there is no middle.
    pub(super) fn radius(&self) -> f64 {
        let norm = self.middle.norm();
        if !(norm > 0.0) {
            return f64::INFINITY;
        }
        let middle = self.middle / norm;
        self.vertices.iter().fold(0.0, |r: f64, v| r.max((v / v.norm() - middle).norm()))
    }

    /// The signed solid angle, as a fan of spherical triangles about the middle [Van Oosterom & Strackee 1983].
    ///
    /// Seen from the middle no triangle is near a half-sphere, unless the middle is no direction: the vertices surround
    /// the origin. Then `moment` = ∫ ω dω is one.
    pub(super) fn solid_angle(&self, moment: &Vector3<f64>) -> f64 {
        let spread = self.middle.norm() < 0.1 * self.vertices.len() as f64 && moment.norm() > 1e-3;
        let apex = if spread {
            let against = moment.dot(&self.middle) < -1e-9;
            if against { -moment } else { *moment }
        } else {
            self.middle
        };
        let apex = apex / apex.norm().max(f64::MIN_POSITIVE);
        let triangle = |(a, b): (Vector3<f64>, Vector3<f64>)| {
            let (length_a, length_b) = (a.norm(), b.norm());
            let determinant = apex.dot(&a.cross(&(b - a)));
            let rest = length_a * length_b + a.dot(&b) + apex.dot(&a) * length_b + apex.dot(&b) * length_a;
            2.0 * determinant.atan2(rest)
        };
        self.arcs().map(triangle).sum()
    }
}
