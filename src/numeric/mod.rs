//! Quadrature, Legendre polynomials, careful sums, tables and other numerical ground work.

mod arch;
mod exponential_integral;
mod legendre;
mod quadrature;
mod safe;
mod stack;
mod sum;
mod table_2d;

pub(crate) use arch::arch_256;
pub use exponential_integral::{exponential_integral, exponential_integral_scaled, sine_cosine_auxiliary};
pub(crate) use legendre::LegendreSteps;
pub use legendre::{legendre, legendre_all, legendre_slopes};
pub use quadrature::GaussLegendre;
pub use safe::{safe_acos, safe_asin, safe_sqrt};
pub(crate) use stack::align_stack;
pub use sum::CompensatedSum;
pub(crate) use sum::SquareSum;
pub use table_2d::{Spacing, Table2d, TableAxis, TableError};
