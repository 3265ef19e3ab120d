//! Tables of BRDFs as harmonics against brute force, closed forms, and their own errors.

use std::f64::consts::PI;

use haarmonic::Error;
use haarmonic::nalgebra::Vector3;
use haarmonic::reference::scene::brdf_expansion;
use haarmonic::scene::{BlinnPhong, Brdf, BrdfExpansions, CookTorrance, Lambert, Ward};
use haarmonic::sh::Zonal;

use crate::support::{assert_all_close, assert_below, assert_close, largest};

fn rgb(table: &BrdfExpansions, wo: &Vector3<f64>) -> [Vec<f32>; 3] {
    let mut out = [0; 3].map(|_| vec![f32::NAN; table.bands() * table.bands()]);
    let [r, g, b] = &mut out;
    table.eval(&wo.cast(), [r, g, b]);
    out
}

/// A viewer on elevation k of n, at an azimuth.
fn viewer(k: usize, n: usize, azimuth: f64) -> Vector3<f64> {
    let (sin, cos) = (0.5 * PI * k as f64 / (n - 1) as f64).sin_cos();
    Vector3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
}

#[test]
fn lambert_is_the_clamped_cosine() {
    let albedo = [0.8, 0.4, 0.0];
    for bands in [1, 2, 3, 6] {
        let table = BrdfExpansions::new(&Lambert::new(albedo).unwrap(), bands, 3, 16).unwrap();
        assert_eq!((table.bands(), table.elevations()), (bands, 3));
        let cosine = Zonal::<f64>::clamped_cosine(bands).unwrap().coefficients();
        for wo in [viewer(0, 3, 0.0), viewer(1, 3, 2.0), Vector3::new(0.0, -0.6, 0.8)] {
            for (out, albedo) in rgb(&table, &wo).into_iter().zip(albedo) {
                let mut want = vec![0.0; bands * bands];
                (0..bands).for_each(|l| want[l * (l + 1)] = albedo / PI * cosine[l]);
                assert_all_close(&out, &want, 5e-8, &format!("{bands} {wo:?}"));
            }
        }
        // ∫ cos² over the hemisphere is 2π/3.
        let kept: f64 = cosine.iter().map(|c| c * c).sum();
        let want = (1.0 - kept / (2.0 * PI / 3.0)).sqrt();
        table.truncation_errors().iter().for_each(|&error| assert_close(error, want, 1e-12, "truncation"));
        table.interpolation_errors().iter().for_each(|&error| assert_below(error, 1e-14, "interpolation"));
    }
    // Three bands leave out 1/128 of the energy.
    let table = BrdfExpansions::new(&Lambert::new([1.0; 3]).unwrap(), 3, 2, 16).unwrap();
    assert_close(table.truncation_errors()[0], (1.0f64 / 128.0).sqrt(), 1e-12, "three bands");
}

fn is_the_twins(model: &dyn Brdf, bands: usize, steps: usize, tolerance: f64) {
    let (elevations, rings) = (5, 48);
    let table = BrdfExpansions::new(model, bands, elevations, rings).unwrap();
    for (k, azimuth) in [(0, 0.0), (1, 1.1), (3, -2.5)] {
        let wo = viewer(k, elevations, azimuth);
        let (mut left_out, mut whole) = (0.0, 0.0);
        for (channel, out) in rgb(&table, &wo).into_iter().enumerate() {
            let (want, energy) = brdf_expansion(bands, steps, |wi| model.eval(wi, &wo)[channel]);
            assert_all_close(&out, &want, tolerance * largest(&want), &format!("{model:?} {k} {channel}"));
            left_out += energy - want.iter().map(|c| c * c).sum::<f64>();
            whole += energy;
        }
        let error = (left_out / whole).sqrt();
        assert_close(table.truncation_errors()[k], error, 20.0 * tolerance, &format!("{model:?} {k}: error"));
    }
}

#[test]
fn glossy_models_are_the_twins() {
    is_the_twins(&BlinnPhong::new([0.6, 0.3, 0.1], 12.0).unwrap(), 5, 160, 2e-4);
    is_the_twins(&CookTorrance::new([0.9, 0.5, 0.2], 0.4, 0.4).unwrap(), 6, 160, 2e-4);
}

#[test]
fn errors_fall_with_bands_and_elevations() {
    let models: [&dyn Brdf; 2] =
        [&BlinnPhong::new([0.5; 3], 20.0).unwrap(), &CookTorrance::new([0.9; 3], 0.3, 0.3).unwrap()];
    for model in models {
        let errors = [2, 4, 6, 9].map(|bands| {
            let table = BrdfExpansions::new(model, bands, 4, 40).unwrap();
            table.truncation_errors().to_vec()
        });
        for k in 0..4 {
            assert!(errors.windows(2).all(|e| e[1][k] < e[0][k] && e[1][k] >= 0.0), "{model:?} {k}: {errors:?}");
        }
        assert!(errors[3][0] < 0.3 * errors[0][0], "{model:?}: {errors:?}");
        let gaps = [5, 9, 17].map(|elevations| {
            let table = BrdfExpansions::new(model, 5, elevations, 40).unwrap();
            assert_eq!(table.interpolation_errors().len(), elevations - 1);
            // Towards the horizon models bend without bound.
            largest(&table.interpolation_errors()[..(elevations - 1) / 2])
        });
        assert!(gaps.windows(2).all(|e| e[1] < 0.4 * e[0]), "{model:?}: {gaps:?}");
    }
}

#[test]
fn between_elevations_it_is_as_near_as_it_says() {
    let model = BlinnPhong::new([0.5, 0.2, 0.7], 20.0).unwrap();
    let (coarse, fine) =
        (BrdfExpansions::new(&model, 5, 5, 40).unwrap(), BrdfExpansions::new(&model, 5, 9, 40).unwrap());
    for (k, &said) in coarse.interpolation_errors().iter().enumerate() {
        let wo = viewer(2 * k + 1, 9, 0.7);
        let (mut off, mut kept) = (0.0, 0.0);
        for (a, b) in rgb(&coarse, &wo).iter().flatten().zip(rgb(&fine, &wo).iter().flatten()) {
            off += f64::from(a - b).powi(2);
            kept += f64::from(*b).powi(2);
        }
        // Of the whole: what the bands have, and what they leave out.
        let whole = kept / (1.0 - fine.truncation_errors()[2 * k + 1].powi(2));
        assert_close((off / whole).sqrt(), said, 1e-6, &format!("{k}"));
    }
}

#[test]
fn viewers_at_the_ends() {
    let table = BrdfExpansions::new(&BlinnPhong::new([0.5; 3], 9.0).unwrap(), 4, 6, 16).unwrap();
    for below in [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.6, 0.0, -0.8)] {
        assert!(rgb(&table, &below).iter().flatten().all(|c| *c == 0.0));
    }
    for nan in [Vector3::new(f64::NAN, 0.0, 1.0), Vector3::new(0.0, f64::INFINITY, 1.0)] {
        assert!(rgb(&table, &nan).iter().flatten().all(|c| c.is_nan()));
    }
    let grazing = rgb(&table, &Vector3::new(1.0, 0.0, 1e-20));
    assert!(grazing.iter().flatten().all(|c| c.is_finite()) && grazing[0][0] > 0.0);
    // At the normal nothing depends on the azimuth.
    assert!((0..16).filter(|i| ![0, 2, 6, 12].contains(i)).all(|i| rgb(&table, &Vector3::z())[1][i].abs() < 1e-7));
}

#[test]
fn what_cannot_be_tabulated_is_refused() {
    let lambert = Lambert::new([0.5; 3]).unwrap();
    for (bands, elevations, rings) in
        [(0, 2, 16), (33, 2, 64), (3, 1, 16), (3, 4097, 16), (3, 2, 2), (3, 2, 1025), (3, 0, 16)]
    {
        assert!(matches!(BrdfExpansions::new(&lambert, bands, elevations, rings), Err(Error::OutOfRange { .. })));
    }
    let brushed = Ward::new([0.4; 3], 0.1, 0.4).unwrap();
    assert!(matches!(BrdfExpansions::new(&brushed, 3, 2, 16), Err(Error::OutOfRange { .. })));
    let black = BrdfExpansions::new(&Lambert::new([0.0; 3]).unwrap(), 3, 2, 8).unwrap();
    assert_eq!((black.truncation_errors(), black.interpolation_errors()), (&[0.0; 2][..], &[0.0][..]));
}
