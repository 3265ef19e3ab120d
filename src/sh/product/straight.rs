//! Products of up to three bands for arrays, to be inlined.

use super::generated::{tensor_2::Tensor2, tensor_3::Tensor3};
use super::single::Numbers;
use super::text::Straight;
use crate::Real;

/// Sizes whose text is the one by the tensor, and one band.
pub(in crate::sh) trait Small {
    fn product(a: &Self, b: &Self, out: &mut Self);
    fn square(a: &Self, out: &mut Self);
}

impl<T: Real> Small for [T; 1] {
    #[inline(always)]
    fn product([a]: &Self, [b]: &Self, [out]: &mut Self) {
        // 1/√4π = ¼ · 2/√π.
        *out = *a * (T::of(0.25 * std::f64::consts::FRAC_2_SQRT_PI) * *b);
    }
    #[inline(always)]
    fn square(a: &Self, out: &mut Self) {
        Self::product(a, a, out);
    }
}

macro_rules! small {
    ($($size: literal $text: ty),*) => {$(
        impl<T: Real> Small for [T; $size] {
            #[inline(always)]
            fn product(a: &Self, b: &Self, out: &mut Self) {
                <$text>::product(&mut Numbers { a, b, out });
            }
            #[inline(always)]
            fn square(a: &Self, out: &mut Self) {
                <$text>::square(&mut Numbers { a, b: a, out });
            }
        }
    )*};
}

small!(4 Tensor2, 9 Tensor3);

#[inline(always)]
pub(in crate::sh) fn product<A: Small>(a: &A, b: &A, out: &mut A) {
    A::product(a, b, out);
}

#[inline(always)]
pub(in crate::sh) fn square<A: Small>(a: &A, out: &mut A) {
    A::square(a, out);
}
