//! What a map of directions can hold: scalars and RGB.

use std::fmt::Debug;
use std::ops::{Add, Mul};

use nalgebra::Vector3;
use num_traits::Zero;

use crate::Real;

/// A value that maps interpolate and integrate: `f32`, `f64`, or an RGB `Vector3` of them.
pub trait Texel:
    Copy + Debug + PartialEq + Zero + Add<Output = Self> + Mul<Self::Scalar, Output = Self> + Send + Sync + 'static
{
    /// The scalar that scales it.
    type Scalar: Real;
    /// The same value in `f64`, in which sums run.
    type Wide: Texel<Scalar = f64>;
    /// Widens to `f64` (exact).
    fn widen(self) -> Self::Wide;
    /// Narrows from `f64` (rounds to nearest).
    fn narrow(wide: Self::Wide) -> Self;
    /// Whether every component is finite.
    fn is_finite(self) -> bool;
    /// `f` of every component.
    fn map_components(self, f: impl Fn(Self::Scalar) -> Self::Scalar) -> Self;
    /// `f` of every pair of components.
    fn zip_components(self, other: Self, f: impl Fn(Self::Scalar, Self::Scalar) -> Self::Scalar) -> Self;
}

macro_rules! scalar_texel {
    ($t:ty) => {
        impl Texel for $t {
            type Scalar = $t;
            type Wide = f64;
            #[inline(always)]
            fn widen(self) -> f64 {
                Real::widen(self)
            }
            #[inline(always)]
            fn narrow(wide: f64) -> Self {
                Real::of(wide)
            }
            fn is_finite(self) -> bool {
                <$t>::is_finite(self)
            }
            #[inline(always)]
            fn map_components(self, f: impl Fn($t) -> $t) -> Self {
                f(self)
            }
            #[inline(always)]
            fn zip_components(self, other: Self, f: impl Fn($t, $t) -> $t) -> Self {
                f(self, other)
            }
        }

        impl Texel for Vector3<$t> {
            type Scalar = $t;
            type Wide = Vector3<f64>;
            #[inline(always)]
            fn widen(self) -> Vector3<f64> {
                self.map(Real::widen)
            }
            #[inline(always)]
            fn narrow(wide: Vector3<f64>) -> Self {
                wide.map(Real::of)
            }
            fn is_finite(self) -> bool {
                self.iter().all(|c| <$t>::is_finite(*c))
            }
            #[inline(always)]
            fn map_components(self, f: impl Fn($t) -> $t) -> Self {
                self.map(f)
            }
            #[inline(always)]
            fn zip_components(self, other: Self, f: impl Fn($t, $t) -> $t) -> Self {
                self.zip_map(&other, f)
            }
        }
    };
}

scalar_texel!(f32);
scalar_texel!(f64);

/// `approx` for a map: one grid, and texels that are close.
macro_rules! approx_by_texels {
    ($map:ident, $texels:ident) => {
        crate::approx_eq::approx_by_parts!(
            [P: Texel + approx::RelativeEq + approx::UlpsEq + approx::AbsDiffEq<Epsilon: Copy>] $map<P>,
            P, |m| close [&m.$texels] same [m.grid]
        );
    };
}
pub(super) use approx_by_texels;
