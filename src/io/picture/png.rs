//! PNG, by the crate `image`.

use std::io::Cursor;
use std::path::Path;

use ::image::codecs::png::{CompressionType, FilterType, PngDecoder, PngEncoder};
use ::image::{ColorType, ExtendedColorType, ImageDecoder, ImageEncoder};
use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;
use nalgebra::Vector3;

use super::Image;
use super::primaries::Primaries;
use super::{ImageEncoding, check_finite, check_size, finish};
use crate::io::report::{Loaded, Report, excerpt};
use crate::scene::{linear_to_srgb, srgb_to_linear};
use crate::{Error, Result};

/// Reads a PNG picture from its bytes; `name` is what messages call it.
///
/// Grey, colour and palette pictures of 1 to 16 bits, decoded to linear. Pixels are sRGB-encoded, unless the file says
/// otherwise: a `gAMA` other than sRGB's 1/2.2 is undone as a power, and primaries in `cHRM` other than Rec. 709's are
/// converted to these, both with a warning; an ICC profile that does not call itself sRGB and a `cICP` that is not sRGB
/// are ignored with a warning. Where there are several, `cICP` goes before `iCCP`, that before `sRGB`, and that before
/// `gAMA` and `cHRM`. Alpha is dropped; if any pixel is not opaque, with a warning.
///
/// # Errors
/// [`Error::File`] if the file is damaged, cut short or has more than [`Image::MAX_PIXELS`] pixels.
pub fn read_png(bytes: &[u8], name: impl AsRef<std::path::Path>) -> Result<Loaded<Image>> {
    read(bytes, name.as_ref(), ImageEncoding::Radiance)
}

/// [`read_png`] of numbers with a given meaning.
pub(super) fn read(bytes: &[u8], name: &Path, meaning: ImageEncoding) -> Result<Loaded<Image>> {
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
    // On a palette that ends within a colour the decoder panics.
    if let Some((_, palette)) = Chunks(&bytes[8..]).find(|(name, data)| name == b"PLTE" && data.len() % 3 != 0) {
        let reason = format!("{} bytes are not three a colour; save the picture again", palette.len());
        return Err(report.error("chunk PLTE", reason));
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
    let encoding = match meaning {
        ImageEncoding::Radiance => Encoding::read(bytes, &mut report),
        ImageEncoding::Data => Encoding::NONE,
    };
    let linear: Vec<f32> = (0..=full).map(|s| encoding.decode(f32::from(s) / f32::from(full))).collect();
    let mut transparent = 0_usize;
    let mut pixels: Vec<_> = (raw.chunks_exact(channels * size))
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
    // What is grey has the colour of white whatever the primaries are.
    if let Some(primaries) = encoding.primaries.filter(|_| colour) {
        primaries.convert("chunk cHRM", &mut report, &mut pixels);
    }
    finish(report, width, height, pixels, meaning)
}

/// What the samples of a file mean.
#[derive(Debug, Default)]
struct Encoding {
    /// The power that decodes them, where it is not sRGB's curve.
    power: Option<f32>,
    primaries: Option<Primaries>,
}

impl Encoding {
    /// Samples that are what they are.
    const NONE: Self = Self { power: Some(1.0), primaries: None };

    /// Looks through the chunks before the pixels, which the decoder has checked by then.
    fn read(bytes: &[u8], report: &mut Report) -> Self {
        let mut found = Self::default();
        let chunk = |name: &[u8; 4]| Chunks(&bytes[8..]).find(|(n, _)| n == name).map(|(_, data)| data);
        if let Some(&[primaries, transfer, ..]) = chunk(b"cICP") {
            // Rec. 709 primaries and the curve of sRGB, as ITU-T H.273 numbers them.
            if [primaries, transfer] != [1, 13] {
                let what = format!("primaries {primaries} and curve {transfer}");
                report.warn("chunk cICP", format!("{what} are not those of sRGB; taken as sRGB all the same"));
            }
        } else if let Some(profile) = chunk(b"iCCP") {
            let name: Vec<u8> = profile.iter().copied().take_while(|b| *b != 0).collect();
            if !calls_itself_srgb(profile, name.len()) {
                let name = excerpt(&name);
                report.warn(
                    "chunk iCCP",
                    format!("the colour profile \"{name}\" is ignored; taken as sRGB all the same"),
                );
            }
        } else if chunk(b"sRGB").is_none() {
            let number = |bytes: &[u8; 4]| f64::from(u32::from_be_bytes(*bytes)) / 1e5;
            if let Some(gamma) = chunk(b"gAMA").and_then(|data| data.first_chunk()).map(number) {
                found.power = power(gamma, report);
            }
            if let Some((numbers, [])) = chunk(b"cHRM").map(<[u8]>::as_chunks::<4>) {
                // In the file white is first, then red, green and blue.
                if let Ok([wx, wy, rgb @ ..]) = <[f64; 8]>::try_from(numbers.iter().map(number).collect::<Vec<_>>()) {
                    let [rx, ry, gx, gy, bx, by] = rgb;
                    found.primaries = Some(Primaries::new([rx, ry, gx, gy, bx, by, wx, wy]));
                }
            }
        }
        found
    }

    fn decode(&self, sample: f32) -> f32 {
        match self.power {
            Some(1.0) => sample,
            Some(power) => sample.powf(power),
            None => srgb_to_linear(sample),
        }
    }
}

/// The power that undoes an encoding by `gamma`, unless that stands for sRGB.
fn power(gamma: f64, report: &mut Report) -> Option<f32> {
    // sRGB's is written as 45455; some round it to two digits.
    if (gamma - 1.0 / 2.2).abs() < 0.006 {
        return None;
    }
    // Displays have had 1.0 to 2.8; ten times that is no curve of a picture.
    if !(0.1..=10.0).contains(&gamma) {
        report.warn("chunk gAMA", format!("a gamma of {gamma} cannot be; taken as sRGB"));
        return None;
    }
    let curve = if gamma == 1.0 { "linear".to_owned() } else { format!("encoded with the gamma {gamma}, not as sRGB") };
    report.warn("chunk gAMA", format!("the samples are {curve}; read so"));
    Some((1.0 / gamma) as f32)
}

/// Whether the name of an ICC profile, or a description in it, has "sRGB" in it.
fn calls_itself_srgb(chunk: &[u8], name: usize) -> bool {
    let has = |bytes: &[u8], text: &[u8]| bytes.windows(text.len()).any(|w| w.eq_ignore_ascii_case(text));
    // A zero byte and the number of the only method of compression are between name and profile. Profiles of displays
    // have a few kilobytes; those for printers, which are none of sRGB, can have a megabyte.
    let profile = chunk.get(name + 2..).and_then(|data| decompress_to_vec_zlib_with_limit(data, 1 << 16).ok());
    let profile = profile.unwrap_or_default();
    has(&chunk[..name], b"sRGB") || has(&profile, b"sRGB") || has(&profile, b"s\0R\0G\0B")
}

/// Names and data of chunks.
struct Chunks<'a>(&'a [u8]);

impl<'a> Iterator for Chunks<'a> {
    type Item = ([u8; 4], &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        let (&length, rest) = self.0.split_first_chunk()?;
        let (&name, rest) = rest.split_first_chunk()?;
        let (data, rest) = rest.split_at_checked(u32::from_be_bytes(length) as usize)?;
        // Behind the data there are 4 bytes of checksum.
        self.0 = rest.get(4..)?;
        (name != *b"IDAT").then_some((name, data))
    }
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
    encode(width, height, pixels.as_flattened(), ExtendedColorType::Rgb8)
}

/// Bits of a number in a PNG file.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PngDepth {
    /// 8 bits: steps of 1/255.
    Eight,
    /// 16 bits: steps of 1/65535.
    Sixteen,
}

/// The bytes of an image of data as PNG: numbers in [0, 1] without any encoding.
///
/// Numbers are clamped to [0, 1] and rounded to the nearest step of the depth. [`read_image_with`] and
/// [`ImageEncoding::Data`] bring them back within half a step (and a rounding of `f32`); [`read_png`] takes the file
/// for sRGB, since nothing in a PNG file says that its numbers are no colours.
///
/// [`read_image_with`]: super::read_image_with
///
/// # Errors
/// [`Error::NotFinite`] for a pixel that is NaN or infinite, [`Error::File`] if the picture has more than 2³² − 1
/// pixels along a side.
pub fn encode_png_data(image: &Image, depth: PngDepth) -> Result<Vec<u8>> {
    check_finite(image)?;
    let numbers = image.pixels().iter().flat_map(|p| [p.x, p.y, p.z]).map(|c| f64::from(c.clamp(0.0, 1.0)));
    let (bytes, colour): (Vec<u8>, _) = match depth {
        PngDepth::Eight => (numbers.map(|c| (255.0 * c).round() as u8).collect(), ExtendedColorType::Rgb8),
        // The encoder takes the machine's byte order.
        PngDepth::Sixteen => {
            let bytes = numbers.flat_map(|c| ((65535.0 * c).round() as u16).to_ne_bytes()).collect();
            (bytes, ExtendedColorType::Rgb16)
        }
    };
    encode(image.width(), image.height(), &bytes, colour)
}

fn encode(width: usize, height: usize, samples: &[u8], colour: ExtendedColorType) -> Result<Vec<u8>> {
    let failed = |reason: String| Report::new("PNG").error("", reason);
    let side = |n: usize| u32::try_from(n).map_err(|_| failed(format!("a side of {n} pixels is too long")));
    let (w, h) = (side(width)?, side(height)?);
    let mut out = Vec::new();
    PngEncoder::new_with_quality(&mut out, CompressionType::Best, FilterType::Adaptive)
        .write_image(samples, w, h, colour)
        .map_err(|e| failed(e.to_string()))?;
    Ok(out)
}
