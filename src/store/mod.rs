//! The form in which this crate keeps on disk what took long to compute: one file, one object.
//!
//! [`Stored`] saves and loads everything that has such a form: components, clustered components, biclusterings,
//! run-coded maps and quantised numbers of [`compress`](crate::compress), and the transports of the back ends. [`Kind`]
//! lists them, and [`Kind::of`] says what a file holds.
//!
//! ```text
//! "haarmonic\0"  10 bytes      kind  4 ASCII letters      version of the kind  u32
//! sections: tag  4 ASCII letters      length  u64      that many bytes
//! "END."      length 4, as u64      CRC-32 of everything before the CRC  u32
//! ```
//! Numbers are little-endian. A section is a list of numbers, in an order that its kind fixes. A reader takes the
//! sections of its kind in their order. It skips a section that it does not know if the first letter of the tag is a
//! small one, and refuses it otherwise: so later versions of this crate can add what is of use without being needed.
//!
//! A file that is cut short, followed by more, damaged in any bit, of another kind or version, or inconsistent in
//! itself is an [`Error::File`] with the file and the byte. Arrays are read in pieces: a length that lies fails at the
//! end of the file and not in the allocator.

mod kind;
mod reader;
mod writer;

use std::io::{Read, Write};
use std::path::Path;

pub use kind::Kind;
pub(crate) use reader::{Reader, SectionReader};
#[allow(unused_imports, reason = "for those features that ask for it")]
pub(crate) use writer::{Section, Writer};

use crate::{Error, Result};

const MAGIC: &[u8; 10] = b"haarmonic\0";
const END: [u8; 4] = *b"END.";

/// Arrays go through a buffer of so many bytes.
const PIECE: usize = 1 << 20;

/// What can be saved to a file and loaded from it, bit for bit.
///
/// The trait cannot be implemented outside of this crate, because files say of what [`Kind`] they are.
///
/// # Example
/// ```
/// use haarmonic::compress::{Pca, PcaSettings};
/// use haarmonic::store::Stored;
/// let pca = Pca::new(&[1.0, 2.0, 5.0, 5.0, -3.0, -1.0], 2, &PcaSettings::new(1))?;
/// let mut bytes = Vec::new();
/// pca.write_to(&mut bytes)?;
/// assert_eq!(Pca::<f64>::read_from(&bytes[..])?, pca);
/// assert!(Pca::<f64>::read_from(&bytes[..bytes.len() - 1]).is_err());
/// # Ok::<(), haarmonic::Error>(())
/// ```
pub trait Stored: parts::Parts {
    /// What a file of this type says it is.
    fn kind() -> Kind {
        Self::KIND
    }

    /// Saves to a file. A failure leaves the file that was there.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written.
    fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let path = path.as_ref();
        writer::replace(path, |out| self.write_all(out, path))
    }

    /// Loads what [`save`](Self::save) wrote.
    ///
    /// # Errors
    /// [`Error::File`] naming the place if the file is of another kind or version, cut short, damaged or inconsistent.
    fn load(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let file = std::fs::File::open(path).map_err(|e| file_error(path, "", format!("cannot be opened: {e}")))?;
        Self::read_all(std::io::BufReader::new(file), path)
    }

    /// Writes the bytes of a file to any place.
    ///
    /// # Errors
    /// [`Error::File`] with the path "stream" if they cannot be written.
    fn write_to(&self, out: impl Write) -> Result<()> {
        self.write_all(out, Path::new("stream"))
    }

    /// Reads the bytes of a file from any place, to their end.
    ///
    /// # Errors
    /// As [`load`](Self::load), with the path "stream".
    fn read_from(input: impl Read) -> Result<Self> {
        Self::read_all(input, Path::new("stream"))
    }

    #[doc(hidden)]
    fn write_all(&self, mut out: impl Write, path: &Path) -> Result<()> {
        let mut writer = Writer::new(&mut out, path, Self::KIND)?;
        self.write(&mut writer)?;
        writer.finish()
    }

    #[doc(hidden)]
    fn read_all(mut input: impl Read, path: &Path) -> Result<Self> {
        let mut reader = Reader::new(&mut input, path, Self::KIND)?;
        let read = Self::read(&mut reader)?;
        reader.finish()?;
        Ok(read)
    }
}

impl<T: parts::Parts> Stored for T {}

pub(crate) mod parts {
    use super::{Kind, Reader, Writer};
    use crate::Result;

    /// How a type becomes sections and is made of them again.
    pub trait Parts: Sized {
        /// What a file of it says it is.
        const KIND: Kind;
        /// Writes its sections.
        fn write(&self, to: &mut Writer) -> Result<()>;
        /// Reads what [`write`](Self::write) wrote, and refuses what contradicts itself.
        fn read(from: &mut Reader) -> Result<Self>;
    }
}

/// A number as it stands in a file.
pub(crate) mod field {
    /// Little-endian.
    pub trait Field: Copy {
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
    field!(u8 i8 u16 i16 u32 i32 u64 f32 f64);
}

/// Reads of how many bits numbers are, which must be those of `T`.
pub(crate) fn check_bits<T: field::Field>(section: &mut SectionReader) -> Result<()> {
    match section.field::<u8>("bits of a number")? {
        bits if usize::from(bits) == 8 * T::SIZE => Ok(()),
        bits => Err(section.wrong(format!("holds numbers of {bits} bits, expected {}", 8 * T::SIZE))),
    }
}

fn file_error(path: &Path, place: &str, reason: String) -> Error {
    Error::File { path: path.to_owned(), place: place.to_owned(), reason }
}

#[cfg(test)]
mod tests;
