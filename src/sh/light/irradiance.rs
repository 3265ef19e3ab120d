//! Irradiance as a quadratic form in the normal.

use std::f64::consts::PI;

use nalgebra::{Matrix4, Vector3};
use pulp::{Arch, Simd, WithSimd};

use crate::Real;
use crate::error::check_length;

/// Irradiance on a plane of any normal, from the first three bands of the radiance: a quadratic form in the normal, a
/// matrix a channel.
///
/// ```math
/// E(n) = (n, 1)ᵀ M (n, 1)                                    [Ramamoorthi & Hanrahan 2001, eqs. 11 and 12]
/// ```
///
/// E = ∫ L max(n·ω, 0) dω with its π: a white Lambertian plane reflects E/π. Equal to convolving with
/// [`Zonal::clamped_cosine`](super::super::Zonal::clamped_cosine) and evaluating 3 bands, for unit n. Of what the 3
/// bands leave out, degree 3 does not matter and degree 4 is the first that does. Of a directional light's irradiance
/// on a plane that faces it that is +6.2 % at 0° and 180° from it, −4.0 % at 58° and 122°, and most at 90°: +9.4 %.
/// Planes turned away from it are lit by so much, up to 122° and beyond.
///
/// Accuracy: 4 eps Σ|M|. Cost: 9 multiplications a normal and channel after 5 shared ones. Immutable; calls do not
/// allocate.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Vector3, sh::Irradiance};
/// // Radiance 1 from everywhere.
/// let white = Irradiance::new([&[(4.0 * std::f64::consts::PI).sqrt()]]);
/// let [e] = white.eval(&Vector3::new(0.6, 0.0, 0.8));
/// assert!((e - std::f64::consts::PI).abs() < 1e-15);
/// ```
#[derive(Debug, Clone)]
pub struct Irradiance<T, const C: usize> {
    forms: [Form<T>; C],
    arch: Arch,
}

/// The entries of M.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Form<T> {
    one: T,
    linear: [T; 3],
    /// xx = −yy.
    xx: T,
    zz: T,
    /// Twice the entries xy, xz, yz.
    mixed: [T; 3],
}

impl<T: Real> Form<T> {
    fn new(radiance: &[T]) -> Self {
        let at = |i: usize| radiance.get(i).map_or(0.0, |c| c.widen());
        // Â_0 y_00; Â_1 √(3/4π); Â_2 √(15/4π), and with √(5/16π) (3z² − 1).
        let a0 = PI * (0.25 / PI).sqrt();
        let a1 = 2.0 / 3.0 * PI * (0.75 / PI).sqrt();
        let a2 = 0.25 * PI * (3.75 / PI).sqrt();
        let a20 = 0.25 * PI * (0.3125 / PI).sqrt();
        Self {
            one: T::of(a0 * at(0) - a20 * at(6)),
            linear: [3, 1, 2].map(|i| T::of(a1 * at(i))),
            xx: T::of(0.5 * a2 * at(8)),
            zz: T::of(3.0 * a20 * at(6)),
            mixed: [4, 7, 5].map(|i| T::of(a2 * at(i))),
        }
    }

    /// Σ at L normals; x² − y² is (x − y)(x + y).
    #[inline(always)]
    fn eval<const L: usize>(&self, [x, y, z]: [&[T; L]; 3], out: &mut [T; L]) {
        let [bx, by, bz] = self.linear;
        let [xy, xz, yz] = self.mixed;
        for i in 0..L {
            let (x, y, z) = (x[i], y[i], z[i]);
            let first = x * (bx + xy * y + xz * z) + y * (by + yz * z);
            out[i] = self.one + first + z * (bz + self.zz * z) + self.xx * ((x - y) * (x + y));
        }
    }
}

impl<T: Real, const C: usize> Irradiance<T, C> {
    /// From the coefficients of radiance, a slice a channel. Beyond nine they are not used; missing ones are 0.
    pub fn new(radiance: [&[T]; C]) -> Self {
        Self { forms: radiance.map(Form::new), arch: Arch::new() }
    }

    /// The symmetric matrix M of a channel, for (x, y, z, 1).
    ///
    /// # Panics
    /// If `channel` ≥ C.
    #[track_caller]
    pub fn matrix(&self, channel: usize) -> Matrix4<T> {
        let Form { one, linear, xx, zz, mixed } = self.forms[channel];
        let half = T::of(0.5);
        let [x, y, z] = linear.map(|b| half * b);
        let [xy, xz, yz] = mixed.map(|m| half * m);
        Matrix4::new(xx, xy, xz, x, xy, -xx, yz, y, xz, yz, zz, z, x, y, z, one)
    }

    /// E on a plane of this unit normal.
    pub fn eval(&self, normal: &Vector3<T>) -> [T; C] {
        self.forms.map(|form| {
            let mut out = [T::zero()];
            form.eval([&[normal.x], &[normal.y], &[normal.z]], &mut out);
            out[0]
        })
    }

    /// E at many normals, a slice a channel; the same bits as [`eval`](Self::eval).
    ///
    /// # Panics
    /// If the slices differ in length.
    #[track_caller]
    pub fn eval_batch(&self, normals: [&[T]; 3], out: [&mut [T]; C]) {
        let count = normals[0].len();
        check_length("y coordinates", count, normals[1].len());
        check_length("z coordinates", count, normals[2].len());
        for out in &out {
            check_length("irradiances", count, out.len());
        }
        self.arch.dispatch(Batch { forms: &self.forms, normals, out });
    }
}

struct Batch<'a, T, const C: usize> {
    forms: &'a [Form<T>; C],
    normals: [&'a [T]; 3],
    out: [&'a mut [T]; C],
}

impl<T: Real, const C: usize> WithSimd for Batch<'_, T, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        if size_of::<T>() == 4 { self.run::<16>() } else { self.run::<8>() }
    }
}

impl<T: Real, const C: usize> Batch<'_, T, C> {
    #[inline(always)]
    fn run<const L: usize>(self) {
        let Self { forms, normals, out } = self;
        let (full, tail) = (normals[0].len() / L * L, normals[0].len() % L);
        let [x, y, z] = normals.map(|n| n.as_chunks::<L>().0);
        for channel in 0..C {
            let form = forms[channel];
            let (rows, _) = out[channel].as_chunks_mut::<L>();
            for (((x, y), z), out) in x.iter().zip(y).zip(z).zip(rows) {
                form.eval([x, y, z], out);
            }
        }
        if tail > 0 {
            let mut rest = [[T::zero(); L]; 3];
            for (rest, normal) in rest.iter_mut().zip(normals) {
                rest[..tail].copy_from_slice(&normal[full..]);
            }
            for channel in 0..C {
                let mut last = [T::zero(); L];
                forms[channel].eval(rest.each_ref(), &mut last);
                out[channel][full..].copy_from_slice(&last[..tail]);
            }
        }
    }
}
