//! Eight numbers at a time, in the registers that the machine has.

use std::ops::{Add, Div, Mul, Sub};

use pulp::Simd;

use crate::scene::bvh::WIDTH;

/// Eight numbers in memory.
pub(super) type Lanes = [f32; WIDTH];

/// How many registers hold eight numbers: 1 with AVX2, 2 with NEON, 8 without vectors.
#[inline(always)]
pub(super) const fn parts<S: Simd>() -> usize {
    if S::F32_LANES < WIDTH { WIDTH / S::F32_LANES } else { 1 }
}

/// One register with its arithmetic: plain IEEE operations, never fused, so that all machines agree.
#[derive(Clone, Copy)]
pub(super) struct Reg<S: Simd>(S, S::f32s);

impl<S: Simd> Reg<S> {
    #[inline(always)]
    pub(super) fn splat(simd: S, value: f32) -> Self {
        Self(simd, simd.splat_f32s(value))
    }

    /// The part-th register of eight numbers.
    #[inline(always)]
    pub(super) fn load(simd: S, lanes: &Lanes, part: usize) -> Self {
        if S::F32_LANES <= WIDTH {
            Self(simd, S::as_simd_f32s(lanes).0[part])
        } else {
            Self(simd, simd.partial_load_f32s(lanes))
        }
    }

    #[inline(always)]
    pub(super) fn store(self, lanes: &mut Lanes, part: usize) {
        if S::F32_LANES <= WIDTH {
            S::as_mut_simd_f32s(lanes).0[part] = self.1;
        } else {
            self.0.partial_store_f32s(lanes, self.1);
        }
    }

    /// No operand may be NaN: machines differ there.
    #[inline(always)]
    pub(super) fn min(self, other: Self) -> Self {
        Self(self.0, self.0.min_f32s(self.1, other.1))
    }

    /// No operand may be NaN: machines differ there.
    #[inline(always)]
    pub(super) fn max(self, other: Self) -> Self {
        Self(self.0, self.0.max_f32s(self.1, other.1))
    }

    #[inline(always)]
    pub(super) fn abs(self) -> Self {
        Self(self.0, self.0.abs_f32s(self.1))
    }

    #[inline(always)]
    pub(super) fn sqrt(self) -> Self {
        Self(self.0, self.0.sqrt_f32s(self.1))
    }

    #[inline(always)]
    pub(super) fn less_or_equal(self, other: Self) -> Mask<S> {
        Mask(self.0, self.0.less_than_or_equal_f32s(self.1, other.1))
    }

    #[inline(always)]
    pub(super) fn less(self, other: Self) -> Mask<S> {
        Mask(self.0, self.0.less_than_f32s(self.1, other.1))
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $simd:ident) => {
        impl<S: Simd> $trait for Reg<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0, self.0.$simd(self.1, other.1))
            }
        }
    };
}

operator!(Add, add, add_f32s);
operator!(Sub, sub, sub_f32s);
operator!(Mul, mul, mul_f32s);
operator!(Div, div, div_f32s);

/// The outcome of a comparison.
#[derive(Clone, Copy)]
pub(super) struct Mask<S: Simd>(S, S::m32s);

impl<S: Simd> Mask<S> {
    #[inline(always)]
    pub(super) fn and(self, other: Self) -> Self {
        Self(self.0, self.0.and_m32s(self.1, other.1))
    }

    #[inline(always)]
    pub(super) fn select(self, yes: Reg<S>, no: Reg<S>) -> Reg<S> {
        Reg(self.0, self.0.select_f32s(self.1, yes.1, no.1))
    }
}
