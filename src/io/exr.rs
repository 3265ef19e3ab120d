//! OpenEXR, by the crate `exr`.

use std::cell::Cell;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use ::exr::block::UncompressedBlock;
use ::exr::block::reader::ChunksReader;
use ::exr::meta::attribute::SampleType;
use ::exr::meta::header::Header;
use ::exr::prelude::{Encoding, Image as ExrImage, SpecificChannels, Vec2, WritableImage, f16};
use nalgebra::Vector3;

use super::image::{check_size, finish};
use super::{Image, Loaded, Report};
use crate::{Error, Result};

/// Reads an OpenEXR picture from its bytes; `name` is what messages call it.
///
/// One flat part, scan lines or tiles, every compression including DWAA and DWAB, half, float and unsigned samples.
/// RGB comes from the channels R, G, B, or Y alone, or from those of the only layer that has them (`layer.R` …, with a
/// warning); all others are skipped. The picture is the display window: what the data window leaves free is black,
/// what it has beyond is cut off, both with a warning. Of several resolutions the finest is read.
///
/// # Errors
/// [`Error::File`] with the block or pixel: several parts, deep data, subsampled or luminance-chroma colour, channels
/// that are not there, NaN or infinite pixels, more than [`Image::MAX_PIXELS`] pixels,
/// a display window of more than 1024 times the data window, damage of any kind.
pub fn read_exr(bytes: &[u8], name: impl AsRef<std::path::Path>) -> Result<Loaded<Image>> {
    let mut report = Report::new(name);
    if bytes.is_empty() {
        return Err(report.error("", "the file is empty"));
    }
    // Version field: bit 11 = deep data, bit 12 = several parts.
    if let [0x76, 0x2f, 0x31, 0x01, _, flags, ..] = bytes {
        if flags & 0x08 != 0 {
            return Err(report.error("header", "deep data cannot be read; flatten the picture first"));
        }
        if flags & 0x10 != 0 {
            return Err(report.error("header", "a file of several parts cannot be read; save one part by itself"));
        }
    }
    // The crate's decoders subtract and index without checks in places, so that damaged blocks can panic in them (B44
    // does, where overflow is checked). Nothing but local values is touched by then. The panic's message still goes to
    // the process's panic hook, and a build that aborts on panic aborts.
    let block = Cell::new(None);
    let decoded = catch_unwind(AssertUnwindSafe(|| decode(bytes, &mut report, &block)));
    let place = || block.get().map_or_else(|| "header".to_owned(), |(i, n)| format!("block {i} of {n}"));
    let (width, height, pixels) = match decoded {
        Ok(Ok(parts)) => parts,
        Ok(Err(Failure::Described(e))) => return Err(e),
        Ok(Err(Failure::Decoder(e))) => return Err(report.error(place(), e.to_string())),
        Err(_) => return Err(report.error(place(), "the data are damaged")),
    };
    finish(report, width, height, pixels)
}

enum Failure {
    Described(Error),
    Decoder(::exr::error::Error),
}

impl From<Error> for Failure {
    fn from(e: Error) -> Self {
        Self::Described(e)
    }
}

impl From<::exr::error::Error> for Failure {
    fn from(e: ::exr::error::Error) -> Self {
        Self::Decoder(e)
    }
}

/// Width, height and pixels. `at` is set to the block being decoded and their number.
fn decode(
    bytes: &[u8],
    report: &mut Report,
    at: &Cell<Option<(usize, usize)>>,
) -> Result<(usize, usize, Vec<Vector3<f32>>), Failure> {
    let reader = ::exr::block::read(Cursor::new(bytes), false)?;
    let [header] = reader.headers() else {
        return Err(report.error("header", "a file of several parts cannot be read; save one part by itself").into());
    };
    let layout = Layout::new(header, bytes.len(), report)?;
    let chunks = reader.filter_chunks(false, |_, tile, _| tile.level_index == Vec2(0, 0))?;
    let total = chunks.expected_chunk_count();
    // Taken when the first block has shown that the size is not a lie.
    let mut pixels = Vec::new();
    let mut blocks = chunks.sequential_decompressor(false);
    for i in 0..total {
        at.set(Some((i, total)));
        let block = blocks.decompress_next_block();
        let block = block.ok_or_else(|| report.error(format!("block {i} of {total}"), "the file ends here"))??;
        pixels.resize(layout.width * layout.height, Vector3::zeros());
        layout.copy(&block, &blocks.meta_data().headers[0], &mut pixels)?;
    }
    Ok((layout.width, layout.height, pixels))
}

/// Where the samples of a file go.
struct Layout {
    width: usize,
    height: usize,
    /// Per channel of the file, the colours that it is.
    colours: Vec<std::ops::Range<usize>>,
    /// Position of the data window in the display window.
    offset: [i64; 2],
}

impl Layout {
    fn new(header: &Header, bytes: usize, report: &mut Report) -> Result<Self> {
        let display = header.shared_attributes.display_window;
        let Vec2(width, height) = display.size;
        check_size(report, "header, display window", width, height)?;
        let Vec2(data_width, data_height) = header.layer_size;
        check_size(report, "header, data window", data_width, data_height)?;
        // Each block has an entry of 8 bytes in the offset table and a head of at least 8 of its own. Compression at its
        // best is DWA of one colour: a symbol of 2 bytes for 8 × 8 halves, which Deflate shortens 1032 times: 2^16.01.
        let raw = data_width.saturating_mul(data_height).saturating_mul(header.channels.bytes_per_pixel);
        if header.chunk_count.saturating_mul(16) > bytes || raw >> 17 > bytes {
            let reason = format!(
                "{data_width} × {data_height} pixels in {} blocks cannot come from {bytes} bytes",
                header.chunk_count
            );
            return Err(report.error("header, data window", reason));
        }
        // What the data leave free costs no bytes, so that nothing else bounds it.
        if width * height / 1024 > data_width * data_height {
            let reason = format!(
                "{width} × {height} pixels, more than 1024 times the {data_width} × {data_height} that have data"
            );
            return Err(report.error("header, display window", reason));
        }
        let Vec2(x, y) = header.own_attributes.layer_position;
        let offset = [i64::from(x) - i64::from(display.position.0), i64::from(y) - i64::from(display.position.1)];
        if offset != [0, 0] || header.layer_size != display.size {
            report.warn(
                "header",
                format!(
                    "the data window ({data_width} × {data_height} at {}, {}) is not the display window ({width} × {height}); cut or filled with black",
                    offset[0], offset[1]
                ),
            );
        }
        let colours = colours_of_channels(header, report)?;
        Ok(Self { width, height, colours, offset })
    }

    fn copy(
        &self,
        block: &UncompressedBlock,
        header: &Header,
        pixels: &mut [Vector3<f32>],
    ) -> ::exr::error::UnitResult {
        for line in block.lines(&header.channels) {
            let at = line.location;
            let (x, y) = (at.position.0 as i64 + self.offset[0], at.position.1 as i64 + self.offset[1]);
            let colours = self.colours[at.channel].clone();
            if colours.is_empty() || y < 0 || y >= self.height as i64 {
                continue;
            }
            let row = &mut pixels[y as usize * self.width..][..self.width];
            let mut set = |i: usize, value: f32| {
                let pixel = usize::try_from(x + i as i64).ok().and_then(|x| row.get_mut(x));
                if let Some(pixel) = pixel {
                    pixel.as_mut_slice()[colours.clone()].fill(value);
                }
            };
            match header.channels.list[at.channel].sample_type {
                SampleType::F16 => {
                    line.read_samples::<f16>().enumerate().try_for_each(|(i, s)| s.map(|s| set(i, s.to_f32())))?
                }
                SampleType::F32 => {
                    line.read_samples::<f32>().enumerate().try_for_each(|(i, s)| s.map(|s| set(i, s)))?
                }
                SampleType::U32 => {
                    line.read_samples::<u32>().enumerate().try_for_each(|(i, s)| s.map(|s| set(i, s as f32)))?
                }
            }
        }
        Ok(())
    }
}

/// Per channel of the file, the colours that it is: of R, G, B one each, of a lone Y all three.
fn colours_of_channels(header: &Header, report: &mut Report) -> Result<Vec<std::ops::Range<usize>>> {
    let channels = &header.channels.list;
    let names: Vec<String> = channels.iter().map(|c| c.name.to_string()).collect();
    let find = |name: &str| names.iter().position(|n| n == name);
    let rgb = |prefix: &str| ["R", "G", "B"].map(|c| find(&format!("{prefix}{c}")));
    let mut colours = vec![0..0; names.len()];
    let take = |found: [Option<usize>; 3], colours: &mut Vec<std::ops::Range<usize>>| {
        found
            .iter()
            .enumerate()
            .for_each(|(colour, channel)| channel.iter().for_each(|&c| colours[c] = colour..colour + 1));
    };
    let layers: Vec<&str> =
        names.iter().filter_map(|n| n.strip_suffix('R')).filter(|p| rgb(p).iter().all(Option::is_some)).collect();
    if rgb("").iter().all(Option::is_some) {
        take(rgb(""), &mut colours);
    } else if let (Some(y), None, None) = (find("Y"), find("RY"), find("BY")) {
        colours[y] = 0..3;
    } else if let [layer] = layers[..] {
        take(rgb(layer), &mut colours);
        report.warn("header", format!("colours taken from the layer \"{}\"", layer.trim_end_matches('.')));
    } else {
        let mut list = names.iter().take(20).map(String::as_str).collect::<Vec<_>>().join(", ");
        if names.len() > 20 {
            list.push_str(", …");
        }
        let reason = format!("there is no one set of channels R, G, B and no plain Y; the channels are: {list}");
        return Err(report.error("header", reason));
    }
    if channels.iter().any(|c| c.sampling != Vec2(1, 1)) {
        return Err(report.error("header", "subsampled channels cannot be read"));
    }
    Ok(colours)
}

/// The bytes of a picture as OpenEXR: R, G, B as 32-bit float, ZIP-compressed, which loses nothing.
///
/// # Errors
/// [`Error::File`] if the picture is too large for the format.
pub fn encode_exr(image: &Image) -> Result<Vec<u8>> {
    let pixel = |at: Vec2<usize>| {
        let p = image.pixel(at.0, at.1);
        (p.x, p.y, p.z)
    };
    let size = (image.width(), image.height());
    let mut out = Cursor::new(Vec::new());
    ExrImage::from_encoded_channels(size, Encoding::SMALL_LOSSLESS, SpecificChannels::rgb(pixel))
        .write()
        .non_parallel()
        .to_buffered(&mut out)
        .map_err(|e| Error::File { path: "EXR".into(), place: String::new(), reason: e.to_string() })?;
    Ok(out.into_inner())
}
