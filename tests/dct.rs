//! Block transforms, low-frequency projections and product integrals against golden values and the naive twins.
#![cfg(all(feature = "reference", feature = "proptest"))]

mod support;

use haarmonic::dct::{BlockDct, LowProjection, product_integral};
use haarmonic::numeric::CompensatedSum;
use haarmonic::reference::dct as twin;
use haarmonic::{Error, Real, dct, strategies};
use proptest::prelude::*;
use support::{HAAR_AFFINE, assert_close, cases, golden, narrow, norm, numbers, random, wide};

const SIDES: [usize; 5] = [4, 8, 16, 32, 64];

/// max |got − want| ≤ k·ε(T)·scale, with a floor for subnormal numbers; NaN fails.
#[track_caller]
fn assert_within<T: Real>(got: &[T], want: &[f64], k: f64, scale: f64) {
    assert_eq!(got.len(), want.len());
    let tolerance = k * T::epsilon().widen() * (scale + 16.0 * T::min_positive_value().widen());
    for (i, (g, w)) in got.iter().zip(want).enumerate() {
        let error = (g.widen() - w).abs();
        assert!(error <= tolerance, "[{i}]: got {g}, want {w}, error {error:e} > {tolerance:e}");
    }
}

/// A coefficient is a sum of n² products with a vector of norm one: some ε of the block's norm (measured: up to 1.9).
const ULPS: f64 = 4.0;

fn check_golden<T: Real>() {
    let file = golden(HAAR_AFFINE, "dct16");
    let (block, coefs) = (numbers(&file["block_yx"]), numbers(&file["coef_vu"]));
    let (scale, plan) = (norm(&block), BlockDct::<T>::new(16).unwrap());
    let mut out = vec![T::nan(); 256];
    plan.forward(&narrow(&block), &mut out);
    assert_within(&out, &coefs, ULPS, scale);
    plan.inverse(&narrow(&coefs), &mut out);
    assert_within(&out, &block, ULPS, scale);
    for case in file["lowfreq"].as_array().unwrap() {
        let low = case["l"].as_u64().unwrap() as usize;
        let samples = numbers(&case["samples_yx"]);
        let projection = LowProjection::<T>::centres(16, low).unwrap();
        assert_eq!(projection.positions(), numbers(&case["positions"]));
        let (want, mut got) = (numbers(&case["coef_vu"]), vec![T::nan(); low * low]);
        projection.project(&narrow(&samples), &mut got);
        assert_within(&got, &want, ULPS, norm(&want));
        // The sum over the block of block × projected function.
        let dot = product_integral(&got, &narrow(&coefs));
        assert_within(&[dot], &[case["dot_with_block_dct"].as_f64().unwrap()], ULPS, norm(&want) * scale);
    }
}

#[test]
fn golden_values_are_reproduced() {
    let file = golden(HAAR_AFFINE, "dct16");
    let (block, coefs) = (numbers(&file["block_yx"]), numbers(&file["coef_vu"]));
    for (got, want) in twin::forward(16, &block).iter().zip(&coefs) {
        assert_close(*got, *want, 1e-11, "twin");
    }
    for case in file["lowfreq"].as_array().unwrap() {
        let got = twin::project(16, &numbers(&case["positions"]), &numbers(&case["samples_yx"]));
        for (got, want) in got.iter().zip(numbers(&case["coef_vu"])) {
            assert_close(*got, want, 1e-13, "twin projection");
        }
    }
    check_golden::<f64>();
    check_golden::<f32>();
}

fn against_twin<T: Real>(side: usize, low: usize, samples: &[T]) {
    let (plan, source) = (BlockDct::<T>::new(side).unwrap(), wide(samples));
    let scale = norm(&source);
    let mut coefs = vec![T::nan(); low * low];
    plan.forward_low(low, samples, &mut coefs);
    assert_within(&coefs, &twin::forward(low, &source), ULPS, scale);
    let mut back = vec![T::nan(); side * side];
    plan.inverse_low(low, &coefs, &mut back);
    assert_within(&back, &twin::inverse(side, &wide(&coefs)), ULPS, scale);
    if low == side {
        assert_within(&back, &source, 2.0 * ULPS, scale);
    }
}

/// (side, low, samples), with the small sides that the O(n⁴) twin affords.
fn block<T: Real>() -> impl Strategy<Value = (usize, usize, Vec<T>)> {
    prop::sample::select(vec![4, 8, 16]).prop_flat_map(|side: usize| {
        let low = prop_oneof![1..=side, Just(side), Just(4)];
        (Just(side), low, strategies::signal(side * side))
    })
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn blocks_match_their_definition((n, l, x) in block::<f64>(), (m, k, y) in block::<f32>()) {
        against_twin(n, l, &x);
        against_twin(m, k, &y);
    }

    /// Σ C² = Σ f², Σ C_f C_g = Σ f g, and the transform is linear, at every side.
    #[test]
    fn parseval_and_linearity(
        (side, f, g) in prop::sample::select(SIDES.to_vec()).prop_flat_map(|n| {
            let unit = || prop::collection::vec(-1.0..1.0_f64, n * n);
            (Just(n), unit(), unit())
        }),
        a in -2.0..2.0_f64,
    ) {
        let (cf, cg) = (dct::forward(&f).unwrap(), dct::forward(&g).unwrap());
        let scale = norm(&f) * norm(&g);
        let sum: CompensatedSum = f.iter().zip(&g).map(|(f, g)| f * g).collect();
        assert_within(&[product_integral(&cf, &cg)], &[sum.total()], 2.0, scale);
        assert_within(&[product_integral(&cf, &cf)], &[norm(&f).powi(2)], 8.0, norm(&f).powi(2));
        let mixed: Vec<f64> = f.iter().zip(&g).map(|(f, g)| a * f + g).collect();
        let want: Vec<f64> = cf.iter().zip(&cg).map(|(f, g)| a * f + g).collect();
        assert_within(&dct::forward(&mixed).unwrap(), &want, 2.0, 2.0 * norm(&f) + norm(&g));
        assert_within(&dct::inverse(&cf).unwrap(), &f, 2.0, norm(&f));
        prop_assert_eq!(side * side, f.len());
    }

    /// Any positions that are accepted solve the equations they stand for.
    #[test]
    fn projections_solve_their_equations(
        (side, positions, samples) in (1usize..5, prop::sample::select(vec![4usize, 9, 16]))
            .prop_flat_map(|(l, n)| {
                let places = prop::collection::vec(-0.5..n as f64 - 0.5, l);
                (Just(n), places, prop::collection::vec(-1.0..1.0_f64, l * l))
            })
    ) {
        match LowProjection::<f64>::at(side, &positions) {
            Ok(plan) => {
                let mut got = vec![f64::NAN; samples.len()];
                plan.project(&samples, &mut got);
                if plan.condition() < 30.0 {
                    let want = twin::project(side, &positions, &samples);
                    // Both lose the condition of two axes.
                    assert_within(&got, &want, 8.0, plan.condition().powi(2) * norm(&want).max(norm(&samples)));
                }
            }
            Err(Error::OutOfRange { what: "condition number", got, .. }) => prop_assert!(got > 1e3),
            Err(other) => prop_assert!(false, "{other}"),
        }
    }

    /// The dot product of two coefficient squares is that of the smaller square.
    #[test]
    fn product_integrals_take_the_common_square(
        (l, m, a, b) in (1usize..9, 1usize..9).prop_flat_map(|(l, m)| {
            (Just(l), Just(m), strategies::signal::<f64>(l * l), strategies::signal::<f64>(m * m))
        })
    ) {
        let both = l.min(m);
        let pairs = (0..both * both).map(|i| (a[i / both * l + i % both], b[i / both * m + i % both]));
        let (a, b): (Vec<f64>, Vec<f64>) = pairs.unzip();
        let [most_a, most_b] = [&a, &b].map(|x| x.iter().fold(1.0_f64, |m, x| m.max(x.abs())));
        // Scaled, so that huge times huge is finite.
        let want: f64 = a.iter().zip(&b).map(|(a, b)| (a / most_a) * (b / most_b)).sum();
        let got = product_integral(&a.iter().map(|a| a / most_a).collect::<Vec<_>>(),
            &b.iter().map(|b| b / most_b).collect::<Vec<_>>());
        assert_within(&[got], &[want], 4.0, 64.0);
    }
}

/// Every basis function of the larger sides, which the O(n⁴) twin cannot afford: one coefficient, one product of
/// cosines.
#[test]
fn one_hot_coefficients_are_basis_functions() {
    for side in SIDES {
        let plan = BlockDct::<f64>::new(side).unwrap();
        for (v, u) in [(0, 0), (0, 1), (1, 0), (2, 3), (side / 2, 3), (side - 1, side - 2), (3, side - 1)] {
            let mut coefs = vec![0.0; side * side];
            coefs[v * side + u] = 1.0;
            let want: Vec<f64> = (0..side * side)
                .map(|i| twin::basis(side, v, (i / side) as f64) * twin::basis(side, u, (i % side) as f64))
                .collect();
            let mut got = vec![f64::NAN; side * side];
            plan.inverse(&coefs, &mut got);
            assert_within(&got, &want, 3.0, 1.0);
            plan.forward(&want, &mut got);
            assert_within(&got, &coefs, 3.0, 1.0);
        }
    }
}

/// The first coefficients alone are the first of all, and their inverse is that of the others being 0; f32 as f64.
fn low_is_part_of_all<T: Real>(side: usize) {
    let plan = BlockDct::<T>::new(side).unwrap();
    let block = narrow::<T>(&random(side * side, 1));
    let scale = norm(&wide(&block));
    let mut all = vec![T::nan(); side * side];
    plan.forward(&block, &mut all);
    for low in [1, 2, 3, 4, 5, 7, 8, 12, 16, 21, side - 1, side].into_iter().filter(|&low| low <= side) {
        let (mut few, mut kept) = (vec![T::nan(); low * low], vec![T::zero(); side * side]);
        plan.forward_low(low, &block, &mut few);
        let want: Vec<f64> = (0..low * low).map(|i| all[i / low * side + i % low].widen()).collect();
        assert_within(&few, &want, ULPS, scale);
        for i in 0..low * low {
            kept[i / low * side + i % low] = few[i];
        }
        let (mut from_all, mut from_few) = (vec![T::nan(); side * side], vec![T::nan(); side * side]);
        plan.inverse(&kept, &mut from_all);
        plan.inverse_low(low, &few, &mut from_few);
        assert_within(&from_few, &wide(&from_all), ULPS, scale);
    }
}

#[test]
fn low_frequencies_are_part_of_all() {
    for side in SIDES {
        low_is_part_of_all::<f64>(side);
        low_is_part_of_all::<f32>(side);
    }
}

/// Tiles of an image, blocks, batches, one by one and in parallel: the same bits; gaps between rows stay.
fn layouts_agree<T: Real>(side: usize, across: usize, down: usize, gap: usize, low: usize) {
    let (width, stride) = (across * side, across * side + gap);
    let count = across * down;
    let image = narrow::<T>(&random(down * side * stride, 1));
    let mut blocks = vec![T::zero(); count * side * side];
    for (i, pixel) in blocks.iter_mut().enumerate() {
        let (b, y, x) = (i / (side * side), i / side % side, i % side);
        *pixel = image[(b / across * side + y) * stride + b % across * side + x];
    }
    let (plan, tiles) = (BlockDct::<T>::new(side).unwrap(), BlockDct::<T>::tiles(side, width, stride).unwrap());
    let each = low * low;
    let mut want = vec![T::nan(); count * each];
    for (block, coefs) in blocks.chunks(side * side).zip(want.chunks_mut(each)) {
        plan.forward_low(low, block, coefs);
    }
    // The last row of an image may end at its width.
    let cut = image.len().saturating_sub(gap);
    let fresh = || vec![T::nan(); count * each];
    let [mut batch, mut parallel, mut tiled, mut tiled_parallel] = [fresh(), fresh(), fresh(), fresh()];
    plan.forward_low(low, &blocks, &mut batch);
    plan.forward_low_parallel(low, &blocks, &mut parallel);
    tiles.forward_low(low, &image[..cut], &mut tiled);
    tiles.forward_low_parallel(low, &image, &mut tiled_parallel);
    assert!([batch, parallel, tiled, tiled_parallel].iter().all(|got| *got == want));

    let mut want = vec![T::nan(); blocks.len()];
    let coefs = narrow::<T>(&random(count * each, 1));
    for (block, coefs) in want.chunks_mut(side * side).zip(coefs.chunks(each)) {
        plan.inverse_low(low, coefs, block);
    }
    let [mut batch, mut parallel] = [vec![T::nan(); blocks.len()], vec![T::nan(); blocks.len()]];
    plan.inverse_low(low, &coefs, &mut batch);
    plan.inverse_low_parallel(low, &coefs, &mut parallel);
    assert!(batch == want && parallel == want);
    let marker = T::of(-77.0);
    let [mut tiled, mut tiled_parallel] = [vec![marker; image.len()], vec![marker; cut]];
    tiles.inverse_low(low, &coefs, &mut tiled);
    tiles.inverse_low_parallel(low, &coefs, &mut tiled_parallel);
    assert!(tiled[..cut] == tiled_parallel[..]);
    for (i, pixel) in tiled.iter().enumerate() {
        let (y, x) = (i / stride, i % stride);
        let inside = (y / side * across + x / side) * side * side + y % side * side + x % side;
        assert!(*pixel == if x < width { want[inside] } else { marker }, "pixel {x}, {y}");
    }
}

#[test]
fn all_layouts_give_the_same_bits() {
    for (side, across, down, gap, low) in
        [(4, 1, 1, 0, 4), (4, 3, 2, 1, 2), (8, 2, 3, 5, 8), (16, 4, 24, 0, 4), (16, 3, 2, 7, 16), (32, 2, 1, 3, 9)]
    {
        layouts_agree::<f32>(side, across, down, gap, low);
        layouts_agree::<f64>(side, across, down, gap, low);
    }
    layouts_agree::<f32>(64, 2, 2, 64, 64);
}

#[test]
fn nothing_is_a_batch_and_bad_numbers_stay_in_their_block() {
    let plan = BlockDct::<f32>::new(16).unwrap();
    plan.forward(&[], &mut []);
    plan.inverse_low_parallel(4, &[], &mut []);
    BlockDct::<f32>::tiles(16, 48, 50).unwrap().forward(&[], &mut []);
    LowProjection::<f32>::centres(16, 4).unwrap().project(&[], &mut []);
    assert_eq!(product_integral::<f32>(&[], &[1.0]), 0.0);
    for bad in [f32::NAN, f32::INFINITY] {
        let mut blocks = narrow::<f32>(&random(3 * 256, 1));
        blocks[256 + 77] = bad;
        let mut coefs = vec![0.0; 3 * 256];
        plan.forward(&blocks, &mut coefs);
        assert!(coefs.iter().enumerate().all(|(i, c)| c.is_finite() == (i / 256 != 1)));
    }
    // Zero gives zero; the largest that fits is exact to rounding.
    let mut coefs = vec![f32::NAN; 256];
    plan.forward(&[0.0; 256], &mut coefs);
    assert!(coefs.iter().all(|&c| c == 0.0));
    plan.forward(&[f32::MAX / 32.0; 256], &mut coefs);
    assert!((coefs[0] / (f32::MAX / 2.0) - 1.0).abs() < 1e-6);
}

/// The figures of the docs: condition numbers of the sample positions, and that the best whole pixels are the best.
#[test]
fn condition_numbers_are_as_documented() {
    for side in [4, 8, 15, 16, 64] {
        for low in [1, 2, 3, 4].into_iter().filter(|&l| l <= side) {
            let centres = LowProjection::<f64>::centres(side, low).unwrap();
            let solved = LowProjection::<f64>::at(side, centres.positions()).unwrap();
            assert_close(solved.condition(), 1.0, 1e-14, "centres");
            let samples = random(low * low, 1);
            let [mut a, mut b] = [vec![0.0; low * low], vec![0.0; low * low]];
            centres.project(&samples, &mut a);
            solved.project(&samples, &mut b);
            assert_within(&a, &b, 8.0, side as f64);
        }
    }
    let condition =
        |positions: &[f64]| LowProjection::<f64>::at(16, positions).map_or(f64::INFINITY, |p| p.condition());
    // Two places, as the docs quote them; the square is that of the whole solve.
    assert_close(condition(&[3.0, 12.0]), 1.093, 5e-4, "l = 2");
    assert_close(condition(&[1.0, 6.0, 10.0, 14.0]), 1.321, 5e-4, "l = 4");
    // The samples that the print names, with the right basis.
    assert_close(condition(&[0.0, 8.0]), 2.114, 5e-4, "multiples of n/2");
    assert_close(condition(&[0.0, 4.0, 8.0, 12.0]), 2.517, 5e-4, "multiples of n/4");
    // No other pixels are better.
    let (mut best_of_two, mut best_of_four) = (f64::INFINITY, f64::INFINITY);
    for set in 0u32..1 << 16 {
        if let 2 | 4 = set.count_ones() {
            let pixels: Vec<f64> = (0..16).filter(|i| set >> i & 1 == 1).map(f64::from).collect();
            let best = if pixels.len() == 2 { &mut best_of_two } else { &mut best_of_four };
            *best = best.min(condition(&pixels));
        }
    }
    assert_close(condition(&[3.0, 12.0]), best_of_two, 1e-12, "the best two");
    assert_close(condition(&[1.0, 6.0, 10.0, 14.0]), best_of_four, 1e-12, "the best four");
}

#[test]
fn impossible_plans_are_refused() {
    for side in [0, 3, 12] {
        assert_eq!(BlockDct::<f64>::new(side).unwrap_err(), Error::NotPowerOfTwo { what: "block side", got: side });
    }
    for side in [1, 2, 128] {
        assert!(matches!(BlockDct::<f32>::new(side), Err(Error::OutOfRange { got, .. }) if got == side as f64));
    }
    for (width, stride) in [(0, 16), (24, 24), (32, 31), (32, usize::MAX)] {
        assert!(matches!(BlockDct::<f32>::tiles(16, width, stride), Err(Error::OutOfRange { .. })), "{width} {stride}");
    }
    assert!(matches!(dct::forward(&[0.0; 15]), Err(Error::Length { got: 15, .. })));
    for (side, low) in [(0, 0), (16, 0), (16, 17), (1 << 17, 4), (128, 65)] {
        assert!(matches!(LowProjection::<f32>::centres(side, low), Err(Error::OutOfRange { .. })));
    }
    for positions in [&[3.0, 3.0][..], &[-0.6], &[16.0, 2.0], &[f64::NAN, 2.0], &[]] {
        assert!(LowProjection::<f64>::at(16, positions).is_err(), "{positions:?}");
    }
}

fn panics(f: impl FnOnce() + std::panic::UnwindSafe) -> bool {
    std::panic::catch_unwind(f).is_err()
}

#[test]
fn wrong_lengths_panic() {
    let plan = || BlockDct::<f32>::new(4).unwrap();
    let tiles = || BlockDct::<f32>::tiles(4, 8, 10).unwrap();
    assert!(panics(|| plan().forward(&[0.0; 16], &mut [0.0; 15])));
    assert!(panics(|| plan().forward(&[0.0; 32], &mut [0.0; 16])));
    assert!(panics(|| plan().forward_low(0, &[0.0; 16], &mut [])));
    assert!(panics(|| plan().forward_low(5, &[0.0; 16], &mut [0.0; 25])));
    assert!(panics(|| plan().inverse_low(2, &[0.0; 5], &mut [0.0; 16])));
    assert!(panics(|| tiles().forward(&[0.0; 37], &mut [0.0; 32])));
    assert!(panics(|| tiles().forward(&[0.0; 41], &mut [0.0; 32])));
    assert!(panics(|| tiles().forward(&[0.0; 40], &mut [0.0; 16])));
    assert!(panics(|| {
        product_integral(&[0.0; 4], &[0.0; 3]);
    }));
    assert!(panics(|| LowProjection::<f32>::centres(16, 2).unwrap().project(&[0.0; 3], &mut [0.0; 3])));
    // The lengths beside them are right.
    tiles().forward(&[0.0; 38], &mut [0.0; 32]);
    tiles().forward(&[0.0; 40], &mut [0.0; 32]);
}
