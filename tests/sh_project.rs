//! Projection, reconstruction, windows, extrema and fits of spherical harmonics against naive twins, golden values and theorems.
#![cfg(all(feature = "reference", feature = "proptest"))]

use std::f64::consts::PI;

use haarmonic::nalgebra::{UnitVector3, Vector3};
use haarmonic::reference::sh as naive;
use haarmonic::sh::{
    Channels, CubeProjection, CubeReconstruction, LatLongProjection, LatLongReconstruction, TexelRule, degree_order,
    project_cube, project_fn, project_fn_channels, project_lat_long,
};
use haarmonic::sphere::{CubeGrid, CubeMap, LatLongGrid, LatLongMap, SphereQuadrature, fibonacci_directions};
use haarmonic::strategies;
use haarmonic::{Error, Real};
use proptest::prelude::*;
use serde_json::Value;

fn golden(name: &str) -> Value {
    let path = format!("{}/tests/golden/sh_airlight_normal/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn cases() -> ProptestConfig {
    ProptestConfig::with_cases(std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(48))
}

/// Largest |a − b|; NaN or infinity anywhere is infinite.
fn worst<T: Real>(got: &[T], want: &[f64]) -> f64 {
    assert_eq!(got.len(), want.len());
    got.iter().zip(want).fold(0.0, |worst, (got, want)| {
        let off = (got.widen() - want).abs();
        if off.is_finite() { off.max(worst) } else { f64::INFINITY }
    })
}

#[track_caller]
fn assert_below(error: f64, tolerance: f64, what: &str) {
    assert!(error <= tolerance, "{what}: error {error:e} exceeds {tolerance:e}");
}

/// No zeros, no pattern, decaying with the degree.
fn coefficients(bands: usize) -> Vec<f64> {
    (0..bands * bands).map(|i| (1.0 + 2.3 * i as f64).sin() / (1.0 + degree_order(i).0 as f64)).collect()
}

/// A texel value with no symmetry.
fn noise(i: usize) -> f64 {
    let x = (1.7 * i as f64 + 0.3).sin() * 43758.5453;
    x - x.floor() + 0.1
}

fn narrow<T: Real>(values: &[f64]) -> Vec<T> {
    values.iter().map(|&x| T::of(x)).collect()
}

const RULES: [TexelRule; 2] = [TexelRule::Centre, TexelRule::Mean];

fn cube_twin(grid: CubeGrid, texels: &[f64], bands: usize, rule: TexelRule) -> Vec<f64> {
    if rule == TexelRule::Centre {
        return naive::project_cube(&CubeMap::new(grid, texels.to_vec()).unwrap(), bands);
    }
    let mut out = vec![0.0; bands * bands];
    for (i, f) in texels.iter().enumerate() {
        let points = 6 + (bands + 20) / grid.side();
        out.iter_mut().zip(naive::cube_texel_integrals(bands, grid, i, points)).for_each(|(o, y)| *o += f * y);
    }
    out
}

fn lat_long_twin(grid: LatLongGrid, pixels: &[f64], bands: usize, rule: TexelRule) -> Vec<f64> {
    if rule == TexelRule::Centre {
        return naive::project_lat_long(&LatLongMap::new(grid, pixels.to_vec()).unwrap(), bands);
    }
    let mut out = vec![0.0; bands * bands];
    for (i, f) in pixels.iter().enumerate() {
        let points = 6 + (2 * bands + 20) / grid.width().min(grid.height());
        out.iter_mut().zip(naive::lat_long_pixel_integrals(bands, grid, i, points)).for_each(|(o, y)| *o += f * y);
    }
    out
}

/// Grids from one texel up, odd and even, bands on both sides of a register, both scalars; also the map back.
#[test]
fn cube_maps_against_the_twin() {
    for (side, bands) in [(1, 1), (1, 4), (2, 3), (3, 6), (4, 9), (7, 2), (8, 8), (9, 17), (16, 5), (33, 3)] {
        let grid = CubeGrid::new(side).unwrap();
        let texels: Vec<f64> = (0..grid.len()).map(|i| noise(side + i)).collect();
        let c = coefficients(bands);
        for rule in RULES {
            let want = cube_twin(grid, &texels, bands, rule);
            let map = CubeMap::new(grid, texels.clone()).unwrap();
            let [got] = CubeProjection::new(grid, bands, rule).unwrap().project(&map);
            // Texels up to 1.1 over 4π, basis values up to √bands: eps · 14 · √bands, and the twin's own rounding; its Gauss weights
            // are known to 1e-14.
            let what = format!("side {side}, {bands} bands, {rule:?}");
            let scale = 14.0 * (bands as f64).sqrt();
            assert_below(worst(&got, &want), 60.0 * f64::EPSILON * scale, &what);
            let map = map.map(|t| t as f32);
            let [got] = CubeProjection::new(grid, bands, rule).unwrap().project(&map);
            assert_below(worst(&got, &want), 2.0 * f64::from(f32::EPSILON) * scale, &format!("{what}, f32"));

            let want: Vec<f64> = (0..grid.len()).map(|i| cube_texel(grid, i, &c, rule)).collect();
            let scale = 4.0 * (bands as f64).sqrt();
            let map: CubeMap<f64> = CubeReconstruction::new(grid, bands, rule).unwrap().reconstruct([&c]);
            assert_below(worst(map.texels(), &want), 20.0 * f64::EPSILON * scale, &format!("{what}, back"));
            let map: CubeMap<f32> = CubeReconstruction::new(grid, bands, rule).unwrap().reconstruct([&narrow(&c)]);
            assert_below(worst(map.texels(), &want), f64::from(f32::EPSILON) * scale, &format!("{what}, back, f32"));
        }
    }
}

fn cube_texel(grid: CubeGrid, i: usize, c: &[f64], rule: TexelRule) -> f64 {
    match rule {
        TexelRule::Centre => naive::reconstruct(c, &grid.direction(i)),
        TexelRule::Mean => {
            let bands = c.len().isqrt();
            let y = naive::cube_texel_integrals(bands, grid, i, 6 + (bands + 20) / grid.side());
            mean(c, &y)
        }
    }
}

#[test]
fn lat_long_maps_against_the_twin() {
    let sizes =
        [(1, 1, 3), (2, 1, 2), (1, 4, 4), (5, 3, 6), (8, 4, 9), (16, 9, 17), (17, 8, 8), (40, 20, 5), (129, 3, 3)];
    for (width, height, bands) in sizes {
        let grid = LatLongGrid::new(width, height).unwrap();
        let pixels: Vec<f64> = (0..grid.len()).map(|i| noise(width + i)).collect();
        let c = coefficients(bands);
        for rule in RULES {
            let want = lat_long_twin(grid, &pixels, bands, rule);
            let map = LatLongMap::new(grid, pixels.clone()).unwrap();
            let [got] = LatLongProjection::new(grid, bands, rule).unwrap().project(&map);
            let what = format!("{width}×{height}, {bands} bands, {rule:?}");
            let scale = 14.0 * (bands as f64).sqrt();
            assert_below(worst(&got, &want), 20.0 * f64::EPSILON * scale, &what);
            let [got] = LatLongProjection::new(grid, bands, rule).unwrap().project(&map.map(|t| t as f32));
            assert_below(worst(&got, &want), 2.0 * f64::from(f32::EPSILON) * scale, &format!("{what}, f32"));

            let want: Vec<f64> = (0..grid.len()).map(|i| lat_long_pixel(grid, i, &c, rule)).collect();
            let scale = 4.0 * (bands as f64).sqrt();
            let map: LatLongMap<f64> = LatLongReconstruction::new(grid, bands, rule).unwrap().reconstruct([&c]);
            assert_below(worst(map.pixels(), &want), 20.0 * f64::EPSILON * scale, &format!("{what}, back"));
            let map: LatLongMap<f32> =
                LatLongReconstruction::new(grid, bands, rule).unwrap().reconstruct([&narrow(&c)]);
            assert_below(worst(map.pixels(), &want), f64::from(f32::EPSILON) * scale, &format!("{what}, back, f32"));
        }
    }
}

fn lat_long_pixel(grid: LatLongGrid, i: usize, c: &[f64], rule: TexelRule) -> f64 {
    match rule {
        TexelRule::Centre => naive::reconstruct(c, &grid.direction(i)),
        TexelRule::Mean => {
            let bands = c.len().isqrt();
            let y =
                naive::lat_long_pixel_integrals(bands, grid, i, 6 + (2 * bands + 20) / grid.width().min(grid.height()));
            mean(c, &y)
        }
    }
}

/// Σ c_i ∫ y_i over the solid angle, which is ∫ y_0 √4π.
fn mean(c: &[f64], y: &[f64]) -> f64 {
    c.iter().zip(y).map(|(c, y)| c * y).sum::<f64>() / (y[0] * (4.0 * PI).sqrt())
}

#[test]
fn expansions_are_projected_exactly() {
    for bands in [1, 2, 6, 20] {
        let c = coefficients(bands);
        let rule = SphereQuadrature::new(2 * (bands - 1)).unwrap();
        let got: Vec<f64> = project_fn(bands, &rule, |d| naive::reconstruct(&c, d)).unwrap();
        assert_below(worst(&got, &c), 1e-14 * bands as f64, "f64");
        let [got, twice] = project_fn_channels::<f32, 2>(bands, &rule, |d| {
            let f = naive::reconstruct(&c, d);
            [f, 2.0 * f]
        })
        .unwrap();
        assert_below(worst(&got, &c), f64::from(f32::EPSILON), "f32");
        assert_eq!(twice, got.iter().map(|c| 2.0 * c).collect::<Vec<_>>());
    }
}

#[test]
fn golden_clamped_cosine() {
    let want = numbers(&golden("clamped_cosine")["zonal_coefficients"]);
    // Across the kink at the equator the rule is one of step h = π/501: 2π h²/12 for a kink of 1 at a node, times y₀₀ … √2.
    let rule = SphereQuadrature::new(1000).unwrap();
    let got: Vec<f64> = project_fn(want.len(), &rule, |d| d.z.max(0.0)).unwrap();
    for (i, got) in got.into_iter().enumerate() {
        let (l, m) = degree_order(i);
        assert_below((got - if m == 0 { want[l] } else { 0.0 }).abs(), 3e-5, &format!("l {l}, m {m}"));
    }
}
