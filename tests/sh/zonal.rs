//! Zonal functions, their kernels and lobes against golden values, naive twins and theorems.

use std::f64::consts::{FRAC_PI_2, PI};

use haarmonic::Real;
use haarmonic::nalgebra::{UnitVector3, Vector3};
use haarmonic::reference::sh as naive;
use haarmonic::sh::{Basis, VonMisesFisher, Zonal, associated_legendre, index};
use haarmonic::sphere::fibonacci_directions;
use haarmonic::strategies::{self, direction};
use proptest::prelude::*;
use serde_json::Value;

use crate::support::{HARMONICS, cases, golden, largest, number, numbers};

fn items<'a>(v: &'a Value, name: &str) -> &'a [Value] {
    v[name].as_array().unwrap()
}

/// Every value within `relative` of its own size, or `absolute`.
#[track_caller]
fn assert_all_close<T: Real>(got: &[T], want: &[f64], relative: f64, absolute: f64, what: &str) {
    assert_eq!(got.len(), want.len(), "{what}");
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        let (got, off) = (got.widen(), (got.widen() - want).abs());
        assert!(off <= relative * want.abs() + absolute, "{what}, {i}: got {got:e}, want {want:e}, off by {off:e}");
    }
}

#[test]
fn golden_clamped_cosine() {
    let file = golden(HARMONICS, "clamped_cosine");
    let cosine = Zonal::<f64>::clamped_cosine(21).unwrap();
    // Products of ten ratios: 2e-15 relative. Golden zeros are exact zeros.
    assert_all_close(cosine.factors(), &numbers(&file["A_hat_l"]), 2e-15, 0.0, "factors");
    assert_all_close(&cosine.coefficients(), &numbers(&file["zonal_coefficients"]), 2e-15, 0.0, "coefficients");
    for lobe in items(&file, "phong_lobe_clamped_cos_pow") {
        let want = numbers(&lobe["A_hat_l"]);
        let power = number(&lobe["exponent"]);
        let got = Zonal::<f64>::cosine_power(want.len(), power).unwrap();
        // The file's zeros are of 1e-35.
        assert_all_close(got.factors(), &want, 4e-15, 1e-34, &format!("power {power}"));
    }
}

#[test]
fn golden_circle_blocker() {
    for item in items(&golden(HARMONICS, "circle_blocker"), "items") {
        let want = numbers(&item["g_zonal"]);
        let theta = number(&item["theta"]);
        let got = Zonal::<f64>::outside_cap(want.len(), theta).unwrap();
        // At π/2 the even degrees are rounding on both sides.
        assert_all_close(&got.coefficients(), &want, 2e-15, 1e-15, &format!("θ {theta}"));
    }
}

#[test]
fn golden_von_mises_fisher() {
    for item in items(&golden(HARMONICS, "vmf"), "items") {
        let kappa = number(&item["kappa"]);
        let density = VonMisesFisher::new(kappa).unwrap();
        let what = format!("κ {kappa}");
        let log = number(&item["log_norm_C"]);
        // The terms of the logarithm are of size κ.
        assert_all_close(&[density.log_normalization()], &[log], 4e-16, 1e-15, &what);
        assert_all_close(&[density.mean_length()], &[number(&item["mean_length_A1"])], 1e-15, 0.0, &what);
        let want = numbers(&item["A_l_convolution"]);
        let zonal = Zonal::<f64>::von_mises_fisher(want.len(), &density).unwrap();
        // A product of l ratios.
        assert_all_close(zonal.factors(), &want, 6e-15, 0.0, &what);
        assert_all_close(&zonal.coefficients(), &numbers(&item["zonal_coefficients"]), 6e-15, 0.0, &what);
    }
}

#[test]
fn golden_normal_map_filtering() {
    let file = golden(HARMONICS, "ndf_filtering");
    let bands = file["order"].as_u64().unwrap() as usize;
    let basis = Basis::<f64>::new(bands).unwrap();
    // γ_lm is the mean of the basis at the normals.
    let mut gamma = vec![0.0; bands * bands];
    let normals: Vec<Vec<f64>> = items(&file, "normals").iter().map(numbers).collect();
    let [x, y, z] = [0, 1, 2].map(|k| normals.iter().map(|n| n[k]).collect::<Vec<_>>());
    basis.accumulate(&x, &y, &z, [&vec![1.0 / normals.len() as f64; normals.len()]], [&mut gamma]);
    assert_all_close(&gamma, &numbers(&file["gamma_lm"]), 0.0, 1e-15, "γ");
    for item in items(&file, "items") {
        let name = item["brdf"].as_str().unwrap();
        let power = name.strip_prefix("blinn_cos_pow_").map_or(1.0, |n| n.parse().unwrap());
        let lobe = Zonal::<f64>::cosine_power(bands, power).unwrap();
        assert_all_close(lobe.factors(), &numbers(&item["rho_hat_l"]), 4e-15, 1e-34, name);
        assert_all_close(&lobe.coefficients(), &numbers(&item["f_l"]), 4e-15, 1e-34, name);
        let mut effective = gamma.clone();
        lobe.convolve(&mut effective);
        assert_all_close(&effective, &numbers(&item["rho_eff_lm"]), 0.0, 4e-15, name);
        for eval in items(item, "eval") {
            let omega = Vector3::from_vec(numbers(&eval["omega"]));
            let want = number(&eval["rho_eff_bandlimited"]);
            assert_all_close(&[basis.dot(&effective, &omega)], &[want], 0.0, 4e-15, name);
        }
    }
}

#[test]
fn clamped_cosine_has_the_published_signs_and_falls_as_the_power_five_halves() {
    let cosine = Zonal::<f64>::clamped_cosine(1000).unwrap();
    let k = cosine.factors();
    assert!((k[4] + 0.130_900).abs() < 5e-7, "Â_4 is negative");
    for l in (3..1000).step_by(2) {
        assert_eq!(k[l], 0.0);
    }
    for l in (2..998).step_by(2) {
        assert_eq!(k[l].signum(), -k[l + 2].signum());
    }
    // l^{−5/2}: the closed form with Stirling's (l)!/(2^l (l/2)!²) ≈ √(2/πl).
    let want = 2.0 * PI * (2.0 / PI).sqrt() * 998f64.powf(-2.5);
    assert!((k[998].abs() / want - 1.0).abs() < 2e-3);
}

#[test]
fn lobes_of_any_power_are_their_integrals() {
    for power in [0.0, 0.001, 0.5, 1.0, 1.7, 2.0, 7.25, 33.0, 1e3, 1e6] {
        let want = naive::zonal_factors(14, &[0.0, FRAC_PI_2], |angle| angle.cos().max(0.0).powf(power));
        let got = Zonal::<f64>::cosine_power(14, power).unwrap();
        // What the powers of cosines near 1 lose: eps · power · (1 − cos), of order eps.
        assert_all_close(got.factors(), &want, 0.0, 6e-14 * want[0].max(1e-3), &format!("power {power}"));
    }
    let tiny = 1e-10;
    let huge = Zonal::<f64>::cosine_power(9, 1e12).unwrap().scaled(1e12 / (2.0 * PI));
    assert_all_close(huge.factors(), &[1.0; 9], tiny, 0.0, "tends to the delta");
}

#[test]
fn caps_of_any_size_are_their_integrals() {
    for angle in [1e-3, 0.02, 0.3, 1.0, FRAC_PI_2, 2.5, 3.1, PI] {
        let want = naive::zonal_factors(17, &[0.0, angle], |_| 1.0);
        let got = Zonal::<f64>::cap(17, angle).unwrap();
        assert_all_close(got.factors(), &want, 0.0, 1e-14 * want[0], &format!("θ {angle}"));
        let mut rest = naive::zonal_factors(17, &[angle, PI], |_| 1.0);
        if angle == PI {
            rest.fill(0.0);
        }
        let outside = Zonal::<f64>::outside_cap(17, angle).unwrap();
        assert_all_close(outside.factors(), &rest, 0.0, 3e-14, &format!("θ {angle}, outside"));
    }
}

#[test]
fn tiny_caps_keep_their_digits_at_both_ends() {
    // k_l = 2π ∫_0^θ P_l sin = π θ² (1 − θ²/12 − l(l+1) θ²/8 + O(θ⁴ l⁴)).
    for theta in [1e-150f64, 1e-9, 1e-6, 1e-4] {
        let cap = Zonal::<f64>::cap(8, theta).unwrap();
        let rest = Zonal::<f64>::outside_cap(8, PI - theta).unwrap();
        // π − θ rounds by eps π/θ relative; what it rounds to is known again exactly, but for the rounding of π.
        let theta_rest = (PI - (PI - theta)) + 1.224_646_799_147_353e-16;
        for l in 0..8 {
            let n = (l * (l + 1)) as f64;
            let want = |t: f64| PI * t * t * (1.0 - t * t / 12.0 - n * t * t / 8.0);
            let sign = if l % 2 == 0 { 1.0 } else { -1.0 };
            assert!((cap.factors()[l] / want(theta) - 1.0).abs() < 3e-15, "l {l} θ {theta}");
            // Below 1e-8 the angle itself is rounding.
            if theta > 1e-8 {
                assert!((rest.factors()[l] * sign / want(theta_rest) - 1.0).abs() < 1e-14, "l {l} π − {theta}");
            }
        }
    }
}

#[test]
fn caps_at_and_beyond_the_ends() {
    for (angle, first) in [(0.0, 0.0), (-1.0, 0.0), (PI, 4.0 * PI), (7.0, 4.0 * PI), (f64::INFINITY, 4.0 * PI)] {
        let cap = Zonal::<f64>::cap(5, angle).unwrap();
        let outside = Zonal::<f64>::outside_cap(5, angle).unwrap();
        assert_all_close(cap.factors(), &[first, 0.0, 0.0, 0.0, 0.0], 0.0, 1e-30, &format!("{angle}"));
        assert_all_close(outside.factors(), &[4.0 * PI - first, 0.0, 0.0, 0.0, 0.0], 0.0, 1e-30, &format!("{angle}"));
    }
    assert!(Zonal::<f64>::cap(3, f64::NAN).unwrap().factors().iter().all(|k| k.is_nan()));
    // A step at the equator: half of everything.
    let half = Zonal::<f32>::cap(1, FRAC_PI_2).unwrap();
    assert_eq!(half.factors(), [2.0 * std::f32::consts::PI]);
}

#[test]
fn von_mises_fisher_of_any_concentration() {
    for kappa in [0.0, 1e-9, 0.3, 1.0, 3.0, 20.0, 99.0, 575.0, 577.0, 1e4, 1e6, 1e9] {
        let density = VonMisesFisher::new(kappa).unwrap();
        let lobe = |angle: f64| (-2.0 * kappa * (0.5 * angle).sin().powi(2)).exp();
        let want = naive::zonal_factors(14, &[0.0, PI], lobe);
        let want: Vec<f64> = want.iter().map(|k| k / want[0]).collect();
        let got = Zonal::<f64>::von_mises_fisher(14, &density).unwrap();
        assert_all_close(got.factors(), &want, 0.0, 3e-14, &format!("κ {kappa}"));
        // The density is normalised.
        let total = naive::zonal_factors(1, &[0.0, PI], |angle| density.eval(angle.cos()));
        // 1 − cos loses eps κ.
        assert_all_close(&total, &[1.0], 0.0, 4e-15 + 4e-16 * kappa, &format!("κ {kappa}"));
    }
}

#[test]
fn von_mises_fisher_at_its_ends() {
    let uniform = VonMisesFisher::new(0.0).unwrap();
    assert_eq!(Zonal::<f64>::von_mises_fisher(3, &uniform).unwrap().factors(), [1.0, 0.0, 0.0]);
    assert_all_close(&[uniform.eval(-0.3), uniform.log_normalization().exp()], &[0.25 / PI; 2], 1e-15, 0.0, "uniform");
    let delta = VonMisesFisher::new(f64::INFINITY).unwrap();
    assert_eq!(Zonal::<f64>::von_mises_fisher(40, &delta).unwrap(), Zonal::delta(40).unwrap());
    assert_eq!((delta.mean_length(), delta.eval(0.999), delta.log_normalization()), (1.0, 0.0, f64::NEG_INFINITY));
    let huge = VonMisesFisher::new(1e300).unwrap();
    assert_all_close(Zonal::<f64>::von_mises_fisher(40, &huge).unwrap().factors(), &[1.0; 40], 1e-15, 0.0, "1e300");
    assert!(VonMisesFisher::new(-1e-300).is_err() && VonMisesFisher::new(f64::NAN).is_err());
    // Ratios that underflow.
    let faint = VonMisesFisher::new(1e-200).unwrap();
    let faint = Zonal::<f64>::von_mises_fisher(4, &faint).unwrap();
    assert_eq!(faint.factors()[2..], [0.0, 0.0]);
    assert!((faint.factors()[1] / 1e-200 * 3.0 - 1.0).abs() < 1e-15);
    // Both ways through the recurrence agree where they meet: bands² = κ, to the error that the upward one makes.
    for bands in [2usize, 10, 64, 200] {
        let kappa = (bands * bands) as f64;
        let up = Zonal::<f64>::von_mises_fisher(bands, &VonMisesFisher::new(kappa).unwrap()).unwrap();
        let down = Zonal::<f64>::von_mises_fisher(bands + 1, &VonMisesFisher::new(kappa).unwrap()).unwrap();
        let tolerance = 2e-15 * bands as f64;
        assert_all_close(up.factors(), &down.factors()[..bands], tolerance, 0.0, &format!("{bands} bands"));
    }
}

#[test]
fn concentration_from_mean_length_is_the_inverse() {
    for kappa in [1e-12, 1e-3, 0.1, 0.9, 1.0, 1.1, 2.0, 10.0, 50.0, 1e3, 1e6, 1e12] {
        let length = VonMisesFisher::new(kappa).unwrap().mean_length();
        let back = VonMisesFisher::from_mean_length(length).unwrap().concentration();
        let tolerance = 1e-15 + 4.0 * f64::EPSILON / (1.0 - length);
        assert!((back / kappa - 1.0).abs() < tolerance, "κ {kappa}, back {back}");
    }
    let of = |length| VonMisesFisher::from_mean_length(length).map(|d| d.concentration());
    assert_eq!((of(0.0), of(1.0)), (Ok(0.0), Ok(f64::INFINITY)));
    assert!(of(1.0 - f64::EPSILON / 2.0).unwrap() > 1e15 && of(1e-310).unwrap() > 0.0);
    assert!(of(-1e-9).is_err() && of(1.0 + 1e-9).is_err() && of(f64::NAN).is_err());
}

#[test]
fn projection_is_exact_on_pieces() {
    // |t|³ and a step, with degrees 3 and 0 on their pieces.
    let want = naive::zonal_factors(12, &[0.0, FRAC_PI_2, PI], |angle| angle.cos().abs().powi(3));
    let got = Zonal::<f64>::project(12, 8, &[0.0], |t| t.abs().powi(3)).unwrap();
    assert_all_close(got.factors(), &want, 0.0, 2e-14, "|t|³");
    let step = Zonal::<f64>::project(12, 6, &[-0.5, 0.3], |t| f64::from(u8::from(t > 0.3))).unwrap();
    assert_all_close(step.factors(), Zonal::<f64>::cap(12, 0.3f64.acos()).unwrap().factors(), 0.0, 2e-14, "step");
    // One node too few shows.
    let short = Zonal::<f64>::project(12, 5, &[-0.5, 0.3], |t| f64::from(u8::from(t > 0.3))).unwrap();
    assert!((short.factors()[11] - step.factors()[11]).abs() > 1e-9);
    for breaks in [&[0.5, 0.5][..], &[0.5, 0.2], &[1.0], &[-1.0], &[f64::NAN]] {
        assert!(Zonal::<f64>::project(2, 3, breaks, |t| t).is_err(), "{breaks:?}");
    }
    assert!(Zonal::<f64>::project(0, 3, &[], |t| t).is_err() && Zonal::<f64>::project(3, 0, &[], |t| t).is_err());
}

#[test]
fn values_are_the_sum_over_the_basis() {
    let zonal = Zonal::from_factors((0..9).map(|l| 1.0 / (1.0 + l as f64))).unwrap();
    let z = zonal.coefficients();
    for d in fibonacci_directions(30) {
        let y = naive::basis(9, &d);
        let want: f64 = (0..9).map(|l| z[l] * y[index(l, 0)]).sum();
        assert!((zonal.eval(d.z) - want).abs() < 2e-15);
    }
    let back = Zonal::from_coefficients(z).unwrap();
    approx::assert_relative_eq!(back, zonal, max_relative = 1e-15);
    approx::assert_abs_diff_ne!(back, zonal.clone().scaled(1.001), epsilon = 1e-6);
    assert!(Zonal::<f64>::from_factors([]).is_err() && Zonal::<f32>::from_coefficients([]).is_err());
    assert!(Zonal::<f64>::cap(0, 1.0).is_err() && Zonal::<f64>::clamped_cosine(0).is_err());
    assert!(Zonal::<f64>::cosine_power(2, -1e-9).is_err() && Zonal::<f64>::cosine_power(2, f64::NAN).is_err());
}

#[test]
fn associated_functions_are_those_of_the_basis() {
    const BANDS: usize = 30;
    let mut q = vec![0.0; BANDS * (BANDS + 1) / 2];
    for z in [-1.0, -0.999_999, -0.4, 0.0, 0.7, 1.0] {
        associated_legendre(BANDS, z, &mut q).unwrap();
        for l in 0..BANDS {
            let want = naive::associated_legendre(l, z, (1.0 - z) * (1.0 + z));
            for m in 0..=l {
                let want = want[m] * if m == 0 { 1.0 } else { 2f64.sqrt() };
                let got = q[l * (l + 1) / 2 + m];
                assert!((got - want).abs() < 2e-13 * want.abs().max(1.0), "({l}, {m}) at {z}: {got} {want}");
            }
        }
    }
    assert!(associated_legendre::<f64>(0, 0.0, &mut []).is_err());
    assert!(associated_legendre(129, 0.0f32, &mut []).is_err());
}

/// About an axis by quadrature of the whole sphere.
fn about(zonal: &Zonal<f64>, axis: &UnitVector3<f64>) -> Vec<f64> {
    let bands = zonal.bands();
    naive::project_cap(bands, axis, PI, bands, |d| {
        (0..bands)
            .map(|l| (2 * l + 1) as f64 / (4.0 * PI) * zonal.factors()[l] * naive::legendre(l, d.angle(axis)))
            .sum()
    })
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn about_an_axis_is_the_projection(
        axis in direction(),
        zonal in strategies::zonal::<f64>(7),
    ) {
        let bands = zonal.bands();
        let basis = Basis::<f64>::new(bands).unwrap();
        let mut got = vec![f64::NAN; bands * bands];
        zonal.about(&basis, &axis, &mut got);
        assert_all_close(&got, &about(&zonal, &axis), 0.0, 4e-14, "about");
        // Batches and sums have the bits of one, or of its multiples.
        let axes = [&axis.x, &axis.y, &axis.z].map(|c| vec![*c; 11]);
        let mut batch = vec![f64::NAN; 11 * bands * bands];
        zonal.about_batch(&basis, axes.each_ref().map(|a| &a[..]), &mut batch);
        prop_assert!(batch.chunks(11).zip(&got).all(|(row, got)| row.iter().all(|x| x == got)));
        let (mut a, mut b, mut scratch) = (vec![1.0; got.len()], vec![0.0; got.len()], vec![0.0; got.len()]);
        zonal.add_about(&basis, &axis, [(2.0, &mut a), (-1.0, &mut b)], &mut scratch);
        prop_assert!(got.iter().zip(&a).zip(&b).all(|((got, a), b)| *a == 1.0 + 2.0 * got && *b == -got));
    }

    #[test]
    fn convolution_is_the_integral(
        n in direction(),
        zonal in strategies::zonal::<f64>(6),
        seed in prop::collection::vec(-1.0..1.0f64, 36),
    ) {
        let bands = zonal.bands();
        let light = &seed[..bands * bands];
        // ∫ f(n · ω) L(ω) dω = Σ (f about n)_i L_i.
        let want: f64 = about(&zonal, &n).iter().zip(light).map(|(f, l)| f * l).sum();
        let mut got = light.to_vec();
        zonal.convolve(&mut got);
        let value: f64 = naive::basis(bands, &n).iter().zip(&got).map(|(y, c)| y * c).sum();
        prop_assert!((value - want).abs() < 1e-13);
        let mut batch: Vec<f32> = light.iter().flat_map(|c| [*c as f32; 3]).collect();
        let narrow = Zonal::from_factors(zonal.factors().iter().map(|k| *k as f32)).unwrap();
        narrow.convolve_batch(3, &mut batch);
        let tolerance = 2e-7 * largest(zonal.factors()).max(2.0);
        let close = |x: &f32, got: f64| (f64::from(*x) - got).abs() < tolerance;
        prop_assert!(batch.chunks(3).zip(&got).all(|(row, got)| row.iter().all(|x| close(x, *got))));
        narrow.convolve_batch(0, &mut []);
    }
}

#[test]
#[should_panic(expected = "coefficients: expected length 9, got 8")]
fn convolution_of_another_size_panics() {
    Zonal::<f64>::delta(3).unwrap().convolve(&mut [0.0; 8]);
}

#[test]
#[should_panic(expected = "bands of the basis: expected length 3, got 2")]
fn a_basis_of_another_size_panics() {
    Zonal::<f64>::delta(3).unwrap().about(&Basis::new(2).unwrap(), &Vector3::z(), &mut [0.0; 4]);
}
