//! Surfaces that built-in scenes are put together from.

use std::collections::HashMap;
use std::f64::consts::TAU;

use nalgebra::{Vector2, Vector3};

use crate::Result;
use crate::scene::Mesh;

type Point = Vector3<f64>;

/// Whether the last row of a grid of vertices is its first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ends {
    Open,
    Joined,
}

impl Ends {
    fn rows(self, cells: usize) -> usize {
        if self == Self::Joined { cells } else { cells + 1 }
    }

    /// The texture coordinate at parameter t. Where the ends are joined, a coordinate that ran from 0 to 1 would need
    /// two vertices at the seam: it runs to 1 half way round and back again.
    fn texture(self, t: f64) -> f64 {
        if self == Self::Joined { 1.0 - (2.0 * t - 1.0).abs() } else { t }
    }
}

/// Collects surfaces, or only counts their vertices.
pub(super) struct Builder {
    counts_only: bool,
    count: usize,
    part: u8,
    positions: Vec<Vector3<f32>>,
    normals: Vec<Vector3<f32>>,
    uv: Vec<Vector2<f32>>,
    faces: Vec<[u32; 3]>,
    parts: Vec<u8>,
}

impl Builder {
    pub(super) fn new() -> Self {
        Self {
            counts_only: false,
            count: 0,
            part: 0,
            positions: vec![],
            normals: vec![],
            uv: vec![],
            faces: vec![],
            parts: vec![],
        }
    }

    pub(super) fn counting() -> Self {
        Self { counts_only: true, ..Self::new() }
    }

    pub(super) fn vertices(&self) -> usize {
        self.count
    }

    /// What is added from now on belongs to this part.
    pub(super) fn part(&mut self, part: u8) {
        self.part = part;
    }

    pub(super) fn finish(self) -> Result<(Mesh, Vec<u8>)> {
        Ok((Mesh::with_normals(self.positions, self.normals, self.faces)?.with_uv(self.uv)?, self.parts))
    }

    fn vertex(&mut self, position: Point, normal: Point, uv: [f64; 2]) -> u32 {
        self.positions.push(position.cast());
        self.normals.push(normal.cast());
        self.uv.push(Vector2::from(uv).cast());
        self.parts.push(self.part);
        self.positions.len() as u32 - 1
    }

    /// A surface over (u, v) ∈ [0, 1]² in cells[0] × cells[1] quads, outward along ∂u × ∂v; `at` gives position and
    /// normal. Texture coordinates are (u, v), there and back along an axis whose ends are joined.
    pub(super) fn grid(&mut self, cells: [usize; 2], ends: [Ends; 2], at: impl Fn(f64, f64) -> (Point, Point)) {
        self.textured_grid(cells, ends, |u, v| [ends[0].texture(u), ends[1].texture(v)], at);
    }

    /// The same with texture coordinates by a function of (u, v).
    pub(super) fn textured_grid(
        &mut self,
        cells: [usize; 2],
        ends: [Ends; 2],
        uv: impl Fn(f64, f64) -> [f64; 2],
        at: impl Fn(f64, f64) -> (Point, Point),
    ) {
        let (nu, nv) = (ends[0].rows(cells[0]), ends[1].rows(cells[1]));
        self.count += nu * nv;
        if self.counts_only {
            return;
        }
        let base = self.positions.len();
        for i in 0..nu {
            for j in 0..nv {
                let (u, v) = (i as f64 / cells[0] as f64, j as f64 / cells[1] as f64);
                let (position, normal) = at(u, v);
                self.vertex(position, normal, uv(u, v));
            }
        }
        let index = |i: usize, j: usize| (base + (i % nu) * nv + j % nv) as u32;
        for i in 0..cells[0] {
            for j in 0..cells[1] {
                let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
                // Alternate diagonals: no preferred direction in interpolated shadows.
                if (i + j) % 2 == 0 {
                    self.faces.extend([[a, b, c], [a, c, d]]);
                } else {
                    self.faces.extend([[a, b, d], [b, c, d]]);
                }
            }
        }
    }

    /// A closed box with hard edges. The texture covers each side.
    pub(super) fn cuboid(&mut self, min: [f64; 3], max: [f64; 3], spacing: f64) {
        let (low, high) = (Point::from(min), Point::from(max));
        let size = high - low;
        let cells = size.map(|s| ((s / spacing).round() as usize).max(1));
        for axis in 0..3 {
            for outward in [-1.0, 1.0] {
                // (a, b, axis) right-handed; the far side swaps them.
                let (mut a, mut b) = ((axis + 1) % 3, (axis + 2) % 3);
                if outward < 0.0 {
                    std::mem::swap(&mut a, &mut b);
                }
                let normal = Point::ith(axis, outward);
                self.grid([cells[a], cells[b]], [Ends::Open; 2], |u, v| {
                    let mut p = low;
                    p[axis] = if outward < 0.0 { low[axis] } else { high[axis] };
                    p[a] = low[a] + u * size[a];
                    p[b] = low[b] + v * size[b];
                    (p, normal)
                });
            }
        }
    }

    /// A closed cone stump between two points, with its caps. The texture goes around twice, there and back, and along
    /// once; on a cap it is cut to a disc.
    pub(super) fn rod(&mut self, ends: [[f64; 3]; 2], radii: [f64; 2], spacing: f64) {
        let [from, to] = ends.map(Point::from);
        let (axis, length) = ((to - from).normalize(), (to - from).norm());
        let sides = ((TAU * radii[0].max(radii[1]) / (0.6 * spacing)).round() as usize).clamp(4, 48);
        let pieces = ((length / spacing).round() as usize).max(1);
        let across = if axis.x.abs() < 0.8 { Point::x() } else { Point::z() };
        let x = (across - axis * axis.dot(&across)).normalize();
        let y = axis.cross(&x);
        let radial = |u: f64| x * (TAU * u).cos() + y * (TAU * u).sin();
        let slope = axis * ((radii[0] - radii[1]) / length);
        self.grid([sides, pieces], [Ends::Joined, Ends::Open], |u, v| {
            let r = radial(u);
            (from + axis * (length * v) + r * (radii[0] + (radii[1] - radii[0]) * v), (r + slope).normalize())
        });
        for (centre, radius, outward) in [(from, radii[0], -1.0), (to, radii[1], 1.0)] {
            self.count += sides + 1;
            if self.counts_only {
                continue;
            }
            let hub = self.vertex(centre, axis * outward, [0.5; 2]);
            for i in 0..sides {
                // The same arithmetic as the side's, so that rims coincide to the bit.
                let u = i as f64 / sides as f64;
                let rim = if outward < 0.0 { from } else { from + axis * length };
                let (sin, cos) = (TAU * u).sin_cos();
                let uv = [0.5 + 0.5 * cos, 0.5 + 0.5 * outward * sin];
                self.vertex(rim + radial(u) * radius, axis * outward, uv);
            }
            for i in 0..sides as u32 {
                let (a, b) = (hub + 1 + i, hub + 1 + (i + 1) % sides as u32);
                self.faces.push(if outward < 0.0 { [hub, b, a] } else { [hub, a, b] });
            }
        }
    }

    /// A sphere: an icosahedron whose edges are cut into equal parts. Texture coordinates are those of
    /// [`hemispheres`].
    pub(super) fn sphere(&mut self, centre: [f64; 3], radius: f64, spacing: f64) {
        let parts = ((1.1 * radius / spacing).round() as usize).max(1);
        self.count += 10 * parts * parts + 2;
        if self.counts_only {
            return;
        }
        let centre = Point::from(centre);
        let (corners, triangles) = icosahedron();
        let mut known = HashMap::new();
        for triangle in triangles {
            let mut rows: Vec<Vec<u32>> = Vec::with_capacity(parts + 1);
            for i in 0..=parts {
                let mut row = Vec::with_capacity(parts + 1 - i);
                for j in 0..=parts - i {
                    let weights = [parts - i - j, i, j];
                    let mut key = [0, 1, 2].map(|k: usize| (if weights[k] > 0 { triangle[k] } else { 99 }, weights[k]));
                    key.sort_unstable();
                    let vertex = *known.entry(key).or_insert_with(|| {
                        let p = (0..3).fold(Point::zeros(), |p, k| p + corners[triangle[k]] * weights[k] as f64);
                        let n = p.normalize();
                        self.vertex(centre + n * radius, n, hemispheres(&n))
                    });
                    row.push(vertex);
                }
                rows.push(row);
            }
            for i in 0..parts {
                for j in 0..parts - i {
                    self.faces.push([rows[i][j], rows[i + 1][j], rows[i][j + 1]]);
                    if j + 1 < parts - i {
                        self.faces.push([rows[i + 1][j], rows[i + 1][j + 1], rows[i][j + 1]]);
                    }
                }
            }
        }
    }

    /// A square floor at y = 0 with a skirt; vertices lie `spacing` apart at the middle and further towards the rim.
    pub(super) fn floor(&mut self, half: f64, skirt: f64, spacing: f64) {
        // Derivative FINE at the middle, 1 at the rim after a cubic.
        const FINE: f64 = 0.6;
        let cells = ((2.0 * half * FINE / spacing).round() as usize).max(2);
        let place = move |t: f64| {
            let t = 2.0 * t - 1.0;
            half * t * (FINE + (1.0 - FINE) * t * t)
        };
        let along = |t: f64| 0.5 + 0.5 * place(t) / half;
        self.textured_grid(
            [cells, cells],
            [Ends::Open; 2],
            |u, v| [along(v), 1.0 - along(u)],
            |u, v| (Point::new(place(v), 0.0, place(u)), Point::y()),
        );
        for side in 0..4 {
            let turn = |x: f64, y: f64, z: f64| match side {
                0 => Point::new(x, y, z),
                1 => Point::new(z, y, -x),
                2 => Point::new(-x, y, -z),
                _ => Point::new(-z, y, x),
            };
            self.grid([cells, 1], [Ends::Open; 2], |u, v| {
                (turn(place(u), (v - 1.0) * skirt, half), turn(0.0, 0.0, 1.0))
            });
        }
    }
}

/// Texture coordinates of a direction: the halves z ≥ 0 and z ≤ 0 of the sphere each cover the same disc by Lambert's
/// equal-area projection, with u along x and v along y, so that the half behind has the mirror image of the one in
/// front. There is no pole and no seam.
fn hemispheres(n: &Point) -> [f64; 2] {
    // (x, y) √(1 − |z|) / √(x² + y²), without the quotient 0 / 0.
    let scale = 0.5 / (1.0 + n.z.abs()).sqrt();
    [0.5 + scale * n.x, 0.5 + scale * n.y]
}

/// Unit corners and outward counter-clockwise faces.
fn icosahedron() -> ([Point; 12], [[usize; 3]; 20]) {
    let golden = 0.5 + 1.25_f64.sqrt();
    let mut corners = [Point::zeros(); 12];
    for axis in 0..3 {
        for (k, (s, t)) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].into_iter().enumerate() {
            let mut p = Point::zeros();
            p[axis] = s;
            p[(axis + 1) % 3] = t * golden;
            corners[axis * 4 + k] = p.normalize();
        }
    }
    // Faces are the triples of corners at the edge's distance from each other.
    let edge = 2.0 / (1.0 + golden * golden).sqrt();
    let near = |a: usize, b: usize| ((corners[a] - corners[b]).norm() - edge).abs() < 1e-9;
    let mut faces = [[0; 3]; 20];
    let mut found = 0;
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    let outward = (corners[b] - corners[a]).cross(&(corners[c] - corners[a])).dot(&corners[a]) > 0.0;
                    faces[found] = if outward { [a, b, c] } else { [a, c, b] };
                    found += 1;
                }
            }
        }
    }
    (corners, faces)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest distance in the texture between two corners of a face, and the mesh.
    fn widest(build: impl Fn(&mut Builder)) -> (f32, Mesh) {
        let mut builder = Builder::new();
        build(&mut builder);
        let (mesh, _) = builder.finish().unwrap();
        let uv = mesh.uv().unwrap();
        assert!(uv.iter().flat_map(|c| c.iter()).all(|c| (0.0..=1.0).contains(c)));
        let pairs = mesh.faces().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let far = |[a, b]: [u32; 2]| (uv[a as usize] - uv[b as usize]).amax();
        (pairs.map(far).fold(0.0, f32::max), mesh)
    }

    #[test]
    fn joined_ends_have_no_seam() {
        let place = |u: f64, v: f64| {
            let ((su, cu), (sv, cv)) = ((TAU * u).sin_cos(), (TAU * v).sin_cos());
            (Point::new((2.0 + cu) * cv, su, (2.0 + cu) * sv), Point::new(cu * cv, su, cu * sv))
        };
        let (width, mesh) = widest(|b| b.grid([20, 25], [Ends::Joined; 2], place));
        assert!((width - 0.1).abs() < 1e-6, "{width}");
        assert_eq!(mesh.uv().unwrap()[0], Vector2::zeros());
        let (width, _) = widest(|b| b.grid([20, 25], [Ends::Joined, Ends::Open], place));
        assert!((width - 0.1).abs() < 1e-6, "{width}");
    }

    #[test]
    fn spheres_have_no_seam_and_their_texture_stands_upright() {
        let (width, mesh) = widest(|b| b.sphere([1.0, 2.0, 3.0], 0.5, 0.05));
        // Edges of an eleventh of 63.4°, a little longer in the middle of a side; the projection stretches by 2^-1/2.
        assert!(width < 0.1, "{width}");
        for (n, uv) in mesh.normals().iter().zip(mesh.uv().unwrap()) {
            let from_middle = uv.map(|c| 2.0 * c - 1.0);
            assert!((from_middle.norm_squared() - (1.0 - n.z.abs())).abs() < 1e-6);
            assert!(from_middle.perp(&n.xy()).abs() < 1e-6 && from_middle.dot(&n.xy()) >= 0.0);
        }
        let mesh = mesh.with_tangents_from_uv().unwrap();
        let handedness = mesh.uv_handedness().unwrap();
        for ((n, t), h) in mesh.normals().iter().zip(mesh.tangents()).zip(handedness) {
            if n.z.abs() > 0.2 {
                assert!(t.x > 0.0 && h == n.z.signum());
            }
        }
    }

    #[test]
    fn caps_floors_and_boxes_are_not_mirrored() {
        let build: [fn(&mut Builder); 3] = [
            |b| b.cuboid([-1.0, 0.0, 2.0], [1.0, 0.5, 3.0], 0.25),
            |b| b.floor(2.0, 0.1, 0.2),
            |b| b.rod([[0.0; 3], [0.0, 1.0, 2.0]], [0.3, 0.2], 0.1),
        ];
        for (i, build) in build.into_iter().enumerate() {
            let mesh = widest(build).1;
            let hands = mesh.uv_handedness().unwrap();
            let mirrored = hands.iter().filter(|h| **h < 0.0).count();
            assert_eq!(mirrored > 0, i == 2, "{i}");
            let caps = |n: &Vector3<f32>| n.dot(&Vector3::new(0.0, 1.0, 2.0).normalize()).abs() > 0.9;
            assert!(i < 2 || hands.iter().zip(mesh.normals()).all(|(h, n)| *h > 0.0 || !caps(n)));
        }
        let floor = widest(build[1]).1.with_tangents_from_uv().unwrap();
        for v in (0..floor.normals().len()).filter(|&v| floor.normals()[v].y > 0.5) {
            assert!((floor.tangents()[v] - Vector3::x()).norm() < 1e-6);
            assert!((floor.local_frame(v).bitangent + Vector3::z()).norm() < 1e-6);
        }
    }
}
