//! Affine couplings one by one, and the visit of those that are not zero: against golden values, the twin and exact
//! counts.

use std::collections::BTreeMap;

use crate::support::{HAAR_AFFINE, assert_close, golden, half_power, map, number};
use haarmonic::affine::{
    AffineMap, Atom, Mother, Nonzeros1d, NonzerosNonstandard, Operator1d, canonical, coupling, coupling_1d,
    coupling_gradient_1d, coupling_nonstandard, coupling_standard,
};
use haarmonic::reference::affine as naive;
use haarmonic::strategies::{affine_map, dyadic_map};
use proptest::prelude::*;
use serde_json::Value;

fn map_of(case: &Value) -> AffineMap {
    map(number(&case["s"]), number(&case["o"]))
}

/// Whether the file's s and o are exact as `f64`.
fn is_dyadic(case: &Value) -> bool {
    ["s", "o"].iter().all(|k| match case[k].as_str().unwrap().split_once('/') {
        Some((_, q)) => q.parse::<u64>().unwrap().is_power_of_two(),
        None => true,
    })
}

type Entries = BTreeMap<(usize, usize), f64>;

fn all(size: usize, m: AffineMap) -> Entries {
    let mut entries = Entries::new();
    Nonzeros1d::new(size).unwrap().all(m, |i, j, d| {
        assert!(entries.insert((i, j), d).is_none(), "({i}, {j}) is visited twice for {m:?}");
    });
    entries
}

#[test]
fn golden_couplings_are_visited_and_nothing_else() {
    for name in ["acc_n8", "acc_n16"] {
        let file = golden(HAAR_AFFINE, name);
        let size = file["N"].as_u64().unwrap() as usize;
        for case in file["cases"].as_array().unwrap() {
            let (m, got) = (map_of(case), all(size, map_of(case)));
            let list = case["nonzero"].as_array().unwrap();
            let want: Entries = list
                .iter()
                .map(|e| ((e[0].as_u64().unwrap() as usize, e[1].as_u64().unwrap() as usize), half_power(&e[2], &e[3])))
                .collect();
            for (&(i, j), &want) in &want {
                let got = got.get(&(i, j)).copied().unwrap_or(0.0);
                assert_close(got, want, 1e-14, &format!("{name}, {m:?}, ({i}, {j})"));
                assert_close(coupling_1d(i, j, m), want, 1e-14, &format!("{name}, {m:?}, ({i}, {j})"));
            }
            // A third or a fifth is rounded in an `f64`, and what cancels for the one need not for the other.
            if is_dyadic(case) {
                assert!(got.keys().eq(want.keys()), "{name}, {m:?}");
            }
            let single = Operator1d::<f32>::new(size, m).unwrap();
            for i in 0..size {
                let (index, value) = single.row(i);
                for (&j, &d) in index.iter().zip(value) {
                    assert_close(f64::from(d), want.get(&(i, j as usize)).copied().unwrap_or(0.0), 1e-6, "f32");
                }
            }
        }
    }
}

#[test]
fn golden_gradients() {
    let file = golden(HAAR_AFFINE, "acc_grad_n16");
    let rows = file["rows"].as_array().unwrap();
    assert!(rows.len() > 20);
    for e in rows {
        let index = |k: usize| e[k].as_u64().unwrap() as usize;
        let (i, j, m) = (index(0), index(1), map(number(&e[2]), number(&e[3])));
        let [d, ds, d_o] = [4, 6, 8].map(|k| half_power(&e[k], &e[k + 1]));
        let what = format!("({i}, {j}), {m:?}");
        assert_close(coupling_1d(i, j, m), d, 1e-14, &what);
        let got = coupling_gradient_1d(i, j, m);
        assert_close(got[0], ds, 1e-14 * (1.0 + ds.abs()), &format!("dD/ds of {what}"));
        assert_close(got[1], d_o, 1e-14 * (1.0 + d_o.abs()), &format!("dD/do of {what}"));
    }
}

/// Maps between 1/8 and 8 of ordinary mantissa that show some of the source.
fn ordinary() -> impl Strategy<Value = AffineMap> {
    (-3.0..3.0f64, any::<bool>(), -1.2..1.2f64).prop_map(|(log, mirrored, o)| {
        let s = log.exp2();
        if mirrored { map(-s, 0.5 + 0.5 * s + o) } else { map(s, 0.5 - 0.5 * s + o) }
    })
}

proptest! {
    #[test]
    fn as_many_are_visited_as_are_not_zero(
        m in prop_oneof![ordinary(), dyadic_map(), (1i32..9, -20i32..20).prop_map(|(s, o)| map(f64::from(s), f64::from(o) / 3.0))],
        log in 0u32..6,
    ) {
        let size = 1 << log;
        let (got, mut below_rounding) = (all(size, m), 0);
        for i in 0..size {
            for j in 0..size {
                let sign = naive::coupling_sign_1d(i, j, m);
                if !got.contains_key(&(i, j)) && sign != 0 {
                    // Cancels but for the last bit of o: not zero, and yet it rounds to 0.
                    prop_assert!(naive::coupling_1d(i, j, m).abs() < 1e-14, "({}, {}), {:?} is left out", i, j, m);
                    below_rounding += 1;
                    continue;
                }
                let d = got.get(&(i, j)).copied().unwrap_or(0.0);
                prop_assert_eq!(sign, if d > 0.0 { 1 } else if d < 0.0 { -1 } else { 0 }, "({}, {}), {:?}: {:e}", i, j, m, d);
            }
        }
        prop_assert!(below_rounding <= 2, "{:?}", m);
        prop_assert_eq!(Nonzeros1d::new(size).unwrap().count(m) + below_rounding, naive::count_nonzeros_1d(size, m));
        prop_assert_eq!(Operator1d::<f64>::new(size, m).unwrap().nnz(), got.len());
    }

    #[test]
    fn rows_columns_and_operators_agree_with_the_twin(m in affine_map(), log in 0u32..6) {
        let size = 1 << log;
        let (rows, nonzeros) = (all(size, m), Nonzeros1d::new(size).unwrap());
        let operator = Operator1d::<f64>::new(size, m).unwrap();
        // Breakpoints are rounded by ε (1 + |o/s|), and a coupling is the amplitudes times that.
        let epsilon = 4.0 * f64::EPSILON * (1.0 + (m.offset() / m.scale()).abs().min(1e3));
        for i in 0..size {
            let row: Entries = { let (j, d) = operator.row(i); j.iter().zip(d).map(|(&j, &d)| ((i, j as usize), d)).collect() };
            for j in 0..size {
                let want = naive::coupling_1d(i, j, m);
                let got = rows.get(&(i, j)).copied().unwrap_or(0.0);
                let amplitudes = ((i.max(1) * j.max(1)) as f64).sqrt();
                prop_assert!((got - want).abs() <= epsilon * amplitudes, "({i}, {j}) of {m:?}: {got:e} {want:e}");
                prop_assert!((row.get(&(i, j)).copied().unwrap_or(0.0) - want).abs() <= epsilon * amplitudes);
                prop_assert!((coupling_1d(i, j, m) - want).abs() <= epsilon * amplitudes);
            }
        }
        for j in 0..size {
            let mut last = None;
            nonzeros.column(j, m, |i, d| {
                assert!(last < Some(i), "column {j} of {m:?} does not ascend");
                last = Some(i);
                let amplitudes = ((i.max(1) * j.max(1)) as f64).sqrt();
                assert_close(d, naive::coupling_1d(i, j, m), epsilon * amplitudes, &format!("column {j}, row {i}, {m:?}"));
            });
        }
    }

    #[test]
    fn rows_and_columns_visit_the_same(m in ordinary(), log in 0u32..7) {
        let (size, nonzeros) = (1 << log, Nonzeros1d::new(1 << log).unwrap());
        let mut columns = Vec::new();
        (0..size).for_each(|j| nonzeros.column(j, m, |i, _| columns.push((i, j))));
        columns.sort_unstable();
        prop_assert!(all(size, m).into_keys().eq(columns), "{:?}", m);
    }

    #[test]
    fn exchanged_roles(i in 0usize..64, j in 0usize..64, m in ordinary()) {
        // [Sun 2008, eq. 4.13] with |s|.
        let want = coupling_1d(j, i, m.inverse()) / m.scale().abs();
        prop_assert!((coupling_1d(i, j, m) - want).abs() <= 1e-13, "({i}, {j}), {m:?}");
    }

    #[test]
    fn gradients_are_one_sided(i in 0usize..32, j in 0usize..32, m in prop_oneof![ordinary(), dyadic_map()]) {
        let gradient = coupling_gradient_1d(i, j, m);
        for (k, along) in [[1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
            let step = 1e-7 * m.scale().abs();
            let want = naive::coupling_slope_1d(i, j, m, along, step);
            // Differences of the twin: ε/step, and curvature 1/s³ of the map's inverse.
            let scale = 32.0 * (1.0 + m.scale().abs().recip()).powi(2);
            prop_assert!((gradient[k] - want).abs() <= 1e-7 * scale, "({i}, {j}), {m:?}, {k}: {} {want}", gradient[k]);
        }
    }

    #[test]
    fn nonstandard_rows_are_the_products_that_are_not_zero(x in prop_oneof![ordinary(), dyadic_map()], y in prop_oneof![ordinary(), dyadic_map()], log in 0u32..4) {
        let (side, maps) = (1usize << log, [x, y]);
        let nonzeros = NonzerosNonstandard::new(side).unwrap();
        let mut rows = Entries::new();
        nonzeros.all(maps, |i, j, d| assert!(rows.insert((i, j), d).is_none()));
        let mut columns = Entries::new();
        (0..side * side).for_each(|j| nonzeros.column(j, maps, |i, d| assert!(columns.insert((i, j), d).is_none())));
        prop_assert!(rows.keys().eq(columns.keys()), "{:?}", maps);
        for i in 0..side * side {
            for j in 0..side * side {
                let d = rows.get(&(i, j)).copied();
                prop_assert_eq!(naive::coupling_sign_nonstandard(i, j, maps) != 0, d.is_some(), "({}, {}), {:?}", i, j, maps);
                if let Some(d) = d {
                    let want = naive::coupling_nonstandard(i, j, maps);
                    prop_assert!((d - want).abs() <= 1e-13 && (coupling_nonstandard(i, j, maps) - want).abs() <= 1e-13, "({i}, {j}), {maps:?}");
                    prop_assert!((columns[&(i, j)] - want).abs() <= 1e-13);
                }
            }
        }
        prop_assert_eq!(nonzeros.count(maps), rows.len());
    }

    #[test]
    fn standard_couplings_are_products(i in [0usize..32, 0..32, 0..32], j in [0usize..32, 0..32, 0..32], m in [ordinary(), ordinary(), ordinary()]) {
        let want = naive::coupling_standard(&i, &j, &m);
        prop_assert!((coupling_standard(i, j, m) - want).abs() <= 1e-13);
    }

    #[test]
    fn atoms_of_any_level_follow_the_canonical_coupling(
        [li, lj] in [0u32..20, 0..20], [ti, tj] in [0.0..1.0f64, 0.0..1.0], m in ordinary(), f in 0usize..2, g in 0usize..2,
    ) {
        let atom = |mother, level: u32, t: f64| Atom { mother, level, offset: (t * f64::from(1u32 << level)) as usize };
        let (source, target) = (atom(Mother::ALL[f], li, ti), atom(Mother::ALL[g], lj, tj));
        // [Sun 2008, eq. 4.23] as corrected: 2^{l_j} o.
        let (p, s) = ((f64::from(lj) - f64::from(li)).exp2(), m.scale());
        let r = p / 2.0 / s;
        let c = (p * source.offset as f64 - f64::from(lj).exp2() * m.offset() + p / 2.0) / s - target.offset as f64;
        let want = p.sqrt().recip() * canonical(source.mother, target.mother, r, c);
        let scale = ((li + lj) as f64 / 2.0).exp2();
        prop_assert!((coupling(source, target, m) - want).abs() <= 1e-13 * scale, "{source:?} {target:?} {m:?}");
    }
}

#[test]
fn a_small_scale_leaves_the_value_at_a_point() {
    // s → 0: D_ij = Φ_i(o) δ_{j, DC}.
    for s in [1e-12, -1e-12, 1e-50] {
        let got = all(8, map(s, 0.3));
        let want = [1.0, 1.0, -(2f64.sqrt()), 0.0, 0.0, 2.0, 0.0, 0.0];
        for (i, want) in want.into_iter().enumerate() {
            assert_close(got.get(&(i, 0)).copied().unwrap_or(0.0), want, 1e-14, &format!("row {i}, s = {s:e}"));
        }
        assert!(got.keys().all(|&(_, j)| j == 0), "{s:e}: {got:?}");
    }
}

#[test]
fn a_tiny_scale_loses_no_column() {
    let mut column = Vec::new();
    Nonzeros1d::new(2).unwrap().column(0, map(1e-20, 0.25), |i, d| column.push((i, d)));
    assert_eq!(column, [(0, 1.0), (1, 1.0)]);
}

#[test]
fn two_dimensions_cost_less_in_the_nonstandard_basis() {
    let (x, y) = (map(1.0037, -0.0021), map(1.0037, 0.0013));
    for (side, [standard, nonstandard]) in [(32usize, [40_596, 26_311]), (64, [194_038, 113_374])] {
        let one = |m| Nonzeros1d::new(side).unwrap().count(m);
        let (product, two) = (one(x) * one(y), NonzerosNonstandard::new(side).unwrap().count([x, y]));
        assert!(
            product.abs_diff(standard) < standard / 30 && two.abs_diff(nonstandard) < nonstandard / 30,
            "{side}: {product} {two}"
        );
    }
}
