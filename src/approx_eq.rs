//! Approximate equality by the traits of `approx`, written once.

/// Implements `AbsDiffEq`, `RelativeEq` and `UlpsEq` for a type: what is `same` must be equal, what is `close` is
/// compared number by number.
///
/// `close` lists slices, arrays or vectors of scalars or of `Vector2`s or `Vector3`s, of which those of different
/// length are never equal; `same` lists what `==` compares. The type's defaults are those of the number behind it.
/// `[T]` stands for a scalar of the crate, other generics are written out.
macro_rules! approx_by_parts {
    ([T] $type:ty, $($parts:tt)+) => {
        $crate::approx_eq::approx_by_parts!(
            [T: $crate::Real + approx::RelativeEq<Epsilon = T> + approx::UlpsEq<Epsilon = T>] $type, $($parts)+
        );
    };
    ([$($generics:tt)*] $type:ty, $number:ty, $($parts:tt)+) => {
        impl<$($generics)*> approx::AbsDiffEq for $type {
            type Epsilon = <$number as approx::AbsDiffEq>::Epsilon;

            fn default_epsilon() -> Self::Epsilon {
                <$number as approx::AbsDiffEq>::default_epsilon()
            }

            fn abs_diff_eq(&self, other: &Self, epsilon: Self::Epsilon) -> bool {
                $crate::approx_eq::all_parts!(self, other, AbsDiffEq::abs_diff_eq [epsilon], $($parts)+)
            }
        }

        impl<$($generics)*> approx::RelativeEq for $type {
            fn default_max_relative() -> Self::Epsilon {
                <$number as approx::RelativeEq>::default_max_relative()
            }

            fn relative_eq(&self, other: &Self, epsilon: Self::Epsilon, max_relative: Self::Epsilon) -> bool {
                $crate::approx_eq::all_parts!(self, other, RelativeEq::relative_eq [epsilon, max_relative], $($parts)+)
            }
        }

        impl<$($generics)*> approx::UlpsEq for $type {
            fn default_max_ulps() -> u32 {
                <$number as approx::UlpsEq>::default_max_ulps()
            }

            fn ulps_eq(&self, other: &Self, epsilon: Self::Epsilon, max_ulps: u32) -> bool {
                $crate::approx_eq::all_parts!(self, other, UlpsEq::ulps_eq [epsilon, max_ulps], $($parts)+)
            }
        }
    };
}

/// Whether the parts of two values are the same and close, by a method of `approx` with its limits.
macro_rules! all_parts {
    (
        $a:ident, $b:ident, $trait:ident::$method:ident $limits:tt,
        |$value:ident| close [$($close:expr),+] same [$($same:expr),*]
    ) => {{
        let [a, b] = [$a, $b];
        true
            $(&& { let $value = a; $same } == { let $value = b; $same })*
            $(&& $crate::approx_eq::all_parts!(
                @part { let $value = a; $close }, { let $value = b; $close }, $trait::$method $limits
            ))+
    }};
    (@part $a:expr, $b:expr, $trait:ident::$method:ident [$($limit:expr),+]) => {
        approx::$trait::$method(&($a)[..], &($b)[..], $($limit),+)
    };
}

pub(crate) use {all_parts, approx_by_parts};
