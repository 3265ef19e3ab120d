//! What tests of several rooms share: golden files, comparisons, one-sided slopes, rows of matrices, a watch on long work.
#![allow(dead_code, reason = "each test uses its own share of this")]

use std::sync::atomic::{AtomicUsize, Ordering};

use haarmonic::affine::AffineMap;
use haarmonic::{Progress, Real};
use serde_json::Value;

/// A file of tests/golden/haar_affine_tables.
pub fn golden(name: &str) -> Value {
    let path = format!("{}/tests/golden/haar_affine_tables/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// "p/q" or "p".
pub fn rational(v: &Value) -> f64 {
    let text = v.as_str().unwrap();
    let (p, q) = text.split_once('/').unwrap_or((text, "1"));
    p.parse::<f64>().unwrap() / q.parse::<f64>().unwrap()
}

/// m·2^{e/2}, e = 0 or 1.
pub fn half_power(m: &Value, e: &Value) -> f64 {
    rational(m) * if e.as_u64() == Some(1) { 2f64.sqrt() } else { 1.0 }
}

#[track_caller]
pub fn assert_close(got: f64, want: f64, tolerance: f64, what: &str) {
    assert!((got - want).abs() <= tolerance, "{what}: got {got:e}, want {want:e}, off by {:e}", (got - want).abs());
}

pub fn map(s: f64, o: f64) -> AffineMap {
    AffineMap::new(s, o).unwrap()
}

/// The right-hand derivative of `f` at 0 of a function that is a + b/(1 + x) without kinks within the step; good to O(h²) + O(ε/h).
fn right_slope(f: impl Fn(f64) -> f64) -> f64 {
    let step = 2f64.powi(-20);
    let difference = |h: f64| (f(h) - f(0.0)) / h;
    2.0 * difference(step / 2.0) - difference(step)
}

/// [∂/∂s, ∂/∂o], right-hand, of a function of a map.
pub fn right_gradient(at: AffineMap, f: impl Fn(AffineMap) -> f64) -> [f64; 2] {
    let moved = |ds: f64, d_o: f64| map(at.scale() + ds, at.offset() + d_o);
    [right_slope(|h| f(moved(h, 0.0))), right_slope(|h| f(moved(0.0, h)))]
}

/// Maps of moderate scale whose kinks the differences do not step over: of few binary places, or of none in common with a cell.
#[cfg(feature = "proptest")]
pub fn differentiable() -> impl proptest::prelude::Strategy<Value = AffineMap> {
    use proptest::prelude::*;
    let generic = [map(0.713, 0.2), map(-1.3719, 1.2113), map(2.613, -0.737), map(-0.5471, 0.7)];
    prop_oneof![haarmonic::strategies::dyadic_map(), prop::sample::select(generic.to_vec())]
        .prop_filter("a moderate scale", |map| (0.2..8.0).contains(&map.scale().abs()) && map.offset().abs() < 8.0)
}

/// Rows one after the other.
pub fn flat<T: Real>(rows: &[Vec<f64>]) -> Vec<T> {
    rows.iter().flatten().map(|&x| T::of(x)).collect()
}

pub fn wide<T: Real>(x: &[T]) -> Vec<f64> {
    x.iter().map(|x| x.widen()).collect()
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Follows work of `total` pieces, and stops it once it has heard of some.
pub struct Watch {
    total: usize,
    largest: AtomicUsize,
    stop_after: Option<usize>,
}

impl Watch {
    pub fn new(total: usize) -> Self {
        Self { total, largest: AtomicUsize::new(0), stop_after: None }
    }

    pub fn stopping_after(pieces: usize, total: usize) -> Self {
        Self { stop_after: Some(pieces), ..Self::new(total) }
    }

    /// The most pieces that it has heard of.
    pub fn largest(&self) -> usize {
        self.largest.load(Ordering::Relaxed)
    }
}

impl Progress for Watch {
    fn advance(&self, done: usize, total: usize) {
        assert!(done <= total && total == self.total, "{done} of {total}, not of {}", self.total);
        self.largest.fetch_max(done, Ordering::Relaxed);
    }
    fn is_cancelled(&self) -> bool {
        self.stop_after.is_some_and(|pieces| self.largest() >= pieces)
    }
}
