//! OpenEXR files of every kind, by the crate `exr`.

use std::io::Cursor;

use exr::prelude::*;
use haarmonic::nalgebra::Vector3;

pub const COMPRESSIONS: [Compression; 10] = [
    Compression::Uncompressed,
    Compression::RLE,
    Compression::ZIP1,
    Compression::ZIP16,
    Compression::PIZ,
    Compression::PXR24,
    Compression::B44,
    Compression::B44A,
    Compression::DWAA(None),
    Compression::DWAB(None),
];

/// The type of each channel in turn.
pub const TYPES: [&[SampleType]; 4] = [
    &[SampleType::F16],
    &[SampleType::F32],
    &[SampleType::F16, SampleType::F32],
    &[SampleType::F32, SampleType::F16, SampleType::U32],
];

/// A value of channel `c` at a pixel: smooth, with an edge and grain; whole numbers that every type holds.
pub fn value(c: usize, x: usize, y: usize) -> f32 {
    let grain = (x * 7919 + y * 104_729 + c * 31) % 5;
    (3 + 2 * x + y + 10 * c + grain + if x > 2 * y { 40 } else { 0 }) as f32
}

pub fn file(
    names: &[&str],
    types: &[SampleType],
    compression: Compression,
    size: (usize, usize),
    blocks: Blocks,
    linear: bool,
) -> Vec<u8> {
    let size = Vec2(size.0, size.1);
    let list = names.iter().enumerate().map(|(c, name)| {
        let samples = (0..size.area()).map(|i| value(c, i % size.0, i / size.0));
        let samples = match types[c % types.len()] {
            SampleType::F16 => FlatSamples::F16(samples.map(f16::from_f32).collect()),
            SampleType::F32 => FlatSamples::F32(samples.collect()),
            SampleType::U32 => FlatSamples::U32(samples.map(|s| s as u32).collect()),
        };
        AnyChannel { name: Text::from(*name), sample_data: samples, quantize_linearly: linear, sampling: Vec2(1, 1) }
    });
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    let layer = Layer::new(size, LayerAttributes::named("layer"), encoding, AnyChannels::sort(list.collect()));
    let mut out = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut out).unwrap();
    out.into_inner()
}

/// R, G and B as the crate `exr` reads them, if it does.
pub fn peer(bytes: &[u8]) -> Option<Vec<Vector3<f32>>> {
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .ok()?;
    let channels = &image.layer_data.channel_data.list;
    let plane = |name: &str| -> Option<Vec<f32>> {
        let channel = channels.iter().find(|c| c.name == *name)?;
        Some(channel.sample_data.values_as_f32().collect())
    };
    let [r, g, b] = [plane("R")?, plane("G")?, plane("B")?];
    Some((0..r.len()).map(|i| Vector3::new(r[i], g[i], b[i])).collect())
}

/// Adds an attribute at the front of a file's header and moves the offsets of its blocks accordingly.
pub fn with_attribute(bytes: &[u8], name: &str, kind: &str, value: &[u8]) -> Vec<u8> {
    let mut attribute = [name.as_bytes(), &[0], kind.as_bytes(), &[0]].concat();
    attribute.extend_from_slice(&(value.len() as i32).to_le_bytes());
    attribute.extend_from_slice(value);
    // The header ends in a zero byte, where a name would begin.
    let mut at = 8;
    while bytes[at] != 0 {
        for _ in 0..2 {
            at += bytes[at..].iter().position(|&b| b == 0).unwrap() + 1;
        }
        at += 4 + i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    }
    let table = at + 1;
    let first = u64::from_le_bytes(bytes[table..table + 8].try_into().unwrap()) as usize;
    let mut out = [&bytes[..8], &attribute, &bytes[8..table]].concat();
    // The table ends where the first block begins: the writers here put that block first.
    for offset in bytes[table..first].chunks_exact(8) {
        let offset = u64::from_le_bytes(offset.try_into().unwrap()) + attribute.len() as u64;
        out.extend_from_slice(&offset.to_le_bytes());
    }
    out.extend_from_slice(&bytes[first..]);
    out
}
