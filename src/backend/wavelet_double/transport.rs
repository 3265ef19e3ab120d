//! The transport of a static scene in wavelets.

use super::bake::Baker;
use super::block::{BLOCK, Block};
use super::settings::BakeSettings;
use crate::backend::distant::check_vertices;
use crate::haar::{Decomposition, Transform2d};
use crate::parallel::{self, Watch};
use crate::scene::{BinaryVisibility, DirectionTable, Materials, Mesh, View};
use crate::sphere::CubeGrid;
use crate::{Error, Progress, Result};

/// The transport of a static scene seen from one view (from any view, if the materials do not depend on it): visibility
/// × brdf_cos of every vertex in the nonstandard Haar basis of each cube-map face, sparse, by wavelet.
///
/// ```math
/// radiance(v) = Σ_i L_i T_vi                                                              [Ng 2003, eq. 5]
/// ```
///
/// with L the light's coefficients (texels weighted by side² × solid angle). The matrix is stored in blocks of 256
/// vertices, each by column, so that a light of few terms reads only its own columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Transport {
    pub(super) grid: CubeGrid,
    pub(super) vertices: usize,
    /// What was baked; none if the materials do not depend on it.
    pub(super) view: Option<View>,
    pub(super) blocks: Vec<Block>,
}

/// What a [`Transport`] holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct TransportStats {
    /// Vertices.
    pub vertices: usize,
    /// Coefficients that are stored, of all vertices.
    pub coefficients: usize,
    /// Bytes in memory.
    pub bytes: usize,
}

impl Transport {
    /// Computes the transport of every vertex: visibility × brdf_cos at every texel, transformed and thinned.
    ///
    /// Shapes: `visibility` has one map a mesh vertex, `materials` one material a vertex. `progress` counts vertices.
    /// The same bits for any number of threads. Cost: one BRDF slice and one Haar transform a vertex.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] for a cube map whose side is none, [`Error::Length`] if mesh, visibility and materials
    /// disagree about the number of vertices, [`Error::OutOfRange`] for a tolerance outside [0, 1),
    /// [`Error::NotFinite`] for a BRDF whose value for one of the texels is NaN or infinite in `f32` (the index is the
    /// BRDF's), [`Error::Cancelled`].
    pub fn bake(
        mesh: &Mesh,
        visibility: &BinaryVisibility,
        view: &View,
        materials: &Materials,
        settings: BakeSettings,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let (grid, vertices) = (visibility.grid(), mesh.positions().len());
        check_vertices("visibility maps", vertices, visibility.vertices())?;
        materials.check(vertices)?;
        if !(0.0..1.0).contains(&settings.tolerance) {
            let got = f64::from(settings.tolerance);
            return Err(Error::OutOfRange { what: "tolerance of the transport", got, allowed: "in [0, 1)" });
        }
        let directions = DirectionTable::new(grid);
        let transform = Transform2d::new(grid.side(), grid.side(), Decomposition::Nonstandard)?;
        let baker = Baker { mesh, visibility, materials, view, settings, directions, transform };
        let watch = Watch::new(progress, vertices);
        let blocks = parallel::try_map(
            vertices.div_ceil(BLOCK),
            || (),
            |k, ()| {
                watch.check()?;
                let (first, end) = (k * BLOCK, (k * BLOCK + BLOCK).min(vertices));
                let block = baker.block(first, end)?;
                watch.advance(end - first);
                Ok(block)
            },
        )?;
        let depends = materials.brdfs().iter().any(|brdf| !brdf.is_view_independent());
        Ok(Self { grid, vertices, view: depends.then_some(*view), blocks })
    }

    /// The grid of the cube maps.
    pub fn grid(&self) -> CubeGrid {
        self.grid
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// The view that was baked; none if the materials do not depend on it.
    pub fn view(&self) -> Option<&View> {
        self.view.as_ref()
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        self.blocks.iter().map(Block::bytes).sum()
    }

    /// Counts and sizes.
    pub fn stats(&self) -> TransportStats {
        let coefficients = self.blocks.iter().map(Block::nnz).sum();
        TransportStats { vertices: self.vertices, coefficients, bytes: self.bytes() }
    }
}
