//! Images in pixels, moved: against the twin, its transpose, its derivatives, and every edge of the sides.

use crate::support::{cases, dot, map, random, wide};
use haarmonic::Real;
use haarmonic::affine::{AffineMap, Axis, Parameter, PixelOperator};
use haarmonic::reference::affine as naive;
use haarmonic::strategies::affine_map;
use proptest::prelude::*;

const SIDES: [[usize; 2]; 9] = [[1, 1], [1, 4], [4, 1], [2, 2], [4, 32], [32, 4], [8, 8], [16, 32], [32, 32]];

/// The twin's image, column by column.
fn wanted(image: &[f64], [from, side]: [usize; 2], maps: [AffineMap; 2]) -> Vec<f64> {
    let rows = naive::resample_between_2d(image, from, [side; 2], maps);
    (0..side * side).map(|i| rows[i % side * side + i / side]).collect()
}

fn check<T: Real>(sides: [usize; 2], maps: [AffineMap; 2]) {
    let [from, side] = sides;
    let narrow = |values: &[f64]| values.iter().map(|&x| T::of(x)).collect::<Vec<T>>();
    let images = [narrow(&random(from * from, 1)), narrow(&random(from * from, 2))];
    let met = narrow(&random(side * side, 3));
    let mut operator = PixelOperator::new(from, side).unwrap();
    assert_eq!([operator.source_side(), operator.side()], sides);
    operator.set(maps);
    let mut back = vec![T::nan(); from * from];
    operator.adjoint(&met, &mut back);
    let products = operator.inner_products([&images[0], &images[1]], &met);
    let epsilon = T::epsilon().widen();
    for (image, product) in images.iter().zip(products) {
        let mut seen = vec![T::nan(); side * side];
        operator.apply(image, &mut seen);
        let want = wanted(&wide(image), sides, maps);
        for (i, (got, want)) in seen.iter().zip(&want).enumerate() {
            // Images are within ±1; ends of source pixels are rounded by ε of their place in f64 (worst of 3,000: 2.1).
            let place = if size_of::<T>() == 8 { (i % side).max(i / side) as f64 } else { 0.0 };
            assert!(
                (got.widen() - want).abs() <= (4.0 + 4.0 * place) * epsilon,
                "{sides:?} {maps:?} pixel {i}: {got} {want}"
            );
        }
        // Sums of side² products of numbers within ±1, in an order of their own.
        let (want, allowed) = (dot(&want, &wide(&met)), 2.0 * epsilon * (side * side) as f64);
        assert!((product.widen() - want).abs() <= allowed, "{sides:?} {maps:?}: {product} {want}");
        let transposed = dot(&wide(&back), &wide(image));
        assert!((transposed - want).abs() <= allowed, "{sides:?} {maps:?}: {transposed} {want}");
    }
}

#[test]
fn images_are_the_twins_and_products_those_of_either_side() {
    let scales = [map(1.0, 0.0), map(0.31, 0.2), map(2.7, -0.9), map(-1.3, 1.1), map(1e-9, 0.4), map(40.0, -17.3)];
    for sides in SIDES {
        for x in scales {
            for y in scales {
                check::<f64>(sides, [x, y]);
                check::<f32>(sides, [x, y]);
            }
        }
        // Nothing in sight.
        check::<f32>(sides, [map(1.0, 1.0), map(0.5, 0.1)]);
        check::<f32>(sides, [map(0.5, 0.1), map(1.0, -1.0)]);
    }
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn any_map_is_the_twins(sides in proptest::sample::select(&SIDES[..]), x in affine_map(), y in affine_map()) {
        check::<f64>(sides, [x, y]);
    }
}

#[test]
fn derivatives_are_differences() {
    let (image, maps, step) = (random(64, 5), [map(0.83, 0.07), map(1.21, -0.13)], 1e-6);
    let mut operator = PixelOperator::<f64>::new(8, 8).unwrap();
    for (k, axis) in [Axis::X, Axis::Y].into_iter().enumerate() {
        for parameter in Parameter::ALL {
            let mut images = [-step, step].map(|d| {
                let mut moved = maps;
                moved[k] = match parameter {
                    Parameter::Scale => map(maps[k].scale() + d, maps[k].offset()),
                    Parameter::Offset => map(maps[k].scale(), maps[k].offset() + d),
                };
                let mut out = vec![0.0; 64];
                operator.set(moved);
                operator.apply(&image, &mut out);
                out
            });
            let [before, after] = &mut images;
            let mut slope = vec![0.0; 64];
            operator.set_derivative((axis, parameter), maps);
            operator.apply(&image, &mut slope);
            for ((before, after), slope) in before.iter().zip(after).zip(slope) {
                // No kink lies within a step of these maps: what is left is the rounding of the difference.
                assert!(((*after - *before) / (2.0 * step) - slope).abs() < 1e-8, "{axis:?} {parameter:?}");
            }
        }
    }
}

#[test]
fn sides_that_are_none_are_refused() {
    for (from, side) in [(0, 4), (4, 0), (3, 4), (4, 6), (8192, 4), (4, 8192), (usize::MAX, 1)] {
        assert!(PixelOperator::<f32>::new(from, side).is_err(), "{from} {side}");
    }
}

#[test]
#[should_panic(expected = "pixels of the source")]
fn a_source_of_another_side_panics() {
    PixelOperator::<f32>::new(4, 4).unwrap().apply(&[0.0; 15], &mut [0.0; 16]);
}
