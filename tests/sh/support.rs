//! What the tests of spherical harmonics share.

use haarmonic::Real;
use haarmonic::sh::degree_order;
use proptest::prelude::ProptestConfig;
use serde_json::Value;

/// A file of tests/golden/sh_airlight_normal.
pub fn golden(name: &str) -> Value {
    let path = format!("{}/tests/golden/sh_airlight_normal/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

pub fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

pub fn number(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

/// Few cases, or as many as PROPTEST_CASES says.
pub fn cases() -> ProptestConfig {
    ProptestConfig::with_cases(std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(48))
}

pub fn narrow<T: Real>(x: &[f64]) -> Vec<T> {
    x.iter().map(|&x| T::of(x)).collect()
}

/// No zeros, no pattern, decaying with the degree.
pub fn coefficients(bands: usize) -> Vec<f64> {
    (0..bands * bands).map(|i| (1.0 + 2.3 * i as f64).sin() / (1.0 + degree_order(i).0 as f64)).collect()
}

/// Largest |a − b|; NaN or infinity anywhere is infinite.
pub fn worst<T: Real>(got: &[T], want: &[f64]) -> f64 {
    assert_eq!(got.len(), want.len());
    worst_of(got.iter().map(|x| x.widen()).zip(want))
}

/// As [`worst`], of pairs.
pub fn worst_of<'a>(pairs: impl IntoIterator<Item = (f64, &'a f64)>) -> f64 {
    pairs.into_iter().fold(0.0, |worst, (got, want)| {
        let off = (got - want).abs();
        if off.is_finite() { off.max(worst) } else { f64::INFINITY }
    })
}

#[track_caller]
pub fn assert_below(error: f64, tolerance: f64, what: &str) {
    assert!(error <= tolerance, "{what}: error {error:e} exceeds {tolerance:e}");
}

#[track_caller]
pub fn assert_all_close<T: Real>(got: &[T], want: &[f64], tolerance: f64, what: &str) {
    assert_eq!(got.len(), want.len(), "{what}");
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        let (got, off) = (got.widen(), (got.widen() - want).abs());
        assert!(off <= tolerance, "{what}, {i}: got {got:e}, want {want:e}, off by {off:e}");
    }
}
