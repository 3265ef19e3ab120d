//! Projection, reconstruction, windows, extrema and fits of spherical harmonics against naive twins, golden values and
//! theorems.

use std::f64::consts::PI;

use haarmonic::Error;
use haarmonic::nalgebra::{UnitVector3, Vector3};
use haarmonic::reference::sh as naive;
use haarmonic::sh::{
    CubeProjection, CubeReconstruction, DeringBy, DeringWindow, Deringing, Extrema, LatLongProjection,
    LatLongReconstruction, ScatteredFit, TexelRule, Window, Zonal, degree_order, eval, index, monte_carlo,
    project_cube, project_fn, project_fn_channels, project_lat_long,
};
use haarmonic::sphere::{CubeGrid, CubeMap, LatLongGrid, LatLongMap, SphereQuadrature, fibonacci_directions};
use haarmonic::strategies;
use proptest::prelude::*;

use crate::support::{HARMONICS, assert_below, cases, coefficients, golden, narrow, noise, numbers, worst};

/// Numbers without a pattern, not near 0.
fn positive(i: usize) -> f64 {
    0.1 + noise(i)
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
        let texels: Vec<f64> = (0..grid.len()).map(|i| positive(side + i)).collect();
        let c = coefficients(bands);
        for rule in RULES {
            let want = cube_twin(grid, &texels, bands, rule);
            let map = CubeMap::new(grid, texels.clone()).unwrap();
            let [got] = CubeProjection::new(grid, bands, rule).unwrap().project(&map);
            // Texels up to 1.1 over 4π, basis values up to √bands: eps · 14 · √bands, and the twin's own rounding; its
            // Gauss weights are known to 1e-14.
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
        let pixels: Vec<f64> = (0..grid.len()).map(|i| positive(width + i)).collect();
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
    let want = numbers(&golden(HARMONICS, "clamped_cosine")["zonal_coefficients"]);
    let by = |degree: usize| -> Vec<f64> {
        project_fn(want.len(), &SphereQuadrature::new(degree).unwrap(), |d| d.z.max(0.0)).unwrap()
    };
    // The kink lies on a ring of the first rule and midway between two of the second: errors h²/12 and −h²/24 of one
    // kind.
    let (on, off) = (by(1000), by(1002));
    for (i, (on, off)) in on.into_iter().zip(off).enumerate() {
        let (l, m) = degree_order(i);
        let error = (on + 2.0 * off) / 3.0 - if m == 0 { want[l] } else { 0.0 };
        assert_below(error.abs(), 1e-7, &format!("l {l}, m {m}"));
    }
}

/// ⟨f, map of c⟩ with solid angles = ⟨projection of f, c⟩, whatever the map: reconstruction is the transpose.
#[test]
fn reconstruction_is_the_transpose_of_projection() {
    for rule in RULES {
        let grid = CubeGrid::new(13).unwrap();
        let map = CubeMap::new(grid, (0..grid.len()).map(noise).collect()).unwrap();
        let c = coefficients(7);
        let [d] = CubeProjection::new(grid, 7, rule).unwrap().project(&map);
        let back: CubeMap<f64> = CubeReconstruction::new(grid, 7, rule).unwrap().reconstruct([&c]);
        let inner: f64 = c.iter().zip(&d).map(|(c, d)| c * d).sum();
        let product = map.zip_map(&back, |f, g| f * g).integral();
        assert_below((product - inner).abs(), 1e-13, &format!("cube, {rule:?}"));

        let grid = LatLongGrid::new(21, 10).unwrap();
        let map = LatLongMap::new(grid, (0..grid.len()).map(noise).collect()).unwrap();
        let [d] = LatLongProjection::new(grid, 7, rule).unwrap().project(&map);
        let back: LatLongMap<f64> = LatLongReconstruction::new(grid, 7, rule).unwrap().reconstruct([&c]);
        let inner: f64 = c.iter().zip(&d).map(|(c, d)| c * d).sum();
        let pixels = map.pixels().iter().zip(back.pixels()).map(|(f, g)| f * g).collect();
        let product = LatLongMap::new(grid, pixels).unwrap().integral();
        assert_below((product - inner).abs(), 1e-13, &format!("lat-long, {rule:?}"));
    }
}

/// A constant is √4π of the first harmonic, by the mean exactly at any resolution; all 128 bands.
#[test]
fn constants_and_the_largest_plans() {
    let root = (4.0 * PI).sqrt();
    for (side, bands) in [(1, 3), (2, 40), (5, 128)] {
        let grid = CubeGrid::new(side).unwrap();
        let [c] = CubeProjection::new(grid, bands, TexelRule::Mean).unwrap().project(&CubeMap::from_fn(grid, |_| 2.5));
        let want: Vec<f64> = (0..bands * bands).map(|i| if i == 0 { 2.5 * root } else { 0.0 }).collect();
        assert_below(worst(&c, &want), 1e-12, &format!("cube of {side}, {bands} bands"));
        let grid = LatLongGrid::new(side, side).unwrap();
        let map = LatLongMap::from_fn(grid, |_| 2.5);
        let [c] = LatLongProjection::new(grid, bands, TexelRule::Mean).unwrap().project(&map);
        assert_below(worst(&c, &want), 1e-12, &format!("lat-long of {side}, {bands} bands"));
    }
    for bands in [0, 129] {
        let error = CubeProjection::<f32>::new(CubeGrid::new(2).unwrap(), bands, TexelRule::Mean).unwrap_err();
        assert!(matches!(error, Error::OutOfRange { what: "bands", .. }));
        assert!(LatLongReconstruction::<f32>::new(LatLongGrid::new(2, 2).unwrap(), bands, TexelRule::Mean).is_err());
    }
}

/// What the documentation says about round trips: c → map → c. Once by centres, where the error is that of the rule of
/// centres for products of harmonics, and once by means, where each way blurs by the texel.
#[test]
fn round_trips() {
    let c = coefficients(6);
    let scale = c.iter().fold(0.0f64, |s, c| s.max(c.abs()));
    let mut before = [f64::INFINITY; 4];
    for side in [8, 16, 32, 64] {
        let mut errors = [0.0; 4];
        for (k, rule) in RULES.into_iter().enumerate() {
            let grid = CubeGrid::new(side).unwrap();
            let map: CubeMap<f64> = CubeReconstruction::new(grid, 6, rule).unwrap().reconstruct([&c]);
            let [back] = CubeProjection::new(grid, 6, rule).unwrap().project(&map);
            errors[k] = worst(&back, &c) / scale;
            let grid = LatLongGrid::new(2 * side, side).unwrap();
            let map: LatLongMap<f64> = LatLongReconstruction::new(grid, 6, rule).unwrap().reconstruct([&c]);
            let [back] = LatLongProjection::new(grid, 6, rule).unwrap().project(&map);
            errors[2 + k] = worst(&back, &c) / scale;
        }
        // Second order in the texel's size.
        for (error, before) in errors.iter().zip(before) {
            assert!(*error < 0.3 * before && *error > 0.0, "side {side}: {error:e} after {before:e}");
        }
        before = errors;
    }
}

#[test]
fn channels_are_alone_and_nan_shows() {
    let grid = CubeGrid::new(6).unwrap();
    let colour = |i: usize| Vector3::new(positive(i) as f32, positive(i + 1000) as f32, -positive(i + 2000) as f32);
    let mut map = CubeMap::new(grid, (0..grid.len()).map(colour).collect()).unwrap();
    let plan = CubeProjection::new(grid, 4, TexelRule::Centre).unwrap();
    let rgb = plan.project(&map);
    for (c, plane) in rgb.iter().zip(map.planes()) {
        assert_eq!(plan.project(&plane)[0], *c);
    }
    assert_eq!(project_cube(&map, 4).unwrap(), rgb);
    for bad in [f32::NAN, f32::INFINITY] {
        for at in [0, 40, grid.len() - 1] {
            map.texels_mut()[at].y = bad;
            let [r, g, b] = plan.project(&map);
            assert!(g.iter().all(|c| !c.is_finite()) && (bad.is_infinite() || g.iter().all(|c| c.is_nan())));
            assert!(r == rgb[0] && b == rgb[2]);
            map.texels_mut()[at] = colour(at);
        }
    }
    let refs = rgb.each_ref().map(|c| &c[..]);
    let back: CubeMap<Vector3<f32>> = CubeReconstruction::new(grid, 4, TexelRule::Mean).unwrap().reconstruct(refs);
    for (plane, c) in back.planes().iter().zip(&rgb) {
        let alone: CubeMap<f32> = CubeReconstruction::new(grid, 4, TexelRule::Mean).unwrap().reconstruct([c]);
        assert_eq!(*plane, alone);
    }

    let grid = LatLongGrid::new(7, 5).unwrap();
    let mut pixels: Vec<_> = (0..grid.len()).map(colour).collect();
    let rgb = project_lat_long(&LatLongMap::new(grid, pixels.clone()).unwrap(), 4).unwrap();
    let green: Vec<f32> = pixels.iter().map(|p| p.y).collect();
    assert_eq!(project_lat_long(&LatLongMap::new(grid, green).unwrap(), 4).unwrap(), [rgb[1].clone()]);
    pixels[17].x = f32::NAN;
    let bad = project_lat_long(&LatLongMap::new(grid, pixels).unwrap(), 4).unwrap();
    assert!(bad[0].iter().all(|c| c.is_nan()) && bad[1] == rgb[1]);
}

#[test]
#[should_panic(expected = "cube map side: expected length 4, got 5")]
fn another_grid_panics() {
    let plan = CubeProjection::new(CubeGrid::new(4).unwrap(), 2, TexelRule::Centre).unwrap();
    plan.project(&CubeMap::from_fn(CubeGrid::new(5).unwrap(), |_| 1.0));
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn any_cube_map_and_its_one_texel(map in strategies::cube_map::<f64>(9), bands in 1..10usize, mean in any::<bool>()) {
        let rule = RULES[usize::from(mean)];
        let want = cube_twin(map.grid(), map.texels(), bands, rule);
        let [got] = CubeProjection::new(map.grid(), bands, rule).unwrap().project(&map);
        let scale: f64 = map.texels().iter().fold(1e-300, |s, t| s.max(t.abs()));
        prop_assert!(worst(&got, &want) <= 100.0 * f64::EPSILON * 14.0 * (bands as f64).sqrt() * scale);
        // Bessel: no more energy than the piecewise-constant function has.
        let energy = map.map(|t| t * t).integral();
        let kept: f64 = got.iter().map(|c| c * c).sum();
        prop_assert!(!mean || kept <= energy * (1.0 + 1e-12));
        // The first coefficient is the integral.
        prop_assert!((got[0] * (4.0 * PI).sqrt() - map.integral()).abs() <= 1e-12 * scale);
    }

    #[test]
    fn any_lat_long_map(map in strategies::lat_long_map::<f64>(12, 9), bands in 1..10usize, mean in any::<bool>()) {
        let rule = RULES[usize::from(mean)];
        let want = lat_long_twin(map.grid(), map.pixels(), bands, rule);
        let [got] = LatLongProjection::new(map.grid(), bands, rule).unwrap().project(&map);
        let scale: f64 = map.pixels().iter().fold(1e-300, |s, t| s.max(t.abs()));
        prop_assert!(worst(&got, &want) <= 100.0 * f64::EPSILON * 14.0 * (bands as f64).sqrt() * scale);
        let energy = map.map(|t| t * t).integral();
        let kept: f64 = got.iter().map(|c| c * c).sum();
        prop_assert!(!mean || kept <= energy * (1.0 + 1e-12));
    }
}

#[test]
fn windows_are_their_formulas() {
    let width = 3.0;
    let hanning: Vec<f64> = (0..5).map(|l| Window::Hanning { width }.factor(l)).collect();
    assert_below(worst(&hanning, &[1.0, 0.75, 0.25, 0.0, 0.0]), 1e-15, "Hanning");
    let lanczos: Vec<f64> = (0..5).map(|l| Window::Lanczos { width }.factor(l)).collect();
    let sinc = 0.75f64.sqrt() * 3.0 / PI;
    assert_below(worst(&lanczos, &[1.0, sinc, 0.5 * sinc, 0.0, 0.0]), 1e-15, "Lanczos");
    for l in 0..9 {
        let x = (l * (l + 1)) as f64;
        assert_below((Window::Gaussian { deviation: 0.3 }.factor(l) - (-0.045 * x).exp()).abs(), 1e-15, "Gaussian");
        assert_below(
            (Window::Curvature { lambda: 0.01 }.factor(l) - 1.0 / (1.0 + 0.01 * x * x)).abs(),
            1e-15,
            "curvature",
        );
        // Nothing to fade with: all but the mean goes, NaN included.
        for width in [0.0, -1.0, f64::NAN] {
            assert_eq!(Window::Hanning { width }.factor(l), f64::from(u8::from(l == 0)));
        }
    }
    let mut c: Vec<f32> = vec![2.0; 9];
    Window::Hanning { width }.apply(&mut c);
    assert_eq!(c, [2.0, 1.5, 1.5, 1.5, 0.5, 0.5, 0.5, 0.5, 0.5]);
    Window::Lanczos { width }.apply::<f32>(&mut []);
}

/// Blur of a blur: Gaussians are a semigroup, and near the pole they are normal distributions of that deviation.
#[test]
fn gaussian_window_is_a_blur_of_its_deviation() {
    let zonal: Vec<f64> = (0..100).map(|l| Window::Gaussian { deviation: 0.1 }.factor(l)).collect();
    let kernel = |theta: f64| -> f64 {
        zonal
            .iter()
            .enumerate()
            .map(|(l, w)| {
                let y = eval(100, &Vector3::new(theta.sin(), 0.0, theta.cos())).unwrap()[l * (l + 1)];
                w * y * ((2 * l + 1) as f64 / (4.0 * PI)).sqrt()
            })
            .sum()
    };
    let ratio = kernel(0.1) / kernel(0.0);
    assert_below((ratio - (-0.5f64).exp()).abs(), 2e-3, "one deviation from the centre");
}

#[test]
#[should_panic(expected = "a square")]
fn windows_refuse_partial_bands() {
    Window::Hanning { width: 2.0 }.apply(&mut [1.0; 5]);
}

/// A zonal bump about `axis` with its minimum planted there: −Σ_{m} y_lm(axis) y_lm, by the addition theorem.
fn planted(bands: usize, axis: &UnitVector3<f64>) -> Vec<f64> {
    eval(bands, axis).unwrap().into_iter().map(|y| -y).collect()
}

#[test]
fn planted_minima_are_found() {
    let mut axes = fibonacci_directions(7);
    axes.extend([Vector3::x_axis(), -Vector3::z_axis(), UnitVector3::new_normalize(Vector3::new(1.0, 1.0, 1.0))]);
    for bands in [1, 2, 3, 6, 12] {
        let extrema = Extrema::new(bands).unwrap();
        for axis in &axes {
            let c = planted(bands, axis);
            let least = extrema.minimum(&c).unwrap();
            let truth = -((bands * bands) as f64) / (4.0 * PI);
            assert_below((least.value - truth).abs() / truth.abs(), 2e-14, &format!("{bands} bands, value"));
            if bands > 1 {
                assert_below((least.direction.into_inner() - axis.into_inner()).norm(), 1e-7, "direction");
            }
            assert!(
                least.bound <= truth && least.bound >= truth * (1.0 + 2e-6) - 1e-12,
                "{bands}: {}",
                least.bound - truth
            );
            let greatest = extrema.maximum(&c.iter().map(|c| -c).collect::<Vec<_>>()).unwrap();
            assert_eq!(
                (greatest.value, greatest.bound, greatest.direction),
                (-least.value, -least.bound, least.direction)
            );
        }
    }
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn no_sample_is_below_the_bound(seed in 0..1_000_000usize, bands in 1..7usize, scale in prop_oneof![Just(1.0), Just(1e-200), Just(1e200)]) {
        let c: Vec<f64> = (0..bands * bands).map(|i| (noise(seed + 31 * i) - 0.5) * scale).collect();
        let extrema = Extrema::new(bands).unwrap();
        let (least, greatest) = (extrema.minimum(&c).unwrap(), extrema.maximum(&c).unwrap());
        let sampled = naive::sampled_minimum(&c, 4000);
        let range = greatest.value - least.value;
        let rounding = 1e-12 * scale * bands as f64;
        prop_assert!(least.value <= sampled + rounding, "{} {}", least.value, sampled);
        prop_assert!(least.bound <= least.value && least.value - least.bound <= 1e-6 * range + rounding);
        prop_assert!(greatest.bound >= greatest.value);
        prop_assert!((naive::reconstruct(&c, &least.direction) - least.value).abs() <= rounding);
    }

    fn deringed_expansions_touch_the_bound(
        seed in 0..1_000_000usize,
        bands in 2..7usize,
        level in -0.5..0.9f64,
        family in prop_oneof![Just(DeringWindow::Curvature), Just(DeringWindow::Gaussian)],
    ) {
        let c: Vec<f64> = (0..bands * bands).map(|i| if i == 0 { 3.5 } else { noise(seed + 31 * i) - 0.5 }).collect();
        let (extrema, plan) = (Extrema::new(bands).unwrap(), Deringing::new(bands).unwrap().with_window(family));
        let strength = strength(plan.window(&c, level).unwrap());
        let least = |strength: f64| {
            let mut c = c.clone();
            match family {
                DeringWindow::Curvature => Window::Curvature { lambda: strength }.apply(&mut c),
                DeringWindow::Gaussian => Window::Gaussian { deviation: strength.sqrt() }.apply(&mut c),
            }
            extrema.minimum(&c).unwrap().value
        };
        prop_assert!(least(strength) >= level - 1e-14);
        if strength > 0.0 {
            // The smallest: a little less is too little, and what is left over is of that size.
            prop_assert!(least(strength * (1.0 - 3e-6)) < level);
            prop_assert!(least(strength * 2.0) >= level);
        } else {
            prop_assert!(least(0.0) >= level);
        }
    }
}

/// λ or σ².
fn strength(window: Window) -> f64 {
    match window {
        Window::Curvature { lambda } => lambda,
        Window::Gaussian { deviation } => deviation * deviation,
        other => panic!("{other:?} is no window of deringing"),
    }
}

/// Over a bright cap on black the curvature window needs as much blur at 17 bands as at 5, the Gaussian ever less.
#[test]
fn the_flow_of_heat_blurs_less_with_more_bands() {
    let blur = |bands: usize, family: DeringWindow| {
        let mut lamp = vec![0.0; bands * bands];
        let cap = Zonal::<f64>::cap(bands, 0.5).unwrap();
        (0..bands).for_each(|l| lamp[index(l, 0)] = cap.coefficients()[l]);
        strength(Deringing::new(bands).unwrap().with_window(family).window(&lamp, 0.0).unwrap())
    };
    let [curved, curved_more] = [5, 17].map(|bands| blur(bands, DeringWindow::Curvature));
    let [heat, heat_more] = [5, 17].map(|bands| blur(bands, DeringWindow::Gaussian));
    assert!(curved_more > 0.9 * curved && heat_more < 0.5 * heat, "{curved} {curved_more}, {heat} {heat_more}");
}

/// Relative L² error of a light after each family of windows, all channels alike, by light and bands; the table of
/// docs/sh.md: `cargo test --all-features --test sh the_default_window -- --nocapture`.
#[test]
#[expect(clippy::print_stdout, reason = "the table of docs/sh.md")]
fn the_default_window_of_deringing_is_the_nearer_one() {
    // A square lamp: extrema along circles, which round ones have, cost hundreds of times more.
    let lamp = |half: f64, bright: f64, sky: f64, ground: f64| {
        move |d: &Vector3<f64>| {
            let shines = d.z > 0.0 && d.x.abs().max(d.y.abs()) < half * d.z;
            (if shines { bright } else { 0.0 }) + if d.y + 0.3 * d.z > 0.0 { sky } else { ground }
        }
    };
    type Shape = Box<dyn Fn(&Vector3<f64>) -> f64>;
    let lights: [(&str, Shape); 6] = [
        ("small lamp over black", Box::new(lamp(0.1, 100.0, 0.0, 0.0))),
        ("lamp over black", Box::new(lamp(0.3, 10.0, 0.0, 0.0))),
        ("lamp in a room of 1/20 of it", Box::new(lamp(0.3, 10.0, 0.5, 0.5))),
        ("lamp in a sky of 1/10 of it, ground black", Box::new(lamp(0.3, 10.0, 1.0, 0.0))),
        ("faint lamp in a sky, ground 1/20 of that", Box::new(lamp(0.5, 0.5, 1.0, 0.05))),
        ("soft sky", Box::new(|d| 0.25 * (1.0 + d.z).powi(2) + 0.02 + 0.01 * d.x * d.y)),
    ];
    let grid = CubeGrid::new(32).unwrap();
    let families = [DeringWindow::Curvature, DeringWindow::Gaussian];
    let mut sums = [0.0; 2];
    println!("| light | {} |", BANDS.map(|n| format!("{n} bands")).join(" | "));
    for (name, light) in &lights {
        let map = CubeMap::<f64>::from_fn(grid, |d| light(&d));
        let energy = |map: &CubeMap<f64>| map.map(|t| t * t).integral();
        let mut row = Vec::new();
        for bands in BANDS {
            let plain = CubeProjection::new(grid, bands, TexelRule::Mean).unwrap().project::<_, 1>(&map);
            let errors = families.map(|family| {
                let [mut c] = plain.clone();
                let plan = Deringing::new(bands).unwrap().with_window(family);
                plan.apply([&mut c], 0.0, DeringBy::AllChannels).unwrap();
                let seen: CubeMap<f64> =
                    CubeReconstruction::new(grid, bands, TexelRule::Mean).unwrap().reconstruct([&c]);
                (energy(&map.zip_map(&seen, |a, b| a - b)) / energy(&map)).sqrt()
            });
            row.push(format!("{:.3} / {:.3}", errors[0], errors[1]));
            sums.iter_mut().zip(errors).for_each(|(sum, e)| *sum += e);
            // Where the flow of heat is the farther one, it is by little.
            assert!(errors[1] < errors[0] + 0.012, "{name}, {bands} bands: {errors:?}");
        }
        println!("| {name} | {} |", row.join(" | "));
    }
    println!("mean: {:?}", sums.map(|sum| sum / (lights.len() * BANDS.len()) as f64));
    assert!(sums[1] < 0.97 * sums[0], "{sums:?}");
    assert_eq!(DeringWindow::default(), DeringWindow::Gaussian);
}

const BANDS: [usize; 6] = [2, 3, 4, 6, 9, 17];

/// Extrema along circles, where nearly all cells of a ring survive; constants; zero; sizes that overflow.
#[test]
fn degenerate_extrema() {
    let ring = |l: usize, bands: usize| -> Vec<f64> {
        (0..bands * bands).map(|i| if i == index(l, 0) { 1.0 } else { 0.0 }).collect()
    };
    // y₂₀ is least on the equator: −√(5/16π).
    let least = Extrema::new(3).unwrap().minimum(&ring(2, 3)).unwrap();
    assert_below((least.value + (5.0 / (16.0 * PI)).sqrt()).abs(), 1e-15, "equator");
    assert!(least.direction.z.abs() < 1e-7 && least.bound < least.value && least.bound > least.value - 1e-5);
    let least = Extrema::new(12).unwrap().minimum(&ring(11, 12)).unwrap();
    // P₁₁ is least at the south pole, −1.
    assert_below((least.value + (23.0 / (4.0 * PI)).sqrt()).abs(), 1e-13, "pole");
    for c in [0.0, 1.0, -2.0] {
        let mut constant = vec![0.0; 16];
        constant[0] = c;
        let least = Extrema::new(4).unwrap().minimum(&constant).unwrap();
        let value = c / (4.0 * PI).sqrt();
        assert!((least.value - value).abs() < 1e-15 && least.bound <= least.value && least.bound > value - 1e-12);
        assert_eq!(strength(Deringing::new(4).unwrap().window(&constant, value - 1e-9).unwrap()), 0.0);
    }
    let huge = Extrema::new(3).unwrap().minimum(&[1e308f64; 9]);
    assert!(matches!(huge, Err(Error::NotFinite { .. })) || huge.unwrap().value.is_finite());
    for bad in [f64::NAN, f64::INFINITY] {
        let result = Extrema::new(2).unwrap().minimum(&[1.0, bad, 0.0, 0.0]);
        assert_eq!(result.unwrap_err(), Error::NotFinite { what: "coefficient", index: 1 });
        assert!(Deringing::new(2).unwrap().window(&[1.0, bad, 0.0, 0.0], 0.0).is_err());
    }
}

#[test]
fn deringing_by_channels() {
    let plan = Deringing::new(5).unwrap().with_window(DeringWindow::Curvature);
    let lamp = |d: [f64; 3], mean: f64| -> Vec<f64> {
        let mut c = eval(5, &UnitVector3::new_normalize(Vector3::from(d))).unwrap();
        c[0] += mean;
        c
    };
    let make = || [lamp([1.0, 0.2, 0.3], 0.0), lamp([-0.3, 0.9, 0.1], 0.4), lamp([0.0, 0.1, -1.0], 9.0)];
    let windows = make().map(|c| plan.window(&c, 0.0).unwrap());
    let alone = windows.map(strength);
    assert!(alone[0] > alone[1] && alone[1] > 0.0 && alone[2] == 0.0);
    let [mut r, mut g, mut b] = make();
    assert_eq!(plan.apply([&mut r, &mut g, &mut b], 0.0, DeringBy::EachChannel).unwrap(), windows);
    assert_eq!(b, make()[2]);
    let [mut r, mut g, mut b] = make();
    let shared = plan.apply([&mut r, &mut g, &mut b], 0.0, DeringBy::AllChannels).unwrap();
    assert_eq!(shared, [windows[0]; 3]);
    for (c, before) in [&r, &g, &b].into_iter().zip(make()) {
        assert!(Extrema::new(5).unwrap().minimum(c).unwrap().value >= 0.0);
        let ratio = c[index(4, 0)] / before[index(4, 0)];
        assert_below((ratio - 1.0 / (1.0 + 400.0 * alone[0])).abs(), 1e-15, "window");
    }
    let [mut r, mut g, mut b] = make();
    let weights = [0.7, 0.3, 0.0];
    plan.apply([&mut r, &mut g, &mut b], 0.0, DeringBy::Luminance(weights)).unwrap();
    let sum: Vec<f64> = (0..25).map(|i| weights[0] * r[i] + weights[1] * g[i] + weights[2] * b[i]).collect();
    let least = Extrema::new(5).unwrap().minimum(&sum).unwrap().value;
    assert!((-1e-15..1e-5).contains(&least), "{least:e}");
    // No window lifts the mean; the channels stay as they were.
    let (mut r, before) = (make()[0].clone(), make()[0].clone());
    let error = plan.apply([&mut r], 10.0, DeringBy::EachChannel).unwrap_err();
    assert!(matches!(error, Error::OutOfRange { what: "bound of deringing", .. }) && r == before);
}

#[test]
fn fits_against_singular_values() {
    // Clustered directions and uneven weights.
    let mut directions = fibonacci_directions(60);
    directions.extend((0..40).map(|i| UnitVector3::new_normalize(Vector3::new(positive(i), positive(i + 99), 2.0))));
    let weights: Vec<f64> = (0..100).map(|i| if i % 7 == 0 { 0.0 } else { positive(i + 5) }).collect();
    let values: Vec<f64> = (0..100).map(|i| positive(3 * i) - 0.5).collect();
    for (bands, lambda) in [(1, 0.0), (3, 0.0), (6, 0.0), (6, 1e-3), (11, 1e-4)] {
        let samples: Vec<_> = (0..100).map(|i| (directions[i], weights[i], values[i])).collect();
        let want = naive::least_squares(bands, &samples, lambda);
        let fit = ScatteredFit::new(bands, &directions, Some(&weights), lambda).unwrap();
        let [got, twice] = fit.fit([&values, &values.iter().map(|v| 2.0 * v).collect::<Vec<_>>()]);
        assert_below(worst(&got, &want), 1e-14 * fit.condition(), &format!("{bands} bands, λ {lambda}"));
        assert_eq!(twice, got.iter().map(|c| 2.0 * c).collect::<Vec<_>>());
        let [single] = fit.fit([&narrow::<f32>(&values)]);
        assert_below(worst(&single, &want), 1e-6 * fit.condition(), "f32");
        let sum: f64 = weights.iter().sum();
        let residual = samples.iter().map(|(d, w, f)| w * (f - naive::reconstruct(&want, d)).powi(2)).sum::<f64>();
        assert_below((fit.residual(&values, &got) - (residual / sum).sqrt()).abs(), 1e-12, "residual");
    }
}

/// With a quadrature rule's weights a fit is projection, and its penalty the curvature window.
#[test]
fn a_fit_to_a_quadrature_is_a_window() {
    let rule = SphereQuadrature::new(14).unwrap();
    let c = coefficients(8);
    let values: Vec<f64> = rule.directions().iter().map(|d| naive::reconstruct(&c, d)).collect();
    for lambda in [0.0, 1e-3, 1.0] {
        let fit = ScatteredFit::new(8, rule.directions(), Some(rule.weights()), lambda).unwrap();
        let [got] = fit.fit([&values]);
        let mut want = c.clone();
        Window::Curvature { lambda }.apply(&mut want);
        assert_below(worst(&got, &want), 2e-14, &format!("λ {lambda}"));
        // Singular values √(1 + λ l²(l+1)²), all 1 without penalty.
        let condition = (1.0 + lambda * 56f64.powi(2)).sqrt();
        assert_below((fit.condition() / condition - 1.0).abs(), 0.1, "condition");
    }
}

#[test]
fn fits_that_cannot_be() {
    let few = fibonacci_directions(8);
    let rank = ScatteredFit::new(3, &few, None, 0.0).unwrap_err();
    assert!(matches!(rank, Error::OutOfRange { what: "condition number of the fit", .. }), "{rank}");
    // 40 directions on the equator cannot tell z from 0; the penalty decides.
    let ring: Vec<_> =
        (0..40).map(|i| UnitVector3::new_normalize(Vector3::new((i as f64).cos(), (i as f64).sin(), 0.0))).collect();
    assert!(ScatteredFit::new(2, &ring, None, 0.0).is_err());
    let fit = ScatteredFit::new(2, &ring, None, 1e-3).unwrap();
    let [c] = fit.fit([&vec![1.0; 40]]);
    assert_below(worst(&c, &[(4.0 * PI).sqrt(), 0.0, 0.0, 0.0]), 1e-10, "a ring of ones");
    // A single sample and a penalty: the constant through it.
    let [c] = ScatteredFit::new(4, &few[..1], None, 1.0).unwrap().fit([&[2.0f64]]);
    assert_below((c[0] / (4.0 * PI).sqrt() - 2.0).abs(), 1e-10, "one sample");
    assert_eq!(
        ScatteredFit::new(2, &[], None, 1.0).unwrap_err(),
        Error::Empty { what: "set of samples with positive weight" }
    );
    assert!(ScatteredFit::new(2, &few, Some(&[1.0; 7]), 1.0).is_err());
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(ScatteredFit::new(2, &few, Some(&[bad; 8]), 1.0).is_err());
        assert!(ScatteredFit::new(2, &few, None, bad).is_err());
    }
    let nan = UnitVector3::new_unchecked(Vector3::new(f64::NAN, 0.0, 1.0));
    assert_eq!(
        ScatteredFit::new(1, &[few[0], nan], None, 0.0).unwrap_err(),
        Error::NotFinite { what: "direction", index: 1 }
    );
    let [c] = ScatteredFit::new(2, &few, None, 0.0).unwrap().fit([&[1.0, f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]]);
    assert!(c.iter().all(|c: &f64| c.is_nan()));
}

/// Over 36 coefficients and 20 seeds the errors in units of the stated ones follow Student's t of 15 degrees of
/// freedom, whose variance is 15/13; they are dependent, so a factor 1.3 either way is allowed (an error that is stated
/// twice too large or small fails).
#[test]
fn monte_carlo_states_its_error() {
    // A cap off every axis, with an edge, and a smooth channel; truth by the addition theorem.
    let axis = UnitVector3::new_normalize(Vector3::new(0.3, -0.5, 0.7));
    let cap = project_fn::<f64>(6, &SphereQuadrature::new(1000).unwrap(), |d| f64::from(u8::from(d.z > 0.5))).unwrap();
    let y = eval(6, &axis).unwrap();
    // Of the cap about z: c_l0 = 2π K_l0 ∫_{1/2}^1 P_l.
    let legendre = |l: usize, x: f64| -> f64 {
        let (mut p, mut q) = (1.0, x);
        for n in 1..=l {
            (p, q) = (q, ((2 * n + 1) as f64 * x * q - n as f64 * p) / (n + 1) as f64);
        }
        p
    };
    let truth: Vec<f64> = (0..36)
        .map(|i| {
            let l = degree_order(i).0;
            let integral =
                if l == 0 { 0.5 } else { (legendre(l - 1, 0.5) - legendre(l + 1, 0.5)) / (2 * l + 1) as f64 };
            2.0 * PI * integral * y[i]
        })
        .collect();
    assert_below((cap[0] - truth[0]).abs(), 1e-2, "the cap's area");
    let (mut squares, mut count, mut outside) = (0.0, 0.0, 0.0);
    for seed in 0..20 {
        let estimate = monte_carlo(6, 1600, seed, |d| [f64::from(u8::from(d.dot(&axis) > 0.5))]).unwrap();
        assert_eq!(estimate.samples, 1600);
        for ((c, e), t) in estimate.coefficients[0].iter().zip(&estimate.errors[0]).zip(&truth) {
            squares += ((c - t) / e).powi(2);
            outside += f64::from(u8::from((c - t).abs() > 2.131 * e));
            count += 1.0;
        }
        let typical = (estimate.errors[0].iter().map(|e| e * e).sum::<f64>() / 36.0).sqrt();
        // Random directions: √(4π ∫ f² y²)/√n is about √π/40 = 0.044.
        assert!((0.008..0.012).contains(&typical));
    }
    let many = monte_carlo(6, 25600, 1, |d| [f64::from(u8::from(d.dot(&axis) > 0.5))]).unwrap();
    let typical = (many.errors[0].iter().map(|e| e * e).sum::<f64>() / 36.0).sqrt();
    // 16^{3/4} = 8 times less than 0.01, where random directions gain 4.
    assert!((0.8e-3..1.8e-3).contains(&typical));
    let spread: f64 = squares / count / (15.0 / 13.0);
    assert!((0.7..1.4).contains(&spread), "variance over that of Student's t: {spread}");
    assert!((0.02..0.09).contains(&(outside / count)), "outside the 95 % interval: {}", outside / count);
}

#[test]
fn monte_carlo_edges() {
    let f = |d: &UnitVector3<f64>| [d.x, 1.0];
    let a = monte_carlo(3, 100, 1, f).unwrap();
    assert_eq!((a.samples, &a), (112, &monte_carlo(3, 100, 1, f).unwrap()));
    assert_ne!(a.coefficients, monte_carlo(3, 100, 2, f).unwrap().coefficients);
    assert_below((a.coefficients[1][0] - (4.0 * PI).sqrt()).abs() + a.errors[1][0], 1e-14, "constant");
    assert_eq!(monte_carlo(1, 1, 0, f).unwrap().samples, 16);
    assert!(monte_carlo(0, 100, 1, f).is_err() && monte_carlo(2, 0, 1, f).is_err());
    let nan = monte_carlo(2, 64, 1, |_| [f64::NAN]).unwrap();
    assert!(nan.coefficients[0].iter().chain(&nan.errors[0]).all(|c| c.is_nan()));
}
