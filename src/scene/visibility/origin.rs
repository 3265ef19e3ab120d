//! Where the rays of a vertex start.

use nalgebra::Vector3;

use crate::scene::Mesh;

/// Where the rays of every vertex start.
///
/// The start is v + δ(n + t), which is rounded to `f32` where it is used: n the shading normal, t of
/// [`Around::inward`]. δ has to be above what two things may displace:
/// - The rounding of the start, and that of v and of what touches it there, which the file's or modeller's coordinates
///   have gone through. Each moves by at most u|vᵢ| along axis i, u = 2⁻²⁴, so along n and t by no more than r = u Σᵢ
///   (|nᵢ| + |tᵢ|)|vᵢ|. An axis along which nothing is moved does not count: a floor y = 0 has r = 0 however far from
///   the origin. δ ≥ 4r leaves a margin of two.
/// - The rounding of the predicates: but that is relative to distances from the start
///   ([`edge`](crate::scene::bvh::edge)), and from the vertex's own faces the start is away by δ itself. So any share
///   of the size of these faces will do.
///
/// The size is that of the shortest edge from v: a vertex of a small body may be the corner of a large face, never the
/// other way round.
pub(super) fn starts(mesh: &Mesh, offset: f64) -> impl Iterator<Item = Vector3<f64>> {
    const MARGIN: f64 = 4.0;
    const UNIT_ROUNDOFF: f64 = 0.5 * f32::EPSILON as f64;
    let around = around(mesh);
    let start = move |(vertex, Around { inward, shortest, .. }): (usize, Around)| {
        let normal = mesh.normals()[vertex].cast::<f64>();
        let position = mesh.positions()[vertex].cast::<f64>();
        let rounding = UNIT_ROUNDOFF * (normal.abs() + inward.abs()).dot(&position.abs());
        let size = if shortest.is_finite() { shortest } else { 0.0 };
        let delta = (offset * size).max(MARGIN * rounding);
        position + (normal + inward) * delta
    };
    around.into_iter().enumerate().map(start)
}

/// The faces around a vertex.
#[derive(Clone, Copy)]
struct Around {
    /// The angle-weighted mean of the unit directions into the faces, along the surface: at most 1 long, zero where the
    /// faces close around the vertex evenly, into the surface at its border.
    inward: Vector3<f64>,
    /// Sum of the angles.
    angles: f64,
    /// The shortest edge from the vertex; ∞ without one.
    shortest: f64,
}

fn around(mesh: &Mesh) -> Vec<Around> {
    let nothing = Around { inward: Vector3::zeros(), angles: 0.0, shortest: f64::INFINITY };
    let mut all = vec![nothing; mesh.positions().len()];
    for (face, indices) in mesh.faces().iter().enumerate() {
        let corners = mesh.corners(face).map(|p| p.cast::<f64>());
        for k in 0..3 {
            let around = &mut all[indices[k] as usize];
            let edges = [1, 2].map(|j: usize| corners[(k + j) % 3] - corners[k]);
            let [Some(a), Some(b)] = edges.map(|edge| edge.try_normalize(0.0)) else { continue };
            around.shortest = edges.iter().fold(around.shortest, |least, edge| least.min(edge.norm()));
            let angle = a.angle(&b);
            if let Some(middle) = (a + b).try_normalize(1e-12) {
                around.inward += middle * angle;
                around.angles += angle;
            }
        }
    }
    for (around, normal) in all.iter_mut().zip(mesh.normals()) {
        let n = normal.cast::<f64>();
        let mean = if around.angles > 0.0 { around.inward / around.angles } else { around.inward };
        around.inward = mean - n * n.dot(&mean);
    }
    all
}
