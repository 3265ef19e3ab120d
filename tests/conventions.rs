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

#[test]
fn maps_of_other_programs_are_ours_turned_about_y() {
    // Their own formulas for the image column of a direction.
    let mitsuba = |d: &Vector3<f64>| (d.x.atan2(-d.z) / (2.0 * PI)).rem_euclid(1.0);
    let three_js = |d: &Vector3<f64>| d.z.atan2(d.x) / (2.0 * PI) + 0.5;
    let ours = |d: &Vector3<f64>| LatLongGrid::locate(d).0;
    type Column<'a> = &'a dyn Fn(&Vector3<f64>) -> f64;
    let formulas: [(LatLongConvention, Column); 3] = [
        (LatLongConvention::CentreNegZ, &ours),
        (LatLongConvention::Mitsuba, &mitsuba),
        (LatLongConvention::ThreeJs, &three_js),
    ];
    for (convention, theirs) in formulas {
        for d in haarmonic::sphere::fibonacci_directions(50) {
            // Our reading of the turned map in direction d: the column of R⁻¹d.
            let (u, v) = LatLongGrid::locate(&(convention.rotation().inverse() * *d));
            let gap = (u - theirs(&d) + 0.5).rem_euclid(1.0) - 0.5;
            assert!(gap.abs() < 1e-15 && (v - d.y.acos() / PI).abs() < 1e-15, "{convention:?}: {u} {}", theirs(&d));
        }
    }
    assert_eq!(LatLongConvention::default().angle(), 0.0);
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
