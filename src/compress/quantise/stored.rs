//! The file form of quantised numbers.
//!
//! ```text
//! HALF: BITS  each number u16        DIST  distortion: max f64, rms f64, relative f64
//! BYTE: SIZE  bits of a decoded number u8 (32, 64), numbers u64, columns u64, blocks u8 (0 rows, 1 columns,
//!             2 runs), length of a run u64
//!       CODE  each number u8         BLOK  offsets, steps                               DIST  as above
//! ```

use super::bytes::{ByteBlocks, QuantisedBytes};
use super::half::QuantisedHalf;
use crate::compress::Distortion;
use crate::store::field::Field;
use crate::store::parts::Parts;
use crate::store::{Kind, Reader, Writer, check_bits};
use crate::{Real, Result};

impl Parts for QuantisedHalf {
    const KIND: Kind = Kind::QuantisedHalf;

    fn write(&self, to: &mut Writer) -> Result<()> {
        to.section(*b"BITS", |s| s.array(self.bits()))?;
        self.distortion().write(to)
    }

    fn read(from: &mut Reader) -> Result<Self> {
        let bits = from.section(*b"BITS")?.rest("numbers")?;
        let distortion = Distortion::read(from)?;
        Self::from_parts(bits, distortion).map_err(|e| from.wrong(e.to_string()))
    }
}

impl<T: Real + Field> Parts for QuantisedBytes<T> {
    const KIND: Kind = Kind::QuantisedBytes;

    fn write(&self, to: &mut Writer) -> Result<()> {
        let (blocks, run) = match self.blocks() {
            ByteBlocks::Rows => (0, 0),
            ByteBlocks::Columns => (1, 0),
            ByteBlocks::Runs(len) => (2, len),
        };
        to.section(*b"SIZE", |s| {
            s.field(8 * T::SIZE as u8);
            s.field(self.codes().len() as u64);
            s.field(self.columns() as u64);
            s.field(blocks as u8);
            s.field(run as u64);
        })?;
        to.section(*b"CODE", |s| s.array(self.codes()))?;
        to.section(*b"BLOK", |s| {
            s.array(self.offsets());
            s.array(self.steps());
        })?;
        self.distortion().write(to)
    }

    fn read(from: &mut Reader) -> Result<Self> {
        let mut size = from.section(*b"SIZE")?;
        check_bits::<T>(&mut size)?;
        let (len, columns) = (size.count("numbers")?, size.count("columns")?);
        let blocks = match (size.field::<u8>("a kind of blocks")?, size.count("numbers of a run")?) {
            (0, 0) => ByteBlocks::Rows,
            (1, 0) => ByteBlocks::Columns,
            (2, run) => ByteBlocks::Runs(run),
            (kind, run) => return Err(size.wrong(format!("blocks of kind {kind} and length {run}"))),
        };
        size.end()?;
        let mut section = from.section(*b"CODE")?;
        let codes = section.array("codes", len)?;
        section.end()?;
        let mut section = from.section(*b"BLOK")?;
        let both: Vec<T> = section.rest("offsets and steps")?;
        let (offsets, steps) = both.split_at(both.len() / 2);
        let distortion = Distortion::read(from)?;
        Self::from_parts(codes, columns, blocks, offsets.to_vec(), steps.to_vec(), distortion)
            .map_err(|e| from.wrong(e.to_string()))
    }
}
