//! Affine wavelets: what a Haar signal becomes when it is scaled and moved, without leaving the wavelet basis.
//!
//! A signal F = Σ F_i Φ_i seen through the map v ↦ s v + o has the coefficients L_k = Σ_i F_i D_ik(s, o), with the
//! *affine coupling coefficients* D_ij = ∫ Φ_i(s v + o) Φ_j(v) dv; against a product it needs the *affine tripling
//! coefficients* D_ijk = ∫ Φ_i(s v + o) Φ_j Φ_k dv. All of them come down to one function of two variables, the
//! canonical coupling M(r, c). The light that a point receives from a textured rectangle is such a map of its texture,
//! and so is a zoom into an image [Sun 2008, ch. 4].
//!
//! # Which one when
//!
//! | you have | you want | use |
//! |---|---|---|
//! | r, c | M and its companions, their slopes | [`canonical`], [`canonical_batch`], [`canonical_gradient`] |
//! | a shader | M from a texture | [`CanonicalTable`] |
//! | two functions | D, its gradient | [`coupling_1d`], [`coupling_standard`], [`coupling_nonstandard`], [`coupling_gradient_1d`] |
//! | three | D_ijk | [`tripling_1d`], [`tripling_standard`], [`tripling_nonstandard`] |
//! | a function, or all | only the couplings that are not zero | [`Nonzeros1d`], [`NonzerosNonstandard`]; triplings: [`TripleNonzeros1d`], [`TripleNonzerosNonstandard`] |
//! | a 1D signal | it, scaled and moved; the transpose; derivatives | [`Operator1d`] |
//! | a light, thousands of places | its image at each, or a part of it | [`Propagation`], which picks the cheapest of three routes |
//! | a light's place to be optimised | the gradient of any function of its image | [`Propagation::gradient`] |
//! | no time for all targets | those that will matter | [`Prediction`] → [`Targets`] |
//! | many vertices, each with targets of its own | the light of each | [`Propagation::apply_lists`], with [`TargetLists`] |
//! | a transport vector a vertex | what each sends on, its light not stored | [`Propagation::inner_products`] |
//! | the same, in pixels | it, by exact areas and without a transform | [`PixelOperator`] |
//! | memory, few (s, o) | couplings looked up | [`StoredCouplings`] |
//! | sparse F, G, W | ∫ F(s v + o) G W dv and its gradient | [`AffineProduct1d`], [`AffineProduct2d`] |
//! | a light field F(v₁, v₂) | its image | [`LightField`] |
//! | a compressed image | it zoomed, streamed, mixed, masked, blurred | [`WaveletImage`], [`Zoom`], [`Kernel`] |
//! | curiosity | the same in pixels and Fourier series | `reference::affine::pixel_basis`, `fourier_basis` |
//!
//! Routes of a [`Propagation`], standard basis, side 32 and 64 (measured: docs/performance.md; the crossings drift with
//! s and with the machine):
//!
//! | source terms kept | targets kept | cheapest |
//! |---|---|---|
//! | up to about 10 % | any | [`PropagationRoute::Wavelets`] |
//! | more | more than about 3 % | [`PropagationRoute::Pixels`] |
//! | more | up to about 3 % | [`PropagationRoute::Lookups`] |
//!
//! In the nonstandard basis a moved wavelet has long edges of non-zero terms: the pixels win from about 1 % of the
//! source on.
//!
//! # What to know
//!
//! - F is 0 outside [0, 1). s may be negative; s = 0 is an error, its limit is L = F(o).
//! - L is the L² projection of F(s v + o): exact against anything of the same resolution. Projections do not chain:
//!   compose the maps ([`AffineMap::then`]).
//! - Non-zero couplings of an operator are Θ(N): at most 8N − (k + 2)(k + 4) of wavelets with wavelets, k = log₂ N, and
//!   2k + 1 more with the scaling function. Non-zero triplings are Θ(N log N).
//! - Single couplings, triplings, their gradients and columns are right to a few ε of themselves at every scale and
//!   zero if and only if they are; rows and operators to a few ε of the amplitudes of both functions.
//! - Maps are `f64`, signals `f32` or `f64`. A derivative where the value has a kink is the right-hand one.
//!
//! Sources: [Sun 2008, ch. 4]; docs/errata.md lists what is wrong or missing there, docs/affine.md has the pictures.

mod atom;
mod atom_product;
mod canonical;
mod coupling;
pub(crate) mod exact_sum;
mod grid;
mod image;
mod light_field;
mod map;
mod met;
mod operator_1d;
mod overlap;
pub(crate) mod pixel;
mod prediction;
mod product;
mod propagation;
mod steps;
mod stored;
mod table;
mod tripling;
mod zero;

pub use atom::Atom;
pub use atom_product::ScaledAtom;
pub use canonical::{Mother, canonical, canonical_batch, canonical_gradient, canonical_slope};
pub use coupling::{
    Nonzeros1d, NonzerosNonstandard, coupling, coupling_1d, coupling_gradient, coupling_gradient_1d,
    coupling_gradient_standard, coupling_nonstandard, coupling_standard,
};
pub use grid::{MapGrid, NearestMap};
pub use image::{
    ImageLevels, ImageRoute, Kernel, WaveletImage, Zoom, ZoomLevels, ZoomScratch, ZoomTargets, ZoomWindow,
};
pub use light_field::{LightField, LightFieldTerm};
pub use map::{AffineMap, Parameter};
pub use operator_1d::{Operator1d, apply_map_1d};
pub use prediction::{Heuristic, Prediction, mean_squares_1d, mean_squares_2d};
pub use product::{
    AffineProduct1d, AffineProduct2d, ProductGradient, ProductRoute, affine_double_product_1d,
    affine_double_product_2d, affine_triple_product_1d, affine_triple_product_2d,
};
pub use propagation::{
    Axis, PixelOperator, Propagation, PropagationRoute, PropagationScratch, PropagationSource, TargetLists, Targets,
};
pub use stored::{StoredCouplings, StoredOperator};
pub use table::{CanonicalTable, Filter, Quantisation};
pub use tripling::{
    TripleNonzeros1d, TripleNonzerosNonstandard, tripling, tripling_1d, tripling_gradient, tripling_gradient_1d,
    tripling_gradient_nonstandard, tripling_gradient_standard, tripling_nonstandard, tripling_standard,
};
