//! Whole signals through affine maps: every route against golden values, the naive twin and each other.

use crate::support::{HAAR_AFFINE, assert_all_close, golden, largest, map, number, numbers, random, wide};
use haarmonic::Real;
use haarmonic::affine::{
    AffineMap, Axis, Operator1d, Parameter, Propagation, PropagationRoute, PropagationScratch, PropagationSource,
    Targets, apply_map_1d,
};
use haarmonic::haar::{Decomposition, SparseVector, forward_1d, forward_2d, inverse_1d, inverse_2d};
use haarmonic::reference::affine as naive;
use haarmonic::strategies::{affine_map, haar_signal, signal, sparse_vector};
use proptest::prelude::*;

const BASES: [Decomposition; 2] = [Decomposition::Standard, Decomposition::Nonstandard];

/// Maps that shrink, grow, mirror, move out, touch and miss.
fn maps() -> Vec<AffineMap> {
    let pairs = [
        (1.0, 0.0),
        (0.5, 0.25),
        (1.0, 0.125),
        (-1.0, 1.0),
        (0.7137, 0.1071),
        (1.9, -0.3),
        (-0.613, 0.87),
        (3.7, -1.2),
        (-2.3, 1.41),
        (0.031, 0.517),
        (40.0, -17.3),
        (1.0, 1.0),
        (1.0, -1.0),
        (1.5, -3.0),
        (1e-9, 0.5),
        (-1e-9, 0.5),
        (1e9, -4e8),
    ];
    pairs.map(|(s, o)| map(s, o)).to_vec()
}

fn run<T: Real, const C: usize>(
    route: PropagationRoute,
    side: usize,
    basis: Decomposition,
    channels: [&[T]; C],
    maps: [AffineMap; 2],
    targets: &Targets,
) -> [Vec<T>; C] {
    let source = PropagationSource::from_dense(side, basis, channels).unwrap();
    let plan = Propagation::new(side, basis).unwrap();
    let mut out: [Vec<T>; C] = std::array::from_fn(|_| vec![T::nan(); targets.len()]);
    let planes = out.each_mut().map(|plane| plane.as_mut_slice());
    plan.apply_by(route, &source, maps, targets, planes, &mut PropagationScratch::new());
    out
}

/// The tolerance of a route in ε of max |F|, for coefficients of modulus at most that.
///
/// Look-ups difference a table of rounding about ε over 1/(s_x s_y): their documented caveat.
fn tolerance(route: PropagationRoute, maps: [AffineMap; 2], epsilon: f64) -> f64 {
    let inverse = |m: AffineMap| m.scale().abs().recip().max(1.0);
    match route {
        PropagationRoute::Lookups => 32.0 * epsilon.max(f64::EPSILON * inverse(maps[0]) * inverse(maps[1]) * 8.0),
        _ => 32.0 * epsilon,
    }
}

#[test]
fn one_axis_equals_the_twin() {
    for size in [1usize, 2, 4, 8, 32, 128] {
        let samples = random(size, size as u64);
        let coefs = forward_1d(&samples).unwrap();
        for m in maps() {
            let got = inverse_1d(&apply_map_1d(&coefs, m).unwrap()).unwrap();
            // A breakpoint is rounded by ε/2, which is N ε/2 of a cell; worst seen: 65 ε at N = 128.
            let tolerance = 8.0 + size as f64;
            let want = naive::resample_1d(&samples, m);
            assert_all_close(&got, &want, tolerance * f64::EPSILON, &format!("{size}, {m:?}"));
            let single: Vec<f32> = coefs.iter().map(|&c| c as f32).collect();
            let got = inverse_1d(&apply_map_1d(&single, m).unwrap()).unwrap();
            // Here the breakpoints are as good as exact; sums and couplings are rounded.
            assert_all_close(&wide(&got), &want, 16.0 * f64::from(f32::EPSILON), &format!("f32, {size}, {m:?}"));
        }
    }
}

#[test]
fn one_axis_sparse_is_dense_and_the_adjoint_is_the_transpose() {
    for size in [1usize, 2, 16, 64] {
        for m in maps() {
            let operator = Operator1d::<f64>::new(size, m).unwrap();
            let (f, g) = (random(size, 3), random(size, 5));
            let sparse =
                SparseVector::from_pairs(size, f.iter().copied().enumerate().filter(|(i, _)| i % 3 != 1)).unwrap();
            let (mut l, mut dense, mut back) = (vec![0.0; size], vec![f64::NAN; size], vec![f64::NAN; size]);
            operator.apply_sparse(&sparse, &mut l);
            operator.apply(&sparse.to_dense(), &mut dense);
            assert_eq!(l, dense);
            operator.apply(&f, &mut l);
            operator.apply_adjoint(&g, &mut back);
            let (a, b): (f64, f64) =
                (l.iter().zip(&g).map(|(l, g)| l * g).sum(), f.iter().zip(&back).map(|(f, b)| f * b).sum());
            assert!((a - b).abs() <= 1e-14 * size as f64 * (1.0 + a.abs()), "{size}, {m:?}: {a:e} {b:e}");
        }
    }
}

#[test]
fn derivative_of_one_axis_is_the_slope_of_the_twin() {
    let size = 16;
    for m in [map(0.7137, 0.1071), map(-0.613, 0.87), map(1.0, 0.0), map(0.5, 0.25), map(-1.0, 1.0), map(2.0, -0.5)] {
        for parameter in Parameter::ALL {
            let mut operator = Operator1d::<f64>::new(size, m).unwrap();
            operator.set_derivative(m, parameter);
            let along = if parameter == Parameter::Scale { [1.0, 0.0] } else { [0.0, 1.0] };
            for i in 0..size {
                let mut row = vec![0.0; size];
                let (indices, values) = operator.row(i);
                assert!(indices.is_sorted_by(|a, b| a < b), "row {i} of {m:?}: {indices:?}");
                indices.iter().zip(values).for_each(|(&j, &d)| row[j as usize] = d);
                let want: Vec<f64> = (0..size).map(|j| naive::coupling_slope_1d(i, j, m, along, 1e-5)).collect();
                // The differences are right to about 1e-9.
                assert_all_close(&row, &want, 2e-8, &format!("{parameter:?}, row {i}, {m:?}"));
            }
        }
    }
}

#[test]
fn golden_propagation_by_every_route() {
    let file = golden(HAAR_AFFINE, "propagate_2d");
    let side = file["N"].as_u64().unwrap() as usize;
    let cases = file["cases"].as_array().unwrap();
    assert!(cases.len() >= 2);
    for case in cases {
        let axis = |s: &str, o: &str| map(number(&case[s]), number(&case[o]));
        let maps = [axis("sx", "ox"), axis("sy", "oy")];
        let (image, want) = (numbers(&case["image_rows_y"]), numbers(&case["target_pixel_averages"]));
        for basis in BASES {
            let light = forward_2d(&image, side, side, basis).unwrap();
            let all = Targets::all(side, basis).unwrap();
            for route in PropagationRoute::ALL {
                let [got] = run(route, side, basis, [&light], maps, &all);
                let got = inverse_2d(&got, side, side, basis).unwrap();
                // The table differences sums of the whole image.
                let tolerance = if route == PropagationRoute::Lookups { 4e-14 } else { 1e-14 } * largest(&image);
                assert_all_close(&got, &want, tolerance, &format!("{route:?}, {basis:?}"));
                let single: Vec<f32> = light.iter().map(|&c| c as f32).collect();
                let [got] = run(route, side, basis, [&single], maps, &all);
                let got = inverse_2d(&wide(&got), side, side, basis).unwrap();
                assert_all_close(&got, &want, 1e-6 * largest(&image), &format!("f32, {route:?}, {basis:?}"));
            }
        }
    }
}

fn check_side<T: Real>(side: usize, x: AffineMap, y: AffineMap) {
    let epsilon = T::epsilon().widen();
    let images = [random(side * side, 11), random(side * side, 12)];
    for basis in BASES {
        let lights = images.each_ref().map(|image| {
            let image: Vec<T> = image.iter().map(|&x| T::of(x)).collect();
            forward_2d(&image, side, side, basis).unwrap()
        });
        let all = Targets::all(side, basis).unwrap();
        let some: Vec<u32> = (0..(side * side) as u32).filter(|k| k % 3 == 0 || k % 7 == 2).collect();
        let some_targets = Targets::new(side, basis, &some).unwrap();
        let want = images
            .each_ref()
            .map(|image| forward_2d(&naive::resample_2d(image, side, side, [x, y]), side, side, basis).unwrap());
        for route in PropagationRoute::ALL {
            let tolerance = tolerance(route, [x, y], epsilon);
            let channels = lights.each_ref().map(Vec::as_slice);
            let got = run(route, side, basis, channels, [x, y], &all);
            let chosen = run(route, side, basis, channels, [x, y], &some_targets);
            for c in 0..2 {
                let what = format!("{route:?}, {basis:?}, side {side}, channel {c}, {x:?} {y:?}");
                assert_all_close(&wide(&got[c]), &want[c], tolerance, &what);
                let want: Vec<f64> = some.iter().map(|&k| want[c][k as usize]).collect();
                assert_all_close(&wide(&chosen[c]), &want, tolerance, &format!("some of {what}"));
            }
        }
    }
}

#[test]
fn every_route_equals_the_twin() {
    for side in [1, 2, 4, 8, 16, 32, 64] {
        let maps = maps();
        let step = if side > 16 { 3 } else { 1 };
        for (k, &x) in maps.iter().enumerate().step_by(step) {
            let y = maps[(k * 5 + 3) % maps.len()];
            check_side::<f64>(side, x, y);
            check_side::<f32>(side, x, y);
        }
    }
}

#[test]
fn the_identity_changes_nothing_and_a_light_out_of_sight_is_black() {
    let (side, light) = (16, random(256, 9));
    for basis in BASES {
        let all = Targets::all(side, basis).unwrap();
        for route in PropagationRoute::ALL {
            let [same] = run(route, side, basis, [&light], [AffineMap::IDENTITY; 2], &all);
            assert_all_close(&same, &light, 32.0 * f64::EPSILON * 16.0, &format!("{route:?}, {basis:?}"));
            for away in [map(1.0, 1.0), map(0.5, -0.5), map(-2.0, 0.0), map(1.0, 1e30)] {
                let [black] = run(route, side, basis, [&light], [AffineMap::IDENTITY, away], &all);
                assert!(black.iter().all(|&l| l == 0.0), "{route:?}, {basis:?}, {away:?}");
            }
        }
    }
}

#[test]
fn composition_is_one_map_and_chaining_loses() {
    let (side, image) = (16, random(256, 21));
    let (first, second) = (map(0.5, 0.3), map(1.7, -0.2));
    let composed = second.then(first).unwrap();
    assert_eq!(composed.apply(0.25), first.apply(second.apply(0.25)));
    let through = |image: &[f64], m: AffineMap| naive::resample_2d(image, side, side, [m, m]);
    let (at_once, chained) = (through(&image, composed), through(&through(&image, first), second));
    let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let difference: Vec<f64> = at_once.iter().zip(&chained).map(|(a, b)| a - b).collect();
    // White noise through two projections: they do not commute with anything.
    assert!(norm(&difference) > 0.05 * norm(&at_once), "{}", norm(&difference) / norm(&at_once));
}

#[test]
fn energy_is_lost_as_the_resolution_demands() {
    // s = 2, N = 32: the light covers half of the view; its energy is at most half of what it was, and details are
    // lost.
    let (size, m) = (32, map(2.0, -0.5));
    let lost = |samples: &[f64]| {
        let mean = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64;
        let seen = inverse_1d(&apply_map_1d(&forward_1d(samples).unwrap(), m).unwrap()).unwrap();
        1.0 - 2.0 * mean(&seen) / mean(samples)
    };
    let step: Vec<f64> = (0..size).map(|k| if k < 13 { 1.0 } else { 0.0 }).collect();
    let smooth: Vec<f64> = (0..size).map(|k| 1.0 + (0.2 * k as f64).sin()).collect();
    let white = (0..200).map(|seed| lost(&random(size, seed + 1))).sum::<f64>() / 200.0;
    assert!((0.4..0.6).contains(&white), "white noise loses half: {white}");
    assert!((1e-4..0.01).contains(&lost(&smooth)), "{}", lost(&smooth));
    assert!((0.02..0.06).contains(&lost(&step)), "one pixel of thirteen is split: {}", lost(&step));
}

#[test]
fn derivatives_are_one_sided_differences() {
    let side = 8;
    let light = random(64, 31);
    let h = 1e-6;
    for basis in BASES {
        let source = PropagationSource::from_dense(side, basis, [&light]).unwrap();
        let (plan, all) = (Propagation::<f64>::new(side, basis).unwrap(), Targets::all(side, basis).unwrap());
        let mut scratch = PropagationScratch::new();
        let generic = [map(0.7137, 0.1071), map(-1.31, 0.87)];
        let kinks = [map(1.0, 0.0), map(-0.5, 0.75)];
        let far = [map(1.0, 1.0), map(1.0, -1.0)]; // touching: the right-hand derivative of one of them is not 0
        for maps in [generic, kinks, far] {
            for (a, axis) in [Axis::X, Axis::Y].into_iter().enumerate() {
                for parameter in Parameter::ALL {
                    let moved = |h: f64| {
                        let mut maps = maps;
                        let (s, o) = (maps[a].scale(), maps[a].offset());
                        maps[a] = if parameter == Parameter::Scale { map(s + h, o) } else { map(s, o + h) };
                        maps
                    };
                    let mut seen = [h, 2.0 * h, 0.0].map(|h| {
                        let mut out = vec![0.0; 64];
                        plan.apply_by(PropagationRoute::Pixels, &source, moved(h), &all, [&mut out], &mut scratch);
                        out
                    });
                    let mut slope = vec![f64::NAN; 64];
                    plan.derivative((axis, parameter), &source, maps, &all, [&mut slope], &mut scratch);
                    // Richardson on the right-hand side: error O(h²) + ε/h.
                    let want: Vec<f64> =
                        (0..64).map(|k| (4.0 * seen[0][k] - seen[1][k] - 3.0 * seen[2][k]) / (2.0 * h)).collect();
                    assert_all_close(&slope, &want, 3e-8, &format!("{basis:?}, {axis:?}, {parameter:?}, {maps:?}"));
                    // The gradient of J = ⟨g, L⟩ is ⟨g, ∂L⟩.
                    let g = random(64, 77);
                    let gradient = plan.gradient(&source, maps, &all, [&g], &mut scratch);
                    let want: f64 = slope.iter().zip(&g).map(|(l, g)| l * g).sum();
                    let got = gradient[a][parameter as usize];
                    assert!((got - want).abs() <= 1e-13 * (1.0 + want.abs()), "{got:e} {want:e}");
                    seen[0].clear();
                }
            }
        }
    }
}

#[test]
fn the_adjoint_is_the_transpose() {
    for side in [1usize, 2, 8, 32] {
        for basis in BASES {
            let plan = Propagation::<f64>::new(side, basis).unwrap();
            let all = Targets::all(side, basis).unwrap();
            let mut scratch = PropagationScratch::new();
            for (k, x) in maps().into_iter().enumerate() {
                let maps = [x, maps()[(k * 3 + 1) % maps().len()]];
                let (f, g) = (random(side * side, 41), random(side * side, 42));
                let source = PropagationSource::from_dense(side, basis, [&f]).unwrap();
                let (mut l, mut back) = (vec![0.0; side * side], vec![0.0; side * side]);
                plan.apply(&source, maps, &all, [&mut l], &mut scratch);
                plan.adjoint(maps, &g, &mut back, &mut scratch);
                let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
                let (a, b) = (dot(&l, &g), dot(&f, &back));
                let scale = dot(&f, &f).sqrt() * dot(&back, &back).sqrt();
                assert!(
                    (a - b).abs() <= 1e-13 * (scale + a.abs()) + 1e-300,
                    "{side}, {basis:?}, {maps:?}: {a:e} {b:e}"
                );
            }
        }
    }
}

#[test]
fn a_batch_is_one_by_one_to_the_bit() {
    let (side, basis) = (16, Decomposition::Standard);
    let lights = [random(256, 51), random(256, 52), random(256, 53)];
    let sparse = lights
        .each_ref()
        .map(|l| SparseVector::from_pairs(256, l.iter().copied().enumerate().filter(|(i, _)| i % 11 == 0)).unwrap());
    let source = PropagationSource::new(side, basis, sparse.each_ref()).unwrap();
    let plan = Propagation::<f64>::new(side, basis).unwrap();
    let targets = Targets::new(side, basis, &(0..256).step_by(5).collect::<Vec<u32>>()).unwrap();
    let maps: Vec<[AffineMap; 2]> =
        (0..301).map(|k| [map(0.3 + 0.01 * k as f64, 0.1), map(-1.0, 0.004 * k as f64)]).collect();
    let mut out = vec![f64::NAN; maps.len() * 3 * targets.len()];
    plan.apply_batch(&source, &maps, &targets, &mut out);
    let mut scratch = PropagationScratch::new();
    for (maps, got) in maps.iter().zip(out.chunks(3 * targets.len())) {
        let mut want = vec![0.0; 3 * targets.len()];
        let (r, rest) = want.split_at_mut(targets.len());
        let (g, b) = rest.split_at_mut(targets.len());
        plan.apply(&source, *maps, &targets, [r, g, b], &mut scratch);
        assert_eq!(got, want);
    }
    plan.apply_batch(&source, &[], &targets, &mut []);
}

#[test]
fn what_does_not_fit_is_refused() {
    assert!(Propagation::<f32>::new(12, Decomposition::Standard).is_err());
    assert!(Propagation::<f32>::new(8192, Decomposition::Standard).is_err());
    assert!(Targets::new(4, Decomposition::Standard, &[3, 3]).is_err());
    assert!(Targets::new(4, Decomposition::Standard, &[16]).is_err());
    assert!(PropagationSource::from_dense(4, Decomposition::Standard, [&[0.0f32; 8]]).is_err());
    assert!(Operator1d::<f32>::new(0, AffineMap::IDENTITY).is_err());
    for (s, o) in
        [(0.0, 0.0), (-0.0, 0.0), (f64::NAN, 0.0), (1.0, f64::NAN), (f64::INFINITY, 0.0), (1.0, f64::INFINITY)]
    {
        assert!(AffineMap::new(s, o).is_err(), "{s} {o}");
    }
}

#[test]
#[should_panic(expected = "side of the source")]
fn a_source_of_another_side_panics() {
    let source = PropagationSource::from_dense(2, Decomposition::Standard, [&[0.0f32; 4]]).unwrap();
    let plan = Propagation::new(4, Decomposition::Standard).unwrap();
    let all = Targets::all(4, Decomposition::Standard).unwrap();
    plan.apply(&source, [AffineMap::IDENTITY; 2], &all, [&mut [0.0; 16]], &mut PropagationScratch::new());
}

proptest! {
    #[test]
    fn any_signal_through_any_map(samples in haar_signal::<f64>(6), m in affine_map()) {
        let coefs = forward_1d(&samples).unwrap();
        let got = inverse_1d(&apply_map_1d(&coefs, m).unwrap()).unwrap();
        let want = naive::resample_1d(&samples, m);
        assert_all_close(&got, &want, 64.0 * f64::EPSILON * largest(&samples), &format!("{m:?}"));
    }

    #[test]
    fn any_sparse_light_by_any_route(
        light in sparse_vector::<f64>(256, 20),
        x in affine_map(),
        y in affine_map(),
        kept in proptest::collection::btree_set(0u32..256, 0..60),
    ) {
        let kept: Vec<u32> = kept.into_iter().collect();
        for basis in BASES {
            let image = inverse_2d(&light.to_dense(), 16, 16, basis).unwrap();
            let want = forward_2d(&naive::resample_2d(&image, 16, 16, [x, y]), 16, 16, basis).unwrap();
            let want: Vec<f64> = kept.iter().map(|&k| want[k as usize]).collect();
            let targets = Targets::new(16, basis, &kept).unwrap();
            for route in [PropagationRoute::Wavelets, PropagationRoute::Pixels] {
                let [got] = run(route, 16, basis, [&light.to_dense()], [x, y], &targets);
                let scale = largest(&image).max(1e-300);
                assert_all_close(&got, &want, 64.0 * f64::EPSILON * scale, &format!("{route:?}, {basis:?}, {x:?} {y:?}"));
            }
        }
    }

    #[test]
    fn propagation_is_linear(f in signal::<f64>(64), g in signal::<f64>(64), x in affine_map(), y in affine_map(), a in -2.0..2.0f64) {
        let (largest_f, largest_g) = (largest(&f), largest(&g));
        prop_assume!(largest_f < 1e100 && largest_g < 1e100);
        for basis in BASES {
            let all = Targets::all(8, basis).unwrap();
            let sum: Vec<f64> = f.iter().zip(&g).map(|(f, g)| a * f + g).collect();
            for route in [PropagationRoute::Wavelets, PropagationRoute::Pixels] {
                let [lf] = run(route, 8, basis, [&f], [x, y], &all);
                let [lg] = run(route, 8, basis, [&g], [x, y], &all);
                let [ls] = run(route, 8, basis, [&sum], [x, y], &all);
                let want: Vec<f64> = lf.iter().zip(&lg).map(|(f, g)| a * f + g).collect();
                assert_all_close(&ls, &want, 512.0 * f64::EPSILON * (2.0 * largest_f + largest_g) * 8.0, &format!("{route:?} {basis:?}"));
            }
        }
    }
}
