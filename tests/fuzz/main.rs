//! The inputs of `fuzz/corpus` through the bodies of the fuzz targets. See fuzz/README.md.
#![cfg(all(feature = "io", feature = "backends"))]

#[allow(dead_code, reason = "tests of pictures use the rest")]
#[path = "../io/pictures/exr_files.rs"]
mod exr_files;
#[allow(dead_code, reason = "seeds use a part of this")]
#[path = "../support/noise.rs"]
mod noise;
mod seeds;
mod targets;

use std::io::Write;
use std::path::{Path, PathBuf};

/// Where the committed inputs of a target are.
fn corpus(target: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(target)
}

/// The inputs of a target, in order: the committed ones, or those of the folder of its name in `HAARMONIC_FUZZ_INPUTS`.
/// Where there are none, a line on stderr says so.
fn inputs(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder =
        std::env::var_os("HAARMONIC_FUZZ_INPUTS").map_or_else(|| corpus(target), |f| Path::new(&f).join(target));
    if !folder.is_dir() {
        // Written past the harness, which would capture a print of a test that passes.
        let _ = writeln!(std::io::stderr(), "skipped: {} is not there", folder.display());
        return Vec::new();
    }
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    assert!(!paths.is_empty(), "no inputs of {target}");
    paths.into_iter().map(|path| (path.clone(), std::fs::read(path).unwrap())).collect()
}

/// Runs a target and, if it panics, says on what.
fn check(run: fn(&[u8]), input: &[u8], what: impl std::fmt::Display) {
    if let Err(panic) = std::panic::catch_unwind(|| run(input)) {
        let _ = writeln!(std::io::stderr(), "the input was {what}");
        std::panic::resume_unwind(panic);
    }
}

macro_rules! replayed {
    ($($target:ident)*) => {$(
        #[test]
        fn $target() {
            for (path, input) in inputs(stringify!($target)) {
                check(targets::$target, &input, path.display());
            }
        }
    )*};
}
replayed!(ply obj gltf hdr exr png merl merl_edits store);

/// Every number of what is stored in turn, at every edge: what a fuzzer seldom hits, because a number has many bytes.
#[test]
fn edges_of_what_is_stored() {
    let numbers = [
        vec![0],
        vec![0xff],
        0x7fff_u16.to_le_bytes().to_vec(),
        u16::MAX.to_le_bytes().to_vec(),
        0_u32.to_le_bytes().to_vec(),
        (1_u32 << 31).to_le_bytes().to_vec(),
        f32::NAN.to_le_bytes().to_vec(),
        f32::MAX.to_le_bytes().to_vec(),
        f32::MIN.to_le_bytes().to_vec(),
        1e-40_f32.to_le_bytes().to_vec(),
        0_u64.to_le_bytes().to_vec(),
        (1_u64 << 32).to_le_bytes().to_vec(),
        (1_u64 << 63).to_le_bytes().to_vec(),
        u64::MAX.to_le_bytes().to_vec(),
        f64::NAN.to_le_bytes().to_vec(),
        f64::MAX.to_le_bytes().to_vec(),
        1e-310_f64.to_le_bytes().to_vec(),
    ];
    // The short ones are all that differ in kind.
    for (path, good) in inputs("store").into_iter().filter(|(_, input)| input.len() < 700) {
        for at in 19..good.len() {
            for number in &numbers {
                let mut input = good.clone();
                let end = (at + number.len()).min(good.len());
                input[at..end].copy_from_slice(&number[..end - at]);
                check(targets::store, &input, format_args!("{} with {number:?} at {at}", path.display()));
            }
        }
    }
}
