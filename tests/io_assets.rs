//! Real files, where they are: the folder of the environment variable `HAARMONIC_ASSETS`, else `../shared/assets`.
#![cfg(feature = "io")]

use std::io::Write;
use std::path::PathBuf;

use haarmonic::io::{Image, load_image, load_mesh};

/// The path of a real file; where it is absent, a line on stderr says that the test was skipped.
fn asset(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("HAARMONIC_ASSETS")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/assets"), PathBuf::from);
    let path = folder.join(name);
    if path.is_file() {
        return Some(path);
    }
    // Written past the harness, which would capture a print of a test that passes.
    let _ = writeln!(std::io::stderr(), "skipped: {} is not there (set HAARMONIC_ASSETS)", path.display());
    None
}

fn check_mesh(name: &str, vertices: usize, faces: usize) {
    let Some(path) = asset(name) else { return };
    let loaded = load_mesh(path).unwrap();
    assert_eq!(loaded.warnings, []);
    let mesh = loaded.value;
    assert_eq!((mesh.positions().len(), mesh.faces().len()), (vertices, faces));
    // Watertight: every edge is used once in each direction.
    let mut edges: Vec<[u32; 2]> = mesh.faces().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    edges.sort_unstable();
    assert!(edges.windows(2).all(|w| w[0] != w[1]), "an edge is used twice in the same direction");
    assert!(edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok()), "an edge is open");
    // Wound outwards: the signed volume is positive.
    let volume: f64 = (mesh.faces().iter())
        .map(|f| f.map(|i| mesh.positions()[i as usize].cast::<f64>()))
        .map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0)
        .sum();
    assert!(volume > 0.0, "{volume}");
}

#[test]
fn bunny_obj() {
    check_mesh("bunny.obj", 1839, 3674);
}

#[test]
fn armadillo_ply() {
    check_mesh("armadillo.ply", 26002, 52000);
}

/// Mean and largest of all channels.
fn statistics(image: &Image) -> (f64, f64) {
    let channels = || image.pixels().iter().flatten().map(|c| f64::from(*c));
    (channels().sum::<f64>() / (3 * image.pixels().len()) as f64, channels().fold(0.0, f64::max))
}

fn check_image(name: &str, size: (usize, usize)) -> Option<(f64, f64)> {
    let loaded = load_image(asset(name)?).unwrap();
    // Lossy compression rings below zero; that is all that may be wrong with these files.
    for warning in &loaded.warnings {
        assert!(warning.message.contains("set to 0 (lowest -0.00"), "{warning}");
    }
    assert_eq!((loaded.value.width(), loaded.value.height()), size);
    Some(statistics(&loaded.value))
}

#[test]
fn forest_exr() {
    let Some((mean, max)) = check_image("forest.exr", (1024, 512)) else { return };
    assert!((max / mean / 1761.0 - 1.0).abs() < 0.01, "mean {mean}, max {max}");
}

#[test]
fn studio_exr() {
    let Some((mean, max)) = check_image("studio.exr", (1024, 512)) else { return };
    // Made with a clamp to [0, 100]; the lossy compression may overshoot a little.
    assert!((80.0..110.0).contains(&max), "{max}");
    assert!((0.05..5.0).contains(&mean), "{mean}");
}

#[test]
fn sunset_hdr() {
    let Some((mean, max)) = check_image("sunset_256.hdr", (256, 128)) else { return };
    // The sun is one bright pixel or few: 764 is a stored value of the file, and exact.
    assert_eq!(max, 764.0);
    assert!((mean - 0.4626).abs() < 1e-4, "{mean}");
}
