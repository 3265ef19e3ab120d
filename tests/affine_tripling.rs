//! Affine tripling coefficients, products and light fields against golden values and naive twins.
#![cfg(all(feature = "reference", feature = "proptest"))]

use haarmonic::affine::{
    AffineMap, Atom, Mother, TripleNonzeros1d, TripleNonzerosNonstandard, canonical, coupling_1d, tripling,
    tripling_1d, tripling_gradient_1d, tripling_gradient_nonstandard, tripling_nonstandard, tripling_standard,
};
use haarmonic::haar::{self, Index1d};
use haarmonic::reference::affine as naive;
use haarmonic::strategies;
use proptest::prelude::*;
use serde_json::Value;

const EPS: f64 = f64::EPSILON;

fn golden(name: &str) -> Value {
    let path = format!("{}/tests/golden/haar_affine_tables/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn rational(v: &Value) -> f64 {
    let (p, q) = v.as_str().unwrap().split_once('/').unwrap();
    p.parse::<f64>().unwrap() / q.parse::<f64>().unwrap()
}

fn map(scale: f64, offset: f64) -> AffineMap {
    AffineMap::new(scale, offset).unwrap()
}

fn golden_map(case: &Value) -> AffineMap {
    map(rational(&case["s"]), rational(&case["o"]))
}

/// Property cases: 48, or as many as `PROPTEST_CASES` says.
fn cases() -> ProptestConfig {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(48);
    ProptestConfig::with_cases(cases)
}

#[track_caller]
fn assert_close(got: f64, want: f64, tolerance: f64, what: &str) {
    assert!((got - want).abs() <= tolerance, "{what}: got {got:e}, want {want:e}, off by {:e}", (got - want).abs());
}

/// Some maps of every sort: identity, mirrored, zooming in and out, partly and wholly outside, with coinciding breakpoints.
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

/// The largest value that |D_ijk| can have, a scale for its errors: ∫ |f g h| ≤ the amplitudes, over the finest support.
fn scale([i, j, k]: [usize; 3]) -> f64 {
    [i, j, k].iter().map(|&flat| 2f64.powf(f64::from(Atom::from_flat(flat).level) / 2.0)).product()
}

#[test]
fn golden_triplings() {
    let file = golden("atc_n8");
    let size = file["N"].as_u64().unwrap() as usize;
    let nonzeros = TripleNonzeros1d::new(size).unwrap();
    for case in file["cases"].as_array().unwrap() {
        let map = golden_map(case);
        let mut want = std::collections::BTreeMap::new();
        for e in case["nonzero"].as_array().unwrap() {
            let [i, j, k] = [0, 1, 2].map(|n| e[n].as_u64().unwrap() as usize);
            want.insert([i, j, k], rational(&e[3]) * 2f64.powf(e[4].as_f64().unwrap() / 2.0));
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
        let tolerance = 8.0 * EPS * scale([i, j, k]) * condition(map);
        for other in [by_column, by_partners] {
            assert_close(other, d, tolerance, &format!("{i} {j} {k} {map:?}"));
            assert_eq!(other == 0.0, d == 0.0, "{i} {j} {k} {map:?}: {other:e} {d:e}");
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
