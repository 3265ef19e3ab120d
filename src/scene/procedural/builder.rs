//! Surfaces that built-in scenes are put together from.

use std::collections::HashMap;
use std::f64::consts::TAU;

use nalgebra::Vector3;

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
}

/// Collects surfaces, or only counts their vertices.
pub(super) struct Builder {
    counts_only: bool,
    count: usize,
    part: u8,
    positions: Vec<Vector3<f32>>,
    normals: Vec<Vector3<f32>>,
    faces: Vec<[u32; 3]>,
    parts: Vec<u8>,
}

impl Builder {
    pub(super) fn new() -> Self {
        Self { counts_only: false, count: 0, part: 0, positions: vec![], normals: vec![], faces: vec![], parts: vec![] }
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
        Ok((Mesh::with_normals(self.positions, self.normals, self.faces)?, self.parts))
    }

    fn vertex(&mut self, position: Point, normal: Point) -> u32 {
        self.positions.push(position.cast());
        self.normals.push(normal.cast());
        self.parts.push(self.part);
        self.positions.len() as u32 - 1
    }

    /// A surface over (u, v) ∈ [0, 1]² in cells[0] × cells[1] quads, outward along ∂u × ∂v; `at` gives position and
    /// normal.
    pub(super) fn grid(&mut self, cells: [usize; 2], ends: [Ends; 2], at: impl Fn(f64, f64) -> (Point, Point)) {
        let (nu, nv) = (ends[0].rows(cells[0]), ends[1].rows(cells[1]));
        self.count += nu * nv;
        if self.counts_only {
            return;
        }
        let base = self.positions.len();
        for i in 0..nu {
            for j in 0..nv {
                let (position, normal) = at(i as f64 / cells[0] as f64, j as f64 / cells[1] as f64);
                self.vertex(position, normal);
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

    /// A closed box with hard edges.
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

    /// A closed cone stump between two points, with its caps.
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
            let hub = self.vertex(centre, axis * outward);
            for i in 0..sides {
                // The same arithmetic as the side's, so that rims coincide to the bit.
                let u = i as f64 / sides as f64;
                let rim = if outward < 0.0 { from } else { from + axis * length };
                self.vertex(rim + radial(u) * radius, axis * outward);
            }
            for i in 0..sides as u32 {
                let (a, b) = (hub + 1 + i, hub + 1 + (i + 1) % sides as u32);
                self.faces.push(if outward < 0.0 { [hub, b, a] } else { [hub, a, b] });
            }
        }
    }

    /// A sphere: an icosahedron whose edges are cut into equal parts.
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
                        self.vertex(centre + n * radius, n)
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
        self.grid([cells, cells], [Ends::Open; 2], |u, v| (Point::new(place(v), 0.0, place(u)), Point::y()));
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
