//! Pictures as other programs write them, and damaged ones.

mod colours;
mod damage;
mod data;
mod environments;
pub mod exr_files;
mod exr_peer;
mod hdr;
mod png;

use std::path::PathBuf;

use haarmonic::io::{Image, Loaded};

/// A file of `tests/faults/pictures`.
fn fault(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/faults/pictures").join(name)
}

fn messages<T>(loaded: &Loaded<T>) -> Vec<String> {
    loaded.warnings.iter().map(ToString::to_string).collect()
}

/// The one message of a picture that has one.
#[track_caller]
fn only_message<T>(loaded: &Loaded<T>) -> String {
    let messages = messages(loaded);
    assert_eq!(messages.len(), 1, "{messages:?}");
    messages[0].clone()
}

/// Every pixel within `tolerance` of a colour.
#[track_caller]
fn assert_all(image: &Image, expected: [f32; 3], tolerance: f32) {
    for (i, pixel) in image.pixels().iter().enumerate() {
        for c in 0..3 {
            let difference = (pixel[c] - expected[c]).abs();
            assert!(difference <= tolerance, "pixel {i}: {:?} instead of {expected:?}", pixel.as_slice());
        }
    }
}
