//! By way of wavelets or of pixels.

/// How an operation on a [`WaveletImage`](super::WaveletImage) is computed; both give the same numbers to rounding.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ImageRoute {
    /// From the terms that there are. Its cost grows with them.
    Wavelets,
    /// By decompression, the operation on pixels, and compression. Its cost hardly depends on the terms.
    Pixels,
}

impl ImageRoute {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Wavelets, Self::Pixels];
}
