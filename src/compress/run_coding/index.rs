//! The integers that places in a map are stored as, and where the changes of each of many maps lie.

use std::ops::Range;

use crate::{Error, Result};

mod sealed {
    pub trait Sealed {}
    impl Sealed for u8 {}
    impl Sealed for u16 {}
    impl Sealed for u32 {}
}

/// How a place in a map is stored; sealed: `u8` for maps of up to 256 pixels, `u16` up to 65536, `u32` beyond.
pub trait MapIndex: sealed::Sealed + Copy + Ord + std::hash::Hash + std::fmt::Debug + Send + Sync + 'static {
    /// The longest map whose places fit.
    const LONGEST: u64;
    /// Narrows; the place is below [`LONGEST`](Self::LONGEST).
    fn of(place: usize) -> Self;
    /// Widens.
    fn place(self) -> usize;
}

macro_rules! map_index {
    ($($t:ty)*) => {$(
        impl MapIndex for $t {
            const LONGEST: u64 = <$t>::MAX as u64 + 1;
            #[inline(always)]
            fn of(place: usize) -> Self {
                place as $t
            }
            #[inline(always)]
            fn place(self) -> usize {
                self as usize
            }
        }
    )*};
}
map_index!(u8 u16 u32);

/// Whether maps of `len` pixels can be stored with `I`.
pub(super) fn check_map_length<I: MapIndex>(len: usize) -> Result<()> {
    if len == 0 || len as u64 > I::LONGEST {
        let allowed = match I::LONGEST {
            0x100 => "from 1 to 256 with u8",
            0x1_0000 => "from 1 to 65536 with u16",
            _ => "from 1 to 2^32 with u32",
        };
        return Err(Error::OutOfRange { what: "length of a map", got: len as f64, allowed });
    }
    Ok(())
}

/// Whether changes rise strictly and lie within the map.
pub(super) fn check_changes<I: MapIndex>(changes: &[I], len: usize) -> Result<()> {
    if let Some(at) = changes.windows(2).position(|pair| pair[0] >= pair[1]) {
        let got = changes[at + 1].place() as f64;
        return Err(Error::OutOfRange { what: "change of a map", got, allowed: "above the one before it" });
    }
    if let Some(last) = changes.last().filter(|last| last.place() >= len) {
        let got = last.place() as f64;
        return Err(Error::OutOfRange { what: "change of a map", got, allowed: "below the length of the map" });
    }
    Ok(())
}

/// Where the changes of a range of maps lie, and where each of these maps' end counted from there; `ends` has those of
/// all maps.
#[track_caller]
pub(super) fn slice_ends(ends: &[u32], range: Range<usize>) -> (Range<usize>, Vec<u32>) {
    let place = |map: usize| if map == 0 { 0 } else { ends[map - 1] };
    let (start, end) = (place(range.start), place(range.end));
    (start as usize..end as usize, ends[range].iter().map(|&end| end - start).collect())
}
