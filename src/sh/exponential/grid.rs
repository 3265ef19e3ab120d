//! Any function of an expansion, point by point on a grid of rings.

use std::f64::consts::PI;

use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

use super::grid_exp;
use super::series::check_bands;
use crate::error::check_length;
use crate::numeric::GaussLegendre;
use crate::sh::Basis;
use crate::{Error, Real, Result};

/// The most points of a ring.
const MOST_AROUND: usize = 256;
/// The most orders −m…m.
const MOST_ORDERS: usize = 63;

/// h(f) by evaluating f on a grid of the sphere, applying h there and projecting back: the pointwise form, for any h.
///
/// ```math
/// out_i = Σ_p w_p h(f(ω_p)) y_i(ω_p) ≈ ∫ h(f(ω)) y_i(ω) dω               [Sun 2008, eq. 5.15, the integral as a sum]
/// ```
///
/// 2·bands Gauss–Legendre rings of 4·bands points: exact where h(f) y_i has degree up to 4·bands − 1, as for a square;
/// otherwise the more rings the closer ([`with_rings`](Self::with_rings)). Where the products of
/// [`ProductSeries`](super::ProductSeries) are truncated each time, this is truncated once.
///
/// Shapes: f, out: bands², index l(l+1)+m. Calls do not allocate. Cost: counted, for rings R of A points about R
/// (2·bands² + A·bands) multiplications, and R·A calls of h: the sums are separate in z and azimuth, and folded by the
/// symmetries ±x, ±y, ±z of the grid. NaN or infinity anywhere in f, or NaN of h at a point, gives NaN everywhere; so
/// may an f so large that its values overflow (of a largest coefficient above T's largest number over bands²).
///
/// # Example
/// ```
/// use haarmonic::sh::GridFunction;
/// let grid = GridFunction::<f64>::new(2)?;
/// let mut out = [0.0; 4];
/// grid.apply(&[1.0, 0.0, 2.0, 0.0], |f| f * f, &mut out);
/// let want = haarmonic::sh::Square::<f64>::new(2, 2)?;
/// let mut square = [0.0; 4];
/// want.apply(&[1.0, 0.0, 2.0, 0.0], &mut square);
/// assert!(out.iter().zip(square).all(|(a, b)| (a - b).abs() < 1e-14));
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct GridFunction<T> {
    bands: usize,
    around: usize,
    /// For each ring of z > 0, for m = 0…, for l = m…: √2 N P_l^m (N P_l for m = 0).
    legendre: Vec<T>,
    /// For each ring of z > 0: the weight of one of its points.
    weights: Vec<T>,
    /// For m = 0…, for each azimuth of the first quadrant: cos mφ, sin mφ.
    azimuths: Vec<[T; 2]>,
    arch: Arch,
}

impl<T: Real> GridFunction<T> {
    /// The grid of 2·bands rings of 4·bands points.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is not in 1…32.
    pub fn new(bands: usize) -> Result<Self> {
        check_bands(bands)?;
        Self::with_rings(bands, 2 * bands)
    }

    /// A grid of this many rings, each of twice as many points.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is not in 1…32, or `rings` is odd, less than `bands` or more than 128.
    pub fn with_rings(bands: usize, rings: usize) -> Result<Self> {
        check_bands(bands)?;
        if rings < bands || rings > MOST_AROUND / 2 || rings % 2 == 1 {
            let allowed = "even, at least bands and at most 128";
            return Err(Error::OutOfRange { what: "rings", got: rings as f64, allowed });
        }
        let around = 2 * rings;
        let basis = Basis::<f64>::new(bands)?;
        let mut y = vec![0.0; bands * bands];
        let (mut legendre, mut weights) = (Vec::new(), Vec::new());
        let gauss = GaussLegendre::new(rings)?;
        for (&z, &weight) in gauss.nodes().iter().zip(gauss.weights()).filter(|(z, _)| **z > 0.0) {
            basis.eval(&Vector3::new((1.0 - z * z).sqrt(), 0.0, z), &mut y);
            for m in 0..bands {
                legendre.extend((m..bands).map(|l| T::of(y[l * l + l + m])));
            }
            weights.push(T::of(weight * 2.0 * PI / around as f64));
        }
        let azimuth = |m: usize, a: usize| {
            let (sin, cos) = (m as f64 * (a as f64 + 0.5) * 2.0 * PI / around as f64).sin_cos();
            [T::of(cos), T::of(sin)]
        };
        let azimuths = (0..bands).flat_map(|m| (0..around / 4).map(move |a| azimuth(m, a))).collect();
        Ok(Self { bands, around, legendre, weights, azimuths, arch: Arch::new() })
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// The number of points.
    pub fn points(&self) -> usize {
        2 * self.weights.len() * self.around
    }

    /// `out` = h(f).
    ///
    /// # Panics
    /// If `f.len()` or `out.len()` is not bands².
    #[track_caller]
    pub fn apply(&self, f: &[T], h: impl Fn(T) -> T, out: &mut [T]) {
        self.apply_batch(1, f, h, out);
    }

    /// `count` expansions at once, coefficient-major: coefficient i of vector v is at i·`count` + v. The same bits as
    /// [`apply`](Self::apply).
    ///
    /// # Panics
    /// If `f.len()` or `out.len()` is not `count` times bands².
    #[track_caller]
    pub fn apply_batch(&self, count: usize, f: &[T], h: impl Fn(T) -> T, out: &mut [T]) {
        self.run(count, f, &Closure(h), out);
    }

    /// exp(f) with the vectorised exp, whose range it has: values stay finite.
    #[track_caller]
    pub(super) fn exp(&self, count: usize, f: &[T], out: &mut [T]) {
        self.run(count, f, &Exp, out);
    }

    #[track_caller]
    fn run(&self, count: usize, f: &[T], function: &impl Pointwise<T>, out: &mut [T]) {
        check_length("expansions", (self.bands * self.bands).saturating_mul(count), f.len());
        check_length("functions of them", (self.bands * self.bands).saturating_mul(count), out.len());
        match count {
            1 => self.sized::<1>(count, f, function, out),
            _ if size_of::<T>() == 4 => self.sized::<16>(count, f, function, out),
            _ => self.sized::<8>(count, f, function, out),
        }
    }

    fn sized<const L: usize>(&self, count: usize, f: &[T], function: &impl Pointwise<T>, out: &mut [T]) {
        let mut run = |buffers: &mut [[T; L]]| {
            self.arch.dispatch(Job { grid: self, count, f, function, out: &mut *out, buffers });
        };
        // Of two sizes, so that small ones need not clear the most.
        match self.bands {
            0..=6 => run(&mut [[T::zero(); L]; 72]),
            _ => run(&mut [[T::zero(); L]; 2048]),
        }
    }
}

/// A function of values that is inlined where it is used.
trait Pointwise<T> {
    /// Scales expansions down whose values would overflow and be NaN, if the function has long come to its end there.
    fn tame<const L: usize>(&self, _expansions: &mut [[T; L]]) {}
    fn map<const L: usize>(&self, values: &mut [[T; L]]);
}

struct Closure<H>(H);

impl<T: Real, H: Fn(T) -> T> Pointwise<T> for Closure<H> {
    #[inline(always)]
    fn map<const L: usize>(&self, values: &mut [[T; L]]) {
        values.as_flattened_mut().iter_mut().for_each(|x| *x = (self.0)(*x));
    }
}

struct Exp;

impl<T: Real> Pointwise<T> for Exp {
    /// e^x is at its ends beyond ±708, so that only values within rounding of 0 tell a coefficient of 1e30 from a
    /// larger one; sums of up to 1e8 such terms are finite.
    #[inline(always)]
    fn tame<const L: usize>(&self, expansions: &mut [[T; L]]) {
        let most = T::of(1e30);
        for lane in 0..L {
            let largest = expansions.iter().fold(T::zero(), |m, row| m.max(row[lane].abs()));
            // An infinity becomes NaN, as the NaN of its vector is.
            if largest > most {
                expansions.iter_mut().for_each(|row| row[lane] = row[lane] / largest * most);
            }
        }
    }

    #[inline(always)]
    fn map<const L: usize>(&self, values: &mut [[T; L]]) {
        values.as_flattened_mut().iter_mut().for_each(|x| *x = grid_exp::exp(*x));
    }
}

/// A batch in blocks of L vectors.
struct Job<'a, T, H, const L: usize> {
    grid: &'a GridFunction<T>,
    count: usize,
    f: &'a [T],
    function: &'a H,
    out: &'a mut [T],
    /// A block of coefficients of f, one of the results.
    buffers: &'a mut [[T; L]],
}

impl<T: Real, H: Pointwise<T>, const L: usize> WithSimd for Job<'_, T, H, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { grid, count, f, function, out, buffers } = self;
        let size = grid.bands * grid.bands;
        let (input, output) = buffers[..2 * size].split_at_mut(size);
        let (mut values, mut rings) = ([[T::zero(); L]; MOST_AROUND], [[[T::zero(); L]; MOST_ORDERS]; 2]);
        for first in (0..count).step_by(L) {
            let width = L.min(count - first);
            for (to, from) in input.iter_mut().zip(f.chunks_exact(count)) {
                to[..width].copy_from_slice(&from[first..first + width]);
            }
            function.tame(input);
            // 0, or NaN for the lanes that have NaN or infinity: of infinity h may make anything.
            let mut start = [T::zero(); L];
            for row in &*input {
                for i in 0..L {
                    start[i] += row[i] * T::zero();
                }
            }
            output.fill(start);
            let per_ring = grid.bands * (grid.bands + 1) / 2;
            for (legendre, &weight) in grid.legendre.chunks_exact(per_ring).zip(&grid.weights) {
                to_rings(grid.bands, legendre, input, &mut rings);
                for ring in &mut rings {
                    let values = &mut values[..grid.around];
                    to_points(grid, ring, values);
                    function.map(values);
                    from_points(grid, values, weight, ring);
                }
                from_rings(grid.bands, legendre, &rings, output);
            }
            for (from, to) in output.iter().zip(out.chunks_exact_mut(count)) {
                to[first..first + width].copy_from_slice(&from[..width]);
            }
        }
    }
}

/// Σ_l f_{l,±m} P_l^m on the rings at z and −z, by P(−z) = (−1)^{l−m} P(z). Order m is at bands − 1 + m.
#[inline(always)]
fn to_rings<T: Real, const L: usize>(
    bands: usize,
    legendre: &[T],
    f: &[[T; L]],
    rings: &mut [[[T; L]; MOST_ORDERS]; 2],
) {
    let mut next = 0;
    for m in 0..bands {
        let (mut cosine, mut sine) = ([[T::zero(); L]; 2], [[T::zero(); L]; 2]);
        for l in m..bands {
            let (p, parity) = (legendre[next], (l - m) % 2);
            next += 1;
            let (plus, minus) = (&f[l * l + l + m], &f[l * l + l - m]);
            for i in 0..L {
                cosine[parity][i] += p * plus[i];
                sine[parity][i] += p * minus[i];
            }
        }
        for i in 0..L {
            // The cosine last: at m = 0 both have one place.
            rings[0][bands - 1 - m][i] = sine[0][i] + sine[1][i];
            rings[1][bands - 1 - m][i] = sine[0][i] - sine[1][i];
            rings[0][bands - 1 + m][i] = cosine[0][i] + cosine[1][i];
            rings[1][bands - 1 + m][i] = cosine[0][i] - cosine[1][i];
        }
    }
}

/// The inverse step: adds Σ_rings P_l^m times the orders to the coefficients.
#[inline(always)]
fn from_rings<T: Real, const L: usize>(
    bands: usize,
    legendre: &[T],
    rings: &[[[T; L]; MOST_ORDERS]; 2],
    out: &mut [[T; L]],
) {
    let mut next = 0;
    for m in 0..bands {
        let (mut cosine, mut sine) = ([[T::zero(); L]; 2], [[T::zero(); L]; 2]);
        let [above, below] = rings;
        for i in 0..L {
            let (a, b) = (above[bands - 1 + m][i], below[bands - 1 + m][i]);
            (cosine[0][i], cosine[1][i]) = (a + b, a - b);
            let (a, b) = (above[bands - 1 - m][i], below[bands - 1 - m][i]);
            (sine[0][i], sine[1][i]) = (a + b, a - b);
        }
        for l in m..bands {
            let (p, parity) = (legendre[next], (l - m) % 2);
            next += 1;
            for i in 0..L {
                out[l * l + l + m][i] += p * cosine[parity][i];
            }
            if m > 0 {
                for i in 0..L {
                    out[l * l + l - m][i] += p * sine[parity][i];
                }
            }
        }
    }
}

/// From the orders of a ring to its points, a quarter each at φ, π − φ, −φ, π + φ.
///
/// With c_e, c_o, s_e, s_o the sums over even and odd m of cos mφ and sin mφ, the four are c_e + c_o + s_e + s_o,
/// c_e − c_o − s_e + s_o, c_e + c_o − s_e − s_o, c_e − c_o + s_e − s_o.
#[inline(always)]
fn to_points<T: Real, const L: usize>(grid: &GridFunction<T>, orders: &[[T; L]; MOST_ORDERS], values: &mut [[T; L]]) {
    let (bands, quarter) = (grid.bands, grid.around / 4);
    for a in 0..quarter {
        let (mut c, mut s) = ([[T::zero(); L]; 2], [[T::zero(); L]; 2]);
        c[0] = orders[bands - 1];
        for m in 1..bands {
            let [cos, sin] = grid.azimuths[m * quarter + a];
            let (plus, minus) = (&orders[bands - 1 + m], &orders[bands - 1 - m]);
            for i in 0..L {
                c[m % 2][i] += cos * plus[i];
                s[m % 2][i] += sin * minus[i];
            }
        }
        for i in 0..L {
            let (sum, difference) = (c[0][i] + c[1][i], c[0][i] - c[1][i]);
            let (sines, other) = (s[0][i] + s[1][i], s[0][i] - s[1][i]);
            values[a][i] = sum + sines;
            values[quarter + a][i] = difference - other;
            values[2 * quarter + a][i] = sum - sines;
            values[3 * quarter + a][i] = difference + other;
        }
    }
}

/// The inverse step: weight · Σ over the points of the value times cos mφ, sin mφ.
#[inline(always)]
fn from_points<T: Real, const L: usize>(
    grid: &GridFunction<T>,
    values: &mut [[T; L]],
    weight: T,
    orders: &mut [[T; L]; MOST_ORDERS],
) {
    let (bands, quarter) = (grid.bands, grid.around / 4);
    for a in 0..quarter {
        for i in 0..L {
            let v = [0, 1, 2, 3].map(|q| weight * values[q * quarter + a][i]);
            let (p, q) = (v[0] + v[2], v[1] + v[3]);
            let (r, s) = (v[0] - v[2], v[1] - v[3]);
            // Of cosines of even and odd m, of sines of even and odd m.
            values[a][i] = p + q;
            values[quarter + a][i] = p - q;
            values[2 * quarter + a][i] = r - s;
            values[3 * quarter + a][i] = r + s;
        }
    }
    for m in 0..bands {
        let (mut cosine, mut sine) = ([T::zero(); L], [T::zero(); L]);
        let (of_cosines, of_sines) = values[m % 2 * quarter..].split_at(2 * quarter);
        let azimuths = &grid.azimuths[m * quarter..][..quarter];
        for (&[cos, sin], (x, y)) in azimuths.iter().zip(of_cosines.iter().zip(of_sines)) {
            for i in 0..L {
                cosine[i] += cos * x[i];
                sine[i] += sin * y[i];
            }
        }
        orders[bands - 1 - m] = sine;
        orders[bands - 1 + m] = cosine;
    }
}
