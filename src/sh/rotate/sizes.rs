//! How large rotations are.

use crate::{Error, Result};

/// The largest `bands` of a rotation.
pub(super) const MAX_BANDS: usize = 128;

pub(super) fn check_bands(bands: usize) -> Result<()> {
    if bands == 0 || bands > MAX_BANDS {
        return Err(Error::OutOfRange { what: "bands", got: bands as f64, allowed: "1 to 128" });
    }
    Ok(())
}

/// Entries before block l: Σ (2k+1)² for k < l.
#[inline(always)]
pub(super) const fn block_start(l: usize) -> usize {
    l * (4 * l * l - (l > 0) as usize) / 3
}
