//! Primaries and white of pictures.

use haarmonic::io::{Image, Loaded, encode_exr, load_image, read_exr};
use haarmonic::nalgebra::Vector3;

use super::exr_files::with_attribute;
use super::{assert_all, fault, messages, only_message};

const REC_709: [f32; 8] = [0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329];
const REC_2020: [f32; 8] = [0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329];

fn read(chromaticities: [f32; 8], pixel: [f32; 3]) -> Loaded<Image> {
    let image = Image::new(3, 2, vec![Vector3::from(pixel); 6]).unwrap();
    let value: Vec<u8> = chromaticities.iter().flat_map(|c| c.to_le_bytes()).collect();
    let bytes = with_attribute(&encode_exr(&image).unwrap(), "chromaticities", "chromaticities", &value);
    read_exr(&bytes, "a.exr").unwrap()
}

#[test]
fn rec_2020_becomes_rec_709() {
    let loaded = load_image(fault("rec2020.exr")).unwrap();
    assert_all(&loaded.value, [0.2, 0.6, 0.4], 0.002);
    let message = only_message(&loaded);
    let expected = "header, chromaticities: pixels converted from the primaries Rec. 2020 to those of Rec. 709";
    assert!(message.ends_with(expected), "{message}");
}

#[test]
fn rec_709_is_left_alone_within_rounding() {
    let pixel = [0.1234567, 3.4567e-5, 7654.321];
    for change in [0.0, 4e-4, -4e-4] {
        let chromaticities = REC_709.map(|c| c + change);
        let loaded = read(chromaticities, pixel);
        assert_eq!(messages(&loaded), [""; 0]);
        assert_eq!(loaded.value.pixels(), [Vector3::from(pixel); 6]);
    }
    // D65 to five digits.
    let mut exact = REC_709;
    exact[6..].copy_from_slice(&[0.31271, 0.32902]);
    assert_eq!(messages(&read(exact, pixel)), [""; 0]);
}

/// Pixels of the primaries, by the published matrices to Rec. 709.
#[test]
fn primaries_that_have_a_name() {
    let d65 = [0.3127, 0.329];
    let with_white = |rgb: [f32; 6], w: [f32; 2]| {
        let mut all = [0.0; 8];
        all[..6].copy_from_slice(&rgb);
        all[6..].copy_from_slice(&w);
        all
    };
    // Each white stays white.
    for (name, chromaticities) in [
        ("Rec. 2020", REC_2020),
        ("Display P3", with_white([0.68, 0.32, 0.265, 0.69, 0.15, 0.06], d65)),
        ("DCI-P3", with_white([0.68, 0.32, 0.265, 0.69, 0.15, 0.06], [0.314, 0.351])),
        ("ACES AP0", with_white([0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077], [0.32168, 0.33767])),
        ("ACES AP1", with_white([0.713, 0.293, 0.165, 0.83, 0.128, 0.044], [0.32168, 0.33767])),
        ("Adobe RGB", with_white([0.64, 0.33, 0.21, 0.71, 0.15, 0.06], d65)),
        ("ProPhoto RGB", with_white([0.7347, 0.2653, 0.1596, 0.8404, 0.0366, 0.0001], [0.3457, 0.3585])),
        ("Radiance", with_white([0.64, 0.33, 0.29, 0.6, 0.15, 0.06], [0.3333, 0.3333])),
        (
            "red 0.5 0.25, green 0.25 0.5, blue 0.125 0.125, white 0.25 0.25",
            with_white([0.5, 0.25, 0.25, 0.5, 0.125, 0.125], [0.25, 0.25]),
        ),
    ] {
        let loaded = read(chromaticities, [0.75; 3]);
        // Chromaticities are rounded to f32, and some of the files' to four digits.
        assert_all(&loaded.value, [0.75; 3], 1e-6);
        let expected =
            format!("a.exr, header, chromaticities: pixels converted from the primaries {name} to those of Rec. 709");
        assert_eq!(only_message(&loaded), expected);
    }
    // A colour of ACEScg.
    let ap1 = read(with_white([0.713, 0.293, 0.165, 0.83, 0.128, 0.044], [0.32168, 0.33767]), [1.0, 0.5, 0.25]);
    // Rows of AP1 → Rec. 709: (1.70505 −.62179 −.08326), (−.13026 1.14080 −.01055), (−.02400 −.12897 1.15297).
    assert_all(&ap1.value, [1.37334, 0.43750, 0.19976], 5e-4);
}

/// XYZ is converted as it is: the white of its axes is that of no picture.
#[test]
fn xyz() {
    for third in [1.0 / 3.0, 0.3333, 0.333] {
        let xyz = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0, third, third];
        // D65 as XYZ, IEC 61966-2-1.
        let loaded = read(xyz, [0.9505, 1.0, 1.089]);
        assert_all(&loaded.value, [1.0; 3], 3e-4);
        let expected =
            "a.exr, header, chromaticities: pixels converted from the primaries CIE XYZ to those of Rec. 709";
        assert_eq!(only_message(&loaded), expected);
        // The red, green and blue of Rec. 709.
        for (i, column) in
            [[0.4124, 0.2126, 0.0193], [0.3576, 0.7152, 0.1192], [0.1805, 0.0722, 0.9505]].iter().enumerate()
        {
            let got = read(xyz, *column).value.pixel(0, 0);
            assert!((got - Vector3::ith(i, 1.0)).amax() < 5e-4, "{got}");
        }
    }
}

#[test]
fn colours_outside_of_rec_709_are_cut_with_a_warning() {
    let loaded = read(REC_2020, [1.0, 0.0, 0.0]);
    let all = messages(&loaded);
    assert_eq!(all.len(), 2, "{all:?}");
    assert!(all[1].starts_with("a.exr, pixel (0, 0): 6 negative pixels set to 0"), "{all:?}");
    assert_all(&loaded.value, [1.6605, 0.0, 0.0], 2e-4);
    // What is largest stays finite.
    let largest = read(REC_2020, [f32::MAX, 0.0, 0.0]).value;
    assert_eq!(largest.pixel(0, 0).x, f32::MAX);
}

#[test]
fn chromaticities_that_span_no_colours_are_ignored_with_a_warning() {
    let nan = f32::NAN;
    for chromaticities in [
        [0.0; 8],
        [nan; 8],
        [f32::INFINITY, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329],
        [1e30; 8],
        // Three primaries on a line; two that are the same; a white without luminance; a white outside the triangle.
        [0.2, 0.2, 0.3, 0.3, 0.4, 0.4, 0.3127, 0.329],
        [0.64, 0.33, 0.64, 0.33, 0.15, 0.06, 0.3127, 0.329],
        [0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.0],
        [0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.7, 0.3],
        [0.64, 0.33, 0.3, 0.6, 0.15, 0.06, nan, 0.329],
    ] {
        let loaded = read(chromaticities, [0.5, 1.0, 2.0]);
        assert_eq!(loaded.value.pixels(), [Vector3::new(0.5, 1.0, 2.0); 6], "{chromaticities:?}");
        let message = only_message(&loaded);
        assert!(message.starts_with("a.exr, header, chromaticities: the primaries (red "), "{message}");
        assert!(message.ends_with(") span no colours; ignored"), "{message}");
    }
}

/// A lone Y is as bright and as white in any primaries.
#[test]
fn grey_is_grey() {
    use exr::prelude::{Blocks, Compression, SampleType};
    let grey = super::exr_files::file(&["Y"], &[SampleType::F32], Compression::ZIP16, (3, 2), Blocks::ScanLines, false);
    let value: Vec<u8> = REC_2020.iter().flat_map(|c| c.to_le_bytes()).collect();
    let tagged = with_attribute(&grey, "chromaticities", "chromaticities", &value);
    assert_eq!(read_exr(&tagged, "a.exr").unwrap(), read_exr(&grey, "a.exr").unwrap());
}
