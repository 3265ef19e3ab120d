//! Blocks: some scan lines or a tile, compressed by itself.
//!
//! Uncompressed, a block is its lines from the top; in a line, channel after channel; of a channel, sample after
//! sample, little endian. Whatever the compressed bytes say, a decoder writes into a buffer of exactly that size, and
//! takes memory besides for at most about as much again: every size that a block declares is checked against the size
//! that the header gives it before anything is taken for it.

use super::header::{Channel, Compression};
use super::{b44, deflate, dwa, piz, pxr24};

/// The size of a block and what is in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block<'a> {
    pub(super) channels: &'a [Channel],
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Block<'_> {
    /// Samples of a channel.
    pub(super) fn samples(&self) -> usize {
        self.width * self.height
    }

    /// Bytes of a line.
    pub(super) fn line_size(&self) -> usize {
        self.width * self.channels.iter().map(|c| c.samples.size()).sum::<usize>()
    }

    /// Bytes of the block, uncompressed.
    pub(super) fn size(&self) -> usize {
        self.height * self.line_size()
    }

    /// Where in a line each channel begins.
    pub(super) fn channel_starts(&self) -> Vec<usize> {
        let sizes = self.channels.iter().map(|c| self.width * c.samples.size());
        sizes
            .scan(0, |at, size| {
                *at += size;
                Some(*at - size)
            })
            .collect()
    }

    /// Fills `raw`, of [`size`](Self::size) bytes, from compressed bytes.
    ///
    /// # Errors
    /// What is wrong with them, in words.
    pub(super) fn decode(&self, compression: Compression, bytes: &[u8], raw: &mut [u8]) -> Result<(), String> {
        // What compression would not make smaller is stored as it is.
        if bytes.len() == raw.len() {
            raw.copy_from_slice(bytes);
            return Ok(());
        }
        match compression {
            Compression::None => Err(format!("{} bytes where {} are needed", bytes.len(), raw.len())),
            Compression::Rle => deflate::run_length(bytes, raw),
            Compression::Zips | Compression::Zip => deflate::zip(bytes, raw),
            Compression::Pxr24 => pxr24::decode(self, bytes, raw),
            Compression::Piz => piz::decode(self, bytes, raw),
            Compression::B44 => b44::decode(self, bytes, raw),
            Compression::Dwaa | Compression::Dwab => dwa::decode(self, bytes, raw),
        }
    }
}
