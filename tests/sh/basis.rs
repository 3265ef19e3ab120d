//! The spherical harmonic basis against golden values, its naive twin and its theorems.

use haarmonic::Real;
use haarmonic::nalgebra::{Complex, Matrix3, UnitVector3, Vector3};
use haarmonic::reference::sh as naive;
use haarmonic::sh::{
    Basis, Convention, Layout, Normalization, Phase, degree_order, eval, from_complex, index, to_complex,
};
use haarmonic::sphere::{Axes, SphereQuadrature, fibonacci_directions};
use haarmonic::strategies::direction;
use proptest::prelude::*;
use serde_json::Value;
use std::f64::consts::PI;

use crate::support::{HARMONICS, assert_below, cases, coefficients, golden, numbers, worst_of};

fn vector(v: &Value) -> Vector3<f64> {
    Vector3::from_vec(numbers(v))
}

fn narrow<T: Real>(d: &Vector3<f64>) -> Vector3<T> {
    d.map(T::of)
}

/// Poles, places beside them, axes, diagonals and the sphere.
fn directions() -> Vec<UnitVector3<f64>> {
    let mut all = fibonacci_directions(40);
    for z in [1.0, -1.0] {
        for across in [0.0, 1e-300, 1e-20, 1e-8, 1e-4, 1e-2, 0.1, 0.3] {
            all.push(UnitVector3::new_normalize(Vector3::new(across, -0.6 * across, z)));
        }
    }
    for (x, y) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0), (1.0, 1.0), (-1.0, 1e-9)] {
        all.push(UnitVector3::new_normalize(Vector3::new(x, y, 0.0)));
    }
    all
}

fn soa<T: Real>(directions: &[UnitVector3<f64>]) -> [Vec<T>; 3] {
    [0, 1, 2].map(|k| directions.iter().map(|d| T::of(d[k])).collect())
}

#[test]
fn golden_basis() {
    let (mut error, mut error32) = (0f64, 0f64);
    for item in golden(HARMONICS, "sh_basis")["items"].as_array().unwrap() {
        let (d, want) = (vector(&item["dir"]), numbers(&item["y"]));
        for bands in 1..=11 {
            let want = &want[..bands * bands];
            error = error.max(worst_of(eval(bands, &d).unwrap().into_iter().zip(want)));
            error32 =
                error32.max(worst_of(eval(bands, &narrow::<f32>(&d)).unwrap().into_iter().map(f64::from).zip(want)));
        }
        error = error.max(worst_of(naive::basis(11, &UnitVector3::new_unchecked(d)).into_iter().zip(&want)));
    }
    // l² eps times values up to 1.3, l = 10.
    assert_below(error, 2e-14, "f64");
    // The golden direction itself is rounded to f32.
    assert_below(error32, 4e-6, "f32");
}

/// The twin against a third formula: P_l^m = (2m−1)!! sin^m Σ_k g_k g_{l−m−k} cos (l−m−2k)θ, g_k = (m+½)_k/k!.
#[test]
fn twin_against_gegenbauer_sums() {
    let mut error = 0f64;
    for theta in [0.0f64, 1e-5, 0.3, 1.0, 1.5, 2.0, 3.1, PI] {
        for l in 0..=16usize {
            let (sin, cos) = theta.sin_cos();
            let p = naive::associated_legendre(l, cos, sin * sin);
            for m in 0..=l {
                let g = |k: usize| (0..k).map(|j| (m as f64 + 0.5 + j as f64) / (j as f64 + 1.0)).product::<f64>();
                let sum: f64 =
                    (0..=l - m).map(|k| g(k) * g(l - m - k) * (((l - m) as f64 - 2.0 * k as f64) * theta).cos()).sum();
                let odd: f64 = (1..=m).map(|k| (2 * k - 1) as f64).product();
                let ratio: f64 = (l - m + 1..=l + m).map(|k| 1.0 / k as f64).product();
                let want = ((2 * l + 1) as f64 / (4.0 * PI) * ratio).sqrt() * odd * sum * sin.powi(m as i32);
                error = error.max((p[m] * sin.powi(m as i32) - want).abs());
            }
        }
    }
    // The sum cancels from Gegenbauer's value at 1, up to 1.62^16 = 2000 times the result.
    assert_below(error, 2e-13, "Gegenbauer sum");
}

fn twin<T: Real>(bands: usize) -> f64 {
    let basis = Basis::<T>::new(bands).unwrap();
    let mut out = vec![T::zero(); bands * bands];
    let mut error = 0f64;
    for d in directions() {
        let d = narrow::<T>(&d);
        basis.eval(&d, &mut out);
        let exact = UnitVector3::new_unchecked(d.map(|x| x.widen()));
        error = error.max(worst_of(out.iter().map(|y| y.widen()).zip(&naive::basis(bands, &exact))));
    }
    error
}

#[test]
fn twin_f64() {
    for bands in [1, 2, 3, 4, 5, 6, 7, 12, 33, 64] {
        // Half an eps of |ω| moves a value near a pole by l² eps/2 of √(l/2π) or so. Measured: 1.2e-17 to 2.2e-17 times
        // bands^2.5.
        assert_below(twin::<f64>(bands), 1e-16 + 4e-17 * (bands as f64).powf(2.5), &format!("bands {bands}"));
    }
}

/// l = 20…50 in f32, where double factorials overflow. Measured: 2.4e-9 to 6.8e-9 times bands^2.5.
#[test]
fn twin_f32() {
    for bands in [1, 2, 3, 4, 5, 6, 7, 12, 21, 31, 51, 64] {
        assert_below(twin::<f32>(bands), 2.5e-8 + 1.1e-8 * (bands as f64).powf(2.5), &format!("bands {bands}"));
    }
}

/// The largest sizes are finite, and right where closed forms are known: y_{l,0} and y_{l,l} at the poles and the
/// equator.
#[test]
fn largest_bands() {
    fn check<T: Real>(tolerance: f64) {
        let bands = Basis::<T>::max_bands();
        for d in directions() {
            assert!(eval(bands, &narrow::<T>(&d)).unwrap().iter().all(|y| y.widen().abs() < 20.0));
        }
        let l = bands - 1;
        let pole = eval(bands, &Vector3::new(T::zero(), T::zero(), -T::one())).unwrap();
        let equator = eval(bands, &Vector3::new(T::one(), T::zero(), T::zero())).unwrap();
        let ratios = (0..bands).map(|l| {
            let want = ((2 * l + 1) as f64 / (4.0 * PI)).sqrt() * if l % 2 == 0 { 1.0 } else { -1.0 };
            (pole[index(l, 0)].widen() / want, &1.0)
        });
        assert_below(worst_of(ratios), tolerance, "pole");
        let square = (1..=l).map(|k| 1.0 + 0.5 / k as f64).product::<f64>() / (2.0 * PI);
        assert_below((equator[index(l, l as isize)].widen() - square.sqrt()).abs(), tolerance, "equator");
    }
    // At z = ±1 the recurrence has a double root: the error of one step grows linearly, all of them as l² eps/2 at
    // worst (1e-3 at l = 127, 1e-10 at l = 1023); measured 1.7e-5 and 7.4e-12.
    check::<f32>(6e-5);
    check::<f64>(3e-11);
    for bands in [0, Basis::<f32>::max_bands() + 1] {
        assert!(Basis::<f32>::new(bands).is_err());
    }
    assert!(Basis::<f64>::new(1025).is_err());
}

#[test]
fn orthonormal() {
    for bands in [1, 5, 16] {
        let rule = SphereQuadrature::new(2 * (bands - 1)).unwrap();
        let n = bands * bands;
        let mut gram = vec![0.0; n * n];
        let basis = Basis::new(bands).unwrap();
        let mut y = vec![0.0; n];
        for (d, w) in rule.directions().iter().zip(rule.weights()) {
            basis.eval(d, &mut y);
            for i in 0..n {
                for j in 0..n {
                    gram[i * n + j] += w * y[i] * y[j];
                }
            }
        }
        let identity: Vec<f64> = (0..n * n).map(|k| if k / n == k % n { 1.0 } else { 0.0 }).collect();
        assert_below(worst_of(gram.into_iter().zip(&identity)), 5e-14, "Gram matrix");
    }
}

fn batch_forms<T: Real + bits::Bits>() {
    for bands in [1, 2, 3, 4, 5, 6, 7, 10, 20] {
        let basis = Basis::<T>::new(bands).unwrap();
        let n = bands * bands;
        for points in [0, 1, 7, 8, 9, 16, 17, 56] {
            let d: Vec<_> = directions().into_iter().rev().take(points).collect();
            assert_eq!(d.len(), points);
            let [x, y, z] = soa::<T>(&d);
            let c: Vec<T> = coefficients(bands).into_iter().map(T::of).collect();
            let mut one = vec![T::nan(); n];
            let (mut rows, mut by_point) = (vec![T::nan(); n * points], vec![T::nan(); n * points]);
            let mut sums = vec![T::nan(); points];
            basis.eval_batch(&x, &y, &z, &mut rows);
            basis.eval_points(&x, &y, &z, &mut by_point);
            basis.reconstruct(&c, &x, &y, &z, &mut sums);
            let (mut values, mut slopes) = (vec![T::nan(); n], vec![Vector3::from_element(T::nan()); n]);
            let mut value_rows = rows.clone();
            let mut slope_rows = [rows.clone(), rows.clone(), rows.clone()];
            let [gx, gy, gz] = &mut slope_rows;
            basis.gradient_batch([&x, &y, &z], &mut value_rows, [gx, gy, gz]);
            let mut bends = vec![Matrix3::from_element(T::nan()); n];
            let (mut jet_values, mut jet_slopes) = (values.clone(), slopes.clone());
            let mut jet_value_rows = vec![T::nan(); n * points];
            let mut jet_rows: [Vec<T>; 9] = std::array::from_fn(|_| vec![T::nan(); n * points]);
            let [jx, jy, jz, xx, xy, xz, yy, yz, zz] = &mut jet_rows;
            basis.hessian_batch([&x, &y, &z], &mut jet_value_rows, [jx, jy, jz], [xx, xy, xz, yy, yz, zz]);
            for p in 0..points {
                let d = Vector3::new(x[p], y[p], z[p]);
                basis.eval(&d, &mut one);
                basis.gradient(&d, &mut values, &mut slopes);
                basis.hessian(&d, &mut jet_values, &mut jet_slopes, &mut bends);
                assert_eq!(sums[p].bits(), basis.dot(&c, &d).bits());
                for i in 0..n {
                    assert_eq!(one[i].bits(), rows[i * points + p].bits(), "bands {bands}, point {p}, coefficient {i}");
                    assert_eq!(one[i].bits(), by_point[p * n + i].bits());
                    assert_eq!(one[i].bits(), values[i].bits());
                    assert_eq!(one[i].bits(), value_rows[i * points + p].bits());
                    for k in 0..3 {
                        assert_eq!(slopes[i][k].bits(), slope_rows[k][i * points + p].bits());
                        assert_eq!(slopes[i][k].bits(), jet_slopes[i][k].bits());
                        assert_eq!(slopes[i][k].bits(), jet_rows[k][i * points + p].bits());
                    }
                    assert_eq!(one[i].bits(), jet_values[i].bits());
                    assert_eq!(one[i].bits(), jet_value_rows[i * points + p].bits());
                    for (k, at) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate() {
                        assert_eq!(bends[i][at].bits(), jet_rows[3 + k][i * points + p].bits());
                        assert_eq!(bends[i][at].bits(), bends[i][(at.1, at.0)].bits());
                    }
                }
                let want: f64 = c.iter().zip(&one).map(|(c, y)| c.widen() * y.widen()).sum();
                let size: f64 = c.iter().zip(&one).map(|(c, y)| (c.widen() * y.widen()).abs()).sum();
                let error = (sums[p].widen() - want).abs();
                // Two chains of at most `bands` additions; q overshoots y near the poles by less than the sum's own
                // size.
                assert!(
                    error <= T::epsilon().widen() * 2.0 * bands as f64 * size.max(1.0),
                    "{error:e} of {size:e}, bands {bands}"
                );
            }
        }
    }
}

mod bits {
    /// Bit patterns, so that −0 and 0 differ.
    pub trait Bits {
        fn bits(self) -> u64;
    }
    impl Bits for f32 {
        fn bits(self) -> u64 {
            u64::from(self.to_bits())
        }
    }
    impl Bits for f64 {
        fn bits(self) -> u64 {
            self.to_bits()
        }
    }
}

/// One direction, rows, points, padded ends and every unrolled size are the same bits.
#[test]
fn every_form_agrees_f32() {
    batch_forms::<f32>();
}

#[test]
fn every_form_agrees_f64() {
    batch_forms::<f64>();
}

fn accumulate<T: Real>(bands: usize, points: usize) -> f64 {
    let basis = Basis::<T>::new(bands).unwrap();
    let d = fibonacci_directions(points);
    let [x, y, z] = soa::<T>(&d);
    let weights: [Vec<T>; 2] =
        [0.7, 1.9].map(|k| (0..points).map(|p| T::of((k * p as f64).sin() / points as f64)).collect());
    let start = T::of(0.25);
    let mut out = [vec![start; bands * bands], vec![start; bands * bands]];
    let [a, b] = &mut out;
    basis.accumulate(&x, &y, &z, [&weights[0], &weights[1]], [a, b]);
    let mut error = 0f64;
    for (out, weights) in out.iter().zip(&weights) {
        let mut want = vec![0.25; bands * bands];
        for p in 0..points {
            let at = UnitVector3::new_normalize(Vector3::new(x[p].widen(), y[p].widen(), z[p].widen()));
            for (want, y) in want.iter_mut().zip(naive::basis(bands, &at)) {
                *want += weights[p].widen() * y;
            }
        }
        error = error.max(worst_of(out.iter().map(|x| x.widen()).zip(&want)));
    }
    error
}

#[test]
fn accumulate_against_twin() {
    for (bands, points) in [(1, 0), (1, 1), (3, 15), (3, 17), (4, 3000), (6, 1100), (9, 100)] {
        assert_below(accumulate::<f32>(bands, points), 6e-7, "f32");
        assert_below(accumulate::<f64>(bands, points), 5e-15, "f64");
    }
}

/// A quadrature rule turns accumulation into projection: the coefficients of Σ c y come back.
#[test]
fn projection_inverts_reconstruction() {
    for bands in [1, 4, 9] {
        let rule = SphereQuadrature::new(2 * (bands - 1)).unwrap();
        let [x, y, z] = soa::<f64>(rule.directions());
        let c = coefficients(bands);
        let mut f = vec![0.0; x.len()];
        let basis = Basis::new(bands).unwrap();
        basis.reconstruct(&c, &x, &y, &z, &mut f);
        f.iter_mut().zip(rule.weights()).for_each(|(f, w)| *f *= w);
        let mut back = vec![0.0; c.len()];
        basis.accumulate(&x, &y, &z, [&f], [&mut back]);
        assert_below(worst_of(back.into_iter().zip(&c)), 2e-14, "projected");
    }
}

#[test]
fn gradient_against_differences() {
    for bands in [1, 2, 5, 11] {
        let basis = Basis::<f64>::new(bands).unwrap();
        let basis32 = Basis::<f32>::new(bands).unwrap();
        let n = bands * bands;
        let (mut y, mut g) = (vec![0.0; n], vec![Vector3::zeros(); n]);
        let (mut y32, mut g32) = (vec![0.0; n], vec![Vector3::zeros(); n]);
        let (mut error, mut error32, mut radial) = (0f64, 0f64, 0f64);
        for d in directions() {
            basis.gradient(&d, &mut y, &mut g);
            basis32.gradient(&narrow(&d), &mut y32, &mut g32);
            for (i, want) in naive::basis_gradient(bands, &d).iter().enumerate() {
                error = error.max(worst_of((0..3).map(|k| (g[i][k], &want[k]))));
                error32 = error32.max(worst_of((0..3).map(|k| (f64::from(g32[i][k]), &want[k]))));
                radial = radial.max(g[i].dot(&d).abs());
            }
        }
        // The differences: truncation (l step)^6/140 with l·step < 0.06, times l √(l/2π); rounding 1e-15/step.
        assert_below(error, 1e-8, &format!("gradient, bands {bands}"));
        assert_below(error32, 1e-6 * (bands * bands) as f64, &format!("gradient in f32, bands {bands}"));
        assert_below(radial, 1e-14 * bands as f64, "radial part");
    }
}

/// ∫ |∇y|² = l(l+1): exact at any degree, where differences are not.
#[test]
fn gradient_energy() {
    let bands = 40;
    let rule = SphereQuadrature::new(2 * bands).unwrap();
    let basis = Basis::<f64>::new(bands).unwrap();
    let n = bands * bands;
    let (mut y, mut g) = (vec![0.0; n], vec![Vector3::zeros(); n]);
    let mut energy = vec![0.0; n];
    for (d, w) in rule.directions().iter().zip(rule.weights()) {
        basis.gradient(d, &mut y, &mut g);
        energy.iter_mut().zip(&g).for_each(|(e, g)| *e += w * g.norm_squared());
    }
    for (i, e) in energy.iter().enumerate().skip(1) {
        let l = degree_order(i).0 as f64;
        assert!((e / (l * (l + 1.0)) - 1.0).abs() < 1e-12, "coefficient {i}: {e}");
    }
}

#[test]
fn hessian_against_differences() {
    for bands in [1, 2, 5, 11] {
        let (basis, basis32) = (Basis::<f64>::new(bands).unwrap(), Basis::<f32>::new(bands).unwrap());
        let n = bands * bands;
        let (mut y, mut g, mut h) = (vec![0.0; n], vec![Vector3::zeros(); n], vec![Matrix3::zeros(); n]);
        let (mut y32, mut g32, mut h32) = (vec![0.0; n], vec![Vector3::zeros(); n], vec![Matrix3::zeros(); n]);
        let (mut error, mut error32, mut radial, mut trace) = (0f64, 0f64, 0f64, 0f64);
        for d in directions() {
            basis.hessian(&d, &mut y, &mut g, &mut h);
            basis32.hessian(&narrow(&d), &mut y32, &mut g32, &mut h32);
            for (i, want) in naive::basis_hessian(bands, &d).iter().enumerate() {
                let l = degree_order(i).0 as f64;
                error = error.max(worst_of(h[i].iter().copied().zip(want)));
                error32 = error32.max(worst_of(h32[i].iter().map(|&h| f64::from(h)).zip(want)));
                radial = radial.max((h[i] * d.into_inner()).amax());
                trace = trace.max((h[i].trace() + l * (l + 1.0) * y[i]).abs());
            }
        }
        let l = bands as f64;
        // The differences: truncation of (l step)^6/560 l² √(l/2π) with l·step < 0.12. Measured: 1.4e-7 at 11 bands;
        // f32 1.3e-4.
        assert_below(error, 5e-11 * l.powi(4), &format!("Hessian, bands {bands}"));
        assert_below(error32, 5e-8 * l.powi(4), &format!("Hessian in f32, bands {bands}"));
        // |ω|² is 1 to 2 eps, times second derivatives of Y up to l² √l.
        assert_below(radial, 1e-15 * l * l * l, "radial part");
        assert_below(trace, 1e-15 * l * l * l, "Laplacian");
    }
}

/// ∫ |Hess y|² = λ(λ − 1), λ = l(l + 1): Bochner's formula on the sphere, whose Ricci curvature is 1.
#[test]
fn hessian_energy() {
    let bands = 24;
    let rule = SphereQuadrature::new(2 * bands).unwrap();
    let basis = Basis::<f64>::new(bands).unwrap();
    let n = bands * bands;
    let (mut y, mut g, mut h) = (vec![0.0; n], vec![Vector3::zeros(); n], vec![Matrix3::zeros(); n]);
    let mut energy = vec![0.0; n];
    for (d, w) in rule.directions().iter().zip(rule.weights()) {
        basis.hessian(d, &mut y, &mut g, &mut h);
        energy.iter_mut().zip(&h).for_each(|(e, h)| *e += w * h.norm_squared());
    }
    let mut error = 0f64;
    for (i, e) in energy.iter().enumerate().skip(1) {
        let lambda = (degree_order(i).0 * (degree_order(i).0 + 1)) as f64;
        error = error.max((e / (lambda * (lambda - 1.0)) - 1.0).abs());
    }
    assert_below(error, 1.5e-13, "energy");
}

/// Only m = ±1 has a gradient at a pole.
#[test]
fn gradient_at_poles() {
    for z in [1.0, -1.0] {
        let (mut y, mut g) = (vec![0.0; 64 * 64], vec![Vector3::zeros(); 64 * 64]);
        Basis::<f64>::new(64).unwrap().gradient(&Vector3::new(0.0, 0.0, z), &mut y, &mut g);
        for (i, g) in g.iter().enumerate() {
            let (l, m) = degree_order(i);
            let size = ((2 * l + 1) as f64 * (l * (l + 1)) as f64 / (8.0 * PI)).sqrt();
            let sign = if z < 0.0 && l % 2 == 0 { -1.0 } else { 1.0 };
            let want = match m {
                1 => Vector3::new(sign * size, 0.0, 0.0),
                -1 => Vector3::new(0.0, sign * size, 0.0),
                _ => Vector3::zeros(),
            };
            assert!((g - want).norm() <= 1e-13 * (1.0 + size), "l {l}, m {m}: {g} instead of {want}");
        }
    }
}

#[test]
fn nan_reaches_what_reads_it() {
    let values = |d: Vector3<f32>| eval(5, &d).unwrap();
    for (i, y) in values(Vector3::new(0.3, 0.4, f32::NAN)).iter().enumerate() {
        let (l, m) = degree_order(i);
        assert_eq!(y.is_nan(), l != m.unsigned_abs(), "z, l {l}, m {m}");
    }
    for (i, y) in values(Vector3::new(f32::NAN, 0.4, 0.5)).iter().enumerate() {
        let (l, m) = degree_order(i);
        assert_eq!(y.is_nan(), m != 0 && m != -1, "x, l {l}, m {m}");
    }
    let basis = Basis::<f64>::new(3).unwrap();
    for k in 0..3 {
        let mut d = Vector3::new(0.0, 0.6, 0.8);
        d[k] = f64::NAN;
        assert!(basis.dot(&coefficients(3), &d).is_nan());
        let mut out = [0.0; 9];
        basis.accumulate(&[d.x, 1.0], &[d.y, 0.0], &[d.z, 0.0], [&[1.0, 1.0]], [&mut out]);
        assert!(out.iter().any(|x| x.is_nan()));
    }
    let mut c = coefficients(3);
    c[5] = f64::NAN;
    assert!(basis.dot(&c, &Vector3::z()).is_nan());
}

#[test]
fn wrong_lengths_panic() {
    let basis = Basis::<f64>::new(2).unwrap();
    let fails = |f: &dyn Fn()| std::panic::catch_unwind(std::panic::AssertUnwindSafe(f)).is_err();
    assert!(fails(&|| basis.eval(&Vector3::z(), &mut [0.0; 3])));
    assert!(fails(&|| basis.eval_batch(&[0.0], &[0.0, 1.0], &[1.0], &mut [0.0; 4])));
    assert!(fails(&|| basis.eval_points(&[0.0], &[0.0], &[1.0], &mut [0.0; 5])));
    assert!(fails(&|| basis.reconstruct(&[0.0; 4], &[0.0], &[0.0], &[1.0], &mut [0.0; 2])));
    assert!(fails(&|| basis.accumulate(&[0.0], &[0.0], &[1.0], [&[]], [&mut [0.0; 4]])));
    assert!(fails(&|| {
        basis.dot(&[0.0; 5], &Vector3::z());
    }));
}

#[test]
fn golden_condon_shortley() {
    let sloan = Convention { phase: Phase::CondonShortley, ..Convention::default() };
    let mut error = 0f64;
    for item in golden(HARMONICS, "sh_basis_cs")["items"].as_array().unwrap() {
        let want = numbers(&item["y"]);
        let y = sloan.export_values(5, &eval(5, &vector(&item["dir"])).unwrap());
        error = error.max(worst_of(y.into_iter().zip(&want)));
    }
    assert_below(error, 3e-15, "with Condon–Shortley signs");
}

#[test]
fn golden_complex() {
    let c = coefficients(5);
    let a = to_complex(5, &c);
    let mut error = 0f64;
    for item in golden(HARMONICS, "sh_complex")["items"].as_array().unwrap() {
        let y = eval(5, &vector(&item["dir"])).unwrap();
        let mut sum = Complex::new(0.0, 0.0);
        for (i, value) in item["Y_re_im"].as_array().unwrap().iter().enumerate() {
            let value = numbers(value);
            sum += a[i] * Complex::new(value[0], value[1]);
            // One function at a time as well.
            let (l, m) = degree_order(i);
            let mut one = vec![0.0; 25];
            one[i] = 1.0;
            let one = to_complex(5, &one);
            let mut single = Complex::new(0.0, 0.0);
            for m in [m, -m].into_iter().take(1 + usize::from(m != 0)) {
                let at = numbers(&item["Y_re_im"][index(l, m)]);
                single += one[index(l, m)] * Complex::new(at[0], at[1]);
            }
            error = error.max((single - y[i]).norm());
        }
        let want: f64 = c.iter().zip(&y).map(|(c, y)| c * y).sum();
        error = error.max((sum - want).norm());
    }
    assert_below(error, 3e-15, "complex sums");
}

/// Squared norms by quadrature: what each normalisation claims.
#[test]
fn normalizations() {
    let rule = SphereQuadrature::new(8).unwrap();
    for (normalization, want) in [
        (Normalization::Orthonormal, [1.0; 5]),
        (Normalization::FourPi, [4.0 * PI; 5]),
        (Normalization::Schmidt, [0, 1, 2, 3, 4].map(|l| 4.0 * PI / (2 * l + 1) as f64)),
    ] {
        let convention = Convention { normalization, ..Convention::default() };
        let mut norms = [0.0; 25];
        for (d, w) in rule.directions().iter().zip(rule.weights()) {
            let y = convention.export_values(5, &eval(5, d).unwrap());
            norms.iter_mut().zip(y).for_each(|(n, y)| *n += w * y * y);
        }
        for (i, n) in norms.iter().enumerate() {
            assert!((n / want[degree_order(i).0] - 1.0).abs() < 1e-13, "{normalization:?} {i}: {n}");
        }
    }
}

#[test]
fn order_major_layout() {
    let convention = Convention { layout: Layout::ByOrder, ..Convention::default() };
    let flat: Vec<f64> = (0..9).map(f64::from).collect();
    assert_eq!(convention.export(3, &flat), [0.0, 2.0, 6.0, 3.0, 7.0, 1.0, 5.0, 8.0, 4.0]);
    assert_eq!(convention.export(1, &[5.0]), [5.0]);
    assert!(convention.export::<f64>(0, &[]).is_empty());
}

fn conventions() -> impl Strategy<Value = Convention> {
    (
        prop_oneof![Just(Phase::Plain), Just(Phase::CondonShortley)],
        prop_oneof![Just(Normalization::Orthonormal), Just(Normalization::FourPi), Just(Normalization::Schmidt)],
        prop_oneof![
            Just(Layout::ByDegree),
            Just(Layout::ByOrder),
            Just(Layout::CosinesFirst),
            Just(Layout::FurseMalham)
        ],
        prop_oneof![Just(Axes::default()), Just(Axes::LEFT_HANDED_Z_UP), Just(Axes::POLE_Y), Just(Axes::AMBISONIC)],
    )
        .prop_map(|(phase, normalization, layout, axes)| Convention { phase, normalization, layout, axes })
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn conventions_round_trip(convention in conventions(), bands in 1usize..9, d in direction()) {
        let c = coefficients(bands);
        let theirs = convention.export(bands, &c);
        let back = convention.import(bands, &theirs);
        // Rounding of the scale, and of two rotations where the pole moves.
        let tolerance = if convention.axes == Axes::default() { 4e-16 } else { 2e-15 };
        prop_assert!(worst_of(back.into_iter().zip(&c)) <= tolerance);
        let y = eval(bands, &d).unwrap();
        let values = convention.export_values(bands, &y);
        prop_assert!(worst_of(convention.import_values(bands, &values).into_iter().zip(&y)) <= 3.0 * tolerance);
        let sum: f64 = theirs.iter().zip(values).map(|(c, y)| c * y).sum();
        let want: f64 = c.iter().zip(&y).map(|(c, y)| c * y).sum();
        prop_assert!((sum - want).abs() <= 1e-14);
        prop_assert!(worst_of(from_complex(bands, &to_complex(bands, &c)).into_iter().zip(&c)) <= 4e-16);
    }

    /// Σ_m y_{l,m}(a) y_{l,m}(b) = (2l+1)/4π P_l(a·b).
    #[test]
    fn addition_theorem(a in direction(), b in direction(), bands in 1usize..=64) {
        let (ya, yb) = (eval(bands, &a).unwrap(), eval(bands, &b).unwrap());
        let l = bands - 1;
        let sum: f64 = (l * l..bands * bands).map(|i| ya[i] * yb[i]).sum();
        let across = a.cross(&b).norm_squared();
        let factor = ((2 * l + 1) as f64 / (4.0 * PI)).sqrt();
        let want = factor * naive::associated_legendre(l, a.dot(&b), across)[0];
        // l² eps of each of the two directions' lengths and of a·b, times (2l+1)/4π.
        prop_assert!((sum - want).abs() <= 2e-15 + 1e-16 * (l * l) as f64 * factor * factor, "{sum} {want}");
    }

    #[test]
    fn symmetries(d in direction(), bands in 1usize..20) {
        let y = eval(bands, &d).unwrap();
        let mirrored = |sign: [f64; 3]| {
            eval(bands, &Vector3::new(sign[0] * d.x, sign[1] * d.y, sign[2] * d.z)).unwrap()
        };
        let [through, flipped, below] = [[-1.0; 3], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0]].map(mirrored);
        for i in 0..bands * bands {
            let (l, m) = degree_order(i);
            let sign = |odd: bool| if odd { -1.0 } else { 1.0 };
            prop_assert_eq!(through[i], sign(l % 2 == 1) * y[i]);
            prop_assert_eq!(flipped[i], sign(m < 0) * y[i]);
            prop_assert_eq!(below[i], sign((l + m.unsigned_abs()) % 2 == 1) * y[i]);
        }
    }

    #[test]
    fn against_twin(d in direction(), bands in 1usize..=64) {
        let want = naive::basis(bands, &d);
        let error = worst_of(eval(bands, &d).unwrap().into_iter().zip(&want));
        prop_assert!(error <= 1e-16 + 4e-17 * (bands as f64).powf(2.5), "{error:e}");
    }

    #[test]
    fn gradient_is_tangent_and_consistent(d in direction(), bands in 1usize..=32) {
        let basis = Basis::<f64>::new(bands).unwrap();
        let n = bands * bands;
        let (mut y, mut g) = (vec![0.0; n], vec![Vector3::zeros(); n]);
        basis.gradient(&d, &mut y, &mut g);
        // Rotation about z: (x ∂_y − y ∂_x) y_{l,m} = −m y_{l,−m}.
        for i in 0..n {
            let (l, m) = degree_order(i);
            let turned = d.x * g[i].y - d.y * g[i].x;
            let want = -(m as f64) * y[index(l, -m)];
            let tolerance = 1e-15 * (bands as f64).powi(3);
            prop_assert!((turned - want).abs() <= tolerance, "l {}, m {}: {} {}", l, m, turned, want);
            prop_assert!(g[i].dot(&d).abs() <= tolerance);
        }
    }
}
