//! The repairs of a mesh whose positions are rounded already.

use std::ops::Range;

use nalgebra::{Matrix3, Vector2, Vector3};

use super::origin::repeats;
use super::polygon::{Cut, Cutter};
use super::sides::{self, Corner, Twin};
use super::winding;
use crate::Result;
use crate::io::count::{Count, plural};
use crate::io::mesh::options::Winding;
use crate::io::mesh::split::{Smoothing, SmoothingRuns, Splitter, is_given};
use crate::io::report::{Loaded, Report};
use crate::scene::Mesh;

/// What a [`Soup`](super::Soup) becomes when its positions are those of the mesh.
#[derive(Debug)]
pub(super) struct Rounded {
    pub(super) winding: Winding,
    pub(super) positions: Vec<Vector3<f32>>,
    pub(super) normals: Option<Vec<Vector3<f32>>>,
    pub(super) faces: Vec<[u32; 3]>,
    /// Texture coordinates of the corners of every face; empty without.
    pub(super) corner_uv: Vec<[Vector2<f32>; 3]>,
    pub(super) fans: Vec<(usize, usize)>,
    pub(super) smoothing: SmoothingRuns,
    pub(super) origin: Vector3<f64>,
}

/// What a polygon's triangles have in common.
#[derive(Debug, Clone, Copy)]
struct Polygon {
    flat: bool,
    twin: Twin,
}

impl Rounded {
    pub(super) fn into_mesh(mut self, mut report: Report) -> Result<Loaded<Mesh>> {
        let ranges = self.polygons();
        let flat = self.split_by_smoothing(&ranges);
        let mut welded = sides::weld(&self.positions);
        let twins = sides::twins(&ranges, &self.faces, &welded);
        self.split_sides(&ranges, &twins, &mut welded, &mut report);
        let polygons: Vec<Polygon> = (flat.into_iter().zip(twins)).map(|(flat, twin)| Polygon { flat, twin }).collect();
        let mut polygon_of = self.cut_polygons(&ranges, &mut report);
        self.drop_degenerate_faces(&mut polygon_of, &mut report)?;
        if self.winding == Winding::Repair {
            self.turn_faces(&polygons, &polygon_of, &welded, &mut report);
        }
        self.split_opposed_vertices(&mut report);
        self.drop_unreferenced_vertices(&mut report);
        let had_normals = self.normals.is_some();
        let bad = self.scale_normals(&mut report);
        self.set_flat_normals(&polygons, &polygon_of);
        if had_normals {
            self.report_normals(bad, &mut report);
        }
        let failed = |e: crate::Error| report.error("", e.to_string());
        let mesh = match self.normals {
            Some(normals) => Mesh::with_normals(self.positions, normals, self.faces),
            None => Mesh::new(self.positions, self.faces),
        }
        .and_then(|mesh| mesh.with_origin(self.origin))
        // Last of all: seams of a texture change neither the normals nor what is repaired.
        .and_then(|mesh| if self.corner_uv.is_empty() { Ok(mesh) } else { mesh.with_corner_uv(&self.corner_uv) })
        .map_err(failed)?;
        Ok(report.loaded(mesh))
    }

    /// The triangles of each polygon.
    fn polygons(&self) -> Vec<Range<usize>> {
        let mut ranges = Vec::with_capacity(self.faces.len());
        let mut fans = self.fans.iter().peekable();
        let mut next = 0;
        while next < self.faces.len() {
            let n = fans.next_if(|f| f.0 == next).map_or(1, |f| f.1);
            ranges.push(next..next + n);
            next += n;
        }
        ranges
    }

    /// Twice the area of a face, as a vector along its normal; exact enough that only collinear corners give zero.
    fn area(&self, face: &[u32; 3]) -> Vector3<f64> {
        let [a, b, c] = face.map(|i| self.positions[i as usize].cast::<f64>());
        (b - a).cross(&(c - a))
    }

    /// Whether the file gives a vertex its normal.
    fn has_normal(&self, vertex: u32) -> bool {
        self.normals.as_ref().is_some_and(|n| is_given(&n[vertex as usize]))
    }

    fn push_copies<K: Copy + Eq + std::hash::Hash>(&mut self, splitter: &Splitter<K>) {
        let copy = |list: &mut Vec<Vector3<f32>>| {
            splitter.sources().iter().for_each(|&source| list.push(list[source as usize]));
        };
        copy(&mut self.positions);
        self.normals.as_mut().map(copy);
    }

    /// Gives faces of different smoothing groups vertices of their own, and flat ones vertices that they share with
    /// none, unless the file has a normal there. Which polygons are flat.
    fn split_by_smoothing(&mut self, ranges: &[Range<usize>]) -> Vec<bool> {
        if self.smoothing.is_uniform() {
            return vec![false; ranges.len()];
        }
        #[derive(Clone, Copy, PartialEq, Eq, Hash)]
        enum Key {
            Group(Option<i64>),
            Polygon(usize),
        }
        let mut splitter = Splitter::new(self.positions.len());
        let smoothing = std::mem::take(&mut self.smoothing);
        let mut smoothing_of = smoothing.in_order();
        let mut flat = Vec::with_capacity(ranges.len());
        for (p, range) in ranges.iter().enumerate() {
            let key = match smoothing_of(range.start) {
                Some(Smoothing::Flat) => Key::Polygon(p),
                Some(Smoothing::Group(group)) => Key::Group(Some(group)),
                None => Key::Group(None),
            };
            flat.push(matches!(key, Key::Polygon(_)));
            for f in range.clone() {
                // A triangle without area is dropped later: copies for it would be vertices without a face.
                if range.len() == 1 && self.area(&self.faces[f]) == Vector3::zeros() {
                    continue;
                }
                self.faces[f] = self.faces[f].map(|v| match key {
                    _ if self.has_normal(v) => v,
                    Key::Polygon(_) => splitter.vertex_in_order(v, key),
                    Key::Group(_) => splitter.vertex(v, key),
                });
            }
        }
        self.push_copies(&splitter);
        flat
    }

    /// Splits the vertices around which every polygon is there both ways round.
    fn split_sides(&mut self, ranges: &[Range<usize>], twins: &[Twin], welded: &mut Vec<u32>, report: &mut Report) {
        if !twins.iter().any(|t| t.both_ways) {
            return;
        }
        let mut splits = vec![true; self.positions.len()];
        for (range, _) in ranges.iter().zip(twins).filter(|(_, t)| !t.both_ways) {
            self.faces[range.clone()].iter().flatten().for_each(|&v| splits[v as usize] = false);
        }
        (0..self.positions.len()).filter(|&v| self.has_normal(v as u32)).for_each(|v| splits[v] = false);
        // The corners at each vertex that may be split.
        let mut around: Vec<(u32, Corner)> = Vec::new();
        for (p, range) in ranges.iter().enumerate().filter(|(p, _)| twins[*p].both_ways) {
            let corners: Vec<u32> = sides::corners(&self.faces, range).collect();
            let n = corners.len();
            around.extend((0..n).filter(|&i| splits[corners[i] as usize]).map(|i| {
                let at = |i: usize| welded[corners[i % n] as usize];
                (corners[i], Corner { polygon: p as u32, before: at(i + n - 1), after: at(i + 1) })
            }));
        }
        around.sort_unstable_by_key(|(v, c)| (*v, c.polygon));
        let mut splitter = Splitter::new(self.positions.len());
        let mut split = Count::default();
        for group in around.chunk_by(|a, b| a.0 == b.0) {
            let v = group[0].0;
            let corners: Vec<Corner> = group.iter().map(|g| g.1).collect();
            for (corner, side) in corners.iter().zip(sides::sides(&corners, twins)) {
                let new = splitter.vertex(v, side);
                if new == v {
                    continue;
                }
                let range = ranges[corner.polygon as usize].clone();
                split.add(|| format!("vertex {v}"));
                self.faces[range].iter_mut().flatten().filter(|i| **i == v).for_each(|i| *i = new);
            }
        }
        let n = splitter.sources().len();
        self.push_copies(&splitter);
        splitter.sources().iter().for_each(|&source| welded.push(welded[source as usize]));
        split.warn(report, |_| {
            format!(
                "faces are there twice, once each way round, without normals; the two sides got vertices of their own \
                 ({n} more)"
            )
        });
    }

    /// Cuts the polygons that the fan does not cover. The polygon of each face.
    fn cut_polygons(&mut self, ranges: &[Range<usize>], report: &mut Report) -> Vec<u32> {
        let mut faces = Vec::with_capacity(self.faces.len());
        let mut corner_uv = Vec::with_capacity(self.corner_uv.len());
        let mut polygon_of = Vec::with_capacity(self.faces.len());
        let mut crossing = Count::default();
        let (mut cutter, mut corners) = (Cutter::default(), Vec::new());
        for (p, range) in ranges.iter().enumerate() {
            let mut cut = Cut::Fan;
            if range.len() > 1 {
                corners.clear();
                corners.extend(sides::corners(&self.faces, range));
                let points: Vec<_> = corners.iter().map(|&i| self.positions[i as usize].cast()).collect();
                cut = cutter.cut(&points);
            }
            if cut == Cut::Crossing {
                let (n, first) = (corners.len(), faces.len());
                crossing.add(|| format!("triangle {first}, a polygon of {n} corners"));
            }
            if cut == Cut::Fan || cutter.triangles.is_empty() {
                faces.extend_from_slice(&self.faces[range.clone()]);
                corner_uv.extend_from_slice(self.corner_uv.get(range.clone()).unwrap_or_default());
            } else {
                let (triangles, _) = cutter.triangles.as_chunks::<3>();
                faces.extend(triangles.iter().map(|t| t.map(|k| corners[k as usize])));
                if !self.corner_uv.is_empty() {
                    let pairs: Vec<_> = sides::corners(&self.corner_uv, range).collect();
                    corner_uv.extend(triangles.iter().map(|t| t.map(|k| pairs[k as usize])));
                }
            }
            polygon_of.resize(faces.len(), p as u32);
        }
        self.faces = faces;
        self.corner_uv = corner_uv;
        crossing.warn(report, |n| {
            format!(
                "the outline of {} crosses itself; the triangles cover more or less than it encloses",
                plural(n, "polygon", "polygons")
            )
        });
        polygon_of
    }

    fn drop_degenerate_faces(&mut self, polygon_of: &mut Vec<u32>, report: &mut Report) -> Result<()> {
        let mut dropped = Count::default();
        let kept: Vec<bool> = (self.faces.iter().enumerate())
            .map(|(i, face)| {
                let flat = repeats(face) || self.area(face) == Vector3::zeros();
                if flat {
                    dropped.add(|| format!("triangle {i}"));
                }
                !flat
            })
            .collect();
        if dropped.n == self.faces.len() {
            return Err(report.error("", format!("all {} faces have no area", dropped.n)));
        }
        keep(&mut self.faces, &kept);
        keep(&mut self.corner_uv, &kept);
        keep(polygon_of, &kept);
        dropped.warn(report, |n| format!("{} without area left out", plural(n, "triangle", "triangles")));
        Ok(())
    }

    /// Turns faces of closed surfaces, and what is there once more with them.
    fn turn_faces(&mut self, polygons: &[Polygon], polygon_of: &[u32], welded: &[u32], report: &mut Report) {
        let twin = |f: usize| polygons[polygon_of[f] as usize].twin;
        let n = self.faces.len();
        let skipped: Vec<bool> = (0..n).map(|f| twin(f).both_ways || twin(f).first != polygon_of[f]).collect();
        let given: Option<Vec<Vector3<f32>>> = (self.normals.as_ref())
            .map(|list| list.iter().map(|n| if is_given(n) { *n } else { Vector3::zeros() }).collect())
            .filter(|list: &Vec<_>| list.iter().any(|n| *n != Vector3::zeros()));
        let turned = winding::repair(
            &winding::Faces {
                positions: &self.positions,
                normals: given.as_deref(),
                welded,
                faces: &self.faces,
                skipped: &skipped,
            },
            report,
        );
        let mut turned_polygon = vec![false; polygons.len()];
        (0..n).filter(|&f| turned[f]).for_each(|f| turned_polygon[polygon_of[f] as usize] = true);
        for f in 0..n {
            let again = skipped[f] && !twin(f).both_ways && turned_polygon[twin(f).first as usize];
            if turned[f] || again {
                self.faces[f].swap(1, 2);
                self.corner_uv.get_mut(f).into_iter().for_each(|corners| corners.swap(1, 2));
            }
        }
    }

    /// Splits the vertices whose faces look in opposite directions, so that the sum of their normals is rounding: those
    /// of a thin surface whose two sides are cut differently.
    fn split_opposed_vertices(&mut self, report: &mut Report) {
        let angles = |face: &[u32; 3]| {
            let corners = face.map(|i| self.positions[i as usize].cast::<f64>());
            [0, 1, 2].map(|k| {
                let to = |j: usize| corners[(k + j) % 3] - corners[k];
                to(1).angle(&to(2))
            })
        };
        // Where some weighted sum of normals is zero, not all of them are on the side of the plain sum.
        let mut plain = vec![Vector3::<f64>::zeros(); self.positions.len()];
        let unit = |face: &[u32; 3]| self.area(face).normalize();
        for face in &self.faces {
            face.iter().for_each(|&v| plain[v as usize] += unit(face));
        }
        let mut marked = vec![false; self.positions.len()];
        for face in &self.faces {
            let normal = unit(face);
            let behind = |v: u32| plain[v as usize].dot(&normal) <= 1e-3 && !self.has_normal(v);
            face.iter().filter(|v| behind(**v)).for_each(|&v| marked[v as usize] = true);
        }
        let mut sums = vec![(Vector3::<f64>::zeros(), 0.0); if marked.contains(&true) { marked.len() } else { 0 }];
        for face in self.faces.iter().filter(|f| f.iter().any(|&v| marked[v as usize])) {
            for (&v, angle) in face.iter().zip(angles(face)) {
                sums[v as usize].0 += unit(face) * angle;
                sums[v as usize].1 += angle;
            }
        }
        // What cancels to less than this is noise; the tip of a needle of a millionth of a radian is not met.
        for (mark, (sum, angle)) in marked.iter_mut().zip(&sums) {
            *mark &= sum.norm() <= 1e-6 * angle;
        }
        if !marked.contains(&true) {
            return;
        }
        let mut opposed = Count::default();
        // The direction that the normals around a vertex have in common but for the sign.
        let mut moments = vec![Matrix3::<f64>::zeros(); self.positions.len()];
        for face in self.faces.iter().filter(|f| f.iter().any(|&v| marked[v as usize])) {
            let normal = self.area(face).normalize();
            for (&v, angle) in face.iter().zip(angles(face)).filter(|(v, _)| marked[**v as usize]) {
                moments[v as usize] += normal * normal.transpose() * angle;
            }
        }
        let axes: Vec<Vector3<f64>> = (moments.iter().zip(&marked))
            .map(|(moment, &marked)| {
                let Some(eigen) = marked.then(|| moment.symmetric_eigen()) else { return Vector3::zeros() };
                eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned()
            })
            .collect();
        let mut splitter = Splitter::new(self.positions.len());
        for f in 0..self.faces.len() {
            let normal = self.area(&self.faces[f]);
            self.faces[f] = self.faces[f].map(|v| {
                if !marked[v as usize] {
                    return v;
                }
                let new = splitter.vertex(v, axes[v as usize].dot(&normal) >= 0.0);
                if new != v {
                    opposed.add(|| format!("vertex {v}"));
                }
                new
            });
        }
        let n = splitter.sources().len();
        self.push_copies(&splitter);
        opposed.warn(report, |_| {
            format!(
                "{} in opposite directions without normals; split in two sides",
                plural(n, "vertex has faces that look", "vertices have faces that look")
            )
        });
    }

    fn drop_unreferenced_vertices(&mut self, report: &mut Report) {
        let mut used = vec![false; self.positions.len()];
        self.faces.iter().flatten().for_each(|&i| used[i as usize] = true);
        let mut dropped = Count::default();
        used.iter().enumerate().filter(|(_, u)| !**u).for_each(|(i, _)| dropped.add(|| format!("vertex {i}")));
        if dropped.n == 0 {
            return;
        }
        let mut next = 0;
        let new_index: Vec<u32> = (used.iter())
            .map(|&u| {
                let index = next;
                next += u32::from(u);
                index
            })
            .collect();
        self.faces.iter_mut().flatten().for_each(|i| *i = new_index[*i as usize]);
        keep(&mut self.positions, &used);
        self.normals.iter_mut().for_each(|normals| keep(normals, &used));
        dropped.warn(report, |n| format!("{} without a face left out", plural(n, "vertex", "vertices")));
    }

    /// Scales normals to unit length; those that are not finite become zero, which means that there is none. How many.
    fn scale_normals(&mut self, report: &mut Report) -> usize {
        let mut bad = Count::default();
        for (i, normal) in self.normals.iter_mut().flatten().enumerate() {
            // In f64, where no finite f32 vector over- or underflows.
            let unit = normal.cast::<f64>().try_normalize(0.0).filter(|n| n.iter().all(|c| c.is_finite()));
            if unit.is_none() && *normal != Vector3::zeros() {
                bad.add(|| format!("vertex {i}"));
            }
            *normal = unit.map_or_else(Vector3::zeros, |n| n.cast());
        }
        let n = bad.n;
        bad.warn(report, |n| format!("{} not finite; computed from the faces", plural(n, "normal is", "normals are")));
        n
    }

    /// Warns of the file's normals that are not there, beside the `bad` ones, or against the faces.
    fn report_normals(&mut self, bad: usize, report: &mut Report) {
        let Some(normals) = &self.normals else { return };
        let missing = normals.iter().filter(|n| !is_given(n)).count();
        if missing > bad {
            report.warn(
                "",
                format!(
                    "{} missing or zero; computed from the faces",
                    plural(missing - bad, "normal is", "normals are")
                ),
            );
        }
        if missing == normals.len() {
            self.normals = None;
            return;
        }
        let against = (self.faces.iter())
            .filter(|f| {
                let mean: Vector3<f64> = f.iter().map(|&i| normals[i as usize].cast::<f64>()).sum();
                self.area(f).dot(&mean) < 0.0
            })
            .count();
        if 2 * against > self.faces.len() {
            report.warn(
                "",
                format!(
                    "{against} of {} faces are wound against their normals; the normals were kept",
                    self.faces.len()
                ),
            );
        }
    }

    /// Gives the corners of a flat polygon its own normal, the Newell normal if it is not plane.
    fn set_flat_normals(&mut self, polygons: &[Polygon], polygon_of: &[u32]) {
        if !polygons.iter().any(|p| p.flat) {
            return;
        }
        let mut normals = self.normals.take().unwrap_or_else(|| vec![Vector3::zeros(); self.positions.len()]);
        let mut sums = vec![Vector3::<f64>::zeros(); polygons.len()];
        for (face, &p) in self.faces.iter().zip(polygon_of) {
            sums[p as usize] += self.area(face);
        }
        for (face, &p) in self.faces.iter().zip(polygon_of).filter(|(_, p)| polygons[**p as usize].flat) {
            let normal = sums[p as usize].try_normalize(0.0).unwrap_or_default().cast();
            for &v in face {
                if !is_given(&normals[v as usize]) {
                    normals[v as usize] = normal;
                }
            }
        }
        self.normals = Some(normals);
    }
}

/// Keeps the elements that are marked.
fn keep<T>(list: &mut Vec<T>, marked: &[bool]) {
    let mut marks = marked.iter();
    list.retain(|_| marks.next().is_some_and(|m| *m));
}
