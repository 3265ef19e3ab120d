//! What files there are.

use std::io::Read;
use std::path::Path;

use super::{MAGIC, file_error};
use crate::Result;

macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident: $tag:literal, version $version:literal, $name:literal;)*) => {
        /// What a file holds. Every type that can be stored has one, and every one its type.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum Kind {
            $($(#[$doc])* $kind,)*
        }

        impl Kind {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$kind),*];

            /// The four letters that name it in a file.
            pub const fn tag(self) -> [u8; 4] {
                match self {
                    $(Self::$kind => *$tag,)*
                }
            }

            /// The version that this build writes and reads.
            pub const fn version(self) -> u32 {
                match self {
                    $(Self::$kind => $version,)*
                }
            }

            /// What it is, in words.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => $name,)*
                }
            }
        }
    };
}

kinds! {
    /// [`compress::CodedBinaryMaps`](crate::compress::CodedBinaryMaps).
    CodedBinaryMaps: b"MAPB", version 1, "binary maps";
    /// [`compress::CodedGrayMaps`](crate::compress::CodedGrayMaps).
    CodedGrayMaps: b"MAPG", version 1, "gray maps";
    /// [`compress::Biclustering`](crate::compress::Biclustering).
    Biclustering: b"BICL", version 1, "a biclustering";
    /// [`compress::Pca`](crate::compress::Pca).
    Pca: b"PCA ", version 1, "principal components";
    /// [`compress::ClusteredPca`](crate::compress::ClusteredPca).
    ClusteredPca: b"CPCA", version 1, "clustered principal components";
    /// [`compress::QuantisedHalf`](crate::compress::QuantisedHalf).
    QuantisedHalf: b"HALF", version 1, "numbers of 16 bits";
    /// [`compress::QuantisedBytes`](crate::compress::QuantisedBytes).
    QuantisedBytes: b"BYTE", version 1, "numbers of 8 bits";
    /// The transport of `backend::wavelet_double`.
    WaveletDouble: b"WDBL", version 2, "a transport of wavelet double products";
    /// The transport of `backend::wavelet_triple`.
    WaveletTriple: b"WTRI", version 2, "a transport of wavelet triple products";
    /// The transport of `backend::near_field`.
    NearField: b"NEAR", version 1, "a transport of near-field relighting";
    /// The transport of `backend::block_product`.
    BlockProduct: b"BLKP", version 3, "a transport of block products";
}

impl Kind {
    /// The kind that a tag names, if this build knows it.
    pub fn from_tag(tag: [u8; 4]) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.tag() == tag)
    }

    /// What a file holds. Its header is read and nothing else.
    ///
    /// # Errors
    /// [`Error::File`](crate::Error::File) if it cannot be read, is none of this crate's, or of a kind that this build
    /// does not know.
    pub fn of(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let mut file = std::fs::File::open(path).map_err(|e| file_error(path, "", format!("cannot be opened: {e}")))?;
        let mut header = [0; 14];
        let is_whole = file.read_exact(&mut header).is_ok() && header.starts_with(MAGIC);
        if !is_whole {
            return Err(file_error(path, "byte 0", "is no file of haarmonic".into()));
        }
        let tag = [header[10], header[11], header[12], header[13]];
        Self::from_tag(tag).ok_or_else(|| {
            let tag = String::from_utf8_lossy(&tag).into_owned();
            file_error(path, "byte 10", format!("is of kind {tag:?}, which this build does not know"))
        })
    }
}
