//! Triangle meshes with per-vertex shading frames.

use nalgebra::{Affine3, UnitVector3, Vector3};

use crate::approx_eq::approx_by_parts;
use crate::{Error, Result};

/// An orthonormal right-handed frame: x = tangent, y = bitangent, z = normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Local +x.
    pub tangent: Vector3<f32>,
    /// Local +y, normal × tangent.
    pub bitangent: Vector3<f32>,
    /// Local +z.
    pub normal: Vector3<f32>,
}

impl Frame {
    /// A frame around a normal; its tangent is arbitrary but deterministic.
    pub fn around(normal: &UnitVector3<f64>) -> Self {
        let normal = normal.cast::<f32>().into_inner();
        let tangent = perpendicular(&normal);
        Self { tangent, bitangent: normal.cross(&tangent), normal }
    }

    /// World to local coordinates, in `f64`.
    #[inline]
    pub fn to_local(&self, world: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(
            self.tangent.cast::<f64>().dot(world),
            self.bitangent.cast::<f64>().dot(world),
            self.normal.cast::<f64>().dot(world),
        )
    }

    /// Local to world coordinates, in `f64`.
    #[inline]
    pub fn to_world(&self, local: &Vector3<f64>) -> Vector3<f64> {
        self.tangent.cast::<f64>() * local.x
            + self.bitangent.cast::<f64>() * local.y
            + self.normal.cast::<f64>() * local.z
    }
}

/// A triangle mesh: positions, unit normals and unit tangents per vertex; counter-clockwise faces seen from outside.
///
/// Every position is finite, every normal and tangent is a unit vector and they are perpendicular, every face names three
/// vertices that are there. Vertices without a face are allowed; so are faces without area, which neither cast nor
/// receive anything ([`repair`](Self::repair) drops them).
///
/// Positions are relative to the mesh's [`origin`](Self::origin), in world coordinates and `f64`; it is zero unless
/// [`with_origin`](Self::with_origin) says otherwise. Distant light, visibility and everything else that is computed
/// from one mesh uses the positions alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    positions: Vec<Vector3<f32>>,
    normals: Vec<Vector3<f32>>,
    tangents: Vec<Vector3<f32>>,
    faces: Vec<[u32; 3]>,
    origin: Vector3<f64>,
}

/// What [`Mesh::repair`] changed, one note for each kind of defect.
///
/// `first` is the index of the first one in the input: a face's, or a vertex's for positions and normals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshRepair {
    /// Faces that name a vertex twice or have no area were dropped.
    DegenerateFaces {
        /// How many.
        count: usize,
        /// The first one.
        first: usize,
    },
    /// Faces that name a vertex that is not there were dropped.
    OutOfRangeFaces {
        /// How many.
        count: usize,
        /// The first one.
        first: usize,
    },
    /// Vertices whose position is NaN or infinite lost their faces; they now stand on the first finite vertex.
    NonFinitePositions {
        /// How many.
        count: usize,
        /// The first one.
        first: usize,
    },
    /// Normals that are NaN, infinite or zero, or that were missing, were made from the faces.
    Normals {
        /// How many.
        count: usize,
        /// The first one.
        first: usize,
    },
}

impl std::fmt::Display for MeshRepair {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::DegenerateFaces { count, first } => {
                write!(f, "{count} faces without area dropped (the first is number {first})")
            }
            Self::OutOfRangeFaces { count, first } => {
                write!(f, "{count} faces with a vertex that is not there dropped (the first is number {first})")
            }
            Self::NonFinitePositions { count, first } => {
                write!(f, "{count} vertices that are NaN or infinite lost their faces (the first is number {first})")
            }
            Self::Normals { count, first } => {
                write!(f, "{count} normals made from the faces (the first is number {first})")
            }
        }
    }
}

/// The smallest axis-aligned box around something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates.
    pub min: Vector3<f32>,
    /// Largest coordinates.
    pub max: Vector3<f32>,
}

impl Bounds {
    /// The centre of the box.
    pub fn centre(&self) -> Vector3<f64> {
        (self.min.cast::<f64>() + self.max.cast::<f64>()) * 0.5
    }

    /// The edge lengths of the box.
    pub fn size(&self) -> Vector3<f64> {
        self.max.cast::<f64>() - self.min.cast::<f64>()
    }

    /// Half of the box's diagonal: the radius of the ball around [`centre`](Self::centre) that holds it.
    pub fn radius(&self) -> f64 {
        self.size().norm() * 0.5
    }
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
        Ok(Self { positions, normals, tangents, faces, origin: Vector3::zeros() })
    }

    /// A mesh with given normals.
    ///
    /// Normals are scaled to unit length; one that is zero, NaN or infinite is replaced by the angle-weighted mean of the
    /// faces around its vertex, as in [`new`](Self::new).
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
        Ok(Self { positions, normals, tangents, faces, origin: Vector3::zeros() })
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

    /// A mesh from parts that may be broken, and what had to be mended.
    ///
    /// For file readers. In this order: a face that names a vertex that is not there is dropped; a face with a corner that
    /// is NaN or infinite is dropped, and the vertex, which stays so that indices keep their meaning, is moved to the first
    /// finite one; a face with a repeated corner or without area is dropped; a normal that is missing or unusable is made
    /// from the faces that are left. Vertices without a face are kept. Nothing else is touched: no welding, no turning.
    /// `normals` shorter or longer than `positions` counts as missing or superfluous at the end.
    ///
    /// # Errors
    /// [`Error::Empty`] if no vertex is finite or no face is left.
    ///
    /// # Example
    /// ```
    /// use haarmonic::{nalgebra::Vector3, scene::{Mesh, MeshRepair}};
    /// let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [f32::NAN, 0., 0.]].map(Vector3::from);
    /// let faces = vec![[0, 1, 2], [0, 1, 1], [0, 1, 9], [1, 2, 3]];
    /// let (mesh, notes) = Mesh::repair(corners.to_vec(), None, faces)?;
    /// assert_eq!(mesh.faces(), [[0, 1, 2]]);
    /// assert!(notes.contains(&MeshRepair::DegenerateFaces { count: 1, first: 1 }));
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn repair(
        mut positions: Vec<Vector3<f32>>,
        normals: Option<Vec<Vector3<f32>>>,
        faces: Vec<[u32; 3]>,
    ) -> Result<(Self, Vec<MeshRepair>)> {
        let finite = |p: &Vector3<f32>| p.iter().all(|c| c.is_finite());
        let (mut out_of_range, mut degenerate, mut unusable) = (Tally::default(), Tally::default(), Tally::default());
        let mut kept = Vec::with_capacity(faces.len());
        for (index, face) in faces.into_iter().enumerate() {
            if face.iter().any(|&i| i as usize >= positions.len()) {
                out_of_range.add(index);
            } else if face.iter().all(|&i| finite(&positions[i as usize])) {
                let corners = face.map(|i| positions[i as usize].cast::<f64>());
                if double_area_vector(&corners).norm() > 0.0 {
                    kept.push(face);
                } else {
                    degenerate.add(index);
                }
            }
        }
        let Some(stand_in) = positions.iter().copied().find(finite) else {
            return Err(Error::Empty { what: "mesh vertices that are finite" });
        };
        for (index, position) in positions.iter_mut().enumerate() {
            if !finite(position) {
                unusable.add(index);
                *position = stand_in;
            }
        }
        if kept.is_empty() {
            return Err(Error::Empty { what: "mesh faces that have an area and are in range" });
        }
        let mut made = Tally::default();
        let mesh = match normals {
            None => Self::new(positions, kept)?,
            Some(mut normals) => {
                normals.resize(positions.len(), Vector3::zeros());
                normals.iter().enumerate().filter(|(_, n)| unit(n).is_none()).for_each(|(i, _)| made.add(i));
                Self::with_normals(positions, normals, kept)?
            }
        };
        let notes = [
            out_of_range.note(|count, first| MeshRepair::OutOfRangeFaces { count, first }),
            unusable.note(|count, first| MeshRepair::NonFinitePositions { count, first }),
            degenerate.note(|count, first| MeshRepair::DegenerateFaces { count, first }),
            made.note(|count, first| MeshRepair::Normals { count, first }),
        ];
        Ok((mesh, notes.into_iter().flatten().collect()))
    }

    /// Several meshes as one: their vertices and faces in the order given.
    ///
    /// The origin is that of the first mesh; the positions of a mesh with another one are moved, in `f64`, so that the
    /// world coordinates stay.
    ///
    /// # Errors
    /// [`Error::Empty`] without a mesh, [`Error::OutOfRange`] for more than 2³² − 1 vertices, [`Error::NotFinite`] if a
    /// position is beyond `f32` seen from the first mesh's origin.
    pub fn merge<'a>(meshes: impl IntoIterator<Item = &'a Self>) -> Result<Self> {
        let origin = Vector3::zeros();
        let mut all = Self { positions: vec![], normals: vec![], tangents: vec![], faces: vec![], origin };
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
            all.faces.extend(mesh.faces.iter().map(|f| f.map(|i| i + base as u32)));
        }
        if all.faces.is_empty() { Err(Error::Empty { what: "list of meshes" }) } else { Ok(all) }
    }

    /// The mesh moved, turned, scaled or sheared.
    ///
    /// Normals go with the inverse transpose, tangents with the map; a mirroring map turns the faces around, so that they
    /// stay counter-clockwise seen from outside. The map acts on the positions; the [`origin`](Self::origin) stays.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if the map's determinant is zero or not finite, [`Error::NotFinite`] if a vertex overflows.
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
        Self::with_normals(positions, normals.collect(), faces)?.with_tangents(tangents)?.with_origin(self.origin)
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
    pub fn frame(&self, vertex: usize) -> Frame {
        let (normal, tangent) = (self.normals[vertex], self.tangents[vertex]);
        Frame { tangent, bitangent: normal.cross(&tangent), normal }
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

/// How many defects of one kind, and where the first one is.
#[derive(Default)]
struct Tally {
    count: usize,
    first: usize,
}

impl Tally {
    fn add(&mut self, index: usize) {
        if self.count == 0 {
            self.first = index;
        }
        self.count += 1;
    }

    fn note(&self, note: impl Fn(usize, usize) -> MeshRepair) -> Option<MeshRepair> {
        (self.count > 0).then(|| note(self.count, self.first))
    }
}

approx_by_parts!([] Frame, f32, |f| close [[f.tangent, f.bitangent, f.normal]] same []);
approx_by_parts!([] Bounds, f32, |b| close [[b.min, b.max]] same []);
approx_by_parts!([] Mesh, f32, |m| close [&m.positions, &m.normals, &m.tangents] same [&m.faces, &m.origin]);

/// Twice the area of a triangle, along its normal.
fn double_area_vector([a, b, c]: &[Vector3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// The unit vector along `v`, unless that is zero or not finite.
fn unit(v: &Vector3<f32>) -> Option<Vector3<f32>> {
    let v = v.cast::<f64>();
    let length = v.norm();
    (length > 0.0 && length.is_finite()).then(|| (v / length).cast())
}

fn angle_weighted_normals(positions: &[Vector3<f32>], faces: &[[u32; 3]]) -> Vec<Vector3<f32>> {
    let mut sums = vec![Vector3::<f64>::zeros(); positions.len()];
    for face in faces {
        let corners = face.map(|i| positions[i as usize].cast::<f64>());
        let Some(normal) = double_area_vector(&corners).try_normalize(0.0) else {
            continue;
        };
        for k in 0..3 {
            let to = |j: usize| corners[(k + j) % 3] - corners[k];
            sums[face[k] as usize] += normal * to(1).angle(&to(2));
        }
    }
    sums.iter().map(|s| s.try_normalize(1e-30).unwrap_or_else(Vector3::y).cast()).collect()
}

/// A unit vector perpendicular to a unit vector.
fn perpendicular(n: &Vector3<f32>) -> Vector3<f32> {
    let axis = if n.x.abs() < 0.8 { Vector3::x() } else { Vector3::z() };
    (axis - n * n.dot(&axis)).normalize()
}
