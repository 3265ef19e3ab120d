//! Real files, where they are: the folder of the environment variable `HAARMONIC_ASSETS`, else `../shared/assets`.

use std::f64::consts::PI;
use std::io::Write;
use std::path::PathBuf;

use haarmonic::io::{Image, load_environment, load_image, load_mesh};
use haarmonic::nalgebra::Vector3;

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

/// What is compared with the figures that the reference implementation of each format gives for the file.
struct Statistics {
    /// Mean of each channel.
    mean: Vector3<f64>,
    /// Largest channel.
    max: f64,
    /// Largest luminance over the mean luminance of the sphere, pixels weighted by their solid angle.
    peak: f64,
}

fn statistics(image: &Image) -> Statistics {
    let (w, h) = (image.width(), image.height());
    let luminance = |p: &Vector3<f32>| p.cast::<f64>().dot(&Vector3::new(0.2126, 0.7152, 0.0722));
    let weight = |i: usize| (PI * ((i / w) as f64 + 0.5) / h as f64).sin();
    let pixels = || image.pixels().iter().enumerate();
    let weights: f64 = pixels().map(|(i, _)| weight(i)).sum();
    let mean_luminance = pixels().map(|(i, p)| weight(i) * luminance(p)).sum::<f64>() / weights;
    Statistics {
        mean: pixels().map(|(_, p)| p.cast::<f64>()).sum::<Vector3<f64>>() / (w * h) as f64,
        max: pixels().map(|(_, p)| f64::from(p.max())).fold(0.0, f64::max),
        peak: pixels().map(|(_, p)| luminance(p)).fold(0.0, f64::max) / mean_luminance,
    }
}

/// Reads a picture and checks its size and how many pixels were negative.
fn check_image(name: &str, size: (usize, usize), negative: &[&str]) -> Option<Statistics> {
    let loaded = load_image(asset(name)?).unwrap();
    // Lossy compression rings below zero; that is all that is wrong with these files.
    assert_eq!(loaded.warnings.iter().map(|w| w.message.as_str()).collect::<Vec<_>>(), negative);
    assert_eq!((loaded.value.width(), loaded.value.height()), size);
    Some(statistics(&loaded.value))
}

#[test]
fn forest_exr() {
    let negative = ["784 negative pixels set to 0 (lowest -0.0015535355)"];
    let Some(s) = check_image("forest.exr", (1024, 512), &negative) else { return };
    // The reference decoder's means, negative pixels included: those are 1e-7 of the whole.
    assert!((s.mean - Vector3::new(0.510_292_0, 0.546_370_6, 0.627_810_3)).amax() < 1e-6, "{}", s.mean);
    assert_eq!(s.max, 1010.5);
    assert!((s.peak - 1761.47).abs() < 0.01, "{}", s.peak);
}

#[test]
fn studio_exr() {
    let negative = ["3 negative pixels set to 0 (lowest -0.0000030398369)"];
    let Some(s) = check_image("studio.exr", (1024, 512), &negative) else { return };
    assert!((s.mean - Vector3::new(0.229_647_2, 0.259_988_4, 0.278_697_6)).amax() < 1e-6, "{}", s.mean);
    assert_eq!(s.max, 118.375);
    assert!((s.peak - 329.409).abs() < 0.01, "{}", s.peak);
}

#[test]
fn sunset_hdr() {
    let Some(s) = check_image("sunset_256.hdr", (256, 128), &[]) else { return };
    // A stored value of the file, and exact.
    assert_eq!(s.max, 764.0);
    assert!((s.mean.mean() - 0.4626).abs() < 1e-4, "{}", s.mean);
}

#[test]
fn environments() {
    for name in ["forest.exr", "studio.exr", "sunset_256.hdr"] {
        let Some(path) = asset(name) else { continue };
        let light = load_environment(&path).unwrap().value;
        // Straight ahead, −z, is the centre of the picture.
        let image = load_image(&path).unwrap().value;
        let (w, h) = (image.width(), image.height());
        let corners = [(w / 2 - 1, h / 2 - 1), (w / 2, h / 2 - 1), (w / 2 - 1, h / 2), (w / 2, h / 2)];
        let centre = corners.iter().map(|&(x, y)| image.pixel(x, y).cast::<f64>()).sum::<Vector3<f64>>() / 4.0;
        let ahead = light.radiance(&Vector3::new(0.0, 0.0, -1.0));
        assert!((ahead - centre).amax() < 1e-6 * centre.amax(), "{name}: {ahead} {centre}");
    }
}
