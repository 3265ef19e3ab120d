//! The plan: tables of a size, applied to one direction or to many.

mod gradient;
mod hessian;
pub(in crate::sh) mod kernel;
mod legendre;

use nalgebra::{Matrix3, Vector3};
use pulp::{Arch, Simd, WithSimd};

use self::gradient::{GradientPoint, GradientRows, walk_gradient};
use self::hessian::{HessianPoint, HessianRows, walk_hessian};
use self::kernel::{Accumulate, Dot, Keep, StoreFewRows, StoreRows, Table, walk, walk_fixed};
use crate::error::check_length;
use crate::numeric::{align_stack, arch_256};
use crate::{Error, Real, Result};

pub use self::legendre::associated_legendre;

/// The real, orthonormal spherical harmonics of `bands`, without the Condon–Shortley phase, at index l(l+1) + m.
///
/// ```math
/// y_{l,0} = N_{l0} P_l(z),  y_{l,±m} = √2 N_{lm} P_l^m(z) {cos mφ, sin mφ}  (m > 0)
/// N_{lm}² = (2l+1)/4π · (l−m)!/(l+m)!        [Sun 2008, eqs. 2.5–2.10, less their (−1)^m: see docs/errata.md]
/// ```
///
/// Built once; `eval` and its batch forms do not allocate. Each value has the same bits by every entry point, on every
/// machine and for any number of points in the call.
///
/// Shapes: directions are unit vectors (x, y, z), in batches three slices of one length; they are neither checked nor
/// normalised, and one whose length is off by δ moves degree l by up to l² δ/2 near the poles. That is also the limit
/// of `f32`: its unit vectors are known to 6e-8. NaN in z reaches all coefficients but those with l = |m|, NaN in x or
/// y all with m ≠ 0: the others do not read it. It reaches every sum over two bands or more.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Vector3, sh::Basis};
/// let mut y = [0.0; 4];
/// Basis::<f64>::new(2)?.eval(&Vector3::new(0.0, 0.0, 1.0), &mut y);
/// let root = |x: f64| (x / std::f64::consts::PI).sqrt() / 2.0;
/// assert!((y[0] - root(1.0)).abs() < 1e-16 && (y[2] - root(3.0)).abs() < 1e-15);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Basis<T> {
    bands: usize,
    table: Table<T>,
    arch: Arch,
}

/// All y of `bands` at one direction, index l(l+1) + m. One shot: where there are many directions, keep a [`Basis`].
///
/// # Errors
/// As [`Basis::new`].
pub fn eval<T: Real>(bands: usize, direction: &Vector3<T>) -> Result<Vec<T>> {
    let basis = Basis::new(bands)?;
    let mut out = vec![T::zero(); bands * bands];
    basis.eval(direction, &mut out);
    Ok(out)
}

impl<T: Real> Basis<T> {
    /// A plan for expansions of `bands` bands.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is 0 or more than [`max_bands`](Self::max_bands).
    pub fn new(bands: usize) -> Result<Self> {
        if bands == 0 || bands > Self::max_bands() {
            let allowed = if is_narrow::<T>() { "1 to 128 in f32" } else { "1 to 1024 in f64" };
            return Err(Error::OutOfRange { what: "bands", got: bands as f64, allowed });
        }
        Ok(Self { bands, table: Table::new(bands), arch: arch_256() })
    }

    /// The largest `bands`: 128 in `f32`, 1024 in `f64`.
    ///
    /// The polynomial in z grows as 1.618^l before sin^m θ brings it back to size; it overflows near l = 180 and 1470.
    pub const fn max_bands() -> usize {
        if is_narrow::<T>() { 128 } else { 1024 }
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// The number of coefficients, bands².
    pub fn coefficient_count(&self) -> usize {
        self.bands * self.bands
    }

    /// All y_i at one direction.
    ///
    /// Accuracy, worst over the sphere and beside the poles, against the normalised direction: `f64` 1.4e-15 at 6
    /// bands, 8e-15 at 12, 4e-13 at 64; `f32` 5e-7 at 6 bands, 5e-6 at 21, 8e-5 at 51. It grows as bands^2.5, which is
    /// the rounding of
    /// |direction| times the slope.
    ///
    /// # Panics
    /// If `out.len()` is not bands².
    #[track_caller]
    pub fn eval(&self, direction: &Vector3<T>, out: &mut [T]) {
        check_length("coefficients", self.coefficient_count(), out.len());
        let d = [&[direction.x], &[direction.y], &[direction.z]];
        let out = out.as_chunks_mut::<1>().0;
        macro_rules! unrolled {
            ($($bands:literal)*) => {
                match self.bands {
                    $($bands => {
                        let mut keep = Keep(&mut out[..$bands * $bands]);
                        walk_fixed::<T, 1, $bands, _>(&self.table, $bands, d, &mut keep)
                    })*
                    bands => walk(&self.table, bands, d, &mut Keep(out)),
                }
            };
        }
        unrolled!(1 2 3 4 5 6);
    }

    /// All y_i at many directions, a row for each coefficient: `out[i · n + p]` is y_i at point p of n.
    ///
    /// Lanes of points run through one walk and are stored as they are.
    ///
    /// # Panics
    /// If the three slices differ in length or `out.len()` is not bands² times it.
    #[track_caller]
    pub fn eval_batch(&self, x: &[T], y: &[T], z: &[T], out: &mut [T]) {
        let points = self.check_points(x, y, z);
        check_length("values", self.coefficient_count() * points, out.len());
        self.arch.dispatch(Batch(EvalRows { basis: self, d: [x, y, z], out }));
    }

    /// All y_i at many directions, a row for each point: `out[p · bands² + i]` is y_i at point p.
    ///
    /// Above 6 bands it allocates once a call.
    ///
    /// # Panics
    /// If the three slices differ in length or `out.len()` is not bands² times it.
    #[track_caller]
    pub fn eval_points(&self, x: &[T], y: &[T], z: &[T], out: &mut [T]) {
        let points = self.check_points(x, y, z);
        check_length("values", self.coefficient_count() * points, out.len());
        self.arch.dispatch(Batch(EvalPoints { basis: self, d: [x, y, z], out }));
    }

    /// The values of f = Σ c_i y_i at many directions, basis values never stored.
    ///
    /// Cost, counted: about 2.5 multiplications a coefficient and point; [`eval_batch`](Self::eval_batch) and a dot
    /// product have 3.5, and a store and a load.
    ///
    /// # Panics
    /// If the slices of points and `out` differ in length or `coefficients.len()` is not bands².
    #[track_caller]
    pub fn reconstruct(&self, coefficients: &[T], x: &[T], y: &[T], z: &[T], out: &mut [T]) {
        let points = self.check_points(x, y, z);
        check_length("values", points, out.len());
        check_length("coefficients", self.coefficient_count(), coefficients.len());
        self.arch.dispatch(Batch(Reconstruct { basis: self, coefficients, d: [x, y, z], out }));
    }

    /// The value of f = Σ c_i y_i at one direction; the same bits as [`reconstruct`](Self::reconstruct).
    ///
    /// # Panics
    /// If `coefficients.len()` is not bands².
    #[track_caller]
    pub fn dot(&self, coefficients: &[T], direction: &Vector3<T>) -> T {
        check_length("coefficients", self.coefficient_count(), coefficients.len());
        let mut dot = Dot::<T, 1>::new(coefficients);
        walk(&self.table, self.bands, [&[direction.x], &[direction.y], &[direction.z]], &mut dot);
        dot.sum[0]
    }

    /// Adds Σ_p w_p y_i(p) to `out[channel][i]`, for C channels of weights in one pass over the basis.
    ///
    /// With w = f · solid angle this is projection. C = 0 does nothing. Sums are held in T for at most 64 points a
    /// lane, then in `f64`; the order of summation depends on neither machine nor threads. Allocates once a call.
    ///
    /// # Panics
    /// If the slices of points and weights differ in length or an `out` is not bands² long.
    #[track_caller]
    pub fn accumulate<const C: usize>(&self, x: &[T], y: &[T], z: &[T], weights: [&[T]; C], out: [&mut [T]; C]) {
        let points = self.check_points(x, y, z);
        for (weights, out) in weights.iter().zip(&out) {
            check_length("weights", points, weights.len());
            check_length("coefficients", self.coefficient_count(), out.len());
        }
        let sums = self.arch.dispatch(Batch(AccumulatePoints { basis: self, d: [x, y, z], weights }));
        for (channel, out) in out.into_iter().enumerate() {
            for (i, out) in out.iter_mut().enumerate() {
                *out = T::of(out.widen() + sums[i * C + channel]);
            }
        }
    }

    /// All y_i and their gradients at one direction.
    ///
    /// The gradient is the one on the sphere: of y(r/|r|) at |r| = 1, tangent to the sphere (∇y · ω = 0), finite
    /// everywhere. That of the solid harmonic r^l y is ∇y + l y ω.
    ///
    /// Accuracy: `f64`, ∫ |∇y|² = l(l+1) to 1e-12 at 40 bands; `f32` 1e-5 at 11 bands.
    ///
    /// # Panics
    /// If `values` or `gradients` is not bands² long.
    #[track_caller]
    pub fn gradient(&self, direction: &Vector3<T>, values: &mut [T], gradients: &mut [Vector3<T>]) {
        check_length("coefficients", self.coefficient_count(), values.len());
        check_length("gradients", self.coefficient_count(), gradients.len());
        let d = [&[direction.x], &[direction.y], &[direction.z]];
        walk_gradient(&self.table, self.bands, d, &mut GradientPoint { values, gradients });
    }

    /// All y_i and their gradients at many directions, a row for each coefficient as in
    /// [`eval_batch`](Self::eval_batch), a slice for each component; the gradient is that of
    /// [`gradient`](Self::gradient).
    ///
    /// # Panics
    /// If the three slices differ in length or an output's length is not bands² times it.
    #[track_caller]
    pub fn gradient_batch(&self, [x, y, z]: [&[T]; 3], values: &mut [T], gradients: [&mut [T]; 3]) {
        let points = self.check_points(x, y, z);
        check_length("values", self.coefficient_count() * points, values.len());
        for g in &gradients {
            check_length("gradients", self.coefficient_count() * points, g.len());
        }
        self.arch.dispatch(Batch(GradientsRows { basis: self, d: [x, y, z], values, gradients }));
    }

    /// All y_i, their gradients, and their Hessians on the sphere at one direction; values and gradients as
    /// [`gradient`](Self::gradient)'s.
    ///
    /// The Hessian is the covariant one, a symmetric matrix in Cartesian coordinates with H ω = 0: uᵀHu is the second
    /// derivative along the great circle that leaves in the unit tangent u. Its trace is −l(l+1) y. Finite everywhere.
    /// The Cartesian Hessian of y(r/|r|) at
    /// |r| = 1 is H − ω∇yᵀ − ∇y ωᵀ.
    ///
    /// # Panics
    /// If `values`, `gradients` or `hessians` is not bands² long.
    #[track_caller]
    pub fn hessian(
        &self,
        direction: &Vector3<T>,
        values: &mut [T],
        gradients: &mut [Vector3<T>],
        hessians: &mut [Matrix3<T>],
    ) {
        check_length("coefficients", self.coefficient_count(), values.len());
        check_length("gradients", self.coefficient_count(), gradients.len());
        check_length("Hessians", self.coefficient_count(), hessians.len());
        let d = [&[direction.x], &[direction.y], &[direction.z]];
        walk_hessian(&self.table, self.bands, d, &mut HessianPoint { values, gradients, hessians });
    }

    /// All y_i, their gradients and Hessians at many directions, a row for each coefficient as in
    /// [`eval_batch`](Self::eval_batch), a slice for each component: x, y, z, and xx, xy, xz, yy, yz, zz of the Hessian
    /// that [`hessian`](Self::hessian) defines.
    ///
    /// # Panics
    /// If the three slices differ in length or an output's length is not bands² times it.
    #[track_caller]
    pub fn hessian_batch(
        &self,
        [x, y, z]: [&[T]; 3],
        values: &mut [T],
        gradients: [&mut [T]; 3],
        hessians: [&mut [T]; 6],
    ) {
        let length = self.coefficient_count() * self.check_points(x, y, z);
        check_length("values", length, values.len());
        for g in &gradients {
            check_length("gradients", length, g.len());
        }
        for h in &hessians {
            check_length("Hessians", length, h.len());
        }
        self.arch.dispatch(Batch(HessiansRows { basis: self, d: [x, y, z], values, gradients, hessians }));
    }

    #[track_caller]
    fn check_points(&self, x: &[T], y: &[T], z: &[T]) -> usize {
        check_length("y coordinates", x.len(), y.len());
        check_length("z coordinates", x.len(), z.len());
        x.len()
    }
}

pub(in crate::sh) const fn is_narrow<T>() -> bool {
    size_of::<T>() == 4
}

/// Work on many points, compiled for a number of lanes.
///
/// Jobs are types and not closures: `pulp` compiles for an instruction set only what is inlined into its dispatch.
trait Job {
    type Scalar;
    type Output;
    fn run<const L: usize>(self) -> Self::Output;
}

struct Batch<J>(J);

impl<J: Job> WithSimd for Batch<J> {
    type Output = J::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> J::Output {
        align_stack();
        // Two registers of AVX2 for each quantity: enough chains to hide latency, few enough to stay in registers.
        if is_narrow::<J::Scalar>() { self.0.run::<16>() } else { self.0.run::<8>() }
    }
}

/// L values from `first`, padded with `pad` beyond the end.
#[inline(always)]
pub(in crate::sh) fn load<T: Real, const L: usize>(values: &[T], first: usize, pad: T) -> [T; L] {
    let rest = &values[first..];
    match rest.first_chunk::<L>() {
        Some(block) => *block,
        None => {
            let mut block = [pad; L];
            block[..rest.len()].copy_from_slice(rest);
            block
        }
    }
}

/// L points from `first`, padded with the north pole.
#[inline(always)]
pub(in crate::sh) fn load_points<T: Real, const L: usize>(d: [&[T]; 3], first: usize) -> [[T; L]; 3] {
    [load(d[0], first, T::zero()), load(d[1], first, T::zero()), load(d[2], first, T::one())]
}

struct EvalRows<'a, T> {
    basis: &'a Basis<T>,
    d: [&'a [T]; 3],
    out: &'a mut [T],
}

impl<T: Real> Job for EvalRows<'_, T> {
    type Scalar = T;
    type Output = ();

    #[inline(always)]
    fn run<const L: usize>(self) {
        let whole = self.d[0].len() >= L;
        match self.basis.bands {
            1 if whole => self.few_rows::<L, 1, 1>(),
            2 if whole => self.few_rows::<L, 2, 4>(),
            3 if whole => self.few_rows::<L, 3, 9>(),
            4 if whole => self.few_rows::<L, 4, 16>(),
            5 => self.blocks::<L, 5>(),
            6 => self.blocks::<L, 6>(),
            _ => self.blocks::<L, 0>(),
        }
    }
}

impl<T: Real> EvalRows<'_, T> {
    /// B bands, N = B² rows, at least L points; the last block overlaps the one before.
    #[inline(always)]
    fn few_rows<const L: usize, const B: usize, const N: usize>(self) {
        let Self { basis, d, out } = self;
        let points = d[0].len();
        let mut rows = out.chunks_exact_mut(points);
        let mut store = StoreFewRows { rows: [(); N].map(|()| rows.next().expect("N rows")), first: 0 };
        for first in (0..points).step_by(L) {
            store.first = first.min(points - L);
            let [x, y, z] = load_points::<T, L>(d, store.first);
            walk_fixed::<T, L, B, _>(&basis.table, B, [&x, &y, &z], &mut store);
        }
    }

    /// B bands, or any number where B is 0.
    #[inline(always)]
    fn blocks<const L: usize, const B: usize>(self) {
        let Self { basis, d, out } = self;
        let stride = d[0].len();
        for first in (0..stride).step_by(L) {
            let [x, y, z] = load_points::<T, L>(d, first);
            let count = L.min(stride - first);
            // A width that is known unrolls.
            if count == L {
                let mut store = StoreRows { out: &mut *out, stride, first, count: L };
                walk_fixed::<T, L, B, _>(&basis.table, basis.bands, [&x, &y, &z], &mut store);
            } else {
                let mut store = StoreRows { out: &mut *out, stride, first, count };
                walk(&basis.table, basis.bands, [&x, &y, &z], &mut store);
            }
        }
    }
}

struct EvalPoints<'a, T> {
    basis: &'a Basis<T>,
    d: [&'a [T]; 3],
    out: &'a mut [T],
}

impl<T: Real> Job for EvalPoints<'_, T> {
    type Scalar = T;
    type Output = ();

    #[inline(always)]
    fn run<const L: usize>(self) {
        match self.basis.bands {
            1 => self.blocks::<L, 1>(&mut [[T::zero(); L]; 1]),
            2 => self.blocks::<L, 2>(&mut [[T::zero(); L]; 4]),
            3 => self.blocks::<L, 3>(&mut [[T::zero(); L]; 9]),
            4 => self.blocks::<L, 4>(&mut [[T::zero(); L]; 16]),
            5 => self.blocks::<L, 5>(&mut [[T::zero(); L]; 25]),
            6 => self.blocks::<L, 6>(&mut [[T::zero(); L]; 36]),
            bands => self.blocks::<L, 0>(&mut vec![[T::zero(); L]; bands * bands]),
        }
    }
}

impl<T: Real> EvalPoints<'_, T> {
    /// B bands, or any number where B is 0. Rows of L points are kept, then transposed.
    #[inline(always)]
    fn blocks<const L: usize, const B: usize>(self, values: &mut [[T; L]]) {
        let Self { basis, d, out } = self;
        let stride = values.len();
        for (first, out) in (0..d[0].len()).step_by(L).zip(out.chunks_mut(stride * L)) {
            let [x, y, z] = load_points::<T, L>(d, first);
            walk_fixed::<T, L, B, _>(&basis.table, basis.bands, [&x, &y, &z], &mut Keep(&mut *values));
            for (i, out) in out.chunks_exact_mut(stride).enumerate() {
                out.iter_mut().zip(&*values).for_each(|(out, values)| *out = values[i]);
            }
        }
    }
}

struct Reconstruct<'a, T> {
    basis: &'a Basis<T>,
    coefficients: &'a [T],
    d: [&'a [T]; 3],
    out: &'a mut [T],
}

impl<T: Real> Job for Reconstruct<'_, T> {
    type Scalar = T;
    type Output = ();

    #[inline(always)]
    fn run<const L: usize>(self) {
        let Self { basis, coefficients, d, out } = self;
        for (block, out) in out.chunks_mut(L).enumerate() {
            let [x, y, z] = load_points::<T, L>(d, block * L);
            let mut dot = Dot::new(coefficients);
            walk(&basis.table, basis.bands, [&x, &y, &z], &mut dot);
            out.copy_from_slice(&dot.sum[..out.len()]);
        }
    }
}

struct AccumulatePoints<'a, T, const C: usize> {
    basis: &'a Basis<T>,
    d: [&'a [T]; 3],
    weights: [&'a [T]; C],
}

impl<T: Real, const C: usize> Job for AccumulatePoints<'_, T, C> {
    type Scalar = T;
    type Output = Vec<f64>;

    #[inline(always)]
    fn run<const L: usize>(self) -> Vec<f64> {
        /// Points a lane that are summed in T.
        const RUN: usize = 64;
        let Self { basis, d, weights } = self;
        let mut lanes = vec![[T::zero(); L]; basis.coefficient_count() * C];
        let mut sums = vec![0.0; lanes.len()];
        let points = d[0].len();
        for run in (0..points).step_by(RUN * L) {
            for first in (run..points.min(run + RUN * L)).step_by(L) {
                let [x, y, z] = load_points::<T, L>(d, first);
                let zero = [[T::zero(); L]; C];
                let mut block = zero;
                for channel in 0..C {
                    block[channel] = load(weights[channel], first, T::zero());
                }
                let mut sum = Accumulate { lanes: &mut lanes, weights: block, even: zero, odd: zero };
                walk(&basis.table, basis.bands, [&x, &y, &z], &mut sum);
            }
            for (sum, lanes) in sums.iter_mut().zip(&mut lanes) {
                for lane in lanes {
                    *sum += lane.widen();
                    *lane = T::zero();
                }
            }
        }
        sums
    }
}

struct GradientsRows<'a, T> {
    basis: &'a Basis<T>,
    d: [&'a [T]; 3],
    values: &'a mut [T],
    gradients: [&'a mut [T]; 3],
}

impl<T: Real> Job for GradientsRows<'_, T> {
    type Scalar = T;
    type Output = ();

    #[inline(always)]
    fn run<const L: usize>(self) {
        let Self { basis, d, values, gradients } = self;
        let stride = d[0].len();
        let mut rows = GradientRows { values, gradients, stride, first: 0, count: 0 };
        for first in (0..stride).step_by(L) {
            let [x, y, z] = load_points::<T, L>(d, first);
            (rows.first, rows.count) = (first, L.min(stride - first));
            walk_gradient(&basis.table, basis.bands, [&x, &y, &z], &mut rows);
        }
    }
}

struct HessiansRows<'a, T> {
    basis: &'a Basis<T>,
    d: [&'a [T]; 3],
    values: &'a mut [T],
    gradients: [&'a mut [T]; 3],
    hessians: [&'a mut [T]; 6],
}

impl<T: Real> Job for HessiansRows<'_, T> {
    type Scalar = T;
    type Output = ();

    #[inline(always)]
    fn run<const L: usize>(self) {
        let Self { basis, d, values, gradients, hessians } = self;
        let stride = d[0].len();
        let mut rows = HessianRows { values, gradients, hessians, stride, first: 0, count: 0 };
        for first in (0..stride).step_by(L) {
            let [x, y, z] = load_points::<T, L>(d, first);
            (rows.first, rows.count) = (first, L.min(stride - first));
            walk_hessian(&basis.table, basis.bands, [&x, &y, &z], &mut rows);
        }
    }
}
