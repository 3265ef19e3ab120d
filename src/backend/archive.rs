//! The file form of a transport: a versioned header, little-endian arrays, a checksum at the end.
//!
//! ```text
//! "haarmonic\0"  10 bytes     kind  4 bytes (ASCII)     version  u32
//! fields and arrays, each array with its length as u64 before it
//! CRC-32 of everything before it  u32
//! ```
//! A reader refuses what it does not understand, what is cut short, what is followed by more, and what fails the
//! checksum. Arrays are read in pieces, so that a length that lies fails at the file's end and not in the allocator.

use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use crate::{Error, Result};

const MAGIC: &[u8; 10] = b"haarmonic\0";
const PIECE: usize = 1 << 20;

/// A number as it stands in an archive.
pub(crate) trait Field: Copy {
    const SIZE: usize;
    fn put(self, out: &mut Vec<u8>);
    fn take(bytes: &[u8]) -> Self;
}

macro_rules! field {
    ($($t:ty)*) => {$(
        impl Field for $t {
            const SIZE: usize = size_of::<$t>();
            #[inline]
            fn put(self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
            #[inline]
            fn take(bytes: &[u8]) -> Self {
                Self::from_le_bytes(bytes.try_into().expect("the caller cuts pieces of SIZE bytes"))
            }
        }
    )*};
}
field!(u8 i8 u16 i16 u32 u64 f32 f64);

/// Writes an archive.
pub(crate) struct Writer<W> {
    out: W,
    crc: crc32fast::Hasher,
    path: PathBuf,
    buffer: Vec<u8>,
}

impl<W: Write> Writer<W> {
    /// Writes the header.
    pub(crate) fn new(out: W, path: &Path, kind: [u8; 4], version: u32) -> Result<Self> {
        let mut writer = Self { out, crc: crc32fast::Hasher::new(), path: path.to_owned(), buffer: Vec::new() };
        writer.bytes(MAGIC)?;
        writer.bytes(&kind)?;
        writer.field(version)?;
        Ok(writer)
    }

    fn bytes(&mut self, bytes: &[u8]) -> Result<()> {
        self.crc.update(bytes);
        self.out.write_all(bytes).map_err(|e| file_error(&self.path, "", format!("cannot be written: {e}")))
    }

    /// Writes one number.
    pub(crate) fn field<T: Field>(&mut self, value: T) -> Result<()> {
        self.buffer.clear();
        value.put(&mut self.buffer);
        let buffer = std::mem::take(&mut self.buffer);
        self.bytes(&buffer)?;
        self.buffer = buffer;
        Ok(())
    }

    /// Writes an array behind its length.
    pub(crate) fn array<T: Field>(&mut self, values: &[T]) -> Result<()> {
        self.field(values.len() as u64)?;
        for piece in values.chunks(PIECE / T::SIZE) {
            self.buffer.clear();
            for &value in piece {
                value.put(&mut self.buffer);
            }
            let buffer = std::mem::take(&mut self.buffer);
            self.bytes(&buffer)?;
            self.buffer = buffer;
        }
        Ok(())
    }

    /// Writes the checksum.
    pub(crate) fn finish(mut self) -> Result<()> {
        let crc = self.crc.clone().finalize();
        self.bytes(&crc.to_le_bytes())?;
        self.out.flush().map_err(|e| file_error(&self.path, "", format!("cannot be written: {e}")))
    }
}

/// Reads an archive.
pub(crate) struct Reader<R> {
    input: R,
    crc: crc32fast::Hasher,
    path: PathBuf,
    offset: u64,
}

impl<R: Read> Reader<R> {
    /// Reads and checks the header.
    pub(crate) fn new(input: R, path: &Path, kind: [u8; 4], what: &str, version: u32) -> Result<Self> {
        let mut reader = Self { input, crc: crc32fast::Hasher::new(), path: path.to_owned(), offset: 0 };
        if reader.bytes(MAGIC.len())? != MAGIC {
            return Err(file_error(path, "byte 0", "is not a haarmonic transport".into()));
        }
        let found = reader.bytes(4)?;
        if found != kind {
            let found = String::from_utf8_lossy(&found).into_owned();
            return Err(file_error(path, "byte 10", format!("holds a transport of kind {found:?}, expected {what}")));
        }
        let found: u32 = reader.field()?;
        if found != version {
            let reason = format!("has version {found}, this build reads version {version}: bake it again");
            return Err(file_error(path, "byte 14", reason));
        }
        Ok(reader)
    }

    /// An error at the present place.
    pub(crate) fn wrong(&self, reason: impl Into<String>) -> Error {
        file_error(&self.path, &format!("byte {}", self.offset), reason.into())
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<()> {
        self.input.read_exact(bytes).map_err(|e| {
            let reason = match e.kind() {
                ErrorKind::UnexpectedEof => "is cut short".into(),
                _ => format!("cannot be read: {e}"),
            };
            self.wrong(reason)
        })?;
        self.crc.update(bytes);
        self.offset += bytes.len() as u64;
        Ok(())
    }

    fn bytes(&mut self, len: usize) -> Result<Vec<u8>> {
        let mut bytes = vec![0; len];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    /// Reads one number.
    pub(crate) fn field<T: Field>(&mut self) -> Result<T> {
        Ok(T::take(&self.bytes(T::SIZE)?))
    }

    /// Reads an array whose length must be `expected`, or any length up to `u32::MAX` for `None`.
    pub(crate) fn array<T: Field>(&mut self, what: &str, expected: Option<usize>) -> Result<Vec<T>> {
        let len: u64 = self.field()?;
        let allowed = expected.map_or(len <= 1 << 40, |e| e as u64 == len);
        if !allowed {
            let expected = expected.map_or("at most 2^40".to_owned(), |e| e.to_string());
            return Err(self.wrong(format!("{what}: expected {expected} values, the file claims {len}")));
        }
        let mut values = Vec::new();
        let mut left = len as usize;
        let mut piece = vec![0; PIECE.min(left.saturating_mul(T::SIZE))];
        while left > 0 {
            let now = left.min(PIECE / T::SIZE);
            let piece = &mut piece[..now * T::SIZE];
            self.fill(piece)?;
            values.extend(piece.chunks_exact(T::SIZE).map(T::take));
            left -= now;
        }
        Ok(values)
    }

    /// Checks the checksum and that nothing follows.
    pub(crate) fn finish(mut self) -> Result<()> {
        let computed = self.crc.clone().finalize();
        let stored: u32 = self.field()?;
        if stored != computed {
            return Err(self.wrong(format!("is damaged: checksum {computed:08x}, the file says {stored:08x}")));
        }
        let mut more = [0; 1];
        match self.input.read(&mut more) {
            Ok(0) => Ok(()),
            Ok(_) => Err(self.wrong("is followed by more bytes than belong to it")),
            Err(e) => Err(self.wrong(format!("cannot be read: {e}"))),
        }
    }
}

/// Writes through `body` to a file beside `path` and renames it into place: a failure leaves what was there.
pub(crate) fn save(path: &Path, body: impl FnOnce(std::io::BufWriter<std::fs::File>) -> Result<()>) -> Result<()> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(name);
    let failed = |e: std::io::Error| file_error(path, "", format!("cannot be written: {e}"));
    let file = std::fs::File::create(&part).map_err(failed)?;
    let written = body(std::io::BufWriter::new(file)).and_then(|()| std::fs::rename(&part, path).map_err(failed));
    if written.is_err() {
        // The first error is the one to report; a part that cannot be removed either changes nothing about it.
        let _ = std::fs::remove_file(&part);
    }
    written
}

/// Opens a file to read.
pub(crate) fn open(path: &Path) -> Result<std::io::BufReader<std::fs::File>> {
    let file = std::fs::File::open(path).map_err(|e| file_error(path, "", format!("cannot be opened: {e}")))?;
    Ok(std::io::BufReader::new(file))
}

fn file_error(path: &Path, place: &str, reason: String) -> Error {
    Error::File { path: path.to_owned(), place: place.to_owned(), reason }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KIND: [u8; 4] = *b"TEST";

    fn sample() -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut writer = Writer::new(&mut bytes, Path::new("sample"), KIND, 3).unwrap();
        writer.field(7u64).unwrap();
        writer.array(&[1.5f32, -2.0, f32::MAX]).unwrap();
        writer.array::<u16>(&[]).unwrap();
        writer.finish().unwrap();
        bytes
    }

    fn parse(bytes: &[u8]) -> Result<(u64, Vec<f32>, Vec<u16>)> {
        let mut reader = Reader::new(bytes, Path::new("sample"), KIND, "a test", 3)?;
        let parsed = (reader.field()?, reader.array("floats", None)?, reader.array("shorts", Some(0))?);
        reader.finish()?;
        Ok(parsed)
    }

    #[test]
    fn what_was_written_is_read() {
        assert_eq!(parse(&sample()).unwrap(), (7, vec![1.5, -2.0, f32::MAX], vec![]));
    }

    #[test]
    fn every_cut_every_flipped_bit_and_every_tail_is_refused() {
        let good = sample();
        for len in 0..good.len() {
            assert!(parse(&good[..len]).is_err(), "cut at {len}");
        }
        for bit in 0..8 * good.len() {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(parse(&bad).is_err(), "bit {bit}");
        }
        assert!(parse(&[good.as_slice(), &[0]].concat()).is_err());
    }

    #[test]
    fn messages_say_what_is_wrong() {
        let say = |bytes: &[u8]| parse(bytes).unwrap_err().to_string();
        assert_eq!(say(b"something else"), "sample, byte 0: is not a haarmonic transport");
        let mut other = sample();
        other[10..14].copy_from_slice(b"DIFF");
        assert_eq!(say(&other), "sample, byte 10: holds a transport of kind \"DIFF\", expected a test");
        let mut newer = sample();
        newer[14] = 9;
        assert_eq!(say(&newer), "sample, byte 14: has version 9, this build reads version 3: bake it again");
    }
}
