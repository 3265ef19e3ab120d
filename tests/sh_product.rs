//! The triple-product tensor, products and squares of spherical harmonics against golden values and a naive twin.
#![cfg(feature = "reference")]

use std::f64::consts::PI;

use haarmonic::Real;
use haarmonic::reference::sh as naive;
use haarmonic::sh::{Product, Square, TripleTensor, gamma};
use proptest::prelude::*;
use serde_json::Value;

fn golden(name: &str) -> Value {
    let path = format!("{}/tests/golden/sh_airlight_normal/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn triple(v: &Value) -> [usize; 3] {
    [0, 1, 2].map(|n| v[n].as_u64().unwrap() as usize)
}

fn narrow<T: Real>(x: &[f64]) -> Vec<T> {
    x.iter().map(|&x| T::of(x)).collect()
}

/// Uniform in −1..1.
fn random(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut next = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

#[track_caller]
fn assert_close(got: f64, want: f64, tolerance: f64, what: &str) {
    assert!((got - want).abs() <= tolerance, "{what}: got {got:e}, want {want:e}, off by {:e}", (got - want).abs());
}

#[track_caller]
fn assert_all_close<T: Real>(got: &[T], want: &[f64], tolerance: f64, what: &str) {
    assert_eq!(got.len(), want.len(), "{what}");
    for (n, (got, want)) in got.iter().zip(want).enumerate() {
        assert_close(got.widen(), *want, tolerance, &format!("{what}, coefficient {n}"));
    }
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn product<T: Real>(a: &[f64], b: &[f64], bands_out: usize) -> Vec<T> {
    let plan = Product::<T>::new(a.len().isqrt(), b.len().isqrt(), bands_out).unwrap();
    let mut out = vec![T::nan(); bands_out * bands_out];
    plan.apply(&narrow::<T>(a), &narrow::<T>(b), &mut out);
    out
}

fn product_f64(a: &[f64], b: &[f64], bands_out: usize) -> Vec<f64> {
    product(a, b, bands_out)
}

/// A relative bound on Γ: some fifteen roundings, each half an eps.
const GAMMA_ERROR: f64 = 2e-15;

#[test]
fn golden_gamma_below_four_bands() {
    let file = golden("gamma_order4");
    let tensor = TripleTensor::new(4).unwrap();
    let entries = file["entries"].as_array().unwrap();
    assert_eq!(tensor.nnz(), entries.len());
    for (([i, j, k], value), want) in tensor.entries().zip(entries) {
        assert_eq!([i, j, k], triple(want));
        let want = want[3].as_f64().unwrap();
        assert_close(value, want, GAMMA_ERROR * want.abs(), &format!("{i} {j} {k}"));
    }
}

#[test]
fn golden_gamma_samples_below_eight_bands() {
    let file = golden("gamma_order8_samples");
    let tensor = TripleTensor::new(8).unwrap();
    for entry in file["entries"].as_array().unwrap() {
        let ([i, j, k], want) = (triple(entry), entry[3].as_f64().unwrap());
        assert_close(gamma(i, j, k).unwrap(), want, GAMMA_ERROR * want.abs(), &format!("{i} {j} {k}"));
        assert_eq!(tensor.value(k, i, j), gamma(j, k, i).unwrap());
    }
    for list in ["zeros", "accidental_zeros_all"] {
        for entry in file[list].as_array().unwrap() {
            let [i, j, k] = triple(entry);
            assert_eq!((gamma(i, j, k).unwrap(), tensor.value(j, i, k)), (0.0, 0.0), "{i} {j} {k}");
        }
    }
}

#[test]
fn counts_are_the_true_ones() {
    let file = golden("gamma_order8_samples");
    for bands in 1..=8 {
        let tensor = TripleTensor::new(bands).unwrap();
        let want = |list: &str| file[list][bands - 1].as_u64().unwrap();
        assert_eq!(tensor.nnz() as u64, want("counts_true_nonzero_sorted"));
        assert_eq!(tensor.ordered_nnz(), want("counts_true_nonzero_ordered"));
        assert_eq!(tensor.ordered_allowed(), want("counts_selection_rules_ordered"));
        // A plan does one multiplication for each non-zero, and one for each pair (i, k).
        let plan = Product::<f64>::new(bands, bands, bands).unwrap();
        let pairs = (0..bands.pow(4)).filter(|p| {
            let (i, k) = (p / bands.pow(2), p % bands.pow(2));
            (0..bands * bands).any(|j| tensor.value(i, j, k) != 0.0)
        });
        assert_eq!(plan.multiplications() as u64, tensor.ordered_nnz() + pairs.count() as u64);
    }
}

#[test]
fn every_gamma_below_four_bands_is_its_integral() {
    for i in 0..16 {
        for j in i..16 {
            for k in j..16 {
                assert_close(gamma(k, i, j).unwrap(), naive::gamma(i, j, k), 4e-15, &format!("{i} {j} {k}"));
            }
        }
    }
}

#[test]
fn gamma_of_high_degree_is_its_integral() {
    let flat = |l: usize, m: isize| (l * l + l).strict_add_signed(m);
    for (l, m) in [
        ([15, 15, 15], [0, 0, 0]),
        ([15, 15, 14], [7, -8, -15 + 1]),
        ([15, 15, 30], [15, 15, 30]),
        ([15, 15, 30], [-15, 15, -30]),
        ([15, 13, 20], [3, -9, -6]),
        ([40, 40, 40], [11, -22, -33]),
        ([42, 42, 42], [1, 41, 42]),
        ([31, 31, 62], [0, 0, 0]),
        ([32, 31, 63], [31, 31, 62]),
        ([63, 63, 0], [-63, -63, 0]),
    ] {
        let [i, j, k] = [0, 1, 2].map(|n| flat(l[n], m[n]));
        let want = naive::gamma(i, j, k);
        // The twin's rounding grows with its ~10⁴ nodes and the degree of its recurrence.
        assert_close(gamma(i, j, k).unwrap(), want, 3e-14, &format!("{l:?} {m:?}"));
        assert!(l[2] != 63 || want != 0.0);
    }
}

/// Σ_k Γ_ijk² over all k is ∫ (y_i y_j)², and Σ over j and k with i fixed follows from the addition theorem.
#[test]
fn squares_of_gamma_sum_to_the_addition_theorem() {
    // Σ_m y_lm² = (2l+1)/4π; so Σ_{j of degree l, k of any degree} Γ_ijk² = ∫ y_i² Σ_m y_lm² = (2l+1)/4π.
    for (i, l) in [(0usize, 0usize), (5, 3), (100, 9), (255, 15), (240, 15), (230, 15)] {
        let degree = i.isqrt();
        let mut sum = 0.0;
        for j in l * l..(l + 1) * (l + 1) {
            for k in 0..(degree + l + 1).pow(2) {
                sum += gamma(i, j, k).unwrap().powi(2);
            }
        }
        let want = (2 * l + 1) as f64 / (4.0 * PI);
        assert_close(sum, want, 4e-15 * want, &format!("i {i}, degree {l}"));
    }
}

#[test]
fn golden_products_squares_and_matrices() {
    fn check<T: Real>(tolerance: f64) {
        for item in golden("sh_products")["items"].as_array().unwrap() {
            let bands = item["order"].as_u64().unwrap() as usize;
            let (f, g) = (numbers(&item["f"]), numbers(&item["g"]));
            let tolerance = tolerance * norm(&f) * norm(&g).max(norm(&f));
            assert_all_close(&product::<T>(&f, &g, bands), &numbers(&item["f_times_g"]), tolerance, "product");
            let mut square = vec![T::nan(); f.len()];
            Square::<T>::new(bands, bands).unwrap().apply(&narrow::<T>(&f), &mut square);
            assert_all_close(&square, &numbers(&item["f_squared"]), tolerance, "square");
            let plan = Product::<T>::new(bands, bands, bands).unwrap();
            if let Some(rows) = item.get("product_matrix_f_rowmajor") {
                let rows: Vec<f64> = match rows[0].is_array() {
                    true => rows.as_array().unwrap().iter().flat_map(numbers).collect(),
                    false => numbers(rows),
                };
                let mut matrix = vec![T::nan(); f.len() * f.len()];
                plan.matrix(&narrow::<T>(&f), &mut matrix);
                assert_all_close(&matrix, &rows, tolerance, "matrix");
            }
            if let Some(want) = item.get("triple_fgf") {
                let (f, g) = (narrow::<T>(&f), narrow::<T>(&g));
                assert_close(plan.integral(&f, &g, &f).widen(), want.as_f64().unwrap(), 4.0 * tolerance, "integral");
            }
        }
    }
    check::<f64>(2.0 * f64::EPSILON);
    check::<f32>(2.0 * f64::from(f32::EPSILON));
}
