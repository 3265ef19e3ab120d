//! The scalar type of the crate's algorithms: `f32` or `f64`, nothing else.

use std::fmt::{Debug, Display};
use std::iter::Sum;

use num_traits::{Float, FloatConst, NumAssign};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A floating-point scalar; sealed, implemented by `f32` and `f64` only.
///
/// Constants are computed in `f64` and narrowed once with [`Real::of`].
pub trait Real:
    sealed::Sealed + Float + FloatConst + NumAssign + Sum + Default + Debug + Display + Send + Sync + 'static
{
    /// Narrows an `f64` (rounds to nearest).
    fn of(x: f64) -> Self;
    /// Widens to `f64` (exact).
    fn widen(self) -> f64;
}

impl Real for f32 {
    #[inline(always)]
    fn of(x: f64) -> Self {
        x as f32
    }
    #[inline(always)]
    fn widen(self) -> f64 {
        f64::from(self)
    }
}

impl Real for f64 {
    #[inline(always)]
    fn of(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn widen(self) -> f64 {
        self
    }
}
