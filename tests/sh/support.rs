//! What the tests of spherical harmonics share.

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
