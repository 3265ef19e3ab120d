//! Functions of expansions: exp, log, any h; see the page of [`sh`](crate::sh).
//!
//! [Sun 2008, §5.2.2–5.2.3], less what docs/errata.md corrects.

mod cap_log;
mod exp;
mod grid;
mod grid_exp;
mod logarithm;
mod optimal_linear;
mod optimal_linear_table;
mod piecewise;
mod series;
mod spectrum;
mod zonal;

pub use cap_log::{CapFit, CapLog};
pub use exp::{ExpMethod, Exponential};
pub use grid::GridFunction;
pub use logarithm::{LogMethod, Logarithm};
pub use optimal_linear::OptimalLinear;
pub use series::{Powers, ProductSeries};
pub use spectrum::ProductSpectrum;

/// The coefficient of y_00 in the constant 1: √4π.
const ONE: f64 = 4.0 / std::f64::consts::FRAC_2_SQRT_PI;
