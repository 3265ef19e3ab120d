//! PNG, by the crate `image`.

use std::io::Cursor;

use ::image::codecs::png::{PngDecoder, PngEncoder};
use ::image::{ColorType, ExtendedColorType, ImageDecoder, ImageEncoder};
use nalgebra::Vector3;

use super::image::{check_size, finish};
use super::{Image, Loaded, Report};
use crate::scene::{linear_to_srgb, srgb_to_linear};
use crate::{Error, Result};

/// Reads a PNG picture from its bytes; `name` is what messages call it.
///
/// Grey, colour and palette pictures of 1 to 16 bits. Pixels are taken as sRGB-encoded, whatever `gAMA` or an ICC
/// profile says, and decoded to linear. Alpha is dropped; if any pixel is not opaque, with a warning.
///
/// # Errors
/// [`Error::File`] if the file is damaged, cut short or has more than [`Image::MAX_PIXELS`] pixels.
pub fn read_png(bytes: &[u8], name: impl AsRef<std::path::Path>) -> Result<Loaded<Image>> {
    let mut report = Report::new(name);
    if bytes.is_empty() {
        return Err(report.error("", "the file is empty"));
    }
    let decoder = PngDecoder::new(Cursor::new(bytes)).map_err(|e| report.error("header", e.to_string()))?;
    let (width, height) = decoder.dimensions();
    let (width, height) = (width as usize, height as usize);
    check_size(&report, "header", width, height)?;
    // Deflate expands at most 1032 times, and expansion of 1-bit pixels to 8 bits another 8 (palette: 32) times.
    let kind = decoder.color_type();
    if decoder.total_bytes() / (1032 * 32) > bytes.len() as u64 {
        let reason = format!("{width} × {height} pixels cannot come from {} bytes", bytes.len());
        return Err(report.error("header", reason));
    }
    let mut raw = vec![0; decoder.total_bytes() as usize];
    decoder.read_image(&mut raw).map_err(|e| report.error("pixels", e.to_string()))?;

    let (colour, channels) = match kind {
        ColorType::L8 | ColorType::L16 => (false, 1),
        ColorType::La8 | ColorType::La16 => (false, 2),
        ColorType::Rgb8 | ColorType::Rgb16 => (true, 3),
        ColorType::Rgba8 | ColorType::Rgba16 => (true, 4),
        _ => return Err(report.error("header", format!("pixels of type {kind:?} cannot be read"))),
    };
    let wide = matches!(kind, ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16);
    let size = if wide { 2 } else { 1 };
    // 16-bit samples come in the machine's byte order.
    let sample = |s: &[u8]| if wide { u16::from_ne_bytes([s[0], s[1]]) } else { u16::from(s[0]) };
    let full = if wide { u16::MAX } else { 255 };
    let linear: Vec<f32> = (0..=full).map(|s| srgb_to_linear(f32::from(s) / f32::from(full))).collect();
    let mut transparent = 0_usize;
    let pixels = (raw.chunks_exact(channels * size))
        .map(|p| {
            let mut samples = p.chunks_exact(size).map(sample);
            let mut next = || samples.next().unwrap_or(full);
            let r = next();
            let (g, b) = if colour { (next(), next()) } else { (r, r) };
            transparent += usize::from(next() != full);
            Vector3::new(r, g, b).map(|s| linear[usize::from(s)])
        })
        .collect();
    if transparent > 0 {
        report.warn("", format!("alpha dropped; {transparent} pixels are not opaque"));
    }
    finish(report, width, height, pixels)
}

/// The bytes of a picture as PNG: 8 bits, sRGB-encoded.
///
/// Pixels are multiplied by 2^`exposure`, encoded and rounded to nearest; NaN and negative channels become 0, what is
/// above 1 becomes 255.
///
/// # Errors
/// [`Error::File`] if the picture has more than 2³² − 1 pixels along a side.
pub fn encode_png(image: &Image, exposure: f32) -> Result<Vec<u8>> {
    let scale = exposure.exp2();
    let quantise = |c: f32| (255.0 * linear_to_srgb((c * scale).clamp(0.0, 1.0))).round() as u8;
    let pixels: Vec<[u8; 3]> = image.pixels().iter().map(|p| [quantise(p.x), quantise(p.y), quantise(p.z)]).collect();
    encode_png_srgb8(image.width(), image.height(), &pixels)
}

/// The bytes of sRGB-encoded pixels as PNG, row after row from the top left.
///
/// # Errors
/// [`Error::Empty`] if a side is 0, [`Error::Length`] unless there are width · height pixels, [`Error::File`] if a
/// side is beyond 2³² − 1 pixels.
pub fn encode_png_srgb8(width: usize, height: usize, pixels: &[[u8; 3]]) -> Result<Vec<u8>> {
    if width == 0 || height == 0 {
        return Err(Error::Empty { what: "picture" });
    }
    let expected = width.saturating_mul(height);
    if pixels.len() != expected {
        return Err(Error::Length { what: "pixels of a picture", expected, got: pixels.len() });
    }
    let failed = |reason: String| Report::new("PNG").error("", reason);
    let side = |n: usize| u32::try_from(n).map_err(|_| failed(format!("a side of {n} pixels is too long")));
    let (w, h) = (side(width)?, side(height)?);
    let mut out = Vec::new();
    PngEncoder::new(&mut out)
        .write_image(pixels.as_flattened(), w, h, ExtendedColorType::Rgb8)
        .map_err(|e| failed(e.to_string()))?;
    Ok(out)
}
