//! Environment lights: energy at every resolution, rotation, the sun, and what is refused.
#![cfg(all(feature = "scene", feature = "reference", feature = "proptest"))]

use std::f64::consts::{FRAC_PI_2, PI};

use haarmonic::nalgebra::{Rotation3, Unit, UnitVector3, Vector3};
use haarmonic::scene::{EnvironmentLight, Sky, SoftBox, Sun};
use haarmonic::sphere::{CubeGrid, CubeMap, LatLongGrid, LatLongMap, fibonacci_directions};
use haarmonic::{Error, reference::sphere as naive, strategies};
use proptest::prelude::*;

fn config() -> ProptestConfig {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(32);
    ProptestConfig::with_cases(cases)
}

fn cube(side: usize) -> CubeGrid {
    CubeGrid::new(side).unwrap()
}

/// A sky of one colour everywhere.
fn plain(colour: f64) -> Sky {
    let colour = Vector3::repeat(colour);
    Sky { zenith: colour, horizon: colour, ground: colour, sun: None, boxes: Vec::new(), ..Sky::default() }
}

fn sun(direction: UnitVector3<f64>, angular_radius: f64) -> Sun {
    Sun { direction, angular_radius, radiance: Vector3::new(1e4, 5e3, 1e3) }
}

fn disc(radius: f64) -> f64 {
    2.0 * PI * (1.0 - radius.cos())
}

#[test]
fn the_sun_lights_the_texels_it_covers() {
    // Discs that hold many texels, a few, and much less than one, against dense sampling of the disc's definition.
    for (radius, side) in [(0.9, 3), (0.3, 5), (0.05, 2), (FRAC_PI_2, 4)] {
        let direction = Unit::new_normalize(Vector3::new(0.8, 0.75, -0.3));
        let light = EnvironmentLight::from_sky(plain(0.0).with_sun(Some(sun(direction, radius)))).unwrap();
        let map = light.to_cube(cube(side));
        let samples = 250;
        let coverage = |d: &Vector3<f64>| if d.angle(&direction) <= radius { 1.0 } else { 0.0 };
        for (i, texel) in map.texels().iter().enumerate() {
            let expected = naive::cube_texel_mean(side, i, samples, coverage);
            let got = f64::from(texel.x) / 1e4;
            // Dense sampling miscounts along the rim by 1/samples of a texel's width or so.
            assert!((got - expected).abs() < 2e-3, "{radius}, texel {i}: {got} against {expected}");
        }
    }
}

#[test]
fn the_default_skies_shine_from_where_they_say() {
    for sky in [Sky::default(), Sky::studio(), Sky::sunset()] {
        let light = EnvironmentLight::from_sky(sky.clone()).unwrap();
        assert_eq!(light.radiance(&Vector3::y()), sky.zenith);
        assert!((light.radiance(&-Vector3::y()) - sky.ground).norm() < 1e-12);
        if let Some(sun) = sky.sun {
            assert!(light.radiance(&sun.direction).x > sun.radiance.x);
            let beside = Rotation3::from_axis_angle(&Vector3::y_axis(), 3.0 * sun.angular_radius) * *sun.direction;
            assert!(light.radiance(&beside).x < 0.1 * sun.radiance.x);
        }
        for lamp in &sky.boxes {
            assert!(light.radiance(&lamp.direction).x >= lamp.radiance.x);
            assert!(light.radiance(&-*lamp.direction).x < 0.5 * lamp.radiance.x);
        }
        assert!(light.to_cube(cube(8)).first_not_finite().is_none());
    }
}

#[test]
fn a_soft_box_is_as_wide_and_as_high_as_it_says() {
    // Towards −z: width along x, height along y, tangents of the angles.
    let lamp = SoftBox {
        direction: -Vector3::z_axis(),
        half_size: [0.5, 0.25],
        softness: 0.0,
        radiance: Vector3::new(3.0, 2.0, 1.0),
    };
    let light = EnvironmentLight::from_sky(plain(0.0).with_box(lamp)).unwrap();
    for (x, y, inside) in [(0.49, 0.24, true), (0.51, 0.0, false), (0.0, 0.26, false), (-0.49, -0.24, true)] {
        let radiance = light.radiance(&(2.0 * Vector3::new(x, y, -1.0)));
        assert_eq!(radiance, if inside { lamp.radiance } else { Vector3::zeros() }, "({x}, {y})");
    }
    // Its energy is its solid angle, closed form 4 atan(wh/√(1 + w² + h²)); the edge falls between samples.
    let omega = 4.0 * (0.5 * 0.25 / (1.0f64 + 0.25 + 0.0625).sqrt()).atan();
    for side in [1, 16, 256] {
        let energy = light.to_cube(cube(side)).integral() / omega;
        assert!((energy - lamp.radiance).norm() < 1e-3, "{side}: {energy:?}");
    }
    // A soft edge is half as bright on the border.
    let soft = EnvironmentLight::from_sky(plain(0.0).with_box(SoftBox { softness: 0.5, ..lamp })).unwrap();
    assert!((soft.radiance(&Vector3::new(0.5, 0.0, -1.0)).x - 1.5).abs() < 1e-12);
    // Overhead there is no level edge; the box is still there.
    let overhead = SoftBox { direction: Vector3::y_axis(), ..lamp };
    let light = EnvironmentLight::from_sky(plain(0.0).with_box(overhead)).unwrap();
    assert_eq!(light.radiance(&Vector3::new(0.4, 1.0, 0.2)), lamp.radiance);
}

#[test]
fn the_sky_is_the_mean_of_its_radiance() {
    let sky = Sky { sun: None, ..Sky::studio() };
    let light = EnvironmentLight::from_sky(sky.clone()).unwrap();
    let map = light.to_cube(cube(2));
    for (i, texel) in map.texels().iter().enumerate() {
        let expected = naive::cube_texel_mean(2, i, 300, |d| sky.radiance(d).y);
        // Of the brightest lamp, 12.
        assert!((f64::from(texel.y) - expected).abs() < 2e-5 * 12.0, "texel {i}: {} {expected}", texel.y);
    }
}

#[test]
fn skies_have_the_same_energy_at_every_resolution() {
    for sky in [Sky::default(), Sky::studio(), Sky::sunset()] {
        let light = EnvironmentLight::from_sky(sky).unwrap();
        let energy = |side| light.to_cube(cube(side)).integral();
        let fine = energy(256);
        for side in [1, 2, 3, 16, 64] {
            let error = (energy(side) - fine).component_div(&fine).abs().max();
            // Midpoint sums over 256² points a face, the horizon three points wide: 5e-5 measured.
            assert!(error < 1e-4, "{side}: {error}");
        }
    }
}

#[test]
fn negative_pixels_are_clamped_and_counted() {
    let grid = LatLongGrid::new(4, 2).unwrap();
    let mut pixels = vec![Vector3::repeat(1.0f32); 8];
    pixels[2] = Vector3::new(-0.5, 2.0, -0.25);
    pixels[7] = Vector3::new(0.0, -0.0, -1e-30);
    let light = EnvironmentLight::from_lat_long(LatLongMap::new(grid, pixels.clone()).unwrap()).unwrap();
    assert_eq!(light.clamped_pixels(), 2);
    let got = light.radiance(&grid.direction(2));
    assert!((got - Vector3::new(0.0, 2.0, 0.0)).norm() < 1e-14, "{got:?}");

    let mut texels = vec![Vector3::repeat(1.0f32); 6];
    texels[3].z = -1.0;
    let light = EnvironmentLight::from_cube(CubeMap::new(cube(1), texels).unwrap()).unwrap();
    assert_eq!((light.clamped_pixels(), light.to_cube(cube(1)).texels()[3].z), (1, 0.0));
    assert_eq!(EnvironmentLight::from_sky(Sky::default()).unwrap().clamped_pixels(), 0);
}

#[test]
fn light_that_is_not_finite_is_refused() {
    let grid = LatLongGrid::new(2, 1).unwrap();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let pixels = vec![Vector3::zeros(), Vector3::new(0.0, bad, 0.0)];
        let light = EnvironmentLight::from_lat_long(LatLongMap::new(grid, pixels).unwrap());
        assert!(matches!(light, Err(Error::NotFinite { index: 1, .. })));
        let mut texels = vec![Vector3::zeros(); 6];
        texels[5].x = bad;
        let light = EnvironmentLight::from_cube(CubeMap::new(cube(1), texels).unwrap());
        assert!(matches!(light, Err(Error::NotFinite { index: 5, .. })));
    }
}

#[test]
fn impossible_skies_are_refused() {
    let refused = |change: fn(&mut Sky)| {
        let mut sky = Sky::studio().with_sun(Some(sun(Vector3::y_axis(), 0.1)));
        assert!(EnvironmentLight::from_sky(sky.clone()).is_ok());
        change(&mut sky);
        EnvironmentLight::from_sky(sky).is_err()
    };
    assert!(refused(|s| s.zenith.x = -0.1));
    assert!(refused(|s| s.ground.z = f64::NAN));
    assert!(refused(|s| s.horizon.y = f64::INFINITY));
    assert!(refused(|s| s.falloff = 0.0));
    assert!(refused(|s| s.horizon_softness = 1.5));
    assert!(refused(|s| s.boxes[0].half_size[1] = 0.0));
    assert!(refused(|s| s.boxes[1].softness = f64::NAN));
    assert!(refused(|s| s.boxes[2].radiance.x = -1.0));
    assert!(refused(|s| s.boxes[0].direction = Unit::new_unchecked(Vector3::zeros())));
    for radius in [0.0, -0.1, 1.6, f64::NAN] {
        let sky = plain(1.0).with_sun(Some(sun(Vector3::y_axis(), radius)));
        assert!(EnvironmentLight::from_sky(sky).is_err(), "{radius}");
    }
    let unit_less = Unit::new_unchecked(Vector3::new(2.0, 0.0, 0.0));
    assert!(EnvironmentLight::from_sky(plain(1.0).with_sun(Some(sun(unit_less, 0.1)))).is_err());
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn the_sun_keeps_its_energy(
        direction in strategies::direction(), log_radius in -7.0..0.4f64, side in 1..20usize, turn in strategies::rotation(),
    ) {
        let radius = log_radius.exp().min(FRAC_PI_2);
        let sun = sun(direction, radius);
        let light = EnvironmentLight::from_sky(plain(0.0).with_sun(Some(sun))).unwrap().with_rotation(turn);
        let map = light.to_cube(cube(side));
        let expected = sun.radiance * disc(radius);
        // Texels round to f32; 1 − cos r in the test loses digits for small r.
        let bound = 1e-7 + 4e-16 / (radius * radius);
        prop_assert!((map.integral() - expected).norm() < bound * expected.norm(), "{:?} {:?}", map.integral(), expected);
        prop_assert!(map.texels().iter().all(|t| t.iter().all(|&c| c >= 0.0)));
        prop_assert_eq!(light.radiance(&(turn * *direction)), sun.radiance);
        // A lit texel is no farther from the sun's centre than a texel's corner from its middle.
        let directions = map.grid().directions();
        let lit = map.texels().iter().zip(&directions).filter(|(t, _)| t.x > 0.0);
        let nearest = lit.map(|(_, d)| d.dot(&(turn * *direction))).fold(-1.0, f64::max);
        prop_assert!(nearest.acos() <= 1.5 / side as f64, "{}", nearest.acos());
    }

    #[test]
    fn turning_a_light_turns_its_radiance(turn in strategies::rotation(), d in strategies::direction()) {
        let map = LatLongMap::from_fn(LatLongGrid::new(8, 5).unwrap(), |d| d.map(|c| 1.0 + c as f32));
        let lights = [
            EnvironmentLight::from_lat_long(map.clone()).unwrap(),
            EnvironmentLight::from_cube(CubeMap::from_fn(cube(3), |d| d.map(|c| 1.0 + c as f32))).unwrap(),
            EnvironmentLight::from_sky(Sky { sun: None, horizon_softness: 0.5, ..Sky::studio() }).unwrap(),
        ];
        for light in lights {
            let expected = light.radiance(&d);
            let turned = light.with_rotation(turn);
            // One rounding of the direction; slopes of these lights stay below a hundred a radian.
            prop_assert!((turned.radiance(&(turn * *d)) - expected).norm() < 1e-12);
            let mut again = turned.clone();
            again.set_rotation(Rotation3::identity());
            prop_assert_eq!(again.radiance(&d), expected);
        }
    }

    #[test]
    fn maps_keep_their_energy_at_every_resolution(side in 1..40usize, turn in strategies::rotation()) {
        let values: Vec<Vector3<f32>> = fibonacci_directions(24 * 12)
            .iter()
            .map(|d| Vector3::new((9.0 * d.x).exp() as f32, 1.0, (d.y > 0.95) as u8 as f32))
            .collect();
        let map = LatLongMap::new(LatLongGrid::new(24, 12).unwrap(), values).unwrap();
        let expected = map.integral();
        let light = EnvironmentLight::from_lat_long(map).unwrap().with_rotation(turn);
        let got = light.to_cube(cube(side)).integral();
        // Six texels round to 6e-8 each.
        prop_assert!((got - expected).component_div(&expected).abs().max() < 1e-7, "{got:?} {expected:?}");
    }
}
