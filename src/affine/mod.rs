//! Affine wavelets: what a Haar signal becomes when it is scaled and moved, without leaving the wavelet basis.

mod atom;
mod canonical;
mod coupling;
mod grid;
mod map;
mod prediction;
mod steps;
mod stored;
mod table;

pub use atom::Atom;
pub use canonical::{Mother, canonical, canonical_batch, canonical_gradient, canonical_slope};
pub use coupling::{
    Nonzeros1d, NonzerosNonstandard, coupling, coupling_1d, coupling_gradient, coupling_gradient_1d,
    coupling_nonstandard, coupling_standard,
};
pub use grid::{MapGrid, NearestMap};
pub use map::AffineMap;
pub use prediction::{Heuristic, Prediction, mean_squares_1d, mean_squares_2d};
pub use stored::{StoredCouplings, StoredOperator};
pub use table::{CanonicalTable, Filter, Quantisation};
