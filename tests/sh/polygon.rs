//! Polygonal lights against brute force, closed forms and theorems.

use std::f64::consts::{FRAC_PI_2, PI};

use haarmonic::nalgebra::{Rotation3, Vector3};
use haarmonic::reference::sh as naive;
use haarmonic::sh::{Basis, PolygonLight, Sides, Zonal};
use haarmonic::strategies::{direction, rotation, spherical_polygon};
use proptest::prelude::*;

use crate::support::{cases, largest, worst};

fn eval(bands: usize, vertices: &[Vector3<f64>], horizon: Option<&Vector3<f64>>) -> Vec<f64> {
    let light = PolygonLight::new(bands).unwrap();
    let mut out = vec![f64::NAN; bands * bands];
    light.eval(vertices, horizon, &mut out, &mut light.scratch());
    out
}

/// A flat polygon about a point, its vertices at these distances from the middle in turn.
fn star(middle: Vector3<f64>, across: [Vector3<f64>; 2], radii: &[f64]) -> Vec<Vector3<f64>> {
    let point = |(i, r): (usize, &f64)| {
        let (sin, cos) = (2.0 * PI * i as f64 / radii.len() as f64).sin_cos();
        middle + across[0] * (cos * r) + across[1] * (sin * r)
    };
    radii.iter().enumerate().map(point).collect()
}

/// Against brute force: error over the largest coefficient.
#[track_caller]
fn assert_is_brute_force(bands: usize, vertices: &[Vector3<f64>], levels: u32, tolerance: f64) {
    let got = eval(bands, vertices, None);
    let mut want = naive::polygon(bands, vertices, None, levels);
    if want[0] < 0.0 {
        want.iter_mut().for_each(|w| *w = -*w);
    }
    let error = worst(&got, &want) / largest(&want);
    assert!(error < tolerance, "{bands} bands: {error:e}");
    // Degree 0 keeps its digits by itself; brute force sums some 10⁵ terms.
    assert!((got[0] / want[0] - 1.0).abs() < 2e-14, "solid angle: {} {}", got[0], want[0]);
}

const TILTED: [Vector3<f64>; 2] = [Vector3::new(1.0, 0.1, 0.0), Vector3::new(0.0, 1.0, 0.3)];

#[test]
fn polygons_of_any_size_and_shape_are_their_integrals() {
    let middle = Vector3::new(0.3, -0.5, 0.8);
    // The two ways meet at a radius of 1/20 or 1/bands.
    for size in [2.0, 0.5, 0.1, 0.056, 0.044, 0.01, 1e-3, 1e-5, 1e-8] {
        let across = TILTED.map(|t| t * size);
        for radii in [&[1.0, 0.4, 1.1, 0.3, 0.8][..], &[1.0, 0.9, 1.0], &[0.7; 8]] {
            for bands in [1, 2, 3, 6, 11] {
                assert_is_brute_force(
                    bands,
                    &star(middle, across, radii),
                    if size > 1.0 {
                        3
                    } else if size > 0.3 {
                        1
                    } else {
                        0
                    },
                    2e-14,
                );
            }
        }
    }
    // Many bands, about where the ways meet for them, and large.
    for (size, levels) in [(1.0, 3), (0.3, 1), (0.07, 0), (0.06, 0), (0.05, 0)] {
        assert_is_brute_force(18, &star(middle, TILTED.map(|t| t * size), &[1.0, 0.8, 1.0, 0.5]), levels, 2e-14);
    }
}

#[test]
fn polygons_seen_at_a_slant_are_their_integrals() {
    // Almost from within the plane: distances differ tenfold within a small angle. A sliver, too large for the area:
    // the outline is 900 times the solid angle, and so are the roundings.
    let across = [Vector3::new(0.02, 0.0, 0.0), Vector3::new(0.0, 0.01, 4.0)];
    assert_is_brute_force(6, &star(Vector3::new(0.1, 0.0, 5.0), across, &[1.0; 5]), 3, 5e-13);
    // From close by: nearly a hemisphere.
    let across = [Vector3::new(9.0, 0.0, 0.0), Vector3::new(0.0, 9.0, 0.0)];
    assert_is_brute_force(4, &star(Vector3::new(2.0, 1.0, 1.0), across, &[1.0, 0.9, 1.0]), 5, 1e-12);
}

#[test]
fn octants_are_as_integrated_by_hand() {
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let octant = eval(4, &[x, y, z], None);
    let close = |got: f64, want: f64| assert!((got - want).abs() < 2e-15, "{got} {want}");
    close(octant[0], PI / 2.0 / (4.0 * PI).sqrt());
    for i in 1..4 {
        close(octant[i], (0.75 / PI).sqrt() * PI / 4.0);
    }
    // ∫ xy = ∫_0^{π/2} sin³ · ∫ cos sin = 1/3; z² and x² − y² vanish by symmetry.
    for i in [4, 5, 7] {
        close(octant[i], (3.75 / PI).sqrt() / 3.0);
    }
    close(octant[6], 0.0);
    close(octant[8], 0.0);
    // ∫ xyz = 1/4 · 1/2 with y_{3,−2} = √(105/4π) xyz.
    close(octant[10], (26.25 / PI).sqrt() / 8.0);
    // All eight make the sphere, signs and all.
    let mut sum = vec![0.0; 64];
    for s in 0..8 {
        let sign = |k: usize| if s >> k & 1 == 0 { 1.0 } else { -1.0 };
        let part = eval(8, &[x * sign(0), y * sign(1), z * sign(2)], None);
        sum.iter_mut().zip(part).for_each(|(sum, p)| *sum += p);
    }
    close(sum[0], (4.0 * PI).sqrt());
    assert!(largest(&sum[1..]) < 4e-15);
}

#[test]
fn a_hemisphere_is_a_polygon_along_its_rim() {
    let want = Zonal::<f64>::cap(9, FRAC_PI_2).unwrap();
    let mut cap = vec![0.0; 81];
    let basis = Basis::new(9).unwrap();
    for n in [3, 4, 5, 12] {
        let turn = Rotation3::from_euler_angles(0.3, 1.0, -0.4);
        let rim = star(Vector3::zeros(), [turn * Vector3::x(), turn * Vector3::y()], &vec![1.0; n]);
        want.about(&basis, &(turn * Vector3::z()), &mut cap);
        let got = eval(9, &rim, None);
        assert!(worst(&got, &cap) < 1e-14, "{n}: {:e}", worst(&got, &cap));
    }
}

#[test]
fn a_polygon_of_many_sides_tends_to_the_cap() {
    let want = Zonal::<f64>::cap(6, 0.4).unwrap().coefficients();
    let mut errors = [24usize, 48, 96].map(|n| {
        let (sin, cos) = 0.4f64.sin_cos();
        let rim = star(Vector3::z() * cos, [Vector3::x() * sin, Vector3::y() * sin], &vec![1.0; n]);
        let got = eval(6, &rim, None);
        (0..6).map(|l| (got[l * (l + 1)] - want[l]).abs()).fold(0.0, f64::max)
    });
    errors.reverse();
    assert!(
        errors[0] < 2e-3
            && (3.9..4.1).contains(&(errors[1] / errors[0]))
            && (3.9..4.1).contains(&(errors[2] / errors[1]))
    );
}

#[test]
fn sides_and_orientation() {
    // Counterclockwise seen from the origin, which looks along +z: +x is to the left when y is up.
    let front = [Vector3::new(0.0, 0.0, 2.0), Vector3::new(0.0, 1.0, 2.0), Vector3::new(1.0, 0.0, 2.0)];
    let back: Vec<_> = front.iter().rev().copied().collect();
    let light = PolygonLight::new(5).unwrap().with_sides(Sides::Front);
    let both = eval(5, &front, None);
    let (mut seen, mut scratch) = (vec![f64::NAN; 25], light.scratch());
    let angle = light.eval(&front, None, &mut seen, &mut scratch);
    assert_eq!(seen, both);
    assert!(angle > 0.0 && (angle - both[0] * (4.0 * PI).sqrt()).abs() < 1e-15);
    assert_eq!(light.eval(&back, None, &mut seen, &mut scratch), 0.0);
    assert!(seen.iter().all(|c| *c == 0.0));
    assert!(worst(&eval(5, &back, None), &both) < 1e-15);
    // A small one, by area.
    let small = front.map(|v| v + Vector3::z() * 1e3);
    assert!(light.eval(&small, None, &mut seen, &mut scratch) > 4.9e-7);
    assert_eq!(light.eval(&[small[1], small[0], small[2]], None, &mut seen, &mut scratch), 0.0);
}

#[test]
fn horizons_cut_where_they_should() {
    let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vector3::new(x, y, 1.0));
    let up = Vector3::new(1.0, 0.0, 0.0);
    let right = [(0.0, -1.0), (1.0, -1.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Vector3::new(x, y, 1.0));
    let scale = eval(7, &right, None)[0];
    assert!(worst(&eval(7, &square, Some(&up)), &eval(7, &right, None)) < 4e-15 * scale);
    // All above, all below, on the horizon.
    assert_eq!(eval(7, &square, Some(&Vector3::z())), eval(7, &square, None));
    assert_eq!(largest(&eval(7, &square, Some(&-Vector3::z()))), 0.0);
    let flat = square.map(|v| Vector3::new(v.x + 3.0, v.y, 0.0));
    assert!(largest(&eval(7, &flat, Some(&Vector3::z()))) < 1e-15);
    // A comb that falls apart into three teeth.
    let comb: Vec<_> =
        [(-3.0, -2.0), (3.0, -2.0), (3.0, 1.0), (2.0, -1.0), (1.0, 1.0), (0.0, -1.0), (-1.0, 1.0), (-2.0, -1.0)]
            .map(|(x, y)| Vector3::new(x, y, 3.0))
            .to_vec();
    let up = Vector3::new(0.0, 1.0, 0.0);
    let got = eval(6, &comb, Some(&up));
    // Its teeth above y = 0, by hand: crossings half way.
    let teeth = [
        vec![(3.0, 0.0), (3.0, 1.0), (2.5, 0.0)],
        vec![(1.5, 0.0), (1.0, 1.0), (0.5, 0.0)],
        vec![(-0.5, 0.0), (-1.0, 1.0), (-1.5, 0.0)],
        // The edge from (−2, −1) to (−3, −2) stays below.
    ];
    let mut want = vec![0.0; 36];
    for tooth in &teeth {
        let tooth: Vec<_> = tooth.iter().map(|&(x, y)| Vector3::new(x, y, 3.0)).collect();
        want.iter_mut().zip(eval(6, &tooth, None)).for_each(|(w, t)| *w += t);
    }
    assert!(worst(&got, &want) < 1e-15, "{:e}", worst(&got, &want));
    // Brute force, as far as it goes.
    let tilted = Vector3::new(0.2, 1.0, -0.1);
    let mut rough = naive::polygon(6, &comb, Some(tilted), 5);
    let sign = rough[0].signum();
    rough.iter_mut().for_each(|r| *r *= sign);
    let error = worst(&eval(6, &comb, Some(&tilted)), &rough) / rough[0];
    assert!(error < 4e-3, "{error:e}");
}

#[test]
fn degenerate_polygons_are_finite() {
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let zero = Vector3::zeros();
    let cases: [&[Vector3<f64>]; 12] = [
        &[],
        &[x],
        &[x, y],
        &[x, x, x],
        &[x, y, y, x],
        &[zero, zero, zero],
        &[zero, x, y],
        &[zero, x, y, z],
        &[x, -x, y],
        &[x, y, -x, -y],
        &[x * 1e-320, y * 1e-320, z * 1e-320],
        &[x * 1e308, y * 1e308, (x + y) * 1e308],
    ];
    for vertices in cases {
        for bands in [1, 2, 5] {
            let (free, cut) = (eval(bands, vertices, None), eval(bands, vertices, Some(&z)));
            assert!(free.iter().chain(&cut).all(|c| c.is_finite()), "{vertices:?} {free:?} {cut:?}");
        }
    }
    for vertices in &cases[..6] {
        assert!(largest(&eval(4, vertices, None)) < 1e-16, "{vertices:?}");
    }
    let nan = [x, Vector3::new(0.0, f64::NAN, 0.0), z];
    assert!(eval(3, &nan, None).iter().chain(&eval(3, &nan, Some(&z))).all(|c| c.is_nan()));
    assert!(eval(3, &[x * f64::INFINITY, y, z], None).iter().all(|c| c.is_nan()));
    assert!(PolygonLight::new(0).is_err() && PolygonLight::new(129).is_err());
    // Doubled vertices change nothing but rounding.
    assert!(worst(&eval(5, &[x, x, y, z, z], None), &eval(5, &[x, y, z], None)) < 1e-15);
}

#[test]
fn scale_does_not_matter() {
    let v = star(Vector3::new(0.3, -0.5, 0.8), TILTED, &[1.0, 0.4, 1.1, 0.3]);
    let want = eval(6, &v, None);
    for scale in [1e-300, 1e-30, 0.1, 7.0, 1e30, 1e300] {
        let scaled: Vec<_> = v.iter().map(|v| v * scale).collect();
        assert!(worst(&eval(6, &scaled, None), &want) < 2e-15, "{scale}");
    }
    // And not at all by powers of two.
    let doubled: Vec<_> = v.iter().map(|v| v * 1024.0).collect();
    assert_eq!(eval(6, &doubled, None), want);
}

#[test]
fn batches_have_the_bits_of_one() {
    let vertices = star(Vector3::new(0.3, -0.5, 2.0), TILTED, &[1.0, 0.4, 1.1])
        .iter()
        .map(|v| v.map(|c| c as f32))
        .collect::<Vec<_>>();
    let points: Vec<_> = (0..7).map(|i| Vector3::new(0.1 * i as f32, -0.2, 0.05 * i as f32)).collect();
    let normals: Vec<_> = (0..7).map(|i| Vector3::new(i as f32 - 3.0, 0.5, 1.0).normalize()).collect();
    let light = PolygonLight::new(4).unwrap();
    let (mut scratch, mut out, mut one) = (light.scratch(), vec![f32::NAN; 16 * 7], [f32::NAN; 16]);
    for normals in [None, Some(&normals[..])] {
        light.eval_batch(&vertices, &points, normals, &mut out, &mut scratch);
        for p in 0..7 {
            // In f64 the differences are exact.
            let seen: Vec<_> = vertices.iter().map(|v| v.map(f64::from) - points[p].map(f64::from)).collect();
            let mut wide = [f64::NAN; 16];
            light.eval(&seen, normals.map(|n| n[p].map(f64::from)).as_ref(), &mut wide, &mut scratch);
            for i in 0..16 {
                assert_eq!(out[i * 7 + p], wide[i] as f32);
            }
        }
    }
    light.eval_batch(&vertices, &[], None, &mut [], &mut scratch);
    light.eval(&vertices, None, &mut one, &mut scratch);
    let wide = eval(4, &vertices.iter().map(|v| v.map(f64::from)).collect::<Vec<_>>(), None);
    assert!((0..16).all(|i| one[i] == wide[i] as f32));
}

proptest! {
    #![proptest_config(cases(48))]

    /// Rounding goes with the outline, the sum of whose terms the integral is: what is thin has fewer digits.
    #[test]
    fn convex_polygons_are_their_integrals(vertices in spherical_polygon(6), bands in 1..8usize) {
        let v: Vec<Vector3<f64>> = vertices.iter().map(|v| v.into_inner()).collect();
        let next = |i: usize| &v[(i + 1) % v.len()];
        let outline: f64 = (0..v.len()).map(|i| v[i].cross(next(i)).norm().atan2(v[i].dot(next(i)))).sum();
        // Towards a hemisphere the integrand is steep, and brute force sums so many terms that it has fewer digits.
        let (levels, tolerance) = match outline {
            x if x > 3.0 => (5, 1e-12),
            x if x > 1.0 => (3, 2e-14),
            _ => (0, 2e-14),
        };
        let (got, want) = (eval(bands, &v, None), naive::polygon(bands, &v, None, levels));
        prop_assert!(got[0] >= 0.0 && want[0] >= 0.0, "{} {}", got[0], want[0]);
        let error = worst(&got, &want);
        prop_assert!(error <= tolerance * largest(&want) + 1e-15 * outline, "{error:e} of {:e}", largest(&want));
    }

    #[test]
    fn cut_in_two_the_parts_make_the_whole(
        middle in direction(),
        size in -9.0..1.0f64,
        radii in prop::collection::vec(0.2..1.0f64, 3..9),
        normal in direction(),
        bands in 1..12usize,
    ) {
        let a = middle.cross(&Vector3::new(0.6, 0.48, 0.64)).normalize();
        let across = [a, middle.cross(&a)].map(|a| a * size.exp2().powi(3));
        let v = star(middle.into_inner(), across, &radii);
        let whole = eval(bands, &v, None);
        let scale = largest(&whole);
        prop_assert!(whole[0] > 0.0);
        // By any plane through the origin.
        let parts = [eval(bands, &v, Some(&normal)), eval(bands, &v, Some(&-normal))];
        let sum: Vec<f64> = parts[0].iter().zip(&parts[1]).map(|(a, b)| a + b).collect();
        prop_assert!(worst(&sum, &whole) < 1e-14 * scale + 1e-15 * size.exp2().powi(3), "{:e} of {scale:e}", worst(&sum, &whole));
        // A polygon's opposite is its point reflection: odd degrees change sign.
        let opposite = eval(bands, &v.iter().map(|v| -v).collect::<Vec<_>>(), None);
        for (i, (o, w)) in opposite.iter().zip(&whole).enumerate() {
            let sign = if i.isqrt() % 2 == 0 { 1.0 } else { -1.0 };
            prop_assert!((o - sign * w).abs() < 1e-14 * scale);
        }
    }

    #[test]
    fn a_rotated_polygon_has_rotated_values(
        turn in rotation(),
        size in -9.0..1.0f64,
        radii in prop::collection::vec(0.2..1.0f64, 3..7),
        probe in direction(),
    ) {
        const BANDS: usize = 9;
        let across = TILTED.map(|a| a * size.exp2().powi(2));
        let v = star(Vector3::new(0.3, -0.5, 0.8), across, &radii);
        let (still, turned) = (eval(BANDS, &v, None), eval(BANDS, &v.iter().map(|v| turn * v).collect::<Vec<_>>(), None));
        let value = |c: &[f64], d| naive::basis(BANDS, d).iter().zip(c).map(|(y, c)| y * c).sum::<f64>();
        let (a, b) = (value(&still, &probe), value(&turned, &(turn * probe)));
        // The rotated vertices are rounded: eps over the size, relative.
        let tolerance = 4e-15 * 81.0 * largest(&still) + 1e-15 * size.exp2().powi(2);
        prop_assert!((a - b).abs() < tolerance, "{a} {b}");
    }
}

#[test]
#[should_panic(expected = "coefficients: expected length 9, got 4")]
fn coefficients_of_another_size_panic() {
    let light = PolygonLight::new(3).unwrap();
    light.eval(&[Vector3::<f64>::x()], None, &mut [0.0; 4], &mut light.scratch());
}
