//! What PNG files say of their colours.

use haarmonic::io::{encode_png_srgb8, read_png};

use super::{assert_all, messages, only_message};

/// A grey picture with chunks before its pixels.
pub fn file(level: u8, chunks: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = encode_png_srgb8(2, 2, &[[level; 3]; 4]).unwrap();
    // Behind the signature and the header chunk of 13 bytes.
    let at = 8 + 12 + 13;
    let mut inserted = Vec::new();
    for (name, data) in chunks {
        let named = [name.as_bytes(), data].concat();
        inserted.extend((data.len() as u32).to_be_bytes());
        inserted.extend(&named);
        inserted.extend(crc(&named).to_be_bytes());
    }
    bytes.splice(at..at, inserted);
    bytes
}

fn crc(bytes: &[u8]) -> u32 {
    let step = |c: u32, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 };
    !bytes.iter().fold(u32::MAX, |c, b| (0..8).fold(c ^ u32::from(*b), step))
}

fn numbers(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| ((v * 1e5).round() as u32).to_be_bytes()).collect()
}

/// What sRGB makes of 128 / 255.
const SRGB_128: f32 = 0.215_860_5;

#[test]
fn gamma() {
    for srgb in [0.45455, 0.4545, 0.45, 0.46] {
        let loaded = read_png(&file(128, &[("gAMA", numbers(&[srgb]))]), "a.png").unwrap();
        assert_eq!(messages(&loaded), [""; 0], "{srgb}");
        assert_all(&loaded.value, [SRGB_128; 3], 1e-6);
    }
    // 8 bits as a fraction; the power in f32 is off by a few ulp.
    for (gamma, message, value) in [
        (1.0, "the samples are linear; read so", 128.0 / 255.0),
        (0.5, "the samples are encoded with the gamma 0.5, not as sRGB; read so", (128.0f32 / 255.0).powi(2)),
        (0.0, "a gamma of 0 cannot be; taken as sRGB", SRGB_128),
        (42949.67295, "a gamma of 42949.67295 cannot be; taken as sRGB", SRGB_128),
    ] {
        let loaded = read_png(&file(128, &[("gAMA", numbers(&[gamma]))]), "a.png").unwrap();
        assert_eq!(only_message(&loaded), format!("a.png, chunk gAMA: {message}"));
        assert_all(&loaded.value, [value; 3], 1e-6);
    }
    // The chunk sRGB goes before it.
    let loaded = read_png(&file(128, &[("gAMA", numbers(&[1.0])), ("sRGB", vec![0])]), "a.png").unwrap();
    assert_eq!(messages(&loaded), [""; 0]);
    assert_all(&loaded.value, [SRGB_128; 3], 1e-6);
}

#[test]
fn primaries() {
    let rec_709 = [0.3127, 0.329, 0.64, 0.33, 0.3, 0.6, 0.15, 0.06];
    let loaded = read_png(&file(128, &[("gAMA", numbers(&[0.45455])), ("cHRM", numbers(&rec_709))]), "a.png").unwrap();
    assert_eq!(messages(&loaded), [""; 0]);
    let p3 = [0.3127, 0.329, 0.68, 0.32, 0.265, 0.69, 0.15, 0.06];
    let loaded = read_png(&file(128, &[("cHRM", numbers(&p3))]), "a.png").unwrap();
    let expected = "a.png, chunk cHRM: pixels converted from the primaries Display P3 to those of Rec. 709";
    assert_eq!(only_message(&loaded), expected);
    assert_all(&loaded.value, [SRGB_128; 3], 1e-6);
    let loaded = read_png(&file(128, &[("cHRM", numbers(&[0.0; 8]))]), "a.png").unwrap();
    assert!(only_message(&loaded).ends_with("span no colours; ignored"));
}

#[test]
fn profiles() {
    // zlib of stored bytes: one final block.
    let profile = |name: &str, text: &[u8]| {
        let length = text.len() as u16;
        let (mut a, mut b) = (1_u32, 0_u32);
        for byte in text {
            a = (a + u32::from(*byte)) % 65521;
            b = (b + a) % 65521;
        }
        let mut data = [name.as_bytes(), &[0, 0, 0x78, 0x01, 1]].concat();
        data.extend(length.to_le_bytes());
        data.extend((!length).to_le_bytes());
        data.extend(text);
        data.extend((b << 16 | a).to_be_bytes());
        vec![("iCCP", data)]
    };
    for chunks in [
        profile("sRGB IEC61966-2.1", b"whatever"),
        profile("ICC profile", b"GIMP built-in sRGB"),
        profile("icc", b"\0s\0R\0G\0B\0 \0I\0E\0C"),
        vec![("cICP", vec![1, 13, 0, 1])],
    ] {
        let loaded = read_png(&file(128, &chunks), "a.png").unwrap();
        assert_eq!(messages(&loaded), [""; 0], "{chunks:?}");
        assert_all(&loaded.value, [SRGB_128; 3], 1e-6);
    }
    for (chunks, message) in [
        (
            profile("Display P3", b"Display P3"),
            "chunk iCCP: the colour profile \"Display P3\" is ignored; taken as sRGB all the same",
        ),
        (
            vec![("iCCP", b"x\0\0damaged".to_vec())],
            "chunk iCCP: the colour profile \"x\" is ignored; taken as sRGB all the same",
        ),
        (
            vec![("cICP", vec![9, 16, 0, 1])],
            "chunk cICP: primaries 9 and curve 16 are not those of sRGB; taken as sRGB all the same",
        ),
        (
            vec![("cICP", vec![1, 8, 0, 1])],
            "chunk cICP: primaries 1 and curve 8 are not those of sRGB; taken as sRGB all the same",
        ),
    ] {
        let loaded = read_png(&file(128, &chunks), "a.png").unwrap();
        assert_eq!(only_message(&loaded), format!("a.png, {message}"));
        assert_all(&loaded.value, [SRGB_128; 3], 1e-6);
    }
}

/// Found by fuzzing: the decoder panics on a palette that ends within a colour.
#[test]
fn palettes_that_are_cut() {
    let error = read_png(&file(128, &[("PLTE", vec![7; 13])]), "a.png").unwrap_err().to_string();
    assert_eq!(error, "a.png, chunk PLTE: 13 bytes are not three a colour; save the picture again");
}
