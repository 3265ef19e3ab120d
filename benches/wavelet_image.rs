//! Zooms into a compressed picture, in the wavelet domain and by way of pixels; masks and convolutions.
//!
//! A picture of 1024², one and three channels, f32, one thread. Both sides choose the terms of the result that are
//! kept. The peer of the zoom is decompression, resampling, transform and selection, by the vectorised bands and
//! column transforms of the engine's own pixel route (`bands`), and as a program without a library would write it
//! (`plain`): a full inverse transform, four bilinear samples a pixel, a forward transform, a selection.

#[path = "../examples/wavelet_zoom/picture.rs"]
mod picture;
#[path = "../examples/wavelet_zoom/plain.rs"]
mod plain;

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use haarmonic::affine::{ImageRoute, Kernel, WaveletImage, Zoom, ZoomScratch, ZoomTargets, ZoomWindow};
use haarmonic::haar::Keep;

const SIDE: usize = 1024;
const SIZE: [usize; 2] = [SIDE; 2];

fn photograph<const C: usize>(keep: Keep) -> WaveletImage<f32, C> {
    let planes = picture::photograph(SIDE);
    WaveletImage::from_pixels(SIZE, std::array::from_fn(|c| &planes[c % 3][..]), keep).expect("as many pixels")
}

fn zooms<const C: usize>(criterion: &mut Criterion) {
    let free = ZoomWindow::new(picture::FACADE, [4.0, 4.0]).expect("a zoom by 4");
    let snapped = free.snapped(SIZE).expect("a window of the picture");
    let mut group = criterion.benchmark_group(format!("zoom 1024², {C} channels"));
    for source in [0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0] {
        let image = photograph::<C>(Keep::Fraction(source / 100.0));
        for target in [1.0, 10.0, 100.0] {
            let keep =
                if target == 100.0 { ZoomTargets::All } else { ZoomTargets::Largest(Keep::Fraction(target / 100.0)) };
            let mut scratch = ZoomScratch::new();
            for (name, window) in [("wavelets", free), ("wavelets, snapped", snapped), ("bands", free)] {
                let route = if name == "bands" { ImageRoute::Pixels } else { ImageRoute::Wavelets };
                if route == ImageRoute::Wavelets && source > 30.0 && C > 1 {
                    continue;
                }
                let zoom =
                    Zoom::new(window, SIZE, SIZE).expect("sizes of pictures").with_targets(keep).with_route(route);
                group.bench_function(BenchmarkId::new(name, format!("{source} % to {target} %")), |b| {
                    b.iter(|| black_box(&zoom).apply_with(&image, &mut scratch));
                });
            }
            if C == 1 {
                let mut plain = plain::Plain::new(SIDE);
                let dense = image.channel(0).to_dense();
                let keep = Keep::Fraction(target / 100.0);
                group.bench_function(BenchmarkId::new("plain", format!("{source} % to {target} %")), |b| {
                    b.iter(|| plain.zoom(&dense, black_box(free), keep));
                });
            }
        }
    }
    group.finish();
}

fn edits(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("edit 1024², 3 channels");
    let ramp: Vec<f32> = (0..SIDE).map(|k| k as f32 / SIDE as f32).collect();
    let part: Vec<f32> = (0..SIDE).map(|k| f32::from(u8::from((300..700).contains(&k)))).collect();
    let gradient = WaveletImage::from_separable(&vec![1.0; SIDE], &ramp).expect("samples");
    let rectangle = WaveletImage::from_separable(&part, &part).expect("samples");
    let kernels = [Kernel::boxed(3.0), Kernel::tent(8.0)].map(|kernel| kernel.expect("a width"));
    for source in [0.1, 1.0, 10.0] {
        let image = photograph::<3>(Keep::Fraction(source / 100.0));
        for route in ImageRoute::ALL {
            for (name, mask) in [("gradient", &gradient), ("rectangle", &rectangle)] {
                group.bench_function(
                    BenchmarkId::new(format!("mask, {name}, {route:?}"), format!("{source} %")),
                    |b| {
                        b.iter(|| image.masked_by(route, black_box(mask)));
                    },
                );
            }
            for (name, kernel) in ["box of 3", "tent of 16"].into_iter().zip(&kernels) {
                group.bench_function(
                    BenchmarkId::new(format!("blur, {name}, {route:?}"), format!("{source} %")),
                    |b| {
                        b.iter(|| image.convolve_by(route, black_box([kernel, kernel])));
                    },
                );
            }
        }
        group.bench_function(BenchmarkId::new("contrast", format!("{source} %")), |b| {
            b.iter(|| image.adjusted(black_box([1.5; 3]), [-0.1; 3]));
        });
    }
    group.finish();
}

criterion_group! {
    name = wavelet_image;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_millis(500));
    targets = zooms::<1>, zooms::<3>, edits
}
criterion_main!(wavelet_image);
