//! Affine tripling coefficients against golden values and naive twins.

use crate::support::{
    HAAR_AFFINE, assert_close, cases, differentiable, golden, half_power, map, number, right_gradient,
};
use haarmonic::affine::{
    AffineMap, Atom, Mother, TripleNonzeros1d, TripleNonzerosNonstandard, canonical, coupling_1d, coupling_gradient_1d,
    coupling_gradient_standard, tripling_1d, tripling_gradient_1d, tripling_gradient_nonstandard,
    tripling_gradient_standard, tripling_nonstandard, tripling_standard,
};
use haarmonic::haar;
use haarmonic::reference::affine as naive;
use haarmonic::strategies;
use proptest::prelude::*;
use serde_json::Value;

const EPS: f64 = f64::EPSILON;

fn golden_map(case: &Value) -> AffineMap {
    map(number(&case["s"]), number(&case["o"]))
}

/// Some maps of every sort: identity, mirrored, zooming in and out, partly and wholly outside, with coinciding
/// breakpoints.
fn maps() -> Vec<AffineMap> {
    [
        (1.0, 0.0),
        (-1.0, 1.0),
        (1.0, 0.25),
        (1.0037, -0.0021),
        (0.5, 0.25),
        (3.0, -1.0),
        (-3.0, 2.0),
        (0.713, 0.2),
        (-0.713, 0.9),
        (2.6, -0.7),
        (-9.1, 5.3),
        (0.01, 0.4),
        (1.0, 1.5),
        (1.0, 1.0),
    ]
    .map(|(s, o)| map(s, o))
    .to_vec()
}

/// The largest value that |D_ijk| can have, a scale for its errors: ∫ |f g h| ≤ the amplitudes, over the finest
/// support.
fn scale([i, j, k]: [usize; 3]) -> f64 {
    [i, j, k].iter().map(|&flat| 2f64.powf(f64::from(Atom::from_flat(flat).level) / 2.0)).product()
}

#[test]
fn golden_triplings() {
    let file = golden(HAAR_AFFINE, "atc_n8");
    let size = file["N"].as_u64().unwrap() as usize;
    let nonzeros = TripleNonzeros1d::new(size).unwrap();
    for case in file["cases"].as_array().unwrap() {
        let map = golden_map(case);
        let mut want = std::collections::BTreeMap::new();
        for e in case["nonzero"].as_array().unwrap() {
            let [i, j, k] = [0, 1, 2].map(|n| e[n].as_u64().unwrap() as usize);
            want.insert([i, j, k], half_power(&e[3], &e[4]));
        }
        let mut got = std::collections::BTreeMap::new();
        nonzeros.all(map, |i, j, k, d| assert_eq!(got.insert([i, j, k], d), None, "visited once"));
        assert_eq!(got.keys().collect::<Vec<_>>(), want.keys().collect::<Vec<_>>(), "{map:?}");
        for (&[i, j, k], &want) in &want {
            for d in [got[&[i, j, k]], tripling_1d(i, j, k, map), tripling_1d(i, k, j, map)] {
                assert_close(d, want, 1e-14, &format!("{i} {j} {k} {map:?}"));
            }
            let reference = naive::tripling_1d(i, j, k, map);
            assert_close(reference, want, 1e-14, "the twin");
        }
        for (i, j, k) in triples(size) {
            if j <= k && !want.contains_key(&[i, j, k]) {
                assert_close(tripling_1d(i, j, k, map), 0.0, 1e-14, &format!("{i} {j} {k} {map:?}"));
            }
        }
    }
}

fn triples(size: usize) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..size * size * size).map(move |n| (n / (size * size), n / size % size, n % size))
}

/// All of D as a dense table, once by rows, once by columns, once by partners; they must agree.
fn dense(size: usize, map: AffineMap) -> Vec<f64> {
    let nonzeros = TripleNonzeros1d::new(size).unwrap();
    let at = |i, j, k| (i * size + j) * size + k;
    let [mut rows, mut columns, mut partners] = [(); 3].map(|()| vec![0.0; size.pow(3)]);
    nonzeros.all(map, |i, j, k, d| {
        assert!(j <= k && d != 0.0 && rows[at(i, j, k)] == 0.0);
        (rows[at(i, j, k)], rows[at(i, k, j)]) = (d, d);
    });
    for a in 0..size {
        for b in 0..size {
            let mut previous = None;
            nonzeros.column(a, b, map, |i, d| {
                assert!(d != 0.0 && previous.replace(i) < Some(i), "ascending");
                columns[at(i, a, b)] = d;
            });
            let mut previous = None;
            nonzeros.partners(a, b, map, |k, d| {
                assert!(d != 0.0 && previous.replace(k) < Some(k), "ascending");
                partners[at(a, b, k)] = d;
            });
        }
    }
    for (i, j, k) in triples(size) {
        let [d, by_column, by_partners] = [&rows, &columns, &partners].map(|table| table[at(i, j, k)]);
        let tolerance = 4.0 * EPS * scale([i, j, k]) * condition(map);
        for other in [by_column, by_partners] {
            assert_close(other, d, tolerance, &format!("{i} {j} {k} {map:?}"));
            // At extreme scales, one route may round to 0 what another does not.
            let extreme = !(1.0 / 256.0..256.0).contains(&map.scale().abs());
            assert!(extreme || (other == 0.0) == (d == 0.0), "{i} {j} {k} {map:?}: {other:e} {d:e}");
        }
    }
    rows
}

/// How much a rounding of a source point moves the target points.
fn condition(map: AffineMap) -> f64 {
    1.0 + (1.0 + map.offset().abs()) / map.scale().abs()
}

#[test]
fn triplings_equal_numeric_integration_by_every_route() {
    for size in [1, 2, 4, 8, 16] {
        for map in maps() {
            let table = dense(size, map);
            for (i, j, k) in triples(size) {
                let want = naive::tripling_1d(i, j, k, map);
                let tolerance = 4.0 * EPS * scale([i, j, k]) * condition(map);
                for got in [table[(i * size + j) * size + k], tripling_1d(i, j, k, map)] {
                    assert_close(got, want, tolerance, &format!("{size}: {i} {j} {k} {map:?}"));
                }
            }
        }
    }
}

#[test]
fn only_exactly_nonzero_triplings_are_visited() {
    for map in maps() {
        for size in [1, 2, 8, 16] {
            let got = TripleNonzeros1d::new(size).unwrap().ordered_count(map);
            assert_eq!(got, naive::count_tripling_nonzeros_1d(size, map), "{size} {map:?}");
        }
    }
}

#[test]
fn lemma_1_is_exact_for_haar() {
    let size = 16;
    for map in maps() {
        for (i, j, k) in triples(size) {
            let sum: f64 = (0..size).map(|l| coupling_1d(i, l, map) * haar::tripling_1d(l, j, k).value::<f64>()).sum();
            let tolerance = 2.0 * EPS * scale([i, j, k]) * condition(map);
            assert_close(tripling_1d(i, j, k, map), sum, tolerance, &format!("{i} {j} {k} {map:?}"));
        }
    }
}

#[test]
fn property_2_holds_with_its_sign_and_for_equal_indices() {
    let level = |flat| f64::from(Atom::from_flat(flat).level);
    for map in maps() {
        for (i, j, k) in (0..16usize.pow(3)).map(|n| (1 + n % 15, 1 + n / 16 % 15, 1 + n / 256 % 15)) {
            let (n, m) = (j.min(k), j.max(k));
            let (fine, from) = (Atom::from_flat(m), Atom::from_flat(i));
            let below = fine.level - Atom::from_flat(n).level;
            let cells = 2f64.powf(level(m));
            let centre = (from.offset as f64 + 0.5) / 2f64.powf(level(i));
            let r = cells / 2f64.powf(level(i)) / (2.0 * map.scale());
            let c = cells * (centre - map.offset()) / map.scale() - fine.offset as f64;
            let want = if j == k {
                2f64.powf(level(i) / 2.0) * canonical(Mother::Wavelet, Mother::Scaling, r, c)
            } else if fine.offset >> below == Atom::from_flat(n).offset && below > 0 {
                let sign = if fine.offset >> (below - 1) & 1 == 1 { -1.0 } else { 1.0 };
                sign * 2f64.powf((level(i) - level(m) + level(n)) / 2.0)
                    * canonical(Mother::Wavelet, Mother::Wavelet, r, c)
            } else {
                0.0
            };
            let tolerance = 2.0 * EPS * scale([i, j, k]) * condition(map);
            assert_close(tripling_1d(i, j, k, map), want, tolerance, &format!("{i} {j} {k} {map:?}"));
        }
    }
}

#[test]
fn the_identity_gives_standard_triplings() {
    let size = 16;
    let nonzeros = TripleNonzeros1d::new(size).unwrap();
    assert_eq!(nonzeros.ordered_count(AffineMap::IDENTITY) as u64, haar::tripling_count_1d(size).unwrap());
    for (i, j, k) in triples(size) {
        let want = haar::tripling_1d(i, j, k).value::<f64>();
        assert_close(tripling_1d(i, j, k, AffineMap::IDENTITY), want, 2.0 * EPS * want.abs(), &format!("{i} {j} {k}"));
    }
    let identity = [AffineMap::IDENTITY; 2];
    let mut listed = 0;
    TripleNonzerosNonstandard::new(4).unwrap().all(identity, |i, j, k, d| {
        listed += if j == k { 1 } else { 2 };
        let want = haar::tripling_2d(i, j, k).value::<f64>();
        assert!(want != 0.0);
        assert_close(d, want, 2.0 * EPS * want.abs(), &format!("{i} {j} {k}"));
    });
    assert_eq!(listed, haar::tripling_count_2d(4).unwrap());
}

#[test]
fn a_tiny_scale_sees_one_value() {
    // D → Φ_i(o) C_jk for s → 0 [ERRATA of eq. 4.20]: the whole target sees the source at o.
    for scale in [1e-9, -1e-9, 1e-100] {
        for (i, at) in [(0, 1.0), (1, 1.0), (3, 0.0), (5, -2.0), (6, 0.0)] {
            for (j, k) in [(0, 0), (3, 3), (0, 3), (1, 2)] {
                let want = if j == k { at } else { 0.0 };
                assert_close(tripling_1d(i, j, k, map(scale, 0.4)), want, 4.0 * EPS, &format!("{i} {j} {k} {scale}"));
            }
        }
    }
}

/// All of the 2D D by every route against the twin.
#[test]
fn nonstandard_triplings_equal_numeric_integration_by_every_route() {
    let uneven = [map(0.713, 0.2), map(-1.37, 1.21)];
    let pairs = [uneven, [map(3.0, -1.0), map(0.5, 0.25)], [map(1.0, 0.25); 2], [AffineMap::IDENTITY; 2]];
    for (side, maps) in [1usize, 2, 4].into_iter().flat_map(|side| pairs.map(|maps| (side, maps))) {
        let (n, nonzeros) = (side * side, TripleNonzerosNonstandard::new(side).unwrap());
        let mut rows = std::collections::BTreeMap::new();
        nonzeros.all(maps, |i, j, k, d| assert!(j <= k && d != 0.0 && rows.insert((i, j, k), d).is_none()));
        assert_eq!(nonzeros.count(maps), rows.len());
        let tolerance = |ijk: [usize; 3]| -> f64 {
            let amplitudes: f64 =
                ijk.map(|flat| 2f64.powi(Atom::from_nonstandard(flat)[0].level as i32)).iter().product();
            EPS * amplitudes * (condition(maps[0]) + condition(maps[1]))
        };
        for j in 0..n {
            for k in 0..n {
                let mut column = vec![0.0; n];
                nonzeros.column(j, k, maps, |i, d| {
                    assert!(d != 0.0 && column[i] == 0.0);
                    column[i] = d;
                });
                for (i, by_column) in column.into_iter().enumerate() {
                    let what = format!("{side}: {i} {j} {k} {maps:?}");
                    let want = naive::tripling_nonstandard(i, j, k, maps);
                    let by_row = rows.get(&(i, j.min(k), j.max(k))).copied().unwrap_or(0.0);
                    for got in [tripling_nonstandard(i, j, k, maps), by_column, by_row] {
                        assert_close(got, want, tolerance([i, j, k]), &what);
                    }
                    assert_eq!((by_row == 0.0, by_column == 0.0), (want.abs() < 1e-13, want.abs() < 1e-13), "{what}");
                }
            }
        }
    }
}

#[test]
fn standard_triplings_are_products() {
    let maps = [map(0.7, 0.1), map(-1.3, 1.1), map(2.0, -0.6)];
    let mut nonzeros = 0;
    for (i, j, k) in triples(4) {
        for (l, m, n) in triples(4) {
            // The third axis repeats the second, under a map of its own.
            let (i, j, k) = ([i, l, l], [j, m, m], [k, n, n]);
            let want = naive::tripling_standard(&i, &j, &k, &maps);
            let amplitudes: f64 = (0..3).map(|q| scale([i[q], j[q], k[q]])).product();
            assert_close(tripling_standard(i, j, k, maps), want, 4.0 * EPS * amplitudes, &format!("{i:?} {j:?} {k:?}"));
            nonzeros += usize::from(want != 0.0);
        }
    }
    assert!(nonzeros > 100, "{nonzeros} of 4096");
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn triplings_are_symmetric_and_right(
        map in strategies::affine_map(), i in 0..64usize, j in 0..64usize, k in 0..64usize,
    ) {
        let d = tripling_1d(i, j, k, map);
        prop_assert_eq!(d, tripling_1d(i, k, j, map));
        let want = naive::tripling_1d(i, j, k, map);
        let tolerance = 4.0 * EPS * scale([i, j, k]) * condition(map);
        prop_assert!((d - want).abs() <= tolerance, "got {:e}, want {:e}", d, want);
        prop_assert!(d.abs() <= scale([i, j, k]));
    }

    #[test]
    fn rows_columns_and_partners_agree(map in strategies::affine_map(), log in 0..4u32) {
        dense(1 << log, map);
    }

    #[test]
    fn counts_are_exact(map in strategies::dyadic_map(), log in 0..5u32) {
        let got = TripleNonzeros1d::new(1 << log).unwrap().ordered_count(map);
        prop_assert_eq!(got, naive::count_tripling_nonzeros_1d(1 << log, map));
    }

    #[test]
    fn gradients_are_right_hand_slopes(map in differentiable()) {
        check_gradients(map, 1e-8);
    }
}

/// Gradients of all D_ijk of 8 functions against differences.
fn check_gradients(map: AffineMap, tolerance: f64) {
    for (i, j, k) in triples(8) {
        let want = right_gradient(map, |map| naive::tripling_1d(i, j, k, map));
        for (got, want) in tripling_gradient_1d(i, j, k, map).into_iter().zip(want) {
            assert_close(got, want, tolerance * scale([i, j, k]), &format!("{i} {j} {k} {map:?}"));
        }
    }
}

#[test]
fn gradients_at_kinks_are_right_hand() {
    for map in maps().into_iter().filter(|map| map.scale().abs() > 0.1) {
        check_gradients(map, 1e-8);
    }
}

#[test]
fn nonstandard_gradients_are_right_hand_slopes() {
    let maps = [map(0.713, 0.2), map(-1.375, 1.25)];
    for (i, j, k) in triples(16) {
        let got = tripling_gradient_nonstandard(i, j, k, maps);
        for q in 0..2 {
            let want = right_gradient(maps[q], |map| {
                naive::tripling_nonstandard(i, j, k, if q == 0 { [map, maps[1]] } else { [maps[0], map] })
            });
            for (got, want) in got[q].into_iter().zip(want) {
                assert_close(got, want, 1e-6, &format!("{i} {j} {k} axis {q}"));
            }
        }
    }
}

#[test]
fn standard_gradients_are_right_hand_slopes() {
    // Without a kink, at one in x, and at kinks of both axes.
    for maps in
        [[map(0.713, 0.2), map(-1.375, 1.25)], [map(1.0, 0.25), map(2.613, -0.737)], [map(-1.0, 1.0), map(0.5, 0.25)]]
    {
        for (i, j, k) in triples(4) {
            for (l, m, n) in triples(4) {
                let (i, j, k) = ([i, l], [j, m], [k, n]);
                let got = tripling_gradient_standard(i, j, k, maps);
                let coupled = coupling_gradient_standard(i, j, maps);
                for q in 0..2 {
                    let beside = |map| if q == 0 { [map, maps[1]] } else { [maps[0], map] };
                    let want = right_gradient(maps[q], |map| naive::tripling_standard(&i, &j, &k, &beside(map)));
                    for (got, want) in got[q].into_iter().zip(want) {
                        assert_close(got, want, 1.5e-9, &format!("{i:?} {j:?} {k:?}, axis {q}, {maps:?}"));
                    }
                    if k == [0, 0] {
                        let want = right_gradient(maps[q], |map| naive::coupling_standard(&i, &j, &beside(map)));
                        for (got, want) in coupled[q].into_iter().zip(want) {
                            assert_close(got, want, 1.5e-9, &format!("{i:?} {j:?}, axis {q}, {maps:?}"));
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn standard_gradients_of_known_values() {
    // Means of [0, 1): min(1, (1 − o)/s) − … of each axis: 1/s for s = 2, o = 0; 1 − o for s = 1; in three dimensions.
    let maps = [map(2.0, 0.0), map(1.0, 0.5), map(4.0, 0.0)];
    let want = [[-0.03125, -0.0625], [-0.0625, -0.125], [-0.015625, -0.0625]];
    assert_eq!(coupling_gradient_standard([0; 3], [0; 3], maps), want);
    assert_eq!(tripling_gradient_standard([0; 3], [1; 3], [1; 3], maps), want);
    // A factor of zero leaves the others no gradient, and keeps its own.
    let maps = [map(1.0, 0.0), map(0.5, 0.25)];
    assert_eq!(coupling_gradient_standard([1, 0], [0, 0], maps)[1], [0.0; 2]);
    assert_eq!(coupling_gradient_standard([1, 0], [0, 0], maps)[0], coupling_gradient_1d(1, 0, maps[0]));
    assert_ne!(coupling_gradient_1d(1, 0, maps[0]), [0.0; 2]);
}

/// The largest count of non-zeros over maps of scale near 1, as the thesis draws them.
fn largest_count(size: usize) -> usize {
    let nonzeros = TripleNonzeros1d::new(size).unwrap();
    let at = |n: usize| map(0.9 + 0.2 * (n as f64 * 0.618).fract(), -0.1 + 0.2 * (n as f64 * 0.414).fract());
    (0..20).map(|n| nonzeros.ordered_count(at(n))).max().unwrap()
}

#[test]
fn counts_grow_as_n_log_n() {
    // Θ(N log N): the count over N grows by a constant from one size to the next, so its second differences fade.
    let sizes = [64, 128, 256, 512, 1024, 2048];
    let per_function: Vec<f64> = sizes.map(|size| largest_count(size) as f64 / size as f64).to_vec();
    let growth: Vec<f64> = per_function.windows(2).map(|w| w[1] - w[0]).collect();
    let (first, last) = (growth[0], *growth.last().unwrap());
    assert!((last / first - 1.0).abs() < 0.1, "{per_function:?}");
}
