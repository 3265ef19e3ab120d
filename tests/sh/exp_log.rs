//! Exponentials, logarithms and functions of expansions against golden values, naive twins and their algebra.

use std::f64::consts::PI;
use std::panic::{AssertUnwindSafe, catch_unwind};

use haarmonic::nalgebra::{Rotation3, UnitVector3, Vector3};
use haarmonic::reference::sh as naive;
use haarmonic::sh::{
    CapFit, CapLog, ExpMethod, Exponential, GridFunction, LogMethod, Logarithm, OptimalLinear, Powers, Product,
    ProductSeries, ProductSpectrum, Square,
};
use haarmonic::sphere::SphereQuadrature;
use haarmonic::strategies::{discs, rotation, sh_visibility};
use haarmonic::{Error, Real};
use proptest::prelude::*;
use serde_json::Value;

use crate::support::{HARMONICS, assert_below, cases, golden, narrow, norm, number, numbers, random};

fn items(name: &str) -> Vec<Value> {
    let file = golden(HARMONICS, name);
    file["items"].as_array().or_else(|| file["hyb_items"].as_array()).unwrap().clone()
}

fn bands(v: &Value) -> usize {
    v["order"].as_u64().unwrap() as usize
}

/// ‖got − want‖/‖want‖.
fn relative<T: Real>(got: &[T], want: &[f64]) -> f64 {
    assert_eq!(got.len(), want.len());
    let difference: Vec<f64> = got.iter().zip(want).map(|(a, b)| a.widen() - b).collect();
    norm(&difference) / norm(want)
}

/// A plan whose scaled series makes as many squarings as the golden values had.
///
/// They differ from ours where ‖f̂‖ is 2^k/8 but for rounding, which the golden values counted as more.
fn as_golden<T: Real>(item: &Value, method: ExpMethod) -> Exponential<T> {
    let squarings = item["n_squarings"].as_u64().unwrap() as i32;
    let plan = Exponential::new(bands(item), method).unwrap();
    let scaled = number(&item["norm_f_hat"]) * 0.5f64.powi(squarings);
    if squarings > 0 && scaled < 0.0625 * (1.0 + 1e-9) { plan.with_scaled_norm(0.124).unwrap() } else { plan }
}

#[test]
fn golden_exponentials() {
    fn check<T: Real>(series: f64, scaled: f64, eigen: f64) {
        use ExpMethod::*;
        for item in items("sh_exp_log") {
            let f = numbers(&item["f"]);
            for (key, method, tolerance) in [
                ("ps_2", Series { degree: 2 }, series),
                ("ps_5", Series { degree: 5 }, series),
                ("ps_9", Series { degree: 9 }, series),
                ("psstar_2", ScaledSeries { degree: 2 }, scaled),
                ("psstar_3", ScaledSeries { degree: 3 }, scaled),
                ("psstar_9", ScaledSeries { degree: 9 }, scaled),
                ("exp_star_inf", Eigen, eigen),
            ] {
                let mut out = vec![T::nan(); f.len()];
                as_golden(&item, method).apply(&narrow::<T>(&f), &mut out);
                let what = format!("{key}, bands {}, norm {}", bands(&item), item["norm_f_hat"]);
                assert_below(relative(&out, &numbers(&item[key])), tolerance, &what);
            }
        }
    }
    // Each squaring doubles the relative error that is there: 6 squarings of a few eps.
    check::<f64>(6e-15, 6e-14, 1e-14);
    check::<f32>(3e-6, 3e-5, 3e-7);
}

#[test]
fn golden_hybrid() {
    let sources = items("sh_exp_log");
    for item in items("ol_hyb") {
        let source = &sources[item["sh_exp_log_item"].as_u64().unwrap() as usize];
        let f = numbers(&source["f"]);
        for tolerance in [1e-6, 3e-5] {
            let error = if tolerance < 2e-6 {
                let mut out = vec![0.0f64; f.len()];
                as_golden(source, ExpMethod::Hybrid).apply(&f, &mut out);
                relative(&out, &numbers(&item["hyb"]))
            } else {
                let mut out = vec![0.0f32; f.len()];
                as_golden(source, ExpMethod::Hybrid).apply(&narrow::<f32>(&f), &mut out);
                relative(&out, &numbers(&item["hyb"]))
            };
            assert_below(error, tolerance, &format!("bands {}, norm {}", f.len().isqrt(), norm(&f)));
        }
    }
}

#[test]
fn golden_optimal_linear_tables() {
    let file = golden(HARMONICS, "ol_hyb");
    for row in file["table"].as_array().unwrap() {
        let [a, b] = OptimalLinear::new(bands(row)).unwrap().factors(number(&row["norm_f_hat"]));
        let what = format!("bands {}, angle {}", bands(row), row["theta"]);
        assert_below((a - number(&row["a"])).abs(), 2e-6, &what);
        assert_below((b - number(&row["b"])).abs(), 2e-6, &what);
    }
}

#[test]
fn golden_logarithms() {
    for item in items("sh_exp_log") {
        let (g, n) = (numbers(&item["exp_star_inf"]), bands(&item));
        let (mut out, mut out32) = (vec![0.0; g.len()], vec![0.0f32; g.len()]);
        let log = Logarithm::new(n, LogMethod::default()).unwrap();
        log.apply(&g, &mut out).unwrap();
        log.apply(&narrow::<f32>(&g), &mut out32).unwrap();
        let want = numbers(&item["log_thesis_of_exp_star_inf"]);
        assert_below(relative(&out, &want), 1e-12, "log");
        // What is known to 6e-8 has eigenvalues known to that, the smallest of them 0.02.
        assert_below(relative(&out32, &want), 1e-5, "log of f32");
        let spectrum = ProductSpectrum::new(&Product::new(n, n, n).unwrap(), &g).unwrap();
        let floor = 0.02 * spectrum.largest();
        let matrix = spectrum.apply(|x| x.max(floor).ln());
        assert_below(relative(&matrix, &numbers(&item["log_matrix_of_exp_star_inf"])), 1e-12, "log(M)1");
    }
}

#[test]
fn golden_discs() {
    for n in [3, 4, 6] {
        let table = CapLog::new(n, CapFit::default()).unwrap();
        assert_below(table.error(), 1e-6, "table");
        let (log, product) = (Logarithm::new(n, LogMethod::default()).unwrap(), Product::new(n, n, n).unwrap());
        for item in items("circle_blocker").iter().filter(|item| bands(item) == n) {
            let g = numbers(&item["g_zonal"]);
            let (theta, want) = (number(&item["theta"]), numbers(&item["log_thesis_zonal"]));
            let what = format!("bands {n}, angle {theta}");
            let (mut zonal, mut tabulated) = (vec![0.0; n], vec![0.0; n]);
            log.apply_zonal(&g, &mut zonal).unwrap();
            // The smallest disc's log is 4e-4: eps/4e-4.
            assert_below(relative(&zonal, &want), 2e-12, &what);
            table.eval(theta, &mut tabulated);
            let scale = (1.0 - theta.cos()) * n as f64;
            assert_below(relative(&tabulated, &want) * norm(&want), 1e-6 * scale, &what);
            let mut full = vec![0.0; n * n];
            g.iter().enumerate().for_each(|(l, &g)| full[l * l + l] = g);
            let spectrum = ProductSpectrum::new(&product, &full).unwrap();
            assert_below((spectrum.largest() - number(&item["eig_max"])).abs(), 1e-14, &what);
            let smallest = spectrum.eigenvalues().iter().copied().fold(f64::INFINITY, f64::min);
            assert_below((smallest - number(&item["eig_min"])).abs(), 1e-14, &what);
        }
    }
}

/// All methods, and that with fewer squarings.
fn methods() -> Vec<ExpMethod> {
    use ExpMethod::*;
    let scaled = [1, 2, 3, 4, 9, 16].map(|degree| ScaledSeries { degree });
    let plain = [0, 1, 2, 5, 9].map(|degree| Series { degree });
    [&scaled[..], &plain, &[OptimalLinear, Hybrid, Eigen, Grid]].concat()
}

fn exp<T: Real>(f: &[f64], method: ExpMethod) -> Vec<T> {
    let mut out = vec![T::nan(); f.len()];
    Exponential::new(f.len().isqrt(), method).unwrap().apply(&narrow::<T>(f), &mut out);
    out
}

/// Random coefficients with a given norm.
fn of_norm(bands: usize, length: f64, seed: u64) -> Vec<f64> {
    let x = random(bands * bands, seed);
    let factor = length / norm(&x);
    x.into_iter().map(|x| x * factor).collect()
}

fn one(bands: usize) -> Vec<f64> {
    let mut one = vec![0.0; bands * bands];
    one[0] = 4.0 / std::f64::consts::FRAC_2_SQRT_PI;
    one
}

#[test]
fn exponentials_are_those_of_the_twins() {
    for bands in 1..=5 {
        for (seed, length) in [0.0, 1e-6, 0.1, 0.9, 3.0, 6.0].into_iter().enumerate() {
            let f = of_norm(bands, length, seed as u64 + 7);
            let scale = naive::exp_limit(&f);
            for degree in [1, 2, 3, 4, 7] {
                let what = format!("degree {degree}, bands {bands}, norm {length}");
                let want = naive::exp_series(&f, degree);
                assert_below(relative(&exp::<f64>(&f, ExpMethod::Series { degree }), &want), 1e-14, &what);
                let want = naive::exp_scaled_series(&f, degree, 0.125);
                assert_below(relative(&exp::<f64>(&f, ExpMethod::ScaledSeries { degree }), &want), 2e-13, &what);
                let want = naive::exp_scaled_series(&f, degree, 0.5);
                let plan = Exponential::new(bands, ExpMethod::ScaledSeries { degree }).unwrap();
                let mut out = vec![f64::NAN; f.len()];
                plan.with_scaled_norm(0.5).unwrap().apply(&f, &mut out);
                assert_below(relative(&out, &want), 2e-13, &what);
            }
            let what = format!("bands {bands}, norm {length}");
            assert_below(relative(&exp::<f64>(&f, ExpMethod::Eigen), &scale), 1e-13, &what);
            let squares = naive::function_projected(&f, f64::exp, 2 * bands);
            // One grid, two sets of azimuths: what they make of the degrees beyond the grid differs.
            let truth = naive::exp_projected(&f);
            let grid = exp::<f64>(&f, ExpMethod::Grid);
            assert_below(relative(&grid, &truth), 4.0 * relative(&squares, &truth) + 1e-14, &what);
        }
    }
}

#[test]
fn exp_of_nothing_is_one() {
    fn check<T: Real>() {
        for bands in [1, 2, 3, 6, 9] {
            let want = narrow::<T>(&one(bands));
            for method in methods() {
                let got = exp::<T>(&vec![0.0; bands * bands], method);
                let what = format!("{method:?}, bands {bands}");
                match method {
                    ExpMethod::Grid | ExpMethod::Eigen => {
                        assert_below(relative(&got, &one(bands)), 4.0 * T::epsilon().widen(), &what);
                    }
                    _ => assert_eq!(got, want, "{what}"),
                }
            }
        }
    }
    check::<f32>();
    check::<f64>();
}

#[test]
fn exp_of_a_constant_is_its_exp() {
    for bands in [1, 2, 5] {
        for c in [-40.0, -3.0, 1e-9, 0.7, 5.0] {
            let f: Vec<f64> = one(bands).into_iter().map(|x| x * c).collect();
            let want: Vec<f64> = one(bands).into_iter().map(|x| x * f64::exp(c)).collect();
            for method in methods().into_iter().filter(|m| !matches!(m, ExpMethod::Series { .. })) {
                let what = format!("{method:?}, bands {bands}, {c}");
                // An eigenvalue is known to eps times it.
                assert_below(relative(&exp::<f64>(&f, method), &want), 4e-14, &what);
                assert_below(relative(&exp::<f32>(&f, method), &want), 1e-5, &what);
            }
        }
    }
}

/// Coefficients of f(R⁻¹ω).
fn rotated(f: &[f64], rotation: &Rotation3<f64>) -> Vec<f64> {
    let bands = f.len().isqrt();
    let rule = SphereQuadrature::new(2 * bands).unwrap();
    let mut out = vec![0.0; f.len()];
    for (d, weight) in rule.directions().iter().zip(rule.weights()) {
        let there = naive::basis(bands, &UnitVector3::new_normalize(rotation.inverse() * d.into_inner()));
        let value: f64 = f.iter().zip(there).map(|(f, y)| f * y).sum();
        out.iter_mut().zip(naive::basis(bands, d)).for_each(|(out, y)| *out += weight * value * y);
    }
    out
}

proptest! {
    #![proptest_config(cases(48))]

    /// Products do not know how the axes lie; the grid has a pole, whose mark is its error.
    #[test]
    fn functions_turn_with_their_arguments(rotation in rotation(), bands in 1..=5usize, length in 0.01..5.0f64, seed: u64) {
        let f = of_norm(bands, length, seed);
        let turned = rotated(&f, &rotation);
        for method in methods() {
            let tolerance = if method == ExpMethod::Grid {
                4.0 * relative(&exp::<f64>(&f, method), &naive::function_projected(&f, f64::exp, 24)) + 2e-3
            } else {
                1e-12
            };
            let want = rotated(&exp::<f64>(&f, method), &rotation);
            assert_below(relative(&exp::<f64>(&turned, method), &want), tolerance, &format!("{method:?}"));
        }
        let log = Logarithm::new(bands, LogMethod::default()).unwrap();
        let g = exp::<f64>(&f, ExpMethod::Eigen);
        let (mut first, mut second) = (vec![0.0; g.len()], vec![0.0; g.len()]);
        log.apply(&g, &mut first).unwrap();
        log.apply(&rotated(&g, &rotation), &mut second).unwrap();
        // The largest ratio of slopes of the logarithm is that at the floor.
        assert_below(relative(&second, &rotated(&first, &rotation)), 1e-9, "log");
    }

    /// Where nothing is clipped, exp(M_f)1 takes the logarithm back.
    #[test]
    fn exp_of_log_is_the_visibility(g in sh_visibility(4)) {
        let (mut f, log) = (vec![0.0; 16], Logarithm::new(4, LogMethod::default()).unwrap());
        if log.apply(&g, &mut f).is_err() {
            // Everything is hidden.
            prop_assert!(g.iter().all(|x| x.abs() < 1e-12), "{g:?}");
            return Ok(());
        }
        prop_assert!(f.iter().all(|x| x.is_finite()), "{f:?}");
        let spectrum = ProductSpectrum::new(&Product::new(4, 4, 4).unwrap(), &g).unwrap();
        let clipped = spectrum.eigenvalues().iter().any(|&x| x < 0.02 * spectrum.largest());
        for method in methods() {
            prop_assert!(exp::<f64>(&f, method).iter().all(|x| x.is_finite()));
        }
        let back = relative(&exp::<f64>(&f, ExpMethod::Eigen), &g);
        // What is clipped was up to |λ| below the floor; measured 0.4 for visibility of a few slits.
        prop_assert!(back < if clipped { 1.0 } else { 2e-2 }, "{back}");
    }

    #[test]
    fn the_twins_agree_on_logarithms(discs in discs(4)) {
        let g = naive::union_visibility(3, &discs, 16);
        let mut out = [0.0; 9];
        Logarithm::new(3, LogMethod::default()).unwrap().apply(&g, &mut out).unwrap();
        let want = naive::log_by_eigenvalues(&g, 0.02);
        assert_below(relative(&out, &want) * norm(&want), 1e-10 * (1.0 + norm(&want)), "log");
    }
}

#[test]
fn finite_input_gives_finite_output() {
    fn check<T: Real>(largest: f64) {
        for bands in [2, 3, 6, 8] {
            for length in [8.0, 50.0, 400.0, 1e6, largest / 100.0] {
                let mut inputs = vec![of_norm(bands, length, 3), of_norm(bands, length, 4)];
                // A peak in one direction, upwards and downwards: the most that a norm can do.
                let peak = naive::basis(bands, &UnitVector3::new_normalize(Vector3::new(0.3, -0.5, 0.7)));
                let factor = length / norm(&peak);
                inputs.push(peak.iter().map(|x| x * factor).collect());
                inputs.push(peak.iter().map(|x| -x * factor).collect());
                for sign in [1.0, -1.0] {
                    let mut constant = vec![0.0; bands * bands];
                    constant[0] = sign * length;
                    inputs.push(constant);
                }
                for f in &inputs {
                    for method in methods().into_iter().filter(|m| !matches!(m, ExpMethod::Series { .. })) {
                        let out = exp::<T>(f, method);
                        assert!(out.iter().all(|x| x.is_finite()), "{method:?}, bands {bands}, norm {length}: {out:?}");
                    }
                }
            }
        }
    }
    check::<f32>(f64::from(f32::MAX));
    check::<f64>(f64::MAX);
}

#[test]
fn powers_beyond_the_range_are_scaled() {
    // At ‖f̂‖ = 50 a peak of 8 bands may be e^113, beyond f32: with a constant that takes it down f32 must give what
    // f64 does.
    let peak = naive::basis(8, &UnitVector3::new_normalize(Vector3::new(-0.2, 0.4, 0.5)));
    let mut f: Vec<f64> = peak.iter().map(|y| 50.0 * y / norm(&peak)).collect();
    f[0] -= 45.0 * (4.0 * PI).sqrt();
    for method in [ExpMethod::ScaledSeries { degree: 2 }, ExpMethod::Hybrid, ExpMethod::ScaledSeries { degree: 9 }] {
        let (wide, narrow) = (exp::<f64>(&f, method), exp::<f32>(&f, method));
        assert_below(relative(&narrow, &wide), 1e-3, &format!("{method:?}"));
        assert!((1e-3..1e30).contains(&norm(&wide)), "{method:?}: {}", norm(&wide));
    }
    // The scaled path of f64 against the plain one of a constant's worth less: only rounding differs.
    let mut g: Vec<f64> = peak.iter().map(|y| 400.0 * y / norm(&peak)).collect();
    g[0] = -600.0 * (4.0 * PI).sqrt();
    let far = exp::<f64>(&g, ExpMethod::ScaledSeries { degree: 4 });
    assert!(far.iter().all(|x| x.is_finite()) && norm(&far) > 0.0);
}

#[test]
fn what_is_not_finite_reaches_every_coefficient() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for at in [0, 1, 8] {
            let mut f = of_norm(3, 1.0, 5);
            f[at] = bad;
            for method in methods().into_iter().filter(|m| !matches!(m, ExpMethod::Series { .. })) {
                let (wide, narrow) = (exp::<f64>(&f, method), exp::<f32>(&f, method));
                assert!(wide.iter().all(|x| x.is_nan()), "{method:?}, {bad} at {at}: {wide:?}");
                assert!(narrow.iter().all(|x| x.is_nan()), "{method:?}, {bad} at {at}: {narrow:?}");
            }
        }
    }
}

#[test]
fn batches_have_the_bits_of_single_vectors() {
    fn check<T: Real>() {
        for (bands, counts) in [(1, &[0, 1, 2, 40][..]), (3, &[0, 1, 15, 16, 17, 32, 33, 70]), (6, &[1, 3, 33])] {
            for &count in counts {
                let mut vectors: Vec<Vec<f64>> =
                    (0..count).map(|v| of_norm(bands, [0.1, 0.0, 3.0, 7.0, 300.0][v % 5], v as u64)).collect();
                if let Some(last) = vectors.last_mut().filter(|_| count > 2) {
                    last[0] = f64::NAN;
                }
                let rows: Vec<T> = (0..bands * bands * count).map(|i| T::of(vectors[i % count][i / count])).collect();
                for method in methods() {
                    let plan = Exponential::<T>::new(bands, method).unwrap();
                    let (mut out, mut scratch) = (vec![T::one(); rows.len()], vec![T::nan(); plan.scratch_len()]);
                    plan.apply_batch(count, &rows, &mut out, &mut scratch);
                    for (v, f) in vectors.iter().enumerate() {
                        let single: Vec<u64> = exp::<T>(f, method).iter().map(|x| x.widen().to_bits()).collect();
                        let column: Vec<u64> = out[v..].iter().step_by(count).map(|x| x.widen().to_bits()).collect();
                        assert_eq!(column, single, "{method:?}, bands {bands}, vector {v} of {count}");
                    }
                }
                let grid = GridFunction::<T>::new(bands).unwrap();
                let (mut out, mut single) = (vec![T::one(); rows.len()], vec![T::one(); bands * bands]);
                let h = |x: T| x * x - x;
                grid.apply_batch(count, &rows, h, &mut out);
                for (v, f) in vectors.iter().enumerate().filter(|(_, f)| !f[0].is_nan()) {
                    grid.apply(&narrow::<T>(f), h, &mut single);
                    assert!(out[v..].iter().step_by(count).eq(&single), "grid, bands {bands}, vector {v} of {count}");
                }
            }
        }
    }
    check::<f32>();
    check::<f64>();
}

#[test]
fn series_are_polynomials_of_the_product_matrix() {
    for bands in [1, 2, 4] {
        let f = of_norm(bands, 1.7, 9);
        let spectrum = ProductSpectrum::new(&Product::new(bands, bands, bands).unwrap(), &f).unwrap();
        for terms in [1, 2, 3, 4, 8] {
            let h = random(terms, 20 + terms as u64);
            let want = spectrum.apply(|x| h.iter().rev().fold(0.0, |sum, h| sum * x + h));
            let mut out = vec![f64::NAN; f.len()];
            let series = ProductSeries::new(bands, &h, Powers::LeftToRight).unwrap();
            series.apply(&f, &mut out);
            assert_below(relative(&out, &want), 2e-14, &format!("bands {bands}, {terms} terms"));
            assert_eq!(series.products(), terms.saturating_sub(2));
            // Up to the third power there is one way to group them.
            let even = ProductSeries::new(bands, &h, Powers::EvenOdd).unwrap();
            even.apply(&f, &mut out);
            if terms <= 4 {
                assert_below(relative(&out, &want), 2e-14, &format!("even and odd, bands {bands}, {terms} terms"));
            }
        }
    }
    let products = |degree| ProductSeries::<f64>::exp(2, degree, Powers::EvenOdd).unwrap().products();
    assert_eq!([0, 1, 2, 3, 4, 5, 6, 7, 9].map(products), [0, 0, 1, 2, 3, 3, 4, 4, 5]);
}

#[test]
fn grids_give_any_function() {
    for bands in 1..=6 {
        let f = of_norm(bands, 1.0, 2);
        let grid = GridFunction::<f64>::new(bands).unwrap();
        let (mut out, mut square) = (vec![f64::NAN; f.len()], vec![f64::NAN; f.len()]);
        // Degree 3 bands − 3 is within the grid's.
        grid.apply(&f, |x| x * x, &mut out);
        Square::new(bands, bands).unwrap().apply(&f, &mut square);
        assert_below(relative(&out, &square), 1e-14, "square");
        grid.apply(&f, |x| x, &mut out);
        assert_below(relative(&out, &f), 1e-14, "identity");
        let fine = GridFunction::<f64>::with_rings(bands, 36).unwrap();
        fine.apply(&f, |x| (2.0 * x).sin() / (2.0 + x * x), &mut out);
        let want = naive::function_projected(&f, |x| (2.0 * x).sin() / (2.0 + x * x), 40);
        assert_below(relative(&out, &want), 1e-10, "a function");
        let mut coarse = vec![0.0f32; f.len()];
        GridFunction::<f32>::with_rings(bands, 36).unwrap().apply(
            &narrow::<f32>(&f),
            |x| (2.0 * x).sin() / (2.0 + x * x),
            &mut coarse,
        );
        assert_below(relative(&coarse, &want), 2e-6, "a function in f32");
    }
    assert_eq!(GridFunction::<f32>::new(6).unwrap().points(), 288);
}

#[test]
fn spectra_give_any_function() {
    for bands in [1, 2, 4] {
        let f = of_norm(bands, 2.0, 11);
        let (product, v) = (Product::new(bands, bands, bands).unwrap(), random(bands * bands, 12));
        let spectrum = ProductSpectrum::new(&product, &f).unwrap();
        let (mut values, vectors) = naive::product_eigen(&f);
        let mut want = vec![0.0; f.len()];
        for (value, vector) in values.iter().zip(&vectors) {
            let along: f64 = vector.iter().zip(&v).map(|(a, b)| a * b).sum();
            want.iter_mut().zip(vector).for_each(|(w, x)| *w += (2.0 * value).sin() * along * x);
        }
        assert_below(relative(&spectrum.multiply(|x| (2.0 * x).sin(), &v), &want), 1e-13, "sin(2 M) v");
        let mut product_of = vec![0.0; f.len()];
        product.apply(&f, &v, &mut product_of);
        assert_below(relative(&spectrum.multiply(|x| x, &v), &product_of), 1e-14, "M v");
        let mut got = spectrum.eigenvalues().to_vec();
        got.sort_by(f64::total_cmp);
        values.sort_by(f64::total_cmp);
        assert_below(relative(&got, &values), 1e-14, "eigenvalues");
    }
    let product = Product::new(2, 2, 2).unwrap();
    assert!(matches!(ProductSpectrum::new(&product, &[0.0; 3]), Err(Error::Length { .. })));
    assert!(matches!(
        ProductSpectrum::new(&product, &[0.0, f64::NAN, 0.0, 0.0]),
        Err(Error::NotFinite { index: 1, .. })
    ));
    assert!(matches!(ProductSpectrum::new(&Product::new(2, 2, 3).unwrap(), &[0.0; 4]), Err(Error::Length { .. })));
    let huge = ProductSpectrum::new(&product, &[1e300, 1e299, -3e299, 0.0]).unwrap();
    let tiny = ProductSpectrum::new(&product, &[1e-300, 1e-301, -3e-301, 0.0]).unwrap();
    let ratio = huge.largest() / 1e300 / (tiny.largest() / 1e-300);
    assert_below((ratio - 1.0).abs(), 1e-14, "huge and tiny");
}

#[test]
fn logarithms_of_what_has_none() {
    for method in [LogMethod::default(), LogMethod::Clipped { floor: 0.02 }] {
        let log = Logarithm::new(3, method).unwrap();
        let mut out = [0.0; 9];
        assert!(matches!(log.apply(&[0.0; 9], &mut out), Err(Error::OutOfRange { .. })));
        assert!(matches!(log.apply_zonal(&[0.0; 3], &mut [0.0; 3]), Err(Error::OutOfRange { .. })));
        let dark: Vec<f64> = one(3).iter().map(|x| -x).collect();
        assert!(matches!(log.apply(&dark, &mut out), Err(Error::OutOfRange { .. })));
        assert!(matches!(log.apply(&[f64::NAN; 9], &mut out), Err(Error::NotFinite { index: 0, .. })));
        let panics = |g: &[f64], out: &mut [f64]| catch_unwind(AssertUnwindSafe(|| log.apply(g, out))).is_err();
        assert!(panics(&[0.0; 4], &mut [0.0; 9]) && panics(&[1.0; 9], &mut [0.0; 4]) && !panics(&[1.0; 9], &mut out));
        // Far more below 0 than above.
        let mut lobes = of_norm(3, 5.0, 1);
        lobes[0] = 0.1;
        log.apply(&lobes, &mut out).unwrap();
        assert!(out.iter().all(|x| x.is_finite()), "{out:?}");
        // A constant of any size: log c.
        for c in [1e-30, 0.25, 1.0, 7.0, 1e30] {
            let g: Vec<f64> = one(3).iter().map(|x| c * x).collect();
            log.apply(&g, &mut out).unwrap();
            let want: Vec<f64> = one(3).iter().map(|x| x * f64::ln(c)).collect();
            assert_below(
                norm(&out.iter().zip(&want).map(|(a, b)| a - b).collect::<Vec<_>>()),
                1e-13 * (1.0 + norm(&want)),
                "log c",
            );
            let mut zonal = [0.0; 3];
            log.apply_zonal(&[g[0], 0.0, 0.0], &mut zonal).unwrap();
            assert_below((zonal[0] - want[0]).abs(), 1e-13 * (1.0 + norm(&want)), "zonal log c");
        }
    }
}

/// The reason for eigenvalues: the round trip of a middling disc, each log with the exp that belongs to it
/// [docs/errata.md].
#[test]
fn eigenvalues_come_back_where_clipped_values_do_not() {
    let mut g = vec![0.0; 16];
    let axis = UnitVector3::new_normalize(Vector3::new(1.0, -2.0, 0.5));
    g.copy_from_slice(&naive::cap_visibility(4, &axis, 0.5));
    let mut f = vec![0.0; 16];
    Logarithm::new(4, LogMethod::default()).unwrap().apply(&g, &mut f).unwrap();
    let eigenvalues = relative(&exp::<f64>(&f, ExpMethod::ScaledSeries { degree: 3 }), &g);
    Logarithm::new(4, LogMethod::Clipped { floor: 0.02 }).unwrap().apply(&g, &mut f).unwrap();
    let clipped = relative(&exp::<f64>(&f, ExpMethod::ScaledSeries { degree: 3 }), &g);
    assert_below(eigenvalues, 1e-4, "eigenvalues");
    assert!(clipped > 5e-3, "{clipped}");
}

#[test]
fn zonal_logarithms_are_logarithms() {
    for bands in [1, 2, 3, 6] {
        let log = Logarithm::new(bands, LogMethod::default()).unwrap();
        for theta in [1e-3, 0.3, 0.6, 1.0, 1.5, 2.4] {
            let g = naive::cap_visibility(bands, &Vector3::z_axis(), theta);
            let (mut full, mut zonal) = (vec![0.0; bands * bands], vec![0.0; bands]);
            log.apply(&g, &mut full).unwrap();
            let of_zonal: Vec<f64> = (0..bands).map(|l| g[l * l + l]).collect();
            log.apply_zonal(&of_zonal, &mut zonal).unwrap();
            let mut want = vec![0.0; bands * bands];
            zonal.iter().enumerate().for_each(|(l, &f)| want[l * l + l] = f);
            let what = format!("bands {bands}, angle {theta}");
            assert_below(relative(&full, &want) * norm(&want), 1e-12 * (1.0 + norm(&want)), &what);
        }
    }
}

#[test]
fn tables_of_discs_are_the_logarithms_of_discs() {
    for bands in [1, 2, 3, 4, 6, 7] {
        let table = CapLog::new(bands, CapFit::default()).unwrap();
        let log = Logarithm::new(bands, LogMethod::default()).unwrap();
        let (mut got, mut want) = (vec![0.0; bands], vec![0.0; bands]);
        // The kinks of bands 3, 4, 6 among them.
        let beside = [1.13, 1.1299, 0.854, 0.8541, 0.571, 0.57105, 1e-3, 2.5];
        for theta in (1..250).map(|k| f64::from(k) * 0.01).chain(beside) {
            let g = naive::cap_visibility(bands, &Vector3::z_axis(), theta);
            let zonal: Vec<f64> = (0..bands).map(|l| g[l * l + l]).collect();
            log.apply_zonal(&zonal, &mut want).unwrap();
            table.eval(theta, &mut got);
            for (got, want) in got.iter().zip(&want) {
                let tolerance = 2e-6 * (1.0 - theta.cos()) + 1e-14;
                assert_below((got - want).abs(), tolerance, &format!("bands {bands}, angle {theta}"));
            }
        }
    }
}

#[test]
fn fitted_discs_are_what_the_pointwise_exp_takes_back() {
    for bands in [1, 2, 3, 6, 8] {
        let table = CapLog::new(bands, CapFit::Grid).unwrap();
        for theta in [1e-4, 0.02, 0.3, 0.7, 1.2, PI / 2.0] {
            let mut zonal = vec![0.0; bands];
            table.eval(theta, &mut zonal);
            let mut f = vec![0.0; bands * bands];
            zonal.iter().enumerate().for_each(|(l, &x)| f[l * l + l] = x);
            let want = naive::cap_visibility(bands, &Vector3::z_axis(), theta);
            let got = naive::exp_projected(&f);
            let difference: Vec<f64> = got.iter().zip(&want).map(|(a, b)| a - b).collect();
            // The table's error times exp(f) ≤ about 1; what the twin's rule leaves.
            assert_below(
                norm(&difference),
                if bands > 6 { 4e-4 } else { 5e-5 } * (1.0 - theta.cos()) + 1e-12,
                &format!("bands {bands}, angle {theta}"),
            );
        }
    }
}

#[test]
fn tables_of_discs_at_and_beyond_their_ends() {
    for fit in [CapFit::default(), CapFit::Grid] {
        let table = CapLog::new(4, fit).unwrap();
        let at = |theta: f64| {
            let mut out = [0.0; 4];
            table.eval(theta, &mut out);
            out
        };
        assert_eq!((at(0.0), at(-1.0)), ([0.0; 4], [0.0; 4]));
        assert_eq!((at(3.1), at(f64::INFINITY)), (at(table.largest()), at(table.largest())));
        assert!(at(f64::NAN).iter().all(|x| x.is_nan()));
        // A point that hides: f → g − 1 = −y(z) times its solid angle.
        let tiny = at(1e-7);
        for (l, f) in tiny.iter().enumerate() {
            let want = -(PI * 1e-14) * ((2 * l + 1) as f64 / (4.0 * PI)).sqrt();
            assert_below((f / want - 1.0).abs(), 3e-5, &format!("degree {l}"));
        }
        let narrow = CapLog::new(4, fit).unwrap();
        let mut out = [0.0f32; 4];
        narrow.eval(0.5, &mut out);
        assert_below(relative(&out, &at(0.5)), 1e-6, "f32");
    }
    for floor in [0.0, 1.0, f64::NAN, -0.1] {
        assert!(matches!(CapLog::new(3, CapFit::Products { floor }), Err(Error::OutOfRange { .. })));
        assert!(matches!(Logarithm::new(3, LogMethod::Eigenvalues { floor }), Err(Error::OutOfRange { .. })));
    }
    assert!(matches!(CapLog::new(9, CapFit::Grid), Err(Error::OutOfRange { .. })));
}

#[test]
fn committed_tables_are_fitted_ones() {
    for bands in [2, 4] {
        let (committed, fitted) = (OptimalLinear::new(bands).unwrap(), OptimalLinear::fit(bands).unwrap());
        for (a, b) in [(committed.table().0, fitted.table().0), (committed.table().1, fitted.table().1)] {
            assert_eq!(a.len(), b.len());
            a.iter().zip(b).for_each(|(a, b)| assert_below((a - b).abs(), 1e-9, "table"));
        }
    }
}

#[test]
fn optimal_linear_factors_are_the_best_ones() {
    for bands in [2, 3, 5] {
        let linear = OptimalLinear::new(bands).unwrap();
        let log = Logarithm::new(bands, LogMethod::default()).unwrap();
        for theta in [0.02, 0.4, 0.9] {
            let mut f = vec![0.0; bands * bands];
            let axis = UnitVector3::new_normalize(Vector3::new(0.3, 0.2, -0.6));
            log.apply(&naive::cap_visibility(bands, &axis, theta), &mut f).unwrap();
            let [a, b] = naive::optimal_linear(&f);
            let [got_a, got_b] = linear.factors(norm(&f[1..]));
            assert_below((got_a - a).abs().max((got_b - b).abs()), 2e-6, &format!("bands {bands}, angle {theta}"));
        }
        assert_eq!(linear.factors(0.0), [1.0, 1.0]);
        assert_eq!(linear.factors(1e300), linear.factors(linear.end()));
        assert!(linear.factors(f64::NAN).iter().all(|x| x.is_nan()));
    }
    assert_eq!(OptimalLinear::new(1).unwrap().factors(0.0), [1.0, 1.0]);
    assert_eq!(OptimalLinear::new(9).unwrap().factors(0.0), [1.0, 1.0]);
}

#[test]
fn plans_refuse_what_they_cannot_do() {
    for bands in [0, 33, usize::MAX] {
        for method in methods() {
            assert!(matches!(Exponential::<f32>::new(bands, method), Err(Error::OutOfRange { what: "bands", .. })));
        }
        assert!(matches!(Logarithm::new(bands, LogMethod::default()), Err(Error::OutOfRange { .. })));
        assert!(matches!(CapLog::new(bands, CapFit::default()), Err(Error::OutOfRange { .. })));
        assert!(matches!(GridFunction::<f32>::new(bands), Err(Error::OutOfRange { .. })));
        assert!(matches!(OptimalLinear::new(bands), Err(Error::OutOfRange { .. })));
    }
    for method in [ExpMethod::Series { degree: 17 }, ExpMethod::ScaledSeries { degree: usize::MAX }] {
        assert!(matches!(Exponential::<f64>::new(2, method), Err(Error::OutOfRange { .. })));
    }
    let plan = || Exponential::<f64>::new(2, ExpMethod::default()).unwrap();
    for norm in [0.0, -1.0, f64::NAN, 9.0] {
        assert!(plan().with_scaled_norm(norm).is_err());
    }
    for rings in [0, 3, 5, 130] {
        assert!(GridFunction::<f64>::with_rings(4, rings).is_err());
    }
    let series = |h: &[f64]| ProductSeries::<f64>::new(2, h, Powers::EvenOdd);
    assert!(matches!(series(&[]), Err(Error::Empty { .. })));
    assert!(matches!(series(&[1.0, f64::NAN]), Err(Error::NotFinite { index: 1, .. })));
    assert!(matches!(series(&[1.0; 18]), Err(Error::OutOfRange { .. })));
}

#[test]
#[should_panic(expected = "logarithm: expected length 9, got 4")]
fn wrong_lengths_panic() {
    Exponential::<f64>::new(3, ExpMethod::default()).unwrap().apply(&[0.0; 4], &mut [0.0; 9]);
}

#[test]
#[should_panic(expected = "scratch: at least")]
fn short_scratch_panics() {
    Exponential::<f64>::new(3, ExpMethod::default()).unwrap().apply_batch(1, &[0.0; 9], &mut [0.0; 9], &mut []);
}
