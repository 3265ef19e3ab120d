//! From what a reader found to a [`Mesh`]: the repairs that all formats share.

use nalgebra::Vector3;

use super::origin::{self, repeats};
use super::{Loaded, Report};
use crate::Result;
use crate::scene::Mesh;

/// Triangles as a file gives them. Indices are in range: the readers check that, where they still know the place.
#[derive(Debug, Default)]
pub(super) struct Soup {
    /// Grown by [`push_position`](Self::push_position).
    pub(super) positions: Vec<Vector3<f64>>,
    /// The vertices that are NaN, infinite or beyond `f32`, and their places: an error only where a face uses one.
    unusable: Vec<(u32, String)>,
    /// One a position if the file has any; zero where it has none for that vertex.
    pub(super) normals: Option<Vec<Vector3<f32>>>,
    pub(super) faces: Vec<[u32; 3]>,
    /// Polygons of more than three corners: index of the first triangle of the fan, number of triangles.
    pub(super) fans: Vec<(usize, usize)>,
    /// Faces of fewer than three corners, which were left out.
    pub(super) slivers: Count,
}

/// How often something was seen, and where first.
#[derive(Debug, Default)]
pub(super) struct Count {
    pub(super) n: usize,
    pub(super) first: String,
}

impl Count {
    pub(super) fn add(&mut self, place: impl FnOnce() -> String) {
        if self.n == 0 {
            self.first = place();
        }
        self.n += 1;
    }

    /// Warns if anything was seen.
    pub(super) fn warn(self, report: &mut Report, message: impl FnOnce(usize) -> String) {
        if self.n > 0 {
            report.warn(self.first, message(self.n));
        }
    }
}

/// "1 face" or "5 faces".
pub(super) fn plural(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

impl Soup {
    /// Appends a vertex; `place` is for the message if it turns out that it cannot be used.
    pub(super) fn push_position(&mut self, position: Vector3<f64>, place: impl FnOnce() -> String) {
        if !position.iter().all(|&c| (c as f32).is_finite()) {
            // More vertices than this are refused later.
            self.unusable.push((self.positions.len() as u32, place()));
        }
        self.positions.push(position);
    }

    /// Appends a polygon as a fan around its first corner. Fewer than three corners add nothing.
    pub(super) fn push_polygon(&mut self, corners: &[u32], place: impl FnOnce() -> String) {
        if corners.len() < 3 {
            return self.slivers.add(place);
        }
        if corners.len() > 3 {
            self.fans.push((self.faces.len(), corners.len() - 2));
        }
        self.faces.extend(corners[1..].windows(2).map(|w| [corners[0], w[0], w[1]]));
    }

    /// Repairs, warns and builds.
    ///
    /// Coordinates are rounded to `f32`, far from zero after an origin has been taken off. Faces without area and vertices without a face are dropped, normals that are zero or not finite are computed
    /// from the faces, and normals are scaled to unit length.
    pub(super) fn into_mesh(mut self, mut report: Report) -> Result<Loaded<Mesh>> {
        std::mem::take(&mut self.slivers)
            .warn(&mut report, |n| format!("{} with fewer than three corners left out", plural(n, "face", "faces")));
        if self.positions.is_empty() {
            return Err(report.error("", "no vertices"));
        }
        if self.faces.is_empty() {
            return Err(report.error("", "no faces; a mesh needs triangles"));
        }
        if u32::try_from(self.positions.len()).is_err() {
            return Err(report.error("", format!("{} vertices; at most 2^32 − 1 can be indexed", self.positions.len())));
        }
        self.check_finite(&report)?;
        let origin = origin::choose(&self.positions, &self.faces, &mut report);
        let solid = self.round(&origin, &report)?;
        solid.into_mesh(report)
    }

    /// The vertices that faces use are finite.
    fn check_finite(&self, report: &Report) -> Result<()> {
        let used = self.used();
        let finite = |i: u32| self.positions[i as usize].iter().all(|c| c.is_finite());
        match self.unusable.iter().find(|(i, _)| used[*i as usize] && !finite(*i)) {
            Some((_, place)) => Err(report.error(&**place, UNUSABLE)),
            None => Ok(()),
        }
    }

    /// Which vertices have a face that does not name a vertex twice.
    fn used(&self) -> Vec<bool> {
        let mut used = vec![false; self.positions.len()];
        let faces = self.faces.iter().filter(|f| !repeats(f));
        faces.flatten().for_each(|&i| used[i as usize] = true);
        used
    }

    /// The same in `f32`, relative to an origin.
    fn round(self, origin: &Vector3<f64>, report: &Report) -> Result<Rounded> {
        let positions: Vec<Vector3<f32>> = self.positions.iter().map(|p| (p - origin).cast()).collect();
        let used = self.used();
        let beyond = |i: usize| used[i] && !positions[i].iter().all(|c| c.is_finite());
        if let Some(i) = (0..positions.len()).find(|&i| beyond(i)) {
            let place = self.unusable.iter().find(|(u, _)| *u as usize == i).map_or("", |(_, place)| place);
            return Err(report.error(place, UNUSABLE));
        }
        Ok(Rounded { positions, normals: self.normals, faces: self.faces, fans: self.fans, origin: *origin })
    }
}

const UNUSABLE: &str = "the vertex is NaN, infinite or beyond f32";

/// What [`Soup`] becomes when its positions are those of the mesh.
#[derive(Debug)]
struct Rounded {
    positions: Vec<Vector3<f32>>,
    normals: Option<Vec<Vector3<f32>>>,
    faces: Vec<[u32; 3]>,
    fans: Vec<(usize, usize)>,
    origin: Vector3<f64>,
}

impl Rounded {
    fn into_mesh(mut self, mut report: Report) -> Result<Loaded<Mesh>> {
        self.warn_of_concave_polygons(&mut report);
        self.drop_degenerate_faces(&mut report)?;
        self.drop_unreferenced_vertices(&mut report);
        self.repair_normals(&mut report);
        let failed = |e: crate::Error| report.error("", e.to_string());
        let mesh = match self.normals {
            Some(normals) => Mesh::with_normals(self.positions, normals, self.faces),
            None => Mesh::new(self.positions, self.faces),
        }
        .and_then(|mesh| mesh.with_origin(self.origin))
        .map_err(failed)?;
        Ok(report.loaded(mesh))
    }

    /// Twice the area of a face, as a vector along its normal; exact enough that only collinear corners give zero.
    fn area(&self, face: &[u32; 3]) -> Vector3<f64> {
        let [a, b, c] = face.map(|i| self.positions[i as usize].cast::<f64>());
        (b - a).cross(&(c - a))
    }

    fn warn_of_concave_polygons(&self, report: &mut Report) {
        let mut concave = Count::default();
        for &(first, n) in &self.fans {
            let areas = || self.faces[first..first + n].iter().map(|f| self.area(f));
            let whole: Vector3<f64> = areas().sum();
            // A fan triangle that faces against the whole polygon by more than rounding.
            if areas().any(|a| a.dot(&whole) < -1e-6 * a.norm() * whole.norm()) {
                concave.add(|| format!("triangle {first}"));
            }
        }
        concave.warn(report, |n| {
            format!(
                "{} cut as a fan around the first corner; triangles overlap there",
                plural(n, "concave polygon", "concave polygons")
            )
        });
    }

    fn drop_degenerate_faces(&mut self, report: &mut Report) -> Result<()> {
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
        let mut kept = kept.into_iter();
        self.faces.retain(|_| kept.next().unwrap_or(true));
        dropped.warn(report, |n| format!("{} without area left out", plural(n, "triangle", "triangles")));
        Ok(())
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
        let keep = |list: &mut Vec<Vector3<f32>>| {
            let mut used = used.iter();
            list.retain(|_| used.next().is_some_and(|u| *u));
        };
        keep(&mut self.positions);
        self.normals.as_mut().map(keep);
        dropped.warn(report, |n| format!("{} without a face left out", plural(n, "vertex", "vertices")));
    }

    fn repair_normals(&mut self, report: &mut Report) {
        let Some(normals) = &mut self.normals else { return };
        let (mut bad, mut missing) = (Count::default(), 0);
        for (i, normal) in normals.iter_mut().enumerate() {
            // In f64, where no finite f32 vector over- or underflows.
            let unit = normal.cast::<f64>().try_normalize(0.0).filter(|n| n.iter().all(|c| c.is_finite()));
            if unit.is_none() {
                if *normal == Vector3::zeros() { missing += 1 } else { bad.add(|| format!("vertex {i}")) }
            }
            *normal = unit.map_or_else(Vector3::zeros, |n| n.cast());
        }
        bad.warn(report, |n| format!("{} not finite; computed from the faces", plural(n, "normal is", "normals are")));
        if missing == normals.len() {
            self.normals = None;
        } else if missing > 0 {
            report.warn(
                "",
                format!("{} missing or zero; computed from the faces", plural(missing, "normal is", "normals are")),
            );
        }
        let Some(normals) = &self.normals else { return };
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
}
