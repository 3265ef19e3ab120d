//! Tables of affine couplings: M in a texture, stored couplings, predicted targets, and the law of the number of
//! non-zeros.

use haarmonic::Error;
use haarmonic::affine::{
    AffineMap, CanonicalTable, Filter, Heuristic, MapGrid, Mother, NearestMap, Nonzeros1d, Prediction, Quantisation,
    StoredCouplings, canonical, coupling_1d, coupling_nonstandard, coupling_standard, mean_squares_1d, mean_squares_2d,
};
use haarmonic::haar::{Decomposition, Keep, forward_1d, forward_2d};
use proptest::prelude::*;

use crate::support::cases;

fn exact(r: f64, c: f64) -> f64 {
    canonical(Mother::Wavelet, Mother::Wavelet, r, c)
}

/// Pairs that fill the unit square evenly.
fn pair(k: usize) -> [f64; 2] {
    let k = k as f64 + 0.5;
    [(k * 0.754_877_666_246_692_8).fract(), (k * 0.569_840_290_998_053_3).fract()]
}

/// A map of the grid's scales with something of the signal in sight.
fn visible(scales: [f64; 2], [u, v]: [f64; 2]) -> AffineMap {
    let s = scales[0] * (scales[1] / scales[0]).powf(u);
    AffineMap::new(s, v * (1.0 + s.abs()) - s.max(0.0)).unwrap()
}

/// A light with a gradient, two discs and noise.
fn textured(side: usize, seed: usize) -> Vec<f64> {
    let [a, b] = pair(7919 * (seed + 1));
    let texel = |i: usize| {
        let [x, y] = [i % side, i / side].map(|c| (c as f64 + 0.5) / side as f64);
        let disc = |cx: f64, cy: f64, r: f64| f64::from(u8::from((x - cx).hypot(y - cy) < r));
        0.3 + 0.5 * (a * x + b * y) + 2.0 * disc(a, b, 0.2) + disc(b, 1.0 - a, 0.12) + 0.15 * pair(seed * 4096 + i)[0]
    };
    (0..side * side).map(texel).collect()
}

// --- M in a texture
// -------------------------------------------------------------------------------------------------------------------

/// What a texture unit does, from the bytes and the documented addressing alone.
fn sampled(table: &CanonicalTable, r: f64, c: f64) -> f64 {
    let (n, w, h) = (table.resolution() as f64, table.width(), table.height());
    let bytes = table.texels();
    let texel = |x: f64, y: f64| {
        let (x, y) = (x.clamp(0.0, (w - 1) as f64) as usize, y.clamp(0.0, (h - 1) as f64) as usize);
        let i = y * w + x;
        let [scale, bias] = table.quantisation().decoding();
        let word = || [bytes[2 * i], bytes[2 * i + 1]];
        let t = match table.quantisation() {
            Quantisation::Unorm8 => f64::from(bytes[i]) / 255.0,
            Quantisation::Snorm8 => f64::from(bytes[i] as i8) / 127.0,
            Quantisation::Unorm16 => f64::from(u16::from_le_bytes(word())) / 65535.0,
            Quantisation::Snorm16 => f64::from(i16::from_le_bytes(word())) / 32767.0,
            Quantisation::F32 => f64::from(f32::from_le_bytes(bytes[4 * i..4 * i + 4].try_into().unwrap())),
        };
        scale * t + bias
    };
    let u = ((c + 0.5) * n + 0.5) / (n + 1.0);
    let v = (r * n + 0.5) / (n / 2.0 + 1.0);
    let (x, y) = (u * w as f64 - 0.5, v * h as f64 - 0.5);
    let (a, b) = (x - x.floor(), y - y.floor());
    let row = |y: f64| (1.0 - a) * texel(x.floor(), y) + a * texel(x.floor() + 1.0, y);
    (1.0 - b) * row(y.floor()) + b * row(y.floor() + 1.0)
}

#[test]
fn a_lookup_is_what_a_texture_unit_reads() {
    for quantisation in Quantisation::ALL {
        let table = CanonicalTable::new(20, quantisation).unwrap();
        assert_eq!(table.texels().len(), table.bytes());
        assert_eq!(table.bytes(), 21 * 11 * quantisation.bytes());
        for k in 0..2000 {
            let [u, v] = pair(k);
            let (r, c) = (0.5 * u, v - 0.5);
            // Coordinates of some 20 texels round by 1e-15 or so, at slopes up to 3.
            let difference = table.lookup(r, c) - sampled(&table, r, c);
            assert!(difference.abs() < 1e-13, "{quantisation:?} {r} {c}: {difference}");
        }
    }
}

#[test]
fn texels_hold_m_and_zero_exactly() {
    for quantisation in Quantisation::ALL {
        let step = match quantisation {
            Quantisation::Unorm8 => 0.75 / 255.0,
            Quantisation::Snorm8 => 0.5 / 127.0,
            Quantisation::Unorm16 => 0.75 / 65535.0,
            Quantisation::Snorm16 => 0.5 / 32767.0,
            Quantisation::F32 => 0.0,
        };
        let table = CanonicalTable::new(16, quantisation).unwrap();
        let mut most = 0.0f64;
        for y in 0..=8 {
            for x in 0..=16 {
                let (r, c) = (f64::from(y) / 16.0, f64::from(x) / 16.0 - 0.5);
                let error = table.lookup(r, c) - exact(r, c);
                most = most.max(error.abs());
                assert!(exact(r, c) != 0.0 || error == 0.0, "{quantisation:?} {r} {c}: {error}");
            }
        }
        assert!(most <= step * (1.0 + 1e-12) && most >= 0.5 * step, "{quantisation:?}: {most}");
    }
}

/// The figures of the docstring, in units of 10⁻³: maximum and RMS of F32, Unorm16, Snorm16, Unorm8, Snorm8.
#[test]
fn errors_are_as_documented() {
    let documented = [
        (64, [[7.80, 0.558], [7.80, 0.558], [7.80, 0.557], [8.66, 1.10], [7.86, 1.71]]),
        (128, [[3.83, 0.197], [3.83, 0.197], [3.83, 0.197], [5.04, 0.971], [5.41, 1.68]]),
        (256, [[1.92, 0.070], [1.91, 0.070], [1.92, 0.070], [3.17, 0.952], [3.93, 1.41]]),
        (512, [[0.965, 0.0247], [0.967, 0.0248], [0.965, 0.0248], [2.94, 0.952], [3.84, 1.31]]),
    ];
    let quantisations =
        [Quantisation::F32, Quantisation::Unorm16, Quantisation::Snorm16, Quantisation::Unorm8, Quantisation::Snorm8];
    for (n, figures) in documented {
        for (quantisation, [most, rms]) in quantisations.into_iter().zip(figures) {
            let measured = errors(&CanonicalTable::new(n, quantisation).unwrap(), 200_000);
            // 200,000 samples may miss the worst place by some per cent, and their RMS varies by one or two.
            let within = |got: f64, stated: f64, slack: f64| (got / stated - 1.0).abs() < slack;
            let [got_most, got_rms] = measured.map(|e| 1e3 * e);
            assert!(within(got_most, most, 0.05), "{n} {quantisation:?}: max {got_most}, stated {most}");
            assert!(within(got_rms, rms, 0.03), "{n} {quantisation:?}: RMS {got_rms}, stated {rms}");
        }
        // Derived: a quarter of the jump in slope, 2, a step.
        let [most, _] = errors(&CanonicalTable::new(n, Quantisation::F32).unwrap(), 60_000);
        assert!(most <= 0.5 / n as f64 * (1.0 + 1e-6), "{n}: {most}");
        let nearest = CanonicalTable::new(n, Quantisation::F32).unwrap().with_filter(Filter::Nearest);
        let [most, rms] = errors(&nearest, 60_000);
        assert!((1.9..2.001).contains(&(most * n as f64)) && (0.56..0.6).contains(&(rms * n as f64)), "{most} {rms}");
        let hardware = CanonicalTable::new(n, Quantisation::F32).unwrap().with_filter(Filter::LinearFixed(8));
        let [fixed, _] = errors(&hardware, 60_000);
        assert!((0.9..1.1).contains(&(fixed * 2.0 * n as f64)), "{fixed}");
    }
}

/// Largest and RMS error where the stored quarter is not zero.
fn errors(table: &CanonicalTable, samples: usize) -> [f64; 2] {
    let (mut most, mut sum, mut count) = (0.0f64, 0.0, 0);
    for k in 0..samples {
        let [u, v] = pair(k);
        let (r, c) = (0.5 * u, v - 0.5);
        if c >= -r {
            let error = table.lookup(r, c) - exact(r, c);
            most = most.max(error.abs());
            sum += error * error;
            count += 1;
        }
    }
    [most, (sum / f64::from(count)).sqrt()]
}

#[test]
fn symmetries_fold_everything_into_the_quarter() {
    let table = CanonicalTable::new(128, Quantisation::F32).unwrap();
    for k in 0..4000 {
        let [u, v] = pair(k);
        let (r, c) = (0.01 * 800f64.powf(u), 12.0 * v - 5.5);
        let error = (table.lookup(r, c) - exact(r, c)).abs();
        // 1/(2n), times 2r where the point was folded from r > ½.
        assert!(error <= (2.0 * r).max(1.0) * 0.5 / 128.0 * (1.0 + 1e-9), "{r} {c}: {error}");
        assert_eq!(table.lookup(-r, c), -table.lookup(r, c));
        assert!((table.lookup(r, 1.0 - c) - table.lookup(r, c)).abs() < 1e-12 * (1.0 + r));
    }
}

#[test]
fn odd_arguments_of_a_table() {
    for n in [0, 2, 6, 8196] {
        assert!(matches!(CanonicalTable::new(n, Quantisation::F32), Err(Error::OutOfRange { .. })), "{n}");
    }
    let smallest = CanonicalTable::new(4, Quantisation::F32).unwrap();
    assert_eq!((smallest.width(), smallest.height()), (5, 3));
    assert_eq!(smallest.lookup(0.5, 0.5), 1.0);
    for filter in [Filter::Nearest, Filter::Linear, Filter::LinearFixed(0), Filter::LinearFixed(u32::MAX)] {
        let table = smallest.clone().with_filter(filter);
        assert_eq!(table.lookup(0.0, 0.3), 0.0);
        assert_eq!(table.lookup(-0.0, 0.3), 0.0);
        assert_eq!(table.lookup(0.3, 1e300), 0.0);
        assert_eq!(table.lookup(0.3, f64::NEG_INFINITY), 0.0);
        assert!(table.lookup(f64::NAN, 0.5).is_nan() && table.lookup(0.5, f64::NAN).is_nan());
        assert!(table.lookup(f64::INFINITY, 0.5).is_nan());
    }
}

// --- The grid of maps
// -----------------------------------------------------------------------------------------------------------------

#[test]
fn a_cell_is_nearest_to_its_own_map() {
    for scales in [[0.25, 4.0], [-3.0, -0.1], [1e-3, 1.0]] {
        let grid = MapGrid::new(scales, [7, 11]).unwrap();
        for scale in 0..7 {
            for offset in 0..11 {
                assert_eq!(grid.nearest(grid.map(scale, offset)), NearestMap::Cell { scale, offset });
            }
        }
        let outside = AffineMap::new(scales[0] - 1e-4 * scales[0].abs(), 0.1).unwrap();
        assert_eq!(grid.nearest(outside), NearestMap::Outside);
    }
    for (scales, resolution) in [
        ([1.0, 1.0], [1, 1]),
        ([-1.0, 1.0], [1, 1]),
        ([2.0, 1.0], [1, 1]),
        ([1.0, 2.0], [0, 1]),
        ([1.0, 2.0], [1, 65537]),
    ] {
        assert!(matches!(MapGrid::new(scales, resolution), Err(Error::OutOfRange { .. })), "{scales:?} {resolution:?}");
    }
    assert!(MapGrid::new([f64::NAN, 1.0], [1, 1]).is_err());
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn dark_maps_are_those_without_couplings(s in 0.1f64..5.0, o in -6.0f64..6.0, mirrored: bool) {
        let grid = if mirrored { MapGrid::new([-5.0, -0.1], [4, 4]) } else { MapGrid::new([0.1, 5.0], [4, 4]) }.unwrap();
        let map = AffineMap::new(if mirrored { -s } else { s }, o).unwrap();
        let count = Nonzeros1d::new(16).unwrap().count(map);
        prop_assert_eq!(grid.nearest(map) == NearestMap::Dark, count == 0);
    }
}

// --- Stored couplings
// -----------------------------------------------------------------------------------------------------------------

#[test]
fn stored_rows_are_the_couplings_of_the_cell() {
    for (size, scales) in [(1, [0.5, 2.0]), (2, [-2.0, -0.5]), (32, [0.25, 4.0]), (256, [-1.5, -0.5])] {
        let grid = MapGrid::new(scales, [3, 4]).unwrap();
        let stored = StoredCouplings::new(size, grid, 1 << 24).unwrap();
        let nonzeros = Nonzeros1d::new(size).unwrap();
        let mut total = 0;
        for scale in 0..3 {
            for offset in 0..4 {
                let map = grid.map(scale, offset);
                let operator = stored.operator(map).unwrap();
                for i in 0..size {
                    let mut expected: Vec<(u8, f32)> = Vec::new();
                    nonzeros.row(i, map, |j, d| expected.push((j as u8, d as f32)));
                    let (targets, values) = operator.row(i);
                    let got: Vec<(u8, f32)> = targets.iter().copied().zip(values.iter().copied()).collect();
                    assert_eq!(got, expected);
                    total += got.len();
                }
                if size <= 32 {
                    check_against_dense(&stored, map);
                }
            }
        }
        assert_eq!(stored.nonzeros(), total);
        assert_eq!(stored.bytes(), 5 * total + 12 * 2 * (size + 1) + 3 * 5 * 4);
    }
}

/// The sum over all couplings, zero or not, one by one.
fn check_against_dense(stored: &StoredCouplings, map: AffineMap) {
    let size = stored.size();
    let source: Vec<f32> = (0..size).map(|i| pair(i)[0] as f32 - 0.5).collect();
    let mut target = vec![1.0f32; size];
    stored.operator(map).unwrap().add_to(&source, &mut target);
    for (j, &got) in target.iter().enumerate() {
        let sum: f64 = (0..size).map(|i| f64::from(source[i]) * coupling_1d(i, j, map)).sum();
        // Fewer than 32 terms of magnitude 1, each product and sum rounded to f32.
        assert!((f64::from(got) - 1.0 - sum).abs() < 4e-6, "{j}: {got} against {sum}");
    }
}

#[test]
fn maps_beyond_the_stored_ones() {
    let stored = StoredCouplings::new(8, MapGrid::new([0.5, 2.0], [2, 2]).unwrap(), 1 << 16).unwrap();
    assert_eq!(stored.operator(AffineMap::new(2.1, 0.0).unwrap()), None);
    assert_eq!(stored.operator(AffineMap::new(-1.0, 0.5).unwrap()), None);
    let dark = stored.operator(AffineMap::new(1.0, 1.5).unwrap()).unwrap();
    assert_eq!((dark.nonzeros(), dark.row(7)), (0, (&[][..], &[][..])));
}

#[test]
fn stored_couplings_stay_within_their_limit() {
    let grid = MapGrid::new([0.25, 4.0], [8, 8]).unwrap();
    let bytes = StoredCouplings::new(16, grid, usize::MAX).unwrap().bytes();
    assert!(StoredCouplings::new(16, grid, bytes).is_ok());
    assert!(matches!(StoredCouplings::new(16, grid, bytes - 1), Err(Error::OutOfRange { .. })));
    assert!(matches!(StoredCouplings::new(16, grid, 0), Err(Error::OutOfRange { .. })));
    assert!(matches!(StoredCouplings::new(12, grid, bytes), Err(Error::NotPowerOfTwo { got: 12, .. })));
    assert!(matches!(StoredCouplings::new(0, grid, bytes), Err(Error::NotPowerOfTwo { .. })));
    assert!(matches!(StoredCouplings::new(512, grid, bytes), Err(Error::OutOfRange { .. })));
}

#[test]
fn any_number_of_threads_stores_and_predicts_the_same() {
    let grid = MapGrid::new([0.25, 4.0], [9, 10]).unwrap();
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let keep = Keep::Fraction(0.4);
            let prediction = Prediction::<1>::new(16, Heuristic::Constant, grid, keep).unwrap().with_union(1);
            prediction.fill();
            (StoredCouplings::new(16, grid, 1 << 20).unwrap(), prediction)
        })
    };
    let ((one, few), (three, many)) = (build(1), build(3));
    assert!(one == three);
    assert_eq!(few.bytes(), many.bytes());
    for k in 0..200 {
        let map = visible(grid.scales(), pair(k));
        assert_eq!(few.targets([map]), many.targets([map]));
    }
}

/// The docstring's errors of the nearest entry, which halve with the step.
#[test]
fn the_nearest_entry_costs_what_is_documented() {
    let scales = [0.25, 4.0];
    let nonzeros = Nonzeros1d::new(32).unwrap();
    let lights: Vec<Vec<f64>> = (0..6).map(|seed| forward_1d(&textured(32, seed)[13 * 32..][..32]).unwrap()).collect();
    let transform = |light: &[f64], map: AffineMap| {
        let mut target = vec![0.0; 32];
        nonzeros.all(map, |i, j, d| target[j] += light[i] * d);
        target
    };
    for (cells, stated) in [(64, 0.145), (256, 0.035), (1024, 0.0087)] {
        let grid = MapGrid::new(scales, [cells; 2]).unwrap();
        let error = |k: usize| {
            let (map, light) = (visible(scales, pair(k)), &lights[k % 6]);
            let NearestMap::Cell { scale, offset } = grid.nearest(map) else { panic!("in sight") };
            let (exact, near) = (transform(light, map), transform(light, grid.map(scale, offset)));
            let difference: f64 = exact.iter().zip(&near).map(|(a, b)| (a - b).powi(2)).sum();
            (difference / exact.iter().map(|a| a * a).sum::<f64>()).sqrt()
        };
        let mean = (0..300).map(error).sum::<f64>() / 300.0;
        assert!((0.7..1.4).contains(&(mean / stated)), "{cells}: {mean}, stated {stated}");
    }
}

// --- Predicted targets
// ----------------------------------------------------------------------------------------------------------------

/// The φ of a light has two edges, each in one wavelet a level: 1 + 1 + 2·4 of 32.
#[test]
fn a_constant_light_reaches_ten_targets_an_axis() {
    let grid = MapGrid::new([0.25, 4.0], [16, 32]).unwrap();
    let one = Prediction::<1>::new(32, Heuristic::Constant, grid, Keep::Fraction(1.0)).unwrap();
    let two =
        Prediction::<2>::new(32, Decomposition::Standard, Heuristic::Constant, grid, Keep::Fraction(1.0)).unwrap();
    let counts = |k: usize| {
        let [x, y] = [visible(grid.scales(), pair(k)), visible(grid.scales(), [pair(k)[0], pair(k + 9999)[1]])];
        [one.targets([x]).len(), two.targets([x, y]).len()]
    };
    let most = (0..4000).map(counts).fold([0, 0], |most, n| [most[0].max(n[0]), most[1].max(n[1])]);
    assert_eq!(most, [10, 100]);
    let wide = two.with_union(1);
    let shares = (0..300).map(|k| {
        let [u, v] = pair(k);
        let (x, y) = (visible(grid.scales(), [u, v]), visible(grid.scales(), [u, pair(k + 777)[1]]));
        wide.targets([x, y]).len() as f64 / 1024.0
    });
    let mean = shares.sum::<f64>() / 300.0;
    assert!((0.1..0.3).contains(&mean), "{mean}");
}

/// Checks that the chosen targets are the best of all by scores computed one by one.
fn check_choice(chosen: &[u32], scores: &[f64], keep: usize) {
    assert!(chosen.windows(2).all(|w| w[0] < w[1]));
    let top = scores.iter().copied().fold(0.0, f64::max);
    let worth = scores.iter().filter(|s| **s > 1e-20 * top).count();
    assert_eq!(chosen.len(), keep.min(worth));
    let inside = |k: usize| chosen.binary_search(&(k as u32)).is_ok();
    let least = chosen.iter().map(|&k| scores[k as usize]).fold(f64::INFINITY, f64::min);
    let missed = (0..scores.len()).filter(|k| !inside(*k)).map(|k| scores[k]).fold(0.0, f64::max);
    // Equal scores may be rounded apart.
    assert!(least >= missed * (1.0 - 1e-9), "{least} kept, {missed} missed");
}

#[test]
fn predictions_are_the_largest_of_all_scores() {
    const N: usize = 8;
    let grid = MapGrid::new([0.5, 2.0], [2, 3]).unwrap();
    let keep = Keep::Terms(9);
    for decomposition in [Decomposition::Standard, Decomposition::Nonstandard] {
        let light = forward_2d(&textured(N, 3), N, N, decomposition).unwrap();
        let squares = mean_squares_2d(N, decomposition, &[&light]).unwrap();
        let powers = [
            Prediction::<2>::new(N, decomposition, Heuristic::Constant, grid, keep).unwrap(),
            Prediction::<2>::new(N, decomposition, Heuristic::Light(&light), grid, keep).unwrap(),
            Prediction::<2>::new(N, decomposition, Heuristic::Power(&squares), grid, keep).unwrap(),
        ];
        for (scale, x, y) in [(0, 0, 2), (1, 1, 1), (1, 2, 0)] {
            let maps = [grid.map(scale, x), grid.map(scale, y)];
            let d = |i: usize, k: usize| match decomposition {
                Decomposition::Standard => coupling_standard([i % N, i / N], [k % N, k / N], maps),
                Decomposition::Nonstandard => coupling_nonstandard(i, k, maps),
            };
            let score = |which: usize, k: usize| match which {
                0 => d(0, k).powi(2),
                1 => (0..N * N).map(|i| light[i] * d(i, k)).sum::<f64>().powi(2),
                _ => (0..N * N).map(|i| squares[i] * d(i, k).powi(2)).sum(),
            };
            for (which, prediction) in powers.iter().enumerate() {
                let scores: Vec<f64> = (0..N * N).map(|k| score(which, k)).collect();
                check_choice(prediction.targets(maps), &scores, 9);
            }
        }
    }
}

#[test]
fn samples_are_averaged_and_neighbours_united() {
    let grid = MapGrid::new([0.5, 2.0], [3, 5]).unwrap();
    let light = forward_1d(&textured(16, 1)[..16]).unwrap();
    let new = |samples| {
        Prediction::<1>::new(16, Heuristic::Light(&light), grid, Keep::Terms(5)).unwrap().with_samples(samples)
    };
    // A grid twice as fine has its centres at the samples.
    let fine = MapGrid::new([0.5, 2.0], [6, 10]).unwrap();
    let (sampled, plain) = (new(2), new(1));
    let united = new(1).with_union(1);
    for scale in 0..3 {
        for offset in 0..5 {
            let scores: Vec<f64> = (0..16)
                .map(|k| {
                    let power = |map| (0..16).map(|i| light[i] * coupling_1d(i, k, map)).sum::<f64>().powi(2);
                    (0..4).map(|q| power(fine.map(2 * scale + q % 2, 2 * offset + q / 2))).sum()
                })
                .collect();
            let map = grid.map(scale, offset);
            check_choice(sampled.targets([map]), &scores, 5);
            let mut union: Vec<u32> = Vec::new();
            for s in scale.saturating_sub(1)..=(scale + 1).min(2) {
                for o in offset.saturating_sub(1)..=(offset + 1).min(4) {
                    union.extend(plain.targets([grid.map(s, o)]));
                }
            }
            union.sort_unstable();
            union.dedup();
            assert_eq!(united.targets([map]), union);
        }
    }
}

#[test]
fn a_union_in_the_plane_is_of_27_cells() {
    let grid = MapGrid::new([0.5, 2.0], [4, 5]).unwrap();
    let new = || Prediction::<2>::new(8, Decomposition::Standard, Heuristic::Constant, grid, Keep::Terms(6)).unwrap();
    let (plain, united) = (new(), new().with_union(1));
    for [scale, x, y] in [[0, 0, 0], [2, 2, 1], [3, 4, 4], [1, 0, 3]] {
        let near = |at: usize, count: usize| at.saturating_sub(1)..=(at + 1).min(count - 1);
        let mut union: Vec<u32> = Vec::new();
        for s in near(scale, 4) {
            for ox in near(x, 5) {
                for oy in near(y, 5) {
                    union.extend(plain.targets([grid.map(s, ox), grid.map(s, oy)]));
                }
            }
        }
        union.sort_unstable();
        union.dedup();
        assert_eq!(united.targets([grid.map(scale, x), grid.map(scale, y)]), union);
    }
}

#[test]
fn odd_predictions() {
    let grid = MapGrid::new([0.5, 2.0], [2, 2]).unwrap();
    let new = |size, heuristic, keep| Prediction::<1>::new(size, heuristic, grid, keep);
    let map = AffineMap::new(1.0, 0.2).unwrap();
    assert_eq!(new(1, Heuristic::Constant, Keep::Fraction(1.0)).unwrap().targets([map]), [0]);
    assert!(new(8, Heuristic::Constant, Keep::Terms(0)).unwrap().targets([map]).is_empty());
    assert!(new(8, Heuristic::Light(&[0.0; 8]), Keep::Terms(8)).unwrap().targets([map]).is_empty());
    let dark = AffineMap::new(1.0, 1.0).unwrap();
    let all = new(8, Heuristic::Constant, Keep::Terms(8)).unwrap().with_union(usize::MAX);
    assert!(all.targets([dark]).is_empty() && !all.targets([map]).is_empty());
    // A scale beyond the grid counts as the nearest in it.
    let (far, edge) = (AffineMap::new(9.0, -4.0).unwrap(), AffineMap::new(2.0, -0.5).unwrap());
    let plain = new(8, Heuristic::Constant, Keep::Terms(8)).unwrap();
    assert_eq!(plain.targets([far]), plain.targets([edge]));
    assert!(matches!(new(6, Heuristic::Constant, Keep::Terms(1)), Err(Error::NotPowerOfTwo { got: 6, .. })));
    assert!(matches!(
        new(4, Heuristic::Light(&[0.0; 3]), Keep::Terms(1)),
        Err(Error::Length { expected: 4, got: 3, .. })
    ));
    let nan = [0.0, f64::NAN];
    assert!(matches!(new(2, Heuristic::Light(&nan), Keep::Terms(1)), Err(Error::NotFinite { index: 1, .. })));
    assert!(matches!(new(2, Heuristic::Power(&[1.0, -1.0]), Keep::Terms(1)), Err(Error::OutOfRange { .. })));
    let huge = MapGrid::new([0.5, 2.0], [64, 4096]).unwrap();
    let two = Prediction::<2>::new(8, Decomposition::Standard, Heuristic::Constant, huge, Keep::Terms(1));
    assert!(matches!(two, Err(Error::OutOfRange { .. })));
}

/// The docstring's order of heuristics, and how far apart they are.
#[test]
fn heuristics_err_as_documented() {
    let grid = MapGrid::new([0.25, 4.0], [16, 24]).unwrap();
    let coefs = |seed| forward_2d(&textured(32, seed), 32, 32, Decomposition::Standard).unwrap();
    let (light, others) = (coefs(0), [coefs(1), coefs(2), coefs(3), coefs(4)]);
    let views: Vec<&[f64]> = others.iter().map(Vec::as_slice).collect();
    let power = mean_squares_2d(32, Decomposition::Standard, &views).unwrap();
    let new =
        |heuristic| Prediction::<2>::new(32, Decomposition::Standard, heuristic, grid, Keep::Fraction(0.2)).unwrap();
    let predictions = [
        new(Heuristic::Constant).with_union(1),
        new(Heuristic::Power(&power)).with_samples(2),
        new(Heuristic::Light(&light)).with_samples(2),
    ];
    let nonzeros = Nonzeros1d::new(32).unwrap();
    let mut errors = [0.0; 4];
    const MAPS: usize = 30;
    for k in 0..MAPS {
        let ([u, v], [w, _]) = (pair(k), pair(k + 500));
        let maps = [v, w].map(|t| visible([0.25, 4.0], [u, 0.05 + 0.9 * t]));
        let (mut half, mut target) = (vec![0.0; 1024], vec![0.0; 1024]);
        nonzeros.all(maps[0], |i, j, d| (0..32).for_each(|y| half[y * 32 + j] += light[y * 32 + i] * d));
        nonzeros.all(maps[1], |i, j, d| (0..32).for_each(|x| target[j * 32 + x] += half[i * 32 + x] * d));
        let all: f64 = target.iter().map(|l| l * l).sum();
        let relative = |kept: f64| (1.0 - kept / all).max(0.0).sqrt() / MAPS as f64;
        for (error, prediction) in errors.iter_mut().zip(&predictions) {
            *error += relative(prediction.targets(maps).iter().map(|&k| target[k as usize].powi(2)).sum());
        }
        let mut squares: Vec<f64> = target.iter().map(|l| l * l).collect();
        squares.sort_by(|a, b| b.total_cmp(a));
        errors[3] += relative(squares[..205].iter().sum());
    }
    let [constant, power, light, ideal] = errors;
    assert!((0.1..0.4).contains(&constant), "{errors:?}");
    assert!(power < 0.6 * constant && light < 0.6 * power && ideal < 0.6 * light && ideal > 0.0, "{errors:?}");
}

#[test]
fn mean_squares_are_level_by_level() {
    assert_eq!(mean_squares_1d(4, &[&[1.0, 2.0, 3.0, 4.0], &[3.0, 0.0, 1.0, 0.0]]).unwrap(), [5.0, 2.0, 6.5, 6.5]);
    assert_eq!(mean_squares_1d(2, &[]).unwrap(), [0.0, 0.0]);
    let ramp: Vec<f64> = (0..16).map(f64::from).collect();
    let nonstandard = mean_squares_2d(4, Decomposition::Nonstandard, &[&ramp]).unwrap();
    assert_eq!(nonstandard[..4], [0.0, 1.0, 4.0, 9.0]);
    assert_eq!(nonstandard[4..8], [(16.0 + 25.0 + 36.0 + 49.0) / 4.0; 4]);
    let standard = mean_squares_2d(4, Decomposition::Standard, &[&ramp]).unwrap();
    assert_eq!(standard[10], (100.0 + 121.0 + 196.0 + 225.0) / 4.0);
    assert_eq!(standard[2], (4.0 + 9.0) / 2.0);
    assert!(matches!(mean_squares_1d(3, &[]), Err(Error::NotPowerOfTwo { .. })));
    assert!(matches!(mean_squares_1d(2, &[&[1.0]]), Err(Error::Length { expected: 2, got: 1, .. })));
}

// --- The number of non-zeros
// ----------------------------------------------------------------------------------------------------------

fn wavelet_pairs(size: usize, map: AffineMap) -> usize {
    let mut count = 0;
    Nonzeros1d::new(size).unwrap().all(map, |i, j, _| count += usize::from(i > 0 && j > 0));
    count
}

/// 8N − (k + 2)(k + 4), k = log₂ N: near s = 1 a wavelet meets the two of its own level that it straddles and, of each
/// finer level, the three that have one of its breakpoints: Σ_l 2^l (2 + 6(k − 1 − l)) = 8N − 6k − 8, less one for each
/// pair of levels at the ends of the interval, k².
#[test]
fn nonzeros_follow_the_law_at_their_most() {
    let near = AffineMap::new(1.0 + 2e-6, 1.7e-6).unwrap();
    let listed = [29, 80, 193, 432, 925, 1928, 3953, 8024];
    for (k, most) in (3..).zip(listed) {
        assert_eq!(wavelet_pairs(1 << k, near), most);
        assert_eq!((8 << k) - (k + 2) * (k + 4), most);
        // With the scaling function as well: φ with φ, and at each level one wavelet on either side.
        assert_eq!(Nonzeros1d::new(1 << k).unwrap().count(near), most + 2 * k + 1);
    }
    // The thesis' bound of overlapping pairs, N k + k², is passed.
    assert!(wavelet_pairs(32, near) > 32 * 5 + 5 * 5 && wavelet_pairs(64, near) > 64 * 6 + 6 * 6);
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn nonzeros_never_exceed_the_law(k in 3usize..8, s in 0.5f64..2.0, o in -1.0f64..1.0, mirrored: bool, near: bool) {
        let (s, o) = if near { (1.0 + 1e-3 * (s - 1.0), 1e-3 * o) } else { (s, o) };
        let map = if mirrored { AffineMap::new(-s, 1.0 + o) } else { AffineMap::new(s, o) }.unwrap();
        prop_assert!(wavelet_pairs(1 << k, map) <= (8 << k) - (k + 2) * (k + 4));
        prop_assert!(Nonzeros1d::new(1 << k).unwrap().count(map) <= (8 << k) - (k + 2) * (k + 4) + 2 * k + 1);
    }
}
