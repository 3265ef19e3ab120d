//! The file form of a transport.
//!
//! ```text
//! SIZE  side of the cube map u64, side of a block u64, path u64 (0 rows, 1 serpentine, 2 Hilbert),
//!       top level u64 (1 binary, 3…255 several levels), vertices u64
//! MAPS  for each 4096 vertices: coded maps as `compress` writes them
//! PATH  behind each MAPS: u64, a bit a block that is set if the path of its map is turned, each vertex from a
//!       new word on
//! ```
//! Sections are written and read one at a time, so that a database needs little more memory than it has.

use super::coding::Coded;
use super::layout::BlockLayout;
use super::paths::Paths;
use super::transport::{Maps, Transport};
use crate::Result;
use crate::compress::ScanOrder;
use crate::sphere::CubeGrid;
use crate::store::parts::Parts;
use crate::store::{Kind, Reader, SectionReader, Writer};

const SECTION: usize = 4096;
const ORDERS: [ScanOrder; 3] = [ScanOrder::RowMajor, ScanOrder::Serpentine, ScanOrder::Hilbert];

impl Parts for Transport {
    const KIND: Kind = Kind::BlockProduct;

    fn write(&self, to: &mut Writer) -> Result<()> {
        let layout = self.layout();
        let order = ORDERS.iter().position(|&o| o == layout.scans()[0].order()).expect("all orders are listed");
        let top = usize::from(self.top());
        to.section(*b"SIZE", |s| {
            for field in [layout.grid().side(), layout.side(), order, top, self.vertices()] {
                s.field(field as u64);
            }
        })?;
        match self.maps() {
            Maps::Binary8(maps) => write(to, maps, self),
            Maps::Binary16(maps) => write(to, maps, self),
            Maps::Gray8(maps) => write(to, maps, self),
            Maps::Gray16(maps) => write(to, maps, self),
        }
    }

    fn read(from: &mut Reader) -> Result<Self> {
        let mut size = from.section(*b"SIZE")?;
        let layout = read_layout(&mut size)?;
        let top: u64 = size.field("a top level")?;
        let top = u8::try_from(top).ok().filter(|&top| top > 0);
        let top = top.ok_or_else(|| size.wrong("names a top level that is not in 1…255"))?;
        let shape = (top, size.field("vertices")?);
        size.end()?;
        let mut paths = Paths::default();
        let maps = match (top, layout.block_len() <= 256) {
            (1, true) => Maps::Binary8(read(from, &layout, shape, &mut paths)?),
            (1, false) => Maps::Binary16(read(from, &layout, shape, &mut paths)?),
            (_, true) => Maps::Gray8(read(from, &layout, shape, &mut paths)?),
            (_, false) => Maps::Gray16(read(from, &layout, shape, &mut paths)?),
        };
        Ok(Self::from_maps(layout, maps, paths))
    }
}

fn read_layout(size: &mut SectionReader) -> Result<BlockLayout> {
    let (side, block) = (size.count("texels of a side")?, size.count("texels of a block's side")?);
    let order = size.count("a path")?;
    let order = ORDERS.get(order).copied();
    let order = order.ok_or_else(|| size.wrong("names a path through blocks that this build does not know"))?;
    let grid = CubeGrid::new(side).map_err(|_| size.wrong(format!("{side} is not a side of a cube map")))?;
    BlockLayout::new(grid, block, order)
        .map_err(|_| size.wrong(format!("a cube map of side {side} has no blocks of side {block}")))
}

fn write<M: Coded>(to: &mut Writer, maps: &M, transport: &Transport) -> Result<()> {
    let (vertices, blocks) = (transport.vertices(), transport.layout().blocks());
    let (turned, words) = (transport.paths().turned(), Paths::words(blocks));
    for first in (0..vertices).step_by(SECTION) {
        let end = (first + SECTION).min(vertices);
        to.section(*b"MAPS", |s| s.array(&maps.section(first * blocks..end * blocks)))?;
        to.section(*b"PATH", |s| s.array(&turned[first * words..end * words]))?;
    }
    Ok(())
}

fn read<M: Coded>(from: &mut Reader, layout: &BlockLayout, (top, vertices): (u8, u64), paths: &mut Paths) -> Result<M> {
    let words = Paths::words(layout.blocks());
    let mut all = M::empty(layout.block_len(), top)?;
    let mut left = vertices;
    while left > 0 {
        let now = left.min(SECTION as u64) as usize;
        let bytes: Vec<u8> = from.section(*b"MAPS")?.rest("bytes of coded maps")?;
        let section = M::parse(&bytes).map_err(|e| from.wrong(format!("a section of maps: {e}")))?;
        let (expected, got) = ((layout.block_len(), top, now * layout.blocks()), section.shape());
        if got != expected {
            return Err(from.wrong(format!(
                "a section of (pixels, levels, maps) {expected:?} was expected, there is one of {got:?}"
            )));
        }
        all.join(&section).map_err(|e| from.wrong(e.to_string()))?;
        let mut section = from.section(*b"PATH")?;
        let turned = Paths::new(section.array("words of turned paths", now * words)?);
        section.end()?;
        if (0..now).any(|vertex| !turned.is_of_vertex(vertex, layout.blocks())) {
            return Err(
                from.wrong(format!("a path is turned of a block that is beyond the {} of a vertex", layout.blocks()))
            );
        }
        paths.append(&turned);
        left -= now as u64;
    }
    Ok(all)
}
