//! Summed-area tables against golden values and sums pixel by pixel.

use crate::support::{HAAR_AFFINE, assert_close, cases, golden, narrow, number};
use haarmonic::reference::table as twin;
use haarmonic::strategies;
use haarmonic::table::{DiskGrid, Outside, Rectangle, SummedArea, SummedAreaPlan, SummedAreaRef, SummedAreaStack};
use haarmonic::{Error, Real};
use proptest::prelude::*;

fn rectangle([left, top, right, bottom]: [f64; 4]) -> Rectangle {
    Rectangle { left, top, right, bottom }
}

fn sides(r: Rectangle) -> [f64; 4] {
    [r.left, r.top, r.right, r.bottom]
}

#[test]
fn golden_tables_and_rectangles_are_reproduced() {
    let golden = golden(HAAR_AFFINE, "sat");
    let numbers = |v: &serde_json::Value| -> Vec<f64> {
        v.as_array().unwrap().iter().flat_map(|row| row.as_array().unwrap()).map(|x| x.as_f64().unwrap()).collect()
    };
    let samples = numbers(&golden["table_rows_y"]);
    let want = numbers(&golden["sat_exclusive"]);
    assert_eq!(twin::summed_area(7, 6, &samples), want);
    let table: SummedArea<f64> = SummedArea::new(7, 6, &narrow::<f32>(&samples)).unwrap();
    assert_eq!(table.as_ref().entries(), want);
    let single: SummedArea<f32> = SummedArea::new(7, 6, &samples).unwrap();
    assert_eq!(single.as_ref().entries(), narrow::<f32>(&want));

    let rects = golden["rects"].as_array().unwrap();
    assert_eq!(rects.len(), 15);
    for row in rects {
        let [l, r, t, b, sum] = std::array::from_fn(|k| row[k].as_f64().unwrap());
        assert_eq!(table.sum(rectangle([l, t, r, b])), sum);
        assert_eq!(single.sum(rectangle([l, t, r, b])), sum);
        assert_eq!(twin::rectangle_sum([7, 6], &samples, [l, t, r, b], [false; 2]), sum);
    }
    let rects = golden["fractional_rects"].as_array().unwrap();
    assert_eq!(rects.len(), 15);
    for row in rects {
        let [l, r, t, b, sum] = std::array::from_fn(|k| number(&row[k]));
        // Entries reach 714; a handful of roundings.
        assert_close(table.sum(rectangle([l, t, r, b])), sum, 1e-12, "fractional");
        assert_close(twin::rectangle_sum([7, 6], &samples, [l, t, r, b], [false; 2]), sum, 1e-12, "twin");
    }
}

/// A bound on the rounding of entry (r, c), in ε of the table: additions that a sample passes through, half an ε each.
fn additions(width: usize, height: usize) -> f64 {
    0.5 * (height.min(64) + height / 64 + 4 + width.div_ceil(8) + 1) as f64
}

#[track_caller]
fn check_build<S: Real, T: Real>(width: usize, height: usize, samples: &[f64]) {
    let samples: Vec<S> = narrow(samples);
    let exact: Vec<f64> = samples.iter().map(|s| s.widen()).collect();
    let want = twin::summed_area(width, height, &exact);
    let magnitude = twin::summed_area(width, height, &exact.iter().map(|x| x.abs()).collect::<Vec<_>>());
    let plan = SummedAreaPlan::new(width, height).unwrap();
    let (mut table, mut scratch) = (vec![T::nan(); plan.table_len()], vec![T::nan(); plan.scratch_len()]);
    plan.build(&samples, &mut table, &mut scratch);
    let epsilon = T::epsilon().widen();
    for (i, (&got, &want)) in table.iter().zip(&want).enumerate() {
        // Subnormal sums are spaced as the smallest number is.
        let tolerance = additions(width, height) * (epsilon * magnitude[i] + T::min_positive_value().widen() * epsilon);
        assert!(
            (got.widen() - want).abs() <= tolerance,
            "[{i}] of {width}×{height}: {got} is not {want} ± {tolerance:e}"
        );
    }

    let mut again = vec![T::nan(); table.len()];
    plan.build_parallel(&samples, &mut again);
    assert_eq!(again, table, "parallel");
    let (three, tables) = (samples.repeat(3), table.repeat(3));
    let mut batch = vec![T::nan(); tables.len()];
    scratch.fill(T::nan());
    plan.build_batch(&three, &mut batch, &mut scratch);
    assert_eq!(batch, tables, "batch");
    batch.fill(T::nan());
    plan.build_batch_parallel(&three, &mut batch);
    assert_eq!(batch, tables, "parallel batch");
}

/// A size and its samples.
fn image(largest: usize) -> impl Strategy<Value = (usize, usize, Vec<f64>)> {
    (0..=largest, 0..=largest).prop_flat_map(|(w, h)| (Just(w), Just(h), strategies::signal::<f32>(w * h))).prop_map(
        |(w, h, samples)| {
            // Sums of huge samples must still be numbers.
            let fits = samples.iter().all(|s| s.abs() < 1e30);
            (w, h, samples.iter().map(|&s| f64::from(s) * if fits { 1.0 } else { 1e-10 }).collect())
        },
    )
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn tables_are_sums((width, height, samples) in image(40)) {
        check_build::<f32, f32>(width, height, &samples);
        check_build::<f32, f64>(width, height, &samples);
        check_build::<f64, f64>(width, height, &samples);
        check_build::<f64, f32>(width, height, &samples);
    }

    #[test]
    fn rectangles_are_sums(
        ((width, height, samples), rects) in image(24).prop_flat_map(|(w, h, samples)| {
            let rects = proptest::collection::vec((strategies::rectangle(w, h), strategies::outside(), strategies::outside()), 8);
            (Just((w, h, samples)), rects)
        }),
    ) {
        let table: SummedArea<f64> = SummedArea::new(width, height, &samples).unwrap();
        let magnitude: f64 = samples.iter().map(|s| s.abs()).sum();
        for (rect, along_x, along_y) in rects {
            let outside = [along_x, along_y];
            let wrap = outside.map(|o| o == Outside::Wrap);
            let want = twin::rectangle_sum([width, height], &samples, sides(rect), wrap);
            // Up to 9 images, of entries that are off by 10 ε.
            let tolerance = 40.0 * f64::EPSILON * magnitude;
            assert_close(table.as_ref().sum_beyond(rect, outside), want, tolerance, &format!("{rect:?} {outside:?}"));
            let inside = twin::rectangle_sum([width, height], &samples, sides(rect), [false; 2]);
            assert_close(table.sum(rect), inside, tolerance, &format!("{rect:?}"));
            if rect.area() != 0.0 {
                assert_close(table.mean(rect) * rect.area(), inside, 2.0 * tolerance, "mean");
            }
            let turned = Rectangle { left: rect.right, right: rect.left, ..rect };
            prop_assert_eq!(table.sum(turned), -table.sum(rect));
        }
    }

    #[test]
    fn stacks_are_tables_side_by_side(
        (width, height, layers, samples) in (0..12_usize, 0..12_usize, 0..9_usize).prop_flat_map(|(w, h, n)| {
            (Just(w), Just(h), Just(n), proptest::collection::vec(-1.0..1.0_f64, w * h * n))
        }),
        at in proptest::array::uniform4(-0.3..1.3_f64),
    ) {
        let stack: SummedAreaStack<f64> = SummedAreaStack::new([width, height], layers, &samples).unwrap();
        let [w, h] = [width, height].map(|n| n as f64);
        let rect = rectangle([at[0] * w, at[1] * h, at[2] * w, at[3] * h]);
        let mut sums = vec![f64::NAN; layers];
        stack.sums(rect, &mut sums);
        for layer in 0..layers {
            let own = &samples[layer * width * height..][..width * height];
            let want = twin::rectangle_sum([width, height], own, sides(rect), [false; 2]);
            // At most 121 samples below 1, sixteen products.
            assert_close(sums[layer], want, 1e-13, "sums");
            assert_close(stack.mix(rect, [(layer, 1.0)]), want, 1e-13, "mix");
            let other = (layer + 1) % layers;
            let mixed = stack.mix(rect, [(layer, 0.25), (other, 0.75)]);
            assert_close(mixed, 0.25 * sums[layer] + 0.75 * sums[other], 1e-13, "mix of two");
        }
    }
}

#[test]
fn sizes_beyond_a_band_and_a_chunk() {
    // Bands are 64 rows, chunks 256 columns: one and a bit of each, in both ways round. Small integers: exact in every
    // type.
    for (width, height) in [(257, 9), (261, 65), (513, 3), (1, 200), (16, 129)] {
        let samples: Vec<f64> = (0..width * height).map(|i| ((i * 7919) % 23) as f64 - 11.0).collect();
        let want = twin::summed_area(width, height, &samples);
        let single: SummedArea<f32> = SummedArea::new(width, height, &samples).unwrap();
        assert_eq!(single.as_ref().entries(), narrow::<f32>(&want), "{width}×{height}");
        let plan = SummedAreaPlan::new(width, height).unwrap();
        let mut table = vec![f64::NAN; plan.table_len()];
        plan.build(&narrow::<f32>(&samples), &mut table, &mut vec![f64::NAN; plan.scratch_len()]);
        assert_eq!(table, want, "{width}×{height}");
    }
    // With fractions, parallel and serial still agree bit for bit.
    let samples: Vec<f32> = (0..300 * 300).map(|i| (i as f32 * 0.618_034).fract() - 0.3).collect();
    let plan = SummedAreaPlan::new(300, 300).unwrap();
    let (mut serial, mut parallel) = (vec![0.0_f32; plan.table_len()], vec![0.0_f32; plan.table_len()]);
    plan.build(&samples, &mut serial, &mut vec![0.0; plan.scratch_len()]);
    plan.build_parallel(&samples, &mut parallel);
    assert!(serial == parallel);
}

/// Rows that are summed two at a time and columns that are taken sixteen at a time, or one by one where they end: the
/// same bits.
#[test]
fn parts_of_an_image_have_the_bits_of_the_whole() {
    fn check<T: Real>(width: usize, height: usize) {
        let samples: Vec<f32> = (0..70 * 50).map(|i| (i as f32 * 0.618_034).fract() - 0.3).collect();
        let part: Vec<f32> = samples.chunks(50).take(height).flat_map(|row| row[..width].to_vec()).collect();
        let [part, whole] = [(width, height, part), (50, 70, samples)].map(|(width, height, samples)| {
            let plan = SummedAreaPlan::new(width, height).unwrap();
            let mut table = vec![T::nan(); plan.table_len()];
            plan.build(&samples, &mut table, &mut vec![T::nan(); plan.scratch_len()]);
            table
        });
        for (part, whole) in part.chunks_exact(width + 1).zip(whole.chunks_exact(51)) {
            assert_eq!(part, &whole[..=width], "{width} × {height}");
        }
    }
    for height in (1..=8).chain(63..=69) {
        for width in 1..=49 {
            check::<f32>(width, height);
            check::<f64>(width, height);
        }
    }
}

#[test]
fn single_precision_loses_what_double_keeps() {
    // 2048² samples in [0, 1): the worst of 64 rectangles of 8×8 pixels, relative.
    let n = 2048;
    let samples: Vec<f32> =
        (0..n * n).map(|i: usize| (i.wrapping_mul(2_654_435_761) >> 8 & 0xffff) as f32 / 65536.0).collect();
    let single: SummedArea<f32> = SummedArea::new(n, n, &samples).unwrap();
    let double: SummedArea<f64> = SummedArea::new(n, n, &samples).unwrap();
    let rounded: Vec<f32> = double.as_ref().entries().iter().map(|&s| s as f32).collect();
    let plan = SummedAreaPlan::new(n, n).unwrap();
    let rounded = SummedAreaRef::new(&plan, &rounded);
    let mut worst = [0.0_f64; 3];
    for k in 0..64 {
        let [x, y] = [(k * 37) % 61, (k * 53) % 59].map(|p: usize| n - 8 - 30 * p);
        let rect = rectangle([x as f64, y as f64, x as f64 + 8.0, y as f64 + 8.0]);
        let want: f64 = (0..64).map(|i| f64::from(samples[(y + i / 8) * n + x + i % 8])).sum();
        for (worst, got) in worst.iter_mut().zip([single.sum(rect), rounded.sum(rect), double.sum(rect)]) {
            *worst = worst.max((got - want).abs() / want);
        }
    }
    // Of what an f32 table loses, most is the entries' own rounding: sums in f64 would not save it.
    assert!(worst[0] > 1e-3 && worst[0] < 0.3, "{worst:?}");
    assert!(worst[1] > 1e-3 && worst[1] < 0.1, "{worst:?}");
    assert!(worst[2] < 1e-9, "{worst:?}");
}

#[test]
fn bounds_at_the_edges() {
    let table: SummedArea<f64> = SummedArea::new(3, 2, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).unwrap();
    let view = table.as_ref();
    let (inf, nan) = (f64::INFINITY, f64::NAN);
    assert_eq!(table.sum(rectangle([-inf, -inf, inf, inf])), 21.0);
    assert_eq!(table.mean(rectangle([-inf, -inf, inf, inf])), 0.0);
    assert_eq!(table.sum(rectangle([inf, 0.0, -inf, 2.0])), -21.0);
    assert_eq!(table.sum(rectangle([3.0, 2.0, 0.0, 0.0])), 21.0);
    assert_eq!(table.sum(rectangle([1.0, 0.5, 1.0, 9.0])), 0.0);
    for k in 0..4 {
        let mut bounds = [0.0, 0.0, 1.0, 1.0];
        bounds[k] = nan;
        assert!(table.sum(rectangle(bounds)).is_nan());
        assert!(table.mean(rectangle(bounds)).is_nan());
        assert!(view.sum_beyond(rectangle(bounds), [Outside::Wrap; 2]).is_nan());
    }
    assert!(view.sum_beyond(rectangle([0.0, 0.0, inf, 1.0]), [Outside::Wrap; 2]).is_nan());
    // A mean over nothing is the pixel there.
    assert_eq!(table.mean(Rectangle::square([1.5, 1.5], 0.0)), 5.0);
    assert_eq!(table.mean(Rectangle::square([3.0, 1.5], 0.0)), 0.0);
    assert_eq!(view.pixel([2.999, 0.0]), 3.0);
    assert_eq!(view.pixel([-1e-9, 0.0]), 0.0);
    assert!(view.pixel([nan, 0.0]).is_nan());
    // Images without pixels.
    for (width, height) in [(0, 0), (0, 3), (3, 0)] {
        let empty: SummedArea<f32> = SummedArea::new(width, height, &[0.0_f32; 0]).unwrap();
        assert_eq!(empty.as_ref().entries().len(), (width + 1) * (height + 1));
        assert_eq!(empty.sum(rectangle([-1.0, -1.0, 5.0, 5.0])), 0.0);
        assert_eq!(empty.as_ref().sum_beyond(rectangle([-1.0, -1.0, 5.0, 5.0]), [Outside::Wrap; 2]), 0.0);
        assert_eq!(empty.mean(rectangle([0.0, 0.0, 0.0, 0.0])), 0.0);
    }
}

#[test]
fn nan_and_infinity_reach_what_is_beyond_them() {
    for bad in [f32::NAN, f32::INFINITY] {
        for (x, y) in [(0, 0), (3, 2), (8, 5), (19, 69)] {
            let mut samples = vec![1.0_f32; 20 * 70];
            samples[y * 20 + x] = bad;
            let table: SummedArea<f64> = SummedArea::new(20, 70, &samples).unwrap();
            let view = table.as_ref();
            for (i, entry) in view.entries().iter().enumerate() {
                let (r, c) = (i / 21, i % 21);
                if r > y && c > x {
                    assert!(!entry.is_finite(), "{bad} at ({x}, {y}), entry ({r}, {c})");
                } else {
                    assert_eq!(*entry, (r * c) as f64);
                }
            }
            // Rectangles that end at the pixel are right.
            assert_eq!(view.sum(rectangle([0.0, 0.0, x as f64, 70.0])), (70 * x) as f64);
            assert_eq!(view.sum(rectangle([0.0, 0.0, 20.0, y as f64])), (20 * y) as f64);
            assert!(!view.sum(rectangle([0.0, 0.0, x as f64 + 0.5, y as f64 + 0.5])).is_finite());
        }
    }
}

#[test]
fn the_disk_of_a_grid() {
    for side in [1, 2, 5, 32, 33] {
        let grid = DiskGrid::new(side).unwrap();
        let mut map = vec![true; side * side];
        grid.mask(&mut map);
        let centre = |k: usize| (2 * k + 1) as f64 / side as f64 - 1.0;
        for (i, &inside) in map.iter().enumerate() {
            let (x, y) = (i % side, i / side);
            assert_eq!(inside, centre(x).hypot(centre(y)) <= 1.0 + 1e-12);
            assert_eq!(inside, map[(side - 1 - y) * side + x]);
            assert_eq!(inside, map[x * side + y]);
            let [u, v] = grid.pixels([centre(x), centre(y)]);
            assert_close(u, x as f64 + 0.5, 1e-14 * side as f64, "x");
            assert_close(v, y as f64 + 0.5, 1e-14 * side as f64, "y");
        }
    }
    // The disk's area is that of its pixels, to a pixel's width along the rim.
    let grid = DiskGrid::new(256).unwrap();
    let mut sky = vec![1.0_f32; 256 * 256];
    grid.mask(&mut sky);
    let table: SummedArea<f64> = SummedArea::new(256, 256, &sky).unwrap();
    let quarter = table.mean(grid.square([0.0, 0.0], 2.0)) * 4.0;
    assert_close(quarter, std::f64::consts::PI, 1e-3, "area");
    // A light on the horizon is half seen, one at the nadir not at all.
    let horizon = grid.square([0.0, -1.0], 0.125);
    assert_close(table.mean(horizon), 0.5, 0.02, "horizon");
    assert_eq!(table.mean(grid.square([1.0, 1.0], 0.125)), 0.0);
    assert!(matches!(DiskGrid::new(0), Err(Error::Empty { .. })));
    assert!(matches!(DiskGrid::new(65537), Err(Error::OutOfRange { .. })));
}

#[test]
fn what_is_refused() {
    assert!(matches!(SummedAreaPlan::new(usize::MAX, 2), Err(Error::OutOfRange { .. })));
    let short = SummedArea::<f64>::new(2, 2, &[0.0_f32; 3]);
    assert!(matches!(short, Err(Error::Length { what: "samples", expected: 4, got: 3 })));
    let stack = SummedAreaStack::<f32>::new([2, 2], 2, &[0.0_f32; 4]);
    assert!(matches!(stack, Err(Error::Length { expected: 8, got: 4, .. })));
    assert!(matches!(SummedAreaStack::<f32>::new([1 << 40, 1 << 40], 2, &[0.0_f32; 4]), Err(Error::OutOfRange { .. })));
}

#[test]
#[should_panic(expected = "scratch: expected length 4, got 3")]
fn short_scratch_panics() {
    let plan = SummedAreaPlan::new(2, 2).unwrap();
    plan.build(&[0.0_f32; 4], &mut [0.0_f32; 9], &mut [0.0; 3]);
}

#[test]
#[should_panic(expected = "layer 2 of a stack of 2")]
fn a_layer_too_far_panics() {
    let stack = SummedAreaStack::<f32>::new([1, 1], 2, &[0.0_f32; 2]).unwrap();
    stack.mix(rectangle([0.0; 4]), [(2, 1.0)]);
}
