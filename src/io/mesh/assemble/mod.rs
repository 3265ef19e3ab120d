//! From what a reader found to a [`Mesh`]: the repairs that all formats share.

mod origin;
mod polygon;
mod repair;
mod sides;
mod winding;

use nalgebra::{Vector2, Vector3};

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
    /// Texture coordinates of the corners of the first faces, [`NO_UV`](Self::NO_UV) where the file gives none; none
    /// for the faces from there on.
    pub(super) corner_uv: Vec<[Vector2<f32>; 3]>,
    /// Texture coordinates that are not finite numbers.
    bad_uv: Count,
    /// Polygons of more than three corners: index of the first triangle of the fan, number of triangles.
    fans: Vec<(usize, usize)>,
    smoothing: SmoothingRuns,
    /// Faces of fewer than three corners, which were left out.
    slivers: Count,
}

impl Soup {
    /// Stands for the texture coordinates of a corner that has none.
    pub(super) const NO_UV: Vector2<f32> = Vector2::new(f32::NAN, f32::NAN);

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

    /// Texture coordinates in `f32`; those that are not finite there are counted and become (0, 0).
    pub(super) fn finite_uv(&mut self, pair: [f64; 2], place: impl FnOnce() -> String) -> Vector2<f32> {
        let rounded = Vector2::from(pair).cast::<f32>();
        if rounded.iter().all(|c| c.is_finite()) {
            return rounded;
        }
        self.bad_uv.add(place);
        Vector2::zeros()
    }

    /// Gives the triangles from number `first` on, which are the fan of a polygon, the texture coordinates of its
    /// corners.
    pub(super) fn push_corner_uv(&mut self, first: usize, polygon: &[Vector2<f32>]) {
        self.corner_uv.resize(first, [Self::NO_UV; 3]);
        self.corner_uv.extend((first..self.faces.len()).map(|f| [0, f - first + 1, f - first + 2].map(|k| polygon[k])));
    }

    /// Gives all corners the texture coordinates of their vertices, of which there is one a vertex.
    pub(super) fn set_vertex_uv(&mut self, uv: &[Vector2<f32>]) {
        self.corner_uv = self.faces.iter().map(|f| f.map(|i| uv[i as usize])).collect();
    }

    /// Leaves either no texture coordinates or finite ones at every corner.
    fn complete_uv(&mut self, report: &mut Report) {
        std::mem::take(&mut self.bad_uv).warn(report, |n| {
            let pairs = plural(n, "texture coordinate is", "texture coordinates are");
            format!("{pairs} malformed, NaN or infinite; set to (0, 0)")
        });
        if self.corner_uv.is_empty() {
            return;
        }
        self.corner_uv.resize(self.faces.len(), [Self::NO_UV; 3]);
        let mut without = Count::default();
        for (i, pair) in self.corner_uv.as_flattened_mut().iter_mut().enumerate().filter(|(_, p)| p.x.is_nan()) {
            without.add(|| format!("triangle {}", i / 3));
            *pair = Vector2::zeros();
        }
        if without.n == 3 * self.faces.len() {
            return self.corner_uv.clear();
        }
        without.warn(report, |n| {
            let corners = plural(n, "corner of a triangle has", "corners of triangles have");
            format!("{corners} no texture coordinates, others have; set to (0, 0)")
        });
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
    /// scaled to unit length. Last, vertices are split where corners have different texture coordinates.
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
        self.complete_uv(&mut report);
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
            corner_uv: self.corner_uv,
            fans: self.fans,
            smoothing: self.smoothing,
            origin: *origin,
        })
    }
}

const UNUSABLE: &str = "the vertex is NaN, infinite or beyond f32";
