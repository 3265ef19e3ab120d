//! From what a reader found to a [`Mesh`]: the repairs that all formats share.

mod origin;
mod polygon;
mod repair;
mod sides;
mod winding;

use nalgebra::Vector3;

use self::origin::repeats;
use self::repair::Rounded;
use crate::Result;
use crate::io::count::{Count, plural};
use crate::io::mesh::options::MeshOptions;
use crate::io::mesh::split::{Smoothing, SmoothingRuns, Splitter};
use crate::io::report::{Loaded, Report};
use crate::scene::Mesh;

/// Triangles as a file gives them. Indices are in range: the readers check that, where they still know the place.
#[derive(Debug, Default)]
pub(super) struct Soup {
    options: MeshOptions,
    /// Grown by [`push_position`](Self::push_position).
    pub(super) positions: Vec<Vector3<f64>>,
    /// The vertices that are NaN, infinite or beyond `f32`, and their places: an error only where a face uses one.
    unusable: Vec<(u32, String)>,
    /// One a position if the file has any; zero where it has none for that vertex.
    pub(super) normals: Option<Vec<Vector3<f32>>>,
    pub(super) faces: Vec<[u32; 3]>,
    /// Polygons of more than three corners: index of the first triangle of the fan, number of triangles.
    fans: Vec<(usize, usize)>,
    smoothing: SmoothingRuns,
    /// Faces of fewer than three corners, which were left out.
    slivers: Count,
}

impl Soup {
    /// A soup that becomes a mesh as the options say.
    pub(super) fn new(options: &MeshOptions) -> Self {
        Self { options: *options, ..Self::default() }
    }

    /// Appends a vertex; `place` is for the message if it turns out that it cannot be used.
    pub(super) fn push_position(&mut self, position: Vector3<f64>, place: impl FnOnce() -> String) {
        if !position.iter().all(|&c| (c as f32).is_finite()) {
            // More vertices than this are refused later.
            self.unusable.push((self.positions.len() as u32, place()));
        }
        self.positions.push(position);
    }

    /// Which of the faces that are appended from here on share normals, where the file gives none. Without a word all
    /// do.
    pub(super) fn set_smoothing(&mut self, smoothing: Smoothing) {
        self.smoothing.set(self.faces.len(), smoothing);
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

    /// Appends the copies of vertices that a splitter of these vertices made; their normals are the caller's.
    pub(super) fn push_copies<K: Copy + Eq + std::hash::Hash>(&mut self, splitter: &Splitter<K>) {
        for &source in splitter.sources() {
            if let Ok(at) = self.unusable.binary_search_by_key(&source, |u| u.0) {
                self.unusable.push((self.positions.len() as u32, self.unusable[at].1.clone()));
            }
            self.positions.push(self.positions[source as usize]);
        }
    }

    /// Repairs, warns and builds.
    ///
    /// Coordinates are rounded to `f32`, far from zero after an origin has been taken off. Polygons are cut, vertices
    /// split where faces do not share their normals, faces without area and vertices without a face dropped, faces
    /// turned as the options say; normals that are zero or not finite are computed from the faces, and normals are
    /// scaled to unit length.
    pub(super) fn into_mesh(mut self, mut report: Report) -> Result<Loaded<Mesh>> {
        std::mem::take(&mut self.slivers)
            .warn(&mut report, |n| format!("{} with fewer than three corners left out", plural(n, "face", "faces")));
        if self.positions.is_empty() {
            return Err(report.error("", "no vertices"));
        }
        if self.faces.is_empty() {
            return Err(report.error("", "no faces; a mesh needs triangles"));
        }
        // Every corner may become a vertex of its own: four times as many still have indices.
        if self.positions.len().max(self.faces.len()) >= 1 << 30 {
            let (vertices, faces) = (self.positions.len(), self.faces.len());
            return Err(
                report.error("", format!("{vertices} vertices, {faces} triangles; fewer than 2^30 can be read"))
            );
        }
        self.check_finite(&report)?;
        let up = self.options.up;
        self.positions.iter_mut().for_each(|p| *p = up.turn(p));
        self.normals.iter_mut().flatten().for_each(|n| *n = up.turn(n));
        let origin = origin::choose(&self.positions, &self.faces, &mut report);
        self.round(&origin, &report)?.into_mesh(report)
    }

    /// The vertices that faces use are finite.
    fn check_finite(&self, report: &Report) -> Result<()> {
        if self.unusable.is_empty() {
            return Ok(());
        }
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
        let finite = |i: u32| positions[i as usize].iter().all(|c| c.is_finite());
        if !(0..positions.len() as u32).all(finite) {
            let used = self.used();
            if let Some(i) = (0..positions.len() as u32).find(|&i| used[i as usize] && !finite(i)) {
                let place = self.unusable.iter().find(|(u, _)| *u == i).map_or("", |(_, place)| place);
                return Err(report.error(place, UNUSABLE));
            }
        }
        Ok(Rounded {
            winding: self.options.winding,
            positions,
            normals: self.normals,
            faces: self.faces,
            fans: self.fans,
            smoothing: self.smoothing,
            origin: *origin,
        })
    }
}

const UNUSABLE: &str = "the vertex is NaN, infinite or beyond f32";
