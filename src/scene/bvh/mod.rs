//! The bounding volume hierarchy under every ray of the crate.
//!
//! Geometry is kept in the mesh's own coordinates, as they are: only scaled by a power of two, which is exact. So what
//! is near one vertex has the precision that its own coordinates have, whatever else is in the mesh and however far
//! away, and the scale of the user's scene changes no bit. (Exact but for coordinates below 2⁻¹⁵⁶ of the largest, which
//! `f32` loses.)
//!
//! Single rays walk a binary tree in `f64`; the visibility baker walks a copy of it with eight children a node and
//! eight triangles a leaf, held as structures of arrays, in `f32`.

mod edge;
mod ray;
mod tree;
mod wide;

use std::collections::HashSet;

use nalgebra::Vector3;

pub(super) use self::edge::{EDGE_TOLERANCE, edge, norm_squared, volume};
pub(super) use self::wide::{Leaf, WideNode};

use self::ray::{Meeting, Ray};
use self::tree::{Box3, Item, Node};
use self::wide::WideTree;
use super::Mesh;

use crate::approx_eq::approx_by_parts;

/// Lanes of a wide node and of a leaf.
pub(super) const WIDTH: usize = 8;

/// Bit of a child's index that says "a leaf".
pub(super) const LEAF: u32 = 1 << 31;

/// The largest coordinate of any face is in [2²⁹, 2³⁰).
///
/// That is where `f32` leaves most room to both sides of a product of three lengths, two of them edges: it stays finite
/// for origins up to [`FARTHEST_ORIGIN`], and has all its bits for lengths down to 2⁻³⁴, which is 2⁻⁶⁴ of the largest
/// coordinate.
const EXPONENT: i32 = 30;

/// Origins with a larger coordinate, in the tree's scale, are too far away to see the mesh: it is smaller there than a
/// rounding of the origin's coordinates.
pub(super) const FARTHEST_ORIGIN: f32 = (1_u64 << 61) as f32;

/// Where a ray meets a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The face.
    pub face: u32,
    /// Distance from the ray's origin, in units of its direction's length; ∞ where that is so short that no `f64` holds
    /// it.
    pub distance: f64,
    /// Weights of the face's corners: not negative, sum 1.
    pub barycentric: [f32; 3],
}

/// A bounding volume hierarchy over the faces of a mesh.
///
/// It keeps its own copy of the triangles. Building is deterministic. Cost: about 1 µs a face to build, whatever the
/// faces (many in one place, all the same, of very different sizes), 115 B a face. Of faces in the same place and the
/// same way round, as careless files have them by the thousand, only the first is kept: the others hide nothing that it
/// does not.
///
/// Single rays are traced in `f64` from where they start: their accuracy is that of the origin's own coordinates and of
/// the mesh's `f32` ones, and does not depend on how large the scene is or how far away the origin. Faces without area
/// meet no ray, nor does a face in whose plane the origin lies to the rounding of `f64`.
#[derive(Clone, Default)]
pub struct Bvh {
    /// A power of two.
    scale: f64,
    nodes: Vec<Node>,
    /// Scaled, in the order of the tree.
    triangles: Vec<[[f32; 3]; 3]>,
    /// The mesh's faces in the same order.
    faces: Vec<u32>,
    wide: WideTree,
}

impl std::fmt::Debug for Bvh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bvh")
            .field("faces", &self.triangles.len())
            .field("nodes", &self.nodes.len())
            .field("wide_nodes", &self.wide.nodes.len())
            .field("leaves", &self.wide.leaves.len())
            .finish_non_exhaustive()
    }
}

impl Bvh {
    /// The hierarchy of a mesh's faces.
    pub fn new(mesh: &Mesh) -> Self {
        let scale = scale(mesh);
        let scaled = |p: Vector3<f32>| <[f32; 3]>::from(p).map(|c| (f64::from(c) * scale) as f32);
        let triangle = |face: u32| mesh.corners(face as usize).map(scaled);
        let mut seen = HashSet::with_capacity(mesh.faces().len());
        let mut items: Vec<Item> = (0..mesh.faces().len() as u32)
            .map(|face| (face, triangle(face)))
            .filter(|(_, triangle)| has_area(triangle) && seen.insert(same_corners(triangle)))
            .map(|(face, triangle)| Item::new(Box3::around(&triangle), face))
            .collect();
        let nodes = tree::build(&mut items);
        let faces: Vec<u32> = items.iter().map(|item| item.index).collect();
        let triangles: Vec<_> = faces.iter().map(|&face| triangle(face)).collect();
        let wide = WideTree::new(&nodes, &triangles);
        Self { scale, nodes, triangles, faces, wide }
    }

    /// What the mesh's coordinates are multiplied by, a power of two.
    pub(super) fn scale(&self) -> f64 {
        self.scale
    }

    /// Centre and radius of a ball around all faces, in the mesh's coordinates; the radius is negative without any.
    pub(super) fn ball(&self) -> (Vector3<f64>, f64) {
        let Some(root) = self.nodes.first() else { return (Vector3::zeros(), -1.0) };
        let [low, high] = [root.bounds.low, root.bounds.high].map(|p| Vector3::from(p).cast::<f64>() / self.scale);
        ((low + high) * 0.5, 0.5 * (high - low).norm() * (1.0 + 1e-9))
    }

    /// The wide nodes, root first; empty if the mesh fits one leaf.
    pub(super) fn nodes(&self) -> &[WideNode] {
        &self.wide.nodes
    }

    pub(super) fn leaves(&self) -> &[Leaf] {
        &self.wide.leaves
    }

    /// How many entries a walk's stack can hold at most.
    pub(super) fn stack_len(&self) -> usize {
        self.wide.depth * (WIDTH - 1) + WIDTH
    }

    /// The face that a ray meets first, front or back; of faces at the same distance to the rounding of `f64`, any.
    ///
    /// `direction` need not be a unit vector: any length from the smallest denormal to the largest number is right.
    /// None if the ray meets nothing; if its direction is zero; if a number of it is NaN or infinite; and if it starts
    /// 10⁹⁰ times the mesh's largest coordinate away or farther. Nothing slips between two faces that share an edge.
    pub fn closest_hit(&self, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Hit> {
        let ray = self.ray(origin, direction)?;
        let mut best: Option<(usize, Meeting)> = None;
        ray.walk(&self.nodes, |faces| {
            for index in faces {
                if let Some(found) = ray.intersect(&self.triangles[index])
                    && best.as_ref().is_none_or(|(_, nearest)| found.distance < nearest.distance)
                {
                    best = Some((index, found));
                }
            }
            best.as_ref().map_or(f64::INFINITY, |(_, nearest)| nearest.distance)
        });
        let (index, Meeting { distance, weights }) = best?;
        // One division after the other: the product of the divisors may underflow.
        let distance = distance / self.scale / direction.amax();
        Some(Hit { face: self.faces[index], distance, barycentric: weights.map(|w| w as f32) })
    }

    /// Whether a ray meets any face, front or back.
    ///
    /// As [`closest_hit`](Self::closest_hit), but stops at the first face found.
    pub fn any_hit(&self, origin: &Vector3<f64>, direction: &Vector3<f64>) -> bool {
        self.any_hit_within(origin, direction, f64::INFINITY)
    }

    /// Whether a ray meets any face before a distance, in units of the direction's length.
    ///
    /// As [`any_hit`](Self::any_hit) for an infinite one; a distance of NaN, 0 or less meets nothing.
    pub fn any_hit_within(&self, origin: &Vector3<f64>, direction: &Vector3<f64>, distance: f64) -> bool {
        let Some(ray) = self.ray(origin, direction) else { return false };
        let end = distance * self.scale * direction.amax();
        let mut met = false;
        ray.walk(&self.nodes, |mut faces| {
            met = faces.any(|i| ray.intersect(&self.triangles[i]).is_some_and(|meeting| meeting.distance < end));
            // Behind everything that is left.
            if met { -1.0 } else { end }
        });
        met
    }

    /// The ray in the tree's scale; None if it is none.
    fn ray(&self, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Ray> {
        Ray::new((origin * self.scale).into(), (*direction).into())
    }
}

/// The power of two that brings the largest coordinate of any face into the range of [`EXPONENT`].
fn scale(mesh: &Mesh) -> f64 {
    let bounds = mesh.bounds();
    let largest = f64::from(bounds.min.amax().max(bounds.max.amax()));
    if largest == 0.0 {
        return 1.0;
    }
    // A positive `f32` is a normal `f64`: its exponent is in its bits.
    let exponent = (largest.to_bits() >> 52) as i32 - 1022;
    f64::from(EXPONENT - exponent).exp2()
}

/// What triangles of the same corners, and the same way round, have in common.
fn same_corners(triangle: &[[f32; 3]; 3]) -> [[u32; 3]; 3] {
    // −0 + 0 = 0: one set of bits for each position.
    let mut corners = triangle.map(|p| p.map(|c| (c + 0.0).to_bits()));
    let first = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
    corners.rotate_left(first);
    corners
}

/// Whether a triangle meets any ray at all.
fn has_area(triangle: &[[f32; 3]; 3]) -> bool {
    let [a, b, c] = triangle.map(|p| Vector3::from(p).cast::<f64>());
    (b - a).cross(&(c - a)) != Vector3::zeros()
}

approx_by_parts!([] Hit, f64, |h| close [[h.distance], h.barycentric.map(f64::from)] same [h.face]);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_nodes_hold_every_triangle_in_its_box() {
        for vertices in [1_000, 5_000] {
            let mesh = crate::scene::Procedural::Table.build(vertices).unwrap().mesh;
            let bvh = Bvh::new(&mesh);
            let triangles: u32 = bvh.leaves().iter().map(|leaf| leaf.len as u32).sum();
            assert_eq!(triangles as usize, mesh.faces().len());
            let mut reached = 0;
            for node in bvh.nodes() {
                for lane in (0..WIDTH).filter(|&lane| node.bounds[0][lane] <= node.bounds[3][lane]) {
                    let child = node.children[lane];
                    if child & LEAF == 0 {
                        continue;
                    }
                    reached += 1;
                    let leaf = &bvh.leaves()[(child & !LEAF) as usize];
                    for axis in 0..3 {
                        let (low, high) = (node.bounds[axis][lane], node.bounds[axis + 3][lane]);
                        let inside = |corner: &[[f32; WIDTH]; 3]| corner[axis].iter().all(|c| (low..=high).contains(c));
                        assert!(leaf.corners.iter().all(inside));
                    }
                }
            }
            assert_eq!(reached, bvh.leaves().len());
        }
    }
}
