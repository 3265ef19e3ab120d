//! Rotation by sampling, for few bands: the rotated function at fixed directions d_i, then the coefficients that have
//! these samples.
//!
//! ```math
//! g_{l,i} = Σ_m f_{lm} y_{lm}(R⁻¹ d_i),  out_l = B_l g_l,  B_l = [y_{lm}(d_i)]⁻¹, i ≤ 2l
//! ```
//!
//! It is the transpose of rotating zonal lobes [Nowrouzezahrai et al. 2012]. Lanes are directions first, then orders:
//! no sum across lanes, no root, no axis that can be lost.
//!
//! The directions lie on a cone about z, each a golden angle after the one before, so that any first 2l + 1 of them go
//! round evenly. The condition numbers of [y_{lm}(d_i)] are 4.2, 3.1, 4.7, 4.9, 5.1 for l = 1…5 at [`HEIGHT`].
//!
//! y_{lm} = k_{lm} p_{lm}(z) {Re, Im} (x + iy)^m with monic p:
//!
//! ```math
//! p_{m,m} = 1,  p_{m+1,m} = z,  p_{l+1,m} = z p_{l,m} − β_{l,m} p_{l−1,m},  β_{l,m} = (l² − m²)/(4l² − 1)
//! ```
//!
//! and the k_{lm} go to f.

use std::any::Any;
use std::hint::black_box;

use nalgebra::DMatrix;
use pulp::{Arch, Simd, WithSimd};

use crate::Real;
use crate::numeric::align_stack;
use crate::sh::basis::eval;
use crate::sh::lane::Element;

/// The most bands.
pub(super) const MOST_BANDS: usize = 6;

/// Room for directions and for a column of B, in front: whole registers of any machine.
const ROOM: usize = 16;

/// z of the directions. The worst condition number is 5.1; 5.8 at .15 and 8.9 at .25: on some cones a y_{lm} vanishes.
const HEIGHT: f64 = 0.2;

/// d_i.
fn direction(i: usize, height: f64) -> [f64; 3] {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let (sin, cos) = (i as f64 * golden).sin_cos();
    let radius = (1.0 - height * height).sqrt();
    [radius * cos, radius * sin, height]
}

/// y_{lm}(d_i) of degree l, a row for each i ≤ 2l.
fn values(l: usize, height: f64) -> DMatrix<f64> {
    let rows: Vec<_> = (0..2 * l + 1)
        .map(|i| eval(l + 1, &direction(i, height).into()).expect("a size in range").split_off(l * l))
        .collect();
    DMatrix::from_fn(rows.len(), rows.len(), |i, m| rows[i][m])
}

/// Directions, constants of the basis and inverses.
#[derive(Debug, Clone)]
pub(super) struct Samples<T> {
    /// x and y of the directions.
    round: [[T; ROOM]; 2],
    height: T,
    /// k_{lm} at [m][l].
    scales: [[T; MOST_BANDS]; MOST_BANDS],
    /// β_{l,m} at [m][l].
    steps: [[T; MOST_BANDS]; MOST_BANDS],
    /// Column i of B_l, at its end, in place l² + i.
    columns: [[T; ROOM]; MOST_BANDS * MOST_BANDS],
}

impl<T: Real> Samples<T> {
    pub(super) fn new(bands: usize) -> Self {
        let mut columns = [[T::zero(); ROOM]; MOST_BANDS * MOST_BANDS];
        for l in 1..bands {
            let inverse = values(l, HEIGHT).try_inverse().expect("well conditioned");
            for (to, column) in columns[l * l..].iter_mut().zip(inverse.column_iter()) {
                to[ROOM - (2 * l + 1)..].iter_mut().zip(column.iter()).for_each(|(to, &b)| *to = T::of(b));
            }
        }
        let table = |entry: fn(usize, usize) -> f64| {
            std::array::from_fn(|m| std::array::from_fn(|l| if l < m { T::zero() } else { T::of(entry(l, m)) }))
        };
        Self {
            round: [0, 1].map(|k| std::array::from_fn(|i| T::of(direction(i, HEIGHT)[k]))),
            height: T::of(HEIGHT),
            scales: table(scale),
            steps: table(|l, m| ((l * l) as f64 - (m * m) as f64) / (4.0 * (l * l) as f64 - 1.0)),
            columns,
        }
    }
}

/// k_{lm}: N_{lm} times the leading coefficient (2l − 1)!!/(l − m)! of P_l^m.
fn scale(l: usize, m: usize) -> f64 {
    let mut square = (2 * l + 1) as f64 / (4.0 * std::f64::consts::PI) * if m > 0 { 2.0 } else { 1.0 };
    (1..=l).for_each(|k| square *= ((2 * k - 1) * (2 * k - 1)) as f64);
    (1..=l - m).for_each(|k| square /= k as f64);
    (1..=l + m).for_each(|k| square /= k as f64);
    square.sqrt()
}

/// R, as it is given.
#[derive(Clone, Copy)]
pub(super) enum Pose<'a, T> {
    /// Column by column.
    Matrix(&'a [[T; 3]; 3]),
    /// x, y, z, w, and 2 over their sum of squares.
    Quaternion(&'a [T; 4], T),
}

pub(super) type Run<T> = fn(&Samples<T>, Arch, &Pose<'_, T>, &[T], &mut [T]);

fn run<T: Element, const B: usize>(samples: &Samples<T>, arch: Arch, pose: &Pose<'_, T>, f: &[T], out: &mut [T]) {
    arch.dispatch(Call::<T, B> { samples, pose, f, out });
}

/// The code for `bands`, 2 to [`MOST_BANDS`]; compiled here for `f32` and `f64` once.
pub(super) fn choose<T: Real>(bands: usize) -> Option<Run<T>> {
    fn typed<T: Element>(bands: usize) -> Option<Run<T>> {
        match bands {
            2 => Some(run::<T, 2>),
            3 => Some(run::<T, 3>),
            4 => Some(run::<T, 4>),
            5 => Some(run::<T, 5>),
            6 => Some(run::<T, 6>),
            _ => None,
        }
    }
    let (single, double) = (typed::<f32>(bands), typed::<f64>(bands));
    let found =
        [&single as &dyn Any, &double].into_iter().find_map(|run| run.downcast_ref::<Option<Run<T>>>().copied());
    found.expect("T is f32 or f64")
}

/// One vector of B bands; run by `pulp` with the instructions that the machine has.
struct Call<'a, T, const B: usize> {
    samples: &'a Samples<T>,
    pose: &'a Pose<'a, T>,
    f: &'a [T],
    out: &'a mut [T],
}

impl<T: Element, const B: usize> WithSimd for Call<'_, T, B> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        align_stack();
        let Self { samples, pose, f, out } = self;
        let lanes = T::lanes::<S>();
        let (f, out) = (&f[..B * B], &mut out[..B * B]);
        let mut g = [[T::zero(); ROOM]; B];
        let site = Site::<S, T, B> { simd, samples, pose, f };
        site.sample(0, &mut g);
        if lanes >= 4 {
            // In line, so that the degrees are known.
            if lanes < 2 * B - 1 {
                site.sample(lanes, &mut g);
            }
            if 2 * lanes < 2 * B - 1 {
                site.sample(2 * lanes, &mut g);
            }
        } else {
            let mut first = lanes;
            while first < 2 * B - 1 {
                site.sample(first, &mut g);
                first += lanes;
            }
        }
        // Has the samples written to memory, where a broadcast is a load. Otherwise LLVM takes them out of the
        // registers, two shuffles each.
        black_box(g.as_ptr());
        // Downwards: each register overwrites what the one before left of lower degrees.
        macro_rules! degrees {
            ($($l:literal)*) => {$(
                if B > $l {
                    site.solve::<$l>(&g[$l], out);
                }
            )*};
        }
        degrees!(5 4 3 2 1);
        out[0] = f[0];
    }
}

struct Site<'a, S, T, const B: usize> {
    simd: S,
    samples: &'a Samples<T>,
    pose: &'a Pose<'a, T>,
    f: &'a [T],
}

impl<S: Simd, T: Element, const B: usize> Site<'_, S, T, B> {
    #[inline(always)]
    fn splat(&self, value: T) -> T::Reg<S> {
        T::splat(self.simd, value)
    }

    /// R⁻¹ d_i, from i = `first` on.
    #[inline(always)]
    fn turned(&self, first: usize) -> [T::Reg<S>; 3] {
        let ([x, y], height) = (&self.samples.round, self.samples.height);
        let (x, y) = (T::load(self.simd, &x[first..]), T::load(self.simd, &y[first..]));
        match *self.pose {
            Pose::Matrix(r) => {
                let mut d = [x; 3];
                for k in 0..3 {
                    d[k] = (self.splat(r[k][0]) * x + self.splat(r[k][1]) * y) + self.splat(r[k][2] * height);
                }
                d
            }
            // d + s (u × t − w t), t = u × d.
            Pose::Quaternion(q, s) => {
                let (ux, uy, uz, w) = (self.splat(q[0]), self.splat(q[1]), self.splat(q[2]), self.splat(q[3]));
                let (z, s) = (self.splat(height), self.splat(s));
                let (tx, ty, tz) = (uy * z - uz * y, uz * x - ux * z, ux * y - uy * x);
                let dx = x + s * ((uy * tz - uz * ty) - w * tx);
                let dy = y + s * ((uz * tx - ux * tz) - w * ty);
                let dz = z + s * ((ux * ty - uy * tx) - w * tz);
                [dx, dy, dz]
            }
        }
    }

    /// The samples of a register of directions, from `first` on, of the degrees that want them.
    #[inline(always)]
    fn sample(&self, first: usize, g: &mut [[T; ROOM]; B]) {
        let least = first.div_ceil(2).max(1);
        let [x, y, z] = self.turned(first);
        let square = z * z;
        let mut p = self.polynomials(0, [z, square]);
        let mut sums = [z; B];
        for l in least..B {
            sums[l] = self.splat(self.f[l * (l + 1)]) * p[l];
        }
        let (mut c, mut s) = (x, y);
        macro_rules! orders {
            ($($m:literal)*) => {$(
                if B > $m {
                    if $m > 1 {
                        (c, s) = (c * x - s * y, c * y + s * x);
                    }
                    p = self.polynomials($m, [z, square]);
                    for l in $m.max(least)..B {
                        let centre = l * (l + 1);
                        let wave = self.splat(self.f[centre + $m]) * c + self.splat(self.f[centre - $m]) * s;
                        sums[l] = sums[l] + wave * p[l];
                    }
                }
            )*};
        }
        orders!(1 2 3 4 5);
        for l in least..B {
            T::store(&mut g[l][first..], sums[l]);
        }
    }

    /// k_{lm} p_{lm}.
    #[inline(always)]
    fn polynomials(&self, m: usize, [z, square]: [T::Reg<S>; 2]) -> [T::Reg<S>; B] {
        let (step, scale) = (&self.samples.steps[m], &self.samples.scales[m]);
        let mut p = [z; B];
        if m + 2 < B {
            p[m + 2] = square - self.splat(step[m + 1]);
        }
        if m + 3 < B {
            p[m + 3] = z * (square - self.splat(step[m + 1] + step[m + 2]));
        }
        for l in m + 4..B {
            p[l] = z * p[l - 1] - self.splat(step[l - 1]) * p[l - 2];
        }
        let mut q = [self.splat(scale[m]); B];
        for l in m + 1..B {
            q[l] = self.splat(scale[l]) * p[l];
        }
        q
    }

    /// Degree L of `out`, and something below it.
    #[inline(always)]
    fn solve<const L: usize>(&self, g: &[T; ROOM], out: &mut [T]) {
        let (lanes, size) = (T::lanes::<S>(), 2 * L + 1);
        let columns = &self.samples.columns[L * L..][..size];
        let end = (L + 1) * (L + 1);
        let mut back = 0;
        while back < size {
            let at = ROOM - back - lanes;
            let mut sum = T::load(self.simd, &columns[0][at..]) * self.splat(g[0]);
            for i in 1..size {
                sum = sum + T::load(self.simd, &columns[i][at..]) * self.splat(g[i]);
            }
            if back + lanes <= end {
                T::store(&mut out[end - back - lanes..], sum);
            } else {
                let mut whole = [T::zero(); ROOM];
                T::store(&mut whole, sum);
                out[..end - back].copy_from_slice(&whole[lanes - (end - back)..lanes]);
            }
            back += lanes;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn condition(l: usize, height: f64) -> f64 {
        let singular = values(l, height).singular_values();
        singular.max() / singular.min()
    }

    #[test]
    fn condition_numbers() {
        let want = [4.2, 3.1, 4.7, 4.9, 5.1];
        for (l, want) in (1..).zip(want) {
            let got = condition(l, HEIGHT);
            assert!((got - want).abs() < 0.06, "degree {l}: {got}");
        }
    }

    /// No other height is better by a tenth.
    #[test]
    fn height_is_the_best() {
        let worst = |height: f64| (1..MOST_BANDS).map(|l| condition(l, height)).fold(0.0, f64::max);
        let heights: Vec<_> = (1..100).map(|k| k as f64 / 100.0).collect();
        let best = heights.iter().map(|&h| worst(h)).fold(f64::INFINITY, f64::min);
        assert!(worst(HEIGHT) < 1.1 * best);
    }

    #[test]
    fn columns_are_an_inverse() {
        let samples = Samples::<f64>::new(MOST_BANDS);
        for l in 1..MOST_BANDS {
            let (size, y) = (2 * l + 1, values(l, HEIGHT));
            let b = DMatrix::from_fn(size, size, |m, i| samples.columns[l * l + i][ROOM - size + m]);
            let off = (b * y - DMatrix::identity(size, size)).amax();
            assert!(off < 2e-15, "degree {l}: {off:e}");
        }
    }
}
