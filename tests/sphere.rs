//! Domains of direction against golden values, naive twins and the laws they must keep.
#![cfg(all(feature = "reference", feature = "proptest"))]

mod support;

use std::f64::consts::{FRAC_PI_2, PI};

use approx::{AbsDiffEq, RelativeEq};
use haarmonic::nalgebra::{Rotation3, Unit, Vector2, Vector3};
use haarmonic::sphere::*;
use haarmonic::{Error, reference::sphere as naive, strategies};
use proptest::prelude::*;
use support::{HAAR_AFFINE, cases, golden, noise, number};

const EPS: f64 = f64::EPSILON;

fn cube(side: usize) -> CubeGrid {
    CubeGrid::new(side).unwrap()
}

fn lat_long(width: usize, height: usize) -> LatLongGrid {
    LatLongGrid::new(width, height).unwrap()
}

/// A fixed rotation in general position.
fn askew() -> Rotation3<f64> {
    Rotation3::from_euler_angles(0.3, -1.2, 2.5)
}

/// Rotations that put poles and edges on each other, beside each other and nowhere near.
fn turns() -> Vec<Rotation3<f64>> {
    let about_x = |angle| Rotation3::from_axis_angle(&Vector3::x_axis(), angle);
    vec![Rotation3::identity(), askew(), about_x(FRAC_PI_2), about_x(1e-9), about_x(PI), about_x(PI / 4.0)]
}

/// Values that span eight decades without any smoothness: a hash of the index.
fn rough(i: usize) -> f64 {
    (noise(i) * 18.0 - 9.0).exp()
}

#[test]
fn texel_solid_angles_are_the_golden_ones() {
    let golden = golden(HAAR_AFFINE, "cubemap_solid_angle");
    let mut seen = 0;
    let mut check = |side: usize, x: usize, y: usize, expected: f64| {
        let got = cube(side).solid_angle(x, y);
        // Differences of four arc tangents below π/2: 4 eps absolute, whatever the texel's size.
        assert!((got - expected).abs() <= EPS, "{side}: ({x}, {y}): {got} against {expected}");
        seen += 1;
    };
    for (side, rows) in golden["tables_rows_y"].as_object().unwrap() {
        for (y, row) in rows.as_array().unwrap().iter().enumerate() {
            for (x, omega) in row.as_array().unwrap().iter().enumerate() {
                check(side.parse().unwrap(), x, y, number(omega));
            }
        }
    }
    for row in golden["spot"].as_array().unwrap() {
        let at = |i: usize| row[i].as_u64().unwrap() as usize;
        check(at(0), at(1), at(2), number(&row[3]));
    }
    assert_eq!(seen, 1 + 4 + 64 + golden["spot"].as_array().unwrap().len());
}

#[test]
fn texel_solid_angles_are_the_integral_of_their_density() {
    for side in [1, 2, 3, 7, 64] {
        let grid = cube(side);
        for (x, y) in [(0, 0), (side / 2, 0), (side - 1, side / 3)] {
            let line = |i| [grid.line(i), grid.line(i + 1)];
            let (got, expected) = (grid.solid_angle(x, y), naive::solid_angle(line(x), line(y)));
            assert!((got - expected).abs() < 8.0 * EPS, "{side}: ({x}, {y}): {got} against {expected}");
        }
    }
}

#[test]
fn the_hemisphere_disk_is_the_golden_one() {
    let golden = golden(HAAR_AFFINE, "square_and_hemisphere");
    let rows = golden["hemi"].as_array().unwrap();
    assert_eq!(rows.len(), 20);
    let mut below = 0;
    for row in rows {
        let v: Vec<f64> = row.as_array().unwrap().iter().map(number).collect();
        let (direction, point) = (Unit::new_normalize(Vector3::new(v[2], v[3], v[4])), Vector2::new(v[5], v[6]));
        assert!((HemisphereDisk::point(&direction) - point).norm() < 4.0 * EPS, "{v:?}");
        // √(2 − ρ²) loses digits towards the nadir, where 2 − ρ² = 1 + z vanishes.
        let steep = 1.0 / (1.0 + direction.z).sqrt();
        assert!((*HemisphereDisk::direction(&point) - *direction).norm() < 4.0 * EPS * steep.max(1.0), "{v:?}");
        let [x, y] = naive::hemisphere_point(v[0], v[1]);
        assert!((Vector2::new(x, y) - point).norm() < 4.0 * EPS);
        below += usize::from(v[4] < 0.0);
    }
    assert!(below > 0, "the golden values go below the horizon");
}

#[test]
fn the_hemisphere_disk_halves_areas() {
    // The Jacobian of the inverse by central differences: |∂d/∂x × ∂d/∂y| = dω/dA = 2; step 1e-5, error 1e-9.
    for direction in fibonacci_directions(200).iter().filter(|d| d.z > -0.99) {
        let p = HemisphereDisk::point(direction);
        let slope = |step: Vector2<f64>| {
            (*HemisphereDisk::direction(&(p + step)) - *HemisphereDisk::direction(&(p - step))) / (2.0 * step.norm())
        };
        let area = slope(Vector2::new(1e-5, 0.0)).cross(&slope(Vector2::new(0.0, 1e-5))).norm();
        let expected = 1.0 / HemisphereDisk::AREA_PER_STERADIAN;
        // Third derivatives grow as (2 − ρ²)^{−5/2} towards the nadir.
        let steep = (1.0 + direction.z).powf(-2.5);
        assert!((area - expected).abs() < 1e-9 * (1.0 + steep), "{direction:?}: {area}");
    }
}

#[test]
fn the_hemisphere_disk_has_a_rim() {
    assert_eq!(HemisphereDisk::point(&Vector3::z_axis()), Vector2::zeros());
    assert_eq!(HemisphereDisk::point(&-Vector3::z_axis()), Vector2::new(HemisphereDisk::NADIR_RADIUS, 0.0));
    assert_eq!(HemisphereDisk::direction(&Vector2::new(2.0, 3.0)), -Vector3::z_axis());
    assert!(HemisphereDisk::direction(&Vector2::new(f64::NAN, 0.0)).z.is_nan());
    // Beside the nadir ρ is known to the last bits although 1 + z cancels.
    let near = Unit::new_unchecked(Vector3::new(3e-9, -4e-9, -1.0));
    let p = HemisphereDisk::point(&near);
    assert!((p - Vector2::new(0.6, -0.8) * 2f64.sqrt()).norm() < 4.0 * EPS, "{p:?}");
}

#[test]
fn sphere_quadrature_is_exact_to_its_degree_and_no_further() {
    for degree in [0, 1, 2, 3, 7, 16, 33] {
        let rule = SphereQuadrature::new(degree).unwrap();
        assert_eq!(rule.degree(), degree);
        assert!(rule.directions().iter().all(|d| (d.norm() - 1.0).abs() < 4.0 * EPS));
        let powers = |d: usize| (0..=d).flat_map(move |a| (0..=d - a).map(move |b| [a, b, d - a - b]));
        let error = |[a, b, c]: [usize; 3]| {
            let got = rule.integrate(|d| d.x.powi(a as i32) * d.y.powi(b as i32) * d.z.powi(c as i32));
            (got - naive::monomial_integral(a as u32, b as u32, c as u32)).abs()
        };
        for exponents in (0..=degree).flat_map(powers) {
            assert!(error(exponents) < 1e-13, "degree {degree}, {exponents:?}: {}", error(exponents));
        }
        // One degree more must show an error somewhere, or the rule is larger than it says (odd degrees integrate to
        // 0).
        let beyond = powers(degree + 1 + (degree + 1) % 2).map(error).fold(0.0, f64::max);
        assert!(beyond > 1e-13, "degree {degree} is exact to a higher one");
    }
    assert!(matches!(SphereQuadrature::new(1024), Err(Error::OutOfRange { got: 1024.0, .. })));
}

#[test]
fn monomial_integrals_of_the_reference_are_right() {
    for (powers, thirds) in
        [([0, 0, 0], 4.0), ([2, 0, 0], 4.0 / 3.0), ([2, 2, 0], 4.0 / 15.0), ([2, 2, 2], 4.0 / 105.0)]
    {
        let [a, b, c] = powers;
        assert!((naive::monomial_integral(a, b, c) - thirds * PI).abs() < 2.0 * EPS * 4.0 * PI);
    }
    assert_eq!(naive::monomial_integral(1, 2, 0), 0.0);
}

#[test]
fn fibonacci_directions_are_even() {
    assert!(fibonacci_directions(0).is_empty());
    assert_eq!(fibonacci_directions(1)[0].z, 0.0);
    for n in [10, 1000] {
        let points = fibonacci_directions(n);
        assert!(points.iter().all(|d| (d.norm() - 1.0).abs() < 4.0 * EPS));
        // A quadrature of x² to O(1/n); the centroid likewise.
        let second: f64 = points.iter().map(|d| d.x * d.x).sum::<f64>() * 4.0 * PI / n as f64;
        assert!((second - 4.0 / 3.0 * PI).abs() < 4.0 / n as f64, "{n}: {second}");
    }
}

#[test]
fn lat_long_solid_angles_make_the_sphere_and_match_the_band() {
    for (width, height) in [(1, 1), (2, 1), (5, 3), (1024, 512)] {
        let grid = lat_long(width, height);
        let sum: f64 = (0..height).map(|row| grid.solid_angle(row)).sum::<f64>() * width as f64;
        assert!((sum / (4.0 * PI) - 1.0).abs() < 1e-14, "{width}×{height}: {sum}");
        for row in [0, height / 2, height - 1] {
            let line = |j: usize| (PI * j as f64 / height as f64).cos();
            let band = 2.0 * PI / width as f64 * (line(row) - line(row + 1));
            assert!((grid.solid_angle(row) - band).abs() < 8.0 * EPS / width as f64, "{width}×{height}: row {row}");
        }
    }
}

#[test]
fn lat_long_pixels_and_directions_are_inverse() {
    for (width, height) in [(1, 1), (2, 1), (3, 5), (64, 32), (127, 33)] {
        let grid = lat_long(width, height);
        for i in 0..grid.len() {
            let d = grid.direction(i);
            assert_eq!(grid.nearest(&d), i, "{width}×{height}: pixel {i}");
            assert_eq!(naive::lat_long_nearest([width, height], &d), i);
        }
    }
}

#[test]
fn degenerate_directions_have_a_pixel_and_a_texel() {
    let map = LatLongMap::from_fn(lat_long(4, 2), |d| d.y);
    let boxed = CubeMap::from_fn(cube(3), |d| d.y);
    for d in
        [Vector3::zeros(), Vector3::repeat(f64::NAN), Vector3::repeat(f64::INFINITY), Vector3::new(0.0, -0.0, -0.0)]
    {
        assert!(map.grid().nearest(&d) < map.grid().len() && boxed.grid().nearest(&d) < boxed.grid().len());
        let _ = (map.nearest(&d), map.bilinear(&d), boxed.nearest(&d), boxed.bilinear(&d));
    }
    assert!(map.bilinear(&Vector3::repeat(f64::NAN)).is_nan() && boxed.bilinear(&Vector3::repeat(f64::NAN)).is_nan());
}

#[test]
fn bilinear_look_up_agrees_with_the_search_of_all_texels() {
    for side in [1, 2, 3, 5] {
        let map = CubeMap::new(cube(side), (0..6 * side * side).map(rough).collect()).unwrap();
        for direction in fibonacci_directions(400) {
            let (got, expected) = (map.bilinear(&direction), naive::cube_bilinear(side, map.texels(), &direction));
            // Weights carry a few eps of the coordinates, which span `side`.
            let scale = (9.0f64).exp() * side as f64;
            assert!((got - expected).abs() < 8.0 * EPS * scale, "{side}: {direction:?}: {got} against {expected}");
        }
    }
}

#[test]
fn lat_long_look_up_agrees_with_the_search_of_rows_and_columns() {
    for (width, height) in [(1, 1), (1, 4), (2, 1), (5, 3), (8, 6)] {
        let map = LatLongMap::new(lat_long(width, height), (0..width * height).map(rough).collect()).unwrap();
        for direction in fibonacci_directions(400) {
            let got = map.bilinear(&direction);
            let expected = naive::lat_long_bilinear([width, height], map.pixels(), &direction);
            // acos near a pole knows v to the root of eps, and no direction of the set is nearer than 0.05.
            let scale = 9f64.exp() * (width + height) as f64;
            assert!((got - expected).abs() < 16.0 * EPS * scale, "{width}×{height}: {got} against {expected}");
        }
    }
}

#[test]
fn bilinear_look_up_gives_the_texel_at_its_centre() {
    for side in [1, 2, 7] {
        let map = CubeMap::new(cube(side), (0..6 * side * side).map(|i| i as f64).collect()).unwrap();
        for i in 0..map.grid().len() {
            assert!((map.bilinear(&map.grid().direction(i)) - i as f64).abs() < 64.0 * EPS * map.grid().len() as f64);
        }
    }
    let map = LatLongMap::new(lat_long(8, 4), (0..32).map(f64::from).collect()).unwrap();
    for i in 0..32 {
        assert!((map.bilinear(&map.grid().direction(i)) - i as f64).abs() < 64.0 * EPS * 32.0);
    }
}

#[test]
fn cube_look_up_is_continuous_across_all_edges_and_corners() {
    for side in [1, 2, 3, 8] {
        let map = CubeMap::new(cube(side), (0..6 * side * side).map(rough).collect()).unwrap();
        let largest = map.texels().iter().copied().fold(0.0, f64::max);
        let mut edges = 0;
        for (a, b) in (0..6).flat_map(|a| (a + 1..6).map(move |b| (a, b))) {
            let (a, b) = (naive::cube_point(a, 0.0, 0.0), naive::cube_point(b, 0.0, 0.0));
            if a.dot(&b) < -0.5 {
                continue;
            }
            edges += 1;
            // 41 points along the edge, both corners included, approached from both faces.
            for t in (-20..=20).map(|t| f64::from(t) / 20.0) {
                let on_edge = a + b + a.cross(&b) * t;
                let step = (a - b) * 1e-9;
                let (from_a, from_b) = (map.bilinear(&(on_edge + step)), map.bilinear(&(on_edge - step)));
                // Slopes are at most largest·side a unit.
                let bound = 8e-9 * largest * side as f64;
                assert!((from_a - from_b).abs() < bound, "{side}: {on_edge:?}: {from_a} {from_b}");
            }
        }
        assert_eq!(edges, 12);
        for corner in (0..8).map(|i| Vector3::from_fn(|k, _| if i >> k & 1 == 0 { -1.0 } else { 1.0 })) {
            let mean = (0..3)
                .map(|axis| {
                    let mut inward = corner * (1.0 - 1e-6);
                    inward[axis] = corner[axis];
                    map.nearest(&inward)
                })
                .sum::<f64>()
                / 3.0;
            assert!((map.bilinear(&corner) - mean).abs() < 8.0 * EPS * largest, "{side}: {corner:?}");
        }
    }
}

#[test]
fn lat_long_look_up_is_continuous_across_the_seam_and_at_the_poles() {
    for (width, height) in [(1, 1), (2, 1), (5, 3), (16, 8)] {
        let grid = lat_long(width, height);
        let map = LatLongMap::new(grid, (0..grid.len()).map(rough).collect()).unwrap();
        let largest = map.pixels().iter().copied().fold(0.0, f64::max);
        for v in (1..20).map(|v| f64::from(v) / 20.0) {
            let value = |u: f64| map.bilinear(&naive::lat_long_point(u, v));
            assert!((value(1e-9) - value(1.0 - 1e-9)).abs() < 1e-8 * largest * width as f64);
        }
        for (pole, row) in [(0.0, 0), (1.0, height - 1)] {
            let mean = map.pixels()[row * width..][..width].iter().sum::<f64>() / width as f64;
            for u in (0..16).map(|u| f64::from(u) / 16.0) {
                let beside = map.bilinear(&naive::lat_long_point(u, (pole - 1e-9f64).abs()));
                assert!((beside - mean).abs() < 1e-8 * largest * height as f64, "{width}×{height}: {beside} {mean}");
            }
        }
    }
}

#[test]
fn resampling_by_area_agrees_with_dense_sampling() {
    // A hundred points each way leave an error of a few hundredths of the range where pixels are cut; ten times as
    // many, a tenth.
    let source = LatLongMap::new(lat_long(7, 5), (0..35).map(|i| (rough(i).ln() + 9.0) / 18.0).collect()).unwrap();
    let boxed = CubeMap::new(cube(3), (0..54).map(|i| (rough(i).ln() + 9.0) / 18.0).collect()).unwrap();
    for turn in turns() {
        let mut worst = [0.0f64; 2];
        for (k, samples) in [20, 200].into_iter().enumerate() {
            let to_cube = source.to_cube(cube(2), &turn, Resampling::Area);
            let to_lat_long = boxed.to_lat_long(lat_long(5, 3), &turn, Resampling::Area);
            let turned = boxed.to_cube(cube(2), &turn, Resampling::Area);
            for i in 0..24 {
                let dense = naive::cube_texel_mean(2, i, samples, |d| {
                    source.pixels()[naive::lat_long_nearest([7, 5], &(turn.inverse() * d))]
                });
                worst[k] = worst[k].max((to_cube.texels()[i] - dense).abs());
                let dense = naive::cube_texel_mean(2, i, samples, |d| {
                    boxed.texels()[naive::cube_nearest(3, &(turn.inverse() * d))]
                });
                worst[k] = worst[k].max((turned.texels()[i] - dense).abs());
            }
            for i in 0..15 {
                let dense = naive::lat_long_pixel_mean([5, 3], i, samples, |d| {
                    boxed.texels()[naive::cube_nearest(3, &(turn.inverse() * d))]
                });
                worst[k] = worst[k].max((to_lat_long.pixels()[i] - dense).abs());
            }
        }
        assert!(worst[0] < 3e-2 && worst[1] < 3e-3, "{turn:?}: {worst:?}");
    }
}

#[test]
fn resampling_by_area_does_not_see_how_a_function_is_cut_into_pixels() {
    let coarse = LatLongMap::new(lat_long(6, 5), (0..30).map(rough).collect()).unwrap();
    let fine = {
        let pixels = (0..18 * 15).map(|i| coarse.pixels()[i / 18 / 3 * 6 + i % 18 / 3]).collect();
        LatLongMap::new(lat_long(18, 15), pixels).unwrap()
    };
    let boxed = CubeMap::new(cube(2), (0..24).map(rough).collect()).unwrap();
    let boxed_fine = boxed.resized(cube(6));
    for turn in turns() {
        for side in [1, 2, 5, 16] {
            let (a, b) = (
                coarse.to_cube(cube(side), &turn, Resampling::Area),
                fine.to_cube(cube(side), &turn, Resampling::Area),
            );
            // Overlaps are right to some 1e-15 sr; divided by a texel of 4π/(6·16²) sr.
            assert!(a.relative_eq(&b, 1e-9, 1e-11), "lat-long, {side}, {turn:?}");
            let halves = coarse.to_cube(cube(2 * side), &turn, Resampling::Area).resized(cube(side));
            assert!(a.relative_eq(&halves, 1e-9, 1e-11), "lat-long in two steps, {side}, {turn:?}");
            let (a, b) = (
                boxed.to_cube(cube(side), &turn, Resampling::Area),
                boxed_fine.to_cube(cube(side), &turn, Resampling::Area),
            );
            assert!(a.relative_eq(&b, 1e-9, 1e-11), "cube, {side}, {turn:?}");
        }
        let (a, b) = (
            boxed.to_lat_long(lat_long(9, 4), &turn, Resampling::Area),
            boxed_fine.to_lat_long(lat_long(9, 4), &turn, Resampling::Area),
        );
        assert!(a.relative_eq(&b, 1e-9, 1e-11), "cube to lat-long, {turn:?}");
    }
}

#[test]
fn resizing_is_the_exact_mean_of_what_a_texel_covers() {
    let fine = CubeMap::new(cube(6), (0..216).map(rough).collect()).unwrap();
    let coarse = fine.resized(cube(2));
    for i in 0..24 {
        let (face, x, y) = coarse.grid().texel(i);
        let parts = (0..9).map(|k| (3 * x + k % 3, 3 * y + k / 3));
        let energy: f64 = parts
            .map(|(x, y)| {
                let line = |i| [fine.grid().line(i), fine.grid().line(i + 1)];
                fine.texels()[fine.grid().index(face, x, y)] * naive::solid_angle(line(x), line(y))
            })
            .sum();
        let line = |i| [coarse.grid().line(i), coarse.grid().line(i + 1)];
        let expected = energy / naive::solid_angle(line(x), line(y));
        assert!((coarse.texels()[i] / expected - 1.0).abs() < 1e-13, "texel {i}");
    }
    assert_eq!(fine.resized(cube(6)), fine);
    // By rotation-capable clipping, a turn of nothing at all gives the same.
    let turned = fine.to_cube(cube(4), &Rotation3::from_axis_angle(&Vector3::x_axis(), 1e-300), Resampling::Area);
    assert!(turned.relative_eq(&fine.resized(cube(4)), 0.0, 1e-12));
}

#[test]
fn enlarging_smoothly_leaves_no_blocks() {
    // A linear function of direction is reproduced to second order in the pixel size, the steps of `Area` to first.
    let f = |d: &Vector3<f64>| 2.0 + d.dot(&Vector3::new(0.3, -0.8, 0.5));
    let source = LatLongMap::from_fn(lat_long(32, 16), |d| f(&d));
    let worst = |resampling| {
        let cube = source.to_cube(cube(64), &Rotation3::identity(), resampling);
        let errors = cube.texels().iter().zip(cube.grid().directions()).map(|(t, d)| (t - f(&d)).abs());
        errors.fold(0.0, f64::max)
    };
    let (smooth, area) = (worst(Resampling::Smooth), worst(Resampling::Area));
    assert!(smooth < 0.02 && area > 0.08, "smooth {smooth}, area {area}");
}

#[test]
fn oblong_pixels_fall_back_to_exact_areas() {
    // One pixel of a 1 × 600 map is a band thinner than the gaps between look-ups.
    let grid = lat_long(1, 600);
    for row in [0, 100, 299] {
        let map = LatLongMap::new(grid, (0..600).map(|i| if i == row { 1e4f64 } else { 0.0 }).collect()).unwrap();
        let smooth = map.to_cube(cube(16), &askew(), Resampling::Smooth);
        assert!(smooth == map.to_cube(cube(16), &askew(), Resampling::Area), "row {row}");
    }
}

#[test]
fn light_that_slips_between_look_ups_falls_back_to_exact_areas() {
    // Beside the pole a pixel of 64 × 32 is 1/200 wide, the look-ups of 20² texels 1/25 apart.
    let grid = lat_long(64, 32);
    let mut fallen = 0;
    for at in 0..64 {
        let map = LatLongMap::new(grid, (0..2048).map(|i| if i == at { 1e4f64 } else { 0.0 }).collect()).unwrap();
        let smooth = map.to_cube(cube(20), &askew(), Resampling::Smooth);
        let area = map.to_cube(cube(20), &askew(), Resampling::Area);
        assert!((smooth.integral() / map.integral() - 1.0).abs() < 1e-11, "pixel {at}");
        let brightest = |map: &CubeMap<f64>| map.texels().iter().copied().fold(0.0, f64::max);
        assert!(brightest(&smooth) <= 2.0 * 1e4, "pixel {at}");
        fallen += usize::from(smooth == area);
    }
    assert!((1..64).contains(&fallen), "{fallen} of 64 pixels");
}

#[test]
fn single_precision_keeps_energy_too() {
    let grid = lat_long(256, 128);
    let pixels = (0..grid.len()).map(|i| Vector3::from_fn(|c, _| rough(3 * i + c) as f32)).collect();
    let map = LatLongMap::new(grid, pixels).unwrap();
    for side in [16, 200] {
        for resampling in [Resampling::Area, Resampling::Smooth] {
            let got = map.to_cube(cube(side), &askew(), resampling).integral();
            let error = (got - map.integral()).component_div(&map.integral()).abs().max();
            // Each texel rounds once, to 6e-8; errors average out over hundreds of texels.
            assert!(error < 3e-8, "{side}, {resampling:?}: {error}");
        }
    }
}

#[test]
fn non_finite_pixels_stay_where_they_are() {
    let grid = lat_long(16, 8);
    let map = LatLongMap::new(grid, (0..128).map(|i| if i == 40 { f64::NAN } else { 1.0 }).collect()).unwrap();
    assert_eq!(map.first_not_finite(), Some(40));
    let cube = map.to_cube(cube(4), &Rotation3::identity(), Resampling::Area);
    let tainted = cube.texels().iter().filter(|t| t.is_nan()).count();
    assert!((1..=4).contains(&tainted), "{tainted} texels");
    assert!(cube.first_not_finite().is_some());
}

#[test]
fn planes_come_apart_and_together() {
    let map = CubeMap::from_fn(cube(3), |d| d.into_inner().cast::<f32>());
    let planes = map.planes();
    assert_eq!(planes[1].texels()[7], map.texels()[7].y);
    assert_eq!(CubeMap::from_planes(&planes), Ok(map));
    let [r, g, _] = planes;
    let odd = CubeMap::from_fn(cube(2), |d| d.x as f32);
    assert!(matches!(CubeMap::from_planes(&[r, g, odd]), Err(Error::Length { expected: 3, got: 2, .. })));
}

#[test]
fn maps_combine_texel_by_texel() {
    let x = CubeMap::from_fn(cube(2), |d| d.x);
    let both = x.zip_map(&x.map(|t| Vector3::repeat(2.0 * t)), |a, b| b * a);
    assert!(both.texels().iter().zip(x.texels()).all(|(b, x)| b.z == 2.0 * x * x));
    let panic = std::panic::catch_unwind(|| x.zip_map(&CubeMap::from_fn(cube(3), |d| d.x), |a, _| a));
    assert!(panic.is_err());
}

#[test]
fn wrong_sizes_are_errors() {
    assert!(matches!(CubeMap::new(cube(2), vec![0.0; 23]), Err(Error::Length { expected: 24, got: 23, .. })));
    assert!(matches!(LatLongMap::new(lat_long(2, 2), vec![0.0f32; 5]), Err(Error::Length { expected: 4, got: 5, .. })));
    for (width, height) in [(0, 1), (1, 0), (65537, 1), (1, 65537)] {
        assert!(matches!(LatLongGrid::new(width, height), Err(Error::OutOfRange { .. })), "{width}×{height}");
    }
}

#[test]
fn approximate_equality_sees_values_and_grids() {
    let map = CubeMap::from_fn(cube(2), |d| d.x);
    assert!(map.abs_diff_eq(&map.map(|t| t + 1e-9), 1e-8) && !map.abs_diff_eq(&map.map(|t| t + 1e-7), 1e-8));
    assert!(map.relative_eq(&map.map(|t| t * (1.0 + 1e-9)), 0.0, 1e-8));
    assert!(!map.relative_eq(&map.map(|t| t * (1.0 + 1e-7)), 0.0, 1e-8));
    let flat = |side| CubeMap::new(cube(side), vec![1.0; 6 * side * side]).unwrap();
    assert!(!flat(1).abs_diff_eq(&flat(2), 1.0));
    let image = |w, h| LatLongMap::new(lat_long(w, h), vec![1.0; w * h]).unwrap();
    assert!(!image(4, 1).abs_diff_eq(&image(2, 2), 1.0) && image(4, 1).abs_diff_eq(&image(4, 1), 0.0));
    assert!(!map.map(|_| f64::NAN).abs_diff_eq(&map, 1e9));
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn faces_are_found_as_the_reference_finds_them(d in strategies::direction(), scale in 1e-3..1e3f64) {
        let (face, u, v) = Face::locate(&(*d * scale));
        prop_assert!(u.abs() <= 1.0 && v.abs() <= 1.0);
        let back = naive::cube_point(face as usize, u, v).normalize();
        prop_assert!((back - *d).norm() < 4.0 * EPS);
    }

    #[test]
    fn image_points_and_directions_are_inverse(d in strategies::direction()) {
        let (u, v) = LatLongGrid::locate(&d);
        prop_assert!((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v));
        prop_assert!((LatLongGrid::point(u, v).into_inner() - *d).norm() < 8.0 * EPS);
        prop_assert!((LatLongGrid::point(u, v).into_inner() - naive::lat_long_point(u, v)).norm() < 4.0 * EPS);
    }

    #[test]
    fn the_hemisphere_disk_and_directions_are_inverse(d in strategies::direction()) {
        let p = HemisphereDisk::point(&d);
        prop_assert!((p.norm_squared() - (1.0 - d.z)).abs() < 8.0 * EPS);
        // Beside the nadir the disk's rim is one point of the sphere: √(2 − ρ²) of an error of some eps.
        let bound = if d.z < -0.999 { 1e-7 } else { 64.0 * EPS };
        prop_assert!((HemisphereDisk::direction(&p).into_inner() - *d).norm() < bound);
    }

    #[test]
    fn a_constant_stays_constant_and_integrates_to_the_sphere(
        c in -1e3..1e3f64, side in 1..9usize, width in 1..20usize, height in 1..12usize, turn in strategies::rotation(),
        d in strategies::direction(),
    ) {
        let (boxed, image) = (cube(side), lat_long(width, height));
        let from_cube = CubeMap::from_fn(boxed, |_| c);
        let from_image = LatLongMap::from_fn(image, |_| c);
        let near = |got: f64| (got - c).abs() <= 8.0 * EPS * c.abs();
        prop_assert!((from_cube.integral() - 4.0 * PI * c).abs() <= 1e-12 * c.abs());
        prop_assert!((from_image.integral() - 4.0 * PI * c).abs() <= 1e-12 * c.abs());
        prop_assert!(near(from_cube.bilinear(&d)) && near(from_image.bilinear(&d)));
        for resampling in [Resampling::Area, Resampling::Smooth, Resampling::Bilinear] {
            // Up to 384 terms a mean; the factor of `Smooth` is a quotient of two integrals.
            let near = |got: f64| (got - c).abs() <= if resampling == Resampling::Smooth { 1e-12 } else { 64.0 * EPS } * c.abs();
            prop_assert!(from_image.to_cube(boxed, &turn, resampling).texels().iter().all(|&t| near(t)));
            prop_assert!(from_cube.to_cube(cube(width), &turn, resampling).texels().iter().all(|&t| near(t)));
            prop_assert!(from_cube.to_lat_long(image, &turn, resampling).pixels().iter().all(|&t| near(t)));
        }
    }

    #[test]
    fn energy_is_kept(
        map in strategies::lat_long_map::<f64>(24, 12), boxed in strategies::cube_map::<f64>(6),
        side in 1..12usize, turn in strategies::rotation(),
    ) {
        // Against ∫ |L|: signed maps may integrate to nearly nothing. A turn by 1e-5 rad, where edges nearly lie on
        // grid lines, was seen to lose 1.03e-12; without a turn, or by a large one, it is 1.4e-14 at most.
        let scale = map.map(f64::abs).integral();
        let boxed_scale = boxed.map(f64::abs).integral();
        for resampling in [Resampling::Area, Resampling::Smooth] {
            let got = map.to_cube(cube(side), &turn, resampling).integral();
            prop_assert!((got - map.integral()).abs() <= 5e-12 * scale, "{resampling:?} {got} {}", map.integral());
            let got = boxed.to_cube(cube(side), &turn, resampling).integral();
            prop_assert!((got - boxed.integral()).abs() <= 5e-12 * boxed_scale, "{resampling:?} {got} {}", boxed.integral());
            let got = boxed.to_lat_long(map.grid(), &turn, resampling).integral();
            prop_assert!((got - boxed.integral()).abs() <= 5e-12 * boxed_scale, "{resampling:?} {got} {}", boxed.integral());
        }
    }

    #[test]
    fn values_stay_between_the_least_and_the_largest(
        map in strategies::lat_long_map::<f64>(16, 8), side in 1..6usize, turn in strategies::rotation(),
    ) {
        let range = |v: &[f64]| v.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| (a.min(x), b.max(x)));
        let (low, high) = range(map.pixels());
        let slack = 8.0 * EPS * low.abs().max(high.abs());
        for resampling in [Resampling::Area, Resampling::Bilinear] {
            let (a, b) = range(map.to_cube(cube(side), &turn, resampling).texels());
            prop_assert!(a >= low - slack && b <= high + slack, "{resampling:?}: {a}…{b} from {low}…{high}");
        }
        // `Smooth` may exceed the largest by its factor, but no light becomes negative.
        let (a, _) = range(map.to_cube(cube(side), &turn, Resampling::Smooth).texels());
        prop_assert!(a >= 0.0 || low < 0.0);
    }

    #[test]
    fn turning_a_map_is_turning_the_look_up(
        boxed in strategies::cube_map::<f64>(4), turn in strategies::rotation(), side in 1..5usize,
    ) {
        let turned = boxed.to_cube(cube(side), &turn, Resampling::Bilinear);
        let scale = boxed.texels().iter().fold(0.0, |m: f64, t| m.max(t.abs()));
        for (texel, d) in turned.texels().iter().zip(turned.grid().directions()) {
            let expected = naive::cube_bilinear(boxed.grid().side(), boxed.texels(), &(turn.inverse() * *d));
            // Corners of the square of four are continuous: 1e-15 of direction moves the value by as much.
            prop_assert!((texel - expected).abs() <= 64.0 * EPS * scale, "{texel} {expected}");
        }
    }

    #[test]
    fn quarter_turns_permute_the_texels(
        boxed in strategies::cube_map::<f64>(5), axis in 0..3usize, quarters in 1..4i32,
    ) {
        let mut matrix = haarmonic::nalgebra::Matrix3::identity();
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let (cos, sin) = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][quarters as usize];
        (matrix[(i, i)], matrix[(j, j)], matrix[(j, i)], matrix[(i, j)]) = (cos, cos, sin, -sin);
        let turn = Rotation3::from_matrix_unchecked(matrix);
        let turned = boxed.to_cube(boxed.grid(), &turn, Resampling::Area);
        let largest = boxed.texels().iter().fold(0.0, |m: f64, t| m.max(t.abs()));
        for (texel, d) in turned.texels().iter().zip(turned.grid().directions()) {
            let expected = boxed.nearest(&(turn.inverse() * *d));
            prop_assert!((texel - expected).abs() <= 1e-13 * largest, "{texel} {expected}");
        }
    }

    #[test]
    fn area_there_and_back_is_the_transpose(
        map in strategies::lat_long_map::<f64>(12, 8), boxed in strategies::cube_map::<f64>(4), turn in strategies::rotation(),
    ) {
        // ⟨A map, boxed⟩ on the cube = ⟨map, Aᵀ boxed⟩ on the image: both are Σ overlap · map · boxed.
        let product = map.to_cube(boxed.grid(), &turn, Resampling::Area).zip_map(&boxed, |a, b| a * b).integral();
        let back = boxed.to_lat_long(map.grid(), &turn.inverse(), Resampling::Area);
        let pairs = map.pixels().iter().zip(back.pixels());
        let other = LatLongMap::new(map.grid(), pairs.map(|(a, b)| a * b).collect()).unwrap().integral();
        let bound = map.map(|p| p * p).integral().sqrt() * boxed.map(|t| t * t).integral().sqrt();
        prop_assert!((product - other).abs() <= 1e-12 * bound, "{product} {other}");
    }
}

#[test]
fn cells_of_a_top_face_are_their_integrals() {
    for (size, cells) in [(2.0, 1), (2.0, 7), (3.0, 8), (4.0, 5), (10.0, 16), (0.1, 3)] {
        let face = TopFace::new(size, cells).unwrap();
        let line = |i: usize| size * (i as f64 / cells as f64 - 0.5);
        let (mut all, mut projected) = (0.0, 0.0);
        for (x, y) in (0..face.len()).map(|i| (i % cells, i / cells)) {
            let (u, v) = ([line(x), line(x + 1)], [line(y), line(y + 1)]);
            let (got, want) = (face.solid_angle(x, y), naive::solid_angle(u, v));
            assert!((got - want).abs() <= 4.0 * EPS, "{size}, {cells}: ({x}, {y}): {got} against {want}");
            let (got, want) = (face.projected_solid_angle(x, y), naive::projected_solid_angle(u, v));
            assert!((got - want).abs() <= 4.0 * EPS, "{size}, {cells}: ({x}, {y}): {got} against {want}");
            all += face.solid_angle(x, y);
            projected += face.projected_solid_angle(x, y);
        }
        let n = (cells * cells) as f64;
        assert!((all - face.covered_solid_angle()).abs() <= n * EPS);
        assert!((projected - face.covered_projected_solid_angle()).abs() <= n * EPS);
    }
    // The shares that docs/errata.md has for the thesis' face of size 10, and the face of a cube.
    let (ten, cube_face) = (TopFace::new(10.0, 1).unwrap(), TopFace::new(2.0, 4).unwrap());
    assert!((ten.covered_solid_angle() / (2.0 * PI) - 0.8229).abs() < 5e-5);
    assert!((ten.covered_projected_solid_angle() / PI - 0.9683).abs() < 5e-5);
    assert!((cube_face.covered_solid_angle() - 2.0 * PI / 3.0).abs() < 4.0 * EPS);
    assert_eq!(cube_face.solid_angle(1, 2), cube(4).solid_angle(1, 2));
    // All of the hemisphere but a strip of 4√2/h at the horizon.
    let wide = TopFace::new(1e6, 1).unwrap();
    assert!((2.0 * PI - wide.covered_solid_angle() - 4.0 * 2.0_f64.sqrt() / 5e5).abs() < 1e-13);
    assert!((PI - wide.covered_projected_solid_angle() - (PI + 2.0) * 2e-12).abs() < 1e-14);
}

#[test]
fn top_faces_refuse_what_is_none() {
    for size in [0.0, -2.0, 1e-7, 1e7, f64::NAN, f64::INFINITY] {
        assert!(matches!(TopFace::new(size, 4), Err(Error::OutOfRange { .. })), "{size}");
    }
    for cells in [0, TopFace::MAX_CELLS + 1, usize::MAX] {
        assert!(matches!(TopFace::new(2.0, cells), Err(Error::OutOfRange { .. })), "{cells}");
    }
    let face = TopFace::new(2.0, 4).unwrap();
    for missed in [Vector3::x(), -Vector3::z(), Vector3::new(1.1, 0.0, 1.0), Vector3::repeat(f64::NAN)] {
        assert_eq!(face.nearest(&missed), None, "{missed}");
    }
    assert_eq!(face.nearest(&Vector3::new(1.0, 1.0, 1.0)), Some(15));
    assert_eq!(face.nearest(&Vector3::new(-1.0, -1.0, 1.0)), Some(0));
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn cells_of_a_top_face_hold_their_centres(size in 0.01..100.0_f64, cells in 1..40_usize, at in 0.0..1.0_f64) {
        let face = TopFace::new(size, cells).unwrap();
        let index = (at * face.len() as f64) as usize;
        let direction = face.cell_direction(index);
        prop_assert_eq!(face.nearest(&direction), Some(index));
        let w = face.coordinate(&(direction.into_inner() * 3.0)).unwrap();
        prop_assert!((face.direction(&w).into_inner() - direction.into_inner()).norm() < 1e-14);
    }

    #[test]
    fn the_concentric_square_and_the_hemisphere_are_inverse(x in -1.0..1.0_f64, y in -1.0..1.0_f64) {
        let point = Vector2::new(x, y);
        let disk = ConcentricSquare::to_disk(&point);
        // Squares become circles.
        prop_assert!((disk.norm() - point.amax()).abs() < 4.0 * EPS);
        prop_assert!((ConcentricSquare::from_disk(&disk) - point).norm() < 8.0 * EPS);
        let direction = ConcentricSquare::direction(&point);
        prop_assert!((ConcentricSquare::point(&direction) - point).norm() < 1e-14);
    }
}

/// Areas stay in proportion: a cell of the square, followed along its edges, has its share of the hemisphere's area on
/// the disk.
#[test]
fn cells_of_the_concentric_square_have_equal_solid_angles() {
    let cells = 6;
    let line = |t: f64| 2.0 * t / cells as f64 - 1.0;
    for (i, (x, y)) in (0..cells * cells).map(|i| (i, (i % cells, i / cells))) {
        let centre = Vector2::new(line(x as f64 + 0.5), line(y as f64 + 0.5));
        assert!((ConcentricSquare::point(&ConcentricSquare::cell_direction(cells, i)) - centre).norm() < 1e-14);
    }
    for (x, y) in (0..cells * cells).map(|i| ((i % cells) as f64, (i / cells) as f64)) {
        const STEPS: usize = 400;
        let edge = |k: usize| {
            let (side, t) = (k / STEPS, (k % STEPS) as f64 / STEPS as f64);
            let at = [[x + t, y], [x + 1.0, y + t], [x + 1.0 - t, y + 1.0], [x, y + 1.0 - t]][side % 4];
            ConcentricSquare::to_disk(&Vector2::new(line(at[0]), line(at[1])))
        };
        let area: f64 = (0..4 * STEPS).map(|k| edge(k).perp(&edge(k + 1)) / 2.0).sum();
        let share = 4.0 / (cells * cells) as f64 * PI / 4.0;
        assert!((area / share - 1.0).abs() < 1e-5, "({x}, {y}): {area} against {share}");
        assert!(
            (area / HemisphereDisk::AREA_PER_STERADIAN * ConcentricSquare::AREA_PER_STERADIAN
                / (4.0 / (cells * cells) as f64)
                - 1.0)
                .abs()
                < 1e-5
        );
    }
}

#[test]
fn the_concentric_square_at_its_corners_and_beyond() {
    assert_eq!(ConcentricSquare::to_disk(&Vector2::zeros()), Vector2::zeros());
    assert_eq!(ConcentricSquare::from_disk(&Vector2::zeros()), Vector2::zeros());
    for corner in [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [1.0, 0.0], [0.0, -1.0]] {
        let point = Vector2::from(corner);
        assert!(ConcentricSquare::direction(&point).z.abs() < 4.0 * EPS);
        assert!((ConcentricSquare::point(&ConcentricSquare::direction(&point)) - point).norm() < 8.0 * EPS);
    }
    let nadir = ConcentricSquare::point(&Unit::new_unchecked(-Vector3::z()));
    assert!((nadir.amax() - HemisphereDisk::NADIR_RADIUS).abs() < 4.0 * EPS);
    assert!(ConcentricSquare::to_disk(&Vector2::new(f64::NAN, 0.5)).x.is_nan());
}

const PROJECTIONS: [DiskProjection; 3] =
    [DiskProjection::AngularMap, DiskProjection::SphereMap, DiskProjection::DualParaboloid];

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn disks_and_directions_are_inverse(direction in strategies::direction()) {
        for projection in PROJECTIONS {
            let (disk, point) = projection.point(&direction);
            prop_assert!(disk < projection.disks() && point.norm() <= 1.0 + EPS);
            // What is beside the one direction that is all of the rim is known to the root of the rounding there.
            let point = point / point.norm().max(1.0);
            let back = projection.direction(disk, &point).unwrap();
            let near_rim = 1.0 - point.norm() < 1e-6 && projection != DiskProjection::DualParaboloid;
            let tolerance = if near_rim { 1e-7 } else { 1e-9 };
            prop_assert!((back.into_inner() - direction.into_inner()).norm() < tolerance, "{projection:?} {direction:?}");
            let (_, scaled) = projection.point(&(direction.into_inner() * 1e-150));
            prop_assert!((scaled - projection.point(&direction).1).norm() < 1e-14);
        }
    }

    #[test]
    fn neighbours_of_texels_are_mutual(side in 1..40_usize, at in 0.0..1.0_f64) {
        let grid = cube(side);
        let texel = (at * grid.len() as f64) as usize;
        let neighbours = grid.neighbours(texel);
        for (k, &other) in neighbours.iter().enumerate() {
            prop_assert!(grid.neighbours(other).contains(&texel), "side {side}, texel {texel}, {other}");
            prop_assert!(side == 1 || !neighbours[..k].contains(&other));
            // They touch: their centres are no farther apart than the widest texel is long, and a half.
            let angle = grid.direction(texel).angle(&grid.direction(other));
            prop_assert!(angle > 0.0 && angle < 3.2 / side as f64, "side {side}: {angle}");
        }
    }
}

#[test]
fn disks_show_what_their_formats_say() {
    let at = |projection: DiskProjection, d: [f64; 3]| {
        let (disk, p) = projection.point(&Vector3::from(d));
        (disk, [p.x, p.y])
    };
    let half = 0.5_f64.sqrt();
    for (projection, d, want) in [
        (DiskProjection::AngularMap, [0.0, 0.0, -2.0], (0, [0.0, 0.0])),
        (DiskProjection::AngularMap, [1.0, 0.0, 0.0], (0, [0.5, 0.0])),
        (DiskProjection::AngularMap, [0.0, -1.0, 0.0], (0, [0.0, -0.5])),
        (DiskProjection::AngularMap, [0.0, 0.0, 1.0], (0, [1.0, 0.0])),
        (DiskProjection::SphereMap, [0.0, 0.0, 1.0], (0, [0.0, 0.0])),
        (DiskProjection::SphereMap, [0.0, 3.0, 0.0], (0, [0.0, half])),
        (DiskProjection::SphereMap, [0.0, 0.0, -1.0], (0, [1.0, 0.0])),
        (DiskProjection::DualParaboloid, [0.0, 0.0, -1.0], (0, [0.0, 0.0])),
        (DiskProjection::DualParaboloid, [-1.0, 0.0, 0.0], (0, [-1.0, 0.0])),
        (DiskProjection::DualParaboloid, [0.0, 0.0, 1.0], (1, [0.0, 0.0])),
        (DiskProjection::DualParaboloid, [0.0, 1.0, 1.0], (1, [0.0, (PI / 8.0).tan()])),
    ] {
        let got = at(projection, d);
        assert_eq!(got.0, want.0);
        assert!(
            (got.1[0] - want.1[0]).abs() + (got.1[1] - want.1[1]).abs() < 4.0 * EPS,
            "{projection:?} {d:?}: {got:?}"
        );
    }
    for projection in PROJECTIONS {
        for beyond in [Vector2::new(1.0, 0.1), Vector2::new(f64::NAN, 0.0), Vector2::new(0.0, f64::INFINITY)] {
            assert_eq!(projection.direction(0, &beyond), None);
        }
        assert_eq!(projection.direction(projection.disks(), &Vector2::zeros()), None);
    }
}

/// A smooth light goes to a disk and comes back, the nearer the more pixels there are.
#[test]
fn lights_survive_the_way_over_a_disk() {
    let light = |d: &Vector3<f64>| 2.0 + d.x - 0.5 * d.y * d.z + d.z;
    for projection in PROJECTIONS {
        let error = |side: usize| {
            let map = DiskMap::from_fn(projection, side, |d| light(d)).unwrap();
            let cube = map.to_cube(cube(16));
            let one = |i: usize| (cube.texels()[i] - light(&cube.grid().direction(i))).abs();
            (0..cube.grid().len()).map(one).fold(0.0_f64, f64::max)
        };
        let (coarse, fine) = (error(64), error(256));
        // The rim of two of them is one direction: pixels there are long.
        assert!(coarse < 0.2 && fine < 0.5 * coarse, "{projection:?}: {coarse} {fine}");
        let sky = CubeMap::from_fn(cube(64), |d| light(&d));
        let probe = DiskMap::from_cube(projection, 200, &sky).unwrap();
        let up = probe.bilinear(&Vector3::new(0.1, 0.9, -0.2));
        assert!((up - light(&Vector3::new(0.1, 0.9, -0.2).normalize())).abs() < 2e-3, "{projection:?}: {up}");
        assert_eq!(probe.pixels().len(), projection.disks() * 200 * 200);
        assert_eq!(probe.pixels()[0], 0.0);
    }
    for side in [0, DiskMap::<f32>::MAX_SIDE + 1] {
        assert!(matches!(
            DiskMap::new(DiskProjection::SphereMap, side, vec![0.0_f32; 0]),
            Err(Error::OutOfRange { .. })
        ));
        assert!(DiskMap::from_fn(DiskProjection::SphereMap, side, |_| 0.0_f32).is_err());
    }
    let short = DiskMap::new(DiskProjection::DualParaboloid, 2, vec![0.0_f32; 4]);
    assert!(matches!(short, Err(Error::Length { expected: 8, got: 4, .. })));
    // One pixel shows everything; none that shows anything is beside what is asked for.
    let one = DiskMap::new(DiskProjection::AngularMap, 1, vec![7.0_f64]).unwrap();
    assert_eq!(one.bilinear(&Vector3::z()), 7.0);
    let two = DiskMap::new(DiskProjection::SphereMap, 2, vec![1.0_f64, 2.0, 3.0, 4.0]).unwrap();
    assert!((two.bilinear(&Vector3::new(-1.0, 1.0, 0.0)) - 1.0).abs() < 4.0 * EPS);
}
