//! The file form: varints of gaps.
//!
//! ```text
//! container   "hrun"  version 1  kind 0 (binary) or 1 (gray)   map length   number of maps   maps
//! binary map  number of changes   gaps
//! gray map    number of changes   gaps   a byte for each new level          (top level: a byte before the first map)
//! gaps        c_0, c_1 − c_0, c_2 − c_1, …
//! ```
//! Numbers are varints, base 128: seven bits a byte, lowest first, the high bit set on all but the last, no longer than
//! need be. There is one way to write a container and a reader that refuses all others.

use super::index::{MapIndex, check_changes};
use crate::{Error, Result};

const MAGIC: &[u8; 4] = b"hrun";
const VERSION: u8 = 1;
pub(super) const BINARY: u8 = 0;
pub(super) const GRAY: u8 = 1;

pub(super) fn header(kind: u8, map_len: usize, count: usize) -> Vec<u8> {
    let mut out = MAGIC.to_vec();
    out.extend([VERSION, kind]);
    write_varint(map_len as u64, &mut out);
    write_varint(count as u64, &mut out);
    out
}

pub(super) fn write_varint(mut x: u64, out: &mut Vec<u8>) {
    while x >= 0x80 {
        out.push(x as u8 | 0x80);
        x >>= 7;
    }
    out.push(x as u8);
}

/// Appends the changes of a map as varints of their gaps: c_0, c_1 − c_0, …
///
/// Cost: a byte a change in maps of ordinary visibility, two where a gap is 128 or more.
///
/// # Panics
/// If the changes do not rise strictly.
#[track_caller]
pub fn encode_gaps<I: MapIndex>(changes: &[I], out: &mut Vec<u8>) {
    let mut before = None;
    for &change in changes {
        assert!(before < Some(change), "changes of a map: {change:?} after {before:?}");
        let gap = change.place() - before.map_or(0, I::place);
        write_varint(gap as u64, out);
        before = Some(change);
    }
}

/// Appends the changes of a map of `len` pixels that `bytes`, all of them, hold as [`encode_gaps`] writes them.
///
/// # Errors
/// [`Error::Damaged`], and `changes` as they were, if the bytes end within a number, a number is longer than need be, a
/// gap but the first is 0, or a change is not below `len`.
///
/// # Panics
/// If `len` is more than `I` can hold.
#[track_caller]
pub fn decode_gaps<I: MapIndex>(bytes: &[u8], len: usize, changes: &mut Vec<I>) -> Result<()> {
    assert!(len as u64 <= I::LONGEST, "length of a map: {len} is more than {}", I::LONGEST);
    let (mut reader, start) = (Reader::new("changes of a map", bytes), changes.len());
    let mut next = 0;
    while reader.at < bytes.len() {
        if let Err(error) = reader.gap(&mut next, len, changes) {
            changes.truncate(start);
            return Err(error);
        }
    }
    debug_assert!(check_changes(&changes[start..], len).is_ok());
    Ok(())
}

/// Reads numbers off bytes.
pub(super) struct Reader<'a> {
    what: &'static str,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    pub(super) fn new(what: &'static str, bytes: &'a [u8]) -> Self {
        Self { what, bytes, at: 0 }
    }

    pub(super) fn damaged(&self, reason: &'static str) -> Error {
        Error::Damaged { what: self.what, offset: self.at, reason }
    }

    pub(super) fn byte(&mut self) -> Result<u8> {
        let byte = *self.bytes.get(self.at).ok_or(self.damaged("cut short"))?;
        self.at += 1;
        Ok(byte)
    }

    /// The next `count` bytes.
    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let taken = rest.get(..count).ok_or(self.damaged("cut short"))?;
        self.at += count;
        Ok(taken)
    }

    #[inline]
    fn varint(&mut self) -> Result<u64> {
        let first = self.byte()?;
        if first < 0x80 {
            return Ok(u64::from(first));
        }
        let mut x = u64::from(first & 0x7f);
        for shift in (7..64).step_by(7) {
            let byte = self.byte()?;
            let bits = u64::from(byte & 0x7f);
            if bits << shift >> shift != bits {
                return Err(self.damaged("a number beyond 64 bits"));
            }
            x |= bits << shift;
            if byte < 0x80 {
                return if byte == 0 { Err(self.damaged("a number longer than it need be")) } else { Ok(x) };
            }
        }
        Err(self.damaged("a number beyond 64 bits"))
    }

    /// (map length, number of maps). Every map takes a byte at least, so that a number that lies fails here.
    pub(super) fn header(&mut self, kind: u8) -> Result<(usize, usize)> {
        if self.bytes.get(..4) != Some(MAGIC) {
            return Err(self.damaged("not coded maps"));
        }
        self.at = 4;
        if self.byte()? != VERSION {
            return Err(self.damaged("an unknown version"));
        }
        if self.byte()? != kind {
            return Err(self.damaged("maps of another kind"));
        }
        let map_len = usize::try_from(self.varint()?).map_err(|_| self.damaged("a map length beyond memory"))?;
        let count = self.count(self.bytes.len() - self.at)?;
        Ok((map_len, count))
    }

    /// A number of things, at most `most`.
    pub(super) fn count(&mut self, most: usize) -> Result<usize> {
        let count = self.varint()?;
        if count > most as u64 { Err(self.damaged("a count beyond what there can be")) } else { Ok(count as usize) }
    }

    /// One gap; `next` is the lowest place that the change may have, but that the first gap counts from 0.
    #[inline]
    fn gap<I: MapIndex>(&mut self, next: &mut u64, len: usize, changes: &mut Vec<I>) -> Result<()> {
        let gap = self.varint()?;
        // The place before is next − 1; the first gap counts from 0.
        let place = if *next == 0 { Some(gap) } else { gap.checked_add(*next - 1) };
        match place {
            Some(place) if place < *next => Err(self.damaged("a gap of 0")),
            Some(place) if place < len as u64 => {
                changes.push(I::of(place as usize));
                *next = place + 1;
                Ok(())
            }
            _ => Err(self.damaged("a change beyond the map")),
        }
    }

    /// The gaps of `count` changes.
    pub(super) fn gaps<I: MapIndex>(&mut self, count: usize, len: usize, changes: &mut Vec<I>) -> Result<()> {
        let mut next = 0;
        (0..count).try_for_each(|_| self.gap(&mut next, len, changes))
    }

    pub(super) fn finish(&self) -> Result<()> {
        if self.at == self.bytes.len() { Ok(()) } else { Err(self.damaged("followed by more")) }
    }
}
