//! Couplings, triplings and their derivatives at every scale that a map can have, against values without rounding.

use std::collections::BTreeMap;

use crate::support::map;
use haarmonic::affine::{
    AffineMap, Axis, Nonzeros1d, NonzerosNonstandard, Operator1d, Parameter, Propagation, PropagationRoute,
    PropagationScratch, PropagationSource, Targets, TripleNonzeros1d, coupling_1d, coupling_gradient_1d,
    coupling_nonstandard, coupling_standard, tripling_1d, tripling_gradient_1d, tripling_nonstandard,
};
use haarmonic::haar::{Decomposition, forward_2d, inverse_2d};
use haarmonic::reference::affine as naive;
use proptest::prelude::*;

/// Within so many ε of the value itself; 0 only where the value is 0.
#[track_caller]
fn assert_relative(got: f64, want: f64, epsilons: f64, what: &str) {
    let close = (got - want).abs() <= epsilons * f64::EPSILON * want.abs() && (got == 0.0) == (want == 0.0);
    assert!(close, "{what}: got {got:e}, want {want:e}, off by {:.1} ε", (got / want - 1.0) / f64::EPSILON);
}

/// 0 … 1, half of the time a multiple of 1/64.
fn share() -> impl Strategy<Value = f64> {
    prop_oneof![0.0..1.0f64, (0..=64).prop_map(|k| f64::from(k) / 64.0)]
}

/// Log-uniform scales of both signs, some of few binary places; offsets that bring a point of the source to one of the
/// target, or miss it by a few roundings.
fn any_scale() -> impl Strategy<Value = AffineMap> {
    let log = prop_oneof![
        3 => -332.0..332.0f64,
        3 => -60.0..60.0f64,
        2 => (-60i32..60).prop_map(f64::from),
        1 => -4.0..4.0f64,
    ];
    (log, any::<bool>(), share(), share(), -3i64..=3).prop_map(|(log, mirrored, x, v, nudge)| {
        let s = if mirrored { -log.exp2() } else { log.exp2() };
        let o = x - s * v;
        let nudged = if o == 0.0 { o } else { f64::from_bits(o.to_bits().wrapping_add_signed(nudge)) };
        map(s, nudged.clamp(-1e100, 1e100))
    })
}

fn index() -> impl Strategy<Value = usize> {
    prop_oneof![4 => 0usize..64, 1 => 0usize..2048]
}

fn exact_column(size: usize, j: usize, m: AffineMap) -> BTreeMap<usize, f64> {
    (0..size).map(|i| (i, naive::exact_coupling_1d(i, j, m))).filter(|(_, d)| *d != 0.0).collect()
}

proptest! {
    #[test]
    fn couplings_are_right_to_a_few_roundings_of_themselves(i in index(), j in index(), m in any_scale()) {
        // Half an ε each of an overlap's three roundings, the amplitude, the sum and the quotient; worst seen of
        // 400,000: 1.6 ε.
        assert_relative(coupling_1d(i, j, m), naive::exact_coupling_1d(i, j, m), 3.0, &format!("({i}, {j}), {m:?}"));
    }

    #[test]
    fn triplings_too([i, j, k] in [index(), index(), index()], m in any_scale()) {
        for k in [k, j, j / 2, 2 * j] {
            let what = format!("({i}, {j}, {k}), {m:?}");
            // And a product with a power of √2; worst seen: 2.7 ε.
            assert_relative(tripling_1d(i, j, k, m), naive::exact_tripling_1d(i, j, k, m), 5.0, &what);
        }
    }

    #[test]
    fn gradients_too(i in index(), j in index(), m in any_scale()) {
        let (got, want) = (coupling_gradient_1d(i, j, m), naive::exact_coupling_gradient_1d(i, j, m));
        for k in 0..2 {
            assert_relative(got[k], want[k], 4.0, &format!("derivative {k} of ({i}, {j}), {m:?}"));
        }
        // ψ_j² is 2^l φ there: of φ itself for the coarsest.
        let squared = tripling_gradient_1d(i, 1, 1, m);
        let mean = naive::exact_coupling_gradient_1d(i, 0, m);
        (0..2).for_each(|k| assert_relative(squared[k], mean[k], 4.0, &format!("({i}, 1, 1), {m:?}")));
    }

    #[test]
    fn two_dimensions_too(i in index(), j in index(), x in any_scale(), y in any_scale()) {
        let what = format!("({i}, {j}), {x:?} {y:?}");
        let want = naive::exact_coupling_nonstandard(i, j, [x, y]);
        // Twice the error of an axis; worst seen: 3.9 ε.
        assert_relative(coupling_nonstandard(i, j, [x, y]), want, 8.0, &what);
        let want = naive::exact_coupling_1d(i, j, x) * naive::exact_coupling_1d(j, i, y);
        assert_relative(coupling_standard([i, j], [j, i], [x, y]), want, 8.0, &what);
        // ψ times the mean is ψ.
        assert_eq!(tripling_nonstandard(i, 0, j, [x, y]), coupling_nonstandard(i, j, [x, y]), "{}", what);
    }

    #[test]
    fn columns_visit_what_is_not_zero_and_nothing_else(j in 0usize..64, k in 0usize..64, m in any_scale()) {
        let size = 64;
        let (want, mut got) = (exact_column(size, j, m), BTreeMap::new());
        Nonzeros1d::new(size).unwrap().column(j, m, |i, d| assert!(got.insert(i, d).is_none()));
        prop_assert!(got.keys().eq(want.keys()), "column {}, {:?}: {:?}, want {:?}", j, m, got, want);
        got.iter().for_each(|(i, &d)| assert_relative(d, want[i], 3.0, &format!("({i}, {j}), {m:?}")));

        let mut got = BTreeMap::new();
        TripleNonzeros1d::new(size).unwrap().column(j, k, m, |i, d| assert!(got.insert(i, d).is_none()));
        for i in 0..size {
            let want = naive::exact_tripling_1d(i, j, k, m);
            assert_relative(got.get(&i).copied().unwrap_or(0.0), want, 5.0, &format!("({i}, {j}, {k}), {m:?}"));
        }
    }

    #[test]
    fn columns_of_two_dimensions_too(j in 0usize..64, x in any_scale(), y in any_scale()) {
        let mut got = BTreeMap::new();
        NonzerosNonstandard::new(8).unwrap().column(j, [x, y], |i, d| assert!(got.insert(i, d).is_none()));
        for i in 0..64 {
            let want = naive::exact_coupling_nonstandard(i, j, [x, y]);
            assert_relative(got.get(&i).copied().unwrap_or(0.0), want, 8.0, &format!("({i}, {j}), {x:?} {y:?}"));
        }
    }

    #[test]
    fn rows_are_right_to_a_rounding_of_the_amplitudes(i in 0usize..64, m in any_scale()) {
        let mut got = BTreeMap::new();
        Nonzeros1d::new(64).unwrap().row(i, m, |j, d| assert!(got.insert(j, d).is_none()));
        let operator = Operator1d::<f64>::new(64, m).unwrap();
        let (targets, values) = operator.row(i);
        prop_assert!(got.iter().map(|(&j, &d)| (j as u32, d)).eq(targets.iter().copied().zip(values.iter().copied())));
        for j in 0..64 {
            let want = naive::exact_coupling_1d(i, j, m);
            let amplitudes = ((i.max(1).ilog2() + j.max(1).ilog2()) as f64 / 2.0).exp2();
            let d = got.get(&j).copied().unwrap_or(0.0);
            // Three breakpoints in [0, 1], weights up to 2, two roundings each; worst seen: 1.5 ε.
            prop_assert!((d - want).abs() <= 4.0 * f64::EPSILON * amplitudes, "({i}, {j}), {m:?}: {d:e} {want:e}");
            prop_assert!(d * want >= 0.0 && (d == 0.0 || want != 0.0), "({i}, {j}), {m:?}: {d:e} {want:e}");
        }
    }

    #[test]
    fn every_route_carries_light_through_any_scale(x in any_scale(), y in any_scale()) {
        let (side, maps) = (8, [x, y]);
        let image: Vec<f64> = (0..64).map(|k| f64::from((k * 37 + 11) % 64) / 64.0 + 0.25).collect();
        let seen = seen_exactly(side, &image, maps);
        for basis in [Decomposition::Standard, Decomposition::Nonstandard] {
            let light = forward_2d(&image, side, side, basis).unwrap();
            let source = PropagationSource::from_dense(side, basis, [&light]).unwrap();
            let (plan, all) = (Propagation::<f64>::new(side, basis).unwrap(), Targets::all(side, basis).unwrap());
            for route in PropagationRoute::ALL {
                let mut out = vec![f64::NAN; 64];
                plan.apply_by(route, &source, maps, &all, [&mut out], &mut PropagationScratch::new());
                let got = inverse_2d(&out, side, side, basis).unwrap();
                // An end of a pixel is rounded by ε of its place, up to 8 pixels; worst seen: 7 ε. A table's
                // differences lose 1/(s_x s_y) besides, of corners that are sums of all pixels; worst seen: 86 ε of
                // that.
                let area = (x.scale() * y.scale()).abs();
                let looked_up = route == PropagationRoute::Lookups && area >= 2f64.powi(-20);
                let tolerance = f64::EPSILON * if looked_up { 256.0 * (1.0 + area.recip()) } else { 24.0 };
                for k in 0..64 {
                    let off = (got[k] - seen[k]).abs();
                    prop_assert!(off <= tolerance, "{route:?}, {basis:?}, pixel {k}, {maps:?}: {:e} {:e}", got[k], seen[k]);
                }
            }
        }
    }

    #[test]
    fn so_do_derivatives_and_the_adjoint(x in any_scale(), y in any_scale(), at in 0usize..64) {
        let (side, maps, basis) = (8, [x, y], Decomposition::Standard);
        let image: Vec<f64> = (0..64).map(|k| f64::from((k * 37 + 11) % 64) / 64.0 + 0.25).collect();
        let light = forward_2d(&image, side, side, basis).unwrap();
        let source = PropagationSource::from_dense(side, basis, [&light]).unwrap();
        let (plan, all) = (Propagation::<f64>::new(side, basis).unwrap(), Targets::all(side, basis).unwrap());
        let mut scratch = PropagationScratch::new();
        for (a, axis) in [Axis::X, Axis::Y].into_iter().enumerate() {
            for parameter in Parameter::ALL {
                let mut out = vec![f64::NAN; 64];
                plan.derivative((axis, parameter), &source, maps, &all, [&mut out], &mut scratch);
                let got = inverse_2d(&out, side, side, basis).unwrap();
                let slope = |q: usize, i, k| naive::exact_pixel_gradient(side, i, k, maps[q])[parameter as usize];
                let value = |q: usize, i, k| naive::exact_pixel_coupling(side, i, k, maps[q]);
                let weight = |q: usize, i, k| if q == a { slope(q, i, k) } else { value(q, i, k) };
                let want = combined(side, &image, &weight);
                // 8/|s| for each end of a pixel that moves through a cell; worst seen: 8 ε of that.
                let scale = 8.0 / maps[a].scale().abs();
                for k in 0..64 {
                    let off = (got[k] - want[k]).abs();
                    prop_assert!(off <= 32.0 * f64::EPSILON * scale, "{axis:?}, {parameter:?}, pixel {k}, {maps:?}: {:e} {:e}", got[k], want[k]);
                }
            }
        }
        // The adjoint of one pixel of the target: what each source pixel sends there.
        let mut one = vec![0.0; 64];
        one[at] = 1.0;
        let (cotangent, mut out) = (forward_2d(&one, side, side, basis).unwrap(), vec![f64::NAN; 64]);
        plan.adjoint(maps, &cotangent, &mut out, &mut scratch);
        let got = inverse_2d(&out, side, side, basis).unwrap();
        for (i, got) in got.into_iter().enumerate() {
            let [wx, wy] = [(i % 8, at % 8, x), (i / 8, at / 8, y)].map(|(i, k, m)| naive::exact_pixel_coupling(side, i, k, m));
            prop_assert!((got - wx * wy).abs() <= 32.0 * f64::EPSILON, "pixel {i} to {at}, {maps:?}: {got:e} {:e}", wx * wy);
        }
    }

    #[test]
    fn the_inverse_is_a_map_again(m in any_scale(), far in any::<bool>()) {
        let m = if far { map(m.scale(), 1e100 * m.scale().signum()) } else { m };
        let inverse = m.inverse();
        prop_assert!(AffineMap::new(inverse.scale(), inverse.offset()).is_ok(), "{:?}", inverse);
        assert_relative(inverse.scale(), m.scale().recip(), 4.0, "scale");
        if inverse.offset().abs() < 1e100 {
            prop_assert_eq!(inverse.offset(), -m.offset() / m.scale());
        } else {
            prop_assert!((0..8).all(|i| coupling_1d(i, 0, m) == 0.0 && coupling_1d(i, 0, inverse) == 0.0));
        }
    }
}

/// Σ_ij weight(0, i, x) weight(1, j, y) F(i, j) of all pixels (x, y).
fn combined(side: usize, image: &[f64], weight: &impl Fn(usize, usize, usize) -> f64) -> Vec<f64> {
    let table =
        [0, 1].map(|q| (0..side).map(|k| (0..side).map(|i| weight(q, i, k)).collect::<Vec<_>>()).collect::<Vec<_>>());
    let at = |x: usize, y: usize| -> f64 {
        let row = |j: usize| -> f64 { (0..side).map(|i| table[0][x][i] * image[j * side + i]).sum() };
        (0..side).filter(|&j| table[1][y][j] != 0.0).map(|j| table[1][y][j] * row(j)).sum()
    };
    (0..side * side).map(|k| at(k % side, k / side)).collect()
}

fn seen_exactly(side: usize, image: &[f64], maps: [AffineMap; 2]) -> Vec<f64> {
    combined(side, image, &|q, i, k| naive::exact_pixel_coupling(side, i, k, maps[q]))
}

#[test]
fn half_of_a_border_is_seen_at_a_tiny_scale() {
    // s v + o = 0 in the middle of the target.
    let m = map(2f64.powi(-60), -2f64.powi(-61));
    assert_eq!((coupling_1d(0, 0, m), tripling_1d(0, 0, 0, m)), (0.5, 0.5));
    let mut column = Vec::new();
    Nonzeros1d::new(4).unwrap().column(0, m, |i, d| column.push((i, d)));
    assert_eq!(column, [(0, 0.5), (1, 0.5), (2, 2f64.sqrt() / 2.0)]);
}

#[test]
fn a_point_of_a_large_source_is_seen_at_its_size() {
    // The image of the target is 2^60 times the source, which begins in its middle.
    let m = map(2f64.powi(60), -2f64.powi(59));
    assert_eq!((coupling_1d(0, 0, m), coupling_1d(0, 1, m)), (2f64.powi(-60), -2f64.powi(-60)));
}

#[test]
fn as_many_couplings_one_by_one_as_are_not_zero() {
    let size = 128;
    let pairs = [
        (1.0, 0.0),
        (0.9, 0.05),
        (1.1, -0.05),
        (3.0, -1.0),
        (-3.0, 2.0),
        (0.7, 0.15),
        (-0.3, 0.65),
        (1.0 / 3.0, 1.0 / 3.0),
    ];
    for (s, o) in pairs {
        let m = map(s, o);
        let got = (0..size * size).filter(|k| coupling_1d(k / size, k % size, m) != 0.0).count();
        assert_eq!(got, naive::count_nonzeros_1d(size, m), "{m:?}");
        let mut columns = 0;
        (0..size).for_each(|j| Nonzeros1d::new(size).unwrap().column(j, m, |_, _| columns += 1));
        assert_eq!(columns, got, "{m:?}");
    }
}

#[test]
fn the_cell_below_a_border_is_seen() {
    let (side, basis) = (8, Decomposition::Standard);
    let image: Vec<f64> = (0..64).map(|k| f64::from(k % 8)).collect();
    let light = forward_2d(&image, side, side, basis).unwrap();
    let source = PropagationSource::from_dense(side, basis, [&light]).unwrap();
    let (plan, all) = (Propagation::<f64>::new(side, basis).unwrap(), Targets::all(side, basis).unwrap());
    for route in PropagationRoute::ALL {
        for (s, o, want) in
            [(-1e-17, 0.5, 3.0), (1e-17, 0.5, 4.0), (-1e-17, 1.0, 7.0), (-1e-90, 0.125, 0.0), (-1e-9, 0.5, 3.0)]
        {
            let mut out = vec![f64::NAN; 64];
            plan.apply_by(
                route,
                &source,
                [map(s, o), AffineMap::IDENTITY],
                &all,
                [&mut out],
                &mut PropagationScratch::new(),
            );
            let got = inverse_2d(&out, side, side, basis).unwrap();
            let tolerance = if route == PropagationRoute::Lookups && s == -1e-9 { 1e-5 } else { 1e-14 };
            assert!(got.iter().all(|l| (l - want).abs() <= tolerance), "{route:?}, {s:e}, {o}: {got:?}");
        }
    }
}
