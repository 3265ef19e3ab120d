//! OpenEXR.
//!
//! A reader of our own: the common crate's decoders take memory for what a damaged block says (terabytes, which aborts
//! the process) and index and subtract without checks. Here nothing is taken or indexed that has not been compared with
//! the size in the header, and that with the size of the file. Sources: "OpenEXR File Layout" and "Technical
//! Introduction to OpenEXR", openexr.com; what they leave open (PIZ, B44, DWA) is as OpenEXR and its peers write it.

mod b44;
mod block;
mod deflate;
mod dwa;
mod half;
mod header;
mod huffman;
mod input;
mod piz;
mod pxr24;
mod write;

use nalgebra::Vector3;

use self::block::Block;
pub(super) use self::header::Envmap;
use self::header::{Header, SampleType};
use self::input::Input;
pub use self::write::encode_exr;
use super::Image;
use super::primaries::Primaries;
use super::{ImageEncoding, Tagged, check_size, finish};
use crate::Result;
use crate::io::report::{Loaded, Report};

/// Reads an OpenEXR picture from its bytes; `name` is what messages call it.
///
/// One flat part, scan lines or tiles; uncompressed, RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A, DWAA or DWAB (not HTJ2K);
/// half, float and unsigned samples. RGB comes from the channels R, G, B, or Y alone, or from those of the only layer
/// that has them (`layer.R` …, with a warning); all others are skipped. The picture is the display window: what the
/// data window leaves free is black, what it has beyond is cut off, both with a warning. Of several resolutions the
/// finest is read. Pixels whose attribute `chromaticities` names other primaries than those of Rec. 709 are converted
/// to these, with white adapted (Bradford; not for XYZ, which knows no white), with a warning; `adoptedNeutral` and
/// `whiteLuminance` are ignored.
///
/// Memory: the picture, and one block uncompressed and once more in between.
///
/// # Errors
/// [`Error::File`](crate::Error::File) with the block or pixel: several parts, deep data, HTJ2K compression, subsampled
/// or luminance-chroma colour, channels that are not there, NaN or infinite pixels, more than [`Image::MAX_PIXELS`]
/// pixels, a display window of more than 1024 times the data window, damage of any kind.
pub fn read_exr(bytes: &[u8], name: impl AsRef<std::path::Path>) -> Result<Loaded<Image>> {
    read_tagged(bytes, name.as_ref(), ImageEncoding::Radiance).map(|tagged| tagged.image)
}

/// As [`read_exr`], with what the file says about its use.
pub(super) fn read_tagged(bytes: &[u8], name: &std::path::Path, encoding: ImageEncoding) -> Result<Tagged> {
    let mut report = Report::new(name);
    if bytes.is_empty() {
        return Err(report.error("", "the file is empty"));
    }
    let header = Header::read(bytes).map_err(|reason| report.error("header", reason))?;
    let layout = Layout::new(&header, bytes.len(), &mut report)?;
    let mut pixels = decode(bytes, &header, &layout).map_err(|(place, reason)| report.error(place, reason))?;
    // What is grey has the colour of white whatever the primaries are.
    let is_colour = encoding == ImageEncoding::Radiance && !layout.is_grey();
    if let Some(chromaticities) = header.chromaticities.filter(|_| is_colour) {
        let primaries = Primaries::new(chromaticities.map(f64::from));
        primaries.convert("header, chromaticities", &mut report, &mut pixels);
    }
    let image = finish(report, layout.width, layout.height, pixels, encoding)?;
    Ok(Tagged { image, envmap: header.envmap })
}

/// The pixels, or place and reason of what is wrong.
fn decode(bytes: &[u8], header: &Header, layout: &Layout) -> Result<Vec<Vector3<f32>>, (String, String)> {
    let [across, down] = header.blocks();
    let total = across * down;
    let at = |i: usize| move |reason: String| (format!("block {i} of {total}"), reason);
    let mut table = Input(&bytes[header.end..]);
    let mut pixels = Vec::new();
    let mut raw = Vec::new();
    let mut seen = vec![false; total];
    for i in 0..total {
        // A block says itself where it belongs; of several resolutions the finest is the first in the table.
        let offset = table.size().ok_or_else(|| at(i)("the file ends here".into()))?;
        let (place, compressed) = chunk(bytes, offset, header).map_err(at(i))?;
        if std::mem::replace(&mut seen[place[1] * across + place[0]], true) {
            return Err(at(i)(format!("the block in column {}, row {} is there twice", place[0], place[1])));
        }
        let left = [place[0] * header.block[0], place[1] * header.block[1]];
        let block = Block {
            channels: &header.channels,
            width: header.block[0].min(header.data.width - left[0]),
            height: header.block[1].min(header.data.height - left[1]),
        };
        raw.resize(block.size(), 0);
        block.decode(header.compression, compressed, &mut raw).map_err(at(i))?;
        // Taken when the first block has shown that the size is not a lie.
        pixels.resize(layout.width * layout.height, Vector3::zeros());
        layout.copy(&block, left, &raw, &mut pixels);
    }
    Ok(pixels)
}

/// Column and row of the block at an offset, and its compressed bytes.
fn chunk<'a>(bytes: &'a [u8], offset: usize, header: &Header) -> Result<([usize; 2], &'a [u8]), String> {
    if offset < header.end {
        return Err(format!("its place, byte {offset}, is in the header: the file was not written to its end"));
    }
    let cut = || "the file ends here".to_owned();
    let mut input = Input(bytes.get(offset..).ok_or_else(cut)?);
    let blocks = header.blocks();
    let place = if header.tiled {
        let mut number = || input.i32().ok_or_else(cut);
        let (x, y, levels) = (number()?, number()?, [number()?, number()?]);
        if levels != [0, 0] {
            return Err(format!("a tile of resolution {}, {} where one of the finest belongs", levels[0], levels[1]));
        }
        [i64::from(x), i64::from(y)]
    } else {
        let line = i64::from(input.i32().ok_or_else(cut)?) - header.data.at[1];
        let lines = header.block[1] as i64;
        if line % lines != 0 {
            return Err(format!("scan line {line} does not begin a block"));
        }
        [0, line / lines]
    };
    let inside = |i: usize| usize::try_from(place[i]).ok().filter(|p| *p < blocks[i]);
    let (Some(x), Some(y)) = (inside(0), inside(1)) else {
        return Err(format!("column {}, row {} of {} × {} blocks", place[0], place[1], blocks[0], blocks[1]));
    };
    Ok(([x, y], input.sized().ok_or_else(cut)?))
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
        let (display, data) = (header.display, header.data);
        let (width, height) = (display.width, display.height);
        check_size(report, "header, display window", width, height)?;
        check_size(report, "header, data window", data.width, data.height)?;
        // Each block has an entry of 8 bytes in the offset table and a head of at least 8 of its own. Compression at
        // its best is DWA of one colour: a symbol of 2 bytes for 8 × 8 halves, which Deflate shortens 1032 times:
        // 2^16.01.
        let raw = (data.width * data.height).checked_mul(header.pixel_size());
        let blocks = header.blocks().into_iter().product::<usize>();
        if blocks > bytes / 16 || raw.is_none_or(|raw| raw >> 17 > bytes) {
            let reason =
                format!("{} × {} pixels in {blocks} blocks cannot come from {bytes} bytes", data.width, data.height);
            return Err(report.error("header, data window", reason));
        }
        // What the data leave free costs no bytes, so that nothing else bounds it.
        if width * height / 1024 > data.width * data.height {
            let reason = format!(
                "{width} × {height} pixels, more than 1024 times the {} × {} that have data",
                data.width, data.height
            );
            return Err(report.error("header, display window", reason));
        }
        let offset = [0, 1].map(|i| data.at[i] - display.at[i]);
        if data != display {
            report.warn(
                "header",
                format!(
                    "the data window ({} × {} at {}, {}) is not the display window ({width} × {height}); cut or filled with black",
                    data.width, data.height, offset[0], offset[1]
                ),
            );
        }
        let colours = colours_of_channels(header, report)?;
        Ok(Self { width, height, colours, offset })
    }

    /// Whether one channel is all colours.
    fn is_grey(&self) -> bool {
        self.colours.contains(&(0..3))
    }

    /// Puts an uncompressed block, whose first pixel is `left` from the data window's, where it belongs.
    fn copy(&self, block: &Block, left: [usize; 2], raw: &[u8], pixels: &mut [Vector3<f32>]) {
        let [x, y] = [0, 1].map(|i| left[i] as i64 + self.offset[i]);
        // Samples of a line that are inside the picture.
        let inside =
            (-x).clamp(0, block.width as i64) as usize..(self.width as i64 - x).clamp(0, block.width as i64) as usize;
        if inside.is_empty() {
            return;
        }
        let first = (x + inside.start as i64) as usize;
        let starts = block.channel_starts();
        for (line, y) in raw.chunks_exact(block.line_size()).zip(y..) {
            let Some(y) = usize::try_from(y).ok().filter(|y| *y < self.height) else { continue };
            let row = &mut pixels[y * self.width + first..][..inside.len()];
            let channels = block.channels.iter().zip(&starts).zip(&self.colours);
            for ((channel, &start), colours) in channels.filter(|(_, colours)| !colours.is_empty()) {
                let size = channel.samples.size();
                let samples = &line[start + size * inside.start..][..size * inside.len()];
                for (pixel, sample) in row.iter_mut().zip(samples.chunks_exact(size)) {
                    let value = match (channel.samples, sample) {
                        (SampleType::Half, &[a, b]) => half::to_f32(u16::from_le_bytes([a, b])),
                        (SampleType::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
                        (_, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]) as f32,
                        _ => continue,
                    };
                    pixel.as_mut_slice()[colours.clone()].fill(value);
                }
            }
        }
    }
}

/// Per channel of the file, the colours that it is: of R, G, B one each, of a lone Y all three.
fn colours_of_channels(header: &Header, report: &mut Report) -> Result<Vec<std::ops::Range<usize>>> {
    let channels = &header.channels;
    let names: Vec<&str> = channels.iter().map(|c| c.name.as_str()).collect();
    let find = |name: &str| names.iter().position(|n| *n == name);
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
        let mut list = names.iter().take(20).copied().collect::<Vec<_>>().join(", ");
        if names.len() > 20 {
            list.push_str(", …");
        }
        let reason = format!("there is no one set of channels R, G, B and no plain Y; the channels are: {list}");
        return Err(report.error("header", reason));
    }
    if channels.iter().any(|c| c.subsampled) {
        return Err(report.error("header", "subsampled channels cannot be read"));
    }
    Ok(colours)
}
