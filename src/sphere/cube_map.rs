//! A function of direction, held on the texels of a cube.

use nalgebra::{UnitVector3, Vector3};

use super::{CubeGrid, Face, Texel};
use crate::{Error, Result};

/// A function of direction sampled on a [`CubeGrid`].
#[derive(Debug, Clone, PartialEq)]
pub struct CubeMap<P> {
    grid: CubeGrid,
    texels: Vec<P>,
}

impl<P: Texel> CubeMap<P> {
    /// A map of `texels` in the grid's storage order.
    ///
    /// # Errors
    /// [`Error::Length`] unless there is one value a texel.
    pub fn new(grid: CubeGrid, texels: Vec<P>) -> Result<Self> {
        if texels.len() != grid.len() {
            return Err(Error::Length { what: "cube map texels", expected: grid.len(), got: texels.len() });
        }
        Ok(Self { grid, texels })
    }

    /// A map that samples `f` at every texel's centre.
    pub fn from_fn(grid: CubeGrid, mut f: impl FnMut(UnitVector3<f64>) -> P) -> Self {
        Self { grid, texels: (0..grid.len()).map(|i| f(grid.direction(i))).collect() }
    }

    /// The grid.
    #[inline]
    pub fn grid(&self) -> CubeGrid {
        self.grid
    }

    /// All texels, face after face.
    #[inline]
    pub fn texels(&self) -> &[P] {
        &self.texels
    }

    /// All texels, to write.
    #[inline]
    pub fn texels_mut(&mut self) -> &mut [P] {
        &mut self.texels
    }

    /// The texels of one face, row after row.
    #[inline]
    pub fn face(&self, face: Face) -> &[P] {
        let n = self.grid.face_len();
        &self.texels[face as usize * n..][..n]
    }

    /// The texel that a direction falls into.
    #[inline]
    pub fn nearest(&self, direction: &Vector3<f64>) -> P {
        self.texels[self.grid.nearest(direction)]
    }

    /// ∫ map dω over the sphere: exact for the piecewise-constant function.
    pub fn integral(&self) -> P::Wide {
        let omega = self.grid.face_solid_angles();
        self.texels
            .iter()
            .enumerate()
            .fold(num_traits::Zero::zero(), |sum: P::Wide, (i, t)| sum + t.widen() * omega[i % omega.len()])
    }
}
