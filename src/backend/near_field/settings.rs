//! What a user chooses.

use crate::affine::Heuristic;
use crate::haar::Keep;
use crate::nalgebra::Vector3;
use crate::scene::LocalFrame;

/// How a transport's coefficients are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// 32-bit floats: 6 bytes a coefficient with its index.
    Full,
    /// 16-bit integers with one scale a row: 4 bytes; the step is 1/32767 of the row's largest coefficient, which for a
    /// few hundred coefficients is a smaller error than that of 16-bit floats.
    #[default]
    Bits16,
}

/// How [`Transport::bake`](super::Transport::bake) looks at a scene, and stores what it computes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BakeSettings {
    /// The axes of all top faces: the normal points to the lights' plane, across which lights then move freely, and
    /// whose height is free too.
    pub frame: LocalFrame,
    /// The edge of the top face at distance 1: 2 is that of a cube map. Larger sees more of the light that comes from
    /// the side, 3 or 4 is enough for most scenes; the same cells are coarser then. See
    /// [`TopFace`](crate::sphere::TopFace).
    pub face_size: f64,
    /// Cells along an edge, and wavelets an axis: a power of two, at most 256.
    pub cells: usize,
    /// Rays along an edge of a cell. With 1, a cell is seen or not; with more, visibility and reflectance are averaged
    /// over the cell's parts, and shadows become as smooth as the light.
    pub samples: usize,
    /// How far off its vertex a ray starts: that of
    /// [`VisibilitySettings`](crate::scene::VisibilitySettings::offset).
    pub offset: f64,
    /// The smallest coefficients of a row are dropped as long as the relative L2 error of its transport stays below
    /// this; 0 keeps every non-zero.
    pub tolerance: f32,
    /// How the rest is stored.
    pub precision: Precision,
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self {
            frame: upwards(),
            face_size: 4.0,
            cells: 32,
            samples: 2,
            offset: crate::scene::VisibilitySettings::default().offset,
            tolerance: 0.01,
            precision: Precision::default(),
        }
    }
}

/// Columns along +x, rows along −z, the light above.
fn upwards() -> LocalFrame {
    LocalFrame { tangent: Vector3::x(), bitangent: -Vector3::z(), normal: Vector3::y() }
}

/// Into how many products a BRDF is taken apart for a transport whose view stays free: see
/// [`FactoredBrdf`](crate::scene::FactoredBrdf).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ViewFactors {
    /// Cells of the hemisphere, along an edge, of light and of view.
    pub cells: usize,
    /// Products: rows of a vertex, three times as many for a BRDF without a colour.
    pub terms: usize,
}

impl Default for ViewFactors {
    fn default() -> Self {
        Self { cells: 16, terms: 8 }
    }
}

/// What ranks the wavelets of a light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ranking {
    /// |F_i|, as the thesis does: the least error of the texture.
    Magnitude,
    /// |F_i| ∫|Ψ_i|: leans to coarse wavelets, which move integrals more than fine ones of the same magnitude.
    #[default]
    Integral,
}

/// How frames are computed. All but two give the same numbers to rounding.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Route {
    /// For each light the one that measured costs say is the cheapest of those that are exact.
    #[default]
    Automatic,
    /// The light's wavelets are carried to the vertex by couplings that are computed on the way: for lights of few
    /// terms.
    Couplings,
    /// The same with couplings looked up in a table of maps: the thesis' memory-based approach. Approximate: each
    /// vertex takes the nearest of 256 scales and 256 offsets.
    StoredCouplings,
    /// The same with couplings made of a 256² table of the canonical M: the thesis' computational approach.
    /// Approximate to that table's steps.
    CanonicalTable,
    /// Wavelets of the light at the vertex by look-ups in a summed-area table of the texture: for few targets.
    SummedArea,
    /// Transport and light meet in pixels, by exact areas; the chosen targets do not matter, all are used. Its cost
    /// does not depend on the light's terms.
    Pixels,
}

impl Route {
    /// All routes.
    pub const ALL: [Self; 6] =
        [Self::Automatic, Self::Couplings, Self::StoredCouplings, Self::CanonicalTable, Self::SummedArea, Self::Pixels];

    /// A name for command lines and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Automatic => "automatic",
            Self::Couplings => "couplings",
            Self::StoredCouplings => "stored-couplings",
            Self::CanonicalTable => "canonical-table",
            Self::SummedArea => "summed-area",
            Self::Pixels => "pixels",
        }
    }

    /// The route of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|route| route.name() == name)
    }
}

/// Which coefficients of the light are computed at each vertex.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum TargetSelection<'a> {
    /// All of them: often cheaper than to choose.
    All,
    /// Those of which the vertex has a coefficient of transport: nothing is lost.
    #[default]
    Transport,
    /// Those that a [`Prediction`](crate::affine::Prediction) expects to matter, from the place of the vertex under the
    /// light [Sun 2008, eq. 4.38].
    Predicted {
        /// What is assumed of the light.
        heuristic: Heuristic<'a>,
        /// How many targets are predicted.
        keep: Keep,
        /// Neighbouring places whose predictions are taken too, to each side.
        union: usize,
        /// Maps an axis over which a prediction is averaged.
        samples: usize,
    },
}

impl TargetSelection<'_> {
    /// The thesis' choice: a constant light, and the union with the next places, without which it comes to a tenth of
    /// the targets at most.
    pub const fn constant_light(keep: Keep) -> Self {
        Self::Predicted { heuristic: Heuristic::Constant, keep, union: 1, samples: 1 }
    }
}

/// How a [`Relighter`](super::Relighter) works.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings<'a> {
    /// Wavelets an axis of a light: a power of two, at most 256.
    pub source_side: usize,
    /// How many of its wavelets a light keeps.
    pub source_terms: Keep,
    /// Which.
    pub ranking: Ranking,
    /// Which wavelets are computed at a vertex.
    pub targets: TargetSelection<'a>,
    /// How.
    pub route: Route,
}

impl Default for Settings<'_> {
    fn default() -> Self {
        Self {
            source_side: 32,
            source_terms: Keep::Fraction(1.0),
            ranking: Ranking::default(),
            targets: TargetSelection::default(),
            route: Route::default(),
        }
    }
}
