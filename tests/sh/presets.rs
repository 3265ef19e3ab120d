//! Presets of conventions against the formulas that the projects publish, written out here in their own coordinates.
#![expect(clippy::excessive_precision, clippy::approx_constant, reason = "constants as they are published")]

use std::f64::consts::{FRAC_1_PI, PI};

use haarmonic::Real;
use haarmonic::nalgebra::{Complex, Vector3};
use haarmonic::sh::{Basis, Convention, DiffuseProbe, Irradiance, Normalization, from_complex, to_complex};
use haarmonic::sphere::{Axes, SignedAxis, fibonacci_directions};
use proptest::prelude::*;

use crate::support::{assert_below, cases, coefficients, narrow, worst, worst_of};

/// The worst gap between the preset's values in directions of this crate and `formula` in the project's coordinates.
fn gap(convention: Convention, bands: usize, formula: impl Fn([f64; 3]) -> Vec<f64>) -> f64 {
    let basis = Basis::<f64>::new(bands).unwrap();
    let mut y = vec![0.0; bands * bands];
    let mut error = 0f64;
    for d in fibonacci_directions(40) {
        basis.eval(&d, &mut y);
        let want = formula([d.x, d.y, d.z]);
        error = error.max(worst(&convention.export_values(bands, &y), &want));
        error = error.max(worst(&convention.import_values(bands, &want), &y));
    }
    error
}

/// Sloan 2008, appendix A2, as DirectXMath's `XMSHEvalDirection` has it, to order 3 with its own constants.
#[test]
fn directx_math_and_sloan() {
    let error = gap(Convention::DIRECTX_MATH, 3, |[x, y, z]| {
        vec![
            0.282094791773878140,
            -0.488602511902919920 * y,
            0.488602511902919920 * z,
            -0.488602511902919920 * x,
            0.546274215296039590 * 2.0 * x * y,
            -1.092548430592079200 * z * y,
            0.946174695757560080 * z * z - 0.315391565252520050,
            -1.092548430592079200 * z * x,
            0.546274215296039590 * (x * x - y * y),
        ]
    });
    assert_below(error, 5e-16, "DirectXMath");
    assert_eq!(Convention::SLOAN, Convention::DIRECTX_MATH);
}

/// `getBasisAt`, `getAt` and `getIrradianceAt` of `SphericalHarmonics3`: six digits, so 1e-6.
#[test]
fn three_js() {
    let basis = |[x, y, z]: [f64; 3]| {
        vec![
            0.282095,
            0.488603 * y,
            0.488603 * z,
            0.488603 * x,
            1.092548 * x * y,
            1.092548 * y * z,
            0.315392 * (3.0 * z * z - 1.0),
            1.092548 * x * z,
            0.546274 * (x * x - y * y),
        ]
    };
    assert_below(gap(Convention::THREE_JS, 3, basis), 1e-6, "three.js");
    // Its coefficients are radiance: our irradiance is its `getIrradianceAt`.
    let c = coefficients(3);
    let sh = Convention::THREE_JS.export(3, &c);
    let ours = Irradiance::new([&c]);
    for d in fibonacci_directions(20) {
        let [x, y, z] = [d.x, d.y, d.z];
        let theirs = sh[0] * 0.886227
            + 2.0 * 0.511664 * (sh[1] * y + sh[2] * z + sh[3] * x)
            + 2.0 * 0.429043 * (sh[4] * x * y + sh[5] * y * z + sh[7] * x * z)
            + sh[6] * (0.743125 * z * z - 0.247708)
            + sh[8] * 0.429043 * (x * x - y * y);
        let [want] = ours.eval(&d);
        assert!((theirs - want).abs() < 4e-6, "{theirs} {want}");
    }
}

/// `eval_sh` with `C0`, `C1`, `C2`, `C3`.
#[test]
fn gaussian_splatting() {
    let error = gap(Convention::GAUSSIAN_SPLATTING, 4, |[x, y, z]| {
        let (xx, yy, zz) = (x * x, y * y, z * z);
        vec![
            0.28209479177387814,
            -0.4886025119029199 * y,
            0.4886025119029199 * z,
            -0.4886025119029199 * x,
            1.0925484305920792 * x * y,
            -1.0925484305920792 * y * z,
            0.31539156525252005 * (2.0 * zz - xx - yy),
            -1.0925484305920792 * x * z,
            0.5462742152960396 * (xx - yy),
            -0.5900435899266435 * y * (3.0 * xx - yy),
            2.890611442640554 * x * y * z,
            -0.4570457994644658 * y * (4.0 * zz - xx - yy),
            0.3731763325901154 * z * (2.0 * zz - 3.0 * xx - 3.0 * yy),
            -0.4570457994644658 * x * (4.0 * zz - xx - yy),
            1.445305721320277 * z * (xx - yy),
            -0.5900435899266435 * x * (xx - 3.0 * yy),
        ]
    });
    assert_below(error, 1e-15, "3D Gaussian splatting");
}

/// The constants of `printShBase` in Filament's `CubemapSH`.
#[test]
fn filament_before_its_shader() {
    let root = |x: f64| (x / PI).sqrt();
    let error = gap(Convention::FILAMENT, 3, |[x, y, z]| {
        vec![
            root(1.0) / 2.0,
            -root(3.0) / 2.0 * y,
            root(3.0) / 2.0 * z,
            -root(3.0) / 2.0 * x,
            root(15.0) / 2.0 * y * x,
            -root(15.0) / 2.0 * y * z,
            root(5.0) / 4.0 * (3.0 * z * z - 1.0),
            -root(15.0) / 2.0 * z * x,
            root(15.0) / 4.0 * (x * x - y * y),
        ]
    });
    assert_below(error, 5e-16, "Filament");
}

/// `_spherical_harmonics` before its normalisation, which is that of `component`.
fn e3nn([x, y, z]: [f64; 3]) -> Vec<f64> {
    let r = f64::sqrt;
    let (y2, x2z2) = (y * y, x * x + z * z);
    let two = [
        r(15.0) * x * z,
        r(15.0) * x * y,
        r(5.0) * (y2 - x2z2 / 2.0),
        r(15.0) * y * z,
        r(15.0) / 2.0 * (z * z - x * x),
    ];
    let mut out = vec![1.0, r(3.0) * x, r(3.0) * y, r(3.0) * z];
    out.extend(two);
    out.extend([
        r(42.0) / 6.0 * (two[0] * z + two[4] * x),
        r(7.0) * two[0] * y,
        r(168.0) / 8.0 * (4.0 * y2 - x2z2) * x,
        r(7.0) / 2.0 * y * (2.0 * y2 - 3.0 * x2z2),
        r(168.0) / 8.0 * z * (4.0 * y2 - x2z2),
        r(7.0) * two[4] * y,
        r(42.0) / 6.0 * (two[4] * z - two[0] * x),
    ]);
    out
}

#[test]
fn e3nn_in_its_three_normalizations() {
    assert_below(gap(Convention::E3NN_COMPONENT, 4, e3nn), 5e-15, "component");
    let over = |by: fn(usize) -> f64| {
        move |d| e3nn(d).into_iter().enumerate().map(|(i, y)| y / by(i.isqrt()).sqrt()).collect::<Vec<_>>()
    };
    assert_below(gap(Convention::E3NN_INTEGRAL, 4, over(|_| 4.0 * PI)), 2e-15, "integral");
    assert_below(gap(Convention::E3NN_NORM, 4, over(|l| (2 * l + 1) as f64)), 5e-15, "norm");
    // The vector itself is degree 1.
    assert!((Convention::E3NN_NORM.export_values(2, &e3nn_free([0.6, 0.0, 0.8]))[1] - 0.6).abs() < 1e-15);
}

fn e3nn_free([x, y, z]: [f64; 3]) -> Vec<f64> {
    haarmonic::sh::eval(2, &haarmonic::nalgebra::Unit::new_normalize(Vector3::new(x, y, z))).unwrap()
}

/// 4π-normalised, geodesy: the associated Legendre functions of degree 2 without (−1)^m, and `YilmIndexVector`.
#[test]
fn shtools() {
    let r = f64::sqrt;
    let error = gap(Convention::SHTOOLS, 3, |[x, y, z]| {
        let mut out = vec![f64::NAN; 9];
        // (cosine or sine, l, m) → l² + i·l + m.
        let mut put = |i: usize, l: usize, m: usize, value| out[l * l + i * l + m] = value;
        put(0, 0, 0, 1.0);
        put(0, 1, 0, r(3.0) * z);
        put(0, 1, 1, r(3.0) * x);
        put(1, 1, 1, r(3.0) * y);
        put(0, 2, 0, r(5.0) * (1.5 * z * z - 0.5));
        put(0, 2, 1, r(15.0) * x * z);
        put(1, 2, 1, r(15.0) * y * z);
        put(0, 2, 2, r(15.0) / 2.0 * (x * x - y * y));
        put(1, 2, 2, r(15.0) * x * y);
        out
    });
    assert_below(error, 2e-15, "SHTOOLS");
    // The constant function 1 has cilm[0, 0, 0] = 1.
    let one = Convention::SHTOOLS.export(1, &[(4.0 * PI).sqrt()]);
    assert!((one[0] - 1f64).abs() < 1e-15);
}

/// N3D by channel number, x forwards, y left, z up, from a direction in this crate's world.
fn n3d([x, y, z]: [f64; 3]) -> Vec<f64> {
    let ([x, y, z], r) = ([-z, -x, y], f64::sqrt);
    let (xx, yy, zz) = (x * x, y * y, z * z);
    vec![
        1.0,
        r(3.0) * y,
        r(3.0) * z,
        r(3.0) * x,
        r(15.0) * x * y,
        r(15.0) * y * z,
        r(5.0) / 2.0 * (3.0 * zz - 1.0),
        r(15.0) * x * z,
        r(15.0) / 2.0 * (xx - yy),
        r(35.0 / 8.0) * y * (3.0 * xx - yy),
        r(105.0) * x * y * z,
        r(21.0 / 8.0) * y * (5.0 * zz - 1.0),
        r(7.0) / 2.0 * z * (5.0 * zz - 3.0),
        r(21.0 / 8.0) * x * (5.0 * zz - 1.0),
        r(105.0) / 2.0 * z * (xx - yy),
        r(35.0 / 8.0) * x * (xx - 3.0 * yy),
    ]
}

#[test]
fn ambisonics() {
    assert_below(gap(Convention::AMBISONIC_N3D, 4, n3d), 5e-15, "N3D");
    let sn3d = |d| n3d(d).into_iter().enumerate().map(|(i, y)| y / ((2 * i.isqrt() + 1) as f64).sqrt()).collect();
    assert_below(gap(Convention::AMBIX, 4, sn3d), 5e-15, "AmbiX");
    // From FuMa to N3D by channel number, and the channel numbers of WXYZ RSTUV KLMNOPQ, as in decoders' tables.
    let to_n3d = [
        1.414213562,
        1.732050808,
        1.732050808,
        1.732050808,
        1.936491673,
        1.936491673,
        2.236067978,
        1.936491673,
        1.936491673,
        2.091650066,
        1.972026594,
        2.231093404,
        2.645751311,
        2.231093404,
        1.972026594,
        2.091650066,
    ];
    let channels = [0, 3, 1, 2, 6, 7, 5, 8, 4, 12, 13, 11, 14, 10, 15, 9];
    let fuma = |d| {
        let n3d = n3d(d);
        channels.iter().map(|&i| n3d[i] / to_n3d[i]).collect()
    };
    assert_below(gap(Convention::FUMA, 4, fuma), 2e-9, "FuMa");
    // maxN: the greatest value of each function is 1, W's 1/√2.
    let mut most = [0f64; 16];
    for d in fibonacci_directions(4000) {
        let y = haarmonic::sh::eval(4, &d).unwrap();
        let values = Convention::FUMA.export_values(4, &y);
        most.iter_mut().zip(values).for_each(|(most, v)| *most = most.max(v.abs()));
    }
    assert!((most[0] - 0.5f64.sqrt()).abs() < 1e-15);
    assert!(most[1..].iter().all(|most| (0.99..1.0 + 1e-15).contains(most)), "{most:?}");
    assert!(std::panic::catch_unwind(|| Convention::FUMA.export(5, &[0.0; 25])).is_err());
}

/// The table of `sph_harm_y`, θ from +z, φ from +x to +y.
#[test]
fn scipy() {
    let r = f64::sqrt;
    for d in fibonacci_directions(30) {
        let (cos, phi) = (d.z, d.y.atan2(d.x));
        let sin = (1.0 - cos * cos).sqrt();
        let turn = |m: f64| Complex::new((m * phi).cos(), (m * phi).sin());
        let theirs = [
            Complex::new(0.5 * r(1.0 / PI), 0.0),
            turn(-1.0) * (0.5 * r(1.5 / PI) * sin),
            Complex::new(0.5 * r(3.0 / PI) * cos, 0.0),
            turn(1.0) * (-0.5 * r(1.5 / PI) * sin),
        ];
        // A function by complex coefficients of theirs and by real ones of ours.
        let c = coefficients(2);
        let sum: Complex<f64> = to_complex(2, &c).iter().zip(theirs).map(|(a, y)| a * y).sum();
        let want: f64 = c.iter().zip(haarmonic::sh::eval(2, &d).unwrap()).map(|(c, y)| c * y).sum();
        assert!((sum - want).norm() < 1e-15, "{sum} {want}");
    }
    let c = coefficients(5);
    assert_below(worst(&from_complex(5, &to_complex(5, &c)), &c), 4e-16, "there and back");
}

/// The polynomials that Filament's and Unity's shaders sum: `renderPreScaledSH3Bands`, `SampleSH9`.
fn polynomials([x, y, z]: [f64; 3]) -> [f64; 9] {
    [1.0, y, z, x, x * y, y * z, 3.0 * z * z - 1.0, z * x, x * x - y * y]
}

/// E/π of the engine's own shader, in its own coordinates.
fn shaded(probe: DiffuseProbe, stored: &[f64; 9], n: [f64; 3]) -> f64 {
    let sum = |weights: [f64; 9]| stored.iter().zip(polynomials(n)).zip(weights).map(|((s, p), w)| s * p * w).sum();
    match probe {
        DiffuseProbe::Filament | DiffuseProbe::Unity => sum([1.0; 9]),
        DiffuseProbe::Godot => {
            sum([0.886227, 1.023327, 1.023327, 1.023327, 0.858086, 0.858086, 0.247708, 0.858086, 0.429043])
        }
    }
}

#[test]
fn probes_of_engines_shade_as_our_irradiance_over_pi() {
    let c: [f64; 9] = coefficients(3).try_into().unwrap();
    let irradiance = Irradiance::new([&c]);
    for (probe, tolerance) in
        [(DiffuseProbe::Filament, 1e-15), (DiffuseProbe::Unity, 1e-15), (DiffuseProbe::Godot, 1e-6)]
    {
        let stored = probe.from_radiance(&c);
        assert_below(worst(&probe.to_radiance(&stored), &c), 4e-16, "there and back");
        for d in fibonacci_directions(20) {
            let theirs = probe.axes().to_theirs(&d);
            let [e] = irradiance.eval(&d);
            let gap = shaded(probe, &stored, [theirs.x, theirs.y, theirs.z]) - e * FRAC_1_PI;
            assert!(gap.abs() < tolerance, "{probe:?} {d:?}: {gap:e}");
        }
        // Radiance 1 from everywhere gives 1 everywhere.
        let mut even = [0.0; 9];
        even[0] = (4.0 * PI).sqrt();
        assert!((shaded(probe, &probe.from_radiance(&even), [0.0, 0.0, 1.0]) - 1.0).abs() < 1e-6, "{probe:?}");
    }
}

/// The constants that HDRP divides Unity's probes by, with Sloan's signs, give Sloan's coefficients of radiance.
#[test]
fn unity_undoes_its_scale_to_sloans_coefficients() {
    let [c0, c1, c2, c3, c4] =
        [0.282094791773878143, 0.325735007935279947, 0.273137107648019767, 0.0788478913131300015, 0.136568553824009883];
    let constants = [c0, -c1, c1, -c1, c2, -c2, c3, -c2, c4];
    let c: [f64; 9] = coefficients(3).try_into().unwrap();
    let stored = DiffuseProbe::Unity.from_radiance(&c);
    let undone: Vec<f64> = stored.iter().zip(constants).map(|(s, k)| s / k).collect();
    let sloan = Convention { axes: Axes::LEFT_HANDED_Y_UP, ..Convention::SLOAN };
    assert_below(worst(&undone, &sloan.export(3, &c)), 4e-16, "UndoCosineRescaling");
}

/// Filament's `computeIrradianceSH3Bands` over a few lamps: A·polynomial, summed.
#[test]
fn filament_from_lamps() {
    let over = FRAC_1_PI * FRAC_1_PI / 4.0;
    let [c0, c1, c2] = [PI, 2.0 * PI / 3.0, PI / 4.0];
    let scale = [c0, 3.0 * c1, 3.0 * c1, 3.0 * c1, 15.0 * c2, 15.0 * c2, 1.25 * c2, 15.0 * c2, 3.75 * c2];
    let (mut theirs, mut radiance) = ([0.0; 9], [0.0; 9]);
    for (k, d) in fibonacci_directions(7).into_iter().enumerate() {
        let colour = 1.0 + k as f64;
        let p = polynomials([d.x, d.y, d.z]);
        theirs.iter_mut().zip(p).zip(scale).for_each(|((t, p), a)| *t += colour * over * a * p);
        let y = haarmonic::sh::eval(3, &d).unwrap();
        radiance.iter_mut().zip(y).for_each(|(r, y)| *r += colour * y);
    }
    assert_below(worst(&DiffuseProbe::Filament.from_radiance(&radiance), &theirs), 2e-15, "computeIrradianceSH3Bands");
}

const AXES: [SignedAxis; 6] =
    [SignedAxis::PosX, SignedAxis::NegX, SignedAxis::PosY, SignedAxis::NegY, SignedAxis::PosZ, SignedAxis::NegZ];

/// All 48: values in the convention are our functions of their coordinates.
#[test]
fn every_change_of_axes_evaluates_in_their_coordinates() {
    let bands = 6;
    let directions = fibonacci_directions(9);
    let all = AXES.into_iter().flat_map(|x| AXES.into_iter().flat_map(move |y| AXES.map(|z| [x, y, z])));
    let mut count = 0;
    for axes in all.filter_map(|axes| Axes::new(axes).ok()) {
        let convention = Convention { axes, ..Convention::default() };
        for d in &directions {
            let y = haarmonic::sh::eval(bands, d).unwrap();
            let there = haarmonic::nalgebra::Unit::new_unchecked(axes.to_theirs(d));
            let want = haarmonic::sh::eval(bands, &there).unwrap();
            assert_below(worst(&convention.export_values(bands, &y), &want), 4e-15, &format!("{axes:?}"));
            assert_below(worst(&convention.import_values(bands, &want), &y), 4e-15, &format!("{axes:?}"));
        }
        count += 1;
    }
    assert_eq!(count, 48);
}

#[test]
fn axes_that_keep_the_pole_are_exact_for_any_bands() {
    let bands = 200;
    let c = coefficients(bands);
    for axes in [Axes::LEFT_HANDED_Y_UP, Axes::new([SignedAxis::NegY, SignedAxis::PosX, SignedAxis::NegZ]).unwrap()] {
        let convention = Convention { axes, ..Convention::default() };
        let there = convention.export(bands, &c);
        assert_eq!(convention.import(bands, &there), c, "{axes:?}");
        let sizes = |c: &[f64]| {
            let mut sizes: Vec<f64> = c.iter().map(|c| c.abs()).collect();
            sizes.sort_by(f64::total_cmp);
            sizes
        };
        assert_eq!(sizes(&c), sizes(&there), "signs and places only");
    }
}

const PRESETS: [Convention; 11] = [
    Convention::SLOAN,
    Convention::THREE_JS,
    Convention::FILAMENT,
    Convention::GAUSSIAN_SPLATTING,
    Convention::E3NN_INTEGRAL,
    Convention::E3NN_COMPONENT,
    Convention::E3NN_NORM,
    Convention::SHTOOLS,
    Convention::AMBIX,
    Convention::AMBISONIC_N3D,
    Convention::FUMA,
];

#[test]
fn presets_of_no_and_one_band_and_of_wrong_lengths() {
    for convention in PRESETS {
        assert!(convention.export::<f64>(0, &[]).is_empty() && convention.import_values::<f32>(0, &[]).is_empty());
        let y0 = convention.export_values(1, &[(0.25 / PI).sqrt()])[0];
        let want = match convention.normalization {
            Normalization::Orthonormal => (0.25 / PI).sqrt(),
            Normalization::FourPi | Normalization::Schmidt => 1.0,
            Normalization::FurseMalham => 0.5f64.sqrt(),
        };
        assert!((y0 - want).abs() < 1e-15, "{convention:?}");
        for length in [0, 3, 5] {
            let vector = vec![1.0; length];
            let fails = |f: &dyn Fn() -> Vec<f64>| std::panic::catch_unwind(std::panic::AssertUnwindSafe(f)).is_err();
            assert!(fails(&|| convention.export(2, &vector)) && fails(&|| convention.import(2, &vector)));
            assert!(fails(&|| convention.export_values(2, &vector)) && fails(&|| convention.import_values(2, &vector)));
        }
    }
    let pole = Convention::E3NN_INTEGRAL;
    assert!(std::panic::catch_unwind(|| pole.export(129, &vec![0.0; 129 * 129])).is_err());
}

proptest! {
    #![proptest_config(cases(48))]

    /// A function has the same values by coefficients and functions of either side, in both precisions.
    #[test]
    fn presets_round_trip(which in 0..PRESETS.len(), bands in 1usize..=4, at in 0usize..50) {
        let (convention, c) = (PRESETS[which], coefficients(bands));
        let there = convention.export(bands, &c);
        prop_assert!(worst_of(convention.import(bands, &there).into_iter().zip(&c)) <= 2e-15);
        let single = convention.export(bands, &narrow::<f32>(&c));
        prop_assert!(worst_of(single.iter().map(|x| x.widen()).zip(&there)) <= 1e-6);
        let y = haarmonic::sh::eval(bands, &fibonacci_directions(50)[at]).unwrap();
        let values = convention.export_values(bands, &y);
        let sum: f64 = there.iter().zip(values).map(|(c, y)| c * y).sum();
        let want: f64 = c.iter().zip(&y).map(|(c, y)| c * y).sum();
        prop_assert!((sum - want).abs() <= 4e-15, "{sum} {want}");
    }
}
