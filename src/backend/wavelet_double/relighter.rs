//! Frames: a sparse light times the transport.

use nalgebra::Vector3;

use super::block::BLOCK;
use super::settings::Settings;
use super::transport::Transport;
use crate::backend::distant::range::{in_range, undo};
use crate::backend::distant::{DistantRelighter, Freedom};
use crate::error::check_length;
use crate::haar::ProjectedLight;
use crate::scene::{Materials, View};
use crate::sphere::{CubeGrid, CubeMap};
use crate::{Error, Result, parallel};

/// Relights a scene from its [`Transport`] under lights that change.
///
/// ```math
/// radiance(v) = Σ_i L_i T_vi                                                              [Ng 2003, eq. 5]
/// ```
///
/// over the few i that the light keeps.
#[derive(Debug, Clone)]
pub struct Relighter<'a> {
    transport: &'a Transport,
    settings: Settings<'a>,
    projected: ProjectedLight,
    light: Vec<(u32, [f32; 4])>,
    /// What the radiance of the vertices is multiplied by: 1, but for lights beyond the range of sums in `f32`.
    factor: f64,
    /// For each piece of the vertices: sums of the rows of a block.
    sums: Vec<Vec<[f32; 4]>>,
}

impl<'a> Relighter<'a> {
    /// A relighter without light.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] for a transport whose cube maps are no power of two a side (none that was baked here),
    /// [`Error::OutOfRange`] for a fraction of terms outside [0, 1].
    pub fn new(transport: &'a Transport, settings: Settings<'a>) -> Result<Self> {
        settings.light_terms.check()?;
        let rows = transport.blocks.iter().map(|block| block.vertex.len()).max().unwrap_or(0);
        Ok(Self {
            transport,
            settings,
            projected: ProjectedLight::new(transport.grid)?,
            light: Vec::new(),
            factor: 1.0,
            // Made one by one: a clone would not keep the reserved room.
            sums: (0..parallel::pieces()).map(|_| Vec::with_capacity(rows)).collect(),
        })
    }

    /// Sets the light: radiance on the transport's grid, of which as many wavelets are kept as the settings say.
    /// Any finite light: the brightest and darkest are scaled by a power of two.
    ///
    /// # Errors
    /// [`Error::Length`] for a light on another grid, [`Error::NotFinite`] for a texel that is NaN or infinite; what
    /// [`Selection`](crate::haar::Selection) refuses. The light from before stays.
    pub fn set_light(&mut self, light: &CubeMap<Vector3<f32>>) -> Result<()> {
        let (light, factor) = in_range(light);
        self.projected.set(&light)?;
        let kept = self.projected.select(self.settings.light_terms, self.settings.weighting)?;
        self.factor = factor;
        self.light.clear();
        for &i in kept[0].indices() {
            let [r, g, b] = self.projected.coefficient(i as usize);
            self.light.push((i, [r, g, b, 0.0]));
        }
        Ok(())
    }

    /// How many wavelets the light has.
    pub fn light_terms(&self) -> usize {
        self.light.len()
    }

    /// The radiance that each vertex sends to the view it was baked for; finite (at most [`f32::MAX`]).
    ///
    /// It is that of the materials that were baked, whatever these are.
    ///
    /// # Errors
    /// [`Error::Length`] unless there is a material for each vertex, [`Error::Baked`] for a view other than the baked
    /// one, if radiance depends on it.
    ///
    /// # Panics
    /// Unless `out` has one value a vertex.
    #[track_caller]
    pub fn relight(&mut self, view: &View, materials: &Materials, out: &mut [Vector3<f32>]) -> Result<()> {
        check_length("radiance of the vertices", self.transport.vertices, out.len());
        materials.check(out.len())?;
        if self.transport.view.as_ref().is_some_and(|baked| baked != view) {
            return Err(Error::Baked { what: "view" });
        }
        let Self { transport, light, factor, sums, .. } = self;
        parallel::with_scratch(out, BLOCK, sums, |first, out, sums| {
            let blocks = &transport.blocks[first / BLOCK..];
            for (block, out) in blocks.iter().zip(out.chunks_mut(BLOCK)) {
                out.fill(Vector3::zeros());
                block.add_radiance(light, sums, out);
                undo(*factor, out);
            }
            Ok(())
        })
    }

    /// Bytes in memory that grow with the number of vertices, beside the transport's: none.
    pub fn bytes(&self) -> usize {
        0
    }
}

impl DistantRelighter for Relighter<'_> {
    fn grid(&self) -> CubeGrid {
        self.transport.grid
    }

    fn vertices(&self) -> usize {
        self.transport.vertices
    }

    fn freedom(&self) -> Freedom {
        Freedom::Light
    }

    fn set_light(&mut self, light: &CubeMap<Vector3<f32>>) -> Result<()> {
        self.set_light(light)
    }

    fn relight(&mut self, view: &View, materials: &Materials, out: &mut [Vector3<f32>]) -> Result<()> {
        self.relight(view, materials, out)
    }

    fn bytes(&self) -> usize {
        self.bytes()
    }
}
