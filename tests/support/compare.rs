//! Comparisons, and what they need of slices. NaN is never close to anything.

use haarmonic::Real;
use haarmonic::numeric::CompensatedSum;

#[track_caller]
pub fn assert_close(got: f64, want: f64, tolerance: f64, what: &str) {
    let off = (got - want).abs();
    assert!(off <= tolerance, "{what}: got {got:e}, want {want:e}, off by {off:e} > {tolerance:e}");
}

#[track_caller]
pub fn assert_all_close<T: Real>(got: &[T], want: &[f64], tolerance: f64, what: &str) {
    assert_eq!(got.len(), want.len(), "{what}");
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        let (got, off) = (got.widen(), (got.widen() - want).abs());
        assert!(off <= tolerance, "{what}, {i}: got {got:e}, want {want:e}, off by {off:e} > {tolerance:e}");
    }
}

#[track_caller]
pub fn assert_below(error: f64, tolerance: f64, what: &str) {
    assert!(error <= tolerance, "{what}: error {error:e} exceeds {tolerance:e}");
}

/// Largest |a − b|; NaN or infinity anywhere is infinite.
#[track_caller]
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

pub fn narrow<T: Real>(x: &[f64]) -> Vec<T> {
    x.iter().map(|&x| T::of(x)).collect()
}

pub fn wide<T: Real>(x: &[T]) -> Vec<f64> {
    x.iter().map(|x| x.widen()).collect()
}

/// Rows one after the other.
pub fn flat<T: Real>(rows: &[Vec<f64>]) -> Vec<T> {
    rows.iter().flatten().map(|&x| T::of(x)).collect()
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// max |x|; NaN is passed over.
pub fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most, x| x.abs().max(most))
}

/// √Σx², without overflow; NaN of NaN.
pub fn norm(x: &[f64]) -> f64 {
    let most = largest(x);
    if most == 0.0 {
        return x.iter().sum();
    }
    let squares: CompensatedSum = x.iter().map(|x| (x / most).powi(2)).collect();
    most * squares.total().sqrt()
}
