//! Triangle meshes with per-vertex shading frames.

mod bounds;
mod frame;
mod normals;
mod repair;
mod uv;

use nalgebra::{Affine3, Vector2, Vector3};

pub use bounds::Bounds;
pub use frame::LocalFrame;
use normals::{angle_weighted_normals, double_area_vector, perpendicular, unit};
pub use repair::MeshRepair;

use crate::approx_eq::approx_by_parts;
use crate::{Error, Result};

/// A triangle mesh: positions, unit normals and unit tangents per vertex, and texture coordinates where they are given;
/// counter-clockwise faces seen from outside.
///
/// Every position is finite, every normal and tangent is a unit vector and they are perpendicular, every face names
/// three vertices that are there. Vertices without a face are allowed; so are faces without area, which neither cast
/// nor receive anything ([`repair`](Self::repair) drops them).
///
/// Positions are relative to the mesh's [`origin`](Self::origin), in world coordinates and `f64`; it is zero unless
/// [`with_origin`](Self::with_origin) says otherwise. Distant light, visibility and everything else that is computed
/// from one mesh uses the positions alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    positions: Vec<Vector3<f32>>,
    normals: Vec<Vector3<f32>>,
    tangents: Vec<Vector3<f32>>,
    uv: Option<Vec<Vector2<f32>>>,
    faces: Vec<[u32; 3]>,
    origin: Vector3<f64>,
}

impl Mesh {
    /// A mesh whose normals are the angle-weighted means of the faces around a vertex.
    ///
    /// A vertex without a face of positive area gets the normal +y. Tangents are perpendicular to the normals and
    /// otherwise arbitrary but deterministic.
    ///
    /// # Errors
    /// [`Error::Empty`] without vertices or faces, [`Error::NotFinite`] for a position that is not finite,
    /// [`Error::Index`] for a face that names a vertex that is not there.
    pub fn new(positions: Vec<Vector3<f32>>, faces: Vec<[u32; 3]>) -> Result<Self> {
        check_parts(&positions, &faces)?;
        let normals = angle_weighted_normals(&positions, &faces);
        let tangents = normals.iter().map(perpendicular).collect();
        Ok(Self { positions, normals, tangents, uv: None, faces, origin: Vector3::zeros() })
    }

    /// A mesh with given normals.
    ///
    /// Normals are scaled to unit length; one that is zero, NaN or infinite is replaced by the angle-weighted mean of
    /// the faces around its vertex, as in [`new`](Self::new).
    ///
    /// # Errors
    /// Those of [`new`](Self::new), and [`Error::Length`] unless there is one normal a vertex.
    pub fn with_normals(
        positions: Vec<Vector3<f32>>,
        normals: Vec<Vector3<f32>>,
        faces: Vec<[u32; 3]>,
    ) -> Result<Self> {
        check_parts(&positions, &faces)?;
        if normals.len() != positions.len() {
            return Err(Error::Length { what: "mesh normals", expected: positions.len(), got: normals.len() });
        }
        let mut normals: Vec<_> = normals.iter().map(unit).collect();
        if normals.iter().any(Option::is_none) {
            let from_faces = angle_weighted_normals(&positions, &faces);
            normals.iter_mut().zip(from_faces).for_each(|(n, f)| *n = n.or(Some(f)));
        }
        let normals: Vec<_> = normals.into_iter().flatten().collect();
        let tangents = normals.iter().map(perpendicular).collect();
        Ok(Self { positions, normals, tangents, uv: None, faces, origin: Vector3::zeros() })
    }

    /// The same mesh with given tangents, which anisotropic reflectance is aligned to.
    ///
    /// Each is made perpendicular to its normal and scaled to unit length; one that is not finite, or parallel to the
    /// normal to 1e-6, is replaced by an arbitrary but deterministic one.
    ///
    /// # Errors
    /// [`Error::Length`] unless there is one tangent a vertex.
    pub fn with_tangents(mut self, tangents: Vec<Vector3<f32>>) -> Result<Self> {
        if tangents.len() != self.positions.len() {
            return Err(Error::Length { what: "mesh tangents", expected: self.positions.len(), got: tangents.len() });
        }
        self.tangents = tangents
            .iter()
            .zip(&self.normals)
            .map(|(t, n)| {
                match unit(t) {
                    Some(t) => {
                        let (t, n) = (t.cast::<f64>(), n.cast::<f64>());
                        (t - n * n.dot(&t)).try_normalize(1e-6).map(|t| t.cast())
                    }
                    None => None,
                }
                .unwrap_or_else(|| perpendicular(n))
            })
            .collect();
        Ok(self)
    }

    /// The same positions relative to another point: world = origin + position.
    ///
    /// For coordinates far from zero (surveyors' metres, planets), of which `f32` would keep too few digits: the origin
    /// holds what they have in common. Nothing moves relative to the mesh.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a coordinate of the origin is NaN or infinite.
    ///
    /// # Example
    /// ```
    /// use haarmonic::{nalgebra::Vector3, scene::Mesh};
    /// let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]].map(Vector3::from);
    /// let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2]])?.with_origin(Vector3::new(5e5, 5.4e6, 0.0))?;
    /// assert_eq!(mesh.origin() + mesh.positions()[1].cast(), Vector3::new(500_001.0, 5.4e6, 0.0));
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn with_origin(mut self, origin: Vector3<f64>) -> Result<Self> {
        if let Some(index) = origin.iter().position(|c| !c.is_finite()) {
            return Err(Error::NotFinite { what: "mesh origin: coordinate", index });
        }
        self.origin = origin;
        Ok(self)
    }

    /// Several meshes as one: their vertices and faces in the order given.
    ///
    /// Texture coordinates are kept if all of the meshes have them; else the merged mesh has none. The origin is that
    /// of the first mesh; the positions of a mesh with another one are moved, in `f64`, so that the world coordinates
    /// stay.
    ///
    /// # Errors
    /// [`Error::Empty`] without a mesh, [`Error::OutOfRange`] for more than 2³² − 1 vertices, [`Error::NotFinite`] if a
    /// position is beyond `f32` seen from the first mesh's origin.
    pub fn merge<'a>(meshes: impl IntoIterator<Item = &'a Self>) -> Result<Self> {
        let origin = Vector3::zeros();
        let uv = Some(Vec::new());
        let mut all = Self { positions: vec![], normals: vec![], tangents: vec![], uv, faces: vec![], origin };
        for mesh in meshes {
            let base = all.positions.len();
            if base == 0 {
                all.origin = mesh.origin;
            }
            if base + mesh.positions.len() > u32::MAX as usize {
                return Err(Error::OutOfRange {
                    what: "vertices of a merged mesh",
                    got: (base + mesh.positions.len()) as f64,
                    allowed: "below 2^32",
                });
            }
            if mesh.origin == all.origin {
                all.positions.extend_from_slice(&mesh.positions);
            } else {
                let shift = mesh.origin - all.origin;
                all.positions.extend(mesh.positions.iter().map(|p| (p.cast::<f64>() + shift).cast::<f32>()));
                if let Some(index) = all.positions[base..].iter().position(|p| !p.iter().all(|c| c.is_finite())) {
                    return Err(Error::NotFinite { what: "position of a merged mesh", index: base + index });
                }
            }
            all.normals.extend_from_slice(&mesh.normals);
            all.tangents.extend_from_slice(&mesh.tangents);
            all.uv = all.uv.zip(mesh.uv()).map(|(mut all, uv)| {
                all.extend_from_slice(uv);
                all
            });
            all.faces.extend(mesh.faces.iter().map(|f| f.map(|i| i + base as u32)));
        }
        if all.faces.is_empty() { Err(Error::Empty { what: "list of meshes" }) } else { Ok(all) }
    }

    /// The mesh moved, turned, scaled or sheared.
    ///
    /// Normals go with the inverse transpose, tangents with the map; a mirroring map turns the faces around, so that
    /// they stay counter-clockwise seen from outside. The map acts on the positions; the [`origin`](Self::origin) and
    /// the texture coordinates stay (those of a mirrored mesh are then mirrored too).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if the map's determinant is zero or not finite, [`Error::NotFinite`] if a vertex
    /// overflows.
    pub fn transformed(&self, map: &Affine3<f64>) -> Result<Self> {
        let linear = map.matrix().fixed_view::<3, 3>(0, 0).into_owned();
        let determinant = linear.determinant();
        let inverse = linear.try_inverse().filter(|_| determinant != 0.0 && determinant.is_finite());
        let Some(inverse) = inverse else {
            return Err(Error::OutOfRange {
                what: "determinant of a mesh's transformation",
                got: determinant,
                allowed: "finite and not zero",
            });
        };
        let inverse_transpose = inverse.transpose();
        let positions =
            self.positions.iter().map(|p| map.transform_point(&p.cast::<f64>().into()).coords.cast()).collect();
        let mirrored = determinant < 0.0;
        let normals = self.normals.iter().map(|n| {
            let n: Vector3<f64> = inverse_transpose * n.cast::<f64>();
            n.try_normalize(0.0).unwrap_or_else(Vector3::zeros).cast()
        });
        let faces = self.faces.iter().map(|&[a, b, c]| if mirrored { [a, c, b] } else { [a, b, c] }).collect();
        let tangents = self.tangents.iter().map(|t| (linear * t.cast::<f64>()).cast()).collect();
        let moved = Self::with_normals(positions, normals.collect(), faces)?;
        let uv = self.uv.clone();
        Ok(Self { uv, ..moved.with_tangents(tangents)?.with_origin(self.origin)? })
    }

    /// The point that positions are relative to, in world coordinates: world = origin + position.
    #[inline]
    pub const fn origin(&self) -> Vector3<f64> {
        self.origin
    }

    /// Positions, one a vertex, relative to the [`origin`](Self::origin).
    #[inline]
    pub fn positions(&self) -> &[Vector3<f32>] {
        &self.positions
    }

    /// Unit normals, one a vertex.
    #[inline]
    pub fn normals(&self) -> &[Vector3<f32>] {
        &self.normals
    }

    /// Unit tangents, one a vertex, perpendicular to the normals.
    #[inline]
    pub fn tangents(&self) -> &[Vector3<f32>] {
        &self.tangents
    }

    /// Vertex indices of the triangles.
    #[inline]
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// The corners of a face.
    ///
    /// # Panics
    /// If `face` is out of range.
    #[track_caller]
    #[inline]
    pub fn corners(&self, face: usize) -> [Vector3<f32>; 3] {
        self.faces[face].map(|i| self.positions[i as usize])
    }

    /// The shading frame of a vertex.
    ///
    /// # Panics
    /// If `vertex` is out of range.
    #[track_caller]
    #[inline]
    pub fn local_frame(&self, vertex: usize) -> LocalFrame {
        let (normal, tangent) = (self.normals[vertex], self.tangents[vertex]);
        LocalFrame { tangent, bitangent: normal.cross(&tangent), normal }
    }

    /// The smallest box around the faces, relative to the origin; vertices without a face do not count.
    pub fn bounds(&self) -> Bounds {
        let first = self.corners(0)[0];
        let grow = |b: Bounds, p: Vector3<f32>| Bounds { min: b.min.inf(&p), max: b.max.sup(&p) };
        (0..self.faces.len()).flat_map(|f| self.corners(f)).fold(Bounds { min: first, max: first }, grow)
    }

    /// The area of every face.
    pub fn face_areas(&self) -> Vec<f64> {
        let area = |f| double_area_vector(&self.corners(f).map(|p| p.cast::<f64>())).norm() * 0.5;
        (0..self.faces.len()).map(area).collect()
    }

    /// A third of the area of the faces around every vertex; they sum to the area of the mesh.
    pub fn vertex_areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.positions.len()];
        for (face, area) in self.faces.iter().zip(self.face_areas()) {
            face.iter().for_each(|&i| areas[i as usize] += area / 3.0);
        }
        areas
    }
}

fn check_parts(positions: &[Vector3<f32>], faces: &[[u32; 3]]) -> Result<()> {
    if positions.is_empty() {
        return Err(Error::Empty { what: "mesh vertices" });
    }
    if faces.is_empty() {
        return Err(Error::Empty { what: "mesh faces" });
    }
    if let Some(index) = positions.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
        return Err(Error::NotFinite { what: "mesh position", index });
    }
    let count = positions.len();
    for (at, face) in faces.iter().enumerate() {
        if let Some(&index) = face.iter().find(|&&i| i as usize >= count) {
            return Err(Error::Index { what: "vertex index of mesh face", at, got: index as usize, count });
        }
    }
    Ok(())
}

approx_by_parts!(
    [] Mesh, f32, |m| close [&m.positions, &m.normals, &m.tangents, m.uv.as_deref().unwrap_or_default()]
    same [&m.faces, &m.origin, m.uv.is_some()]
);
