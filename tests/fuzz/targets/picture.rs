//! Readers of pictures, environments and measured reflectance.

use std::sync::OnceLock;

use haarmonic::Result;
use haarmonic::io::{
    EnvironmentLayout, Image, Loaded, encode_exr, encode_hdr, encode_png, read_environment_with, read_exr, read_hdr,
    read_png,
};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Brdf, Lambert, Merl, MerlLookup};
use haarmonic::sphere::CubeGrid;

use super::{NAME, check_error, split};

/// A Radiance HDR picture.
pub fn hdr(data: &[u8]) {
    let (settings, file) = split(data);
    check(settings, file, read_hdr(file, NAME));
}

/// An OpenEXR picture.
pub fn exr(data: &[u8]) {
    let (settings, file) = split(data);
    check(settings, file, read_exr(file, NAME));
}

/// A PNG picture whose chunks get the checksums that belong to them, so that damage goes beyond these.
pub fn png(data: &[u8]) {
    let (settings, file) = split(data);
    let mut file = file.to_vec();
    let mut at = 8;
    while let Some(length) = file.get(at..at + 4) {
        let length = u32::from_be_bytes([length[0], length[1], length[2], length[3]]) as usize;
        let end = at + 8 + length;
        if end + 4 > file.len() {
            break;
        }
        let checksum = crc32fast::hash(&file[at + 4..end]);
        file[end..end + 4].copy_from_slice(&checksum.to_be_bytes());
        at = end + 4;
    }
    check(settings, &file, read_png(&file, NAME));
}

fn layout(settings: usize) -> EnvironmentLayout {
    use EnvironmentLayout::{AngularMap, Auto, Cross, CubeStrip, LatLong, MirrorBall, OpenExrCube};
    [Auto, LatLong, Cross, CubeStrip, OpenExrCube, AngularMap, MirrorBall][settings % 7]
}

/// More pixels are read, but nothing more is done with them.
const MANY_PIXELS: usize = 1 << 12;

fn check(settings: usize, file: &[u8], read: Result<Loaded<Image>>) {
    let Loaded { value: image, warnings } = match read {
        Ok(loaded) => loaded,
        Err(error) => return check_error(&error),
    };
    for warning in &warnings {
        assert!(warning.path.as_os_str() == NAME && !warning.message.is_empty(), "{warning:?}");
    }
    assert_eq!(image.pixels().len(), image.width() * image.height());
    assert!(!image.pixels().is_empty());
    let valid = |p: &Vector3<f32>| p.iter().all(|c| c.is_finite() && *c >= 0.0);
    assert!(image.pixels().iter().all(valid), "a pixel is negative or not finite");
    if image.pixels().len() > MANY_PIXELS {
        return;
    }

    // One thing an input, so that it takes little time.
    match settings / 7 % 4 {
        0 => {
            let exr = encode_exr(&image).expect("pixels are finite");
            assert_eq!(read_exr(&exr, NAME).expect("what is written can be read").value, image);
        }
        1 => {
            let hdr = encode_hdr(&image).expect("pixels are finite");
            let again = read_hdr(&hdr, NAME).expect("what is written can be read").value;
            assert_eq!((again.width(), again.height()), (image.width(), image.height()));
        }
        2 => {
            let png = encode_png(&image, 0.0).expect("sides are short");
            let again = read_png(&png, NAME).expect("what is written can be read").value;
            assert_eq!((again.width(), again.height()), (image.width(), image.height()));
        }
        _ => match read_environment_with(file, NAME, layout(settings)) {
            Ok(light) => {
                let cube = light.value.to_cube(CubeGrid::new(2).expect("2 is a side"));
                assert!(cube.texels().iter().all(valid), "a texel of the light is negative or not finite");
            }
            Err(error) => check_error(&error),
        },
    }
}

/// A measured BRDF: a file, or edits of a good one, or directions in which one is looked up.
///
/// A file has 35 MB: one that is whole takes far longer than all else. Inputs that edit one say so in a whole word, so
/// that a fuzzer comes to it seldom.
pub fn merl(data: &[u8]) {
    if let Some(directions) = data.strip_prefix(b"d") {
        static TABLE: OnceLock<[Merl; 2]> = OnceLock::new();
        let tables = TABLE.get_or_init(|| {
            let read = || Merl::from_bytes(merl_file()).expect("the file is good");
            [read(), read().with_lookup(MerlLookup::Nearest)]
        });
        return tables.iter().for_each(|table| merl_look_up(table, directions));
    }
    let (_, file) = split(data);
    match Merl::read(file, NAME) {
        Ok(_) => panic!("{} bytes are not all of a file", file.len()),
        Err(error) => check_error(&error),
    }
    assert!(Merl::from_bytes(file).is_err());
}

fn merl_file() -> &'static [u8] {
    static FILE: OnceLock<Vec<u8>> = OnceLock::new();
    FILE.get_or_init(|| Merl::bytes_from(&Lambert::new([0.5, 0.25, 0.125]).expect("albedos are in [0, 1]")))
}

/// A good file with edits: a place of 4 bytes and 8 bytes that go there; what is left over is cut off the end or
/// appended. A file has 35 MB, so that some eighty a second are read.
pub fn merl_edits(data: &[u8]) {
    let (_, edits) = split(data);
    let mut file = merl_file().to_vec();
    let (edits, rest) = edits.as_chunks::<12>();
    for edit in edits {
        let place = u32::from_le_bytes([edit[0], edit[1], edit[2], edit[3]]) as usize % (file.len() - 8);
        file[place..place + 8].copy_from_slice(&edit[4..]);
    }
    match rest {
        [] => {}
        [cut] => file.truncate(file.len() - 1 - usize::from(*cut)),
        more => file.extend_from_slice(more),
    }
    match Merl::read(&file[..], NAME) {
        Ok(table) => {
            assert_eq!(file.len(), Merl::FILE_LEN);
            let directions: Vec<u8> = edits.iter().flatten().copied().collect();
            merl_look_up(&table, &directions);
        }
        Err(error) => check_error(&error),
    }
}

fn merl_look_up(table: &Merl, numbers: &[u8]) {
    let vectors: Vec<Vector3<f64>> = numbers
        .as_chunks::<4>()
        .0
        .as_chunks::<3>()
        .0
        .iter()
        .map(|v| Vector3::from(v.map(|c| f64::from(f32::from_le_bytes(c)))))
        .collect();
    for pair in vectors.windows(2) {
        // Directions are unit vectors; others need only not panic.
        let _ = table.eval(&pair[0], &pair[1]);
        if pair.iter().all(|v| v.norm().is_finite() && v.norm() > 0.0) {
            let value = table.eval(&pair[0].normalize(), &pair[1].normalize());
            assert!(value.iter().all(|c| c.is_finite() && *c >= 0.0), "{pair:?}: {value:?}");
        }
    }
}
