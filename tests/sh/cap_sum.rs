//! Sums over caps against the naive twin, single calls, and the functions that were tabulated.

use std::f64::consts::{FRAC_PI_2, PI};

use haarmonic::nalgebra::{UnitVector3, Vector3};
use haarmonic::reference::sh as naive;
use haarmonic::sh::{CapFit, CapLog, CapSum, Zonal};
use haarmonic::strategies::discs;
use haarmonic::{Error, Real};
use proptest::prelude::*;

use crate::support::{assert_all_close, assert_below, cases, narrow, random, wide, worst};

/// Slices of coordinates, and angles.
fn split<T: Real>(caps: &[(UnitVector3<f64>, f64)]) -> ([Vec<T>; 3], Vec<T>) {
    let directions = [0, 1, 2].map(|axis| caps.iter().map(|(d, _)| T::of(d[axis])).collect());
    (directions, caps.iter().map(|(_, angle)| T::of(*angle)).collect())
}

fn slices<T>(columns: &[Vec<T>; 3]) -> [&[T]; 3] {
    columns.each_ref().map(|column| &column[..])
}

/// The table's own coefficients, which a sum turns.
fn table<T: Real>(plan: &CapSum<T>) -> impl Fn(f64) -> Vec<f64> + '_ {
    |theta| {
        let mut out = vec![T::nan(); plan.bands()];
        plan.eval(T::of(theta), &mut out);
        wide(&out)
    }
}

/// Σ |f(θ)|, the size of what is added up.
fn size(f: impl Fn(f64) -> Vec<f64>, caps: &[(UnitVector3<f64>, f64)]) -> f64 {
    caps.iter().flat_map(|(_, angle)| f(*angle)).map(f64::abs).sum()
}

/// A plan without a law in its function, with a kink; up to 2.8.
fn plan<T: Real>(bands: usize) -> CapSum<T> {
    CapSum::new(bands, &[0.7, 2.8], 40, |theta, out| {
        for (l, out) in out.iter_mut().enumerate() {
            let kink = (theta.cos() - 0.7f64.cos()).abs();
            *out = (1.0 - theta.cos()) * ((1.0 + l as f64).cos() + theta.cos() * (0.3 - kink * l as f64 / 9.0));
        }
    })
    .unwrap()
}

fn sums_are_the_twins<T: Real>(bands: usize, caps: &[(UnitVector3<f64>, f64)], eps: f64) -> f64 {
    let plan = plan::<T>(bands);
    let (directions, angles) = split::<T>(caps);
    // What was there before stays.
    let mut out = vec![T::of(0.5); bands * bands];
    plan.accumulate(slices(&directions), &angles, &mut out);
    let seen: Vec<_> = caps
        .iter()
        .enumerate()
        .map(|(j, (_, angle))| {
            let direction = Vector3::from([0, 1, 2].map(|axis| directions[axis][j].widen()));
            (UnitVector3::new_normalize(direction), *angle)
        })
        .collect();
    let want: Vec<f64> = naive::cap_sum(bands, table(&plan), &seen).iter().map(|x| x + 0.5).collect();
    let scale = 0.5 * caps.len() as f64 + size(table(&plan), caps);
    worst(&out, &want) / (eps * scale.max(0.5))
}

proptest! {
    #![proptest_config(cases(32))]

    #[test]
    fn sums_are_those_of_the_twin(caps in discs(40), bands in 1..=9usize) {
        // The bound of the page, in eps of what is added up; thousands of cases stay within it.
        let off = sums_are_the_twins::<f64>(bands, &caps, f64::EPSILON);
        prop_assert!(off < 3.0, "f64: {}", off);
        let off = sums_are_the_twins::<f32>(bands, &caps, f64::from(f32::EPSILON));
        prop_assert!(off < 3.0, "f32: {}", off);
    }

    #[test]
    fn spheres_are_the_caps_that_they_are_seen_as(
        caps in discs(20),
        distances in prop::collection::vec(-8.0..8.0f64, 20),
        receiver in prop::array::uniform3(-2.0..2.0f64),
        bands in 1..=7usize,
    ) {
        let plan = plan::<f64>(bands);
        let receiver = Vector3::from(receiver);
        // From 1/256 to 256 away, seen under the angles of the caps.
        let spheres: Vec<_> = caps
            .iter()
            .zip(&distances)
            .map(|((direction, angle), distance)| {
                let distance = distance.exp2();
                // Near a hemisphere an angle is the less known from its sine.
                (receiver + direction.into_inner() * distance, distance * angle.min(1.45).sin())
            })
            .collect();
        let seen: Vec<_> =
            spheres.iter().map(|(centre, radius)| naive::sphere_cap(&(centre - receiver), *radius).unwrap()).collect();
        let want = naive::cap_sum(bands, table(&plan), &seen);
        let centres = [0, 1, 2].map(|axis| spheres.iter().map(|(centre, _)| centre[axis]).collect::<Vec<f64>>());
        let radii: Vec<f64> = spheres.iter().map(|(_, radius)| *radius).collect();
        let mut out = vec![0.0; bands * bands];
        plan.accumulate_spheres(&receiver, slices(&centres), &radii, &mut out);
        let off = worst(&out, &want) / (f64::EPSILON * size(table(&plan), &seen).max(1e-6));
        prop_assert!(off < 20.0, "{}", off);
    }
}

/// Directions all over the sphere and angles below 0, above the largest and between.
fn noise<T: Real>(count: usize, seed: u64) -> ([Vec<T>; 3], Vec<T>) {
    let columns = [0, 1, 2].map(|axis| random(count, seed + axis));
    let directions = (0..count).map(|j| Vector3::from([0, 1, 2].map(|axis| columns[axis][j])).normalize());
    let directions: Vec<_> = directions.collect();
    let angles = random(count, seed + 3).iter().map(|x| T::of(1.4 + 1.6 * x)).collect();
    ([0, 1, 2].map(|axis| directions.iter().map(|d| T::of(d[axis])).collect()), angles)
}

fn batches_have_the_bits_of_one<T: Real>(bands: usize) {
    let plan = plan::<T>(bands);
    let size = bands * bands;
    for count in [0, 1, 2, 7, 8, 9, 16, 17, 33] {
        for caps in [0, 1, 3, 16, 21] {
            let (directions, angles) = noise::<T>(count * caps, 5);
            let before: Vec<T> = narrow(&random(size * count, 6));
            let mut out = before.clone();
            plan.accumulate_batch(count, slices(&directions), &angles, &mut out);
            // The directions as centres, far from some receivers and around others.
            let (receivers, _) = noise::<T>(count, 11);
            let (centres, radii) = (directions.clone().map(|c| c[..caps.min(count * caps)].to_vec()), &angles);
            let radii = &radii[..caps.min(count * caps)];
            let mut spheres = before.clone();
            plan.accumulate_spheres_batch(slices(&receivers), slices(&centres), radii, &mut spheres);
            for v in 0..count {
                let pick = |all: &[T]| all.iter().skip(v).step_by(count).copied().collect::<Vec<T>>();
                let mut one = pick(&before);
                let own = directions.each_ref().map(|column| pick(&column[..]));
                let own_angles = pick(&angles);
                plan.accumulate(slices(&own), &own_angles, &mut one);
                assert_eq!(pick(&out), one, "caps {bands} {count} {caps} {v}");
                let mut one = pick(&before);
                let receiver = Vector3::from([0, 1, 2].map(|axis| receivers[axis][v]));
                plan.accumulate_spheres(&receiver, slices(&centres), radii, &mut one);
                assert_eq!(pick(&spheres), one, "spheres {bands} {count} {caps} {v}");
            }
        }
    }
}

#[test]
fn a_batch_has_the_bits_of_single_calls() {
    for bands in [1, 2, 3, 4, 5, 6, 7, 11] {
        batches_have_the_bits_of_one::<f32>(bands);
        batches_have_the_bits_of_one::<f64>(bands);
    }
}

#[test]
fn the_table_is_as_near_as_it_says() {
    // (bands, fit, error at 256 cells as measured)
    for (bands, fit, measured) in [
        (1, CapFit::default(), 2.32e-5),
        (3, CapFit::default(), 2.74e-4),
        (4, CapFit::default(), 1.37e-3),
        (6, CapFit::default(), 2.56e-3),
        (4, CapFit::Grid, 1.91e-4),
    ] {
        let log = CapLog::new(bands, fit).unwrap();
        let errors = [64, 128, 256, 512].map(|cells| {
            let plan = CapSum::<f64>::of_logarithms(&log, cells).unwrap();
            assert_eq!((plan.bands(), plan.cells(), plan.largest()), (bands, cells, log.largest()));
            let mut worst = 0.0f64;
            for k in 1..20_000 {
                let theta = log.largest() * f64::from(k) / 20_000.0;
                let (mut got, mut want) = (vec![f64::NAN; bands], vec![f64::NAN; bands]);
                plan.eval(theta, &mut got);
                log.eval(theta, &mut want);
                let solid = 2.0 * (0.5 * theta).sin().powi(2);
                worst = got.iter().zip(&want).map(|(got, want)| (got - want).abs() / solid).fold(worst, f64::max);
            }
            // Three points of a cell see almost all of it.
            assert_below(worst, 1.05 * plan.error(), "table");
            assert!(worst >= 0.8 * plan.error(), "{bands} {fit:?} {cells}: {worst:e} {:e}", plan.error());
            plan.error()
        });
        assert!(errors[2] < 1.2 * measured, "{bands} {fit:?}: {errors:?}");
        // At twice the cells a quarter, but for the steps of the logarithm's own table, 1e-6 and 1e-5.
        assert!(errors.windows(2).all(|e| e[1] < 0.4 * e[0] + 2e-5), "{bands} {fit:?}: {errors:?}");
    }
}

#[test]
fn caps_are_caps() {
    let plan = CapSum::<f64>::of_caps(6, 4096).unwrap();
    assert_eq!(plan.largest(), PI);
    for theta in [1e-9, 1e-3, 0.3, 1.0, FRAC_PI_2, 2.0, 3.0, PI] {
        let mut got = [f64::NAN; 6];
        plan.eval(theta, &mut got);
        let want = Zonal::<f64>::cap(6, theta).unwrap().coefficients();
        let solid = 2.0 * (0.5 * theta).sin().powi(2);
        // Relative to the solid angle, however small.
        assert_all_close(&got, &want, 1.1 * plan.error() * solid, &format!("{theta}"));
    }
    assert_below(plan.error(), 1e-5, "error of 4096 cells");
    // Linear in 1 − cos θ is exact.
    assert_below(CapSum::<f64>::of_caps(2, 1).unwrap().error(), 2e-15, "two bands");
}

#[test]
fn a_kink_on_a_knot_costs_nothing() {
    let kinked = |theta: f64, out: &mut [f64]| {
        let u = 2.0 * (0.5 * theta).sin().powi(2);
        let at = |angle: f64| 2.0 * (0.5 * angle).sin().powi(2);
        out.fill(u * (3.0 * (u - at(0.5)).max(0.0) - 5.0 * (u - at(1.3)).max(0.0) + 1.0));
    };
    let with = CapSum::<f64>::new(3, &[0.5, 1.3, 2.0], 7, kinked).unwrap();
    assert_below(with.error(), 1e-14, "with knots");
    let (mut got, mut want) = ([f64::NAN; 3], [f64::NAN; 3]);
    for k in 0..=200 {
        let theta = 0.01 * f64::from(k);
        with.eval(theta, &mut got);
        kinked(theta, &mut want);
        assert_all_close(&got, &want, 2e-14, &format!("{theta}"));
    }
    assert!(CapSum::<f64>::new(3, &[2.0], 7, kinked).unwrap().error() > 0.05);
}

#[test]
fn angles_are_held_at_the_ends_and_nan_shows() {
    let plan = plan::<f32>(4);
    let at = |theta: f32| {
        let mut out = [0.0; 16];
        plan.accumulate([&[0.6], &[0.0], &[0.8]], &[theta], &mut out);
        out
    };
    assert_eq!(at(0.0), [0.0; 16]);
    assert_eq!(at(-1.0), [0.0; 16]);
    assert_eq!(at(-0.0), [0.0; 16]);
    assert_eq!(at(f32::INFINITY), at(2.8));
    assert_eq!(at(f32::MAX), at(2.8));
    assert!(at(2.7) != at(2.8));
    assert!(at(f32::NAN).iter().all(|c| c.is_nan()));
    assert!(at(1e-30).iter().all(|c| c.is_finite()));
}

#[test]
fn spheres_around_and_at_a_receiver() {
    let (plan, zero) = (plan::<f64>(4), Vector3::zeros());
    let at = |centre: [f64; 3], radius: f64| {
        let mut out = [0.0; 16];
        let [x, y, z] = centre;
        plan.accumulate_spheres(&zero, [&[x], &[y], &[z]], &[radius], &mut out);
        out
    };
    let mut hemisphere = [0.0; 16];
    plan.accumulate([&[0.6], &[0.0], &[-0.8]], &[FRAC_PI_2], &mut hemisphere);
    // On the surface, within it, and with an infinite radius: the hemisphere.
    for (scale, radius) in [(3.0, 3.0), (1e-3, 3.0), (2.0, f64::INFINITY), (1e-100, 1.0)] {
        let got = at([0.6 * scale, 0.0, -0.8 * scale], radius);
        assert_all_close(&got, &hemisphere, 1e-15, &format!("{scale} {radius}"));
    }
    let centre = at([0.0; 3], 1.0);
    assert!((centre[0] - hemisphere[0]).abs() < 1e-15 && centre[1..].iter().all(|c| *c == 0.0));
    for (centre, radius) in [([0.0; 3], 0.0), ([0.0; 3], -1.0), ([1.0, 2.0, 3.0], 0.0), ([1.0, 2.0, 3.0], -4.0)] {
        assert_eq!(at(centre, radius), [0.0; 16], "{centre:?} {radius}");
    }
    for (centre, radius) in [([f64::NAN, 1.0, 1.0], 1.0), ([1.0, 1.0, f64::NAN], 1.0), ([1.0; 3], f64::NAN)] {
        assert!(at(centre, radius).iter().all(|c| c.is_nan()), "{centre:?} {radius}");
    }
    // Small and far: relative accuracy.
    let (near, far) = (at([0.0, 0.0, 1.0], 1e-6), at([0.0, 0.0, 1e60], 1e54));
    assert!(near[0] != 0.0 && (far[0] / near[0] - 1.0).abs() < 1e-14);
}

#[test]
fn constructors_say_what_is_wrong() {
    let flat = |_: f64, out: &mut [f64]| out.fill(0.0);
    let new = |bands, knots: &[f64], cells| CapSum::<f32>::new(bands, knots, cells, flat).map(|_| ());
    let what = |result: Result<(), Error>| match result.unwrap_err() {
        Error::OutOfRange { what, got, .. } => (what, got.to_bits()),
        other => panic!("{other}"),
    };
    for bands in [0, 33] {
        assert_eq!(what(new(bands, &[1.0], 4)), ("bands", (bands as f64).to_bits()));
    }
    assert_eq!(new(2, &[], 4).unwrap_err(), Error::Empty { what: "list of knots" });
    for (knots, wrong) in [
        (&[0.0][..], 0.0),
        (&[-1.0], -1.0),
        (&[f64::NAN], f64::NAN),
        (&[f64::INFINITY], f64::INFINITY),
        (&[3.2], 3.2),
        (&[1.0, 1.0], 1.0),
        (&[1.0, 0.5], 0.5),
    ] {
        assert_eq!(what(new(2, knots, 4)), ("knot of a zonal table", wrong.to_bits()));
    }
    for (knots, cells) in [(&[1.0][..], 0), (&[1.0, 2.0, 3.0], 2), (&[1.0], 65_537)] {
        assert_eq!(what(new(2, knots, cells)), ("cells of a zonal table", (cells as f64).to_bits()));
    }
    assert!(new(32, &[PI], 1).is_ok() && new(1, &[1e-3, 1.0, PI], 3).is_ok() && new(1, &[PI], 65_536).is_ok());
    let infinite = CapSum::<f64>::new(2, &[1.0], 4, |_, out| out.fill(f64::INFINITY));
    assert!(matches!(infinite, Err(Error::NotFinite { .. })));
    // What does not vanish with the solid angle has no limit at 0, but numbers: they are the caller's.
    assert!(CapSum::<f64>::new(2, &[1.0], 4, |_, out| out.fill(1.0)).unwrap().error() > 1.0);
}

#[test]
#[should_panic(expected = "caps, a multiple of the receivers: expected length 4, got 5")]
fn caps_must_be_as_many_for_each_receiver() {
    plan::<f32>(1).accumulate_batch(2, [&[0.0; 5]; 3], &[0.0; 5], &mut [0.0; 2]);
}

#[test]
#[should_panic(expected = "coordinates of directions: expected length 2, got 1")]
fn coordinates_must_be_as_many_as_angles() {
    plan::<f32>(1).accumulate([&[0.0; 2], &[0.0; 1], &[0.0; 2]], &[0.0; 2], &mut [0.0]);
}

#[test]
#[should_panic(expected = "coefficients: expected length 12, got 4")]
fn coefficients_must_be_as_many_as_receivers() {
    plan::<f32>(2).accumulate_spheres_batch([&[0.0; 3]; 3], [&[]; 3], &[], &mut [0.0; 4]);
}

#[test]
#[should_panic(expected = "coordinates of centres: expected length 1, got 2")]
fn centres_must_be_as_many_as_radii() {
    plan::<f32>(1).accumulate_spheres(&Vector3::zeros(), [&[0.0; 1], &[0.0; 2], &[0.0; 1]], &[0.0], &mut [0.0]);
}
