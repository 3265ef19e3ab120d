//! The triple-product tensor, products and squares of spherical harmonics against golden values and a naive twin.

use std::f64::consts::PI;

use haarmonic::Real;
use haarmonic::nalgebra::{UnitVector3, Vector3};
use haarmonic::reference::sh as naive;
use haarmonic::sh::{Product, Square, TripleTensor, gamma};
use proptest::prelude::*;
use serde_json::Value;

use crate::support::{HARMONICS, assert_all_close, assert_close, cases, golden, narrow, norm, numbers, random, wide};

fn triple(v: &Value) -> [usize; 3] {
    [0, 1, 2].map(|n| v[n].as_u64().unwrap() as usize)
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
    let file = golden(HARMONICS, "gamma_order4");
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
    let file = golden(HARMONICS, "gamma_order8_samples");
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
    let file = golden(HARMONICS, "gamma_order8_samples");
    for bands in 1..=8 {
        let tensor = TripleTensor::new(bands).unwrap();
        let want = |list: &str| file[list][bands - 1].as_u64().unwrap();
        assert_eq!(tensor.nnz() as u64, want("counts_true_nonzero_sorted"));
        assert_eq!(tensor.ordered_nnz(), want("counts_true_nonzero_ordered"));
        assert_eq!(tensor.ordered_allowed(), want("counts_selection_rules_ordered"));
        // A plan for unequal bands does one multiplication for each non-zero, and one for each pair (i, k).
        let plan = Product::<f64>::new(bands, 1, bands + 1).unwrap();
        assert_eq!(plan.multiplications(), 2 * bands * bands);
    }
}

#[test]
fn kernels_multiply_less_than_any_published() {
    // DirectXMath's comments; nobody has kernels for 7 and 8 bands.
    let published = [20, 120, 399, 1135, 2527, usize::MAX, usize::MAX];
    let products = [13, 96, 290, 704, 1352, 2365, 3156];
    let squares = [9, 64, 178, 420, 792, 1370, 1818];
    for bands in 2..=8 {
        let product = Product::<f32>::new(bands, bands, bands).unwrap().multiplications();
        let square = Square::<f32>::new(bands, bands).unwrap().multiplications();
        assert_eq!((product, square), (products[bands - 2], squares[bands - 2]), "{bands} bands");
        assert!(product < published[bands - 2] && square < product);
    }
}

/// Each pair of basis functions through each kernel.
#[test]
fn kernels_and_grids_of_one_hot_factors_give_gamma() {
    fn check<T: Real>(bands: usize) {
        let (count, plan) = (bands * bands, Product::<T>::new(bands, bands, bands).unwrap());
        let (square, tensor) = (Square::<T>::new(bands, bands).unwrap(), TripleTensor::new(bands).unwrap());
        // A few roundings of quantities up to bands/√4π, the largest value of the basis functions.
        let tolerance = T::epsilon().widen() * bands as f64;
        let (mut a, mut b, mut out) = (vec![T::zero(); count], vec![T::zero(); count], vec![T::nan(); count]);
        for i in 0..count {
            a[i] = T::one();
            for j in 0..count {
                b[j] = T::one();
                plan.apply(&a, &b, &mut out);
                for k in 0..count {
                    assert_close(out[k].widen(), tensor.value(i, j, k), tolerance, &format!("{bands}: {i} {j} {k}"));
                }
                b[j] = T::zero();
            }
            square.apply(&a, &mut out);
            for k in 0..count {
                assert_close(out[k].widen(), tensor.value(i, i, k), tolerance, &format!("{bands}: {i}² {k}"));
            }
            a[i] = T::zero();
        }
    }
    for bands in 2..=9 {
        check::<f32>(bands);
        check::<f64>(bands);
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
    let flat = |l: usize, m: isize| ((l * l + l) as isize + m) as usize;
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
        for item in golden(HARMONICS, "sh_products")["items"].as_array().unwrap() {
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

/// Fast against naive, for bands 1, mixed, truncated, untruncated and beyond.
#[test]
fn every_form_equals_its_twin() {
    fn check<T: Real>() {
        let eps = T::epsilon().widen();
        for [bands_a, bands_b, bands_out] in [
            [1, 1, 1],
            [1, 1, 4],
            [1, 5, 3],
            [5, 1, 5],
            [2, 3, 4],
            [2, 3, 6],
            [6, 2, 1],
            [3, 3, 5],
            [4, 6, 9],
            [2, 2, 2],
            [3, 3, 3],
            [4, 4, 4],
            [5, 5, 5],
            [6, 6, 6],
        ] {
            let what = format!("{bands_a} {bands_b} {bands_out}");
            // Narrowed first, so that the twin sees the same numbers.
            let widened = |x: &[T]| x.iter().map(|x| x.widen()).collect::<Vec<f64>>();
            let a = narrow::<T>(&random(bands_a * bands_a, 1));
            let b = narrow::<T>(&random(bands_b * bands_b, 2));
            let c = narrow::<T>(&random(bands_out * bands_out, 3));
            let (a64, b64, c64) = (widened(&a), widened(&b), widened(&c));
            // 3 eps for the fast sums; the twin rounds at each of its few hundred nodes.
            let tolerance = (3.0 * eps + 3e-15) * norm(&a64) * norm(&b64);
            let plan = Product::<T>::new(bands_a, bands_b, bands_out).unwrap();
            let mut out = vec![T::nan(); bands_out * bands_out];
            plan.apply(&a, &b, &mut out);
            assert_all_close(&out, &naive::product(&a64, &b64, bands_out), tolerance, &what);
            let mut matrix = vec![T::nan(); out.len() * b.len()];
            plan.matrix(&a, &mut matrix);
            let want = naive::product_matrix(&a64, bands_b, bands_out);
            assert_all_close(&matrix, &want, (3.0 * eps + 3e-15) * norm(&a64), &what);
            let want = naive::triple_integral(&a64, &b64, &c64);
            assert_close(plan.integral(&a, &b, &c).widen(), want, tolerance * norm(&c64), &what);
            let square = Square::<T>::new(bands_a, bands_out).unwrap();
            square.apply(&a, &mut out);
            let want = naive::product(&a64, &a64, bands_out);
            assert_all_close(&out, &want, (3.0 * eps + 3e-15) * norm(&a64).powi(2), &what);
            assert_eq!((plan.bands(), square.bands()), ([bands_a, bands_b, bands_out], [bands_a, bands_out]));
        }
    }
    check::<f64>();
    check::<f32>();
}

/// The same for the sizes whose twins take long, products and squares only.
#[test]
fn larger_products_equal_their_twins() {
    fn check<T: Real>() {
        for [bands_a, bands_b, bands_out] in
            [[7, 7, 7], [8, 8, 8], [9, 9, 9], [2, 12, 12], [12, 5, 14], [1, 25, 25], [13, 12, 1], [5, 5, 20]]
        {
            let what = format!("{bands_a} {bands_b} {bands_out}");
            let a = narrow::<T>(&random(bands_a * bands_a, 1));
            let b = narrow::<T>(&random(bands_b * bands_b, 2));
            let [a64, b64] = [&a, &b].map(|x| x.iter().map(|x| x.widen()).collect::<Vec<f64>>());
            let tolerance = (3.0 * T::epsilon().widen() + 3e-15) * norm(&a64) * norm(&b64);
            let mut out = vec![T::nan(); bands_out * bands_out];
            Product::<T>::new(bands_a, bands_b, bands_out).unwrap().apply(&a, &b, &mut out);
            assert_all_close(&out, &naive::product(&a64, &b64, bands_out), tolerance, &what);
            if bands_a == bands_b && bands_b == bands_out {
                let tolerance = (3.0 * T::epsilon().widen() + 3e-15) * norm(&a64).powi(2);
                Square::<T>::new(bands_a, bands_out).unwrap().apply(&a, &mut out);
                assert_all_close(&out, &naive::product(&a64, &a64, bands_out), tolerance, &what);
            }
        }
    }
    check::<f64>();
    check::<f32>();
}

#[test]
fn a_batch_has_the_bits_of_single_calls() {
    fn check<T: Real>(bands: [usize; 3], count: usize) {
        let sizes = bands.map(|n| n * n);
        let (a, b) = (narrow::<T>(&random(sizes[0] * count, 5)), narrow::<T>(&random(sizes[1] * count, 6)));
        let column = |x: &[T], v: usize| x.iter().skip(v).step_by(count).copied().collect::<Vec<_>>();
        let plan = Product::<T>::new(bands[0], bands[1], bands[2]).unwrap();
        let square = Square::<T>::new(bands[0], bands[2]).unwrap();
        let mut products = vec![T::nan(); sizes[2] * count];
        let mut squares = products.clone();
        plan.apply_batch(count, &a, &b, &mut products);
        square.apply_batch(count, &a, &mut squares);
        let mut out = vec![T::nan(); sizes[2]];
        for v in 0..count {
            plan.apply(&column(&a, v), &column(&b, v), &mut out);
            assert_eq!(column(&products, v), out, "{bands:?}, vector {v} of {count}");
            square.apply(&column(&a, v), &mut out);
            assert_eq!(column(&squares, v), out, "{bands:?}, square {v} of {count}");
        }
    }
    let equal = (1..=9).map(|n| [n; 3]);
    for bands in equal.chain([[2, 3, 6], [12, 5, 14], [1, 26, 26]]) {
        for count in [0, 1, 3, 4, 7, 8, 9, 17, 32, 33, 67] {
            check::<f32>(bands, count);
            check::<f64>(bands, count);
        }
    }
}

#[test]
fn square_takes_about_half_the_multiplications() {
    for (bands, most) in [(2, 0.7), (4, 0.62), (6, 0.59), (8, 0.58), (9, 0.78), (32, 0.75)] {
        let [square, product] = [
            Square::<f32>::new(bands, bands).unwrap().multiplications() as f64,
            Product::<f32>::new(bands, bands, bands).unwrap().multiplications() as f64,
        ];
        assert!(square > 0.5 * product && square < most * product, "{bands}: {square} of {product}");
    }
}

#[test]
fn one_is_the_constant_function_and_zero_annihilates() {
    for bands in [1, 2, 5, 9] {
        let f = random(bands * bands, 9);
        let mut one = vec![0.0; bands * bands];
        one[0] = (4.0 * PI).sqrt();
        let tolerance = f64::EPSILON * norm(&f) * norm(&one);
        assert_all_close(&product_f64(&f, &one, bands), &f, tolerance, "f · 1");
        assert_all_close(&product_f64(&one, &f, bands), &f, tolerance, "1 · f");
        assert!(product_f64(&f, &vec![0.0; bands * bands], 2 * bands).iter().all(|x| *x == 0.0));
    }
}

#[test]
fn one_hot_factors_give_gamma() {
    let tensor = TripleTensor::new(5).unwrap();
    let hot = |n: usize, i: usize| (0..n).map(|j| f64::from(u8::from(i == j))).collect::<Vec<_>>();
    for i in 0..9 {
        for j in 0..25 {
            let want: Vec<f64> = (0..16).map(|k| tensor.value(i, j, k)).collect();
            assert_eq!(product_f64(&hot(9, i), &hot(25, j), 4), want, "{i} {j}");
        }
    }
}

#[test]
fn sixteen_bands_are_accurate() {
    let (f, g) = (random(256, 20), random(256, 21));
    let want = naive::product(&f, &g, 16);
    assert_all_close(&product::<f64>(&f, &g, 16), &want, 4e-15 * norm(&f) * norm(&g), "16 bands");
}

/// f at a direction, by the twin.
fn value(f: &[f64], direction: &UnitVector3<f64>) -> f64 {
    naive::basis(f.len().isqrt(), direction).iter().zip(f).map(|(y, f)| y * f).sum()
}

#[test]
fn untruncated_products_of_many_bands_are_pointwise_products() {
    for [bands_a, bands_b] in [[9, 9], [24, 24], [32, 33], [20, 64], [64, 64]] {
        let (f, g) = (random(bands_a * bands_a, 50), random(bands_b * bands_b, 51));
        let out = bands_a + bands_b - 1;
        let whole: Vec<f64> = product(&f, &g, out);
        for [x, y, z] in [[0.0, 0.0, 1.0], [0.1, 0.2, -0.9], [0.7, -0.3, 0.02], [-1.0, 0.4, 0.6]] {
            let at = UnitVector3::new_normalize(Vector3::new(x, y, z));
            // The sum over the product's coefficients rounds, and so do its terms.
            let tolerance = f64::EPSILON * norm(&f) * norm(&g) * out as f64;
            assert_close(
                value(&whole, &at),
                value(&f, &at) * value(&g, &at),
                tolerance,
                &format!("{bands_a} {bands_b}"),
            );
        }
        // Truncation is of the output only.
        let bands = bands_a.min(bands_b);
        let cut: Vec<f64> = product(&f, &g, bands);
        let tolerance = 2.0 * f64::EPSILON * norm(&f) * norm(&g);
        assert_all_close(&cut, &whole[..bands * bands], tolerance, "truncated");
        // In f32 the inputs are rounded too.
        let single: Vec<f32> = product(&f, &g, bands);
        let tolerance = 2.0 * f64::from(f32::EPSILON) * norm(&f) * norm(&g);
        assert_all_close(&single, &cut, tolerance, "single precision");
    }
}

#[test]
fn many_bands_have_squares_integrals_and_matrices() {
    let (f, g) = (random(400, 60), random(400, 61));
    let plan = Product::<f64>::new(20, 20, 20).unwrap();
    let want: Vec<f64> = product(&f, &g, 20);
    let scale = f64::EPSILON * norm(&f) * norm(&g);
    let mut matrix = vec![f64::NAN; 400 * 400];
    plan.matrix(&f, &mut matrix);
    let got: Vec<f64> = matrix.chunks(400).map(|row| row.iter().zip(&g).map(|(m, g)| m * g).sum()).collect();
    assert_all_close(&got, &want, 4.0 * scale, "matrix");
    let integral: f64 = want.iter().zip(&f).map(|(p, f)| p * f).sum();
    assert_close(plan.integral(&f, &g, &f), integral, 4.0 * scale * norm(&f), "integral");
    let mut square = vec![f64::NAN; 400];
    Square::new(20, 20).unwrap().apply(&f, &mut square);
    assert_all_close(&square, &product::<f64>(&f, &f, 20), 2.0 * f64::EPSILON * norm(&f).powi(2), "square");
}

#[test]
fn huge_tiny_and_nan_go_where_they_must() {
    let (f, g) = (random(16, 30), random(16, 31));
    let plain = product_f64(&f, &g, 4);
    let scaled = |x: &[f64], s: f64| x.iter().map(|x| x * s).collect::<Vec<_>>();
    // Powers of two are exact.
    let (up, down) = (2f64.powi(500), 2f64.powi(-500));
    assert_eq!(product_f64(&scaled(&f, up), &scaled(&g, down), 4), plain);
    assert_eq!(product_f64(&scaled(&f, up), &g, 4), scaled(&plain, up));
    // NaN in a coefficient reaches the outputs that Γ links it with, in every form. The sparse form touches no others.
    for bands_out in [4, 5, 25] {
        let mut bad = f.clone();
        bad[15] = f64::NAN;
        let out = product_f64(&bad, &g, bands_out);
        for (k, value) in out.iter().enumerate() {
            let linked = (0..16).any(|j| gamma(15, j, k).unwrap() != 0.0);
            assert!(value.is_nan() == linked || (bands_out == 4 && !linked), "{bands_out}: {k}");
        }
    }
}

#[test]
fn bad_sizes_are_refused() {
    for bands in [[0, 1, 1], [1, 0, 1], [1, 1, 0], [129, 129, 129], [65, 129, 65 + 128], [usize::MAX; 3]] {
        assert!(Product::<f32>::new(bands[0], bands[1], bands[2]).is_err(), "{bands:?}");
    }
    assert!(TripleTensor::new(0).is_err() && TripleTensor::new(44).is_err());
    assert!(Square::<f64>::new(0, 1).is_err() && Square::<f64>::new(1, 0).is_err());
    // What cannot meet does not count against the limit, here 0 + 999 + 999.
    let constant = Product::<f64>::new(1000, 1, 1).unwrap();
    let mut out = [0.0];
    constant.apply(&vec![2.0; 1_000_000], &[3.0], &mut out);
    assert_close(out[0], 6.0 / (4.0 * PI).sqrt(), 4e-16, "the means alone meet");
    // Degrees 64, 64, 0 are beyond the limit only where the rules allow them.
    assert!(gamma(64 * 65, 64 * 65, 0).is_err());
    assert_eq!(gamma(64 * 65, 64 * 65, 1), Ok(0.0));
    assert_eq!(gamma(usize::MAX, usize::MAX - 5, 0), Ok(0.0));
}

#[test]
#[should_panic(expected = "factor b: expected length 9, got 4")]
fn a_wrong_length_panics() {
    Product::<f32>::new(2, 3, 2).unwrap().apply(&[0.0; 4], &[0.0; 4], &mut [0.0; 4]);
}

/// An expansion of 1 to `most` bands.
fn expansion(most: usize) -> impl Strategy<Value = Vec<f64>> {
    (1..=most).prop_flat_map(|bands| prop::collection::vec(-10.0..10.0f64, bands * bands))
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn products_commute_and_distribute((f, g) in (expansion(7), expansion(7)), bands_out in 1usize..15, s in -4.0..4.0f64) {
        let scale = f64::EPSILON * norm(&f) * norm(&g);
        let fg = product_f64(&f, &g, bands_out);
        assert_all_close(&product_f64(&g, &f, bands_out), &fg, 2.0 * scale, "commutes");
        let scaled: Vec<f64> = f.iter().map(|f| f * s).collect();
        let want: Vec<f64> = fg.iter().map(|x| x * s).collect();
        assert_all_close(&product_f64(&scaled, &g, bands_out), &want, 2.0 * s.abs().max(1.0) * scale, "is linear");
        let other = random(f.len(), 40);
        let sum: Vec<f64> = f.iter().zip(&other).map(|(a, b)| a + b).collect();
        let want: Vec<f64> = fg.iter().zip(product_f64(&other, &g, bands_out)).map(|(a, b)| a + b).collect();
        assert_all_close(&product_f64(&sum, &g, bands_out), &want, 4.0 * (scale + f64::EPSILON * norm(&other) * norm(&g)), "distributes");
    }

    #[test]
    fn untruncated_products_associate((f, g, h) in (expansion(5), expansion(5), expansion(5))) {
        let full = |a: &[f64], b: &[f64]| product_f64(a, b, a.len().isqrt() + b.len().isqrt() - 1);
        let scale = 8.0 * f64::EPSILON * norm(&f) * norm(&g) * norm(&h);
        assert_all_close(&full(&full(&f, &g), &h), &full(&f, &full(&g, &h)), scale, "associates");
    }

    #[test]
    fn matrix_square_and_integral_agree_with_the_product((f, g, h) in (expansion(6), expansion(6), expansion(6))) {
        let bands = [&f, &g, &h].map(|x| x.len().isqrt());
        let plan = Product::<f64>::new(bands[0], bands[1], bands[2]).unwrap();
        let want = product_f64(&f, &g, bands[2]);
        let scale = f64::EPSILON * norm(&f) * norm(&g);
        let mut matrix = vec![0.0; h.len() * g.len()];
        plan.matrix(&f, &mut matrix);
        let got: Vec<f64> = matrix.chunks(g.len()).map(|row| row.iter().zip(&g).map(|(m, g)| m * g).sum()).collect();
        assert_all_close(&got, &want, 2.0 * scale, "matrix");
        let mut square = vec![0.0; h.len()];
        Square::new(bands[0], bands[2]).unwrap().apply(&f, &mut square);
        assert_all_close(&square, &product_f64(&f, &f, bands[2]), 2.0 * f64::EPSILON * norm(&f).powi(2), "square");
        // ∫ f g h, whichever factor comes last.
        let integral = plan.integral(&f, &g, &h);
        let turned = Product::<f64>::new(bands[1], bands[2], bands[0]).unwrap().integral(&g, &h, &f);
        assert_close(turned, integral, 2.0 * scale * norm(&h), "the integral is symmetric");
    }
}

fn batches_of_integrals_have_the_bits_of_one<T: Real>(bands: [usize; 3], count: usize) {
    let product = Product::<T>::new(bands[0], bands[1], bands[2]).unwrap();
    let sizes = bands.map(|n| n * n * count);
    let [a, b, red] = [0, 1, 2].map(|k| narrow::<T>(&random(sizes[k], 7 + k as u64)));
    let green = narrow::<T>(&random(sizes[2], 31));
    let ([mut r, mut g], mut scratch) =
        ([0; 2].map(|_| vec![T::nan(); count]), vec![T::nan(); product.scratch_len(count)]);
    product.integral_batch(count, &a, &b, [&red, &green], [&mut r, &mut g], &mut scratch);
    let pick = |all: &[T], v: usize| all.iter().skip(v).step_by(count).copied().collect::<Vec<T>>();
    for v in 0..count {
        for (c, out) in [(&red, &r), (&green, &g)] {
            assert_eq!(out[v], product.integral(&pick(&a, v), &pick(&b, v), &pick(c, v)), "{bands:?} {count} {v}");
        }
        let want = naive::triple_integral(&wide(&pick(&a, v)), &wide(&pick(&b, v)), &wide(&pick(&red, v)));
        let scale = [&a, &b, &red].map(|f| wide(&pick(f, v)).iter().map(|x| x * x).sum::<f64>().sqrt());
        assert_close(r[v].widen(), want, 2.0 * T::epsilon().widen() * scale.iter().product::<f64>() + 3e-15, "twin");
    }
    product.integral_batch(count, &a, &b, [], [], &mut scratch);
}

#[test]
fn triple_integrals_in_batches() {
    for bands in [[1, 1, 1], [2, 3, 2], [3, 3, 3], [4, 4, 4]] {
        for count in [0, 1, 2, 15, 16, 17, 33] {
            batches_of_integrals_have_the_bits_of_one::<f32>(bands, count);
            batches_of_integrals_have_the_bits_of_one::<f64>(bands, count);
        }
    }
}

#[test]
#[should_panic(expected = "integrals: expected length 2, got 1")]
fn there_is_an_integral_for_each_vector() {
    let product = Product::<f32>::new(1, 1, 1).unwrap();
    product.integral_batch(2, &[0.0; 2], &[0.0; 2], [&[0.0; 2]], [&mut [0.0; 1]], &mut [0.0; 2]);
}
