//! Pixel and Fourier couplings and triplings against golden values and naive twins.

use std::f64::consts::{PI, TAU};

use crate::support::{HAAR_AFFINE, assert_close, cases, golden, map, number};
use haarmonic::affine::AffineMap;
use haarmonic::nalgebra::{Complex, DVector};
use haarmonic::reference::affine as naive;
use haarmonic::reference::affine::fourier_basis::{
    fourier_coupling, fourier_coupling_matrix, fourier_coupling_nonzeros, fourier_tripling, fourier_tripling_count,
};
use haarmonic::reference::affine::pixel_basis::{
    pixel_coupling, pixel_coupling_bound, pixel_coupling_gradient, pixel_coupling_nonzeros, pixel_coupling_slope,
    pixel_tripling, pixel_tripling_nonzeros,
};
use haarmonic::strategies::{affine_map, dyadic_map, power_of_two};
use proptest::prelude::*;
use serde_json::Value;

fn list(v: &Value) -> &[Value] {
    v.as_array().unwrap()
}

#[track_caller]
fn assert_near(got: Complex<f64>, want: Complex<f64>, tolerance: f64, what: &str) {
    assert!((got - want).norm() <= tolerance, "{what}: got {got}, want {want}, off by {:e}", (got - want).norm());
}

#[test]
fn golden_pixels() {
    let file = golden(HAAR_AFFINE, "pixel_fourier_acc");
    for case in list(&file["pixel_n8"]) {
        let map = map(number(&case["s"]), number(&case["o"]));
        let want: Vec<_> = list(&case["nonzero"])
            .iter()
            .map(|e| (e[0].as_u64().unwrap() as usize, e[1].as_u64().unwrap() as usize, number(&e[2])))
            .collect();
        let mut got: Vec<_> = pixel_coupling_nonzeros(8, map).collect();
        assert!(got.is_sorted_by_key(|e| e.1));
        got.sort_by_key(|e| (e.0, e.1));
        assert_eq!(
            got.iter().map(|e| (e.0, e.1)).collect::<Vec<_>>(),
            want.iter().map(|e| (e.0, e.1)).collect::<Vec<_>>()
        );
        for (got, want) in got.iter().zip(&want) {
            // The rounding of o, ε/2·N.
            assert_close(got.2, want.2, 2e-15, &format!("{map:?} {got:?}"));
        }
        for i in 0..8 {
            for j in 0..8 {
                let want = want.iter().find(|e| (e.0, e.1) == (i, j)).map_or(0.0, |e| e.2);
                assert_close(pixel_coupling(8, i, j, map), want, 2e-15, &format!("{map:?} {i} {j}"));
                assert_close(naive::pixel_coupling(8, i, j, map), want, 2e-15, &format!("twin {map:?} {i} {j}"));
            }
        }
    }
}

#[test]
fn golden_fourier() {
    let file = golden(HAAR_AFFINE, "pixel_fourier_acc");
    for row in list(&file["fourier"]["rows"]) {
        let number = |k: usize| row[k].as_f64().unwrap_or_else(|| rational_or_decimal(&row[k]));
        let (p, q, map) = (number(0) as i64, number(1) as i64, map(number(2), number(3)));
        let want = Complex::new(number(4), number(5));
        assert_near(fourier_coupling(p, q, map), want, 2e-15, &format!("{p} {q} {map:?}"));
        assert_near(naive::fourier_coupling(p, q, map), want, 2e-15, &format!("twin {p} {q} {map:?}"));
    }
}

fn rational_or_decimal(v: &Value) -> f64 {
    v.as_str().unwrap().parse().unwrap()
}

#[test]
fn pixels_of_no_and_one_sample_and_at_the_ends_of_the_range() {
    assert_eq!(pixel_coupling_nonzeros(0, AffineMap::IDENTITY).count(), 0);
    assert_eq!(pixel_coupling_bound(0, AffineMap::IDENTITY), 0);
    assert_eq!(pixel_coupling_nonzeros(1, map(2.0, -0.5)).collect::<Vec<_>>(), [(0, 0, 0.5)]);
    assert_eq!(pixel_coupling_nonzeros(1, map(-2.0, 2.0)).collect::<Vec<_>>(), [(0, 0, 0.5)]);
    assert_eq!(pixel_coupling_nonzeros(1, map(1.0, 1.0)).count(), 0);
    assert_eq!(pixel_coupling_nonzeros(1, map(1.0, 1.0 - f64::EPSILON / 2.0)).count(), 1);
    // Every pixel of the target sees the first pixel of the source, at one point of it.
    let far = map(1e-100, 0.0);
    assert!(pixel_coupling_nonzeros(64, far).eq((0..64).map(|j| (0, j, 1.0))));
    assert!(pixel_coupling_nonzeros(64, map(-1e-100, 1.0)).eq((0..64).map(|j| (63, j, 1.0))));
    // The whole source is a speck at the corner of the first.
    assert!(pixel_coupling_nonzeros(64, map(1e100, 0.0)).eq((0..64).map(|i| (i, 0, 1e-100))));
    assert_eq!(pixel_coupling_nonzeros(64, map(1e100, 1e100)).count(), 0);
    assert_eq!(pixel_coupling_nonzeros(64, map(1e-100, -1e100)).count(), 0);
    assert_eq!(pixel_coupling_slope(64, 3, 3, map(1e-100, -1e100), [1.0, 1.0]), 0.0);
}

#[test]
fn the_bound_is_attained_and_the_printed_one_exceeded() {
    for size in [1, 2, 8, 16] {
        for scale in [1.0, 1.5, 0.75, 2.0, 0.3, -1.25, 7.0, 40.0, 0.02] {
            let bound = pixel_coupling_bound(size, map(scale, 0.0));
            // Source point x over target end k.
            let offsets =
                (0..=size).flat_map(|k| (-97..=194).map(move |x| f64::from(x) / 97.0 - scale * k as f64 / size as f64));
            let most = offsets.map(|o| pixel_coupling_nonzeros(size, map(scale, o)).count()).max();
            assert_eq!(most, Some(bound), "N = {size}, s = {scale}");
        }
    }
    let printed = |size: f64, s: f64| ((s + 1.0) * size).min((1.0 / s + 1.0) * size);
    assert!(pixel_coupling_bound(8, map(1.5, 0.0)) as f64 > printed(8.0, 1.5));
    assert_eq!(pixel_coupling_bound(8, AffineMap::IDENTITY), 15);
}

#[test]
#[should_panic(expected = "pixels [8, 0] of 8")]
fn a_pixel_beyond_the_last_is_refused() {
    pixel_coupling(8, 8, 0, AffineMap::IDENTITY);
}

#[test]
#[should_panic(expected = "pixels [0, 1, 2] of 2")]
fn a_third_pixel_beyond_the_last_is_refused() {
    pixel_tripling(2, 0, 1, 2, AffineMap::IDENTITY);
}

proptest! {
    #![proptest_config(cases(64))]

    // Relative: the twin's breakpoints are right to 1e-32 of the unit interval. Measured: 1.3 ε.
    #[test]
    fn pixels_equal_the_twin(size in power_of_two(4), map in affine_map()) {
        for i in 0..size {
            for j in 0..size {
                let want = naive::pixel_coupling(size, i, j, map);
                let error = 4.0 * f64::EPSILON * want + 1e-30 * size as f64;
                assert_close(pixel_coupling(size, i, j, map), want, error, &format!("{i} {j} of {size}"));
                for k in [j, 0] {
                    let want = naive::pixel_tripling(size, i, j, k, map);
                    let error = 8.0 * f64::EPSILON * want + 1e-30 * (size as f64).powf(1.5);
                    assert_close(pixel_tripling(size, i, j, k, map), want, error, &format!("{i} {j} {k} of {size}"));
                }
            }
        }
    }

    // Ends at k/3 are rounded in the twin: ε/2·N.
    #[test]
    fn pixels_of_any_number_equal_the_twin(size in 1..12usize, map in affine_map()) {
        let error = 1.0 * f64::EPSILON * size as f64 * (1.0 + map.scale().abs().recip());
        for (i, j, value) in pixel_coupling_nonzeros(size, map) {
            assert_close(value, naive::pixel_coupling(size, i, j, map), error, &format!("{i} {j} of {size}"));
        }
    }

    #[test]
    fn the_enumeration_has_every_non_zero_once(size in 0..20usize, map in affine_map()) {
        let mut want = Vec::new();
        for j in 0..size {
            for i in 0..size {
                let value = pixel_coupling(size, i, j, map);
                if value != 0.0 {
                    want.push((i, j, value));
                }
            }
        }
        let mut got: Vec<_> = pixel_coupling_nonzeros(size, map).collect();
        prop_assert!(got.len() <= pixel_coupling_bound(size, map));
        prop_assert!(got.is_sorted_by_key(|e| e.1));
        got.sort_by_key(|e| (e.1, e.0));
        prop_assert_eq!(&got, &want);
        let mut triples: Vec<_> = pixel_tripling_nonzeros(size, map).collect();
        triples.sort_by_key(|e| (e.0[1], e.0[0]));
        let root = (size as f64).sqrt();
        prop_assert!(triples.into_iter().eq(want.into_iter().map(|(i, j, value)| ([i, j, j], root * value))));
    }

    #[test]
    fn pixels_that_touch_are_not_counted(size in power_of_two(5), map in dyadic_map()) {
        prop_assert_eq!(pixel_coupling_nonzeros(size, map).count(), naive::count_pixel_nonzeros(size, map));
    }

    #[test]
    fn full_mantissas_are_counted_exactly(
        size in power_of_two(6), s in 0.1..8.0f64, k in 0..64usize, j in 0..64usize, ulps in -1..=1i32,
    ) {
        // An end of the source falls on an end of the target, or an ulp beside it.
        let (k, j) = (k % (size + 1), j % (size + 1));
        let touch = (k as f64 - s * j as f64) / size as f64;
        let offset = touch + f64::from(ulps) * f64::EPSILON * touch.abs();
        for s in [s, -s] {
            let map = map(s, offset);
            prop_assert_eq!(pixel_coupling_nonzeros(size, map).count(), naive::count_pixel_nonzeros(size, map));
        }
    }

    #[test]
    fn a_covered_pixel_is_shared_out(size in 1..40usize, s in -3.0..3.0f64, o in -2.0..2.0f64) {
        // Σ_i D_ij is the part of target pixel j that sees the source: all of it, if both of its ends do.
        prop_assume!(s.abs() > 1e-3);
        let map = map(s, o);
        let mut sums = vec![0.0; size];
        pixel_coupling_nonzeros(size, map).for_each(|(_, j, value)| sums[j] += value);
        for (j, sum) in sums.into_iter().enumerate() {
            let seen = [j, j + 1].map(|k| map.apply(k as f64 / size as f64));
            let (low, high) = (seen[0].min(seen[1]), seen[0].max(seen[1]));
            let want = (high.min(1.0) - low.max(0.0)).max(0.0) / (high - low);
            assert_close(sum, want, 1e-13 / s.abs(), &format!("pixel {j}"));
        }
    }

    // Differences of the twin, (h²)-accurate: D is a + b/s, and linear in o. With ε/h = 2e-10 times N.
    #[test]
    fn slopes_equal_one_sided_differences(size in power_of_two(3), map_ in dyadic_map()) {
        let h = 2f64.powi(-20) * map_.scale().abs().min(1.0);
        for i in 0..size {
            for j in 0..size {
                for along in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
                    let at = |h: f64| {
                        let moved = map(map_.scale() + h * along[0], map_.offset() + h * along[1]);
                        naive::pixel_coupling(size, i, j, moved)
                    };
                    let difference = |h: f64| (at(h) - at(0.0)) / h;
                    let want = 2.0 * difference(h / 2.0) - difference(h);
                    let got = pixel_coupling_slope(size, i, j, map_, along);
                    let scale = 1.0 + map_.scale().abs().powi(-2);
                    assert_close(got, want, 4e-9 * scale * size as f64, &format!("{i} {j} of {size} along {along:?}"));
                }
                let right = [[1.0, 0.0], [0.0, 1.0]].map(|along| pixel_coupling_slope(size, i, j, map_, along));
                prop_assert_eq!(pixel_coupling_gradient(size, i, j, map_), right);
            }
        }
    }

    // The quadrature's own error: measured below 4e-15 and 2e-15.
    #[test]
    fn fourier_equals_quadrature(n in -6..=6i64, p in -6..=6i64, q in -6..=6i64, s in -3.0..3.0f64, o in -7.0..7.0f64) {
        prop_assume!(s != 0.0);
        for map in [map(s, o), map((s * 2.0).round().max(0.5) / 2.0, o)] {
            let got = fourier_coupling(p, q, map);
            assert_near(got, naive::fourier_coupling(p, q, map), 1e-14, "coupling");
            let got = fourier_tripling(n, p, q, map);
            assert_near(got, naive::fourier_tripling(n, p, q, map), 5e-15, "tripling");
            assert_near(fourier_coupling(-p, -q, map), fourier_coupling(p, q, map).conj(), 4e-16, "conjugate");
        }
    }

    #[test]
    fn fourier_non_zeros_are_those_of_the_matrix(first in -9..=0i64, size in 0..14i64, map in affine_map()) {
        let frequencies = first..first + size;
        let matrix = fourier_coupling_matrix(frequencies.clone(), map);
        let mut listed = fourier_coupling_nonzeros(frequencies.clone(), map);
        for p in frequencies.clone() {
            for q in frequencies.clone() {
                let value = fourier_coupling(p, q, map);
                prop_assert_eq!(value, matrix[((q - first) as usize, (p - first) as usize)]);
                prop_assert!(value.norm() <= 1.0 + 4.0 * f64::EPSILON);
                if value != Complex::new(0.0, 0.0) {
                    prop_assert_eq!(listed.next(), Some((p, q, value)));
                }
            }
        }
        prop_assert_eq!(listed.next(), None);
    }
}

#[test]
fn fourier_counts() {
    for (s, o) in [(1.0, 0.0), (2.0, 0.3), (-1.0, 1.0), (-3.0, 0.5), (0.5, 0.0), (1.5, 0.1), (1.1, -2.0), (1e-100, 0.0)]
    {
        let map = map(s, o);
        let range = -5..6i64;
        let mut triples = 0;
        for n in range.clone() {
            for p in range.clone() {
                triples +=
                    range.clone().filter(|&q| fourier_tripling(n, p, q, map) != Complex::new(0.0, 0.0)).count() as u64;
            }
        }
        assert_eq!(fourier_tripling_count(range, map), triples, "s = {s}");
    }
    let count = |s, n: i64| fourier_coupling_nonzeros(-n..n, map(s, 0.1)).count() as i64;
    // Linear for an integer s only: eq. 4.18.
    for n in [8, 32, 64] {
        assert_eq!((count(1.0, n), count(2.0, n), count(-1.0, n)), (2 * n, n, 2 * n - 1));
        assert_eq!(count(2f64.sqrt(), n), 4 * n * n - 2 * n + 1);
    }
    assert_eq!(fourier_tripling_count(0..0, AffineMap::IDENTITY), 0);
}

#[test]
fn fourier_is_accurate_beside_its_zeros_and_its_peak() {
    for exponent in [-52, -45, -30, -20, -10, -3] {
        let delta = 2f64.powi(exponent);
        let map = map(1.0 + delta, 0.0);
        let size = |x: f64| (PI * delta).sin() / (PI * x);
        // sp − q = δ: all but 1; sp − q = δ − 4 and δ + 1: all but 0. Relative to D.
        for (q, x) in [(1, delta), (5, delta - 4.0), (0, 1.0 + delta)] {
            let want = Complex::from_polar(size(x).abs(), PI * delta + if x < 0.0 { PI } else { 0.0 });
            let got = fourier_coupling(1, q, map);
            assert_near(got, want, 1e-15 * want.norm(), &format!("δ = {delta:e}, q = {q}"));
        }
    }
    // Three times the f64 next to 1/3 is 1 − 2^−54: D_30 is −2^−54, not 0.
    assert_close(fourier_coupling(3, 0, map(1.0 / 3.0, 0.0)).re, -2f64.powi(-54), 1e-31, "a third");
    // A phase of many turns: 3o is rounded in f64, by up to 2e-9.
    let turns = map(1.0, TAU * 1e6);
    assert_near(fourier_coupling(3, 3, turns), fourier_coupling(1, 1, turns).powi(3), 5e-16, "powers of the phase");
    assert_eq!(fourier_coupling(1 << 40, 0, map(1e100, 1e100)), Complex::new(0.0, 0.0));
    assert_close(fourier_coupling(1 << 40, 0, map(1e-100, 1e100)).norm(), 1.0, 1e-15, "a huge phase");
}

#[test]
fn a_mirrored_signal_and_parseval() {
    // F = Σ c_p e^{ipv}, seen through −v + o: the matrix gives its coefficients exactly.
    let range = -3..4i64;
    let coefs: Vec<_> = range.clone().map(|p| Complex::new(p as f64 * 0.5 + 1.0, 0.25 - p as f64)).collect();
    let value = |coefs: &[Complex<f64>], v: f64| -> Complex<f64> {
        range.clone().zip(coefs).map(|(p, c)| c * Complex::cis(p as f64 * v)).sum()
    };
    let mirrored = fourier_coupling_matrix(range.clone(), map(-1.0, 0.7)) * DVector::from_column_slice(&coefs);
    for v in [0.0, 0.3, 2.0, 6.0] {
        assert_near(value(mirrored.as_slice(), v), value(&coefs, 0.7 - v), 4e-15 * 20.0, "mirrored");
    }
    // e^{isv} has length 1 on [0, 2π]: Σ_q |D_1q|² → 1, short by 2 sin²(πs)/(π²·q).
    let map = map(1.3, 0.2);
    let sum: f64 = (-2000..=2000).map(|q| fourier_coupling(1, q, map).norm_sqr()).sum();
    let tail = 2.0 * (PI * 1.3).sin().powi(2) / (PI * PI * 2000.5);
    assert_close(sum, 1.0 - tail, 5e-10, "Parseval");
}
