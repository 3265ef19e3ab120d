//! Texels as arrays of channels.

use nalgebra::Vector3;

use crate::sphere::Texel;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
    impl Sealed for nalgebra::Vector3<f32> {}
    impl Sealed for nalgebra::Vector3<f64> {}
}

/// A texel of `C` channels: `f32` and `f64` have 1, RGB `Vector3` of them 3.
///
/// Sealed. Each type has one `C`, so that it is inferred.
pub trait Channels<const C: usize>: Texel + sealed::Sealed {
    /// The channels.
    fn channels(self) -> [Self::Scalar; C];
    /// The texel of these channels.
    fn from_channels(channels: [Self::Scalar; C]) -> Self;
}

macro_rules! channels {
    ($t:ty) => {
        impl Channels<1> for $t {
            #[inline(always)]
            fn channels(self) -> [$t; 1] {
                [self]
            }
            #[inline(always)]
            fn from_channels([value]: [$t; 1]) -> Self {
                value
            }
        }

        impl Channels<3> for Vector3<$t> {
            #[inline(always)]
            fn channels(self) -> [$t; 3] {
                self.into()
            }
            #[inline(always)]
            fn from_channels(channels: [$t; 3]) -> Self {
                channels.into()
            }
        }
    };
}

channels!(f32);
channels!(f64);
