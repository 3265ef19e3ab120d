//! Meshes from parts that may be broken.

use nalgebra::Vector3;

use super::Mesh;
use super::normals::{double_area_vector, unit};
use crate::{Error, Result};

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

impl Mesh {
    /// A mesh from parts that may be broken, and what had to be mended.
    ///
    /// For file readers. In this order: a face that names a vertex that is not there is dropped; a face with a corner
    /// that is NaN or infinite is dropped, and the vertex, which stays so that indices keep their meaning, is moved to
    /// the first finite one; a face with a repeated corner or without area is dropped; a normal that is missing or
    /// unusable is made from the faces that are left. Vertices without a face are kept. Nothing else is touched: no
    /// welding, no turning. Texture coordinates can be given afterwards, since vertices keep their places:
    /// [`with_uv`](Self::with_uv). `normals` shorter or longer than `positions` counts as missing or superfluous at the
    /// end.
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
