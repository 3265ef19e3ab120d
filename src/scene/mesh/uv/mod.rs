//! Texture coordinates: a vertex's, a corner's, and the tangents that follow from them.

#[cfg(test)]
mod tests;

use std::collections::HashMap;

use nalgebra::{Vector2, Vector3};

use super::Mesh;
use super::normals::{double_area_vector, perpendicular};
use crate::{Error, Result};

impl Mesh {
    /// Texture coordinates (u, v), one a vertex, if the mesh has any.
    ///
    /// u runs to the right and v upwards: (0, 0) is the bottom left corner of an image and (1, 1) its top right one, as
    /// in OBJ and PLY files; readers turn those of glTF, whose v runs downwards, round. An [`Image`] of w × h pixels
    /// has its first row at the top, so that (u, v) lies in the pixel of column ⌊u · w⌋ and row ⌊(1 − v) · h⌋, whose
    /// centre is at u = (column + ½) / w, v = 1 − (row + ½) / h. Coordinates are finite and may lie outside of [0, 1]²;
    /// what they mean there (repeat, mirror, clamp) is the caller's choice.
    ///
    #[cfg_attr(feature = "io", doc = "[`Image`]: crate::io::Image")]
    #[cfg_attr(not(feature = "io"), doc = "[`Image`]: crate#map")]
    #[inline]
    pub fn uv(&self) -> Option<&[Vector2<f32>]> {
        self.uv.as_deref()
    }

    /// The same mesh with given texture coordinates, one a vertex; see [`uv`](Self::uv).
    ///
    /// The tangents stay: [`with_tangents_from_uv`](Self::with_tangents_from_uv) makes new ones.
    ///
    /// # Errors
    /// [`Error::Length`] unless there is one pair a vertex, [`Error::NotFinite`] if one is NaN or infinite.
    pub fn with_uv(mut self, uv: Vec<Vector2<f32>>) -> Result<Self> {
        if uv.len() != self.positions.len() {
            return Err(Error::Length {
                what: "mesh texture coordinates",
                expected: self.positions.len(),
                got: uv.len(),
            });
        }
        if let Some(index) = uv.iter().position(|c| !is_finite(c)) {
            return Err(Error::NotFinite { what: "mesh texture coordinate", index });
        }
        self.uv = Some(uv);
        Ok(self)
    }

    /// The same surface with given texture coordinates, three a face: those of its corners.
    ///
    /// Where the corners at a vertex have different coordinates, as along the seams of a texture, the vertex is split.
    /// The first pair in the order of the faces keeps the vertex; for each other one a copy with the same position,
    /// normal and tangent is appended. Faces keep their order, vertices without a face get (0, 0). Coordinates are
    /// compared as numbers: +0 and −0 are one.
    ///
    /// # Errors
    /// [`Error::Length`] unless there are three pairs a face, [`Error::NotFinite`] if one is NaN or infinite (`index`
    /// is 3 · face + corner), [`Error::OutOfRange`] if more than 2³² − 1 vertices would come out.
    ///
    /// # Example
    /// ```
    /// use haarmonic::{nalgebra::{Vector2, Vector3}, scene::Mesh};
    /// // Two triangles with a common edge that the texture is cut along.
    /// let corners = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]].map(Vector3::from);
    /// let uv = |pairs: [[f32; 2]; 3]| pairs.map(Vector2::from);
    /// let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])?
    ///     .with_corner_uv(&[uv([[0., 0.], [1., 0.], [1., 1.]]), uv([[0., 0.], [0.5, 1.], [0., 1.]])])?;
    /// assert_eq!(mesh.faces(), [[0, 1, 2], [0, 4, 3]]);
    /// assert_eq!(mesh.positions()[4], mesh.positions()[2]);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn with_corner_uv(mut self, corners: &[[Vector2<f32>; 3]]) -> Result<Self> {
        if corners.len() != self.faces.len() {
            return Err(Error::Length {
                what: "texture coordinates of mesh faces",
                expected: self.faces.len(),
                got: corners.len(),
            });
        }
        if let Some(index) = corners.as_flattened().iter().position(|c| !is_finite(c)) {
            return Err(Error::NotFinite { what: "texture coordinate of a mesh corner", index });
        }
        let mut uv: Vec<Option<Vector2<f32>>> = vec![None; self.positions.len()];
        let mut copies = HashMap::new();
        for (vertex, pair) in self.faces.as_flattened_mut().iter_mut().zip(corners.as_flattened()) {
            let source = *vertex as usize;
            if uv[source].get_or_insert(*pair) == pair {
                continue;
            }
            let next = self.positions.len();
            *vertex = *copies.entry((*vertex, [pair.x, pair.y].map(|c| (c + 0.0).to_bits()))).or_insert(next as u32);
            if *vertex as usize != next {
                continue;
            }
            if next >= u32::MAX as usize {
                return Err(Error::OutOfRange {
                    what: "vertices of a mesh split by its texture coordinates",
                    got: (next + 1) as f64,
                    allowed: "below 2^32",
                });
            }
            self.positions.push(self.positions[source]);
            self.normals.push(self.normals[source]);
            self.tangents.push(self.tangents[source]);
            uv.push(Some(*pair));
        }
        self.uv = Some(uv.into_iter().map(Option::unwrap_or_default).collect());
        Ok(self)
    }

    /// The same mesh with tangents along +u: those that a tangent-space normal map or brushed metal in texture
    /// coordinates refers to.
    ///
    /// On a face the position p is a linear function of (u, v). The tangent of a vertex is the mean of the directions
    /// of ∂p/∂u of the faces around it, each first made perpendicular to the vertex's normal, weighted by the face's
    /// angle at the vertex. A face counts for nothing if its texture coordinates have no area, or no more than the
    /// rounding of `f32` could give them. Where nothing counts, or the directions cancel (to 1e-6), the tangent is
    /// arbitrary but deterministic, as in [`new`](Self::new).
    ///
    /// A [`LocalFrame`](super::LocalFrame) is right-handed: its bitangent is always normal × tangent. It runs along +v
    /// where the texture is not mirrored and along −v where it is; [`uv_handedness`](Self::uv_handedness) tells which.
    /// A vertex on the line where a texture is mirrored in u has faces with opposite directions; give the two sides
    /// vertices of their own if the tangent matters there.
    ///
    /// # Errors
    /// [`Error::Empty`] if the mesh has no texture coordinates.
    ///
    /// # Example
    /// ```
    /// use haarmonic::{nalgebra::{Vector2, Vector3}, scene::Mesh};
    /// let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]].map(Vector3::from);
    /// // u grows along +y here, v along −x.
    /// let uv = vec![Vector2::new(0., 1.), Vector2::new(0., 0.), Vector2::new(1., 1.)];
    /// let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2]])?.with_uv(uv)?.with_tangents_from_uv()?;
    /// assert_eq!(mesh.tangents()[0], Vector3::y());
    /// assert_eq!(mesh.local_frame(0).bitangent, -Vector3::x());
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn with_tangents_from_uv(mut self) -> Result<Self> {
        let uv = self.uv.as_deref().ok_or(Error::Empty { what: "texture coordinates of a mesh" })?;
        let mut sums = vec![(Vector3::<f64>::zeros(), 0.0); self.positions.len()];
        self.each_textured_corner(uv, |vertex, angle, face| {
            let normal = self.normals[vertex].cast::<f64>();
            let along = face.along_u - normal * normal.dot(&face.along_u);
            // What is left of a direction along the normal is rounding.
            if let Some(direction) = along.try_normalize(1e-6) {
                sums[vertex].0 += direction * angle;
                sums[vertex].1 += angle;
            }
        });
        self.tangents = (sums.into_iter().zip(&self.normals))
            .map(|((sum, angle), n)| {
                let normal = n.cast::<f64>();
                let tangent = (sum - normal * normal.dot(&sum)).try_normalize(1e-6 * angle);
                tangent.map_or_else(|| perpendicular(n), |t| t.cast())
            })
            .collect();
        Ok(self)
    }

    /// One a vertex, if the mesh has texture coordinates: 1 where (u, v), seen against the normal, turn
    /// counter-clockwise, as an image on the surface does, and −1 where the image is mirrored.
    ///
    /// With the tangents of [`with_tangents_from_uv`](Self::with_tangents_from_uv) the direction of +v is handedness ·
    /// bitangent. A normal (x, y, z) of a tangent-space map whose y points along +v becomes x · tangent +
    /// handedness · y · bitangent + z · normal. It is the number that glTF calls `TANGENT.w`. Where faces disagree, the
    /// larger sum of their angles decides; where nothing does, as without area, it is 1.
    pub fn uv_handedness(&self) -> Option<Vec<f32>> {
        let mut sums = vec![0.0; self.positions.len()];
        self.each_textured_corner(self.uv.as_deref()?, |vertex, angle, face| {
            let faces_out = face.normal.dot(&self.normals[vertex].cast()).signum();
            sums[vertex] += angle * faces_out * face.turn;
        });
        Some(sums.into_iter().map(|sum| if sum < 0.0 { -1.0 } else { 1.0 }).collect())
    }

    /// Visits the corners of the faces that have area in space and in texture coordinates: vertex, angle, face.
    fn each_textured_corner(&self, uv: &[Vector2<f32>], mut visit: impl FnMut(usize, f64, &TexturedFace)) {
        for face in &self.faces {
            let corners = face.map(|i| self.positions[i as usize].cast::<f64>());
            let Some(textured) = TexturedFace::new(&corners, &face.map(|i| uv[i as usize].cast())) else { continue };
            for k in 0..3 {
                let to = |j: usize| corners[(k + j) % 3] - corners[k];
                visit(face[k] as usize, to(1).angle(&to(2)), &textured);
            }
        }
    }
}

/// How a face lies in texture coordinates.
struct TexturedFace {
    /// The unit vector along ∂p/∂u.
    along_u: Vector3<f64>,
    /// The unit normal.
    normal: Vector3<f64>,
    /// 1 if its corners are counter-clockwise in (u, v) too, else −1.
    turn: f64,
}

impl TexturedFace {
    /// None without area in space or in (u, v).
    fn new(corners: &[Vector3<f64>; 3], uv: &[Vector2<f64>; 3]) -> Option<Self> {
        let (p, q) = (corners[1] - corners[0], corners[2] - corners[0]);
        let (a, b) = (uv[1] - uv[0], uv[2] - uv[0]);
        let area = a.x * b.y - a.y * b.x;
        // A coordinate c is rounded by up to |c| · ε / 2, a difference of two by twice that.
        let step = |axis: usize| f64::from(f32::EPSILON) * uv.iter().map(|c| c[axis].abs()).fold(0.0, f64::max);
        let rounding = step(0) * (a.y.abs() + b.y.abs()) + step(1) * (a.x.abs() + b.x.abs());
        if !(area.abs() > rounding) {
            return None;
        }
        // p = a.x ∂p/∂u + a.y ∂p/∂v, q = b.x ∂p/∂u + b.y ∂p/∂v, solved for ∂p/∂u but for the factor 1 / |area|.
        let along_u = (p * b.y - q * a.y) * area.signum();
        Some(Self {
            along_u: along_u.try_normalize(0.0)?,
            normal: double_area_vector(corners).try_normalize(0.0)?,
            turn: area.signum(),
        })
    }
}

fn is_finite(uv: &Vector2<f32>) -> bool {
    uv.iter().all(|c| c.is_finite())
}
