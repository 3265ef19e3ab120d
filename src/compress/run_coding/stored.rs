//! The file form of coded maps.
//!
//! ```text
//! MAPS  pixels of a map u64, top level u8 (1 for binary maps), number of maps u64
//! PART  maps, up to 65536 of them, as `to_bytes` writes them; as many sections as it takes
//! ```

use super::binary::CodedBinaryMaps;
use super::gray::CodedGrayMaps;
use super::index::MapIndex;
use crate::store::parts::Parts;
use crate::store::{Kind, Reader, Writer};
use crate::{Error, Result};

/// Maps of a section.
const PART: usize = 1 << 16;

macro_rules! stored {
    ($maps:ident, $top:expr, $empty:expr) => {
        impl<I: MapIndex> Parts for $maps<I> {
            const KIND: Kind = Kind::$maps;

            fn write(&self, to: &mut Writer) -> Result<()> {
                let top: fn(&Self) -> u8 = $top;
                to.section(*b"MAPS", |s| {
                    s.field(self.map_len() as u64);
                    s.field(top(self));
                    s.field(self.len() as u64);
                })?;
                for first in (0..self.len()).step_by(PART) {
                    let part = self.slice(first..self.len().min(first + PART));
                    to.section(*b"PART", |s| s.array(&part.to_bytes()))?;
                }
                Ok(())
            }

            fn read(from: &mut Reader) -> Result<Self> {
                let mut head = from.section(*b"MAPS")?;
                let (map_len, top) = (head.count("pixels of a map")?, head.field("a top level")?);
                let maps: u64 = head.field("a number of maps")?;
                let empty: fn(usize, u8) -> Result<Self> = $empty;
                let mut all = empty(map_len, top).map_err(|e| head.wrong(e.to_string()))?;
                head.end()?;
                while (all.len() as u64) < maps {
                    let expected = (maps - all.len() as u64).min(PART as u64);
                    let bytes: Vec<u8> = from.section(*b"PART")?.rest("bytes of coded maps")?;
                    let part = Self::from_bytes(&bytes).map_err(|e| from.wrong(e.to_string()))?;
                    let top: fn(&Self) -> u8 = $top;
                    let shape = |maps: &Self| (maps.map_len(), top(maps));
                    if shape(&part) != shape(&all) || part.len() as u64 != expected {
                        return Err(from.wrong(format!(
                            "{} maps of (pixels, levels) {:?}, expected {expected} of {:?}",
                            part.len(),
                            shape(&part),
                            shape(&all)
                        )));
                    }
                    let changes = all.total_changes() + part.total_changes();
                    if changes > u32::MAX as usize {
                        return Err(from.wrong(format!("{changes} changes, which 32 bits do not count")));
                    }
                    all.append(&part);
                }
                Ok(all)
            }
        }
    };
}

fn binary<I: MapIndex>(map_len: usize, top: u8) -> Result<CodedBinaryMaps<I>> {
    if top != 1 {
        return Err(Error::OutOfRange { what: "top level of binary maps", got: f64::from(top), allowed: "1" });
    }
    CodedBinaryMaps::new(map_len)
}

stored!(CodedBinaryMaps, |_: &Self| 1, binary);
stored!(CodedGrayMaps, Self::top, Self::new);
