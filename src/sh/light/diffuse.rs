//! Light as a diffuse surface weighs it, for every normal.

use std::ops::Range;

use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

use crate::approx_eq::approx_by_parts;
use crate::error::check_length;
use crate::sh::{Basis, Product, Zonal, bands_of};
use crate::sphere::{CubeGrid, Face};
use crate::{Error, Real, Result};

/// L_H(N) = L ∗ H(N): a light times the clamped cosine about any normal, to be dotted with visibility.
///
/// ```math
/// H(N) = 1/π ∫ max(s·N, 0) y(s) ds,  L_H(N)_k = Σ_ij Γ_ijk L_i H(N)_j                     [Sun 2008, eq. 5.14]
/// ```
///
/// Since H(N) = (Â_l/π) y(N), L_H is linear in y(N): one matrix, without the columns of the odd degrees from 3, of
/// which there are none in the cosine. The dot product of L_H(N) with the visibility g at a point is what a white plane
/// of normal N reflects there: radiance, H has the 1/π. Without blockers that is E/π. A [`table`](Self::table) is
/// faster where it is exact enough.
///
/// Shapes: light: bands²; out: bands_out². `bands_cosine` cuts H off: the thesis has the light's own bands. Up to
/// bands + bands_out − 1 more of them make the result the projection of the light times the exact cosine, and none
/// beyond change it.
/// Accuracy: 4 eps bands ‖L‖. Cost, counted: an evaluation of the basis and bands_out² multiplications for each column
/// in use (of 3, 4, 5, 6 bands: 9, 9, 18, 18).
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Vector3, sh::DiffuseLight};
/// let white = [(4.0 * std::f64::consts::PI).sqrt(), 0.0, 0.0, 0.0];
/// let light = DiffuseLight::new(&white, 2, 2)?;
/// let (mut out, mut scratch) = ([0.0; 4], [0.0; 4]);
/// light.eval(&Vector3::z(), &mut out, &mut scratch);
/// // Nothing in the way: visibility 1 is √4π in the first coefficient.
/// assert!((out[0] * white[0] - 1.0).abs() < 1e-15);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct DiffuseLight<T> {
    basis: Basis<T>,
    bands_out: usize,
    /// Which y(N) there are columns for.
    used: Vec<usize>,
    /// Column-major: bands_out² entries for each in `used`.
    matrix: Vec<T>,
    arch: Arch,
}

impl<T: Real> DiffuseLight<T> {
    /// The light of these coefficients against a cosine of `bands_cosine`, in `bands_out`.
    ///
    /// # Errors
    /// [`Error::Length`] if `light.len()` is not a square, [`Error::OutOfRange`] if the matrix would have more than 2²⁶
    /// entries (it is bands_cosine² by bands_out²: 90 by 90 bands), else as [`Product::new`] and [`Basis::new`].
    pub fn new(light: &[T], bands_cosine: usize, bands_out: usize) -> Result<Self> {
        let bands = bands_of(light.len()).ok_or(Error::Length {
            what: "coefficients of a light, a square number",
            expected: light.len().isqrt().pow(2),
            got: light.len(),
        })?;
        let basis = Basis::new(bands_cosine)?;
        let product = Product::<f64>::new(bands, bands_cosine, bands_out)?;
        let (rows, columns) = (bands_out * bands_out, bands_cosine * bands_cosine);
        if rows * columns > 1 << 26 {
            let allowed = "at most 8192 (the matrix has its square in entries)";
            let got = (bands_out * bands_cosine) as f64;
            return Err(Error::OutOfRange { what: "bands of the cosine times bands of the result", got, allowed });
        }
        let mut full = vec![0.0; rows * columns];
        product.matrix(&light.iter().map(|c| c.widen()).collect::<Vec<_>>(), &mut full);
        let cosine = Zonal::<f64>::clamped_cosine(bands_cosine)?.scaled(std::f64::consts::FRAC_1_PI);
        let factor = |j: usize| cosine.factors()[j.isqrt()];
        let used: Vec<usize> = (0..columns).filter(|&j| factor(j) != 0.0).collect();
        let entries = used.iter().flat_map(|&j| (0..rows).map(move |i| (i, j)));
        let matrix = entries.map(|(i, j)| T::of(full[i * columns + j] * factor(j))).collect();
        Ok(Self { basis, bands_out, used, matrix, arch: Arch::new() })
    }

    /// The bands of the cosine and of the result.
    #[inline]
    pub fn bands(&self) -> [usize; 2] {
        [self.basis.bands(), self.bands_out]
    }

    /// How long the scratch of [`eval`](Self::eval) is: bands_cosine².
    #[inline]
    pub fn scratch_len(&self) -> usize {
        self.basis.coefficient_count()
    }

    /// L_H at a unit normal.
    ///
    /// # Panics
    /// If `out.len()` is not bands_out² or `scratch.len()` not [`scratch_len`](Self::scratch_len).
    #[track_caller]
    pub fn eval(&self, normal: &Vector3<T>, out: &mut [T], scratch: &mut [T]) {
        check_length("light at a normal", self.bands_out * self.bands_out, out.len());
        self.basis.eval(normal, scratch);
        self.arch.dispatch(Columns { matrix: &self.matrix, used: &self.used, y: scratch, out });
    }

    /// L_H at many unit normals, coefficient-major: coefficient i of normal v at i·count + v. The same bits as
    /// [`eval`](Self::eval).
    ///
    /// # Panics
    /// If the slices of normals differ in length, `out.len()` is not bands_out² times it, or `scratch.len()` not
    /// [`batch_scratch_len`](Self::batch_scratch_len).
    #[track_caller]
    pub fn eval_batch(&self, normals: [&[T]; 3], out: &mut [T], scratch: &mut [T]) {
        let count = self.check_batch(normals, scratch);
        check_length("light at normals", square(self.bands_out).saturating_mul(count), out.len());
        for first in (0..count).step_by(BLOCK) {
            let lanes = BLOCK.min(count - first);
            let y = self.basis_at(normals, first..first + lanes, scratch);
            self.arch.dispatch(Block { lights: [self], lanes, y, sink: Store { out: &mut *out, count, first } });
        }
    }

    /// What a white plane of this normal reflects of the light where `visibility` (bands_out²) is seen: L_H(N) dotted
    /// with it.
    ///
    /// ```math
    /// 1/π ∫ L(s) V(s) max(s·N, 0) ds = Σ_k L_H(N)_k V_k
    /// ```
    ///
    /// # Panics
    /// If `visibility.len()` is not bands_out² or `scratch.len()` not [`batch_scratch_len`](Self::batch_scratch_len).
    #[track_caller]
    pub fn integral(&self, normal: &Vector3<T>, visibility: &[T], scratch: &mut [T]) -> T {
        let normals = [0, 1, 2].map(|axis| std::slice::from_ref(&normal[axis]));
        let mut out = [T::zero()];
        Self::integral_batch([self], normals, visibility, [&mut out], scratch);
        out[0]
    }

    /// [`integral`](Self::integral) for many normals, each with its visibility, in any number of channels, such as the
    /// lights of red, green and blue: coefficient i of the visibility at normal v is at i·count + v.
    ///
    /// The channels share the evaluation of the basis, and no L_H is stored. The same bits as
    /// [`integral`](Self::integral).
    ///
    /// # Panics
    /// If the channels differ in bands, the slices of normals in length, `visibility.len()` is not bands_out² times it,
    /// an `out` is not as long as they are, or `scratch.len()` is not [`batch_scratch_len`](Self::batch_scratch_len).
    ///
    /// # Example
    /// ```
    /// use haarmonic::{nalgebra::Vector3, sh::DiffuseLight};
    /// let one = (4.0 * std::f64::consts::PI).sqrt();
    /// let lights = [[one, 0.0, 0.0, 0.0], [0.5 * one, 0.0, 0.0, 0.0]];
    /// let [red, green] = lights.map(|light| DiffuseLight::new(&light, 2, 2).unwrap());
    /// // Up and down, all of the sky and none of it.
    /// let visibility = [one, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    /// let ([mut r, mut g], mut scratch) = ([[0.0; 2]; 2], vec![0.0; red.batch_scratch_len()]);
    /// let normals = [&[0.0, 0.0][..], &[0.0, 0.0], &[1.0, -1.0]];
    /// DiffuseLight::integral_batch([&red, &green], normals, &visibility, [&mut r, &mut g], &mut scratch);
    /// assert!((r[0] - 1.0).abs() < 1e-15 && (g[0] - 0.5).abs() < 1e-15 && r[1] == 0.0);
    /// ```
    #[track_caller]
    pub fn integral_batch<const C: usize>(
        channels: [&Self; C],
        normals: [&[T]; 3],
        visibility: &[T],
        mut out: [&mut [T]; C],
        scratch: &mut [T],
    ) {
        let Some(first_channel) = channels.first() else { return };
        let count = first_channel.check_batch(normals, scratch);
        check_length("visibility", square(first_channel.bands_out).saturating_mul(count), visibility.len());
        for (channel, out) in channels.iter().zip(&out) {
            check_length("bands of the cosine", first_channel.basis.bands(), channel.basis.bands());
            check_length("bands of the result", first_channel.bands_out, channel.bands_out);
            check_length("integrals", count, out.len());
        }
        for first in (0..count).step_by(BLOCK) {
            let lanes = BLOCK.min(count - first);
            let y = first_channel.basis_at(normals, first..first + lanes, scratch);
            let out = out.each_mut().map(|out| &mut out[first..first + lanes]);
            let sink = Dot { visibility, count, first, sums: [[T::zero(); BLOCK]; C], out };
            first_channel.arch.dispatch(Block { lights: channels, lanes, y, sink });
        }
    }

    /// How long the scratch of batches is: 16 bands_cosine².
    #[inline]
    pub fn batch_scratch_len(&self) -> usize {
        BLOCK * self.basis.coefficient_count()
    }

    #[track_caller]
    fn check_batch(&self, normals: [&[T]; 3], scratch: &[T]) -> usize {
        for coordinates in normals {
            check_length("coordinates of normals", normals[0].len(), coordinates.len());
        }
        check_length("scratch", self.batch_scratch_len(), scratch.len());
        normals[0].len()
    }

    /// The basis at some normals, a row of them for each coefficient.
    fn basis_at<'a>(&self, normals: [&[T]; 3], range: Range<usize>, scratch: &'a mut [T]) -> &'a [T] {
        let [x, y, z] = normals.map(|n| &n[range.clone()]);
        let scratch = &mut scratch[..self.basis.coefficient_count() * range.len()];
        self.basis.eval_batch(x, y, z, scratch);
        scratch
    }

    /// L_H tabulated over the sphere of normals, `side`² cells on each face of a cube.
    ///
    /// Accuracy: the error over the largest |L_H| is about 0.7/side² for 2 bands, 1/side² for 3, 1.4/side² for 4 to 6,
    /// of a light of equal power in all degrees (side 32, 6 bands: 1.2e-3).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] as [`CubeGrid::new`], or if the table would have more than 2²⁸ numbers: 6 (side + 1)²
    /// bands_out².
    pub fn table(&self, side: usize) -> Result<DiffuseLightTable<T>> {
        let grid = CubeGrid::new(side)?;
        let count = self.bands_out * self.bands_out;
        if 6 * (side + 1) * (side + 1) > (1 << 28) / count {
            let allowed = "so small that 6 (side + 1)² bands² is at most 2²⁸";
            return Err(Error::OutOfRange { what: "side of a table of diffuse light", got: side as f64, allowed });
        }
        let mut values = vec![T::zero(); 6 * (side + 1) * (side + 1) * count];
        let mut scratch = vec![T::zero(); self.scratch_len()];
        for (node, out) in values.chunks_exact_mut(count).enumerate() {
            let (x, y) = (node % (side + 1), node / (side + 1) % (side + 1));
            let face = Face::ALL[node / ((side + 1) * (side + 1))];
            let normal = face.point(grid.line(x), grid.line(y)).normalize();
            self.eval(&normal.map(T::of), out, &mut scratch);
        }
        Ok(DiffuseLightTable { side, count, values })
    }
}

/// out = matrix · y.
struct Columns<'a, T> {
    matrix: &'a [T],
    used: &'a [usize],
    y: &'a [T],
    out: &'a mut [T],
}

impl<T: Real> WithSimd for Columns<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { matrix, used, y, out } = self;
        out.fill(T::zero());
        for (column, &j) in matrix.chunks_exact(out.len()).zip(used) {
            let y = y[j];
            for (out, m) in out.iter_mut().zip(column) {
                *out += *m * y;
            }
        }
    }
}

/// Normals that are done together.
const BLOCK: usize = 16;

fn square(bands: usize) -> usize {
    bands * bands
}

/// Takes coefficients of L_H of a block of normals, in the order of the coefficients.
trait Sink<T> {
    fn take(&mut self, channel: usize, coefficient: usize, lanes: usize, values: &[T; BLOCK]);
    fn end(self, lanes: usize);
}

/// To their places.
struct Store<'a, T> {
    out: &'a mut [T],
    count: usize,
    first: usize,
}

impl<T: Real> Sink<T> for Store<'_, T> {
    #[inline(always)]
    fn take(&mut self, _: usize, coefficient: usize, lanes: usize, values: &[T; BLOCK]) {
        self.out[coefficient * self.count + self.first..][..lanes].copy_from_slice(&values[..lanes]);
    }

    #[inline(always)]
    fn end(self, _: usize) {}
}

/// Into dot products with visibility.
struct Dot<'a, T, const C: usize> {
    visibility: &'a [T],
    count: usize,
    first: usize,
    sums: [[T; BLOCK]; C],
    out: [&'a mut [T]; C],
}

impl<T: Real, const C: usize> Sink<T> for Dot<'_, T, C> {
    #[inline(always)]
    fn take(&mut self, channel: usize, coefficient: usize, lanes: usize, values: &[T; BLOCK]) {
        let row = &self.visibility[coefficient * self.count + self.first..][..lanes];
        let sums = &mut self.sums[channel];
        match row.first_chunk::<BLOCK>() {
            Some(row) => (0..BLOCK).for_each(|i| sums[i] += values[i] * row[i]),
            None => (0..lanes).for_each(|i| sums[i] += values[i] * row[i]),
        }
    }

    #[inline(always)]
    fn end(self, lanes: usize) {
        for (out, sums) in self.out.into_iter().zip(&self.sums) {
            out.copy_from_slice(&sums[..lanes]);
        }
    }
}

/// L_H of each light at a block of normals, given the basis there.
struct Block<'a, T, K, const C: usize> {
    lights: [&'a DiffuseLight<T>; C],
    lanes: usize,
    y: &'a [T],
    sink: K,
}

impl<T: Real, K: Sink<T>, const C: usize> WithSimd for Block<'_, T, K, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { lights, lanes, y, mut sink } = self;
        for (channel, light) in lights.into_iter().enumerate() {
            let rows = square(light.bands_out);
            for coefficient in 0..rows {
                let mut sums = [T::zero(); BLOCK];
                for (column, &j) in light.matrix.chunks_exact(rows).zip(&light.used) {
                    let m = column[coefficient];
                    let y = &y[j * lanes..][..lanes];
                    match y.first_chunk::<BLOCK>() {
                        Some(y) => (0..BLOCK).for_each(|i| sums[i] += m * y[i]),
                        None => (0..lanes).for_each(|i| sums[i] += m * y[i]),
                    }
                }
                sink.take(channel, coefficient, lanes, &sums);
            }
        }
        sink.end(lanes);
    }
}

/// [`DiffuseLight`] at the nodes of a grid on the cube, bilinear between them; built by [`DiffuseLight::table`].
///
/// Continuous: nodes lie on the cube's edges, where adjacent faces hold the same values. At the nodes it is exact.
#[derive(Debug, Clone, PartialEq)]
pub struct DiffuseLightTable<T> {
    side: usize,
    /// Coefficients of a node.
    count: usize,
    /// Node after node: faces in the order of [`Face::ALL`], each side + 1 rows of side + 1.
    values: Vec<T>,
}

impl<T: Real> DiffuseLightTable<T> {
    /// Cells along an edge of a face.
    #[inline]
    pub fn side(&self) -> usize {
        self.side
    }

    /// L_H at a normal, which need not be unit. NaN gives NaN.
    ///
    /// # Panics
    /// If `out.len()` is not that of the light at a normal.
    #[track_caller]
    pub fn lookup(&self, normal: &Vector3<T>, out: &mut [T]) {
        check_length("light at a normal", self.count, out.len());
        let (face, u, v) = Face::locate(&normal.map(T::widen));
        let place = |t: f64| {
            let at = (t + 1.0) * 0.5 * self.side as f64;
            let cell = (at as usize).min(self.side - 1);
            (cell, at - cell as f64)
        };
        let ((x, right), (y, down)) = (place(u), place(v));
        let row = (self.side + 1) * self.count;
        let first = face as usize * (self.side + 1) * row + y * row + x * self.count;
        let weights =
            [(1.0 - right) * (1.0 - down), right * (1.0 - down), (1.0 - right) * down, right * down].map(T::of);
        let [above, below] = [first, first + row].map(|at| self.values[at..at + 2 * self.count].split_at(self.count));
        for (i, out) in out.iter_mut().enumerate() {
            *out = (weights[0] * above.0[i] + weights[1] * above.1[i])
                + (weights[2] * below.0[i] + weights[3] * below.1[i]);
        }
    }
}

approx_by_parts!([T] DiffuseLightTable<T>, T, |t| close [&t.values] same [t.side]);
