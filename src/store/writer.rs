//! Writing a file.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::field::Field;
use super::{END, Kind, MAGIC, file_error};
use crate::Result;

/// Writes sections behind a header, and a checksum behind them.
pub struct Writer<'a> {
    out: &'a mut dyn Write,
    crc: crc32fast::Hasher,
    path: PathBuf,
}

/// The numbers of one section.
#[derive(Default)]
pub struct Section {
    bytes: Vec<u8>,
}

impl Section {
    /// Appends a number.
    pub(crate) fn field<T: Field>(&mut self, value: T) {
        value.put(&mut self.bytes);
    }

    /// Appends numbers, without how many there are.
    pub(crate) fn array<T: Field>(&mut self, values: &[T]) {
        self.bytes.reserve(values.len() * T::SIZE);
        values.iter().for_each(|value| value.put(&mut self.bytes));
    }

    /// Appends how many numbers there are, and these.
    pub(crate) fn list<T: Field>(&mut self, values: &[T]) {
        self.field(values.len() as u64);
        self.array(values);
    }
}

impl<'a> Writer<'a> {
    /// Writes the header.
    pub(crate) fn new(out: &'a mut dyn Write, path: &Path, kind: Kind) -> Result<Self> {
        let mut writer = Self { out, crc: crc32fast::Hasher::new(), path: path.to_owned() };
        writer.bytes(MAGIC)?;
        writer.bytes(&kind.tag())?;
        writer.bytes(&kind.version().to_le_bytes())?;
        Ok(writer)
    }

    fn bytes(&mut self, bytes: &[u8]) -> Result<()> {
        self.crc.update(bytes);
        self.out.write_all(bytes).map_err(|e| file_error(&self.path, "", format!("cannot be written: {e}")))
    }

    /// Writes a section. It is put together in memory first.
    pub(crate) fn section(&mut self, tag: [u8; 4], fill: impl FnOnce(&mut Section)) -> Result<()> {
        let mut section = Section::default();
        fill(&mut section);
        self.head(tag, section.bytes.len())?;
        self.bytes(&section.bytes)
    }

    fn head(&mut self, tag: [u8; 4], len: usize) -> Result<()> {
        self.bytes(&tag)?;
        self.bytes(&(len as u64).to_le_bytes())
    }

    /// Writes the checksum.
    pub(crate) fn finish(mut self) -> Result<()> {
        self.head(END, 4)?;
        let crc = self.crc.clone().finalize();
        self.bytes(&crc.to_le_bytes())?;
        self.out.flush().map_err(|e| file_error(&self.path, "", format!("cannot be written: {e}")))
    }
}

/// Writes through `body` to a file beside `path` and renames it into place: a failure leaves what was there.
pub(super) fn replace(path: &Path, body: impl FnOnce(std::io::BufWriter<std::fs::File>) -> Result<()>) -> Result<()> {
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
