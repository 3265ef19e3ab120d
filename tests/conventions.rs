//! The conventions of directions and maps, each on a value that a wrong sign or axis would change.

use std::f64::consts::PI;

use haarmonic::nalgebra::{Rotation3, Vector3};
use haarmonic::sphere::{
    CubeGrid, CubeMap, Face, HemisphereDisk, LatLongConvention, LatLongGrid, LatLongMap, Resampling,
};

#[test]
fn cube_faces_are_stored_in_the_order_of_opengl() {
    let centres = [[1., 0., 0.], [-1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.], [0., 0., -1.]];
    for (i, (face, centre)) in Face::ALL.into_iter().zip(centres).enumerate() {
        assert_eq!((face as usize, face.point(0.0, 0.0)), (i, Vector3::from(centre)));
    }
}

#[test]
fn texel_0_0_of_a_face_is_its_top_left_corner() {
    // Seen from inside with y up, the side faces have +y at the top; +Y has −z at its top, −Y has +z.
    let grid = CubeGrid::new(256).unwrap();
    let corners = [[1., 1., 1.], [-1., 1., -1.], [-1., 1., -1.], [-1., -1., 1.], [-1., 1., 1.], [1., 1., -1.]];
    for (face, corner) in Face::ALL.into_iter().zip(corners) {
        let towards = Vector3::from(corner).normalize();
        assert!(grid.direction(grid.index(face, 0, 0)).dot(&towards) > 0.9999, "{face:?}");
    }
    // x is the fast index: on +Z it runs towards +x, y towards −y.
    assert!(grid.direction(grid.index(Face::PosZ, 255, 0)).x > 0.5);
    assert!(grid.direction(grid.index(Face::PosZ, 0, 255)).y < -0.5);
    assert_eq!(grid.index(Face::PosZ, 1, 0), grid.index(Face::PosZ, 0, 0) + 1);
}

#[test]
fn lat_long_images_are_centred_on_minus_z_with_plus_x_to_the_right() {
    let expected = [
        (-Vector3::z(), (0.5, 0.5)),
        (Vector3::x(), (0.75, 0.5)),
        (-Vector3::x(), (0.25, 0.5)),
        (Vector3::new(1.0, 0.0, -1.0), (0.625, 0.5)),
        (Vector3::new(0.0, 1.0, -1.0), (0.5, 0.25)),
        (Vector3::new(0.0, -1.0, -1.0), (0.5, 0.75)),
    ];
    for (d, (u, v)) in expected {
        let got = LatLongGrid::locate(&d);
        assert!((got.0 - u).abs() < 1e-15 && (got.1 - v).abs() < 1e-15, "{d:?}: {got:?}");
    }
    // +z is the seam, ±y are the first and the last row.
    assert!([0.0, 1.0].contains(&LatLongGrid::locate(&Vector3::z()).0));
    assert_eq!(LatLongGrid::locate(&Vector3::y()).1, 0.0);
    assert_eq!(LatLongGrid::locate(&-Vector3::y()).1, 1.0);
}

#[test]
fn lat_long_pixels_start_at_the_top_left() {
    let grid = LatLongGrid::new(8, 4).unwrap();
    let first = grid.direction(0);
    assert!(first.y > 0.9 && first.z > 0.0 && first.x < 0.0, "{first:?}");
    assert!((grid.direction(8 + 4).into_inner() - *LatLongGrid::point(4.5 / 8.0, 1.5 / 4.0)).norm() < 1e-15);
}

#[test]
fn a_turned_map_shows_at_r_omega_what_was_at_omega() {
    // A light in +x, turned by 90° about y, comes from −z.
    let grid = CubeGrid::new(8).unwrap();
    let light = CubeMap::from_fn(grid, |d| if d.x > 0.8 { 1.0 } else { 0.0 });
    let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), PI / 2.0);
    assert!((turn * Vector3::x() + Vector3::z()).norm() < 1e-15);
    for resampling in [Resampling::Area, Resampling::Smooth, Resampling::Bilinear] {
        let turned = light.to_cube(grid, &turn, resampling);
        assert!(turned.nearest(&-Vector3::z()) > 0.999 && turned.nearest(&Vector3::x()) < 1e-3);
        let image = light.to_lat_long(LatLongGrid::new(32, 16).unwrap(), &turn, resampling);
        assert!(image.nearest(&-Vector3::z()) > 0.99 && image.nearest(&Vector3::x()) < 1e-3, "{resampling:?}");
        let back = image.to_cube(grid, &turn.inverse(), resampling);
        assert!(back.nearest(&Vector3::x()) > 0.99 && back.nearest(&-Vector3::z()) < 1e-3, "{resampling:?}");
    }
}

/// Their own formulas: (u, v) of a direction in their own coordinates, v from the top.
fn published(convention: LatLongConvention, d: &Vector3<f64>) -> (f64, f64) {
    let (x, y, z) = (d.x, d.y, d.z);
    let turn = 2.0 * PI;
    match convention {
        LatLongConvention::CentreNegZ => (0.5 + x.atan2(-z) / turn, y.acos() / PI),
        LatLongConvention::Mitsuba => ((x.atan2(-z) / turn).rem_euclid(1.0), y.acos() / PI),
        // equirectUv: v from the bottom.
        LatLongConvention::ThreeJs => (z.atan2(x) / turn + 0.5, 1.0 - (y.asin() / PI + 0.5)),
        // direction_to_equirectangular: v from the bottom.
        LatLongConvention::Blender => (-y.atan2(x) / turn + 0.5, 1.0 - (z.atan2(x.hypot(y)) / PI + 0.5)),
        // SphericalPhi, SphericalTheta.
        LatLongConvention::PbrtV3 => {
            let phi = y.atan2(x);
            (if phi < 0.0 { phi + turn } else { phi } / turn, z.acos() / PI)
        }
        // LookupLongLat of the direction whose y and z TransformSideToWorldSpace has swapped.
        LatLongConvention::Unreal => {
            let (y, z) = (z, y);
            ((1.0 + x.atan2(-z) / PI) / 2.0, y.acos() / PI)
        }
        // ToRadialCoords: v from the bottom.
        LatLongConvention::Unity => (0.5 - z.atan2(x) * 0.5 / PI, 1.0 - (1.0 - y.acos() / PI)),
        // SKY_COORDS: z is negated before the angle.
        LatLongConvention::Godot => {
            let angle = x.atan2(-z);
            (if angle < 0.0 { angle + turn } else { angle } / turn, y.acos() / PI)
        }
        // mirrorCubemap, then toRectilinear.
        LatLongConvention::Filament => {
            let x = -x;
            ((x.atan2(z) / PI + 1.0) * 0.5, (1.0 - y.asin() * 2.0 / PI) * 0.5)
        }
    }
}

#[test]
fn maps_of_other_programs_are_ours_in_their_axes_turned_about_y() {
    for convention in LatLongConvention::ALL {
        for theirs in haarmonic::sphere::fibonacci_directions(50) {
            let (u, v) = published(convention, &theirs);
            let close = |(got_u, got_v): (f64, f64), how: &str| {
                let gap = (got_u - u + 0.5).rem_euclid(1.0) - 0.5;
                assert!(
                    gap.abs() < 1e-15 && (got_v - v).abs() < 1e-15,
                    "{convention:?} {how}: {got_u} {got_v}, {u} {v}"
                );
            };
            close(convention.locate(&theirs), "located");
            // Our reading of the turned map in direction d: the place of R⁻¹d.
            let ours = convention.axes().to_ours(&theirs);
            close(LatLongGrid::locate(&(convention.rotation().inverse() * ours)), "turned");
        }
    }
    assert_eq!(LatLongConvention::default().angle(), 0.0);
}

/// To the right of what one faces is up × forwards in their coordinates, by the same formula in either handedness.
#[test]
fn no_program_mirrors_its_image() {
    for convention in LatLongConvention::ALL {
        let axes = convention.axes();
        let up = axes.to_theirs(&Vector3::y());
        let forwards = axes.to_theirs(&(convention.rotation() * -Vector3::z()));
        let right = if axes.is_left_handed() { up.cross(&forwards) } else { forwards.cross(&up) };
        let (u, v) = convention.locate(&forwards);
        assert!((u - 0.5).abs() < 1e-15 && (v - 0.5).abs() < 1e-15, "{convention:?}");
        assert!((convention.locate(&right).0 - 0.75).abs() < 1e-15, "{convention:?}");
        assert_eq!(convention.locate(&up).1, 0.0, "{convention:?}");
    }
}

/// Draws docs/pictures/lat_long_conventions.png:
/// `cargo test --all-features --test conventions -- --ignored draw`.
#[cfg(feature = "io")]
#[test]
#[ignore = "writes a picture of the documentation"]
fn draw_where_the_axes_lie() {
    picture::draw(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/pictures/lat_long_conventions.png"));
}

#[cfg(feature = "io")]
mod picture {
    use haarmonic::nalgebra::{Vector2, Vector3};
    use haarmonic::sphere::LatLongConvention;

    const COLUMNS: usize = 3;
    /// A panel without its margin, in pixels.
    const SIZE: [usize; 2] = [320, 160];
    const MARGIN: usize = 20;
    const PITCH: [usize; 2] = [SIZE[0] + 2 * MARGIN, SIZE[1] + 2 * MARGIN];
    /// x, y, z: told apart by blue–orange vision too (Okabe and Ito's vermilion, green and blue).
    const COLOURS: [[f64; 3]; 3] = [[0.835, 0.369, 0.0], [0.0, 0.62, 0.451], [0.0, 0.447, 0.698]];

    /// How far a point is inside the sign of an axis, in pixels: a disc for x, a square for y, a diamond for z.
    fn inside(axis: usize, offset: Vector2<f64>, radius: f64) -> f64 {
        match axis {
            0 => radius - offset.norm(),
            1 => radius * 0.9 - offset.amax(),
            _ => radius * 0.9 - (offset.x.abs() + offset.y.abs()) * 0.5f64.sqrt() * 0.9,
        }
    }

    /// Paper, frame, a line every 45° and the six signs: filled for +, hollow for −.
    fn panel(convention: LatLongConvention, at: Vector2<f64>) -> [f64; 3] {
        let size = Vector2::new(SIZE[0] as f64, SIZE[1] as f64);
        let mut colour = [1.0; 3];
        let within = (0..2).all(|i| (-0.5..=size[i] + 0.5).contains(&at[i]));
        let cell = size.x / 8.0;
        let on_line = |t: f64, step: f64| (t - (t / step).round() * step).abs() <= 0.5;
        if within {
            colour = [0.95; 3];
            if on_line(at.x, cell) || on_line(at.y, cell) {
                colour = [0.8; 3];
            }
            if on_line(at.x, size.x / 2.0) && on_line(at.y - size.y / 2.0, size.y * 2.0) || on_line(at.y, size.y) {
                colour = [0.5; 3];
            }
        }
        for axis in 0..3 {
            for negative in [false, true] {
                let mut d = Vector3::zeros();
                d[axis] = if negative { -1.0 } else { 1.0 };
                let (u, v) = convention.locate(&d);
                // A pole is a whole row: its sign stands in the middle. The seam is in two places.
                let us = if v == 0.0 || v == 1.0 {
                    [0.5; 2]
                } else {
                    [
                        u,
                        if u < 0.01 {
                            1.0
                        } else if u > 0.99 {
                            0.0
                        } else {
                            u
                        },
                    ]
                };
                for u in us {
                    let inside = inside(axis, at - Vector2::new(u * size.x, v * size.y), 11.0);
                    if inside > 0.0 {
                        colour = if negative && inside > 4.0 { [1.0; 3] } else { COLOURS[axis] };
                    }
                }
            }
        }
        colour
    }

    pub fn draw(path: &str) {
        let rows = LatLongConvention::ALL.len().div_ceil(COLUMNS);
        let (width, height) = (COLUMNS * PITCH[0], rows * PITCH[1]);
        let mut pixels = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let which = y / PITCH[1] * COLUMNS + x / PITCH[0];
                // Nine samples a pixel.
                let mut sum = Vector3::zeros();
                for sample in 0..9 {
                    let place = [x % PITCH[0], y % PITCH[1]].map(|p| p as f64 - MARGIN as f64);
                    let shift = [sample % 3, sample / 3].map(|s| (s as f64 + 0.5) / 3.0);
                    let at = Vector2::new(place[0] + shift[0], place[1] + shift[1]);
                    sum += Vector3::from(LatLongConvention::ALL.get(which).map_or([1.0; 3], |&c| panel(c, at)));
                }
                pixels.push((sum / 9.0).map(|c| (c * 255.0).round() as u8).into());
            }
        }
        haarmonic::io::save_png_srgb8(path, width, height, &pixels).unwrap();
    }
}

#[test]
fn local_up_is_the_middle_of_the_hemisphere_disk_and_the_horizon_its_rim() {
    assert_eq!(HemisphereDisk::point(&Vector3::z_axis()).norm(), 0.0);
    assert_eq!(HemisphereDisk::point(&Vector3::y_axis()).y, 1.0);
    assert_eq!(HemisphereDisk::AREA_PER_STERADIAN * 2.0 * PI, PI);
}

#[test]
fn integrals_are_in_steradians() {
    let hemisphere = |d: &Vector3<f64>| if d.y > 0.0 { 1.0f64 } else { 0.0 };
    let boxed = CubeMap::from_fn(CubeGrid::new(2).unwrap(), |d| hemisphere(&d));
    let image = LatLongMap::from_fn(LatLongGrid::new(8, 4).unwrap(), |d| hemisphere(&d));
    assert!((boxed.integral() - 2.0 * PI).abs() < 1e-14 && (image.integral() - 2.0 * PI).abs() < 1e-14);
}
