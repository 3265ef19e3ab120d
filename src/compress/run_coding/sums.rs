//! Partial sums of signals.

use crate::Real;
use crate::error::check_length;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
    impl<const C: usize> Sealed for [f32; C] {}
    impl<const C: usize> Sealed for [f64; C] {}
}

/// What a signal has at a pixel: a number (`f32`, `f64`) or an array of channels such as RGB. Sealed.
///
/// Every sum runs in `f64` and is rounded once.
pub trait Sample: sealed::Sealed + Copy + Send + Sync + 'static {
    /// The type of one channel.
    type Scalar: Real;
    /// A sum on its way.
    #[doc(hidden)]
    type Sum: Copy + Send + Sync;
    /// 0.
    #[doc(hidden)]
    const ZERO: Self::Sum;
    /// sum + weight · self.
    #[doc(hidden)]
    fn add(self, sum: Self::Sum, weight: f64) -> Self::Sum;
    /// factor · sum, rounded.
    #[doc(hidden)]
    fn narrow(sum: Self::Sum, factor: f64) -> Self;
}

macro_rules! sample {
    ($($t:ty)*) => {$(
        impl Sample for $t {
            type Scalar = $t;
            type Sum = f64;
            const ZERO: f64 = 0.0;
            #[inline(always)]
            fn add(self, sum: f64, weight: f64) -> f64 {
                sum + weight * self.widen()
            }
            #[inline(always)]
            fn narrow(sum: f64, factor: f64) -> Self {
                Self::of(factor * sum)
            }
        }

        impl<const C: usize> Sample for [$t; C] {
            type Scalar = $t;
            type Sum = [f64; C];
            const ZERO: [f64; C] = [0.0; C];
            #[inline(always)]
            fn add(self, mut sum: [f64; C], weight: f64) -> [f64; C] {
                for i in 0..C {
                    sum[i] += weight * self[i].widen();
                }
                sum
            }
            #[inline(always)]
            fn narrow(sum: [f64; C], factor: f64) -> Self {
                sum.map(|x| <$t>::of(factor * x))
            }
        }
    )*};
}
sample!(f32 f64);

/// The suffix sums of each block of `len` samples.
/// ```math
/// out[i] = Σ_{j≥i} signal[j] within the block                                  [Inger 2013, eq. 6]
/// ```
///
/// Compute once for each new light, for any number of blocks: what
/// [`CodedBinaryMap::dot`](crate::compress::CodedBinaryMap::dot) looks up.
///
/// Accuracy: summed in `f64`, rounded once. An `f32` sum so is wrong by up to 6e-8 of *itself*, and what it sums up
/// includes pixels that a map hides: behind a sun, `f64` sums (`[f64; 3]` for RGB) keep the night sky.
///
/// # Panics
/// If `len` is 0, `signal.len()` no multiple of it, or `out.len()` differs.
#[track_caller]
pub fn suffix_sums<S, O>(len: usize, signal: &[S], out: &mut [O])
where
    S: Sample,
    O: Sample<Sum = S::Sum>,
{
    assert!(len > 0, "suffix sums of blocks of length 0");
    check_length("samples of whole blocks", signal.len() / len * len, signal.len());
    check_length("suffix sums", signal.len(), out.len());
    for (signal, out) in signal.chunks_exact(len).zip(out.chunks_exact_mut(len)) {
        let mut sum = S::ZERO;
        for (sample, out) in signal.iter().zip(out).rev() {
            sum = sample.add(sum, 1.0);
            *out = O::narrow(sum, 1.0);
        }
    }
}
