//! What a user chooses.

use crate::haar::{Keep, Weighting};

/// Where a vertex's BRDF slice comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Slices {
    /// Sampled for each vertex, in each frame: exact normals and views.
    #[default]
    Sampled,
    /// From a table of slices at the texel centres of a cube map of normals (and, for view-dependent materials, one of
    /// views) of this side, filled on first use. Faster from the second frame on; the nearest slice is off by up to
    /// half a texel: 1.4° at side 32, 2.8° at 16. A slice takes up to 12 side² × 6 bytes of the *visibility's* side:
    /// mind side 32 with views.
    Tabulated(usize),
}

/// What a [`Relighter`](super::Relighter) keeps of light and BRDF.
#[derive(Debug, Clone, Copy)]
pub struct Settings<'a> {
    /// Wavelets of the light, over all faces, the same for R, G and B.
    pub light_terms: Keep,
    /// Wavelets of each BRDF slice, over all faces.
    pub brdf_terms: Keep,
    /// What ranks the wavelets of both.
    pub weighting: Weighting<'a, f32>,
    /// Where slices come from.
    pub slices: Slices,
}

impl Default for Settings<'_> {
    fn default() -> Self {
        let terms = Keep::Fraction(0.01);
        Self { light_terms: terms, brdf_terms: terms, weighting: Weighting::default(), slices: Slices::default() }
    }
}
