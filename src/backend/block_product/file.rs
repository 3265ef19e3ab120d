//! The file form of a transport.
//!
//! ```text
//! archive header: kind "BLKP", version 2
//! u64 side of the cube map   u64 side of a block   u64 path (0 rows, 1 serpentine, 2 Hilbert)
//! u64 top level (1 binary, 3…255 several levels)   u64 vertices
//! then sections of up to 4096 vertices: an array of bytes, coded maps as `compress` writes them; and an array of u64, a bit a block
//! that is set if the path of its map is turned, each vertex from a new word on
//! ```
//! Sections are written and read one at a time, so that a database needs little more memory than it has.

use std::io::{Read, Write};
use std::path::Path;

use super::coding::Coded;
use super::layout::BlockLayout;
use super::paths::Paths;
use super::transport::{Maps, Transport};
use crate::Result;
use crate::backend::archive;
use crate::compress::ScanOrder;
use crate::sphere::CubeGrid;

const KIND: [u8; 4] = *b"BLKP";
const VERSION: u32 = 2;
const SECTION: usize = 4096;
const ORDERS: [ScanOrder; 3] = [ScanOrder::RowMajor, ScanOrder::Serpentine, ScanOrder::Hilbert];

pub(super) fn save(transport: &Transport, path: &Path) -> Result<()> {
    archive::save(path, |out| {
        let mut writer = archive::Writer::new(out, path, KIND, VERSION)?;
        let layout = transport.layout();
        let order = ORDERS.iter().position(|&o| o == layout.scans()[0].order()).expect("all orders are listed");
        let top = usize::from(transport.top());
        for field in [layout.grid().side(), layout.side(), order, top, transport.vertices()] {
            writer.field(field as u64)?;
        }
        match transport.maps() {
            Maps::Binary8(maps) => write(&mut writer, maps, transport)?,
            Maps::Binary16(maps) => write(&mut writer, maps, transport)?,
            Maps::Gray8(maps) => write(&mut writer, maps, transport)?,
            Maps::Gray16(maps) => write(&mut writer, maps, transport)?,
        }
        writer.finish()
    })
}

pub(super) fn load(path: &Path) -> Result<Transport> {
    let mut reader = archive::Reader::new(archive::open(path)?, path, KIND, "blocks of visibility", VERSION)?;
    let layout = read_layout(&mut reader)?;
    let top: u64 = reader.field()?;
    let top = u8::try_from(top).ok().filter(|&top| top > 0);
    let top = top.ok_or_else(|| reader.wrong("names a top level that is not in 1…255"))?;
    let shape = (top, reader.field()?);
    let mut paths = Paths::default();
    let maps = match (top, layout.block_len() <= 256) {
        (1, true) => Maps::Binary8(read(&mut reader, &layout, shape, &mut paths)?),
        (1, false) => Maps::Binary16(read(&mut reader, &layout, shape, &mut paths)?),
        (_, true) => Maps::Gray8(read(&mut reader, &layout, shape, &mut paths)?),
        (_, false) => Maps::Gray16(read(&mut reader, &layout, shape, &mut paths)?),
    };
    reader.finish()?;
    Ok(Transport::from_maps(layout, maps, paths))
}

fn read_layout<R: Read>(reader: &mut archive::Reader<R>) -> Result<BlockLayout> {
    let (side, block, order): (u64, u64, u64) = (reader.field()?, reader.field()?, reader.field()?);
    let order = usize::try_from(order).ok().and_then(|o| ORDERS.get(o).copied());
    let order = order.ok_or_else(|| reader.wrong("names a path through blocks that this build does not know"))?;
    let grid = usize::try_from(side).ok().and_then(|s| CubeGrid::new(s).ok());
    let grid = grid.ok_or_else(|| reader.wrong(format!("{side} is not a side of a cube map")))?;
    let layout = usize::try_from(block).ok().and_then(|b| BlockLayout::new(grid, b, order).ok());
    layout.ok_or_else(|| reader.wrong(format!("a cube map of side {side} has no blocks of side {block}")))
}

fn write<W: Write, M: Coded>(writer: &mut archive::Writer<W>, maps: &M, transport: &Transport) -> Result<()> {
    let (vertices, blocks) = (transport.vertices(), transport.layout().blocks());
    let (turned, words) = (transport.paths().turned(), Paths::words(blocks));
    for first in (0..vertices).step_by(SECTION) {
        let end = (first + SECTION).min(vertices);
        writer.array(&maps.section(first * blocks..end * blocks))?;
        writer.array(&turned[first * words..end * words])?;
    }
    Ok(())
}

fn read<R: Read, M: Coded>(
    reader: &mut archive::Reader<R>,
    layout: &BlockLayout,
    (top, vertices): (u8, u64),
    paths: &mut Paths,
) -> Result<M> {
    let words = Paths::words(layout.blocks());
    let mut all = M::empty(layout.block_len(), top)?;
    let mut left = vertices;
    while left > 0 {
        let now = left.min(SECTION as u64) as usize;
        let bytes: Vec<u8> = reader.array("bytes of coded maps", None)?;
        let section = M::parse(&bytes).map_err(|e| reader.wrong(format!("a section of maps: {e}")))?;
        let (expected, got) = ((layout.block_len(), top, now * layout.blocks()), section.shape());
        if got != expected {
            return Err(reader.wrong(format!(
                "a section of (pixels, levels, maps) {expected:?} was expected, there is one of {got:?}"
            )));
        }
        all.join(&section).map_err(|e| reader.wrong(e.to_string()))?;
        let turned: Vec<u64> = reader.array("words of turned paths", Some(now * words))?;
        let turned = Paths::new(turned);
        if (0..now).any(|vertex| !turned.is_of_vertex(vertex, layout.blocks())) {
            return Err(
                reader.wrong(format!("a path is turned of a block that is beyond the {} of a vertex", layout.blocks()))
            );
        }
        paths.append(&turned);
        left -= now as u64;
    }
    Ok(all)
}
