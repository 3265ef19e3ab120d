//! Compressed images: zooms, sums, masks and convolutions by both routes, against sums over pixels.

use crate::support::{assert_all_close, assert_close, cases, dot, largest, map, narrow, random, wide};
use haarmonic::affine::{
    AffineMap, AffineProduct2d, Heuristic, ImageRoute, Kernel, MapGrid, Prediction, WaveletImage, Zoom, ZoomScratch,
    ZoomTargets, ZoomWindow,
};
use haarmonic::haar::{Decomposition, Keep, Quadtree, SparseVector, forward_2d};
use haarmonic::reference::affine as naive;
use haarmonic::strategies::{affine_map, wavelet_image};
use haarmonic::{Error, Real};
use proptest::prelude::*;

const ALL: Keep = Keep::Fraction(1.0);
/// Pictures of one pixel, of lines, of powers of two, and of none.
const SIZES: [[usize; 2]; 9] = [[1, 1], [2, 1], [1, 2], [2, 2], [8, 8], [16, 4], [5, 7], [12, 9], [33, 20]];

fn picture(size: [usize; 2], seed: u64) -> Vec<f64> {
    random(size[0] * size[1], seed)
}

fn image<T: Real>(size: [usize; 2], pixels: &[f64]) -> WaveletImage<T, 1> {
    WaveletImage::from_pixels(size, [&narrow(pixels)], ALL).unwrap()
}

fn pixels<T: Real>(image: &WaveletImage<T, 1>) -> Vec<f64> {
    wide(&image.to_pixels()[0])
}

/// Windows that enlarge, shrink, mirror, lie partly, just and wholly outside.
fn windows() -> Vec<ZoomWindow> {
    let pairs = [
        [(1.0, 0.0), (1.0, 0.0)],
        [(0.25, 0.31), (0.25, 0.42)],
        [(0.5, 0.25), (0.125, 0.5)],
        [(-1.0, 1.0), (0.7137, 0.1071)],
        [(1.9, -0.3), (-0.613, 0.87)],
        [(3.7, -1.2), (0.031, 0.517)],
        [(1.0, 1.0), (1.0, 0.0)],
        [(0.5, -0.75), (0.5, 1.5)],
        [(1e-9, 0.5), (40.0, -17.3)],
    ];
    pairs.map(|axes| ZoomWindow::from_maps(axes.map(|(s, o)| map(s, o)))).to_vec()
}

#[test]
fn decoding_is_the_sum_of_the_functions() {
    for size in SIZES {
        let pixels_in = picture(size, 3);
        let image = image::<f64>(size, &pixels_in);
        let grid = image.grid();
        let terms = image.indices().iter().map(|&i| i as usize).zip(image.values().iter().map(|v| v[0]));
        let whole = naive::decode_standard(grid, terms);
        let shown: Vec<f64> = (0..size[1]).flat_map(|y| whole[y * grid[0]..][..size[0]].to_vec()).collect();
        assert_all_close(&shown, &pixels_in, 4.0 * f64::EPSILON, &format!("{size:?}"));
        // The rest of the grid is 0.
        let beside = |i: &usize| i % grid[0] >= size[0] || i / grid[0] >= size[1];
        let most = (0..whole.len()).filter(beside).fold(0.0, |m: f64, i| m.max(whole[i].abs()));
        assert!(most <= 8.0 * f64::EPSILON, "{size:?}: {most:e} beside the picture");
        assert_all_close(&pixels(&image), &pixels_in, 2.0 * f64::EPSILON, &format!("{size:?}"));
    }
}

fn check_zoom<T: Real>(from: [usize; 2], to: [usize; 2], tolerance: f64) {
    let pixels_in = picture(from, 17);
    let image = image::<T>(from, &pixels_in);
    let mut scratch = ZoomScratch::new();
    for window in windows() {
        let want = naive::resample_between_2d(&pixels_in, from[0], to, window.maps());
        for route in ImageRoute::ALL {
            let zoom = Zoom::new(window, from, to).unwrap().with_route(route);
            let got = zoom.apply_with(&image, &mut scratch).unwrap();
            let what = format!("{from:?} to {to:?}, {route:?}, {window:?}");
            assert_eq!(got.size(), to);
            assert!(got.indices().is_sorted_by(|a, b| a < b), "{what}");
            assert_all_close(&pixels(&got), &want, tolerance * T::epsilon().widen(), &what);
            assert_eq!(got, zoom.apply(&image).unwrap(), "{what}: with memory of others");
        }
    }
}

#[test]
fn zooms_equal_the_twin() {
    for from in SIZES {
        for to in [[1, 1], [2, 1], [8, 8], [3, 16], [21, 10]] {
            check_zoom::<f64>(from, to, 64.0);
            check_zoom::<f32>(from, to, 64.0);
        }
    }
}

#[test]
fn rows_that_are_whole_and_rows_that_are_not() {
    // Of 64 columns, rows of Z with more and with fewer than a sixth; few and many terms.
    let size = [64, 32];
    let pixels_in = picture(size, 5);
    for kept in [1, 3, 20, 200, 2000] {
        let image = WaveletImage::<f64>::from_pixels(size, [&pixels_in], Keep::Terms(kept)).unwrap();
        assert!(image.terms() <= kept);
        let shown = pixels(&image);
        for window in windows() {
            // Worst seen: 44 ε.
            let want = naive::resample_between_2d(&shown, size[0], [64, 64], window.maps());
            let got = Zoom::new(window, size, [64, 64]).unwrap().with_route(ImageRoute::Wavelets).apply(&image);
            assert_all_close(&pixels(&got.unwrap()), &want, 96.0 * f64::EPSILON, &format!("{kept}, {window:?}"));
        }
    }
}

#[test]
fn channels_do_not_mix() {
    let (size, window) = ([12, 10], windows()[1]);
    let planes = [picture(size, 1), picture(size, 2), picture(size, 3)];
    let three = WaveletImage::from_pixels(size, planes.each_ref().map(Vec::as_slice), ALL).unwrap();
    for route in ImageRoute::ALL {
        let zoom = Zoom::new(window, size, [16, 16]).unwrap().with_route(route);
        let got = zoom.apply(&three).unwrap();
        for c in 0..3 {
            let one = zoom.apply(&image::<f64>(size, &planes[c])).unwrap();
            assert_all_close(&got.to_pixels()[c], &pixels(&one), 0.0, &format!("{route:?}, channel {c}"));
            assert_eq!(three.channel(c).to_dense(), image::<f64>(size, &planes[c]).channel(0).to_dense());
        }
    }
}

#[test]
fn targets_are_those_of_the_whole_zoom() {
    let size = [32, 32];
    let pixels_in = picture(size, 9);
    let image = image::<f64>(size, &pixels_in);
    let zoom = Zoom::new(windows()[1], size, size).unwrap();
    for route in ImageRoute::ALL {
        let zoom = zoom.with_route(route);
        let all = zoom.apply(&image).unwrap();
        // The largest: no term that is left out is larger than one that is kept, but for the mean.
        let kept = zoom.with_targets(ZoomTargets::Largest(Keep::Terms(100))).apply(&image).unwrap();
        assert_eq!((kept.terms(), kept.indices()[0]), (100, 0));
        let least = kept.values()[1..].iter().fold(f64::INFINITY, |m, v| m.min(v[0].abs()));
        let mut left = 0;
        for (i, value) in all.indices().iter().zip(all.values()) {
            match kept.indices().binary_search(i) {
                Ok(at) => assert_eq!(kept.values()[at], *value),
                Err(_) => {
                    left += 1;
                    assert!(value[0].abs() <= least, "{route:?}: {i} is {} and left, {least} is kept", value[0]);
                }
            }
        }
        assert_eq!(left, all.terms() - 100);
        assert_eq!(kept, all.kept(Keep::Terms(100)).unwrap());
        // Those of a list, and nothing else.
        for step in [1, 3, 40, 1000] {
            let wanted: Vec<u32> = (0..1024).step_by(step).collect();
            let got = zoom.with_targets(ZoomTargets::At(&wanted)).apply(&image).unwrap();
            let some = all.indices().iter().zip(all.values()).filter(|(i, _)| wanted.contains(i));
            let (indices, values): (Vec<u32>, Vec<[f64; 1]>) = some.map(|(&i, &v)| (i, v)).unzip();
            assert_eq!(got, WaveletImage::new(size, indices, values).unwrap(), "{route:?}, every {step}");
        }
        assert_eq!(zoom.with_targets(ZoomTargets::At(&[])).apply(&image).unwrap().terms(), 0);
    }
}

#[test]
fn predicted_targets_are_taken() {
    let size = [16, 16];
    let pixels_in = picture(size, 4);
    let image = image::<f64>(size, &pixels_in);
    let coefs = forward_2d(&pixels_in, 16, 16, Decomposition::Standard).unwrap();
    let grid = MapGrid::new([0.125, 1.0], [8, 16]).unwrap();
    let prediction =
        Prediction::<2>::new(16, Decomposition::Standard, Heuristic::Light(&coefs), grid, Keep::Terms(60)).unwrap();
    let zoom = Zoom::new(windows()[1], size, size).unwrap();
    let targets = prediction.targets(zoom.maps());
    let got = zoom.with_targets(ZoomTargets::At(targets)).apply(&image).unwrap();
    assert!(got.terms() > 30 && got.indices().iter().all(|i| targets.contains(i)));
    let all = zoom.apply(&image).unwrap();
    for (i, value) in got.indices().iter().zip(got.values()) {
        let want = all.values()[all.indices().binary_search(i).unwrap()][0];
        assert_close(value[0], want, 0.0, "a predicted term");
    }
}

#[test]
fn aligned_zooms_chain_and_the_identity_does_nothing() {
    let size = [32, 16];
    let image = image::<f64>(size, &picture(size, 21));
    let same =
        Zoom::new(ZoomWindow::WHOLE, size, size).unwrap().with_route(ImageRoute::Wavelets).apply(&image).unwrap();
    assert_eq!(same.indices(), image.indices());
    assert_all_close(same.values().as_flattened(), image.values().as_flattened(), f64::EPSILON, "the identity");
    // A quarter by two halves: windows of whole pixels at twice the size lose nothing.
    let [first, second] = [[0.25, 0.75], [0.5, 0.25]].map(|centre| ZoomWindow::new(centre, [2.0, 2.0]).unwrap());
    let [a, b] = [first.maps(), second.maps()];
    let both = ZoomWindow::from_maps([0, 1].map(|axis| b[axis].then(a[axis]).unwrap()));
    let twice = image.zoom(first, size).unwrap().zoom(second, size).unwrap();
    let once = image.zoom(both, size).unwrap();
    assert_all_close(&pixels(&twice), &pixels(&once), 4.0 * f64::EPSILON, "a zoom of a zoom");
    // To twice the pixels and back.
    let back = image.zoom(ZoomWindow::WHOLE, [64, 32]).unwrap().zoom(ZoomWindow::WHOLE, size).unwrap();
    assert_all_close(&pixels(&back), &pixels(&image), 8.0 * f64::EPSILON, "there and back");
}

#[test]
fn a_snapped_window_begins_with_a_pixel_and_has_fewer_terms() {
    let size = [64, 48];
    let image = image::<f64>(size, &picture(size, 2));
    let window = ZoomWindow::new([0.511, 0.423], [4.0, 4.0]).unwrap();
    let snapped = window.snapped(size).unwrap();
    for axis in 0..2 {
        let start = snapped.maps()[axis].offset() * size[axis] as f64;
        assert!(
            (start - start.round()).abs() < 1e-12
                && (start - window.maps()[axis].offset() * size[axis] as f64).abs() <= 0.5
        );
        assert_eq!(snapped.maps()[axis].scale(), 0.25);
    }
    let [free, even] = [window, snapped].map(|window| image.zoom(window, size).unwrap());
    assert!(even.terms() * 2 < free.terms(), "{} and {} terms", even.terms(), free.terms());
    // Each pixel of the picture is a square of 4 × 4.
    let (got, given) = (pixels(&even), pixels(&image));
    let start = snapped.maps().map(|map| map.offset());
    let [x0, y0] = [0, 1].map(|axis| (start[axis] * size[axis] as f64).round() as usize);
    for (i, &pixel) in got.iter().enumerate() {
        let (x, y) = (i % 64 / 4 + x0, i / 64 / 4 + y0);
        assert_close(pixel, given[y * 64 + x], 6.0 * f64::EPSILON, "an enlarged pixel");
    }
}

#[test]
fn levels_add_up_to_the_whole_and_each_is_a_coarser_picture() {
    for (from, to) in [([16, 16], [32, 32]), ([20, 9], [16, 4]), ([7, 33], [4, 64]), ([4, 4], [1, 1]), ([1, 1], [2, 8])]
    {
        let pixels_in = picture(from, 31);
        let image = image::<f64>(from, &pixels_in);
        for window in windows() {
            let zoom = Zoom::new(window, from, to).unwrap().with_route(ImageRoute::Wavelets);
            let steps = zoom.levels(&image);
            assert_eq!(steps.len(), to[0].max(to[1]).next_power_of_two().ilog2() as usize + 1);
            let mut sum = WaveletImage::zero(to).unwrap();
            for (l, step) in steps.enumerate() {
                sum = sum.plus(&step).unwrap();
                // What has come is the zoom at as many pixels. Ends are rounded by ε of their place, which is 64 ε of a
                // pixel here; worst seen: 121 ε.
                let coarse = to.map(|side| side.min(1 << l));
                let want = naive::resample_between_2d(&pixels_in, from[0], coarse, window.maps());
                let got = pixels(&sum.zoom(ZoomWindow::WHOLE, coarse).unwrap());
                assert_all_close(
                    &got,
                    &want,
                    256.0 * f64::EPSILON,
                    &format!("{from:?} to {to:?}, step {l}, {window:?}"),
                );
                let drawn = naive::resample_between_2d(&want, coarse[0], to, [AffineMap::IDENTITY; 2]);
                assert_all_close(&pixels(&sum), &drawn, 256.0 * f64::EPSILON, "and has no finer detail");
            }
            assert_eq!(sum, zoom.apply(&image).unwrap(), "{from:?} to {to:?}, {window:?}");
        }
    }
}

#[test]
fn a_picture_that_arrives_by_levels_is_zoomed_by_levels() {
    let size = [24, 16];
    let image = WaveletImage::<f64>::from_pixels(size, [&picture(size, 8)], Keep::Terms(150)).unwrap();
    let window = windows()[1];
    let (mut sum, mut seen, mut terms) = (WaveletImage::zero(size).unwrap(), WaveletImage::zero([32, 32]).unwrap(), 0);
    assert_eq!(image.levels().len(), 6);
    for level in image.levels() {
        terms += level.terms();
        sum = sum.plus(&level).unwrap();
        seen = seen.plus(&level.zoom(window, [32, 32]).unwrap()).unwrap();
    }
    assert_eq!((sum, terms), (image.clone(), image.terms()));
    let want = image.zoom(window, [32, 32]).unwrap();
    assert_all_close(&pixels(&seen), &pixels(&want), 2.0 * f64::EPSILON, "sum of zooms");
}

#[test]
fn sums_and_contrast_are_those_of_the_pixels() {
    for size in SIZES {
        let [f, g] = [1, 2].map(|seed| picture(size, seed));
        let [a, b] = [&f, &g].map(|pixels| image::<f64>(size, pixels));
        let mixed: Vec<f64> = f.iter().zip(&g).map(|(f, g)| 0.7 * f - 1.3 * g).collect();
        assert_all_close(&pixels(&a.combined(0.7, &b, -1.3).unwrap()), &mixed, 4.0 * f64::EPSILON, "a sum");
        let bright: Vec<f64> = f.iter().map(|f| 1.5 * f + 0.25).collect();
        let got = a.adjusted([1.5], [0.25]);
        assert_all_close(&pixels(&got), &bright, 6.0 * f64::EPSILON, "contrast");
        assert_eq!(a.adjusted([1.0], [0.0]), a);
        assert_eq!(a.combined(1.0, &a, -1.0).unwrap().terms(), 0);
    }
    // Where there is no mean yet.
    let black = WaveletImage::<f64, 2>::zero([4, 4]).unwrap().adjusted([2.0, 2.0], [0.5, -0.5]);
    assert_eq!(black.to_pixels(), [vec![0.5; 16], vec![-0.5; 16]]);
}

#[test]
fn masks_multiply_pixels_by_both_routes() {
    for size in SIZES {
        let [f, g] = [1, 2].map(|seed| picture(size, seed));
        let [a, mask] = [&f, &g].map(|pixels| image::<f64>(size, pixels));
        let want: Vec<f64> = f.iter().zip(&g).map(|(f, g)| f * g).collect();
        for route in ImageRoute::ALL {
            let got = a.masked_by(route, &mask).unwrap();
            assert_all_close(&pixels(&got), &want, 4.0 * f64::EPSILON, &format!("{size:?}, {route:?}"));
        }
        assert_all_close(&pixels(&a.masked(&mask).unwrap()), &want, 4.0 * f64::EPSILON, "whichever");
        let one = image(size, &vec![1.0; size[0] * size[1]]);
        assert_all_close(&pixels(&a.masked(&one).unwrap()), &f, 3.0 * f64::EPSILON, "times 1");
        let other = picture(size, 7);
        let want: Vec<f64> = (0..f.len()).map(|i| other[i] + g[i] * (f[i] - other[i])).collect();
        let got = a.blended(&image(size, &other), &mask).unwrap();
        assert_all_close(&pixels(&got), &want, 6.0 * f64::EPSILON, &format!("{size:?}, blended"));
    }
}

#[test]
fn a_separable_picture_is_the_product_of_its_axes() {
    let (f, g) = (random(5, 1), random(9, 2));
    let image = WaveletImage::<f64, 2>::from_separable(&f, &g).unwrap();
    let want: Vec<f64> = (0..45).map(|i| f[i % 5] * g[i / 5]).collect();
    for plane in image.to_pixels() {
        assert_all_close(&plane, &want, f64::EPSILON, "f(x) g(y)");
    }
    // A rectangle of any place has few terms: at most 2 a level and axis, and the mean.
    let inside = |from: usize, to: usize| (0..1024).map(|i| f64::from((from..to).contains(&i))).collect::<Vec<_>>();
    let rectangle = WaveletImage::<f64>::from_separable(&inside(113, 700), &inside(3, 512)).unwrap();
    assert!(rectangle.terms() <= 21 * 21, "{} terms", rectangle.terms());
}

fn kernels() -> Vec<Kernel> {
    vec![
        Kernel::identity(),
        Kernel::from_taps(1, &[1.0]).unwrap(),
        Kernel::from_taps(-3, &[0.5, -1.25, 0.0, 2.0]).unwrap(),
        Kernel::boxed(5.0).unwrap(),
        Kernel::tent(2.7).unwrap(),
        Kernel::translation(-1.3).unwrap(),
        Kernel::from_cells(-2, &[1.0, 3.0, -2.0]).unwrap(),
        Kernel::boxed(50.0).unwrap(),
        Kernel::from_taps(40, &[1.0, 1.0]).unwrap(),
    ]
}

fn taps(kernel: &Kernel) -> Vec<(i64, f64)> {
    (kernel.first()..).zip(kernel.taps().iter().copied()).collect()
}

fn check_convolution<T: Real>(size: [usize; 2], tolerance: f64) {
    let f = picture(size, 13);
    let image = image::<T>(size, &f);
    for x in kernels() {
        for y in kernels() {
            let want = naive::convolve_2d(&f, size[0], [&taps(&x), &taps(&y)]);
            let what = format!("{size:?}, {x:?}, {y:?}");
            // A sum of as many as there are weights.
            let weight: f64 = [&x, &y].map(|k| k.taps().iter().map(|t| t.abs()).sum::<f64>()).iter().product();
            for route in ImageRoute::ALL {
                let got = image.convolve_by(route, [&x, &y]);
                let tolerance = tolerance * T::epsilon().widen() * weight;
                assert_all_close(&pixels(&got), &want, tolerance, &format!("{route:?}, {what}"));
            }
        }
    }
}

#[test]
fn convolutions_equal_sums_over_pixels() {
    for size in SIZES {
        check_convolution::<f64>(size, 6.0);
    }
    check_convolution::<f32>([12, 9], 6.0);
    check_convolution::<f32>([32, 16], 6.0);
}

#[test]
fn convolutions_and_masks_take_the_cheaper_route() {
    let size = [128, 128];
    let (f, kernel) = (picture(size, 1), Kernel::boxed(3.0).unwrap());
    let mask = WaveletImage::<f32>::from_separable(&narrow::<f32>(&f[..128]), &[1.0; 128]).unwrap();
    for (terms, cheaper, other) in
        [(5, ImageRoute::Wavelets, ImageRoute::Pixels), (16384, ImageRoute::Pixels, ImageRoute::Wavelets)]
    {
        let image = WaveletImage::<f32>::from_pixels(size, [&narrow(&f)], Keep::Terms(terms)).unwrap();
        let blurred = [cheaper, other].map(|route| image.convolve_by(route, [&kernel, &kernel]));
        assert_eq!(image.convolve([&kernel, &kernel]), blurred[0], "{terms}");
        let masked = [cheaper, other].map(|route| image.masked_by(route, &mask).unwrap());
        assert_eq!(image.masked(&mask).unwrap(), masked[0], "{terms}");
        // The routes differ in their last bits, so that it shows which was taken.
        assert!(blurred[0] != blurred[1] && masked[0] != masked[1], "{terms}");
    }
}

#[test]
fn a_unit_kernel_does_nothing() {
    let size = [32, 8];
    let image = image::<f64>(size, &picture(size, 6));
    let same = image.convolve_by(ImageRoute::Wavelets, [&Kernel::identity(), &Kernel::identity()]);
    assert_eq!(same.indices(), image.indices());
    assert_all_close(same.values().as_flattened(), image.values().as_flattened(), f64::EPSILON, "the identity");
}

#[test]
fn taps_are_what_a_density_does_to_pixels() {
    let samples = random(24, 77);
    let tent = |r: f64| move |y: f64| (1.0 - y.abs() / r).max(0.0) / r;
    let boxed = |w: f64| move |y: f64| if y.abs() <= 0.5 * w { 1.0 / w } else { 0.0 };
    type Density = Box<dyn Fn(f64) -> f64>;
    let cases: [(Kernel, Density, f64); 8] = [
        (Kernel::boxed(0.5).unwrap(), Box::new(boxed(0.5)), 0.25),
        (Kernel::boxed(2.0).unwrap(), Box::new(boxed(2.0)), 1.0),
        (Kernel::boxed(3.5).unwrap(), Box::new(boxed(3.5)), 1.75),
        (Kernel::boxed(7.0).unwrap(), Box::new(boxed(7.0)), 3.5),
        (Kernel::tent(0.5).unwrap(), Box::new(tent(0.5)), 0.5),
        (Kernel::tent(1.0).unwrap(), Box::new(tent(1.0)), 1.0),
        (Kernel::tent(3.5).unwrap(), Box::new(tent(3.5)), 3.5),
        (
            Kernel::from_cells(-2, &[1.0, -3.0, 2.0, 0.5]).unwrap(),
            Box::new(|y| [1.0, -3.0, 2.0, 0.5][((y + 2.0).floor() as usize).min(3)]),
            2.0,
        ),
    ];
    for (kernel, density, reach) in cases {
        let want = naive::convolve_density(&samples, density, reach, 4000);
        let got = naive::convolve_2d(&samples, 24, [&taps(&kernel), &[(0, 1.0)]]);
        // The midpoint rule over 4000 steps: its error is below 1e-6 (worst seen: 2.1e-7).
        assert_all_close(&got, &want, 5e-7, &format!("{kernel:?}"));
    }
    // Weights of boxes and tents are 1, wherever the closed form changes.
    for width in [1e-300, 1e-3, 0.99, 1.0, 1.01, 1.99, 2.0, 2.01, 3.0, 100.3, 65535.0] {
        for kernel in [Kernel::boxed(width).unwrap(), Kernel::tent(width).unwrap()] {
            let weight: f64 = kernel.taps().iter().sum();
            assert_close(weight, 1.0, 1e-14, &format!("{width}"));
            let turned: Vec<f64> = kernel.taps().iter().rev().copied().collect();
            assert!(kernel.taps() == turned && kernel.taps().iter().all(|&t| t >= 0.0), "{width}");
            assert_eq!(2 * -kernel.first() + 1, kernel.taps().len() as i64);
        }
    }
}

#[test]
fn kernels_chain() {
    let size = [40, 12];
    let mut f = picture(size, 19);
    // Nothing at the borders, so that nothing is lost there in between.
    for (i, f) in f.iter_mut().enumerate() {
        if !(8..32).contains(&(i % 40)) {
            *f = 0.0;
        }
    }
    let image = image::<f64>(size, &f);
    let (a, b, none) =
        (Kernel::boxed(3.0).unwrap(), Kernel::from_taps(-1, &[0.5, 2.0, -1.0]).unwrap(), Kernel::identity());
    let chained = image.convolve([&a, &none]).convolve([&b, &none]);
    let once = image.convolve([&a.then(&b).unwrap(), &none]);
    assert_all_close(&pixels(&chained), &pixels(&once), 6.0 * f64::EPSILON, "one kernel after the other");
    let double = image.convolve([&a.scaled(2.0).unwrap(), &none]);
    let want: Vec<f64> = pixels(&image.convolve([&a, &none])).iter().map(|x| 2.0 * x).collect();
    assert_all_close(&pixels(&double), &want, 0.0, "twice the kernel");
}

#[test]
fn one_place_of_a_convolution_is_a_product_integral() {
    // Weights of 8² pixels over a window of a picture of 16²: by couplings, by the plan of products, by sums.
    let (size, inside) = ([16, 16], [8, 8]);
    let (f, g) = (picture(size, 41), picture(inside, 42));
    let (image, weights) = (image::<f64>(size, &f), image::<f64>(inside, &g));
    let nonstandard = |pixels: &[f64], side: usize| {
        SparseVector::from_dense(&forward_2d(pixels, side, side, Decomposition::Nonstandard).unwrap())
    };
    let (plan, tree) =
        (AffineProduct2d::new([&nonstandard(&f, 16)]).unwrap(), Quadtree::new(&nonstandard(&g, 8)).unwrap());
    for window in windows() {
        let seen = naive::resample_between_2d(&f, 16, inside, window.maps());
        let want = dot(&seen, &g) / 64.0;
        let [got] = image.product_integral(window, &weights).unwrap();
        assert_close(got, want, 0.25 * f64::EPSILON, &format!("{window:?}"));
        // Where |s| is small the plan takes differences of a table: its documented caveat.
        let inverse: f64 = window.maps().iter().map(|map| map.scale().abs().recip().max(1.0)).product();
        let [peer] = plan.integral([&tree], window.maps());
        assert_close(peer, want, 0.0625 * f64::EPSILON * inverse, &format!("{window:?}, by products"));
    }
    // At whole pixels it is the convolution: a kernel of 3 × 3, turned round.
    let kernel = [0.25, 0.5, -1.0];
    let square: Vec<f64> = (0..9).map(|i| kernel[2 - i % 3] * kernel[2 - i / 3]).collect();
    let small = image_of_small(&square);
    let along = Kernel::from_taps(-1, &kernel).unwrap();
    let whole = pixels(&image.convolve([&along, &along]));
    for (x, y) in [(0, 0), (5, 7), (15, 3), (15, 15)] {
        let axis = |at: usize| map(3.0 / 16.0, (at as f64 - 1.0) / 16.0);
        // The integral is over the grid of the weights, 4 × 4 pixels: a sixteenth of their sum.
        let [got] = image.product_integral(ZoomWindow::from_maps([axis(x), axis(y)]), &small).unwrap();
        assert_close(16.0 * got, whole[y * 16 + x], 2.0 * f64::EPSILON, &format!("at {x}, {y}"));
    }
}

fn image_of_small(pixels: &[f64]) -> WaveletImage<f64, 1> {
    image([3, 3], pixels)
}

#[test]
fn sparse_and_dense_coefficients_are_the_same_picture() {
    let size = [6, 4];
    let planes = [picture(size, 1), picture(size, 2)];
    let image = WaveletImage::from_pixels(size, planes.each_ref().map(Vec::as_slice), ALL).unwrap();
    let sparse = [image.channel(0), image.channel(1)];
    assert_eq!(WaveletImage::from_sparse(size, sparse.each_ref()).unwrap(), image);
    // A term that one of the channels lacks.
    let vectors =
        [vec![(0, 1.0), (9, 2.0)], vec![(3, 4.0), (9, 8.0)]].map(|pairs| SparseVector::from_pairs(32, pairs).unwrap());
    let image = WaveletImage::from_sparse(size, vectors.each_ref()).unwrap();
    assert_eq!((image.indices(), image.values()), (&[0, 3, 9][..], &[[1.0, 0.0], [0.0, 4.0], [2.0, 8.0]][..]));
    assert_eq!((image.terms(), image.bytes(), image.grid()), (3, 3 * 20, [8, 4]));
}

#[test]
fn constructors_check_what_they_are_given() {
    let new = |size, indices: &[u32], values: &[[f64; 1]]| WaveletImage::new(size, indices.to_vec(), values.to_vec());
    let range = |result: Result<WaveletImage<f64, 1>, Error>| matches!(result, Err(Error::OutOfRange { .. }));
    assert!(new([3, 2], &[0, 7], &[[1.0], [2.0]]).is_ok());
    assert!(matches!(new([0, 1], &[], &[]), Err(Error::Empty { .. })));
    assert!(matches!(new([1, 0], &[], &[]), Err(Error::Empty { .. })));
    assert!(range(new([usize::MAX, 1], &[], &[])) && range(new([1, 32769], &[], &[])));
    assert!(new([32768, 1], &[], &[]).is_ok());
    assert!(range(new([3, 2], &[8], &[[1.0]])) && range(new([3, 2], &[2, 2], &[[1.0], [1.0]])));
    assert!(range(new([3, 2], &[u32::MAX], &[[1.0]])));
    assert!(matches!(new([3, 2], &[1], &[]), Err(Error::Length { .. })));
    for wrong in [f64::NAN, f64::INFINITY] {
        assert_eq!(
            new([3, 2], &[0, 1], &[[1.0], [wrong]]),
            Err(Error::NotFinite { what: "value of an image's term", index: 1 })
        );
        assert!(matches!(WaveletImage::from_pixels([2, 1], [&[1.0, wrong]], ALL), Err(Error::NotFinite { .. })));
        assert!(matches!(Kernel::from_taps(0, &[1.0, wrong]), Err(Error::NotFinite { index: 1, .. })));
        assert!(Kernel::boxed(wrong).is_err() && Kernel::tent(wrong).is_err() && Kernel::translation(wrong).is_err());
        assert!(ZoomWindow::new([wrong, 0.5], [1.0; 2]).is_err());
        assert!(ZoomWindow::WHOLE.moved([0.0, wrong]).is_err());
    }
    assert!(ZoomWindow::new([0.5; 2], [1.0, f64::NAN]).is_err() && ZoomWindow::new([0.5; 2], [0.0, 1.0]).is_err());
    assert!(ZoomWindow::new([0.5; 2], [f64::INFINITY, 1.0]).is_err());
    assert!(matches!(WaveletImage::<f64>::from_pixels([2, 2], [&[1.0]], ALL), Err(Error::Length { .. })));
    assert!(matches!(WaveletImage::<f64, 0>::from_pixels([1, 1], [], ALL), Err(Error::Empty { .. })));
    assert!(range(WaveletImage::from_pixels([1, 1], [&[1.0]], Keep::Fraction(f64::NAN))));
    assert!(range(image::<f64>([1, 1], &[1.0]).kept(Keep::Fraction(1.5))));
    assert!(WaveletImage::<f64>::from_sparse([3, 2], [&SparseVector::from_dense(&[1.0])]).is_err());
    assert!(WaveletImage::<f64>::from_separable(&[], &[1.0]).is_err());
    assert!(WaveletImage::<f64>::zero([1, 1]).unwrap().plus(&WaveletImage::zero([2, 1]).unwrap()).is_err());
    assert!(WaveletImage::<f64>::zero([1, 1]).unwrap().masked(&WaveletImage::zero([1, 2]).unwrap()).is_err());
    for wrong in [0.0, -1.0, 65536.0] {
        assert!(Kernel::boxed(wrong).is_err() && Kernel::tent(wrong).is_err(), "{wrong}");
    }
    assert!(Kernel::from_taps(0, &[]).is_err() && Kernel::from_cells(0, &[]).is_err());
    assert!(Kernel::from_taps(i64::MAX, &[1.0, 2.0]).is_err() && Kernel::from_taps(i64::MIN, &[1.0]).is_err());
    assert!(Kernel::from_taps(65536, &[1.0]).is_ok() && Kernel::from_taps(65536, &[1.0, 1.0]).is_err());
    assert!(Kernel::identity().scaled(f64::INFINITY).is_err());
    assert!(
        Zoom::new(ZoomWindow::WHOLE, [1, 1], [0, 1]).is_err()
            && Zoom::new(ZoomWindow::WHOLE, [65536, 1], [1, 1]).is_err()
    );
    let zoom = Zoom::new(ZoomWindow::WHOLE, [2, 2], [2, 2]).unwrap();
    let two = image::<f64>([2, 2], &[1.0, 2.0, 3.0, 4.0]);
    for wrong in [&[4][..], &[1, 1], &[2, 1]] {
        assert!(range(zoom.with_targets(ZoomTargets::At(wrong)).apply(&two)), "{wrong:?}");
    }
    assert!(range(zoom.with_targets(ZoomTargets::Largest(Keep::Fraction(-0.1))).apply(&two)));
    // Kept terms: none but the mean, all.
    assert_eq!(two.kept(Keep::Terms(0)).unwrap().indices(), [0]);
    assert_eq!(two.kept(Keep::Terms(usize::MAX)).unwrap(), two);
    assert_eq!(WaveletImage::<f64>::zero([2, 2]).unwrap().kept(ALL).unwrap().terms(), 0);
}

#[test]
#[should_panic(expected = "where the plan has")]
fn a_picture_of_another_size_is_refused() {
    let zoom = Zoom::new(ZoomWindow::WHOLE, [2, 2], [2, 2]).unwrap();
    let _ = zoom.apply(&WaveletImage::<f64>::zero([4, 4]).unwrap());
}

#[test]
fn pixels_are_cheaper_from_some_number_of_terms_on() {
    let size = [128, 128];
    let f = picture(size, 1);
    let zoom = Zoom::new(ZoomWindow::from_maps([map(0.9, 0.03); 2]), size, size).unwrap();
    let mut scratch = ZoomScratch::new();
    let routes = [30, 300, 16384].map(|terms| {
        let image = WaveletImage::<f32>::from_pixels(size, [&narrow(&f)], Keep::Terms(terms)).unwrap();
        let route = zoom.route(&image, &mut scratch);
        assert_eq!(zoom.apply(&image).unwrap(), zoom.with_route(route).apply(&image).unwrap());
        route
    });
    assert_eq!([routes[0], routes[2]], [ImageRoute::Wavelets, ImageRoute::Pixels]);
    for route in ImageRoute::ALL {
        let image = WaveletImage::<f32>::zero(size).unwrap();
        assert_eq!(zoom.with_route(route).route(&image, &mut scratch), route);
    }
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn any_picture_through_any_window(
        image in wavelet_image::<f64, 1>(20, 60),
        to in (1..20usize, 1..20usize),
        x in affine_map(),
        y in affine_map(),
    ) {
        let (from, to) = (image.size(), [to.0, to.1]);
        // Of the whole grid, whose rest is not 0.
        let grid = image.grid();
        let terms = image.indices().iter().map(|&i| i as usize).zip(image.values().iter().map(|v| v[0]));
        let whole = naive::decode_standard(grid, terms);
        let window = ZoomWindow::from_maps([x, y]);
        let Ok(zoom) = Zoom::new(window, from, to) else { return Ok(()) };
        let want = naive::resample_between_2d(&whole, grid[0], zoom.grid(), zoom.maps());
        let shown: Vec<f64> = (0..to[1]).flat_map(|k| want[k * zoom.grid()[0]..][..to[0]].to_vec()).collect();
        for route in ImageRoute::ALL {
            let got = zoom.with_route(route).apply(&image).unwrap();
            assert_all_close(&pixels(&got), &shown, 32.0 * f64::EPSILON * largest(&whole).max(1.0), &format!("{route:?}"));
        }
    }

    #[test]
    fn zooms_and_convolutions_are_linear(seed in any::<u64>(), a in -2.0..2.0f64, x in affine_map(), y in affine_map()) {
        let size = [16, 8];
        let [f, g] = [seed, seed ^ 1].map(|seed| image::<f64>(size, &picture(size, seed)));
        let sum = f.combined(a, &g, 1.0).unwrap();
        let window = ZoomWindow::from_maps([x, y]);
        for route in ImageRoute::ALL {
            let zoom = Zoom::new(window, size, size).unwrap().with_route(route);
            let [f, g, sum] = [&f, &g, &sum].map(|image| zoom.apply(image).unwrap());
            let want = pixels(&f.combined(a, &g, 1.0).unwrap());
            assert_all_close(&pixels(&sum), &want, 10.0 * f64::EPSILON, &format!("{route:?}"));
        }
        let kernel = Kernel::tent(2.5).unwrap();
        let [f, g, sum] = [&f, &g, &sum].map(|image| image.convolve([&kernel, &kernel]));
        let want = pixels(&f.combined(a, &g, 1.0).unwrap());
        assert_all_close(&pixels(&sum), &want, 5.0 * f64::EPSILON, "convolution");
    }
}
