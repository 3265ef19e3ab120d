//! What each fuzz target does with an input: it reads, and whatever is accepted must be valid and usable.
//!
//! An input is a byte that chooses the reader's settings, then a file.

mod mesh;
mod picture;
mod store;

use haarmonic::Error;

pub use self::mesh::{gltf, obj, ply};
pub use self::picture::{exr, hdr, merl, merl_edits, png};
pub use self::store::store;

/// What errors and warnings call the input.
const NAME: &str = "input";

/// An error of a reader names the file.
#[track_caller]
fn check_error(error: &Error) {
    let Error::File { path, reason, .. } = error else { panic!("not the error of a file: {error:?}") };
    assert!(path.as_os_str() == NAME, "the error names {}", path.display());
    assert!(!reason.is_empty());
}

/// The byte of settings and the file.
fn split(data: &[u8]) -> (usize, &[u8]) {
    data.split_first().map_or((0, data), |(&first, file)| (usize::from(first), file))
}
