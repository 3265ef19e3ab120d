//! Reading a file.

use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use super::field::Field;
use super::{END, Kind, MAGIC, PIECE, file_error};
use crate::{Error, Result};

/// Reads the header and sections, and checks everything on the way.
pub struct Reader<'a> {
    input: &'a mut dyn Read,
    crc: crc32fast::Hasher,
    path: PathBuf,
    offset: u64,
}

impl<'a> Reader<'a> {
    /// Reads and checks the header.
    pub(crate) fn new(input: &'a mut dyn Read, path: &Path, kind: Kind) -> Result<Self> {
        let mut reader = Self { input, crc: crc32fast::Hasher::new(), path: path.to_owned(), offset: 0 };
        if reader.bytes(MAGIC.len() as u64)? != MAGIC {
            return Err(file_error(path, "byte 0", "is no file of haarmonic".into()));
        }
        let found: [u8; 4] = reader.fixed()?;
        if found != kind.tag() {
            let found = match Kind::from_tag(found) {
                Some(other) => other.name().to_owned(),
                None => format!("something of kind {:?}", String::from_utf8_lossy(&found)),
            };
            return Err(file_error(path, "byte 10", format!("holds {found}, expected {}", kind.name())));
        }
        let (found, version) = (u32::from_le_bytes(reader.fixed()?), kind.version());
        if found != version {
            let reason = format!("has version {found}, this build reads version {version}: make it again");
            return Err(file_error(path, "byte 14", reason));
        }
        Ok(reader)
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

    fn fixed<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    /// So many bytes: no more memory is taken than there are.
    fn bytes(&mut self, len: u64) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let mut left = len;
        while left > 0 {
            let (now, start) = (left.min(PIECE as u64) as usize, bytes.len());
            bytes.resize(start + now, 0);
            self.fill(&mut bytes[start..])?;
            left -= now as u64;
        }
        Ok(bytes)
    }

    /// An error at the present place.
    pub(crate) fn wrong(&self, reason: impl Into<String>) -> Error {
        file_error(&self.path, &format!("byte {}", self.offset), reason.into())
    }

    /// The next section, which must have this tag; sections before it that may be skipped are.
    pub(crate) fn section(&mut self, tag: [u8; 4]) -> Result<SectionReader> {
        let len = self.find(tag)?;
        let start = self.offset;
        Ok(SectionReader { bytes: self.bytes(len)?, at: 0, start, path: self.path.clone() })
    }

    fn find(&mut self, tag: [u8; 4]) -> Result<u64> {
        loop {
            let found: [u8; 4] = self.fixed()?;
            let len = u64::from_le_bytes(self.fixed()?);
            if found == tag {
                return Ok(len);
            }
            if !found[0].is_ascii_lowercase() {
                let [found, tag] = [found, tag].map(|tag| String::from_utf8_lossy(&tag).into_owned());
                return Err(self.wrong(format!("a section {tag:?} was expected, there is one {found:?}")));
            }
            let mut left = len;
            let mut piece = vec![0; left.min(PIECE as u64) as usize];
            while left > 0 {
                let now = left.min(PIECE as u64) as usize;
                self.fill(&mut piece[..now])?;
                left -= now as u64;
            }
        }
    }

    /// Checks the checksum and that nothing follows.
    pub(crate) fn finish(mut self) -> Result<()> {
        if self.find(END)? != 4 {
            return Err(self.wrong("does not end as it should"));
        }
        let computed = self.crc.clone().finalize();
        let stored = u32::from_le_bytes(self.fixed()?);
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

/// Takes the numbers of a section, one after the other.
pub struct SectionReader {
    bytes: Vec<u8>,
    at: usize,
    start: u64,
    path: PathBuf,
}

impl SectionReader {
    /// An error at the present place.
    pub(crate) fn wrong(&self, reason: impl Into<String>) -> Error {
        file_error(&self.path, &format!("byte {}", self.start + self.at as u64), reason.into())
    }

    fn take(&mut self, what: &str, len: Option<usize>) -> Result<&[u8]> {
        match len.and_then(|len| self.at.checked_add(len)).filter(|&end| end <= self.bytes.len()) {
            Some(end) => {
                let start = std::mem::replace(&mut self.at, end);
                Ok(&self.bytes[start..end])
            }
            None => Err(self.wrong(format!("the section ends within {what}"))),
        }
    }

    /// A number.
    pub(crate) fn field<T: Field>(&mut self, what: &str) -> Result<T> {
        self.take(what, Some(T::SIZE)).map(T::take)
    }

    /// A number that counts something.
    pub(crate) fn count(&mut self, what: &str) -> Result<usize> {
        let count: u64 = self.field(what)?;
        usize::try_from(count).map_err(|_| self.wrong(format!("{count} {what} are too many for this machine")))
    }

    /// So many numbers.
    pub(crate) fn array<T: Field>(&mut self, what: &str, len: usize) -> Result<Vec<T>> {
        let bytes = self.take(what, len.checked_mul(T::SIZE))?;
        Ok(bytes.chunks_exact(T::SIZE).map(T::take).collect())
    }

    /// As many numbers as it says there.
    pub(crate) fn list<T: Field>(&mut self, what: &str) -> Result<Vec<T>> {
        let len = self.count(what)?;
        self.array(what, len)
    }

    /// All numbers that are left.
    pub(crate) fn rest<T: Field>(&mut self, what: &str) -> Result<Vec<T>> {
        let left = self.bytes.len() - self.at;
        if left % T::SIZE != 0 {
            return Err(self.wrong(format!("{what} are cut in a number")));
        }
        self.array(what, left / T::SIZE)
    }

    /// Checks that there is nothing left.
    pub(crate) fn end(self) -> Result<()> {
        if self.at == self.bytes.len() { Ok(()) } else { Err(self.wrong("the section is longer than what it holds")) }
    }
}
