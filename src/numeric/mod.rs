//! Quadrature, careful sums and other numerical ground work.

mod quadrature;

pub use quadrature::GaussLegendre;
