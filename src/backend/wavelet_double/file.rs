//! The file form of a transport.
//!
//! ```text
//! SIZE  side of the cube map u64, vertices u64, view u8 (0 any, 1 from an eye point, 2 from a direction), x, y,
//!       z f64 of that
//! BLOK  for each 256 vertices: lists of rows' vertices u16, of weights f32 (three a row), of columns u32,
//!       of where these start u32, of row indices u16; bits of a value u8 (32, 16, 8); values
//! ```

use super::block::{BLOCK, Block, Values};
use super::transport::Transport;
use crate::Result;
use crate::backend::distant::read_dyadic_grid;
use crate::scene::View;
use crate::store::parts::Parts;
use crate::store::{Kind, Reader, Writer};

impl Parts for Transport {
    const KIND: Kind = Kind::WaveletDouble;

    fn write(&self, to: &mut Writer) -> Result<()> {
        to.section(*b"SIZE", |s| {
            s.field(self.grid.side() as u64);
            s.field(self.vertices as u64);
            View::write(self.view, s);
        })?;
        for block in &self.blocks {
            to.section(*b"BLOK", |s| {
                s.list(&block.vertex);
                s.list(block.weight.as_flattened());
                s.list(&block.columns);
                s.list(&block.starts);
                s.list(&block.rows);
                match &block.values {
                    Values::Full(values) => {
                        s.field(32u8);
                        s.array(values);
                    }
                    Values::Bits16(values) => {
                        s.field(16u8);
                        s.array(values);
                    }
                    Values::Bits8(values) => {
                        s.field(8u8);
                        s.array(values);
                    }
                }
            })?;
        }
        Ok(())
    }

    fn read(from: &mut Reader) -> Result<Self> {
        let mut size = from.section(*b"SIZE")?;
        let (grid, vertices) = (read_dyadic_grid(&mut size)?, size.count("vertices")?);
        let view = View::read(&mut size)?;
        size.end()?;
        let mut blocks = Vec::new();
        let mut left = vertices;
        while left > 0 {
            let mut section = from.section(*b"BLOK")?;
            let vertex: Vec<u16> = section.list("rows of a block")?;
            let flat: Vec<f32> = section.list("weights of a block")?;
            let (weight, rest) = flat.as_chunks::<3>();
            if weight.len() != vertex.len() || !rest.is_empty() {
                return Err(section.wrong(format!("{} weights for {} rows", flat.len(), vertex.len())));
            }
            let (columns, starts) = (section.list("columns of a block")?, section.list("starts of a block")?);
            let rows: Vec<u16> = section.list("row indices of a block")?;
            let values = match section.field::<u8>("bits of a value")? {
                32 => Values::Full(section.array("values of a block", rows.len())?),
                16 => Values::Bits16(section.array("values of a block", rows.len())?),
                8 => Values::Bits8(section.array("values of a block", rows.len())?),
                bits => return Err(section.wrong(format!("{bits} is not a number of bits of a value"))),
            };
            let block = Block { vertex, weight: weight.to_vec(), columns, starts, rows, values };
            if let Some(fault) = block.fault(left.min(BLOCK), grid.len()) {
                return Err(section.wrong(format!("a block contradicts itself: {fault}; bake the transport again")));
            }
            section.end()?;
            blocks.push(block);
            left -= left.min(BLOCK);
        }
        Ok(Self { grid, vertices, view, blocks })
    }
}
