//! Radiance HDR (RGBE).
//!
//! A reader and a writer of our own: the common crate's reader refuses the signature `#?RGBE` that many files have,
//! says neither scan line nor offset, and overflows on a chain of run markers; its writer truncates where it could
//! round, which darkens a picture by half a step of its 8 bits.

use nalgebra::Vector3;

use super::Image;
use super::primaries::{self, Primaries};
use super::{ImageEncoding, check_finite, check_size, finish};
use crate::Result;
use crate::io::report::{Loaded, Report, excerpt};

/// Reads a Radiance HDR picture from its bytes; `name` is what messages call it.
///
/// A stored pixel (r, g, b, e) is (r, g, b) · 2^(e − 136), and 0 if e = 0. Both run-length codes and all eight
/// orientations are read. `EXPOSURE` and `COLORCORR` are undone, with a warning, so that pixels are radiance; where
/// they are not positive numbers, they are ignored, with a warning. Pixels of other `PRIMARIES` than those of Rec. 709
/// are converted to these, with white adapted (Bradford), and XYZ pixels without (XYZ knows no white), with a warning;
/// a file without `PRIMARIES` has those of Rec. 709, as nearly all such files do. The resolution ends the header,
/// whether a blank line goes before it, as the format has it, or none or several.
///
/// # Errors
/// [`Error::File`](crate::Error::File) with the line of the header or the scan line and byte offset.
pub fn read_hdr(bytes: &[u8], name: impl AsRef<std::path::Path>) -> Result<Loaded<Image>> {
    read(bytes, name.as_ref(), ImageEncoding::Radiance)
}

/// [`read_hdr`] of numbers with a given meaning.
pub(super) fn read(bytes: &[u8], name: &std::path::Path, encoding: ImageEncoding) -> Result<Loaded<Image>> {
    let mut report = Report::new(name);
    let header = Header::read(bytes, &mut report, encoding)?;
    let Header { major, minor, end, scale, primaries } = header;
    let mut stream = Stream { bytes, at: end };
    if bytes.len() - end < 4 * major.length {
        let reason = format!(
            "{} scan lines take at least {} bytes, but only {} are there",
            major.length,
            4 * major.length,
            bytes.len() - end
        );
        return Err(report.error(format!("byte {end}"), reason));
    }
    // Grows with the scan lines that are there, whatever the header says.
    let mut stored: Vec<[u8; 4]> = Vec::new();
    for i in 0..major.length {
        stream
            .scan_line(minor.length, &mut stored)
            .map_err(|reason| report.error(format!("scan line {i} (byte {})", stream.at), reason))?;
    }
    if stream.at < bytes.len() {
        report.warn(
            format!("byte {}", stream.at),
            format!("{} bytes after the last scan line skipped", bytes.len() - stream.at),
        );
    }
    let (width, height) = if major.is_y { (minor.length, major.length) } else { (major.length, minor.length) };
    let decode = |p: [u8; 4]| decode(p).component_mul(&scale);
    let in_place = major.is_y && !major.backwards && !minor.backwards;
    let mut pixels: Vec<_> = if in_place {
        stored.iter().map(|&p| decode(p)).collect()
    } else {
        let mut pixels = vec![Vector3::zeros(); stored.len()];
        for (i, line) in stored.chunks_exact(minor.length).enumerate() {
            for (j, &p) in line.iter().enumerate() {
                let (a, b) = (major.position(i), minor.position(j));
                pixels[if major.is_y { a * width + b } else { b * width + a }] = decode(p);
            }
        }
        pixels
    };
    if let Some((place, primaries)) = primaries {
        primaries.convert(&place, &mut report, &mut pixels);
    }
    finish(report, width, height, pixels, encoding)
}

/// An axis of the resolution line. `backwards`: up for y, leftwards for x.
#[derive(Debug, Clone, Copy)]
struct Axis {
    is_y: bool,
    backwards: bool,
    length: usize,
}

impl Axis {
    fn position(self, i: usize) -> usize {
        if self.backwards { self.length - 1 - i } else { i }
    }
}

struct Header {
    major: Axis,
    minor: Axis,
    /// Byte offset of the first scan line.
    end: usize,
    /// What a stored pixel is multiplied by.
    scale: Vector3<f32>,
    /// Where the header names primaries, and which.
    primaries: Option<(String, Primaries)>,
}

impl Header {
    fn read(bytes: &[u8], report: &mut Report, encoding: ImageEncoding) -> Result<Self> {
        if bytes.is_empty() {
            return Err(report.error("", "the file is empty"));
        }
        if !bytes.starts_with(b"#?") {
            return Err(report.error("byte 0", "not a Radiance HDR file: it does not begin with \"#?\""));
        }
        let mut at = 0;
        let mut after_blank = false;
        let mut lines = Lines { encoding, scale: Vector3::repeat(1.0), primaries: None, xyz: None };
        for number in 1.. {
            let place = format!("line {number}");
            let length = bytes[at..].iter().position(|&b| b == b'\n');
            // The last line of a file without pixels may lack its end: the resolution is read all the same.
            let end = length.map_or(bytes.len(), |length| at + length);
            let line = bytes[at..end].strip_suffix(b"\r").unwrap_or(&bytes[at..end]);
            if let Some((major, minor)) = resolution(line.trim_ascii()) {
                check_size(report, &place, minor.length, major.length)?;
                let scale = lines.usable_scale(report);
                // XYZ pixels are that whatever the primaries of a picture in RGB were.
                let primaries = lines.xyz.or(lines.primaries);
                return Ok(Self { major, minor, end: (end + 1).min(bytes.len()), scale, primaries });
            }
            let of_header = line.is_empty() || line.starts_with(b"#") || line.contains(&b'=');
            if after_blank && !of_header {
                let reason = format!("\"{}\" is not a resolution", excerpt(&bytes[at..end]));
                return Err(report.error(place, reason));
            }
            if length.is_none() {
                return Err(report.error(place, "the header ends here, before the resolution"));
            }
            after_blank |= line.is_empty();
            lines.take(line, &place, report)?;
            at = end + 1;
        }
        unreachable!("the loop has no end but its returns")
    }
}

/// What the lines of a header have said so far.
struct Lines {
    encoding: ImageEncoding,
    scale: Vector3<f64>,
    primaries: Option<(String, Primaries)>,
    xyz: Option<(String, Primaries)>,
}

impl Lines {
    fn take(&mut self, line: &[u8], place: &str, report: &mut Report) -> Result<()> {
        let Some(equals) = line.iter().position(|&b| b == b'=') else { return Ok(()) };
        // Indented lines tell of other programs' headers.
        let (key, value) = (line[..equals].trim_ascii_end(), line[equals + 1..].trim_ascii());
        let unusable = |report: &mut Report, what: &str| {
            report.warn(place, format!("{what}, but \"{}\"; ignored", excerpt(value)));
        };
        let is_data = self.encoding == ImageEncoding::Data;
        match key {
            // What is no light has neither exposure nor primaries.
            b"EXPOSURE" | b"COLORCORR" | b"PRIMARIES" if is_data => {}
            b"FORMAT" => match value {
                b"32-bit_rle_rgbe" => self.xyz = None,
                b"32-bit_rle_xyze" if is_data => {}
                b"32-bit_rle_xyze" => self.xyz = Some((place.to_owned(), primaries::XYZ)),
                _ => {
                    let formats = "only 32-bit_rle_rgbe and 32-bit_rle_xyze can be read";
                    return Err(report.error(place, format!("pixel format \"{}\"; {formats}", excerpt(value))));
                }
            },
            b"EXPOSURE" => match positive(value) {
                Some([factor]) => {
                    self.scale /= factor;
                    report.warn(place, format!("pixels divided by EXPOSURE {factor}"));
                }
                None => unusable(report, "EXPOSURE is not a positive number"),
            },
            b"COLORCORR" => match positive(value) {
                Some([r, g, b]) => {
                    self.scale.component_div_assign(&Vector3::new(r, g, b));
                    report.warn(place, format!("pixels divided by COLORCORR {r} {g} {b}"));
                }
                None => unusable(report, "COLORCORR is not three positive numbers"),
            },
            b"PRIMARIES" => match numbers(value) {
                Some(numbers) => self.primaries = Some((place.to_owned(), Primaries::new(numbers))),
                None => unusable(report, "PRIMARIES is not eight numbers"),
            },
            _ => {}
        }
        Ok(())
    }

    /// What undoes all exposures and corrections, unless that is no number to multiply by.
    fn usable_scale(&self, report: &mut Report) -> Vector3<f32> {
        let scale = self.scale.cast::<f32>();
        if scale.iter().all(|s| s.is_normal() && *s > 0.0) {
            return scale;
        }
        report.warn("header", "EXPOSURE and COLORCORR multiply to 0 or infinity; pixels are as stored");
        Vector3::repeat(1.0)
    }
}

/// Positive finite numbers separated by blanks.
fn positive<const N: usize>(text: &[u8]) -> Option<[f64; N]> {
    numbers(text).filter(|n| n.iter().all(|x| x.is_finite() && *x > 0.0))
}

/// Exactly N numbers separated by blanks, before what is none.
fn numbers<const N: usize>(text: &[u8]) -> Option<[f64; N]> {
    let numbers: Vec<f64> =
        std::str::from_utf8(text).ok()?.split_ascii_whitespace().map_while(|w| w.parse().ok()).collect();
    <[f64; N]>::try_from(numbers).ok()
}

/// Parses "-Y height +X width" and its seven sisters.
fn resolution(line: &[u8]) -> Option<(Axis, Axis)> {
    let words: Vec<&str> = std::str::from_utf8(line).ok()?.split_ascii_whitespace().collect();
    let [first, n1, second, n2] = words[..] else { return None };
    let axis = |sign: &str, n: &str| {
        let (is_y, backwards) = match sign {
            "-Y" => (true, false),
            "+Y" => (true, true),
            "+X" => (false, false),
            "-X" => (false, true),
            _ => return None,
        };
        Some(Axis { is_y, backwards, length: n.parse().ok()? })
    };
    let (major, minor) = (axis(first, n1)?, axis(second, n2)?);
    (major.is_y != minor.is_y).then_some((major, minor))
}

struct Stream<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Stream<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let chunk = self.bytes[self.at..].first_chunk().ok_or("the file ends here")?;
        self.at += N;
        Ok(*chunk)
    }

    /// Appends one scan line of `width` pixels.
    fn scan_line(&mut self, width: usize, out: &mut Vec<[u8; 4]>) -> Result<(), String> {
        let start = out.len();
        let [a, b, hi, lo] = self.take()?;
        if !((8..=0x7fff).contains(&width) && a == 2 && b == 2 && hi < 128) {
            self.at -= 4;
            return self.old_scan_line(start + width, out);
        }
        let coded = usize::from(u16::from_be_bytes([hi, lo]));
        if coded != width {
            return Err(format!("the scan line says that it has {coded} pixels, not {width}"));
        }
        // The shortest code of a scan line: runs of at most 127.
        if self.bytes.len() - self.at < 8 * width.div_ceil(127) {
            return Err("the file ends in this scan line".into());
        }
        out.resize(start + width, [0; 4]);
        for channel in 0..4 {
            let mut x = start;
            while x < out.len() {
                let [count] = self.take()?;
                let (n, run) = if count > 128 { (count - 128, true) } else { (count, false) };
                if n == 0 || usize::from(n) > out.len() - x {
                    return Err(format!("a run of {n} pixels where {} are left", out.len() - x));
                }
                let value = if run { self.take::<1>()?[0] } else { 0 };
                for pixel in &mut out[x..x + usize::from(n)] {
                    pixel[channel] = if run { value } else { self.take::<1>()?[0] };
                }
                x += usize::from(n);
            }
        }
        Ok(())
    }

    /// The code of before 1991: pixels as they are; (1, 1, 1, n) repeats the last one n times, further ones in a row
    /// n · 256, n · 256², … times.
    fn old_scan_line(&mut self, end: usize, out: &mut Vec<[u8; 4]>) -> Result<(), String> {
        let start = out.len();
        let mut shift = 0;
        while out.len() < end {
            let pixel = self.take()?;
            let [1, 1, 1, n] = pixel else {
                out.push(pixel);
                shift = 0;
                continue;
            };
            let left = end - out.len();
            let n = usize::from(n).checked_shl(shift).filter(|n| *n <= left && shift < 32);
            let n = n.ok_or_else(|| format!("a run beyond the {left} pixels that are left"))?;
            let last = *out[start..].last().ok_or("a run before any pixel")?;
            out.resize(out.len() + n, last);
            shift += 8;
        }
        Ok(())
    }
}

/// 2^n for −149 ≤ n ≤ 127, exact.
fn power_of_two(n: i32) -> f32 {
    if n >= -126 { f32::from_bits(((n + 127) as u32) << 23) } else { f32::from_bits(1 << (n + 149)) }
}

fn decode([r, g, b, e]: [u8; 4]) -> Vector3<f32> {
    if e == 0 {
        return Vector3::zeros();
    }
    // 2^(e − 136) is at least 2^−135, a subnormal f32, and exact.
    let unit = power_of_two(i32::from(e) - 136);
    Vector3::new(r, g, b).map(|c| f32::from(c) * unit)
}

/// The nearest stored pixel; the shared exponent is the smallest that holds the largest channel.
fn encode(pixel: &Vector3<f32>) -> [u8; 4] {
    let largest = f64::from(pixel.max());
    // Half a step of the smallest exponent.
    if largest < 2f64.powi(-136) {
        return [0; 4];
    }
    // frexp: largest = m · 2^exponent with ½ ≤ m < 1, from the bits of a normal f64.
    let mut exponent = ((largest.to_bits() >> 52) & 0x7ff) as i32 - 1022;
    // 255.5 steps and more round up to 256, which the next exponent holds.
    if (largest * 2f64.powi(8 - exponent)).round() >= 256.0 {
        exponent += 1;
    }
    let exponent = exponent.clamp(-127, 127);
    let quantise = |c: f32| (f64::from(c) * 2f64.powi(8 - exponent)).round().clamp(0.0, 255.0) as u8;
    [quantise(pixel.x), quantise(pixel.y), quantise(pixel.z), (exponent + 128) as u8]
}

/// The bytes of a picture as Radiance HDR, run-length coded.
///
/// Each pixel is rounded to 8 bits of its largest channel: the error of a channel is at most 2⁻⁸ of the largest one.
/// Negative channels become 0; values beyond 255 · 2¹¹⁹ become that, those below 2⁻¹³⁶ become 0.
///
/// # Errors
/// [`Error::NotFinite`](crate::Error::NotFinite) for a pixel that is NaN or infinite.
pub fn encode_hdr(image: &Image) -> Result<Vec<u8>> {
    check_finite(image)?;
    let (width, height) = (image.width(), image.height());
    let mut out = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    let mut channel = Vec::with_capacity(width);
    for row in image.pixels().chunks_exact(width) {
        let line: Vec<[u8; 4]> = row.iter().map(encode).collect();
        if !(8..=0x7fff).contains(&width) {
            // No channel is above the largest, which has its high bit set: no pixel looks like a marker
            // (2, 2, …) or (1, 1, 1, …), unless its exponent is the smallest.
            for pixel in line {
                out.extend_from_slice(&if pixel[..3].iter().all(|c| *c < 128) { [0; 4] } else { pixel });
            }
            continue;
        }
        out.extend_from_slice(&[2, 2, (width >> 8) as u8, width as u8]);
        for i in 0..4 {
            channel.clear();
            channel.extend(line.iter().map(|p| p[i]));
            run_length(&channel, &mut out);
        }
    }
    Ok(out)
}

/// Runs of 4…127 equal bytes as (128 + n, byte), what is between them as (n ≤ 128, bytes).
fn run_length(bytes: &[u8], out: &mut Vec<u8>) {
    let flush = |plain: &[u8], out: &mut Vec<u8>| {
        for chunk in plain.chunks(128) {
            out.push(chunk.len() as u8);
            out.extend_from_slice(chunk);
        }
    };
    let (mut start, mut at) = (0, 0);
    while at < bytes.len() {
        let run = bytes[at..].iter().take(127).take_while(|b| **b == bytes[at]).count();
        if run >= 4 {
            flush(&bytes[start..at], out);
            out.extend_from_slice(&[128 + run as u8, bytes[at]]);
            start = at + run;
        }
        at += run;
    }
    flush(&bytes[start..], out);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stored_pixel_survives() {
        for e in 0..=255_u8 {
            for m in [0_u8, 1, 2, 127, 128, 200, 255] {
                let stored = [m, 128, 255 - m, e];
                let back = encode(&decode(stored));
                // The exponent may be one that fits better; the value is what counts.
                assert_eq!(decode(back), decode(stored), "{stored:?} became {back:?}");
            }
        }
    }

    #[test]
    fn encoding_rounds_to_nearest() {
        for (value, steps) in [(1.0, 128), (255.49 / 256.0, 255), (0.999, 128), (0.75, 192), (0.751, 192), (0.753, 193)]
        {
            let [r, _, _, _] = encode(&Vector3::repeat(value));
            assert_eq!(r, steps, "{value}");
        }
        assert_eq!(encode(&Vector3::new(-1.0, 0.0, 0.0)), [0; 4]);
        assert_eq!(encode(&Vector3::repeat(f32::MAX)), [255, 255, 255, 255]);
        assert_eq!(encode(&Vector3::repeat(f32::MIN_POSITIVE * 1e-6)), [0; 4]);
    }

    #[test]
    fn run_lengths_have_the_right_bytes() {
        let code = |bytes: &[u8]| {
            let mut out = Vec::new();
            run_length(bytes, &mut out);
            out
        };
        assert_eq!(code(&[7; 200]), [128 + 127, 7, 128 + 73, 7]);
        assert_eq!(code(&[1, 2, 3]), [3, 1, 2, 3]);
        assert_eq!(code(&[1, 5, 5, 5, 5, 2]), [1, 1, 132, 5, 1, 2]);
        let long: Vec<u8> = (0..=255).collect();
        assert_eq!(code(&long).len(), 258);
    }
}
