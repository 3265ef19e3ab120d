//! Sources and targets of different sides: every route against the twin, derivatives and the adjoint.

use crate::support::{assert_all_close, cases, dot, map, random, wide};
use haarmonic::Real;
use haarmonic::affine::{
    AffineMap, Axis, Parameter, Propagation, PropagationRoute, PropagationScratch, PropagationSource, Targets,
};
use haarmonic::haar::{Decomposition, forward_2d};
use haarmonic::reference::affine as naive;
use haarmonic::strategies::affine_map;
use proptest::prelude::*;

const BASES: [Decomposition; 2] = [Decomposition::Standard, Decomposition::Nonstandard];
const SIDES: [[usize; 2]; 12] =
    [[1, 2], [2, 1], [1, 16], [16, 1], [2, 8], [8, 2], [4, 32], [32, 4], [16, 32], [32, 16], [64, 16], [16, 64]];

fn maps() -> [[AffineMap; 2]; 7] {
    [
        [AffineMap::IDENTITY; 2],
        [map(0.7137, 0.1071), map(-0.613, 0.87)],
        [map(1.9, -0.3), map(3.7, -1.2)],
        [map(-2.3, 1.41), map(0.031, 0.517)],
        [map(0.5, 0.25), map(-1.0, 1.0)],
        [map(1e-9, 0.5), map(40.0, -17.3)],
        [map(1.0, 1.0), map(0.5, 0.125)],
    ]
}

/// Means of the moved image over the target's pixels, as coefficients.
fn wanted(image: &[f64], [from, side]: [usize; 2], basis: Decomposition, maps: [AffineMap; 2]) -> Vec<f64> {
    forward_2d(&naive::resample_between_2d(image, from, [side; 2], maps), side, side, basis).unwrap()
}

/// In ε of max |F|: the routes' tolerance (worst seen: 1.6), and what look-ups lose to small scales.
fn tolerance(route: PropagationRoute, maps: [AffineMap; 2], epsilon: f64) -> f64 {
    let inverse = |m: AffineMap| m.scale().abs().recip().max(1.0);
    match route {
        PropagationRoute::Lookups => 4.0 * epsilon.max(8.0 * f64::EPSILON * inverse(maps[0]) * inverse(maps[1])),
        _ => 4.0 * epsilon,
    }
}

fn check<T: Real>(sides: [usize; 2], maps: [AffineMap; 2]) {
    let [from, side] = sides;
    let images = [random(from * from, 11), random(from * from, 12)];
    for basis in BASES {
        let pixels = images.each_ref().map(|image| image.iter().map(|&x| T::of(x)).collect::<Vec<T>>());
        let source = PropagationSource::from_pixels(from, basis, pixels.each_ref().map(Vec::as_slice)).unwrap();
        let plan = Propagation::<T>::between(from, side, basis).unwrap();
        assert_eq!([plan.source_side(), plan.side()], sides);
        let want = images.each_ref().map(|image| wanted(image, sides, basis, maps));
        let every: Vec<u32> = (0..(side * side) as u32).collect();
        let some: Vec<u32> = every.iter().copied().filter(|k| k % 3 == 0 || k % 7 == 2).collect();
        let few: Vec<u32> = every.iter().copied().filter(|k| k % 37 == 5).collect();
        let mut scratch = PropagationScratch::new();
        for route in PropagationRoute::ALL.map(Some).into_iter().chain([None]) {
            for kept in [&every, &some, &few] {
                let targets = Targets::new(side, basis, kept).unwrap();
                let mut out = [(); 2].map(|()| vec![T::nan(); kept.len()]);
                let planes = out.each_mut().map(Vec::as_mut_slice);
                let by = route.unwrap_or_else(|| plan.route(&source, maps, &targets));
                plan.apply_by(by, &source, maps, &targets, planes, &mut scratch);
                for (got, want) in out.iter().zip(&want) {
                    let want: Vec<f64> = kept.iter().map(|&k| want[k as usize]).collect();
                    let what = format!("{route:?}, {basis:?}, {sides:?}, {} targets, {maps:?}", kept.len());
                    assert_all_close(&wide(got), &want, tolerance(by, maps, T::epsilon().widen()), &what);
                }
            }
        }
    }
}

#[test]
fn every_route_equals_the_twin_between_sides() {
    for sides in SIDES {
        for maps in maps() {
            check::<f64>(sides, maps);
            check::<f32>(sides, maps);
        }
    }
}

#[test]
fn a_coarser_target_is_the_beginning_of_a_finer_one() {
    // Coefficients of an orthonormal basis do not change with the resolution.
    let image = random(64 * 64, 5);
    for maps in maps() {
        let source = PropagationSource::from_pixels(64, Decomposition::Nonstandard, [&image]).unwrap();
        let seen = [16, 64].map(|side| {
            let plan = Propagation::between(64, side, Decomposition::Nonstandard).unwrap();
            let (all, mut out) = (Targets::all(side, Decomposition::Nonstandard).unwrap(), vec![0.0; side * side]);
            plan.apply(&source, maps, &all, [&mut out], &mut PropagationScratch::new());
            out
        });
        assert_all_close(&seen[0], &seen[1][..256], 0.125 * f64::EPSILON, &format!("{maps:?}"));
    }
}

#[test]
fn the_adjoint_is_the_transpose_between_sides() {
    for sides @ [from, side] in SIDES {
        for basis in BASES {
            let plan = Propagation::<f64>::between(from, side, basis).unwrap();
            let (all, mut scratch) = (Targets::all(side, basis).unwrap(), PropagationScratch::new());
            for maps in maps() {
                let (f, g) = (random(from * from, 41), random(side * side, 42));
                let source = PropagationSource::from_dense(from, basis, [&f]).unwrap();
                let (mut l, mut back) = (vec![f64::NAN; side * side], vec![f64::NAN; from * from]);
                plan.apply(&source, maps, &all, [&mut l], &mut scratch);
                plan.adjoint(maps, &g, &mut back, &mut scratch);
                let (a, b) = (dot(&l, &g), dot(&f, &back));
                let scale = dot(&f, &f).sqrt() * dot(&back, &back).sqrt();
                assert!((a - b).abs() <= 1e-13 * (scale + a.abs()), "{sides:?}, {basis:?}, {maps:?}: {a:e} {b:e}");
            }
        }
    }
}

#[test]
fn derivatives_are_slopes_of_the_twin_between_sides() {
    let h = 1e-6;
    for sides @ [from, side] in [[4, 8], [16, 4], [1, 4], [4, 1]] {
        let image = random(from * from, 31);
        let basis = Decomposition::Standard;
        let source = PropagationSource::from_pixels(from, basis, [&image]).unwrap();
        let (plan, all) = (Propagation::between(from, side, basis).unwrap(), Targets::all(side, basis).unwrap());
        // Generic maps; kinks, where ends of both grids coincide; touching from outside.
        for maps in
            [[map(0.7137, 0.1071), map(-1.31, 0.87)], [map(1.0, 0.0), map(-0.5, 0.75)], [map(1.0, 1.0), map(1.0, -1.0)]]
        {
            for (a, axis) in [Axis::X, Axis::Y].into_iter().enumerate() {
                for parameter in Parameter::ALL {
                    let moved = |h: f64| {
                        let (mut maps, s, o) = (maps, maps[a].scale(), maps[a].offset());
                        maps[a] = if parameter == Parameter::Scale { map(s + h, o) } else { map(s, o + h) };
                        wanted(&image, sides, basis, maps)
                    };
                    let [one, two, here] = [h, 2.0 * h, 0.0].map(moved);
                    // Richardson on the right-hand side: error O(h²) + ε/h.
                    let want: Vec<f64> =
                        (0..here.len()).map(|k| (4.0 * one[k] - two[k] - 3.0 * here[k]) / (2.0 * h)).collect();
                    let mut slope = vec![f64::NAN; side * side];
                    let mut scratch = PropagationScratch::new();
                    plan.derivative((axis, parameter), &source, maps, &all, [&mut slope], &mut scratch);
                    assert_all_close(&slope, &want, 1e-9, &format!("{sides:?}, {axis:?}, {parameter:?}, {maps:?}"));
                }
            }
        }
    }
}

#[test]
fn sides_that_do_not_fit_are_refused() {
    for (from, side) in [(0, 4), (4, 0), (3, 4), (4, 3), (8192, 4), (4, 8192)] {
        assert!(Propagation::<f32>::between(from, side, Decomposition::Standard).is_err(), "{from} {side}");
    }
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn any_map_between_any_sides(x in affine_map(), y in affine_map(), from in 0..5u32, side in 0..5u32) {
        let sides @ [from, side] = [1usize << from, 1 << side];
        let image = random(from * from, 3);
        for basis in BASES {
            let source = PropagationSource::from_pixels(from, basis, [&image]).unwrap();
            let (plan, all) = (Propagation::between(from, side, basis).unwrap(), Targets::all(side, basis).unwrap());
            let want = wanted(&image, sides, basis, [x, y]);
            for route in [PropagationRoute::Wavelets, PropagationRoute::Pixels] {
                let mut got = vec![f64::NAN; side * side];
                plan.apply_by(route, &source, [x, y], &all, [&mut got], &mut PropagationScratch::new());
                assert_all_close(&got, &want, 2.0 * f64::EPSILON, &format!("{route:?}, {basis:?}, {sides:?}, {x:?} {y:?}"));
            }
        }
    }
}
