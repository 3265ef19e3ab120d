//! Tripling coefficients, products and product integrals of Haar signals against golden values and naive twins.

use crate::support::{HAAR_AFFINE, Stream, assert_close, cases, golden, half_power, narrow, number};
use haarmonic::Real;
use haarmonic::haar::{
    BinaryTree, BitPyramid, BitPyramidRef, Factor, MaskedSum, MeanTree, NFoldProduct, Product1d, Product2d, Quadtree,
    Route, SparseVector, TripleProduct, Tripling, Visibility, multiply_sparse_1d, multiply_sparse_2d, tripling_1d,
    tripling_2d, tripling_count_1d, tripling_count_2d, tripling_nonzeros_1d, tripling_nonzeros_2d,
};
use haarmonic::reference::haar as naive;
use haarmonic::reference::haar::{NgTree, NgTripleProduct};
use proptest::prelude::*;
use serde_json::Value;

/// A number, a rational, or [m, e] = m·2^{e/2}.
fn value(v: &Value) -> f64 {
    v.as_array().map_or_else(|| number(v), |pair| half_power(&pair[0], &pair[1]))
}

fn indices(v: &Value) -> Vec<usize> {
    v.as_array().unwrap().iter().map(|i| i.as_u64().unwrap() as usize).collect()
}

fn image(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().flat_map(|row| row.as_array().unwrap().iter().map(value)).collect()
}

/// Coefficients narrowed to T, zeros dropped.
fn sparse<T: Real>(dense: &[f64]) -> SparseVector<T> {
    SparseVector::from_dense(&narrow::<T>(dense))
}

fn abs(x: &[f64]) -> Vec<f64> {
    x.iter().map(|x| x.abs()).collect()
}

#[test]
fn golden_tripling_1d() {
    let file = golden(HAAR_AFFINE, "stc_1d");
    let size = file["N"].as_u64().unwrap() as usize;
    let entries = file["nonzero"].as_array().unwrap();
    let mut listed = tripling_nonzeros_1d(size).unwrap();
    for e in entries {
        let ([i, j, k], value) = listed.next().expect("as many non-zeros as the golden file");
        assert_eq!([i, j, k], [0, 1, 2].map(|n| e[n].as_u64().unwrap() as usize));
        let want = half_power(&e[3], &e[4]);
        assert_eq!(value.value::<f64>(), want);
        assert_eq!(value.value::<f32>(), want as f32);
        assert_eq!(tripling_1d(k, i, j), value);
    }
    assert_eq!(listed.next(), None);
    assert_eq!(tripling_count_1d(size).unwrap(), file["ordered_count"].as_u64().unwrap());
}

#[test]
fn golden_tripling_2d() {
    let file = golden(HAAR_AFFINE, "stc_2d_nonstandard");
    let side = file["N"].as_u64().unwrap() as usize;
    // The file lists its basis as (kind, level, x, y) in an order of its own.
    let flat: Vec<usize> = file["basis"]
        .as_array()
        .unwrap()
        .iter()
        .map(|b| {
            let [kind, level, x, y] = indices(b)[..] else { panic!("four columns") };
            if kind == 0 { 0 } else { (kind << (2 * level)) + (y << level) + x }
        })
        .collect();
    let mut want: Vec<([usize; 3], f64)> = file["nonzero"]
        .as_array()
        .unwrap()
        .iter()
        .map(|e| {
            let mut triple = [0, 1, 2].map(|n| flat[e[n].as_u64().unwrap() as usize]);
            triple.sort_unstable();
            (triple, value(&e[3]))
        })
        .collect();
    want.sort_by_key(|e| e.0);
    let got: Vec<_> = tripling_nonzeros_2d(side).unwrap().map(|(t, value)| (t, value.value::<f64>())).collect();
    assert_eq!(got, want);
    assert_eq!(tripling_count_2d(side).unwrap(), file["ordered_count"].as_u64().unwrap());
    for ([i, j, k], value) in want {
        assert_eq!(tripling_2d(j, i, k).value::<f64>(), value);
    }
}

#[test]
fn tripling_equals_numeric_integration() {
    for size in [1, 2, 4, 8, 16] {
        for_triples(size, |i, j, k| {
            let want = naive::tripling_1d(size, i, j, k);
            assert_close(tripling_1d(i, j, k).value(), want, 8.0 * f64::EPSILON, &format!("{i} {j} {k}"));
        });
    }
    for side in [1, 2, 4] {
        for_triples(side * side, |i, j, k| {
            let want = naive::tripling_2d(side, i, j, k);
            assert_close(tripling_2d(i, j, k).value(), want, 0.0, &format!("{i} {j} {k}"));
        });
    }
    assert_eq!(Tripling::ZERO.value::<f32>(), 0.0);
}

fn for_triples(n: usize, mut each: impl FnMut(usize, usize, usize)) {
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                each(i, j, k);
            }
        }
    }
}

/// Every route's ∫ L B V, for dense coefficients with zeros; V's bits too if it is binary.
fn every_route<T: Real>(light: &[f64], brdf: &[f64], visibility: &[f64]) -> Vec<(&'static str, f64)> {
    let side = light.len().isqrt();
    let (l, b, v) = (sparse::<T>(light), sparse::<T>(brdf), sparse::<T>(visibility));
    let (fl, fb) = (Factor::new([&l]).unwrap(), Factor::new([&b]).unwrap());
    let means = MeanTree::from_sparse([&v]).unwrap();
    let plan = TripleProduct::new(side).unwrap();
    let by = |route, v| plan.integral_by(route, &fl, &fb, v)[0];
    let mut out = vec![
        ("flat merge", by(Route::FlatMerge, Visibility::Means(&means))),
        ("pixels", by(Route::Pixels, Visibility::Means(&means))),
        ("engine", plan.integral(&fl, &fb, Visibility::Means(&means))[0]),
        (
            "Ng",
            NgTripleProduct::integral(&NgTree::new(&l).unwrap(), &NgTree::new(&b).unwrap(), &narrow::<T>(visibility)),
        ),
        (
            "N-fold",
            NFoldProduct::new().integral(&[
                &Quadtree::new(&l).unwrap(),
                &Quadtree::new(&b).unwrap(),
                &Quadtree::new(&v).unwrap(),
            ]),
        ),
    ];
    let pixels = naive::inverse_nonstandard(visibility);
    if pixels.iter().all(|&p| p == 0.0 || p == 1.0) {
        let bits = BitPyramid::from_rows(side, &rows(&pixels)).unwrap();
        out.push(("flat merge, bits", by(Route::FlatMerge, Visibility::from(&bits))));
        out.push(("pixels, bits", by(Route::Pixels, Visibility::from(&bits))));
        out.push(("engine, bits", plan.integral(&fl, &fb, Visibility::from(&bits))[0]));
    }
    out
}

/// Row-major bits of a binary image.
fn rows(pixels: &[f64]) -> Vec<u64> {
    let mut words = vec![0; pixels.len().div_ceil(64)];
    for (i, &p) in pixels.iter().enumerate() {
        words[i / 64] |= u64::from(p != 0.0) << (i % 64);
    }
    words
}

/// ∫ L B V of the signals, and Π of their largest |texels|, the scale of its errors.
fn pixel_truth(light: &[f64], brdf: &[f64], visibility: &[f64]) -> (f64, f64) {
    let [l, b, v] = [light, brdf, visibility].map(naive::inverse_nonstandard);
    let largest = |x: &[f64]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    (naive::product_integral(&[&l, &b, &v]), largest(&l) * largest(&b) * largest(&v))
}

#[test]
fn golden_triple_products() {
    for case in golden(HAAR_AFFINE, "products_2d")["triple"].as_array().unwrap() {
        let [l, v, r] = ["L", "V", "R"].map(|name| naive::forward_nonstandard(&image(&case[name])));
        let keep = indices(&case["truncated_L_keep_nonstandard"]);
        let truncated: Vec<f64> = (0..l.len()).map(|i| if keep.contains(&i) { l[i] } else { 0.0 }).collect();
        for (light, want) in [(&l, value(&case["triple"])), (&truncated, value(&case["triple_truncated_L"]))] {
            let (_, scale) = pixel_truth(light, &r, &v);
            for (route, got) in every_route::<f64>(light, &r, &v) {
                assert_close(got, want, 2e-14 * want.abs(), route);
            }
            for (route, got) in every_route::<f32>(light, &r, &v) {
                assert_close(got, want, 3e-7 * scale, route);
            }
        }
    }
}

#[test]
fn golden_n_fold_products() {
    fn check<T: Real>(case: &Value, tolerance: f64) {
        let maps: Vec<Vec<f64>> = case["maps"].as_array().unwrap().iter().map(image).collect();
        let trees: Vec<_> =
            maps.iter().map(|m| Quadtree::new(&sparse::<T>(&naive::forward_nonstandard(m))).unwrap()).collect();
        let trees: Vec<_> = trees.iter().collect();
        let mut product = NFoldProduct::new();
        let want = value(&case["integral"]);
        assert_close(product.integral(&trees), want, tolerance * want, "integral");
        let got = product.coefficients(&trees).to_dense();
        let want: Vec<f64> = case["product_nonstandard"].as_array().unwrap().iter().map(value).collect();
        assert_eq!(got.len(), want.len());
        let scale = want.iter().fold(0.0, |m: f64, w| m.max(w.abs()));
        for (i, (got, want)) in got.iter().zip(&want).enumerate() {
            assert_close(got.widen(), *want, tolerance * scale, &format!("coefficient {i}"));
        }
    }
    for case in golden(HAAR_AFFINE, "products_2d")["nfold"].as_array().unwrap() {
        check::<f64>(case, 2e-14);
        check::<f32>(case, 3e-7);
    }
}

/// Coefficients with random sparsity (empty and full included) over the given number.
fn coefficients(len: usize) -> impl Strategy<Value = Vec<f64>> {
    let density = prop_oneof![Just(0.0), Just(1.0), Just(1.0 / len as f64), 0.0..1.0f64];
    (density, prop::collection::vec((0.0..1.0f64, -1.0..1.0f64), len))
        .prop_map(|(density, all)| all.into_iter().map(|(p, c)| if p < density { c } else { 0.0 }).collect())
}

/// Nonstandard coefficients of a binary image with random coverage (none and all included).
fn binary(side: usize) -> impl Strategy<Value = Vec<f64>> {
    let coverage = prop_oneof![Just(0.0), Just(1.0), 0.0..1.0f64];
    (coverage, prop::collection::vec(0.0..1.0f64, side * side)).prop_map(|(coverage, all)| {
        naive::forward_nonstandard(&all.into_iter().map(|p| f64::from(u8::from(p < coverage))).collect::<Vec<_>>())
    })
}

fn triple(max_log: u32, factor: u32) -> impl Strategy<Value = [Vec<f64>; 3]> {
    (0..=max_log).prop_flat_map(move |log| {
        let side = 1usize << log;
        let v = if factor == 0 { binary(side).boxed() } else { coefficients(side * side).boxed() };
        (coefficients(side * side), coefficients(side * side), v).prop_map(|(l, b, v)| [l, b, v])
    })
}

fn agree<T: Real>([l, b, v]: &[Vec<f64>; 3], eps: f64) {
    let (want, scale) = pixel_truth(l, b, v);
    for (route, got) in every_route::<T>(l, b, v) {
        assert_close(got, want, eps * scale, &format!("{route}, side {}", l.len().isqrt()));
    }
}

proptest! {
    #![proptest_config(cases(48))]

    // Tolerances are relative to max|L| max|B| max|V|: every route adds, level by level, means of products of means,
    // each a few eps off. Measured: below 1e-15 in f64 and 4e-7 in f32 (the inputs' own rounding to f32 included).
    #[test]
    fn every_route_agrees_with_pixels(factors in triple(5, 1)) {
        agree::<f64>(&factors, 3e-15);
        agree::<f32>(&factors, 1e-6);
    }

    #[test]
    fn every_route_agrees_on_binary_visibility(factors in triple(5, 0)) {
        agree::<f64>(&factors, 3e-15);
        agree::<f32>(&factors, 1e-6);
    }

    #[test]
    fn every_route_agrees_with_the_triple_sum(factors in triple(2, 1)) {
        let [l, b, v] = &factors;
        let want = naive::triple_sum_2d(l, b, v);
        let (_, scale) = pixel_truth(&abs(l), &abs(b), &abs(v));
        for (route, got) in every_route::<f64>(l, b, v) {
            assert_close(got, want, 3e-14 * (scale + 1.0), route);
        }
    }

    #[test]
    fn routes_are_symmetric_in_their_factors([l, b, v] in triple(4, 1)) {
        let (_, scale) = pixel_truth(&l, &b, &v);
        let first = every_route::<f64>(&l, &b, &v);
        for order in [[&b, &l, &v], [&v, &b, &l], [&l, &v, &b]] {
            for (a, b) in first.iter().zip(every_route::<f64>(order[0], order[1], order[2])) {
                // V may be binary in one order only: then the bits come last and zip drops them.
                assert_close(b.1, a.1, 4e-15 * scale, a.0);
            }
        }
    }

    #[test]
    fn white_visibility_leaves_the_dot_product([l, b, _] in triple(5, 1)) {
        let mut white = vec![0.0; l.len()];
        white[0] = 1.0;
        let want: f64 = l.iter().zip(&b).map(|(l, b)| l * b).sum();
        let (_, scale) = pixel_truth(&l, &b, &white);
        let routes = every_route::<f64>(&l, &b, &white);
        prop_assert_eq!(routes.len(), 8);
        for (route, got) in routes {
            assert_close(got, want, 3e-15 * (scale + 1.0), route);
        }
    }

    #[test]
    fn huge_and_tiny_factors_scale_the_result([l, b, v] in triple(4, 1), power in -30..30i32) {
        // Powers of two commute with every rounding, so the result scales exactly.
        let s = 2f64.powi(power);
        let scaled: Vec<f64> = l.iter().map(|x| x * s).collect();
        let shrunk: Vec<f64> = b.iter().map(|x| x / (s * s)).collect();
        for (a, b) in every_route::<f64>(&l, &b, &v).iter().zip(every_route::<f64>(&scaled, &shrunk, &v)) {
            prop_assert_eq!(a.1 / s, b.1, "{}", a.0);
        }
    }

    #[test]
    fn masked_sums_agree_with_the_naive_sum(
        (x, y, words) in prop_oneof![0..130usize, Just(1024), Just(4096), 0..5000usize].prop_flat_map(|len| {
            let texels = prop::collection::vec(-1.0..1.0f64, len);
            let word = prop_oneof![Just(0), Just(!0u64), any::<u64>()];
            (texels.clone(), texels, prop::collection::vec(word, len.div_ceil(64)))
        })
    ) {
        let masked = MaskedSum::new();
        let products: Vec<f64> = x.iter().zip(&y).map(|(x, y)| x * y).collect();
        let all = vec![!0; words.len()];
        for (terms, words, wide, narrowed) in [
            (&x, &words, masked.sum(&x, &words), masked.sum(&narrow::<f32>(&x), &words)),
            (&products, &words, masked.dot(&x, &y, &words), masked.dot(&narrow::<f32>(&x), &narrow(&y), &words)),
            (&products, &all, masked.dot_unmasked(&x, &y), masked.dot_unmasked(&narrow::<f32>(&x), &narrow(&y))),
        ] {
            let (want, scale) = (naive::masked_sum(terms, words), naive::masked_sum(&abs(terms), words));
            assert_close(wide, want, 3e-15 * scale, "f64");
            // Narrowing x and y costs up to 2^-23 relative a term; the sums themselves less.
            assert_close(narrowed, want, 3e-7 * scale, "f32");
        }
        let squares: Vec<f64> = products.iter().zip(&y).map(|(p, y)| p * y).collect();
        let scale = naive::masked_sum(&abs(&squares), &all);
        assert_close(masked.dot_three(&x, &y, &y), naive::masked_sum(&squares, &all), 3e-15 * scale, "three");
        let [first, second] = masked.dots([&x, &y], &y, &words);
        assert_close(first, masked.dot(&x, &y, &words), 0.0, "first channel");
        assert_close(second, masked.dot(&y, &y, &words), 0.0, "second channel");
        let mut kept = vec![f64::NAN; x.len()];
        masked.mask(&x, &words, &mut kept);
        for (i, kept) in kept.into_iter().enumerate() {
            prop_assert_eq!(kept, if words[i / 64] >> (i % 64) & 1 == 1 { x[i] } else { 0.0 });
        }
    }

    #[test]
    fn pyramids_hold_the_means_of_their_pixels(
        (side, pixels) in (0..=5u32).prop_flat_map(|log| {
            let side = 1usize << log;
            let black_or_white = prop::collection::vec(prop_oneof![Just(0.0), Just(1.0f64)], side * side);
            (Just(side), black_or_white)
        })
    ) {
        let coefficients = naive::forward_nonstandard(&pixels);
        let trees = [
            MeanTree::from_pixels(side, [&pixels[..]]).unwrap(),
            MeanTree::from_coefficients(side, [&coefficients[..]]).unwrap(),
            MeanTree::from_sparse([&sparse::<f64>(&coefficients)]).unwrap(),
        ];
        let bits = BitPyramid::from_rows(side, &rows(&pixels)).unwrap();
        prop_assert_eq!(&BitPyramid::from_morton(side, bits.words()).unwrap(), &bits);
        let view = bits.view();
        let mut first = 0;
        for level in 0..=side.ilog2() {
            let across = 1usize << level;
            let means = naive::means(level, &pixels);
            for (i, want) in means.iter().enumerate() {
                let (x, y) = (i % across, i / across);
                for tree in &trees {
                    assert_close(tree.mean_at(level, x, y, 0), *want, 1e-14, "mean");
                }
                // The parent's record, found by the documented order of nodes.
                let morton = (0..level).fold(0, |m, b| m | (x >> b & 1) << (2 * b) | (y >> b & 1) << (2 * b + 1));
                let node = first + morton;
                let got = match node {
                    0 => f64::from(view.mean()),
                    _ => view.child_means::<f64>((node - 1) / 4)[(node - 1) % 4],
                };
                prop_assert_eq!(got, *want, "level {} at ({}, {})", level, x, y);
            }
            first += across * across;
        }
    }

    #[test]
    fn products_1d_agree_with_samples(
        (f, g) in (0..=6u32).prop_flat_map(|log| (coefficients(1 << log), coefficients(1 << log)))
    ) {
        let want = naive::product_1d(&[&f, &g]);
        let [mf, mg] = [&f, &g].map(|x| naive::inverse_1d(x).iter().fold(0.0, |m: f64, x| m.max(x.abs())));
        let plan = Product1d::new(f.len()).unwrap();
        let (mut out, mut scratch) = (vec![f64::NAN; f.len()], vec![f64::NAN; plan.scratch_len()]);
        plan.apply(&f, &g, &mut out, &mut scratch);
        let tree = multiply_sparse_1d(&sparse::<f64>(&f), &sparse(&g)).unwrap().to_dense();
        let narrow_tree = multiply_sparse_1d(&sparse::<f32>(&f), &sparse(&g)).unwrap().to_dense();
        let (mut out32, mut scratch32) = (vec![f32::NAN; f.len()], vec![f32::NAN; plan.scratch_len()]);
        plan.apply(&narrow(&f), &narrow(&g), &mut out32, &mut scratch32);
        for i in 0..f.len() {
            assert_close(out[i], want[i], 3e-15 * mf * mg, "dense f64");
            assert_close(tree[i], want[i], 3e-15 * mf * mg, "sparse f64");
            assert_close(out32[i].into(), want[i], 1e-6 * mf * mg, "dense f32");
            assert_close(narrow_tree[i].into(), want[i], 1e-6 * mf * mg, "sparse f32");
        }
    }

    #[test]
    fn products_2d_agree_with_texels(
        (f, g) in (0..=4u32).prop_flat_map(|log| (coefficients(1 << (2 * log)), coefficients(1 << (2 * log))))
    ) {
        let want = naive::product_2d(&[&f, &g]);
        let [mf, mg] = [&f, &g].map(|x| naive::inverse_nonstandard(x).iter().fold(0.0, |m: f64, x| m.max(x.abs())));
        let plan = Product2d::new(f.len().isqrt()).unwrap();
        let (mut out, mut scratch) = (vec![f64::NAN; f.len()], vec![f64::NAN; plan.scratch_len()]);
        plan.apply(&f, &g, &mut out, &mut scratch);
        let tree = multiply_sparse_2d(&sparse::<f64>(&f), &sparse(&g)).unwrap().to_dense();
        let (mut out32, mut scratch32) = (vec![f32::NAN; f.len()], vec![f32::NAN; plan.scratch_len()]);
        plan.apply(&narrow(&f), &narrow(&g), &mut out32, &mut scratch32);
        for i in 0..f.len() {
            assert_close(out[i], want[i], 3e-15 * mf * mg, "dense f64");
            assert_close(tree[i], want[i], 3e-15 * mf * mg, "sparse f64");
            assert_close(out32[i].into(), want[i], 1e-6 * mf * mg, "dense f32");
        }
    }

    #[test]
    fn n_fold_agrees_with_texels(
        factors in (0..=3u32, 1..7usize)
            .prop_flat_map(|(log, n)| prop::collection::vec(coefficients(1 << (2 * log)), n))
    ) {
        let refs: Vec<&[f64]> = factors.iter().map(Vec::as_slice).collect();
        let pixels: Vec<_> = factors.iter().map(|f| naive::inverse_nonstandard(f)).collect();
        let scale: f64 = pixels.iter().map(|p| p.iter().fold(0.0, |m: f64, x| m.max(x.abs()))).product();
        let want = naive::product_2d(&refs);
        let trees: Vec<_> = factors.iter().map(|f| Quadtree::new(&sparse::<f64>(f)).unwrap()).collect();
        let trees: Vec<_> = trees.iter().collect();
        let mut product = NFoldProduct::new();
        assert_close(product.integral(&trees), want[0], 4e-15 * scale, "integral");
        for (got, want) in product.coefficients(&trees).to_dense().iter().zip(want) {
            assert_close(*got, want, 4e-15 * scale, "coefficient");
        }
    }

    #[test]
    fn n_fold_1d_agrees_with_samples(
        factors in (0..=6u32, 1..6usize).prop_flat_map(|(log, n)| prop::collection::vec(coefficients(1 << log), n))
    ) {
        let refs: Vec<&[f64]> = factors.iter().map(Vec::as_slice).collect();
        let scale: f64 = factors
            .iter()
            .map(|f| naive::inverse_1d(f).iter().fold(0.0, |m: f64, x| m.max(x.abs())))
            .product();
        let want = naive::product_1d(&refs);
        let trees: Vec<_> = factors.iter().map(|f| BinaryTree::new(&sparse::<f64>(f)).unwrap()).collect();
        let trees: Vec<_> = trees.iter().collect();
        let mut product = NFoldProduct::new();
        assert_close(product.integral(&trees), want[0], 4e-15 * scale, "integral");
        for (got, want) in product.coefficients(&trees).to_dense().iter().zip(want) {
            assert_close(*got, want, 4e-15 * scale, "coefficient");
        }
    }

    #[test]
    fn an_rgb_light_is_three_lights([r, g, b] in triple(4, 1), brdf in any::<prop::sample::Index>(), v in 0..3usize) {
        let side = r.len().isqrt();
        let other = [&r, &g, &b][brdf.index(3)];
        let visibility = [&b, &r, &g][v];
        let channels = [&r, &g, &b].map(|c| sparse::<f64>(c));
        let rgb = Factor::new(channels.each_ref()).unwrap();
        let brdf = Factor::new([&sparse::<f64>(other)]).unwrap();
        let means = MeanTree::from_sparse([&sparse::<f64>(visibility)]).unwrap();
        let plan = TripleProduct::new(side).unwrap();
        for route in [Route::FlatMerge, Route::Pixels] {
            let got = plan.integral_by(route, &rgb, &brdf, Visibility::Means(&means));
            for (c, got) in [&r, &g, &b].into_iter().zip(got) {
                let (want, scale) = pixel_truth(c, other, visibility);
                assert_close(got, want, 3e-15 * scale, "channel");
            }
        }
    }
}

#[test]
fn one_hot_factors_give_the_tripling_coefficients() {
    for side in [1usize, 2, 4] {
        let n = side * side;
        let hot = |i: usize| (0..n).map(|j| f64::from(u8::from(i == j))).collect::<Vec<_>>();
        for_triples(n, |i, j, k| {
            let want = naive::tripling_2d(side, i, j, k);
            for (route, got) in every_route::<f64>(&hot(i), &hot(j), &hot(k)) {
                assert_eq!(got, want, "{route}: {i} {j} {k}");
            }
        });
    }
}

#[test]
fn side_64_agrees_on_binary_visibility() {
    let side = 64;
    let (mut l, mut b, mut stream) = (vec![0.0; side * side], vec![0.0; side * side], Stream::new(7));
    for _ in 0..200 {
        l[(stream.unit() * stream.unit() * 4096.0) as usize] = stream.unit() - 0.5;
        b[(stream.unit() * stream.unit() * 4096.0) as usize] = stream.unit() - 0.5;
    }
    let disk = |i: usize| ((i % side) as f64 - 30.0).hypot((i / side) as f64 - 20.0) < 22.0;
    let pixels: Vec<f64> = (0..side * side).map(|i| f64::from(u8::from(disk(i)))).collect();
    let [pl, pb] = [&l, &b].map(|c| naive::inverse_nonstandard(c));
    let want = naive::product_integral(&[&pl, &pb, &pixels]);
    let scale = naive::product_integral(&[&abs(&pl), &abs(&pb), &pixels]);
    let bits = BitPyramid::from_rows(side, &rows(&pixels)).unwrap();
    let plan = TripleProduct::new(side).unwrap();
    let (fl, fb) = (Factor::new([&sparse::<f64>(&l)]).unwrap(), Factor::new([&sparse::<f64>(&b)]).unwrap());
    let (fl32, fb32) = (Factor::new([&sparse::<f32>(&l)]).unwrap(), Factor::new([&sparse::<f32>(&b)]).unwrap());
    for route in [Route::FlatMerge, Route::Pixels] {
        let [got] = plan.integral_by(route, &fl, &fb, Visibility::from(&bits));
        assert_close(got, want, 3e-15 * scale, &format!("{route:?} f64"));
        let [got] = plan.integral_by(route, &fl32, &fb32, Visibility::from(&bits));
        assert_close(got, want, 1e-6 * scale, &format!("{route:?} f32"));
    }
}

#[test]
fn bad_shapes_are_refused() {
    let odd = SparseVector::<f32>::new(8, vec![1], vec![1.0]).unwrap();
    let empty = SparseVector::<f32>::new(0, vec![], vec![]).unwrap();
    let four = SparseVector::<f32>::new(4, vec![], vec![]).unwrap();
    for bad in [&odd, &empty] {
        assert!(Quadtree::new(bad).is_err() && NgTree::new(bad).is_err());
        assert!(Factor::new([bad]).is_err() && MeanTree::from_sparse([bad]).is_err());
        assert!(multiply_sparse_2d(bad, bad).is_err());
    }
    assert!(Factor::new([&four, &odd]).is_err() && multiply_sparse_2d(&four, &odd).is_err());
    for side in [0, 3, 1 << 15] {
        assert!(TripleProduct::new(side).is_err() && MeanTree::<f32>::zeros(side).is_err());
        assert!(BitPyramid::zeros(side).is_err());
    }
    for side in [0, 3] {
        assert!(Product1d::new(side).is_err() && Product2d::new(side).is_err());
    }
    assert!(BitPyramid::from_rows(8, &[0, 0]).is_err() && BitPyramid::from_morton(16, &[0]).is_err());
    assert!(MeanTree::from_pixels(2, [&[1.0f32][..]]).is_err());
    assert!(MeanTree::from_coefficients(2, [&[1.0f32][..]]).is_err());
}

#[test]
fn the_engine_counts_and_does_not_time() {
    let side = 64;
    let hot = |n: usize| (0..side * side).map(|i| f64::from(u8::from(i < n))).collect::<Vec<_>>();
    let open = vec![!0u64; 64];
    let mut corner = vec![0u64; 64];
    corner[0] = 0xff;
    let plan = TripleProduct::new(side).unwrap();
    let route = |n: usize, rows: &[u64]| {
        let factor = Factor::new([&sparse::<f32>(&hot(n))]).unwrap();
        let bits = BitPyramid::from_rows(side, rows).unwrap();
        plan.route(&factor, &factor, Visibility::from(&bits))
    };
    assert_eq!(route(4, &open), Route::FlatMerge);
    assert_eq!(route(4096, &open), Route::Pixels);
    // The same factors: few words are left to visit in the corner.
    assert_eq!(route(64, &open), Route::FlatMerge);
    assert_eq!(route(64, &corner), Route::Pixels);
}

#[test]
fn a_borrowed_pyramid_is_the_owned_one() {
    let rows: Vec<u64> = (0..16u64).map(|i| i.wrapping_mul(0x9e37_79b9_7f4a_7c15)).collect();
    let bits = BitPyramid::from_rows(32, &rows).unwrap();
    let (mut words, mut upper) = (vec![0; 16], vec![[0.0; 4]; BitPyramid::upper_len(32)]);
    BitPyramid::morton_from_rows(32, &rows, &mut words);
    BitPyramid::upper_from_words(32, &words, &mut upper);
    let view = BitPyramidRef::new(32, &words, &upper);
    assert_eq!((view.words(), view.upper()), (bits.words(), bits.upper()));
    let ones: u32 = rows.iter().map(|w| w.count_ones()).sum();
    assert_eq!(view.mean(), ones as f32 / 1024.0);
}

#[test]
fn nan_reaches_the_result() {
    let mut bad = vec![0.5; 64];
    bad[20] = f64::NAN;
    let good = vec![0.25; 64];
    for (route, got) in every_route::<f64>(&bad, &good, &good) {
        assert!(got.is_nan(), "{route}");
    }
}
