//! Images whose numbers are no light: they come as the file has them.

use haarmonic::Error;
use haarmonic::io::{
    Image, ImageEncoding, PngDepth, encode_exr, encode_hdr, encode_png_data, encode_png_srgb8, load_image_with,
    read_image, read_image_with, save_png_data,
};
use haarmonic::nalgebra::Vector3;

use super::{assert_all, exr_files, messages};

fn data(bytes: &[u8]) -> Image {
    let loaded = read_image_with(bytes, "a", ImageEncoding::Data).unwrap();
    assert_eq!(messages(&loaded), [""; 0]);
    loaded.value
}

/// A picture with values below 0, in [0, 1] and above.
fn ramp(from: f32, to: f32) -> Image {
    let n = 61;
    let pixel = |i: usize| {
        let at = |k: usize| from + (to - from) * ((i + 7 * k) % n) as f32 / (n - 1) as f32;
        Vector3::new(at(0), at(1), at(2))
    };
    Image::new(n, 1, (0..n).map(pixel).collect()).unwrap()
}

#[test]
fn png_comes_back_within_half_a_step() {
    for (depth, full) in [(PngDepth::Eight, 255.0), (PngDepth::Sixteen, 65535.0_f32)] {
        let image = ramp(-0.5, 1.5);
        let back = data(&encode_png_data(&image, depth).unwrap());
        assert_eq!((back.width(), back.height()), (image.width(), 1));
        let mut largest = 0.0_f32;
        for (a, b) in image.pixels().iter().zip(back.pixels()) {
            largest = largest.max((a.map(|c| c.clamp(0.0, 1.0)) - b).amax());
        }
        // A rounding of f32 beside the half step; and it is rounding, not truncation.
        assert!(largest <= 0.5 / full + 6e-8 && largest > 0.4 / full, "{}", largest * full);
        // Every step is itself.
        let again = data(&encode_png_data(&back, depth).unwrap());
        assert_eq!(again, back);
    }
    for bad in [f32::NAN, f32::INFINITY] {
        let image = Image::new(2, 1, vec![Vector3::zeros(), Vector3::new(0.0, bad, 0.0)]).unwrap();
        assert!(matches!(encode_png_data(&image, PngDepth::Eight), Err(Error::NotFinite { index: 1, .. })));
    }
}

#[test]
fn png_samples_are_not_decoded() {
    let bytes = encode_png_srgb8(1, 1, &[[128, 0, 255]]).unwrap();
    assert_eq!(data(&bytes).pixel(0, 0), Vector3::new(128.0 / 255.0, 0.0, 1.0));
    assert!((read_image(&bytes, "a").unwrap().value.pixel(0, 0).x - 0.215_860_5).abs() < 1e-6);
    // Chunks that speak of colour change nothing and are no warnings.
    let numbers = |values: &[u32]| values.iter().flat_map(|v| v.to_be_bytes()).collect::<Vec<_>>();
    let primaries = numbers(&[31270, 32900, 70800, 29200, 17000, 79700, 13100, 4600]);
    let chunks = [("gAMA", numbers(&[100_000])), ("cHRM", primaries), ("cICP", vec![9, 16, 0, 1])];
    for chunks in [&chunks[..2], &chunks[..]] {
        let bytes = super::png::file(128, chunks);
        assert_all(&data(&bytes), [128.0 / 255.0; 3], 0.0);
        assert!(!read_image(&bytes, "a").unwrap().warnings.is_empty());
    }
}

#[test]
fn png_alpha_is_dropped_with_a_warning() {
    use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
    let mut bytes = Vec::new();
    let samples = [1000_u16, 2000, 65535, 3].map(u16::to_ne_bytes).concat();
    PngEncoder::new(&mut bytes).write_image(&samples, 1, 1, ExtendedColorType::Rgba16).unwrap();
    let loaded = read_image_with(&bytes, "a", ImageEncoding::Data).unwrap();
    assert_eq!(loaded.value.pixel(0, 0), Vector3::new(1000.0, 2000.0, 65535.0) / 65535.0);
    assert_eq!(messages(&loaded), ["a: alpha dropped; 1 pixels are not opaque"]);
}

#[test]
fn exr_keeps_negatives_and_primaries() {
    let image = ramp(-2.0, 3.0);
    let bytes = encode_exr(&image).unwrap();
    assert_eq!(data(&bytes), image);
    let cut = read_image(&bytes, "a").unwrap();
    assert_eq!(cut.value.pixel(0, 0).x, 0.0);
    assert_eq!(messages(&cut).len(), 1);
    let wide = [0.708_f32, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329].map(f32::to_le_bytes).concat();
    let bytes = exr_files::with_attribute(&bytes, "chromaticities", "chromaticities", &wide);
    assert_eq!(data(&bytes), image);
    assert_eq!(messages(&read_image(&bytes, "a").unwrap()).len(), 2);
}

#[test]
fn nan_is_refused_in_data_too() {
    let image = Image::new(1, 1, vec![Vector3::new(1.5, -1.5, 0.0)]).unwrap();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        // An uncompressed block: a single pixel does not shrink.
        let mut bytes = encode_exr(&image).unwrap();
        let at = bytes.windows(4).position(|w| w == 1.5_f32.to_le_bytes()).expect("stored as it is");
        bytes[at..at + 4].copy_from_slice(&bad.to_le_bytes());
        let error = read_image_with(&bytes, "a", ImageEncoding::Data).unwrap_err();
        assert_eq!(error.to_string(), "a, pixel (0, 0): NaN or infinite");
    }
}

#[test]
fn hdr_numbers_are_as_stored() {
    let pixel = [128, 64, 32, 129];
    for lines in [
        "EXPOSURE=4\n",
        "EXPOSURE=zero\nCOLORCORR=1 2 3\n",
        "PRIMARIES=0.708 0.292 0.17 0.797 0.131 0.046 0.3127 0.329\n",
        "FORMAT=32-bit_rle_xyze\n",
    ] {
        let header = format!("#?RADIANCE\n{lines}\n-Y 1 +X 2\n");
        let bytes = [header.as_bytes(), &pixel, &pixel].concat();
        assert_all(&data(&bytes), [1.0, 0.5, 0.25], 0.0);
        assert!(!read_image(&bytes, "a").unwrap().warnings.is_empty());
    }
    let bytes = b"#?RADIANCE\nFORMAT=other\n\n-Y 1 +X 1\n\0\0\0\0";
    assert!(read_image_with(bytes, "a", ImageEncoding::Data).is_err());
}

#[test]
fn the_default_is_radiance() {
    assert_eq!(ImageEncoding::default(), ImageEncoding::Radiance);
    let image = ramp(-2.0, 3.0);
    for bytes in [encode_exr(&image).unwrap(), encode_hdr(&ramp(0.0, 3.0)).unwrap()] {
        assert_eq!(read_image(&bytes, "a"), read_image_with(&bytes, "a", ImageEncoding::Radiance));
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.png");
    save_png_data(&path, &image, PngDepth::Sixteen).unwrap();
    let loaded = load_image_with(&path, ImageEncoding::Data).unwrap();
    assert_eq!(loaded.value, data(&encode_png_data(&image, PngDepth::Sixteen).unwrap()));
}
