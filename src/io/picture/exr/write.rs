//! The writer: float R, G and B in blocks of 16 lines, each compressed by ZIP.

use crate::io::Image;
use crate::io::picture::check_finite;
use crate::{Error, Result};

/// Lines of a block.
const LINES: usize = 16;
/// The usual compromise of EXR writers between time and size.
const LEVEL: u8 = 4;

/// The bytes of a picture as OpenEXR: R, G, B as 32-bit float, ZIP-compressed, which loses nothing.
///
/// # Errors
/// [`Error::NotFinite`] for a pixel that is NaN or infinite, which [`read_exr`](super::read_exr) would not read;
/// [`Error::File`] if the picture is too large for the format.
pub fn encode_exr(image: &Image) -> Result<Vec<u8>> {
    check_finite(image)?;
    let (width, height) = (image.width(), image.height());
    // A block's size, and with it either side, is a positive 32-bit number.
    let limit = i32::MAX as usize;
    if width > limit / (12 * LINES) || height > limit {
        let reason = format!("{width} × {height} pixels are too large for the format");
        return Err(Error::File { path: "EXR".into(), place: String::new(), reason });
    }
    let blocks = height.div_ceil(LINES);
    let mut out = header(width as i32, height as i32, blocks as i32);
    let table = out.len();
    out.resize(table + 8 * blocks, 0);
    let mut raw = Vec::with_capacity(12 * width * LINES);
    for (i, lines) in image.pixels().chunks(width * LINES).enumerate() {
        let offset = (out.len() as u64).to_le_bytes();
        out[table + 8 * i..][..8].copy_from_slice(&offset);
        raw.clear();
        for line in lines.chunks_exact(width) {
            // Channels are in the order of their names.
            for channel in [2, 1, 0] {
                raw.extend(line.iter().flat_map(|pixel| pixel[channel].to_le_bytes()));
            }
        }
        let compressed = miniz_oxide::deflate::compress_to_vec_zlib(&predict(&raw), LEVEL);
        // A reader takes data of full size as not compressed.
        let data = if compressed.len() < raw.len() { &compressed } else { &raw };
        out.extend_from_slice(&((i * LINES) as i32).to_le_bytes());
        out.extend_from_slice(&(data.len() as i32).to_le_bytes());
        out.extend_from_slice(data);
    }
    Ok(out)
}

fn header(width: i32, height: i32, blocks: i32) -> Vec<u8> {
    let mut out = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        for text in [name, kind] {
            out.extend_from_slice(text.as_bytes());
            out.push(0);
        }
        out.extend_from_slice(&(value.len() as i32).to_le_bytes());
        out.extend_from_slice(value);
    };
    let numbers = |numbers: &[i32]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<_>>();
    let mut channels = Vec::new();
    for name in [b'B', b'G', b'R'] {
        channels.extend_from_slice(&[name, 0]);
        // Float samples, not linear only for the eye, one for each pixel across and down.
        channels.extend(numbers(&[2, 0, 1, 1]));
    }
    channels.push(0);
    let window = numbers(&[0, 0, width - 1, height - 1]);
    attribute("channels", "chlist", &channels);
    attribute("chunkCount", "int", &numbers(&[blocks]));
    attribute("compression", "compression", &[3]);
    attribute("dataWindow", "box2i", &window);
    attribute("displayWindow", "box2i", &window);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
    out.push(0);
    out
}

/// Bytes at even places, then those at odd ones, each but the first as its difference to the one before, plus 128.
fn predict(raw: &[u8]) -> Vec<u8> {
    let halves = raw.iter().step_by(2).chain(raw.iter().skip(1).step_by(2));
    let mut last = 128_u8;
    halves.map(|&byte| byte.wrapping_sub(std::mem::replace(&mut last, byte)).wrapping_add(128)).collect()
}
