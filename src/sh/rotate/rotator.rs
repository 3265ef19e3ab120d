//! Many rotations, a vector each.

use nalgebra::{Quaternion, Rotation3, UnitQuaternion};
use pulp::{Arch, Simd, WithSimd};

use super::chain::{
    Columns, Powers, degree_1, degree_2, degree_3, degree_4, degree_5, powers, rotate_degree, rotate_flat,
};
use super::sample::{self, Pose, Samples};
use super::single;
use super::sizes::{MAX_BANDS, check_bands};
use super::swap::Swap;
use super::turns::{
    Flat, Poses, Turns, components, entries, matrix_flat, matrix_turns, quaternion_flat, quaternion_turns, tiny,
};
use crate::error::check_length;
use crate::numeric::{align_stack, arch_256};
use crate::{Real, Result};

/// Lanes of a block: one AVX2 register of `f32`.
const LANES_F32: usize = 8;
/// The same register of `f64`.
const LANES_F64: usize = 4;

/// Bands from which a single expansion fills registers of 16 `f32`: below, turning to them costs more than they save.
const WIDE: usize = 5;

/// Bands whose degrees are unrolled.
const UNROLLED: usize = 6;

/// Rotates expansions, each by a rotation of its own that need not be known before.
///
/// ```math
/// (Rf)(ω) = f(R⁻¹ω):  out = Z(α) P Z(−β) P Z(γ) f,  R = R_z(α) R_y(β) R_z(γ)
/// ```
///
/// Z turns about z, (m, −m) by mα; P, the constant matrix of the mirror that swaps y and z, is three quarters zeros.
/// cos and sin of the turns are algebraic in the rotation: no angle, no trigonometric function. That is what batches
/// do. A single expansion has its first six bands rotated by sampling: f at R⁻¹ of a few fixed directions, then the
/// coefficients that have these samples; no root, no special axis. The two differ by rounding. Where one rotation is
/// for many vectors, a [`Rotation`](super::Rotation) is faster.
///
/// Every rotation is good: those that keep or reverse the z axis are done without either, without rounding if they are
/// half turns or none. A quaternion need not have length 1: any length gives the same rotation, 0 none. Of a matrix
/// that is not quite orthogonal, off by δ, the chain takes some rotation that is as far off, and keeps lengths to
/// rounding; sampling evaluates the y_{lm} as polynomials at Rᵀd_i, so results and lengths are off by a few l δ. NaN or
/// infinity in a rotation makes all coefficients of its vector NaN but the first, NaN in a coefficient those of its
/// degree. (A [`Rotation`](super::Rotation) refuses it.)
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
    samples: Samples<T>,
    sampled: Option<sample::Run<T>>,
    arch: Arch,
    /// For single expansions.
    arch_sampled: Arch,
}

impl<T: Real> Rotator<T> {
    /// The plan for `bands`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) if `bands` is 0 or more than 128.
    pub fn new(bands: usize) -> Result<Self> {
        check_bands(bands)?;
        Ok(Self {
            bands,
            table: Swap::new(bands),
            samples: Samples::new(bands.min(sample::MOST_BANDS)),
            sampled: sample::choose(bands.min(sample::MOST_BANDS)),
            arch: arch_256(),
            arch_sampled: if bands < WIDE { arch_256() } else { Arch::new() },
        })
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
        let pose = Pose::Matrix(&rotation.matrix().data.0);
        let r = || entries(rotation);
        if !is_finite(&r()) {
            return poison(1, 0, f, out);
        }
        let [_, _, x, _, _, y, ..] = r();
        if x * x + y * y < tiny() {
            return self.flat(&matrix_flat(&r()), f, out);
        }
        self.one(&pose, || matrix_turns(&r().map(|x| [x])).0, f, out);
    }

    /// `out` = `f` rotated by a quaternion.
    ///
    /// # Panics
    /// If `f.len()` or `out.len()` is not bands².
    #[track_caller]
    pub fn apply_quaternion(&self, rotation: &UnitQuaternion<T>, f: &[T], out: &mut [T]) {
        self.check(1, f, out);
        let q = || components(rotation);
        let [x, y, z, w] = q();
        if !in_range(&q()) {
            return self.out_of_range(&q(), f, out);
        }
        let [about, across] = [w * w + z * z, x * x + y * y];
        if about * across < tiny() {
            return self.flat(&quaternion_flat(q()), f, out);
        }
        let pose = Pose::Quaternion(&rotation.as_ref().coords.data.0[0], (T::one() + T::one()) / (about + across));
        self.one(&pose, || quaternion_turns(&q().map(|x| [x])).0, f, out);
    }

    /// `count` expansions, each rotated by its quaternion x, y, z, w, as [`apply_quaternion`](Self::apply_quaternion)
    /// would up to rounding. A vector's result does not depend on the others.
    ///
    /// # Panics
    /// If a component is not `count` long or `f.len()` or `out.len()` is not `count` · bands².
    #[track_caller]
    pub fn apply_quaternion_batch(&self, count: usize, quaternions: [&[T]; 4], f: &[T], out: &mut [T]) {
        for c in quaternions {
            check_length("rotations", count, c.len());
        }
        self.check(count, f, out);
        self.many(count, &Poses::Quaternions(quaternions), f, out);
        // One pass for the usual case; it vectorises.
        let usual = |v: usize| in_range(&quaternions.map(|c| c[v]));
        if (0..count).fold(true, |all, v| all & usual(v)) {
            return;
        }
        let column = |f: &[T], v: usize| f[v..].iter().step_by(count).copied().collect::<Vec<T>>();
        for v in (0..count).filter(|&v| !usual(v)) {
            let (f, mut turned) = (column(f, v), column(out, v));
            self.out_of_range(&quaternions.map(|c| c[v]), &f, &mut turned);
            out[v..].iter_mut().step_by(count).zip(turned).for_each(|(out, x)| *out = x);
        }
    }

    /// `count` expansions, each rotated by its matrix, nine slices of entries row by row, as [`apply`](Self::apply)
    /// would up to rounding, if the matrix is orthogonal to rounding.
    ///
    /// # Panics
    /// If an entry is not `count` long or `f.len()` or `out.len()` is not `count` · bands².
    #[track_caller]
    pub fn apply_batch(&self, count: usize, matrices: [&[T]; 9], f: &[T], out: &mut [T]) {
        for c in matrices {
            check_length("rotations", count, c.len());
        }
        self.check(count, f, out);
        self.many(count, &Poses::Matrices(matrices), f, out);
        if !matrices.iter().all(|entries| is_finite(entries)) {
            for v in (0..count).filter(|&v| matrices.iter().any(|entries| !entries[v].is_finite())) {
                poison(count, v, f, out);
            }
        }
    }

    /// One expansion by a quaternion whose squares may under- or overflow.
    #[cold]
    fn out_of_range(&self, q: &[T; 4], f: &[T], out: &mut [T]) {
        let size = largest(q);
        if !is_finite(q) {
            poison(1, 0, f, out);
        } else if size == T::zero() {
            out.copy_from_slice(f);
        } else {
            let [x, y, z, w] = q.map(|c| c / size);
            self.apply_quaternion(&UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)), f, out);
        }
    }

    #[track_caller]
    fn check(&self, count: usize, f: &[T], out: &[T]) {
        check_length("coefficients", (self.bands * self.bands).saturating_mul(count), f.len());
        check_length("rotated coefficients", (self.bands * self.bands).saturating_mul(count), out.len());
    }

    #[cold]
    fn flat(&self, flat: &Flat<T>, f: &[T], out: &mut [T]) {
        out[0] = f[0];
        rotate_flat(0..self.bands, flat, f, out, [1, 0]);
    }

    /// One expansion: the first six bands by sampling, those above by the chain.
    #[inline(always)]
    fn one(&self, pose: &Pose<'_, T>, turns: impl FnOnce() -> Turns<T, 1>, f: &[T], out: &mut [T]) {
        match self.sampled {
            Some(run) => run(&self.samples, self.arch_sampled, pose, f, out),
            None => out[0] = f[0],
        }
        if self.bands > sample::MOST_BANDS {
            single::rotate(&self.table, sample::MOST_BANDS..self.bands, &turns(), f, out);
        }
    }

    fn many(&self, count: usize, poses: &Poses<'_, T>, f: &[T], out: &mut [T]) {
        let job = Job { rotator: self, poses, count, f, out };
        if count < lanes::<T>() { job.run::<1>() } else { self.arch.dispatch(job) }
    }
}

/// Rotation of `count` vectors; run by `pulp` with the instructions that the machine has.
struct Job<'a, T> {
    rotator: &'a Rotator<T>,
    poses: &'a Poses<'a, T>,
    count: usize,
    f: &'a [T],
    out: &'a mut [T],
}

impl<T: Real> WithSimd for Job<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        align_stack();
        if size_of::<T>() == 4 { self.blocks::<LANES_F32>() } else { self.blocks::<LANES_F64>() }
    }
}

impl<T: Real> Job<'_, T> {
    #[inline(never)]
    fn run<const W: usize>(self) {
        self.blocks::<W>();
    }

    /// The first six bands unrolled, then those above; blocks of W vectors, the last one with some for the second time.
    #[inline(always)]
    fn blocks<const W: usize>(mut self) {
        let (count, bands) = (self.count, self.rotator.bands);
        self.out[..count].copy_from_slice(&self.f[..count]);
        for block in (0..count).step_by(W) {
            let first = block.min(count - W);
            let (turns, across) = self.poses.turns::<W>(first);
            self.low::<W>(&turns, first);
            for (lane, &across) in across.iter().enumerate() {
                if across < tiny() {
                    let at = first + lane;
                    rotate_flat(0..bands.min(UNROLLED), &self.poses.flat(at), self.f, self.out, [count, at]);
                }
            }
        }
        if bands > UNROLLED {
            self.high::<W>();
        }
    }

    #[inline(always)]
    fn low<const W: usize>(&mut self, turns: &Turns<T, W>, first: usize) {
        let Self { rotator, count, f, ref mut out, .. } = *self;
        let (table, bands) = (&rotator.table, rotator.bands);
        let mut angles: Powers<T, W, UNROLLED> = [[[[T::zero(); W]; 2]; UNROLLED]; 3];
        powers(bands.min(UNROLLED), turns, &mut angles);
        let mut io = Columns { f, out, count, first };
        if bands > 1 {
            degree_1(table, &angles, &mut io);
        }
        if bands > 2 {
            degree_2(table, &angles, &mut io);
        }
        if bands > 3 {
            degree_3(table, &angles, &mut io);
        }
        if bands > 4 {
            degree_4(table, &angles, &mut io);
        }
        if bands > 5 {
            degree_5(table, &angles, &mut io);
        }
    }

    #[inline(always)]
    fn high<const W: usize>(self) {
        let Self { rotator, poses, count, f, out } = self;
        let zero = [T::zero(); W];
        let mut angles: Powers<T, W, MAX_BANDS> = [[[zero; 2]; MAX_BANDS]; 3];
        let (mut rows, mut spare) = ([zero; 2 * MAX_BANDS], [zero; 2 * MAX_BANDS]);
        for block in (0..count).step_by(W) {
            let first = block.min(count - W);
            let (turns, across) = poses.turns::<W>(first);
            powers(rotator.bands, &turns, &mut angles);
            let mut io = Columns { f, out, count, first };
            for l in UNROLLED..rotator.bands {
                rotate_degree(l, &rotator.table, &angles, &mut io, [&mut rows, &mut spare]);
            }
            for (lane, &across) in across.iter().enumerate() {
                if across < tiny() {
                    let at = first + lane;
                    rotate_flat(UNROLLED..rotator.bands, &poses.flat(at), f, out, [count, at]);
                }
            }
        }
    }
}

/// Whether no number of a rotation is NaN or infinite.
#[inline(always)]
fn is_finite<T: Real>(numbers: &[T]) -> bool {
    numbers.iter().fold(T::zero(), |sum, &x| sum + x * T::zero()) == T::zero()
}

/// What a rotation that is none makes of vector v of `count`: the methods do not read every number of every rotation.
#[cold]
fn poison<T: Real>(count: usize, v: usize, f: &[T], out: &mut [T]) {
    out[v] = f[v];
    out[v..].iter_mut().step_by(count).skip(1).for_each(|out| *out = T::nan());
}

/// The largest number of a quaternion, NaN left out.
#[inline(always)]
fn largest<T: Real>(q: &[T; 4]) -> T {
    q.iter().fold(T::zero(), |most, c| most.max(c.abs()))
}

/// Whether the length of a quaternion is in 5e-4…2e6 or so and nothing of it is NaN, so that squares of its squares are
/// normal numbers.
#[inline(always)]
fn in_range<T: Real>(q: &[T; 4]) -> bool {
    let most = largest(q);
    is_finite(q) & (most >= T::of(5e-4)) & (most <= T::of(2e6))
}

const fn lanes<T>() -> usize {
    if size_of::<T>() == 4 { LANES_F32 } else { LANES_F64 }
}
