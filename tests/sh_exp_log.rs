//! Exponentials, logarithms and functions of expansions against golden values, naive twins and their algebra.
#![cfg(all(feature = "reference", feature = "proptest"))]

use haarmonic::Real;
use haarmonic::sh::{
    CapFit, CapLog, ExpMethod, Exponential, LogMethod, Logarithm, OptimalLinear, Product, ProductSpectrum,
};
use serde_json::Value;

fn golden(name: &str) -> Vec<Value> {
    let path = format!("{}/tests/golden/sh_airlight_normal/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let file: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    file["items"].as_array().or_else(|| file["hyb_items"].as_array()).unwrap().clone()
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn bands(v: &Value) -> usize {
    v["order"].as_u64().unwrap() as usize
}

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// ‖got − want‖/‖want‖.
fn relative<T: Real>(got: &[T], want: &[f64]) -> f64 {
    assert_eq!(got.len(), want.len());
    let difference: Vec<f64> = got.iter().zip(want).map(|(a, b)| a.widen() - b).collect();
    norm(&difference) / norm(want)
}

#[track_caller]
fn assert_within(error: f64, tolerance: f64, what: &str) {
    assert!(error <= tolerance, "{what}: {error:e} is not within {tolerance:e}");
}

fn narrow<T: Real>(x: &[f64]) -> Vec<T> {
    x.iter().map(|&x| T::of(x)).collect()
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
        for item in golden("sh_exp_log") {
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
                assert_within(relative(&out, &numbers(&item[key])), tolerance, &what);
            }
        }
    }
    // Each squaring doubles the relative error that is there: 6 squarings of a few eps.
    check::<f64>(4e-15, 6e-14, 1e-14);
    check::<f32>(3e-6, 3e-5, 3e-7);
}

#[test]
fn golden_hybrid() {
    let items = golden("sh_exp_log");
    for item in golden("ol_hyb") {
        let source = &items[item["sh_exp_log_item"].as_u64().unwrap() as usize];
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
            assert_within(error, tolerance, &format!("bands {}, norm {}", f.len().isqrt(), norm(&f)));
        }
    }
}

#[test]
fn golden_optimal_linear_tables() {
    let path = format!("{}/tests/golden/sh_airlight_normal/ol_hyb.json", env!("CARGO_MANIFEST_DIR"));
    let file: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    for row in file["table"].as_array().unwrap() {
        let [a, b] = OptimalLinear::new(bands(row)).unwrap().factors(number(&row["norm_f_hat"]));
        let what = format!("bands {}, angle {}", bands(row), row["theta"]);
        assert_within((a - number(&row["a"])).abs(), 2e-6, &what);
        assert_within((b - number(&row["b"])).abs(), 2e-6, &what);
    }
}

#[test]
fn golden_logarithms() {
    for item in golden("sh_exp_log") {
        let (g, n) = (numbers(&item["exp_star_inf"]), bands(&item));
        let (mut out, mut out32) = (vec![0.0; g.len()], vec![0.0f32; g.len()]);
        let log = Logarithm::new(n, LogMethod::default()).unwrap();
        log.apply(&g, &mut out).unwrap();
        log.apply(&narrow::<f32>(&g), &mut out32).unwrap();
        let want = numbers(&item["log_thesis_of_exp_star_inf"]);
        assert_within(relative(&out, &want), 1e-12, "log");
        // What is known to 6e-8 has eigenvalues known to that, the smallest of them 0.02.
        assert_within(relative(&out32, &want), 1e-5, "log of f32");
        let spectrum = ProductSpectrum::new(&Product::new(n, n, n).unwrap(), &g).unwrap();
        let floor = 0.02 * spectrum.largest();
        let matrix = spectrum.apply(|x| x.max(floor).ln());
        assert_within(relative(&matrix, &numbers(&item["log_matrix_of_exp_star_inf"])), 1e-12, "log(M)1");
    }
}

#[test]
fn golden_discs() {
    for n in [3, 4, 6] {
        let table = CapLog::new(n, CapFit::default()).unwrap();
        assert_within(table.error(), 1e-6, "table");
        let (log, product) = (Logarithm::new(n, LogMethod::default()).unwrap(), Product::new(n, n, n).unwrap());
        for item in golden("circle_blocker").iter().filter(|item| bands(item) == n) {
            let g = numbers(&item["g_zonal"]);
            let (theta, want) = (number(&item["theta"]), numbers(&item["log_thesis_zonal"]));
            let what = format!("bands {n}, angle {theta}");
            let (mut zonal, mut tabulated) = (vec![0.0; n], vec![0.0; n]);
            log.apply_zonal(&g, &mut zonal).unwrap();
            // The smallest disc's log is 4e-4: eps/4e-4.
            assert_within(relative(&zonal, &want), 2e-12, &what);
            table.eval(theta, &mut tabulated);
            let scale = (1.0 - theta.cos()) * n as f64;
            assert_within(relative(&tabulated, &want) * norm(&want), 1e-6 * scale, &what);
            let mut full = vec![0.0; n * n];
            g.iter().enumerate().for_each(|(l, &g)| full[l * l + l] = g);
            let spectrum = ProductSpectrum::new(&product, &full).unwrap();
            assert_within((spectrum.largest() - number(&item["eig_max"])).abs(), 1e-14, &what);
            let smallest = spectrum.eigenvalues().iter().copied().fold(f64::INFINITY, f64::min);
            assert_within((smallest - number(&item["eig_min"])).abs(), 1e-14, &what);
        }
    }
}
