//! Near-field relighting by affine wavelet products: textured lamps that move, grow, turn and are painted while every
//! vertex sees them [Sun 2008, §4.5–4.6].
//!
//! The plane of the lights is chosen once. Above each vertex lies a square parallel to it, the *top face*, and what the
//! vertex sees of a light on it is an affine map of the light's texture: scaled by the height, moved by the place. So
//! the light's wavelets are carried to the vertex by affine couplings, exactly, and met there by the vertex's
//! transport.
//!
//! | type | life |
//! |---|---|
//! | [`Transport`] | visibility × reflectance of every vertex on its top face, baked once, saved and loaded |
//! | [`BakeSettings`], [`Precision`], [`ViewFactors`] | the face, its cells, and what is kept |
//! | [`PlanarLight`] | a textured rectangle with a place, sizes, an angle, a mask and a profile |
//! | [`Relighter`] | frames, and the gradient of a loss in a light |
//! | [`Settings`], [`Route`], [`TargetSelection`], [`Ranking`] | what is kept of lights, and how frames are computed |
//! | [`ProductSampler`], [`BrdfTable`], [`LightSampler`], [`Mixture`], [`Reflection`] | importance sampling for Monte Carlo renderers, without the rest |
//! | [`IncidentLight`] | the wavelets of the light that arrives at a point, for any other transport |
//!
//! # Which route when
//!
//! | you have | use |
//! |---|---|
//! | no wish | [`Route::Automatic`] |
//! | a light of a wavelet or two: one radiance | [`Route::Couplings`] |
//! | any other light | [`Route::Pixels`], unless its images are too large for the memory |
//! | the thesis in hand | [`Route::StoredCouplings`], [`Route::CanonicalTable`], with [`TargetSelection::constant_light`] |
//!
//! What lies below the horizon of the face, beyond its edge, is not seen: a larger face sees more, in coarser cells.
//! Lights in planes that are not parallel want a transport each. docs/near_field.md has the theory and what was
//! measured.

mod bake;
mod file;
mod gradient;
mod incident;
mod light;
mod pixels;
mod relighter;
mod rows;
mod sampling;
mod settings;
mod tables;
mod texture;
mod transport;

pub use gradient::LightGradient;
pub use incident::IncidentLight;
pub use light::PlanarLight;
pub use relighter::Relighter;
pub use sampling::{
    BrdfDensity, BrdfScratch, BrdfTable, DirectionSample, DirectionSampler, Incidence, LightDensity, LightHit,
    LightSampler, LightWeight, Mixture, ProductDensity, ProductSampler, ProductScratch, ProductSettings, Reflection,
    ShadingPoint, Window,
};
pub use settings::{BakeSettings, Precision, Ranking, Route, Settings, TargetSelection, ViewFactors};
pub use transport::{Transport, TransportStats};
