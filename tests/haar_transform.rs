//! Haar transforms, pyramids, layouts and selection against golden values and the naive twins.
#![cfg(feature = "reference")]

use haarmonic::haar::{Decomposition, Pyramid, Transform1d, Transform2d, forward_1d, forward_2d};
use haarmonic::{Real, reference};

const NONSTANDARD: Decomposition = Decomposition::Nonstandard;
const STANDARD: Decomposition = Decomposition::Standard;

/// max |a − b| ≤ tolerance·scale; NaN fails.
#[track_caller]
fn assert_close<T: Real>(got: &[T], want: &[f64], tolerance: f64, scale: f64) {
    assert_eq!(got.len(), want.len());
    for (i, (&g, &w)) in got.iter().zip(want).enumerate() {
        let error = (g.widen() - w).abs();
        assert!(error <= tolerance * scale, "[{i}]: got {g}, want {w}, error {error:e} > {tolerance:e}·{scale:e}");
    }
}

fn narrow<T: Real>(x: &[f64]) -> Vec<T> {
    x.iter().map(|&x| T::of(x)).collect()
}

fn max_abs(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| x.abs().max(m))
}

fn numbers(value: &serde_json::Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// `[m, e]` = m·2^{e/2}, m = "p/q".
fn exact(value: &serde_json::Value) -> f64 {
    let (p, q) = value[0].as_str().unwrap().split_once('/').unwrap();
    let root = if value[1].as_i64().unwrap() == 1 { std::f64::consts::SQRT_2 } else { 1.0 };
    p.parse::<f64>().unwrap() / q.parse::<f64>().unwrap() * root
}

/// Forward and inverse, out of place, in place and batched, of one image and its known coefficients.
#[track_caller]
fn check_2d<T: Real>(
    (width, height): (usize, usize),
    basis: Decomposition,
    samples: &[f64],
    coefs: &[f64],
    tolerance: f64,
) {
    let plan = Transform2d::<T>::new(width, height, basis).unwrap();
    let (x, c) = (narrow::<T>(samples), narrow::<T>(coefs));
    let (mut out, mut scratch) = (vec![T::nan(); plan.len()], vec![T::nan(); plan.scratch_len()]);
    let scale = max_abs(samples);

    plan.forward(&x, &mut out, &mut scratch);
    assert_close(&out, coefs, tolerance, scale);
    let mut data = x.clone();
    scratch.fill(T::nan());
    plan.forward_in_place(&mut data, &mut scratch);
    assert_eq!(data, out, "in place = out of place");

    let three = [x.clone(), x.clone(), x.clone()].concat();
    let (mut batch, mut parallel) = (vec![T::nan(); three.len()], vec![T::nan(); three.len()]);
    plan.forward_batch(&three, &mut batch, &mut scratch);
    plan.forward_batch_parallel(&three, &mut parallel);
    let mut in_place = three.clone();
    plan.forward_batch_in_place(&mut in_place, &mut scratch);
    assert_eq!(batch, [out.clone(), out.clone(), out.clone()].concat());
    assert_eq!(parallel, batch);
    assert_eq!(in_place, batch);

    plan.inverse(&c, &mut out, &mut scratch);
    assert_close(&out, samples, tolerance, scale);
    let mut data = c.clone();
    scratch.fill(T::nan());
    plan.inverse_in_place(&mut data, &mut scratch);
    assert_eq!(data, out, "in place = out of place");
    let three = [c.clone(), c.clone(), c.clone()].concat();
    plan.inverse_batch(&three, &mut batch, &mut scratch);
    plan.inverse_batch_parallel(&three, &mut parallel);
    let mut in_place = three.clone();
    plan.inverse_batch_in_place(&mut in_place, &mut scratch);
    assert_eq!(batch, [out.clone(), out.clone(), out.clone()].concat());
    assert_eq!(parallel, batch);
    assert_eq!(in_place, batch);
}

#[track_caller]
fn check_1d<T: Real>(samples: &[f64], coefs: &[f64], tolerance: f64) {
    let plan = Transform1d::<T>::new(samples.len()).unwrap();
    let (x, c) = (narrow::<T>(samples), narrow::<T>(coefs));
    let (mut out, mut scratch) = (vec![T::nan(); plan.len()], vec![T::nan(); plan.scratch_len()]);
    for (input, want, inverse) in [(&x, coefs, false), (&c, samples, true)] {
        let mut data = [input.clone(), input.clone()].concat();
        if inverse {
            plan.inverse(input, &mut out, &mut scratch);
            scratch.fill(T::nan());
            plan.inverse_batch_in_place(&mut data, &mut scratch);
        } else {
            plan.forward(input, &mut out, &mut scratch);
            scratch.fill(T::nan());
            plan.forward_batch_in_place(&mut data, &mut scratch);
        }
        assert_close(&out, want, tolerance, max_abs(samples));
        assert_eq!(data, [out.clone(), out.clone()].concat(), "in place = out of place");
    }
}

#[test]
fn golden_values_are_reproduced() {
    let golden: serde_json::Value = serde_json::from_str(include_str!("golden/haar_affine_tables/haar.json")).unwrap();
    for case in golden["d1"].as_array().unwrap() {
        let pixels = numbers(&case["pixels"]);
        let coefs: Vec<f64> = case["coef"].as_array().unwrap().iter().map(exact).collect();
        assert_close(&coefs, &numbers(&case["coef_f64"]), 1e-15, max_abs(&pixels));
        assert_close(&reference::haar::forward_1d(&pixels), &coefs, 1e-13, max_abs(&pixels));
        check_1d::<f64>(&pixels, &coefs, 1e-13);
        check_1d::<f32>(&pixels, &coefs, 1e-5);
    }
    for case in golden["d2"].as_array().unwrap() {
        let n = case["N"].as_u64().unwrap() as usize;
        let pixels: Vec<f64> = case["pixels_rows_y_then_x"].as_array().unwrap().iter().flat_map(numbers).collect();
        let nonstandard: Vec<f64> = case["nonstandard"].as_array().unwrap().iter().map(exact).collect();
        let rows = case["standard"].as_array().unwrap();
        let standard: Vec<f64> = rows.iter().flat_map(|row| row.as_array().unwrap().iter().map(exact)).collect();
        for (basis, coefs) in [(NONSTANDARD, &nonstandard), (STANDARD, &standard)] {
            check_2d::<f64>((n, n), basis, &pixels, coefs, 1e-13);
            check_2d::<f32>((n, n), basis, &pixels, coefs, 1e-5);
        }
        assert_close(&reference::haar::forward_nonstandard(&pixels), &nonstandard, 1e-13, max_abs(&pixels));
        assert_close(&reference::haar::forward_standard(n, &pixels), &standard, 1e-13, max_abs(&pixels));
    }
}
