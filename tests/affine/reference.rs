//! The naive twins of affine wavelets against golden values: what every other test of this room leans on.

use std::collections::HashMap;

use crate::support::{HAAR_AFFINE, assert_close, golden, half_power, number, numbers};
use haarmonic::affine::AffineMap;
use haarmonic::haar::{Decomposition, forward_2d};
use haarmonic::reference::affine as naive;
use serde_json::Value;

fn index(v: &Value) -> usize {
    v.as_u64().unwrap() as usize
}

fn list(v: &Value) -> &[Value] {
    v.as_array().unwrap()
}

fn map(s: &Value, o: &Value) -> AffineMap {
    AffineMap::new(number(s), number(o)).unwrap()
}

/// Whether both numbers are the rationals that the file names, rather than rounded.
fn is_dyadic(case: &Value) -> bool {
    ["s", "o"].iter().all(|key| {
        let denominator: u64 = case[key].as_str().unwrap().split_once('/').unwrap().1.parse().unwrap();
        denominator.is_power_of_two()
    })
}

#[test]
fn golden_couplings_and_their_counts() {
    for name in ["acc_n8", "acc_n16"] {
        let file = golden(HAAR_AFFINE, name);
        let size = index(&file["N"]);
        for case in list(&file["cases"]) {
            let map = map(&case["s"], &case["o"]);
            let nonzero: HashMap<_, _> = list(&case["nonzero"])
                .iter()
                .map(|e| ((index(&e[0]), index(&e[1])), half_power(&e[2], &e[3])))
                .collect();
            for i in 0..size {
                for j in 0..size {
                    let (got, want) = (naive::coupling_1d(i, j, map), nonzero.get(&(i, j)).copied());
                    // |D| is up to 4; the rounding of s and o shows, by slopes up to 2^{(l_i + l_j)/2} = 8.
                    assert_close(got, want.unwrap_or(0.0), 2e-15, &format!("{name} {map:?} {i} {j}"));
                    if is_dyadic(case) {
                        let sign = want.map_or(0, |d| d.signum() as i32);
                        assert_eq!(naive::coupling_sign_1d(i, j, map), sign, "{map:?} {i} {j}");
                    }
                }
            }
            if is_dyadic(case) {
                assert_eq!(naive::count_nonzeros_1d(size, map), index(&case["count"]), "{map:?}");
            }
        }
    }
}

#[test]
fn golden_gradients_by_differences() {
    for row in list(&golden(HAAR_AFFINE, "acc_grad_n16")["rows"]) {
        let (i, j, map) = (index(&row[0]), index(&row[1]), map(&row[2], &row[3]));
        let what = format!("{i} {j} {map:?}");
        assert_close(naive::coupling_1d(i, j, map), half_power(&row[4], &row[5]), 2e-15, &what);
        let [in_s, in_o] = [half_power(&row[6], &row[7]), half_power(&row[8], &row[9])];
        for step in [1e-6, -1e-6] {
            // h² of a few D, and ε/h = 2e-10 of it.
            assert_close(naive::coupling_slope_1d(i, j, map, [1.0, 0.0], step), in_s, 5e-9, &what);
            assert_close(naive::coupling_slope_1d(i, j, map, [0.0, 1.0], step), in_o, 5e-9, &what);
        }
        let diagonal = naive::coupling_slope_1d(i, j, map, [1.0, -2.0], 1e-6);
        assert_close(diagonal, in_s - 2.0 * in_o, 1e-8, &what);
    }
}

#[test]
fn golden_triplings() {
    let file = golden(HAAR_AFFINE, "atc_n8");
    let size = index(&file["N"]);
    for case in list(&file["cases"]) {
        let map = map(&case["s"], &case["o"]);
        let nonzero: HashMap<_, _> = list(&case["nonzero"])
            .iter()
            .map(|e| ([0, 1, 2].map(|n| index(&e[n])), half_power(&e[3], &e[4])))
            .collect();
        let mut ordered = 0;
        for i in 0..size {
            for j in 0..size {
                for k in 0..size {
                    let want = nonzero.get(&[i, j.min(k), j.max(k)]).copied();
                    let what = format!("{map:?} {i} {j} {k}");
                    assert_close(naive::tripling_1d(i, j, k, map), want.unwrap_or(0.0), 4e-15, &what);
                    ordered += usize::from(want.is_some());
                    if is_dyadic(case) {
                        assert_eq!(naive::tripling_sign_1d(i, j, k, map), want.map_or(0, |d| d.signum() as i32));
                    }
                }
            }
        }
        if is_dyadic(case) {
            assert_eq!(naive::count_tripling_nonzeros_1d(size, map), ordered);
        }
    }
}

#[test]
fn golden_products_of_samples() {
    for case in list(&golden(HAAR_AFFINE, "affine_products_1d")["cases"]) {
        let map = map(&case["s"], &case["o"]);
        let [f, g, w] = ["F", "G", "W"].map(|name| numbers(&case[name]));
        let (double, triple) = (naive::double_product(&f, &g, map), naive::triple_product(&f, &g, &w, map));
        assert_close(double, number(&case["double"]), 8e-15 * (1.0 + double.abs()), &format!("{map:?}"));
        assert_close(triple, number(&case["triple"]), 8e-15 * (1.0 + triple.abs()), &format!("{map:?}"));
    }
}

#[test]
fn golden_propagation() {
    let file = golden(HAAR_AFFINE, "propagate_2d");
    let size = index(&file["N"]);
    for case in list(&file["cases"]) {
        let maps = [map(&case["sx"], &case["ox"]), map(&case["sy"], &case["oy"])];
        let image: Vec<f64> =
            list(&case["image_rows_y"]).iter().flat_map(|row| list(row).iter().map(|v| v.as_f64().unwrap())).collect();
        let got = naive::resample_2d(&image, size, size, maps);
        let want: Vec<f64> = list(&case["target_pixel_averages"]).iter().flat_map(numbers).collect();
        for (k, (&got, &want)) in got.iter().zip(&want).enumerate() {
            assert_close(got, want, 3e-14, &format!("{maps:?} pixel {k}"));
        }
        let pairs = |v: &Value| list(v).iter().map(|c| half_power(&c[0], &c[1])).collect::<Vec<_>>();
        let standard: Vec<f64> = list(&case["target_standard"]).iter().flat_map(pairs).collect();
        let nonstandard = pairs(&case["target_nonstandard"]);
        for (want, decomposition) in [(standard, Decomposition::Standard), (nonstandard, Decomposition::Nonstandard)] {
            let got = forward_2d(&got, size, size, decomposition).unwrap();
            for (k, (&got, &want)) in got.iter().zip(&want).enumerate() {
                assert_close(got, want, 3e-14, &format!("{maps:?} coefficient {k}"));
            }
        }
        // L_k = Σ_i F_i D_ik, with every coefficient of the nonstandard basis, and of the standard one.
        let source = forward_2d(&image, size, size, Decomposition::Nonstandard).unwrap();
        let target = forward_2d(&got, size, size, Decomposition::Nonstandard).unwrap();
        for k in 0..size * size {
            let sum: f64 = (0..size * size).map(|i| source[i] * naive::coupling_nonstandard(i, k, maps)).sum();
            assert_close(sum, target[k], 5e-14, &format!("{maps:?} nonstandard {k}"));
        }
        let source = forward_2d(&image, size, size, Decomposition::Standard).unwrap();
        let target = forward_2d(&got, size, size, Decomposition::Standard).unwrap();
        let split = |k: usize| [k % size, k / size];
        for k in (0..size * size).step_by(5) {
            let sum: f64 =
                (0..size * size).map(|i| source[i] * naive::coupling_standard(&split(i), &split(k), &maps)).sum();
            assert_close(sum, target[k], 5e-14, &format!("{maps:?} standard {k}"));
        }
    }
}

#[test]
fn a_light_field_is_a_sum_of_affine_triplings() {
    // L_k = Σ_ij F_ij D_ijk with the standard coefficients F_ij of the field [Sun 2008, eq. 4.37].
    let size = 8;
    let field: Vec<f64> = (0..size * size).map(|n| ((n * 37 + 11) % 23) as f64 - 7.0).collect();
    for (s, o) in [(1.0, 0.0), (1.5, -0.2), (-1.25, 1.125), (0.3, 0.6)] {
        let map = AffineMap::new(s, o).unwrap();
        let means = naive::resample_light_field(&field, size, map);
        let got = haarmonic::haar::forward_1d(&means).unwrap();
        // Rows v₁, columns v₂: coefficient [i][j] belongs to ψ_i(v₁) ψ_j(v₂).
        let coefs = forward_2d(&field, size, size, Decomposition::Standard).unwrap();
        for (k, got) in got.into_iter().enumerate() {
            let mut want = 0.0;
            for i in 0..size {
                for j in 0..size {
                    want += coefs[i * size + j] * naive::tripling_1d(i, j, k, map);
                }
            }
            assert_close(got, want, 5e-14, &format!("s {s} o {o} k {k}"));
        }
    }
    // A field that does not depend on the direction is a signal.
    let signal = [3.0, -1.0, 4.0, 1.0];
    let constant: Vec<f64> = signal.iter().flat_map(|&x| [x; 4]).collect();
    let map = AffineMap::new(0.7, 0.2).unwrap();
    assert_eq!(naive::resample_light_field(&constant, 4, map), naive::resample_1d(&signal, map));
}

#[test]
fn triplings_are_products_of_axes_and_agree_with_standard_ones_at_rest() {
    let rest = [AffineMap::IDENTITY; 2];
    for i in 0..16 {
        for j in 0..16 {
            for k in 0..16 {
                let want = haarmonic::haar::tripling_2d(i, j, k).value::<f64>();
                assert_close(naive::tripling_nonstandard(i, j, k, rest), want, 1e-15, "at rest");
            }
        }
    }
    let maps = [AffineMap::new(1.5, -0.2).unwrap(), AffineMap::new(-0.75, 0.9).unwrap()];
    let want = naive::tripling_1d(2, 1, 4, maps[0]) * naive::tripling_1d(1, 3, 6, maps[1]);
    assert!(want.abs() > 0.01, "{want}");
    assert_eq!(naive::tripling_standard(&[2, 1], &[1, 3], &[4, 6], &maps), want);
    // Flat 12 is the diagonal detail at (0, 0) of level 1: 2 ψ(2x) ψ(2y), ψ_2 on both axes; flat 0 is 1.
    let want = naive::tripling_1d(2, 0, 2, maps[0]) * naive::tripling_1d(2, 0, 2, maps[1]);
    assert_close(naive::tripling_nonstandard(12, 0, 12, maps), want, 1e-15, "one diagonal");
}

#[test]
fn the_counts_of_non_zeros_reach_the_errata_s_maxima() {
    // Largest near s = 1; (N, count). Odd offsets in units far below a cell leave no breakpoints in common.
    let offsets = (0..64).map(|n| f64::from(2 * n + 1) / 4096.0);
    let maps: Vec<_> = offsets
        .flat_map(|o| {
            [1.0 + 1.0 / 8192.0, 1.0 - 1.0 / 8192.0, -1.0 - 1.0 / 8192.0]
                .map(|s| (s, if s > 0.0 { o } else { o + 1.0 }))
        })
        .map(|(s, o)| AffineMap::new(s, o).unwrap())
        .collect();
    // The known maxima 29, 80, 193, 432 are of wavelets with wavelets; 2 log₂N + 1 couplings with the scaling function
    // come on top.
    for (size, wavelets) in [(8, 29), (16, 80), (32, 193), (64, 432)] {
        let most = maps.iter().map(|&map| naive::count_nonzeros_1d(size, map)).max().unwrap();
        assert_eq!(most, wavelets + 2 * size.ilog2() as usize + 1, "N = {size}");
    }
    let pairs = || (1..32).flat_map(|i| (1..32).map(move |j| (i, j)));
    let count = |map| pairs().filter(|&(i, j)| naive::coupling_sign_1d(i, j, map) != 0).count();
    assert_eq!(maps.iter().map(|&map| count(map)).max(), Some(193));
    assert_eq!(naive::count_nonzeros_1d(1, AffineMap::IDENTITY), 1);
    assert_eq!(naive::count_nonzeros_1d(0, AffineMap::IDENTITY), 0);
    // At rest: δ_ij, and the ordered standard triplings.
    assert_eq!(naive::count_nonzeros_1d(128, AffineMap::IDENTITY), 128);
    assert_eq!([8, 16, 32].map(|n| naive::count_tripling_nonzeros_1d(n, AffineMap::IDENTITY)), [52, 148, 388]);
    assert_eq!(naive::count_nonzeros_nonstandard(8, [AffineMap::IDENTITY; 2]), 64);
    assert_eq!(naive::count_pixel_nonzeros(64, AffineMap::IDENTITY), 64);
    // Of the 2D nonstandard basis, pair by pair.
    let maps = [AffineMap::new(1.25, -0.125).unwrap(), AffineMap::new(-0.75, 0.8).unwrap()];
    let pairs = (0..16).flat_map(|i| (0..16).map(move |j| (i, j)));
    let nonzero = |&(i, j): &(usize, usize)| naive::coupling_nonstandard(i, j, maps).abs() > 1e-12;
    assert_eq!(naive::count_nonzeros_nonstandard(4, maps), pairs.clone().filter(nonzero).count());
    for (i, j) in pairs {
        let value = naive::coupling_nonstandard(i, j, maps);
        let sign = if value.abs() > 1e-12 { value.signum() as i32 } else { 0 };
        assert_eq!(naive::coupling_sign_nonstandard(i, j, maps), sign);
    }
}

#[test]
fn exact_signs_tell_touching_from_overlapping_by_one_bit() {
    // ψ_1 of the source begins where the target ends: o = 1. One ulp less and a sliver of 1e-16 is left.
    let touching = AffineMap::new(1.0, 1.0).unwrap();
    let sliver = AffineMap::new(1.0, 1.0 - f64::EPSILON / 2.0).unwrap();
    assert_eq!(naive::coupling_sign_1d(1, 1, touching), 0);
    // The target's start meets the source's end: ψ is −1 there and +1 here.
    assert_eq!(naive::coupling_sign_1d(1, 1, sliver), -1);
    assert_eq!(naive::coupling_1d(1, 1, sliver), -f64::EPSILON / 2.0);
    // Full mantissas at both ends of the range of scales, and N = 1024.
    for s in [0.1 / 16.0, 1.0 / 3.0, 250.1] {
        let map = AffineMap::new(s, 1.0 / 3.0).unwrap();
        for (i, j) in [(1023, 1023), (512, 700), (341, 0), (1, 1)] {
            let value = naive::coupling_1d(i, j, map);
            let sign = if value.abs() > 1e-12 { value.signum() as i32 } else { 0 };
            assert_eq!(naive::coupling_sign_1d(i, j, map), sign, "{s} {i} {j}: {value:e}");
        }
    }
}

#[test]
fn resampling_keeps_its_edges() {
    let map = AffineMap::new(2.0, -0.5).unwrap();
    assert!(naive::resample_1d(&[], map).is_empty());
    assert_eq!(naive::resample_1d(&[3.0], map), [1.5]); // [¼, ¾] of the target is inside
    assert_eq!(naive::resample_1d(&[1.0, 2.0], AffineMap::IDENTITY), [1.0, 2.0]);
    assert_eq!(naive::resample_1d(&[1.0, 2.0], AffineMap::new(-1.0, 1.0).unwrap()), [2.0, 1.0]);
    assert_eq!(naive::resample_1d(&[1.0, 2.0], AffineMap::new(1.0, 1.0).unwrap()), [0.0, 0.0]);
    // NaN reaches the cells that see it.
    let seen = naive::resample_1d(&[1.0, f64::NAN, 1.0, 1.0], AffineMap::new(1.0, 0.125).unwrap());
    assert!(seen[0].is_nan() && seen[1].is_nan() && seen[2] == 1.0 && seen[3] == 0.5);
    assert_eq!(naive::double_product(&[], &[], map), 0.0);
    assert!(naive::resample_2d(&[], 0, 0, [map; 2]).is_empty());
    let wide = naive::resample_2d(&[1.0, 2.0, 3.0, 4.0], 4, 1, [map, AffineMap::IDENTITY]);
    assert_eq!(wide, [0.0, 1.5, 3.5, 0.0]);
}
