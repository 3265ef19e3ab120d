//! Many rotations, a vector each.

use nalgebra::{Rotation3, UnitQuaternion};
use pulp::{Arch, Simd, WithSimd};

use super::chain::{Powers, powers, rotate_degree, rotate_flat};
use super::rotation::check_bands;
use super::swap::Swap;
use super::turns::{Matrices, Poses, Quaternions, components, entries, load, tiny};
use crate::error::check_length;
use crate::{Real, Result};

/// Lanes of a block: one AVX2 register of `f32`.
const LANES_F32: usize = 8;
/// The same register of `f64`.
const LANES_F64: usize = 4;

/// Rotates expansions, each by a rotation of its own that need not be known before.
///
///   (Rf)(ω) = f(R⁻¹ω):  out = Z(α) P Z(−β) P Z(γ) f,  R = R_z(α) R_y(β) R_z(γ)
///
/// Z turns about z, (m, −m) by mα; P, the constant matrix of the mirror that swaps y and z, is three quarters zeros. cos and sin of the
/// turns are algebraic in the rotation: no angle, no trigonometric function. Where one rotation is for many vectors, a
/// [`Rotation`](super::Rotation) is faster.
///
/// Every rotation is good: those that keep or reverse the z axis are done without P, without rounding if they are half turns or none.
/// A quaternion need not have length 1: any length from 1e-3 to 1e6 gives the same rotation, 0 none. Of a matrix that
/// is not quite orthogonal some rotation is taken that is as far off as the matrix. Whatever the input, lengths are kept to rounding.
/// NaN in a rotation reaches all coefficients of its vector but the first, NaN in a coefficient those of its degree.
///
/// Shapes: f, out: bands², index l(l+1)+m; batches coefficient-major, coefficient i of vector v at i·count + v.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::{Rotation3, Vector3}, sh::{Rotator, eval}};
/// let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), 0.3);
/// let d = Vector3::new(0.0, 0.6, 0.8);
/// let mut turned = [0.0; 16];
/// Rotator::<f64>::new(4)?.apply(&turn, &eval(4, &d)?, &mut turned);
/// // A lobe about d becomes the lobe about the turned d.
/// assert!(turned.iter().zip(eval(4, &(turn * d))?).all(|(a, b)| (a - b).abs() < 1e-15));
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Rotator<T> {
    bands: usize,
    table: Swap<T>,
    arch: Arch,
}

impl<T: Real> Rotator<T> {
    /// The plan for `bands`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) if `bands` is 0 or more than 128.
    pub fn new(bands: usize) -> Result<Self> {
        check_bands(bands)?;
        Ok(Self { bands, table: Swap::new(bands), arch: Arch::new() })
    }

    /// The number of bands.
    #[inline]
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// `out` = `f` rotated.
    ///
    /// # Panics
    /// If `f.len()` or `out.len()` is not bands².
    #[track_caller]
    pub fn apply(&self, rotation: &Rotation3<T>, f: &[T], out: &mut [T]) {
        self.check(1, f, out);
        let r = entries(rotation);
        self.one(&Matrices(std::array::from_fn(|k| &r[k..=k])), f, out);
    }

    /// `out` = `f` rotated by a quaternion; a little faster than by a matrix.
    ///
    /// # Panics
    /// If `f.len()` or `out.len()` is not bands².
    #[track_caller]
    pub fn apply_quaternion(&self, rotation: &UnitQuaternion<T>, f: &[T], out: &mut [T]) {
        self.check(1, f, out);
        let q = components(rotation);
        self.one(&Quaternions(std::array::from_fn(|k| &q[k..=k])), f, out);
    }

    /// `count` expansions, each rotated by its quaternion x, y, z, w: the same bits as [`apply_quaternion`](Self::apply_quaternion) one by
    /// one.
    ///
    /// # Panics
    /// If a component is not `count` long or `f.len()` or `out.len()` is not `count` · bands².
    #[track_caller]
    pub fn batch(&self, count: usize, quaternions: [&[T]; 4], f: &[T], out: &mut [T]) {
        for c in quaternions {
            check_length("rotations", count, c.len());
        }
        self.check(count, f, out);
        self.many(count, &Quaternions(quaternions), f, out);
    }

    /// `count` expansions, each rotated by its matrix, nine slices of entries row by row: the same bits as [`apply`](Self::apply) one by one.
    ///
    /// # Panics
    /// If an entry is not `count` long or `f.len()` or `out.len()` is not `count` · bands².
    #[track_caller]
    pub fn batch_matrices(&self, count: usize, matrices: [&[T]; 9], f: &[T], out: &mut [T]) {
        for c in matrices {
            check_length("rotations", count, c.len());
        }
        self.check(count, f, out);
        self.many(count, &Matrices(matrices), f, out);
    }

    #[track_caller]
    fn check(&self, count: usize, f: &[T], out: &[T]) {
        check_length("coefficients", self.bands * self.bands * count, f.len());
        check_length("rotated coefficients", self.bands * self.bands * count, out.len());
    }

    #[inline(always)]
    fn one<P: Poses<T>>(&self, poses: &P, f: &[T], out: &mut [T]) {
        let job = Job { rotator: self, poses, count: 1, f, out };
        job.sized::<1>();
    }

    fn many<P: Poses<T>>(&self, count: usize, poses: &P, f: &[T], out: &mut [T]) {
        self.arch.dispatch(Job { rotator: self, poses, count, f, out });
    }
}

/// Rotation of `count` vectors; run by `pulp` with the instructions that the machine has.
struct Job<'a, T, P> {
    rotator: &'a Rotator<T>,
    poses: &'a P,
    count: usize,
    f: &'a [T],
    out: &'a mut [T],
}

impl<T: Real, P: Poses<T>> WithSimd for Job<'_, T, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        if size_of::<T>() == 4 { self.sized::<LANES_F32>() } else { self.sized::<LANES_F64>() }
    }
}

impl<T: Real, P: Poses<T>> Job<'_, T, P> {
    /// A constant number of bands unrolls the chain.
    #[inline(always)]
    fn sized<const W: usize>(self) {
        match self.rotator.bands {
            1 => self.out.copy_from_slice(self.f),
            2 => self.run::<W, 2, 5>(2),
            3 => self.run::<W, 3, 5>(3),
            4 => self.run::<W, 4, 7>(4),
            5 => self.run::<W, 5, 9>(5),
            6 => self.run::<W, 6, 11>(6),
            bands @ ..=16 => self.run::<W, 16, 31>(bands),
            bands => self.run::<W, 128, 255>(bands),
        }
    }

    /// CAP ≥ bands, ROWS ≥ 2 bands − 1.
    #[inline(always)]
    fn run<const W: usize, const CAP: usize, const ROWS: usize>(self, bands: usize) {
        let Self { rotator, poses, count, f, out } = self;
        let zero = [T::zero(); W];
        let mut angles: Powers<T, W, CAP> = [[[zero; 2]; CAP]; 3];
        let (mut rows, mut spare) = ([zero; ROWS], [zero; ROWS]);
        for first in (0..count).step_by(W) {
            let width = W.min(count - first);
            let (turns, across) = poses.turns::<W>(first);
            powers(bands, &turns, &mut angles);
            out[first..first + width].copy_from_slice(&f[first..first + width]);
            for l in 1..bands {
                let size = 2 * l + 1;
                let at = l * l * count + first;
                for (i, row) in rows[..size].iter_mut().enumerate() {
                    *row = load(f, at + i * count, T::zero());
                }
                rotate_degree(l, &rotator.table, &angles, &mut rows[..size], &mut spare[..size]);
                for (i, row) in rows[..size].iter().enumerate() {
                    if width == W {
                        out[at + i * count..][..W].copy_from_slice(row);
                    } else {
                        out[at + i * count..][..width].copy_from_slice(&row[..width]);
                    }
                }
            }
            for (lane, &across) in across[..width].iter().enumerate() {
                if across < tiny() {
                    rotate_flat(bands, &poses.flat(first + lane), f, out, [count, first + lane]);
                }
            }
        }
    }
}
