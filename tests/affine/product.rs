//! Affine product integrals and light fields against golden values and naive twins.

use crate::support::{HAAR_AFFINE, assert_close, cases, differentiable, golden, largest, map, number, right_gradient};
use haarmonic::affine::{
    AffineMap, AffineProduct1d, AffineProduct2d, Atom, LightField, LightFieldTerm, ProductRoute,
    affine_double_product_1d, affine_double_product_2d, affine_triple_product_1d, affine_triple_product_2d,
    tripling_1d, tripling_nonstandard,
};
use haarmonic::haar::{BinaryTree, Quadtree, SparseVector};
use haarmonic::reference::{affine as naive, haar as naive_haar};
use haarmonic::{Error, Real, strategies};
use proptest::prelude::*;

const EPS: f64 = f64::EPSILON;
const ROUTES: [ProductRoute; 2] = [ProductRoute::Terms, ProductRoute::Primitive];

fn narrow<T: Real>(dense: &[f64]) -> SparseVector<T> {
    SparseVector::from_dense(&dense.iter().map(|&c| T::of(c)).collect::<Vec<T>>())
}

/// The sparse coefficients of 1D samples.
fn sparse(samples: &[f64]) -> SparseVector<f64> {
    narrow(&naive_haar::forward_1d(samples))
}

#[test]
fn golden_products() {
    let file = golden(HAAR_AFFINE, "affine_products_1d");
    let cases = file["cases"].as_array().unwrap();
    assert!(cases.len() >= 8);
    for case in cases {
        let map = map(number(&case["s"]), number(&case["o"]));
        let samples = |name: &str| case[name].as_array().unwrap().iter().map(number).collect::<Vec<_>>();
        let [f, g, w] = ["F", "G", "W"].map(samples);
        let scale = largest(&f) * largest(&g);
        let plan = AffineProduct1d::new(&sparse(&f)).unwrap();
        let [tg, tw] = [&g, &w].map(|x| BinaryTree::new(&sparse(x)).unwrap());
        let (double, triple) = (number(&case["double"]), number(&case["triple"]));
        for route in ROUTES {
            assert_close(plan.integral_by(route, [&tg], map), double, 2e-15 * scale, "double");
            let triple_scale = 2e-15 * scale * largest(&w);
            assert_close(plan.integral_by(route, [&tg, &tw], map), triple, triple_scale, "triple");
        }
        let [f, g, w] = [f, g, w].map(|x| sparse(&x));
        assert_close(affine_double_product_1d(&f, &g, map).unwrap(), double, 2e-15 * scale, "double");
        assert_eq!(affine_triple_product_1d(&f, &g, &w, map).unwrap(), plan.integral([&tg, &tw], map));
        // In f32 the coefficients are rounded; what is done with them is not.
        let [f, g] = [f, g].map(|x| narrow::<f32>(&x.to_dense()));
        assert_close(affine_double_product_1d(&f, &g, map).unwrap(), double, 1e-6 * scale, "double in f32");
    }
}

/// ∫∫ F(s v + o) G W over the texels of G and W, from the exact means of F over them.
fn truth_2d(f: &[f64], factors: &[&[f64]], maps: [AffineMap; 2]) -> f64 {
    let side = f.len().isqrt();
    let seen = naive::resample_2d(f, side, side, maps);
    let product = |p: usize| factors.iter().map(|g| g[p]).product::<f64>();
    seen.iter().enumerate().map(|(p, mean)| mean * product(p)).sum::<f64>() / seen.len() as f64
}

fn sparse_2d(samples: &[f64]) -> SparseVector<f64> {
    narrow(&naive_haar::forward_nonstandard(samples))
}

/// How much a rounding of a source point moves the target points.
fn condition(map: AffineMap) -> f64 {
    1.0 + (1.0 + map.offset().abs()) / map.scale().abs()
}

/// Samples of ordinary size, one-hot, constant, binary.
fn samples(len: usize) -> impl Strategy<Value = Vec<f64>> {
    strategies::signal::<f64>(len).prop_filter("an ordinary size", |x| {
        let m = largest(x);
        m == 0.0 || (1e-6..1e6).contains(&m)
    })
}

fn factors_1d() -> impl Strategy<Value = [Vec<f64>; 3]> {
    strategies::power_of_two(4).prop_flat_map(|n| [samples(n), samples(n), samples(n)])
}

fn factors_2d() -> impl Strategy<Value = [Vec<f64>; 3]> {
    strategies::power_of_two(3).prop_flat_map(|n| [samples(n * n), samples(n * n), samples(n * n)])
}

/// By the primitive an error of ε max|F| is divided by s; term by term it is not.
fn loss(route: ProductRoute, maps: &[AffineMap]) -> f64 {
    match route {
        ProductRoute::Terms => 1.0,
        ProductRoute::Primitive => maps.iter().map(|map| 1.0 + map.scale().recip().abs()).product(),
    }
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn products_1d_equal_the_twin([f, g, w] in factors_1d(), map in strategies::affine_map()) {
        let plan = AffineProduct1d::new(&sparse(&f)).unwrap();
        let [tg, tw] = [&g, &w].map(|x| BinaryTree::new(&sparse(x)).unwrap());
        let n = f.len() as f64;
        let unit = 2.0 * EPS * n * largest(&f);
        let routes = ROUTES.map(|route| (route, true)).into_iter().chain([(plan.route(map), false)]);
        for (route, by_name) in routes {
            let tolerance = unit * (condition(map) + loss(route, &[map]));
            let got = if by_name { plan.integral_by(route, [&tg], map) } else { plan.integral([&tg], map) };
            let want = naive::double_product(&f, &g, map);
            prop_assert!((got - want).abs() <= tolerance * largest(&g), "{:?}: {:e} {:e}", route, got, want);
            let got = if by_name { plan.integral_by(route, [&tg, &tw], map) } else { plan.integral([&tg, &tw], map) };
            let want = naive::triple_product(&f, &g, &w, map);
            let scale = largest(&g) * largest(&w);
            prop_assert!((got - want).abs() <= tolerance * scale, "{:?}: {:e} {:e}", route, got, want);
            let got = plan.integral_by::<f64, 0>(route, [], map);
            let want = naive::double_product(&f, &[1.0], map);
            prop_assert!((got - want).abs() <= tolerance, "{:?}: {:e} {:e}", route, got, want);
        }
    }

    #[test]
    fn products_2d_equal_the_twin(
        [f, g, w] in factors_2d(), maps in [strategies::affine_map(), strategies::affine_map()],
    ) {
        let plan = AffineProduct2d::new([&sparse_2d(&f)]).unwrap();
        let [tg, tw] = [&g, &w].map(|x| Quadtree::new(&sparse_2d(x)).unwrap());
        let unit = 2.0 * EPS * f.len() as f64 * largest(&f) * largest(&g);
        for route in ROUTES {
            let tolerance = unit * (condition(maps[0]) + condition(maps[1])).min(1e18) + unit * loss(route, &maps);
            let [got] = plan.integral_by(route, [&tg], maps);
            let want = truth_2d(&f, &[&g], maps);
            prop_assert!((got - want).abs() <= tolerance, "{:?}: {:e} {:e}", route, got, want);
            let [got] = plan.integral_by(route, [&tg, &tw], maps);
            let want = truth_2d(&f, &[&g, &w], maps);
            prop_assert!((got - want).abs() <= tolerance * largest(&w), "{:?}: {:e} {:e}", route, got, want);
        }
        // The route that it chooses stays right at any scale that does not move o by its rounding.
        let [got] = plan.integral([&tg], maps);
        let tolerance = unit * (condition(maps[0]) + condition(maps[1]) + 2f64.powi(22));
        prop_assert!((got - truth_2d(&f, &[&g], maps)).abs() <= tolerance);
    }

    #[test]
    fn gradients_of_products_are_right_hand_slopes([f, g, w] in factors_1d(), map in differentiable()) {
        let plan = AffineProduct1d::new(&sparse(&f)).unwrap();
        let [tg, tw] = [&g, &w].map(|x| BinaryTree::new(&sparse(x)).unwrap());
        let want = right_gradient(map, |map| naive::triple_product(&f, &g, &w, map));
        let tolerance = 1e-8 * largest(&f) * largest(&g) * largest(&w) * f.len() as f64;
        for route in ROUTES {
            let got = plan.gradient_by(route, [&tg, &tw], map);
            prop_assert!((got.value[0] - plan.integral_by(route, [&tg, &tw], map)).abs() <= 1e-7 * tolerance);
            for (got, want) in [got.scale[0][0], got.offset[0][0]].into_iter().zip(want) {
                prop_assert!((got - want).abs() <= tolerance, "{:?}: {} {}", route, got, want);
            }
        }
    }

    #[test]
    fn gradients_in_2d_are_right_hand_slopes([f, g, w] in factors_2d(), maps in [differentiable(), differentiable()]) {
        let plan = AffineProduct2d::new([&sparse_2d(&f)]).unwrap();
        let [tg, tw] = [&g, &w].map(|x| Quadtree::new(&sparse_2d(x)).unwrap());
        let tolerance = 1e-8 * largest(&f) * largest(&g) * largest(&w) * f.len() as f64;
        for route in ROUTES {
            let got = plan.gradient_by(route, [&tg, &tw], maps);
            prop_assert!((got.value[0] - plan.integral_by(route, [&tg, &tw], maps)[0]).abs() <= 1e-7 * tolerance);
            for q in 0..2 {
                let want = right_gradient(maps[q], |map| {
                    truth_2d(&f, &[&g, &w], if q == 0 { [map, maps[1]] } else { [maps[0], map] })
                });
                for (got, want) in [got.scale[q][0], got.offset[q][0]].into_iter().zip(want) {
                    prop_assert!((got - want).abs() <= tolerance, "{:?} axis {}: {} {}", route, q, got, want);
                }
            }
        }
    }
}

#[test]
fn gradients_at_kinks_are_right_hand() {
    // Ends, middles and cells of source and target coincide.
    let kinks = [
        (1.0, 0.0),
        (1.0, 0.25),
        (-1.0, 1.0),
        (-1.0, 0.75),
        (0.5, 0.5),
        (-0.5, 1.0),
        (2.0, -1.0),
        (-2.0, 2.0),
        (3.0, -1.0),
    ];
    let at = |n: usize| (n as f64 * 0.618).fract() - 0.3;
    for (s, o) in kinks {
        let map = map(s, o);
        let [f, g, w] = [0, 1, 2].map(|m| (0..8).map(|n| at(8 * m + n)).collect::<Vec<_>>());
        let plan = AffineProduct1d::new(&sparse(&f)).unwrap();
        let [tg, tw] = [&g, &w].map(|x| BinaryTree::new(&sparse(x)).unwrap());
        let want = right_gradient(map, |map| naive::triple_product(&f, &g, &w, map));
        let image = |m: usize| (0..16).map(|n| at(16 * m + n)).collect::<Vec<_>>();
        let square = AffineProduct2d::new([&sparse_2d(&image(0))]).unwrap();
        let maps = [AffineMap::new(1.3, -0.2).unwrap(), map];
        let tree = Quadtree::new(&sparse_2d(&image(1))).unwrap();
        let want_2d = right_gradient(map, |map| truth_2d(&image(0), &[&image(1)], [maps[0], map]));
        for route in ROUTES {
            let got = plan.gradient_by(route, [&tg, &tw], map);
            let got_2d = square.gradient_by(route, [&tree], maps);
            for (got, want, name) in [
                (got.scale[0][0], want[0], "scale"),
                (got.offset[0][0], want[1], "offset"),
                (got_2d.scale[1][0], want_2d[0], "scale in 2D"),
                (got_2d.offset[1][0], want_2d[1], "offset in 2D"),
            ] {
                assert_close(got, want, 1e-7, &format!("{route:?}, {name}, {s} {o}"));
            }
        }
    }
}

#[test]
fn a_product_is_the_sum_over_all_triplings() {
    let value = |n: usize| (n as f64 * 0.618).fract() - 0.4;
    let map = map(-0.713, 0.9);
    let [f, g, w] = [0, 1, 2].map(|m| (0..8).map(|n| value(8 * m + n)).collect::<Vec<_>>());
    let mut want = 0.0;
    for n in 0..512 {
        let (i, j, k) = (n / 64, n / 8 % 8, n % 8);
        want += f[i] * g[j] * w[k] * tripling_1d(i, j, k, map);
    }
    let got = affine_triple_product_1d(&narrow::<f64>(&f), &narrow(&g), &narrow(&w), map).unwrap();
    assert_close(got, want, 1e-14, "1D");

    let maps = [map, AffineMap::new(1.31, -0.2).unwrap()];
    let [f, g, w] = [0, 1, 2].map(|m| (0..16).map(|n| value(16 * m + n)).collect::<Vec<_>>());
    let mut want = 0.0;
    for n in 0..4096 {
        let (i, j, k) = (n / 256, n / 16 % 16, n % 16);
        want += f[i] * g[j] * w[k] * tripling_nonstandard(i, j, k, maps);
    }
    let [f, g, w] = [f, g, w].map(|x| narrow::<f64>(&x));
    assert_close(affine_triple_product_2d(&f, &g, &w, maps).unwrap(), want, 1e-14, "2D");
}

#[test]
fn channels_sizes_and_routes() {
    let at = |n: usize| (n as f64 * 0.414).fract() - 0.3;
    let image = |side: usize, seed: usize| (0..side * side).map(|n| at(n + 7 * seed)).collect::<Vec<_>>();
    let maps = [map(0.7, 0.1), map(-1.3, 1.1)];
    let channels = [0, 1, 2].map(|c| sparse_2d(&image(8, c)));
    let plan = AffineProduct2d::new([&channels[0], &channels[1], &channels[2]]).unwrap();
    let g = Quadtree::new(&sparse_2d(&image(4, 9))).unwrap();
    let (all, slopes) = (plan.integral([&g], maps), plan.gradient([&g], maps));
    for c in 0..3 {
        let single = AffineProduct2d::new([&channels[c]]).unwrap();
        assert_eq!([all[c]], single.integral([&g], maps));
        assert_eq!(slopes.offset[1][c], single.gradient([&g], maps).offset[1][0]);
        let [by_terms, alone] = [
            plan.integral_by(ProductRoute::Terms, [&g], maps)[c],
            single.integral_by(ProductRoute::Terms, [&g], maps)[0],
        ];
        assert_eq!(by_terms, alone);
        // Coarser factors than the light: as if they were drawn on its grid.
        let finer: Vec<f64> = (0..64).map(|p| image(4, 9)[(p / 16) * 4 + p % 8 / 2]).collect();
        let want = truth_2d(&image(8, c), &[&finer], maps);
        for route in ROUTES {
            assert_close(single.integral_by(route, [&g], maps)[0], want, 1e-14, "another size");
        }
    }
    assert_eq!(plan.route(maps), ProductRoute::Primitive);
    assert_eq!(plan.route([map(1e-9, 0.5); 2]), ProductRoute::Terms);
    let flat = AffineProduct2d::new([&SparseVector::from_dense(&[2.0])]).unwrap();
    assert_eq!(flat.route(maps), ProductRoute::Terms);
    assert_eq!(flat.integral([&g], [map(1.0, 2.0); 2]), [0.0]);
    // A tiny scale sees one pixel of the light, whatever its size.
    for scale in [1e-9, -1e-9, 1e-100] {
        let [got] = AffineProduct2d::new([&channels[0]]).unwrap().integral::<f64, 0>([], [map(scale, 0.3); 2]);
        assert_close(got, image(8, 0)[2 * 8 + 2], 1e-14, "one pixel");
    }
}

#[test]
fn wrong_sizes_are_refused() {
    let [three, eight] = [3, 8].map(|n| SparseVector::from_dense(&vec![1.0; n]));
    let four = SparseVector::from_dense(&[1.0; 4]);
    assert!(matches!(AffineProduct1d::new(&three), Err(Error::NotPowerOfTwo { .. })));
    assert!(matches!(AffineProduct2d::new([&three]), Err(Error::NotPowerOfTwo { .. })));
    assert!(matches!(AffineProduct2d::new([&eight]), Err(Error::NotPowerOfTwo { .. })));
    assert!(matches!(AffineProduct2d::new([&four, &SparseVector::default()]), Err(Error::Length { .. })));
    assert!(matches!(AffineProduct2d::<0>::new::<f64>([]), Err(Error::Empty { .. })));
    let huge = SparseVector::<f64>::new(1 << 26, vec![], vec![]).unwrap();
    assert!(matches!(AffineProduct2d::new([&huge]), Err(Error::OutOfRange { .. })));
    assert!(affine_double_product_2d(&four, &eight, [AffineMap::IDENTITY; 2]).is_err());
    assert!(matches!(LightField::new(12), Err(Error::NotPowerOfTwo { .. })));
    assert!(matches!(LightField::new(1 << 16), Err(Error::OutOfRange { .. })));
}

#[test]
fn a_nan_is_not_lost() {
    let f = sparse(&[1.0, 2.0, f64::NAN, 4.0]);
    let g = BinaryTree::new(&sparse(&[1.0, 2.0, 3.0, 4.0])).unwrap();
    let plan = AffineProduct1d::new(&f).unwrap();
    for route in ROUTES {
        assert!(plan.integral_by(route, [&g], AffineMap::IDENTITY).is_nan());
    }
}

/// A light field F_ij at j·N + i and its samples F[plane·N + direction].
fn light_field(size: usize, seed: usize) -> (SparseVector<f64>, Vec<f64>) {
    let value = |n: usize| ((n * n + 3 * seed) as f64 * 0.618).fract() - 0.4;
    let field: Vec<f64> = (0..size * size).map(|n| if n % 3 == seed % 3 { value(n) } else { 0.0 }).collect();
    let by_direction = naive_haar::inverse_standard(size, &field);
    let samples = (0..size * size).map(|n| by_direction[(n % size) * size + n / size]).collect();
    (narrow(&field), samples)
}

#[test]
fn light_fields_equal_the_pixel_domain() {
    let maps = [(1.0, 0.0), (0.5, 0.25), (-0.713, 0.9), (2.6, -0.7), (3.0, -1.0), (0.01, 0.4), (1.0, 1.5)];
    for size in [1, 2, 8, 16] {
        for (seed, (s, o)) in maps.into_iter().enumerate() {
            let (field, samples) = light_field(size, seed);
            let want = naive_haar::forward_1d(&naive::resample_light_field(&samples, size, map(s, o)));
            let plan = LightField::new(size).unwrap();
            let mut got = vec![f64::NAN; size];
            plan.propagate(&field, map(s, o), &mut got);
            let tolerance = 4.0 * EPS * largest(&samples) * condition(map(s, o));
            let mut narrow_got = vec![0.0f32; size];
            plan.propagate(&narrow(&field.to_dense()), map(s, o), &mut narrow_got);
            for k in 0..size {
                assert_close(got[k], want[k], tolerance, &format!("{size}: L_{k} at {s} {o}"));
                let single = 4.0 * f64::from(f32::EPSILON) * largest(&samples);
                assert_close(narrow_got[k].into(), want[k], single, "f32");
            }
        }
    }
}

#[test]
fn light_fields_in_space_equal_the_sum_over_triplings() {
    let size = 8;
    let maps = [map(0.713, 0.1), map(-1.3, 1.1)];
    let index = |n: usize| (n * 5 + n * n) as u32 % size as u32;
    let field: Vec<LightFieldTerm<f64, 2>> = (0..40)
        .map(|n| LightFieldTerm {
            plane: [index(n), index(n + 3)],
            direction: [index(2 * n + 1), index(3 * n + 2)],
            value: [(n as f64 * 0.618).fract() - 0.5, 1.0],
        })
        .collect();
    let mut got = vec![[f64::NAN; 2]; size * size];
    LightField::new(size).unwrap().propagate_in_space(&field, maps, &mut got);
    for (k, got) in got.into_iter().enumerate() {
        let (mut want, mut scale) = ([0.0; 2], 0.0);
        for LightFieldTerm { plane, direction, value } in &field {
            let d = |q: usize, k| naive::tripling_1d(plane[q] as usize, direction[q] as usize, k, maps[q]);
            let level = |flat: u32| Atom::from_flat(flat as usize).level as i32;
            scale += 2f64.powi((level(plane[0]) + level(plane[1]) + 6) / 2);
            for c in 0..2 {
                want[c] += value[c] * d(0, k % size) * d(1, k / size);
            }
        }
        for c in 0..2 {
            assert_close(got[c], want[c], 4.0 * EPS * scale, &format!("L_{k} channel {c}"));
        }
    }
    let outside = LightFieldTerm { plane: [8, 0], direction: [0, 0], value: [1.0] };
    let refused = std::panic::catch_unwind(|| {
        LightField::new(size).unwrap().propagate_in_space(&[outside], maps, &mut [[0.0]; 64]);
    });
    assert!(refused.is_err());
}
