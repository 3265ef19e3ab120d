//! Triangle meshes with per-vertex shading frames.

use nalgebra::Vector3;

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
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    positions: Vec<Vector3<f32>>,
    normals: Vec<Vector3<f32>>,
    tangents: Vec<Vector3<f32>>,
    faces: Vec<[u32; 3]>,
}

impl Mesh {
    /// A mesh whose normals are the angle-weighted means of the faces around a vertex.
    ///
    /// A vertex without a face of positive area gets the normal +y. Tangents are perpendicular to the normals and
    /// otherwise arbitrary but deterministic.
    ///
    /// # Errors
    /// [`Error::Empty`] without vertices or faces, [`Error::NotFinite`] for a position that is not finite,
    /// [`Error::OutOfRange`] for a face that names a vertex that is not there.
    pub fn new(positions: Vec<Vector3<f32>>, faces: Vec<[u32; 3]>) -> Result<Self> {
        if positions.is_empty() {
            return Err(Error::Empty { what: "mesh vertices" });
        }
        if faces.is_empty() {
            return Err(Error::Empty { what: "mesh faces" });
        }
        if let Some(index) = positions.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            return Err(Error::NotFinite { what: "mesh position", index });
        }
        if let Some(&bad) = faces.iter().flatten().find(|&&i| i as usize >= positions.len()) {
            return Err(Error::OutOfRange {
                what: "vertex index of a face",
                got: f64::from(bad),
                allowed: "below the number of vertices",
            });
        }
        let normals = angle_weighted_normals(&positions, &faces);
        let tangents = normals.iter().map(perpendicular).collect();
        Ok(Self { positions, normals, tangents, faces })
    }

    /// Positions, one a vertex.
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

    /// The shading frame of a vertex.
    ///
    /// # Panics
    /// If `vertex` is out of range.
    #[inline]
    pub fn frame(&self, vertex: usize) -> Frame {
        let (normal, tangent) = (self.normals[vertex], self.tangents[vertex]);
        Frame { tangent, bitangent: normal.cross(&tangent), normal }
    }
}

fn angle_weighted_normals(positions: &[Vector3<f32>], faces: &[[u32; 3]]) -> Vec<Vector3<f32>> {
    let mut sums = vec![Vector3::<f64>::zeros(); positions.len()];
    for face in faces {
        let corners = face.map(|i| positions[i as usize].cast::<f64>());
        let Some(normal) = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).try_normalize(0.0) else {
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
