//! Quadrature, careful sums and other numerical ground work.

mod quadrature;
mod safe;
mod sum;

pub use quadrature::GaussLegendre;
pub use safe::{safe_acos, safe_asin, safe_sqrt};
pub use sum::CompensatedSum;
