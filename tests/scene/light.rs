//! Environment lights: energy at every resolution, rotation, the sun, and what is refused.

use std::f64::consts::{FRAC_PI_2, PI};

use haarmonic::nalgebra::{Rotation3, Unit, UnitVector3, Vector3};
use haarmonic::scene::{EnvironmentLight, Sky, SoftBox, Sun};
use haarmonic::sphere::{CubeGrid, CubeMap, LatLongGrid, LatLongMap, fibonacci_directions};
use haarmonic::{Error, reference::sphere as naive, strategies};
use proptest::prelude::*;

use crate::support::cases;

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

/// 2π(1 − cos r) without cancellation.
fn small_disc(radius: f64) -> f64 {
    4.0 * PI * (0.5 * radius).sin().powi(2)
}

/// Texel centres, corners of texels, of faces and of the cube, edges of faces, poles, and near misses of each.
fn awkward_directions(side: usize) -> Vec<UnitVector3<f64>> {
    let line = |i: usize| 2.0 * i as f64 / side as f64 - 1.0;
    let mut points = vec![Vector3::new(1.0, 1.0, 1.0), Vector3::new(-1.0, 1.0, -1.0), Vector3::new(0.0, -1.0, 1.0)];
    points.extend([Vector3::x(), -Vector3::y(), Vector3::y(), -Vector3::z(), Vector3::new(0.3, 1.0, 1.0)]);
    for i in [1, side / 2] {
        points.push(Vector3::new(line(i), 1.0, line(side - i)));
        points.push(Vector3::new(-1.0, line(i), line(i)));
        points.push(Vector3::new(line(i) + 1.0 / side as f64, line(i) + 1.0 / side as f64, -1.0));
        points.push(Vector3::new(line(i) + 1e-15, line(i) - 1e-9, 1.0));
    }
    points.into_iter().map(Unit::new_normalize).collect()
}

#[test]
fn a_sun_of_any_radius_keeps_its_energy_in_every_direction() {
    let radii = [1e-300, 1e-160, 1e-30, 1e-16, 1e-15, 1e-13, 1e-10, 1e-8, 9.9e-7, 1e-6, 1e-3, 1.0, FRAC_PI_2];
    for radius in radii {
        for side in [1, 4, 7] {
            for direction in awkward_directions(side) {
                // As bright as texels of f32 can hold, so that the energy of the smallest ones is not below its range
                // too.
                let energy = 1e3;
                let radiance = (energy / small_disc(radius)).min(1e300);
                let sun =
                    Sun { direction, angular_radius: radius, radiance: Vector3::new(radiance, 0.5 * radiance, 0.0) };
                let light = EnvironmentLight::from_sky(plain(0.0).with_sun(Some(sun))).unwrap();
                let map = light.to_cube(cube(side));
                let expected =
                    if radius < 1e-140 { radiance * PI.sqrt() * radius * (PI.sqrt() * radius) } else { energy };
                // A texel rounds to half of f32's epsilon, or to its smallest number.
                let bound = 1e-7 * expected + 1e-44;
                let got = map.integral();
                assert!((got.x - expected).abs() <= bound, "{radius:e} {side} {direction:?}: {:e} {expected:e}", got.x);
                assert!((got.y - 0.5 * expected).abs() <= bound && got.z == 0.0);
            }
        }
    }
}

#[test]
fn a_small_sun_at_a_corner_is_shared_by_its_texels() {
    // Four texels meet in the middle of a face of even side, three at a corner of the cube; each gets its angle there.
    for radius in [1e-12, 1e-9, 5e-7, 2e-6, 1e-3] {
        for (direction, shares) in [(Vector3::z(), [0.25; 4].as_slice()), (Vector3::repeat(1.0), &[1.0 / 3.0; 3])] {
            let direction = Unit::new_normalize(direction);
            let sun = Sun { direction, angular_radius: radius, radiance: Vector3::repeat(1.0 / small_disc(radius)) };
            let map = EnvironmentLight::from_sky(plain(0.0).with_sun(Some(sun))).unwrap().to_cube(cube(2));
            let omega = map.grid().solid_angle(0, 0);
            let lit: Vec<f64> = map.texels().iter().map(|t| f64::from(t.x) * omega).filter(|&t| t > 0.0).collect();
            assert_eq!(lit.len(), shares.len(), "{radius:e}: {lit:?}");
            // The rounding of the direction, 1e-16, against the radius; quartered discs are cut to 1/64 of it.
            let bound = 2e-16 / radius + if radius >= 1e-6 { 2e-4 } else { 1e-6 };
            assert!(lit.iter().zip(shares).all(|(got, share)| (got - share).abs() < bound), "{radius:e}: {lit:?}");
        }
    }
}

#[test]
fn a_sun_of_given_irradiance_has_it_at_any_radius() {
    for radius in [1e-150, 1e-15, 1e-6, 0.00465, 0.3, FRAC_PI_2] {
        let sun = Sun::with_irradiance(Vector3::y_axis(), Vector3::new(3.0, 2.0, 0.0), radius).unwrap();
        let back = sun.radiance * radius.sin() * radius.sin() * PI;
        assert!((back - Vector3::new(3.0, 2.0, 0.0)).norm() < 1e-14, "{radius}: {back:?}");
        if radius <= 1e-6 {
            let map = EnvironmentLight::from_sky(plain(0.0).with_sun(Some(sun))).unwrap().to_cube(cube(5));
            assert!((map.integral().x - 3.0).abs() < 3e-7);
        }
    }
    let make = |e: f64, r: f64| Sun::with_irradiance(Vector3::y_axis(), Vector3::repeat(e), r);
    for radius in [0.0, -1e-9, 1.6, f64::INFINITY, f64::NAN, 5e-324, 1e-160] {
        assert!(make(1.0, radius).is_err(), "{radius}");
    }
    for irradiance in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(make(irradiance, 0.1).is_err());
    }
    assert_eq!(make(0.0, 1e-300).unwrap().radiance, Vector3::zeros());
}

#[test]
fn a_lamp_of_any_size_keeps_its_energy() {
    let radiance = Vector3::new(1e3, 10.0, 0.0);
    for [w, h] in [[1e-200, 1e-200], [1e-9, 1e-9], [1e-4, 1e-4], [1e-3, 3e-3], [0.02, 0.01], [1e-6, 0.7], [100.0, 1e-3]]
    {
        for softness in [0.0, 0.01, 0.5, 1.0] {
            for (side, direction) in [(1, Vector3::x()), (3, Vector3::new(0.1, 0.7, -0.7)), (64, Vector3::repeat(1.0))]
            {
                let lamp = SoftBox { direction: Unit::new_normalize(direction), half_size: [w, h], softness, radiance };
                let light = EnvironmentLight::from_sky(plain(0.0).with_box(lamp)).unwrap();
                let got = light.to_cube(cube(side)).integral().x / radiance.x;
                // A soft edge is a sharp one on average; on a narrow box the measure is that of the other axis.
                let sharp = 4.0 * (w * h).atan2((1.0 + w * w + h * h).sqrt());
                let wide = w.max(h) > 0.1;
                let expected =
                    if wide && softness > 0.0 { profile(w.max(h), softness) * 2.0 * w.min(h) } else { sharp };
                let close = (got - expected).abs() <= 1e-3 * expected + 1e-46;
                assert!(close, "{w} {h} {softness} {side}: {got:e} {expected:e}");
            }
        }
    }
}

/// ∫ coverage(a) da/(1 + a²)^{3/2} along one axis of a lamp.
fn profile(half: f64, softness: f64) -> f64 {
    let lamp =
        SoftBox { direction: -Vector3::z_axis(), half_size: [half, 1.0], softness, radiance: Vector3::repeat(1.0) };
    let sky = plain(0.0).with_box(lamp);
    let n = 200_000;
    // a = tan θ: da/(1 + a²)^{3/2} = cos θ dθ.
    let step = PI / n as f64;
    let angles = (0..n).map(|k| -FRAC_PI_2 + (k as f64 + 0.5) * step);
    angles.map(|t| sky.radiance(&Vector3::new(t.sin(), 0.0, -t.cos())).x * t.cos() * step).sum()
}

#[test]
fn a_light_turned_by_what_is_no_rotation_is_nan_at_once() {
    let nan = Rotation3::from_matrix_unchecked(haarmonic::nalgebra::Matrix3::repeat(f64::NAN));
    let mut one = haarmonic::nalgebra::Matrix3::identity();
    one[(1, 2)] = f64::INFINITY;
    let zero = Rotation3::from_matrix_unchecked(haarmonic::nalgebra::Matrix3::zeros());
    let scaled = Rotation3::from_matrix_unchecked(haarmonic::nalgebra::Matrix3::identity() * 2.0);
    let image = LatLongMap::from_fn(LatLongGrid::new(8, 4).unwrap(), |_| Vector3::repeat(1.0f32));
    let boxed = CubeMap::from_fn(cube(4), |_| Vector3::repeat(1.0f32));
    for turn in [nan, Rotation3::from_matrix_unchecked(one), zero, scaled] {
        for light in [
            EnvironmentLight::from_sky(Sky::studio().with_sun(Some(sun(Vector3::x_axis(), 0.1)))).unwrap(),
            EnvironmentLight::from_lat_long(image.clone()).unwrap(),
            EnvironmentLight::from_cube(boxed.clone()).unwrap(),
        ] {
            let light = light.with_rotation(turn);
            assert!(light.to_cube(cube(8)).texels().iter().all(|t| t.iter().all(|c| c.is_nan())));
            assert!(light.radiance(&Vector3::x()).iter().all(|c| c.is_nan()));
        }
    }
}

#[test]
fn radiance_takes_directions_of_any_length() {
    let sky = Sky::studio().with_sun(Some(sun(Unit::new_normalize(Vector3::new(0.3, 0.8, -0.2)), 0.1)));
    for d in [Vector3::new(0.3, 0.8, -0.2), Vector3::new(-0.5, -0.1, 0.3), Vector3::x(), -Vector3::y()] {
        let expected = sky.radiance(&d);
        for scale in [1e-320, 1e-200, 1e-110, 1e110, 1e200, 1e308] {
            // A denormal has few digits; the sky varies by some tens a radian.
            let bound = if scale < 1e-307 { 1.0 } else { 1e-12 * (1.0 + expected.norm()) };
            assert!((sky.radiance(&(d * scale)) - expected).norm() <= bound, "{d:?} {scale}");
        }
    }
    // Half way between the ground and the horizon's colour.
    assert_eq!(sky.radiance(&Vector3::zeros()), 0.5 * (sky.ground + sky.horizon));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(sky.radiance(&Vector3::new(0.1, bad, 0.0)).iter().all(|c| c.is_nan()), "{bad}");
    }
}

#[test]
fn every_field_of_a_sky_is_refused_or_gives_finite_texels() {
    type Change = fn(&mut Sky, f64);
    let fields: [(&str, Change); 14] = [
        ("zenith", |s, x| s.zenith.x = x),
        ("horizon", |s, x| s.horizon.y = x),
        ("ground", |s, x| s.ground.z = x),
        ("falloff", |s, x| s.falloff = x),
        ("softness of the horizon", |s, x| s.horizon_softness = x),
        ("sun radius", |s, x| s.sun.as_mut().unwrap().angular_radius = x),
        ("sun radiance", |s, x| s.sun.as_mut().unwrap().radiance.y = x),
        ("sun direction", |s, x| s.sun.as_mut().unwrap().direction = Unit::new_unchecked(Vector3::new(x, 0.0, 0.0))),
        ("box radiance", |s, x| s.boxes[0].radiance.y = x),
        ("box direction", |s, x| s.boxes[0].direction = Unit::new_unchecked(Vector3::new(0.0, x, 0.0))),
        ("box width", |s, x| s.boxes[0].half_size[0] = x),
        ("box height", |s, x| s.boxes[0].half_size[1] = x),
        ("box softness", |s, x| s.boxes[0].softness = x),
        ("all radiances", |s, x| (s.zenith, s.boxes[1].radiance) = (Vector3::repeat(x), Vector3::repeat(x))),
    ];
    let f32_max = f64::from(f32::MAX);
    let values =
        [f64::NAN, f64::INFINITY, -1.0, -0.0, 0.0, 5e-324, 1e-160, 1e-17, 1.0, 16.0, 100.0, f32_max, 1e200, f64::MAX];
    for (name, change) in fields {
        for x in values {
            let mut sky = Sky::studio().with_sun(Some(sun(Vector3::y_axis(), 0.1)));
            change(&mut sky, x);
            let made = EnvironmentLight::from_sky(sky);
            if !x.is_finite() || (x < 0.0 && !name.ends_with("direction")) || x >= 1e200 {
                assert!(made.is_err(), "{name} {x}");
            }
            let Ok(light) = made else { continue };
            assert!(light.to_cube(cube(3)).first_not_finite().is_none(), "{name} {x}");
            for d in awkward_directions(3) {
                assert!(light.radiance(&d).iter().all(|c| c.is_finite() && *c >= 0.0), "{name} {x} {d:?}");
            }
        }
    }
    // A tiny sun may be brighter than f32 holds, as long as a texel's mean is not.
    let bright = |radius, radiance| Sun {
        direction: Vector3::y_axis(),
        angular_radius: radius,
        radiance: Vector3::repeat(radiance),
    };
    assert!(EnvironmentLight::from_sky(plain(0.0).with_sun(Some(bright(1e-30, 1e60)))).is_ok());
    assert!(EnvironmentLight::from_sky(plain(0.0).with_sun(Some(bright(0.1, 1e60)))).is_err());
}

proptest! {
    #![proptest_config(cases(32))]

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
