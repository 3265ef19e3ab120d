//! What a user chooses.

use crate::haar::{Keep, Weighting};

/// How a transport's coefficients are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// 32-bit floats: 6 bytes a coefficient with its row.
    Full,
    /// 16-bit integers with one scale a vertex: 4 bytes; the step is 1/32767 of the vertex's largest coefficient.
    #[default]
    Bits16,
    /// 8-bit integers with one scale a vertex, as the paper stores them: 3 bytes; the step is 1/127 of the largest.
    Bits8,
}

/// How [`Transport::bake`](super::Transport::bake) stores what it computes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BakeSettings {
    /// The smallest coefficients of a vertex are dropped as long as the relative L2 error of its transport stays below
    /// this; 0 keeps every non-zero. Too large loses shadows' edges, too small stores noise: each halving costs about
    /// 1.5 × the memory.
    pub tolerance: f32,
    /// How the rest is stored.
    pub precision: Precision,
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self { tolerance: 0.01, precision: Precision::default() }
    }
}

/// What a [`Relighter`](super::Relighter) keeps of a light.
#[derive(Debug, Clone, Copy)]
pub struct Settings<'a> {
    /// Wavelets of the light, over all faces, the same for R, G and B.
    pub light_terms: Keep,
    /// What ranks them.
    pub weighting: Weighting<'a, f32>,
}

impl Default for Settings<'_> {
    fn default() -> Self {
        Self { light_terms: Keep::Fraction(0.01), weighting: Weighting::default() }
    }
}
