//! What the straight-line kernels compute with: registers of `f32` or `f64`, as wide as the machine has them.
//!
//! Each lane of a register holds a number of a vector of its own. Operations are those of IEEE 754 and never fused, so
//! that every machine gives the same bits.

use std::ops::{Add, Mul, Sub};

use pulp::Simd;

use crate::Real;

/// Anything that the text of a kernel can add, subtract and multiply.
pub(super) trait Lane: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {}

/// A register of `f32`.
#[derive(Clone, Copy)]
pub(super) struct Reg32<S: Simd>(S, S::f32s);

/// A register of `f64`.
#[derive(Clone, Copy)]
pub(super) struct Reg64<S: Simd>(S, S::f64s);

macro_rules! operators {
    ($reg: ident, $($op: ident :: $name: ident = $call: ident),*) => {
        impl<S: Simd> Lane for $reg<S> {}
        $(impl<S: Simd> $op for $reg<S> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(self.0, self.0.$call(self.1, other.1))
            }
        })*
    };
}

operators!(Reg32, Add::add = add_f32s, Sub::sub = sub_f32s, Mul::mul = mul_f32s);
operators!(Reg64, Add::add = add_f64s, Sub::sub = sub_f64s, Mul::mul = mul_f64s);

/// `f32` or `f64`, and the registers that hold several of it.
pub(super) trait Element: Real {
    type Reg<S: Simd>: Lane;
    /// How many numbers a register holds.
    fn lanes<S: Simd>() -> usize;
    fn splat<S: Simd>(simd: S, value: Self) -> Self::Reg<S>;
    /// As many numbers as there are lanes, or fewer: the lanes beyond are 0.
    fn load<S: Simd>(simd: S, from: &[Self]) -> Self::Reg<S>;
    /// To as many places as there are lanes, or fewer.
    fn store<S: Simd>(to: &mut [Self], value: Self::Reg<S>);
}

macro_rules! element {
    ($scalar: ty, $reg: ident, $lanes: ident, $splat: ident, $load: ident, $store: ident, $slice: ident, $slice_mut: ident) => {
        impl Element for $scalar {
            type Reg<S: Simd> = $reg<S>;
            #[inline(always)]
            fn lanes<S: Simd>() -> usize {
                S::$lanes
            }
            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: Self) -> $reg<S> {
                $reg(simd, simd.$splat(value))
            }
            #[inline(always)]
            fn load<S: Simd>(simd: S, from: &[Self]) -> $reg<S> {
                match S::$slice(from).0.first() {
                    Some(whole) => $reg(simd, *whole),
                    None => $reg(simd, simd.$load(from)),
                }
            }
            #[inline(always)]
            fn store<S: Simd>(to: &mut [Self], value: $reg<S>) {
                if to.len() >= S::$lanes {
                    S::$slice_mut(to).0[0] = value.1;
                } else {
                    value.0.$store(to, value.1);
                }
            }
        }
    };
}

element!(f32, Reg32, F32_LANES, splat_f32s, partial_load_f32s, partial_store_f32s, as_simd_f32s, as_mut_simd_f32s);
element!(f64, Reg64, F64_LANES, splat_f64s, partial_load_f64s, partial_store_f64s, as_simd_f64s, as_mut_simd_f64s);
