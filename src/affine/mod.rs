//! Affine wavelets: what a Haar signal becomes when it is scaled and moved, without leaving the wavelet basis.

mod atom;
mod atom_product;
mod canonical;
mod coupling;
mod exact_sum;
mod fourier;
mod grid;
mod light_field;
mod map;
mod met;
mod operator_1d;
mod pixel;
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
    coupling_nonstandard, coupling_standard,
};
pub use fourier::{
    fourier_coupling, fourier_coupling_matrix, fourier_coupling_nonzeros, fourier_tripling, fourier_tripling_count,
};
pub use grid::{MapGrid, NearestMap};
pub use light_field::{LightField, LightFieldTerm};
pub use map::{AffineMap, Parameter};
pub use operator_1d::{Operator1d, transform_1d};
pub use pixel::{
    pixel_coupling, pixel_coupling_bound, pixel_coupling_gradient, pixel_coupling_nonzeros, pixel_coupling_slope,
    pixel_tripling, pixel_tripling_nonzeros,
};
pub use prediction::{Heuristic, Prediction, mean_squares_1d, mean_squares_2d};
pub use product::{
    AffineProduct1d, AffineProduct2d, ProductGradient, ProductRoute, affine_double_product_1d,
    affine_double_product_2d, affine_triple_product_1d, affine_triple_product_2d,
};
pub use propagation::{Axis, Propagation, PropagationRoute, PropagationScratch, PropagationSource, Targets};
pub use stored::{StoredCouplings, StoredOperator};
pub use table::{CanonicalTable, Filter, Quantisation};
pub use tripling::{
    TripleNonzeros1d, TripleNonzerosNonstandard, tripling, tripling_1d, tripling_gradient, tripling_gradient_1d,
    tripling_gradient_nonstandard, tripling_nonstandard, tripling_standard,
};
