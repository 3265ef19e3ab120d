//! The reference values in tests/golden.

use serde_json::Value;

/// The folder of wavelets, affine maps, tables and compression.
pub const HAAR_AFFINE: &str = "haar_affine_tables";
/// The folder of spherical harmonics.
pub const HARMONICS: &str = "sh_airlight_normal";

/// A file of a folder of tests/golden.
#[track_caller]
pub fn golden(folder: &str, name: &str) -> Value {
    let path = format!("{}/tests/golden/{folder}/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// A number, "p/q" or "p".
#[track_caller]
pub fn number(v: &Value) -> f64 {
    let Some(text) = v.as_str() else { return v.as_f64().unwrap() };
    let (p, q) = text.split_once('/').unwrap_or((text, "1"));
    p.parse::<f64>().unwrap() / q.parse::<f64>().unwrap()
}

/// The numbers of an array, or of an array of arrays row by row.
#[track_caller]
pub fn numbers(v: &Value) -> Vec<f64> {
    match v.as_array() {
        Some(items) => items.iter().flat_map(numbers).collect(),
        None => vec![number(v)],
    }
}

/// m·2^{e/2}.
#[track_caller]
pub fn half_power(m: &Value, e: &Value) -> f64 {
    let e = e.as_i64().unwrap() as i32;
    let root = if e.rem_euclid(2) == 1 { std::f64::consts::SQRT_2 } else { 1.0 };
    number(m) * root * 2f64.powi(e.div_euclid(2))
}
