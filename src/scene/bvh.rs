//! The bounding volume hierarchy under every ray of the crate.
//!
//! Geometry is kept in *scene units*: moved by the centre of the mesh and scaled by a power of two, so that every
//! coordinate is in [−1, 1]. Scale and place of the user's scene then change no result beyond the rounding of the input.
//!
//! `obvhs` builds the binary tree. Single rays walk that tree; the visibility baker walks a copy of it with eight children
//! a node and eight triangles a leaf, held as structures of arrays.

use std::collections::HashMap;
use std::ops::{Add, Mul, Sub};

use glam::Vec3A;
use nalgebra::Vector3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ray::Ray;
use obvhs::{Boundable, BvhBuildParams};

use super::Mesh;

/// Lanes of a wide node and of a leaf.
pub(super) const WIDTH: usize = 8;

/// Bit of a child's index that says "a leaf".
pub(super) const LEAF: u32 = 1 << 31;

/// The unit roundoff of `f32` times twelve: the bound of the edge functions' error (see [`edge`]), relative to the sum
/// of the absolute values of their terms.
pub(super) const EDGE_TOLERANCE: f32 = 12.0 * 0.5 * f32::EPSILON;

/// How much larger than its triangle a box is on every side, in scene units: some roundings of a coordinate.
const BOX_PAD: f32 = 8.0 * f32::EPSILON;

/// Eight child boxes: smallest x, y, z, then largest x, y, z; lanes without a child are inside out.
#[derive(Debug, Clone)]
#[repr(C, align(32))]
pub(super) struct WideNode {
    pub(super) bounds: [[f32; WIDTH]; 6],
    /// Index of the child node, or of the leaf with [`LEAF`] set.
    pub(super) children: [u32; WIDTH],
}

/// Up to eight triangles: `corners[corner][axis][lane]`; spare lanes repeat the first one.
#[derive(Debug, Clone)]
#[repr(C, align(32))]
pub(super) struct Leaf {
    pub(super) corners: [[[f32; WIDTH]; 3]; 3],
    pub(super) len: usize,
}

/// Where a ray meets a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The face.
    pub face: u32,
    /// Distance from the ray's origin, in units of its direction's length.
    pub distance: f64,
    /// Weights of the face's corners: not negative, sum 1.
    pub barycentric: [f32; 3],
}

/// A bounding volume hierarchy over the faces of a mesh.
///
/// It keeps its own copy of the triangles. Building is deterministic. Cost: about 1 µs a face to build, 140 B a face.
#[derive(Clone, Default)]
pub struct Bvh {
    centre: Vector3<f64>,
    scale: f64,
    tree: Bvh2,
    /// Triangles in the order of `tree.primitive_indices`.
    triangles: Vec<[Vec3A; 3]>,
    /// The mesh's faces in the same order.
    faces: Vec<u32>,
    nodes: Vec<WideNode>,
    leaves: Vec<Leaf>,
    wide_depth: usize,
}

impl std::fmt::Debug for Bvh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bvh")
            .field("faces", &self.triangles.len())
            .field("nodes", &self.tree.nodes.len())
            .field("wide_nodes", &self.nodes.len())
            .field("leaves", &self.leaves.len())
            .finish_non_exhaustive()
    }
}

/// A ray in scene units, the largest component of its direction 1.
struct Start {
    ray: Ray,
    /// How far along the ray its origin was moved.
    skipped: f64,
    /// What the direction was divided by.
    length: f64,
}

struct Triangle([Vec3A; 3]);

impl Boundable for Triangle {
    fn aabb(&self) -> Aabb {
        // The ray-box test of single rays rounds: boxes have to be a little too large.
        let mut bounds = Aabb::from_points(&self.0);
        bounds.min -= Vec3A::splat(BOX_PAD);
        bounds.max += Vec3A::splat(BOX_PAD);
        bounds
    }
}

impl Bvh {
    /// The hierarchy of a mesh's faces.
    pub fn new(mesh: &Mesh) -> Self {
        let bounds = mesh.bounds();
        let (centre, size) = (bounds.centre(), bounds.size().max() * 0.5);
        let scale = if size > 0.0 { (-size.log2().ceil()).exp2() } else { 1.0 };
        let to_scene = |p: Vector3<f32>| {
            let q = ((p.cast::<f64>() - centre) * scale).cast::<f32>();
            Vec3A::new(q.x, q.y, q.z)
        };
        // Faces without area, in scene units, meet no ray.
        let area = |t: &[Vec3A; 3]| (t[1] - t[0]).as_dvec3().cross((t[2] - t[0]).as_dvec3()).length_squared();
        let (faces, given): (Vec<u32>, Vec<Triangle>) = (0..mesh.faces().len())
            .map(|face| (face as u32, Triangle(mesh.corners(face).map(to_scene))))
            .filter(|(_, triangle)| area(&triangle.0) > 0.0)
            .unzip();
        let mut bvh = Self { centre, scale, ..Self::default() };
        if given.is_empty() {
            return bvh;
        }
        let params = BvhBuildParams { max_prims_per_leaf: WIDTH as u32, ..BvhBuildParams::medium_build() };
        let mut tree = build_bvh2(&given, params, &mut std::time::Duration::default());
        // The walks size their stacks by this; optimisation may have made the tree deeper than its builder says.
        tree.max_depth = depth(&tree) + 1;
        bvh.triangles = tree.primitive_indices.iter().map(|&i| given[i as usize].0).collect();
        bvh.faces = tree.primitive_indices.iter().map(|&i| faces[i as usize]).collect();
        bvh.tree = tree;
        bvh.widen();
        bvh
    }

    /// A point of the world in scene units.
    pub(super) fn to_scene(&self, point: &Vector3<f64>) -> Vector3<f64> {
        (point - self.centre) * self.scale
    }

    /// A point in scene units in the world.
    pub(super) fn to_world(&self, point: &Vector3<f64>) -> Vector3<f64> {
        point / self.scale + self.centre
    }

    /// Scene units in a unit of the world.
    pub(super) fn scale(&self) -> f64 {
        self.scale
    }

    /// The wide nodes, root first; empty if the mesh fits one leaf.
    pub(super) fn nodes(&self) -> &[WideNode] {
        &self.nodes
    }

    pub(super) fn leaves(&self) -> &[Leaf] {
        &self.leaves
    }

    /// How many entries a walk's stack can hold at most.
    pub(super) fn stack_len(&self) -> usize {
        self.wide_depth * (WIDTH - 1) + WIDTH
    }

    /// The face that a ray meets first, front or back.
    ///
    /// `direction` need not be a unit vector. None if the ray meets nothing, or is zero or not finite. Nothing slips between two
    /// faces that share an edge.
    pub fn closest_hit(&self, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Hit> {
        let Start { ray, skipped, length } = self.ray(origin, direction)?;
        let mut best: Option<(usize, [f32; 4])> = None;
        let mut hit = obvhs::ray::RayHit::none();
        self.tree.ray_traverse(ray, &mut hit, |ray, index| {
            match intersect(&self.triangles[index], ray.origin, ray.direction) {
                Some(found) if found[0] <= ray.tmax => {
                    if best.is_none_or(|(_, b)| found[0] < b[0]) {
                        best = Some((index, found));
                    }
                    found[0]
                }
                _ => f32::INFINITY,
            }
        });
        let (index, [t, barycentric @ ..]) = best?;
        Some(Hit { face: self.faces[index], distance: (skipped + f64::from(t)) / (length * self.scale), barycentric })
    }

    /// Whether a ray meets any face, front or back.
    ///
    /// As [`closest_hit`](Self::closest_hit), but stops at the first face found.
    pub fn any_hit(&self, origin: &Vector3<f64>, direction: &Vector3<f64>) -> bool {
        let Some(Start { ray, .. }) = self.ray(origin, direction) else { return false };
        !self.tree.ray_traverse_miss(ray, |ray, index| {
            intersect(&self.triangles[index], ray.origin, ray.direction).map_or(f32::INFINITY, |found| found[0])
        })
    }

    /// The ray in scene units; None if it is none.
    fn ray(&self, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Start> {
        let length = direction.amax();
        let origin = self.to_scene(origin);
        let finite = direction.iter().chain(&origin).all(|c| c.abs() < 1e300);
        if !finite || length == 0.0 {
            return None;
        }
        let direction = direction / length;
        // The scene is in the ball of radius √3 around zero: start near it, where f32 is fine.
        let skipped = (-origin.dot(&direction) / direction.norm_squared() - 2.0).max(0.0);
        let origin = origin + direction * skipped;
        // A ray that passes so far away misses; the edge functions would overflow.
        if origin.amax() >= 1e12 {
            return None;
        }
        let vec3a = |v: Vector3<f64>| Vec3A::new(v.x as f32, v.y as f32, v.z as f32);
        Some(Start { ray: Ray::new_inf(vec3a(origin), vec3a(direction)), skipped, length })
    }

    /// Copies the binary tree into nodes of up to eight children and leaves of up to eight triangles.
    ///
    /// From the leaves up: the largest subtrees of at most eight triangles become leaves, the largest of at most eight
    /// leaves nodes above them, and so on. That fills nodes better than opening boxes from the root down.
    fn widen(&mut self) {
        let order = children_first(&self.tree);
        let nodes = &self.tree.nodes;
        let mut count = vec![0_usize; nodes.len()];
        for &i in &order {
            let first = nodes[i].first_index as usize;
            count[i] = if nodes[i].is_leaf() { nodes[i].prim_count as usize } else { count[first] + count[first + 1] };
        }
        // The units that a wide node's subtree was made of, by the subtree's root.
        let mut members: HashMap<usize, Vec<usize>> = HashMap::new();
        let mut is_unit = vec![false; nodes.len()];
        // A leaf of the binary tree has at most eight triangles, so that every one is in a unit.
        mark_units(&self.tree, &count, &mut is_unit);
        while !is_unit[0] {
            for &i in &order {
                let first = nodes[i].first_index as usize;
                count[i] = if is_unit[i] {
                    1
                } else if nodes[i].is_leaf() {
                    0
                } else {
                    count[first] + count[first + 1]
                };
            }
            let below = is_unit.clone();
            mark_units(&self.tree, &count, &mut is_unit);
            for &i in order.iter().filter(|&&i| is_unit[i] && count[i] > 1) {
                members.insert(i, units_below(&self.tree, i, &below));
            }
        }
        if !members.contains_key(&0) {
            self.push_leaf(0);
            return;
        }
        // (binary node, wide node that it becomes, depth)
        let mut todo = vec![(0_usize, 0_usize, 1_usize)];
        self.nodes.push(empty_node());
        while let Some((binary, wide, level)) = todo.pop() {
            self.wide_depth = self.wide_depth.max(level);
            for (lane, &member) in members[&binary].iter().enumerate() {
                let bounds = *self.tree.nodes[member].aabb();
                let child = if members.contains_key(&member) {
                    self.nodes.push(empty_node());
                    todo.push((member, self.nodes.len() - 1, level + 1));
                    self.nodes.len() as u32 - 1
                } else {
                    self.push_leaf(member) | LEAF
                };
                let (min, max) = (bounds.min.to_array(), bounds.max.to_array());
                let slot = &mut self.nodes[wide];
                for axis in 0..3 {
                    slot.bounds[axis][lane] = min[axis];
                    slot.bounds[axis + 3][lane] = max[axis];
                }
                slot.children[lane] = child;
            }
        }
    }

    /// Adds the triangles of a subtree, at most eight, as a leaf.
    fn push_leaf(&mut self, binary: usize) -> u32 {
        let mut leaf = Leaf { corners: [[[0.0; WIDTH]; 3]; 3], len: 0 };
        let mut todo = vec![binary];
        while let Some(index) = todo.pop() {
            let node = &self.tree.nodes[index];
            let first = node.first_index as usize;
            if !node.is_leaf() {
                todo.extend([first + 1, first]);
                continue;
            }
            for triangle in &self.triangles[first..][..node.prim_count as usize] {
                for (corner, point) in triangle.iter().enumerate() {
                    for (axis, value) in point.to_array().into_iter().enumerate() {
                        if leaf.len == 0 {
                            leaf.corners[corner][axis] = [value; WIDTH];
                        } else {
                            leaf.corners[corner][axis][leaf.len] = value;
                        }
                    }
                }
                leaf.len += 1;
            }
        }
        self.leaves.push(leaf);
        self.leaves.len() as u32 - 1
    }
}

/// The nodes of a binary tree, children before their parents.
fn children_first(tree: &Bvh2) -> Vec<usize> {
    let mut order = Vec::with_capacity(tree.nodes.len());
    let mut todo = vec![0_usize];
    while let Some(index) = todo.pop() {
        order.push(index);
        let node = &tree.nodes[index];
        if !node.is_leaf() {
            todo.extend([0, 1].map(|k| node.first_index as usize + k));
        }
    }
    order.reverse();
    order
}

/// Makes the roots of the largest subtrees of at most eight units the new units.
fn mark_units(tree: &Bvh2, count: &[usize], is_unit: &mut [bool]) {
    let mut todo = vec![0_usize];
    while let Some(index) = todo.pop() {
        let node = &tree.nodes[index];
        // A subtree of one unit is that unit: its root stays where it is, further down.
        if is_unit[index] || (count[index] <= WIDTH && (count[index] > 1 || node.is_leaf())) {
            is_unit[index] = true;
        } else {
            todo.extend([0, 1].map(|k| node.first_index as usize + k));
        }
    }
}

/// The units of a subtree, in the order of the tree.
fn units_below(tree: &Bvh2, root: usize, is_unit: &[bool]) -> Vec<usize> {
    let mut units = vec![];
    let mut todo = vec![root];
    while let Some(index) = todo.pop() {
        if is_unit[index] {
            units.push(index);
        } else {
            todo.extend([1, 0].map(|k| tree.nodes[index].first_index as usize + k));
        }
    }
    units
}

fn empty_node() -> WideNode {
    let (low, high) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
    WideNode { bounds: [low, low, low, high, high, high], children: [0; WIDTH] }
}

/// Levels of a binary tree.
fn depth(tree: &Bvh2) -> usize {
    let mut deepest = 0;
    let mut todo = vec![(0_usize, 1_usize)];
    while let Some((index, level)) = todo.pop() {
        deepest = deepest.max(level);
        let node = &tree.nodes[index];
        if !node.is_leaf() {
            todo.extend([0, 1].map(|k| (node.first_index as usize + k, level + 1)));
        }
    }
    deepest
}

/// The edge function of the edge a → b seen from the origin, and the sum of its terms' absolute values.
///
///   n = m × (b − a) = a × b,  m the nearer of a and b;  a direction d is on the inner side of the edge if n · d ≥ 0
///
/// `a`, `b` are relative to the ray's origin; `e` = b − a is from the positions themselves, which keeps it exact where the
/// edge is short and far. The nearer end keeps n exact where the edge is long and near, as a vertex's own edges are.
///
/// Error: with u the unit roundoff, |δm| ≤ u|m|, |δe| ≤ u|e|; each product adds u, the difference u, the product with
/// |d| ≤ 1 u, and the two sums 2u; altogether |δ(n · d)| ≤ 7u Q to first order with Q the second result, 8u with the
/// rounding of the tolerance itself; [`EDGE_TOLERANCE`] is 12u.
#[inline(always)]
pub(super) fn edge<T: Number>(m: [T; 3], e: [T; 3], abs: impl Fn(T) -> T) -> ([T; 3], T) {
    let n = [m[1] * e[2] - m[2] * e[1], m[2] * e[0] - m[0] * e[2], m[0] * e[1] - m[1] * e[0]];
    let (mx, my, mz) = (abs(m[0]), abs(m[1]), abs(m[2]));
    let (ex, ey, ez) = (abs(e[0]), abs(e[1]), abs(e[2]));
    (n, (my * ez + mz * ey) + (mz * ex + mx * ez) + (mx * ey + my * ex))
}

/// Squared length.
#[inline(always)]
pub(super) fn norm_squared<T: Number>(a: [T; 3]) -> T {
    a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
}

/// Six times the signed volume of origin and triangle (a is the first corner relative to the origin, e and f its edges to the
/// second and from there to the third), and the same sum as in [`edge`].
///
/// Positive if the face turns its back to the origin in a right-handed frame.
#[inline(always)]
pub(super) fn volume<T: Number>(a: [T; 3], e: [T; 3], f: [T; 3], abs: impl Fn(T) -> T) -> (T, T) {
    let (x0, x1) = (e[1] * f[2], e[2] * f[1]);
    let (y0, y1) = (e[2] * f[0], e[0] * f[2]);
    let (z0, z1) = (e[0] * f[1], e[1] * f[0]);
    let v = (x0 - x1) * a[0] + (y0 - y1) * a[1] + (z0 - z1) * a[2];
    let q = (abs(x0) + abs(x1)) * abs(a[0]) + (abs(y0) + abs(y1)) * abs(a[1]) + (abs(z0) + abs(z1)) * abs(a[2]);
    (v, q)
}

/// One `f32` or a register of them.
pub(super) trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>> Number for T {}

/// Distance and barycentric weights where a ray from `o` meets a triangle; `d` has largest component 1.
///
/// Edges are widened by their error bound, so that nothing slips through a shared edge.
fn intersect(triangle: &[Vec3A; 3], o: Vec3A, d: Vec3A) -> Option<[f32; 4]> {
    let p = triangle.map(|v| (v - o).to_array());
    let e = [0, 1, 2].map(|k: usize| (triangle[(k + 1) % 3] - triangle[k]).to_array());
    let (six_volume, volume_terms) = volume(p[0], e[0], e[1], f32::abs);
    if six_volume.abs() <= EDGE_TOLERANCE * volume_terms {
        return None;
    }
    let side = six_volume.signum();
    let mut weights = [0.0; 3];
    for k in 0..3 {
        let (a, b) = (p[k], p[(k + 1) % 3]);
        let nearer = if norm_squared(b) < norm_squared(a) { b } else { a };
        let (n, q) = edge(nearer, e[k], f32::abs);
        let value = side * (n[0] * d.x + n[1] * d.y + n[2] * d.z);
        if value < -EDGE_TOLERANCE * q {
            return None;
        }
        weights[(k + 2) % 3] = value.max(0.0);
    }
    let sum = weights[0] + weights[1] + weights[2];
    // Along a face the weights' sum, which is the slant but for rounding, at least has the right sign.
    let slant = (e[0][1] * e[1][2] - e[0][2] * e[1][1]) * d.x
        + (e[0][2] * e[1][0] - e[0][0] * e[1][2]) * d.y
        + (e[0][0] * e[1][1] - e[0][1] * e[1][0]) * d.z;
    let t = six_volume.abs() / if side * slant > 0.0 { side * slant } else { sum };
    t.is_finite().then(|| [t, weights[0] / sum, weights[1] / sum, weights[2] / sum])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The widening of the edges is as large as the error can be, and not many times larger.
    #[test]
    fn edge_functions_err_by_less_than_their_tolerance() {
        let mut state = 1_u64;
        let mut number = |size: f32| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 40) as f32 / (1 << 23) as f32 - 1.0) * size
        };
        let mut worst = 0.0_f64;
        for i in 0..200_000 {
            let size = [1.0, 1e-2, 1e-4][i % 3];
            let origin = [0; 3].map(|_| number(1.0));
            let from = origin.map(|o| o + number(0.5));
            let to = from.map(|p| p + number(size));
            let d = [number(1.0), number(1.0), 1.0];
            let [a, b] = [from, to].map(|p| [0, 1, 2].map(|k: usize| p[k] - origin[k]));
            let e = [0, 1, 2].map(|k: usize| to[k] - from[k]);
            let nearer = if norm_squared(b) < norm_squared(a) { b } else { a };
            let (n, terms) = edge(nearer, e, f32::abs);
            let value = n[0] * d[0] + (n[1] * d[1] + n[2]);
            let [o, p, q, d] = [origin, from, to, d].map(|v| Vector3::from(v).cast::<f64>());
            let exact = (p - o).cross(&(q - o)).dot(&d);
            worst = worst.max((f64::from(value) - exact).abs() / f64::from(EDGE_TOLERANCE * terms));
        }
        // 8 of the tolerance's 12 roundings by the analysis; chance reaches about a quarter of that.
        assert!((0.05..8.0 / 12.0).contains(&worst), "{worst}");
    }

    #[test]
    fn wide_nodes_hold_every_triangle_in_its_box() {
        for vertices in [1_000, 5_000] {
            let mesh = crate::scene::Procedural::Table.build(vertices).unwrap().mesh;
            let bvh = Bvh::new(&mesh);
            let triangles: u32 = bvh.leaves.iter().map(|leaf| leaf.len as u32).sum();
            assert_eq!(triangles as usize, mesh.faces().len());
            let mut reached = 0;
            for node in &bvh.nodes {
                for lane in (0..WIDTH).filter(|&lane| node.bounds[0][lane] <= node.bounds[3][lane]) {
                    let child = node.children[lane];
                    if child & LEAF == 0 {
                        continue;
                    }
                    reached += 1;
                    let leaf = &bvh.leaves[(child & !LEAF) as usize];
                    for axis in 0..3 {
                        let (low, high) = (node.bounds[axis][lane], node.bounds[axis + 3][lane]);
                        let inside = |corner: &[[f32; WIDTH]; 3]| corner[axis].iter().all(|c| (low..=high).contains(c));
                        assert!(leaf.corners.iter().all(inside));
                    }
                }
            }
            assert_eq!(reached, bvh.leaves.len());
        }
    }
}
