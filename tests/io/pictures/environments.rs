//! Layouts of environments: OpenEXR's cube, angular maps and mirror balls.

use std::f64::consts::PI;

use haarmonic::io::{EnvironmentLayout, Image, encode_exr, load_environment, read_environment, read_environment_with};
use haarmonic::nalgebra::{UnitVector3, Vector3};
use haarmonic::scene::EnvironmentLight;
use haarmonic::sphere::CubeGrid;

use super::exr_files::with_attribute;
use super::{fault, messages, only_message};

type V = Vector3<f64>;

/// A light without any symmetry: what is turned or mirrored, is seen.
fn analytic(d: &V) -> V {
    let d = d.normalize();
    V::new(1.0 + 0.8 * d.x, 1.0 + 0.6 * d.y + 0.3 * d.x * d.z, 1.0 - 0.7 * d.z + 0.2 * d.x * d.y * d.z)
}

fn directions() -> Vec<UnitVector3<f64>> {
    // An odd side has texels on the axes; corners and edges of the cube are beside it.
    let mut directions = CubeGrid::new(11).unwrap().directions();
    for i in 0..27 {
        let corner = V::new((i % 3) as f64 - 1.0, (i / 3 % 3) as f64 - 1.0, (i / 9) as f64 - 1.0);
        directions.extend(UnitVector3::try_new(corner, 0.5));
    }
    directions
}

/// The largest difference between a light and an analytic one, and where.
fn worst(light: &EnvironmentLight, expected: impl Fn(&V) -> V) -> (f64, V) {
    let difference = |d: &UnitVector3<f64>| ((light.radiance(d) - expected(d)).amax(), d.into_inner());
    directions().iter().map(difference).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
}

fn picture(w: usize, h: usize, f: impl Fn(usize, usize) -> V) -> Image {
    Image::new(w, h, (0..w * h).map(|i| f(i % w, i / w).cast()).collect()).unwrap()
}

/// The direction that a pixel of OpenEXR's cube shows, as its header ImfEnvmap.h has it: the outermost pixels are on
/// the edges. In its own coordinates.
fn open_exr_direction(side: usize, x: usize, y: usize) -> V {
    let at = |i: usize| if side == 1 { 0.0 } else { 2.0 * i as f64 / (side - 1) as f64 - 1.0 };
    let (a, b) = (at(x), at(y % side));
    match y / side {
        0 => V::new(1.0, -b, a),
        1 => V::new(-1.0, -b, -a),
        2 => V::new(a, 1.0, -b),
        3 => V::new(a, -1.0, b),
        4 => V::new(-a, -b, 1.0),
        _ => V::new(a, -b, -1.0),
    }
}

/// OpenEXR's coordinates are turned by 180° about y, in its latitude–longitude maps as in its cubes.
fn turned(d: &V) -> V {
    V::new(-d.x, d.y, -d.z)
}

#[test]
fn open_exr_cube_and_its_companion_are_the_same_light() {
    let cube = load_environment(fault("envmap_cube.exr")).unwrap();
    let lat_long = load_environment(fault("envmap_latlong.exr")).unwrap();
    assert_eq!((messages(&cube), messages(&lat_long)), (vec![], vec![]));
    // ½ + ½ d. Faces of 16² pixels interpolate d within (1/15)² / 2, twice over; halves have 11 bits.
    let (error, at) = worst(&cube.value, |d| turned(d).map(|c| 0.5 + 0.5 * c));
    assert!(error < 0.01, "{error} at {at}");
    // The companion's pixels are on the poles and on the seam; it is read as if they were half a pixel beside these:
    // half of 180°/16.
    let (error, at) = worst(&lat_long.value, |d| turned(d).map(|c| 0.5 + 0.5 * c));
    assert!(error < 0.06, "{error} at {at}");
}

#[test]
fn open_exr_cubes_of_every_size() {
    for side in [1, 2, 3, 16, 64] {
        let image = picture(side, 6 * side, |x, y| analytic(&open_exr_direction(side, x, y)));
        let bytes = encode_exr(&image).unwrap();
        let tagged = with_attribute(&bytes, "envmap", "envmap", &[1]);
        let loaded = read_environment(&tagged, "a.exr").unwrap();
        assert_eq!(messages(&loaded), [""; 0]);
        let explicit = read_environment_with(&bytes, "a.exr", EnvironmentLayout::OpenExrCube).unwrap().value;
        for d in directions() {
            assert_eq!(loaded.value.radiance(&d), explicit.radiance(&d));
        }
        if side >= 16 {
            let (error, at) = worst(&loaded.value, |d| analytic(&turned(d)));
            // Interpolation twice over: second derivatives of up to 3 times (2/side)² / 8, and as much again.
            assert!(error < 8.0 / (side * side) as f64 + 2e-3, "side {side}: {error} at {at}");
        }
    }
}

#[test]
fn strips_without_the_attribute_are_open_gl_ones() {
    let side = 32;
    let grid = CubeGrid::new(side).unwrap();
    let image = picture(side, 6 * side, |x, y| analytic(&grid.direction(y / side * side * side + y % side * side + x)));
    let bytes = encode_exr(&image).unwrap();
    for (layout, bytes) in [
        (EnvironmentLayout::Auto, bytes.clone()),
        // Said by the caller, it goes before the attribute.
        (EnvironmentLayout::CubeStrip, with_attribute(&bytes, "envmap", "envmap", &[1])),
    ] {
        let loaded = read_environment_with(&bytes, "a.exr", layout).unwrap();
        assert_eq!(messages(&loaded), [""; 0]);
        let (error, at) = worst(&loaded.value, analytic);
        assert!(error < 6e-3, "{error} at {at}");
    }
}

#[test]
fn the_attribute_and_the_proportions() {
    let flat = |w: usize, h: usize| encode_exr(&picture(w, h, |_, _| V::new(1.0, 2.0, 3.0))).unwrap();
    let tagged = |w, h, value: &[u8]| with_attribute(&flat(w, h), "envmap", "envmap", value);
    let read = |bytes: &[u8]| read_environment(bytes, "a.exr");
    // A latitude–longitude map by its attribute is one, whatever its proportions; so is what has those of neither.
    for (w, h) in [(8, 6), (6, 8), (12, 2), (2, 12), (5, 5), (7, 3)] {
        let message = only_message(&read(&tagged(w, h, &[0])).unwrap());
        let expected = format!("a.exr: {w} × {h} pixels are not 2 : 1; taken as a latitude–longitude map all the same");
        assert_eq!(message, expected);
    }
    assert_eq!(messages(&read(&tagged(8, 4, &[0])).unwrap()), [""; 0]);
    // A cube that is none.
    for (w, h) in [(8, 4), (12, 2), (8, 6)] {
        let message = only_message(&read(&tagged(w, h, &[1])).unwrap());
        assert_eq!(message, format!("a.exr, header: envmap is cube, but {w} × {h} pixels are not 1 : 6; ignored"));
    }
    assert_eq!(messages(&read(&tagged(2, 12, &[1])).unwrap()), [""; 0]);
    let e = read(&tagged(2, 12, &[7])).unwrap_err().to_string();
    assert_eq!(e, "a.exr, header: environment map number 7 is not known");
    // Every light above is the same from everywhere.
    let light = read(&tagged(2, 12, &[1])).unwrap().value;
    assert_eq!(worst(&light, |_| V::new(1.0, 2.0, 3.0)).0, 0.0);
}

#[test]
fn layouts_refuse_other_proportions() {
    let bytes = encode_exr(&picture(7, 3, |_, _| V::zeros())).unwrap();
    for (layout, needed) in [
        (EnvironmentLayout::Cross, "4 : 3 or 3 : 4"),
        (EnvironmentLayout::CubeStrip, "6 : 1 or 1 : 6"),
        (EnvironmentLayout::OpenExrCube, "1 : 6"),
        (EnvironmentLayout::AngularMap, "1 : 1"),
        (EnvironmentLayout::MirrorBall, "1 : 1"),
    ] {
        let e = read_environment_with(&bytes, "a.exr", layout).unwrap_err().to_string();
        assert_eq!(e, format!("a.exr: 7 × 3 pixels; this layout needs {needed}"));
    }
    // What was said needs no warning.
    let loaded = read_environment_with(&bytes, "a.exr", EnvironmentLayout::LatLong).unwrap();
    assert_eq!(messages(&loaded), [""; 0]);
}

/// The point of the unit disc that a pixel shows, y up, if it does.
fn disc(n: usize, x: usize, y: usize) -> Option<(f64, f64)> {
    let at = |i: usize| (2 * i + 1) as f64 / n as f64 - 1.0;
    let (u, v) = (at(x), -at(y));
    (u.hypot(v) <= 1.0).then_some((u, v))
}

/// Angle π r from −z, towards the point: (0, 0, −1) turned about the axis across.
fn angular_direction(u: f64, v: f64) -> V {
    let r = u.hypot(v);
    let (sin, cos) = (PI * r).sin_cos();
    if r == 0.0 { -V::z() } else { V::new(sin * u / r, sin * v / r, -cos) }
}

/// The view ray (0, 0, −1) reflected by the ball, whose normal there is (u, v, √(1 − u² − v²)).
fn ball_direction(u: f64, v: f64) -> V {
    let normal = V::new(u, v, (1.0 - u * u - v * v).max(0.0).sqrt());
    let ray = -V::z();
    ray - 2.0 * ray.dot(&normal) * normal
}

#[test]
fn angular_maps_and_mirror_balls() {
    for (layout, direction, rim) in [
        // The picture's pixel is 180°/(n/2) wide.
        (EnvironmentLayout::AngularMap, angular_direction as fn(f64, f64) -> V, 0.999),
        // Towards the rim of the ball a pixel shows ever more: the last one of 128, 14°.
        (EnvironmentLayout::MirrorBall, ball_direction, 0.9),
    ] {
        let n = 128;
        // Outside of the disc something that would show.
        let image = picture(n, n, |x, y| disc(n, x, y).map_or(V::repeat(1e6), |(u, v)| analytic(&direction(u, v))));
        let bytes = encode_exr(&image).unwrap();
        let loaded = read_environment_with(&bytes, "a.exr", layout).unwrap();
        assert_eq!(messages(&loaded), [""; 0]);
        for d in directions() {
            let error = (loaded.value.radiance(&d) - analytic(&d)).amax();
            // Near −z the angular map is at its centre, the ball at its rim; there half of a pixel counts.
            let backwards = if layout == EnvironmentLayout::AngularMap { d.z } else { -d.z };
            let tolerance = if backwards > rim { 0.25 } else { 0.012 };
            assert!(error < tolerance, "{layout:?} at {}: {error}", d.into_inner());
        }
        // The directions that everybody can check: what is in the middle, and a little to the right and up.
        let middle = if layout == EnvironmentLayout::AngularMap { -V::z() } else { V::z() };
        for (u, v) in [(0.05, 0.0), (0.0, 0.05), (-0.5, 0.3), (0.4, -0.6)] {
            let d = direction(u, v);
            assert_eq!((d.x > 0.0, d.y > 0.0), (u > 0.0, v > 0.0));
            assert!((loaded.value.radiance(&d) - analytic(&d)).amax() < 0.012);
        }
        assert!((loaded.value.radiance(&middle) - analytic(&middle)).amax() < 1e-3);
    }
}

#[test]
fn small_discs() {
    for n in 1..6 {
        let bytes = encode_exr(&picture(n, n, |_, _| V::new(1.0, 2.0, 3.0))).unwrap();
        for layout in [EnvironmentLayout::AngularMap, EnvironmentLayout::MirrorBall] {
            let light = read_environment_with(&bytes, "a.exr", layout).unwrap().value;
            assert!(worst(&light, |_| V::new(1.0, 2.0, 3.0)).0 < 1e-6, "{n}, {layout:?}");
        }
    }
}

#[test]
fn square_pictures_are_angular_maps_with_a_warning() {
    let n = 64;
    let image = picture(n, n, |x, y| disc(n, x, y).map_or(V::zeros(), |(u, v)| analytic(&angular_direction(u, v))));
    let loaded = read_environment(&encode_exr(&image).unwrap(), "a.exr").unwrap();
    let expected = "a.exr: 64 × 64 pixels are square; taken as an angular map (light probe); for a mirror ball or a \
                    latitude–longitude map say so (EnvironmentLayout, --env-layout)";
    assert_eq!(only_message(&loaded), expected);
    assert!((loaded.value.radiance(&V::x()) - analytic(&V::x())).amax() < 0.02);
}
