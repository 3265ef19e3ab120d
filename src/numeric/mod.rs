//! Quadrature, Legendre polynomials, careful sums and other numerical ground work.

mod arch;
mod legendre;
mod quadrature;
mod safe;
mod stack;
mod sum;

pub(crate) use arch::arch_256;
pub(crate) use legendre::LegendreSteps;
pub use legendre::{legendre, legendre_all, legendre_slopes};
pub use quadrature::GaussLegendre;
pub use safe::{safe_acos, safe_asin, safe_sqrt};
pub(crate) use stack::align_stack;
pub use sum::CompensatedSum;
pub(crate) use sum::SquareSum;
