//! Turns about z.

use pulp::{Arch, Simd, WithSimd};

use super::turns::load;
use crate::Real;
use crate::error::check_length;

/// Turns an expansion about z by `angle`, in place, x towards y.
///
/// ```math
/// c_{l,m} ← cos mα c_{l,m} − sin mα c_{l,−m},  c_{l,−m} ← sin mα c_{l,m} + cos mα c_{l,−m}
/// ```
///
/// Cost: 2 multiplications a coefficient. For many, [`rotate_z_batch`]. An infinite angle is NaN.
///
/// # Panics
/// If the number of coefficients is not a square.
///
/// # Example
/// ```
/// // x goes to y.
/// let mut c = [0.0, 0.0, 0.0, 1.0];
/// haarmonic::sh::rotate_z(std::f64::consts::FRAC_PI_2, &mut c);
/// assert!((c[1] - 1.0).abs() < 1e-15 && c[3].abs() < 1e-15);
/// ```
#[track_caller]
pub fn rotate_z<T: Real>(angle: T, coefficients: &mut [T]) {
    let (sin, cos) = angle.widen().sin_cos();
    let bands = bands_of(coefficients.len());
    turn_block::<T, 1>(bands, 1, [[T::of(cos)], [T::of(sin)]], [0, 1], coefficients);
}

/// Turns `count` expansions about z, each by an angle of its own given as cos and sin, in place; `count` is the number
/// of angles.
///
/// Coefficient-major: coefficient i of vector v at i·count + v. The same bits as [`rotate_z`] one by one.
///
/// # Panics
/// If there is not one sine to a cosine or the number of coefficients is not `count` times a square.
#[track_caller]
pub fn rotate_z_batch<T: Real>(cos: &[T], sin: &[T], coefficients: &mut [T]) {
    let count = cos.len();
    check_length("sines", count, sin.len());
    if count == 0 {
        check_length("coefficients", 0, coefficients.len());
        return;
    }
    let bands = bands_of(coefficients.len() / count);
    check_length("coefficients", bands * bands * count, coefficients.len());
    Arch::new().dispatch(Batch { bands, cos, sin, coefficients });
}

#[track_caller]
fn bands_of(coefficients: usize) -> usize {
    let bands = coefficients.isqrt();
    check_length("coefficients", bands * bands, coefficients);
    bands
}

struct Batch<'a, T> {
    bands: usize,
    cos: &'a [T],
    sin: &'a [T],
    coefficients: &'a mut [T],
}

impl<T: Real> WithSimd for Batch<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        if size_of::<T>() == 4 { self.run::<8>() } else { self.run::<4>() }
    }
}

impl<T: Real> Batch<'_, T> {
    #[inline(always)]
    fn run<const W: usize>(self) {
        let Self { bands, cos, sin, coefficients } = self;
        let count = cos.len();
        for first in (0..count).step_by(W) {
            let turn = [load::<T, W>(cos, first, T::one()), load::<T, W>(sin, first, T::zero())];
            let width = W.min(count - first);
            if width == W {
                turn_block(bands, count, turn, [first, W], coefficients);
            } else {
                turn_block(bands, count, turn, [first, width], coefficients);
            }
        }
    }
}

/// Vectors first..first + width of `count`.
#[inline(always)]
fn turn_block<T: Real, const W: usize>(
    bands: usize,
    count: usize,
    turn: [[T; W]; 2],
    [first, width]: [usize; 2],
    coefficients: &mut [T],
) {
    let mut power = turn;
    for m in 1..bands {
        for l in m..bands {
            let (up, down) = ((l * (l + 1) + m) * count + first, (l * (l + 1) - m) * count + first);
            let (mut a, mut b) = ([T::zero(); W], [T::zero(); W]);
            a[..width].copy_from_slice(&coefficients[up..up + width]);
            b[..width].copy_from_slice(&coefficients[down..down + width]);
            let (even, odd) = (a, b);
            for i in 0..W {
                a[i] = power[0][i] * even[i] - power[1][i] * odd[i];
                b[i] = power[1][i] * even[i] + power[0][i] * odd[i];
            }
            coefficients[up..up + width].copy_from_slice(&a[..width]);
            coefficients[down..down + width].copy_from_slice(&b[..width]);
        }
        for i in 0..W {
            let (c, s) = (power[0][i], power[1][i]);
            power[0][i] = c * turn[0][i] - s * turn[1][i];
            power[1][i] = c * turn[1][i] + s * turn[0][i];
        }
    }
}
