//! Lights, irradiance and light at a normal against golden values, naive twins and closed forms.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};

use haarmonic::Real;
use haarmonic::nalgebra::{UnitVector3, Vector3, Vector4};
use haarmonic::reference::sh as naive;
use haarmonic::sh::{Basis, DiffuseLight, Irradiance, Light, Lights, Measure, Zonal};
use haarmonic::sphere::fibonacci_directions;
use haarmonic::strategies::direction;
use proptest::prelude::*;

use crate::support::{HARMONICS, assert_all_close, assert_close, cases, golden, narrow, numbers, random, wide};

fn unit<T: Real>(lights: &Lights<T>, light: &Light<T>) -> Vec<T> {
    let mut out = vec![T::nan(); lights.bands() * lights.bands()];
    lights.eval(light, [T::one()], [&mut out]);
    out
}

/// The irradiance that reaches a plane facing +z from a light about +z, from all its bands.
fn facing(coefficients: &[f64]) -> f64 {
    naive::irradiance(coefficients, &Vector3::z_axis())
}

#[test]
fn lights_are_their_integrals() {
    const BANDS: usize = 7;
    let lights = Lights::<f64>::new(BANDS).unwrap();
    for axis in fibonacci_directions(7).into_iter().chain([Vector3::z_axis(), -Vector3::z_axis()]) {
        let a = axis.into_inner();
        let cap = |angle: f64| naive::project_cap(BANDS, &axis, angle, 0, |_| 1.0);
        let table = [
            (Light::Ambient, cap(PI)),
            (Light::Directional { direction: a }, naive::basis(BANDS, &axis)),
            (Light::Cone { axis: a, half_angle: 0.4 }, cap(0.4)),
            (Light::Cone { axis: a, half_angle: 2.9 }, cap(2.9)),
            (Light::Sphere { centre: a * 5.0, radius: 3.0 }, cap(0.6f64.asin())),
            (Light::Sphere { centre: a * 1e-160, radius: 0.8e-160 }, cap(0.8f64.asin())),
            (Light::Sphere { centre: a * 2.0, radius: 2.5 }, cap(FRAC_PI_2)),
            (Light::Hemisphere { up: a }, cap(FRAC_PI_2)),
            (Light::Gradient { up: a }, naive::project_cap(BANDS, &axis, PI, 1, |d| 0.5 + 0.5 * d.dot(&axis))),
        ];
        for (light, want) in table {
            // The quadrature's own rounding is the larger part.
            assert_all_close(&unit(&lights, &light), &want, 1e-14, &format!("{light:?}"));
        }
    }
}

#[test]
fn facing_irradiance_is_that() {
    // Enough bands that the kernel's tail is small: 1/2 Σ_{l > bands} (2l+1) l^{−5/2}… times the light's own fall.
    let lights = Lights::<f64>::new(64).unwrap().with_measure(Measure::FacingIrradiance);
    let z = Vector3::z();
    for (light, tolerance) in [
        (Light::Ambient, 1e-14),
        (Light::Gradient { up: z }, 1e-14),
        (Light::Hemisphere { up: z }, 2e-4),
        (Light::Cone { axis: z, half_angle: 1.2 }, 2e-4),
        (Light::Cone { axis: z, half_angle: 2.0 }, 2e-4),
        (Light::Cone { axis: z, half_angle: PI }, 1e-14),
        (Light::Sphere { centre: z * 3.0, radius: 1.5 }, 2e-4),
        (Light::Sphere { centre: z, radius: 3.0 }, 2e-4),
        (Light::Directional { direction: z }, 1e-2),
    ] {
        let e = facing(&unit(&lights, &light));
        assert!((e - 1.0).abs() < tolerance, "{light:?} {e}");
    }
    // Closed, a cone and a sphere are the directional light.
    let directional = unit(&lights, &Light::Directional { direction: z });
    assert_eq!(unit(&lights, &Light::Cone { axis: z, half_angle: 0.0 }), directional);
    assert_eq!(unit(&lights, &Light::Sphere { centre: z * 1e30, radius: 1e-30 }), directional);
    assert_eq!(unit(&lights, &Light::Sphere { centre: z * 3.0, radius: -1.0 }), directional);
}

#[test]
fn three_bands_show_seventeen_sixteenths_of_a_directional_light() {
    for (bands, share) in [(1, 0.25), (2, 0.75), (3, 17.0 / 16.0), (4, 17.0 / 16.0), (5, 31.0 / 32.0), (6, 31.0 / 32.0)]
    {
        let lights = Lights::<f64>::new(bands).unwrap();
        let light = Light::Directional { direction: Vector3::z() };
        assert!((facing(&unit(&lights, &light)) - share).abs() < 2e-15, "{bands}");
        // DirectXMath: what is shown is π.
        let theirs = unit(&lights.with_measure(Measure::DirectXMath), &light);
        assert!((facing(&theirs) - PI).abs() < 1e-14, "{bands}");
    }
}

/// DirectXMath's own formulas, at six bands about +z: ComputeCapInt, its extra factors and its basis.
#[test]
fn the_directxmath_scale_is_theirs() {
    let lights = Lights::<f64>::new(6).unwrap().with_measure(Measure::DirectXMath);
    let cap = |angle: f64| {
        let (s, c) = angle.sin_cos();
        let root = |l: f64| ((2.0 * l + 1.0) * PI).sqrt();
        let c2 = c * c;
        [
            PI.sqrt() * (1.0 - c),
            root(1.0) * s * s / 2.0,
            -root(2.0) * c * (c2 - 1.0) / 2.0,
            root(3.0) * (-0.625 * c2 * c2 + 0.75 * c2 - 0.125),
            -0.375 * PI.sqrt() * 3.0 * c * (7.0 * c2 * c2 - 10.0 * c2 + 3.0) / 3.0,
            root(5.0) * (-21.0 * c2 * c2 * c2 + 35.0 * c2 * c2 - 15.0 * c2 + 1.0) / 16.0,
        ]
    };
    let at_pole = |z: [f64; 6], scale: f64| {
        let mut out = [0.0; 36];
        for (l, z) in z.into_iter().enumerate() {
            let l1 = (2 * l + 1) as f64;
            // fExtraNormFac times their y_l0 at +z is 1.
            out[l * (l + 1)] = z * scale * (4.0 * PI / l1).sqrt() * (l1 / (4.0 * PI)).sqrt();
        }
        out
    };
    let z = Vector3::z();
    for angle in [0.2f64, 1.0, FRAC_PI_2, 2.2] {
        let norm = angle.min(FRAC_PI_2).sin().powi(-2);
        let cone = unit(&lights, &Light::Cone { axis: z, half_angle: angle });
        // Their differences lose 1/sin² θ.
        assert_all_close(&cone, &at_pole(cap(angle), norm), 8e-15 * norm, &format!("cone {angle}"));
    }
    let sphere = unit(&lights, &Light::Sphere { centre: z * 2.0, radius: 1.0 });
    assert_all_close(&sphere, &at_pole(cap((0.5f64).asin()), 1.0), 2e-15, "sphere");
    // A white top: (top + bottom)/2 and the rest, times 2 √π, 2 √(π/3), 3/2 and the extra factors.
    let top = unit(&lights, &Light::Gradient { up: z });
    let want = at_pole([0.5 * 2.0 * PI.sqrt(), 0.5 * 2.0 * (PI / 3.0).sqrt(), 0.0, 0.0, 0.0, 0.0], 1.5);
    assert_all_close(&top, &want, 2e-15, "gradient");
    assert!((facing(&top) / PI - 1.25).abs() < 1e-14, "white reflects 5/4");
}

#[test]
fn channels_and_sums() {
    let lights = Lights::<f32>::new(4).unwrap();
    let light = Light::Cone { axis: Vector3::new(0.6, 0.0, -0.8), half_angle: 0.5 };
    let one = unit(&lights, &light);
    let mut rgb = [[f32::NAN; 16]; 3];
    let [r, g, b] = &mut rgb;
    lights.eval(&light, [3.0, 0.0, -0.5], [r, g, b]);
    for i in 0..16 {
        assert_eq!(rgb.map(|c| c[i]), [3.0 * one[i], 0.0, -0.5 * one[i]]);
    }
    let (mut sum, mut scratch) = (vec![1.0; 16], [0.0; 16]);
    lights.add(&light, [(2.0, &mut sum)], &mut scratch);
    assert!((0..16).all(|i| sum[i] == 1.0 + 2.0 * one[i]));
    lights.eval(&light, [], []);
    lights.add(&light, [], &mut scratch);
    // f32 is f64 narrowed, but for the basis.
    let wide = Lights::<f64>::new(4).unwrap();
    let wide = unit(&wide, &Light::Cone { axis: Vector3::new(0.6, 0.0, -0.8), half_angle: 0.5 });
    assert_all_close(&one, &wide, 3e-7, "f32");
    // The two halves of the sky are the ambient light.
    let up = Vector3::new(0.0, -0.6, 0.8);
    let mut sky = vec![0.0; 16];
    for light in [Light::Hemisphere { up }, Light::Hemisphere { up: -up }] {
        lights.add(&light, [(0.5, &mut sky)], &mut scratch);
    }
    for light in [Light::Gradient { up }, Light::Gradient { up: -up }] {
        lights.add(&light, [(0.5, &mut sky)], &mut scratch);
    }
    assert_all_close(&sky, &unit(&lights, &Light::Ambient).iter().map(|x| x.widen()).collect::<Vec<_>>(), 4e-7, "sky");
}

#[test]
fn degenerate_lights_are_finite_and_nan_shows() {
    for measure in [Measure::Radiance, Measure::FacingIrradiance, Measure::DirectXMath] {
        let lights = Lights::<f64>::new(3).unwrap().with_measure(measure);
        assert_eq!((lights.measure(), lights.bands()), (measure, 3));
        let z = Vector3::z();
        for light in [
            Light::Sphere { centre: Vector3::zeros(), radius: 1.0 },
            Light::Sphere { centre: Vector3::zeros(), radius: 0.0 },
            Light::Sphere { centre: z * 1e300, radius: 1e300 },
            Light::Sphere { centre: z * 1e-300, radius: 1e300 },
            Light::Cone { axis: z, half_angle: -1.0 },
            Light::Cone { axis: z, half_angle: 1e300 },
            Light::Cone { axis: z, half_angle: PI },
            Light::Cone { axis: z, half_angle: 1e-200 },
        ] {
            let out = unit(&lights, &light);
            assert!(out.iter().all(|c| c.is_finite()), "{measure:?} {light:?} {out:?}");
        }
        let inside = unit(&lights, &Light::Sphere { centre: Vector3::zeros(), radius: 1.0 });
        assert!(inside[0] > 0.0 && inside[1..].iter().all(|c| *c == 0.0), "no direction at the centre");
        for light in [
            Light::Cone { axis: z, half_angle: f64::NAN },
            Light::Sphere { centre: z, radius: f64::NAN },
            Light::Sphere { centre: z * f64::NAN, radius: 1.0 },
        ] {
            assert!(unit(&lights, &light).iter().any(|c| c.is_nan()), "{measure:?} {light:?}");
        }
    }
    assert!(Lights::<f64>::new(0).is_err());
}

#[test]
fn irradiance_matrix_is_symmetric_and_has_the_published_constants() {
    // c1…c5 of the paper, for one coefficient at a time; the last digits of c2 and c3 are not rounded right there (…63,
    // …24).
    let form = |i: usize| {
        let mut light = [0.0f64; 9];
        light[i] = 1.0;
        Irradiance::new([&light]).matrix(0)
    };
    let [c1, c2, c3, c4, c5] = [0.429_043, 0.511_664, 0.743_125, 0.886_227, 0.247_708];
    let entries = [
        (0, (3, 3), c4),
        (1, (1, 3), c2),
        (2, (2, 3), c2),
        (3, (0, 3), c2),
        (4, (0, 1), c1),
        (5, (1, 2), c1),
        (6, (2, 2), c3),
        (6, (3, 3), -c5),
        (7, (0, 2), c1),
        (8, (0, 0), c1),
        (8, (1, 1), -c1),
    ];
    for (i, at, want) in entries {
        assert!((form(i)[at] - want).abs() < 1.3e-6, "{i} {at:?}");
    }
    for i in 0..9 {
        assert_eq!(form(i), form(i).transpose());
        let listed = entries.iter().filter(|e| e.0 == i).map(|e| 1 + usize::from(e.1.0 != e.1.1)).sum::<usize>();
        assert_eq!(form(i).iter().filter(|m| **m != 0.0).count(), listed, "{i}");
    }
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn irradiance_is_the_integral(
        normal in direction(),
        bands in 1..=3usize,
        seed in prop::collection::vec(-1.0..1.0f64, 9),
    ) {
        let light = &seed[..bands * bands];
        let want = naive::irradiance(light, &normal);
        let form = Irradiance::new([light, &seed[..0]]);
        let [got, none] = form.eval(&normal);
        // Nine terms of size 1.
        prop_assert!((got - want).abs() < 4e-15 && none == 0.0, "{got} {want}");
        let h = Vector4::new(normal.x, normal.y, normal.z, 1.0);
        prop_assert!((h.dot(&(form.matrix(0) * h)) - want).abs() < 4e-15);
        // The same as convolution and evaluation.
        let mut convolved = light.to_vec();
        Zonal::clamped_cosine(bands).unwrap().convolve(&mut convolved);
        let value = Basis::new(bands).unwrap().dot(&convolved, &normal);
        prop_assert!((value - want).abs() < 4e-15);
    }

    #[test]
    fn irradiance_of_batches_has_the_bits_of_one(
        normals in prop::collection::vec(direction(), 0..40),
        seed in prop::collection::vec(-1.0..1.0f32, 27),
    ) {
        let form = Irradiance::new([&seed[..9], &seed[9..18], &seed[18..]]);
        let [x, y, z] = [0, 1, 2].map(|k| normals.iter().map(|n| n[k] as f32).collect::<Vec<_>>());
        let mut out = [0, 1, 2].map(|_| vec![f32::NAN; x.len()]);
        let [r, g, b] = &mut out;
        form.eval_batch([&x, &y, &z], [r, g, b]);
        for p in 0..x.len() {
            let want = form.eval(&Vector3::new(x[p], y[p], z[p]));
            prop_assert_eq!(out.each_ref().map(|c| c[p]), want);
            let wide: Vec<f64> = seed[..9].iter().map(|c| f64::from(*c)).collect();
            let naive = naive::irradiance(&wide, &normals[p]);
            prop_assert!((f64::from(want[0]) - naive).abs() < 4e-6);
        }
    }
}

#[test]
fn more_than_nine_coefficients_are_cut() {
    let many: Vec<f64> = (0..25).map(|i| f64::from(i).sin()).collect();
    assert_eq!(Irradiance::new([&many]).matrix(0), Irradiance::new([&many[..9]]).matrix(0));
}

#[test]
fn irradiance_of_a_directional_light_is_off_by_the_stated_part() {
    let light = unit(&Lights::<f64>::new(3).unwrap(), &Light::Directional { direction: Vector3::z() });
    let form = Irradiance::new([&light]);
    let worst = (0..=2000)
        .map(|i| {
            let z = f64::from(i) / 1000.0 - 1.0;
            let [e] = form.eval(&Vector3::new((1.0 - z * z).sqrt(), 0.0, z));
            (e - z.max(0.0)).abs()
        })
        .fold(0.0, f64::max);
    assert!((worst - 0.09375).abs() < 1e-3, "{worst}");
}

#[test]
fn golden_clamped_cosine_at_a_normal() {
    let file = golden(HARMONICS, "clamped_cosine");
    let want = numbers(&file["H_eq_5_14_order6"]);
    let normal = UnitVector3::new_normalize(Vector3::from_vec(numbers(&file["N"])));
    let (basis, mut h) = (Basis::<f64>::new(6).unwrap(), vec![0.0; 36]);
    Zonal::clamped_cosine(6).unwrap().scaled(FRAC_1_PI).about(&basis, &normal, &mut h);
    assert_all_close(&h, &want, 1e-15, "H(N)");
}

#[test]
fn light_at_a_normal_is_the_product() {
    for (bands, cosine, out) in [(1, 1, 1), (1, 3, 2), (3, 3, 3), (4, 6, 3), (6, 6, 6), (3, 2, 5)] {
        let light = random(bands * bands, 1);
        let plan = DiffuseLight::new(&light, cosine, out).unwrap();
        assert_eq!((plan.bands(), plan.scratch_len()), ([cosine, out], cosine * cosine));
        let narrow = DiffuseLight::new(&light.iter().map(|c| *c as f32).collect::<Vec<_>>(), cosine, out).unwrap();
        let (mut got, mut scratch) = (vec![f64::NAN; out * out], vec![f64::NAN; cosine * cosine]);
        let (mut got32, mut scratch32) = (vec![f32::NAN; out * out], vec![f32::NAN; cosine * cosine]);
        for normal in fibonacci_directions(5).into_iter().chain([Vector3::z_axis()]) {
            plan.eval(&normal, &mut got, &mut scratch);
            let want = naive::diffuse_light(&light, cosine, &normal, out);
            // Sums of bands_cosine² terms of at most 1.
            assert_all_close(&got, &want, 4e-15, &format!("{bands} {cosine} {out}"));
            narrow.eval(&normal.map(|c| c as f32), &mut got32, &mut scratch32);
            assert_all_close(&got32, &want, 2e-6, &format!("f32, {bands} {cosine} {out}"));
        }
    }
    assert!(DiffuseLight::new(&[1.0; 8], 2, 2).is_err() && DiffuseLight::new(&[1.0; 9], 0, 2).is_err());
    assert!(DiffuseLight::<f64>::new(&[], 2, 2).is_err());
}

#[test]
fn light_at_a_normal_without_blockers_is_irradiance() {
    let light = random(9, 1);
    let plan = DiffuseLight::new(&light, 3, 1).unwrap();
    let (mut out, mut scratch) = ([0.0], [0.0; 9]);
    for normal in fibonacci_directions(9) {
        plan.eval(&normal, &mut out, &mut scratch);
        // g = 1 has √4π in its first coefficient.
        let reflected = out[0] * (4.0 * PI).sqrt();
        assert!((reflected - naive::irradiance(&light, &normal) / PI).abs() < 2e-15);
    }
}

#[test]
fn bands_of_the_cosine_beyond_the_selection_rules_do_not_matter() {
    let light = random(9, 1);
    // 3 + 4 − 1 bands; odd degrees from 3 are empty, so the sixth is not needed.
    let [exact, more] = [6, 9].map(|cosine| DiffuseLight::new(&light, cosine, 4).unwrap());
    let normal = fibonacci_directions(3)[1];
    let mut outs = [[0.0; 16]; 2];
    exact.eval(&normal, &mut outs[0], &mut [0.0; 36]);
    more.eval(&normal, &mut outs[1], &mut [0.0; 81]);
    assert_all_close(&outs[0], &outs[1], 1e-15, "more");
    // And it is the projection of the light times the cosine.
    let value = |d: &UnitVector3<f64>| naive::basis(3, d).iter().zip(&light).map(|(y, l)| y * l).sum::<f64>();
    let want = naive::project_cap(4, &normal, FRAC_PI_2, 3, |d| value(d) * d.dot(&normal) / PI);
    assert_all_close(&outs[0], &want, 2e-15, "projection");
}

/// The largest error of a table of this side over the largest coefficient, of the light that the stated errors are of.
fn table_error(bands: usize, side: usize) -> f64 {
    let light: Vec<f64> = (0..bands * bands).map(|i| (12.9898 * (i + 1) as f64).sin()).collect();
    let plan = DiffuseLight::new(&light, bands, bands).unwrap();
    let table = plan.table(side).unwrap();
    assert_eq!(table.side(), side);
    let (mut direct, mut looked, mut scratch) = ([0; 3].map(|_| vec![0.0; bands * bands])).into();
    let (mut largest, mut worst) = (0.0f64, 0.0f64);
    for normal in fibonacci_directions(3000) {
        plan.eval(&normal, &mut direct, &mut scratch);
        table.lookup(&(normal.into_inner() * 3.0), &mut looked);
        for (a, b) in direct.iter().zip(&looked) {
            (largest, worst) = (largest.max(a.abs()), worst.max((a - b).abs()));
        }
    }
    worst / largest
}

#[test]
fn tables_err_as_stated() {
    // side² · error.
    for (bands, constant) in [(2, 0.68), (3, 1.0), (4, 1.35), (6, 1.2)] {
        let errors = [16, 32, 64].map(|side| table_error(bands, side) * (side * side) as f64);
        assert!(errors.iter().all(|e| (0.9 * constant..1.1 * constant).contains(e)), "{bands} bands: {errors:?}");
    }
    assert!(table_error(1, 1) < 1e-15);
}

#[test]
fn tables_are_exact_at_nodes_and_continuous_over_edges() {
    let plan = DiffuseLight::new(&random(16, 1), 4, 4).unwrap();
    let table = plan.table(4).unwrap();
    let (mut direct, mut looked, mut beside, mut scratch) = ([0.0; 16], [0.0; 16], [0.0; 16], [0.0; 16]);
    for d in [[1.0, 0.5, -1.0], [1.0, 1.0, 1.0], [-0.5, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, -1.0, 0.5]] {
        let d = Vector3::from(d);
        plan.eval(&d.normalize(), &mut direct, &mut scratch);
        table.lookup(&d, &mut looked);
        assert_all_close(&looked, &direct, 1e-15, "node");
    }
    for (d, step) in
        [([1.0, 0.3, 1.0], Vector3::x()), ([0.3, -1.0, 1.0], Vector3::y()), ([-1.0, 1.0, 0.9], Vector3::x())]
    {
        table.lookup(&(Vector3::from(d) + step * 1e-13), &mut looked);
        table.lookup(&(Vector3::from(d) - step * 1e-13), &mut beside);
        assert_all_close(&looked, &beside, 1e-11, "edge");
    }
    table.lookup(&Vector3::new(0.0, f64::NAN, 1.0), &mut looked);
    assert!(looked.iter().all(|c| c.is_nan()));
    approx::assert_abs_diff_eq!(plan.table(4).unwrap(), table, epsilon = 0.0);
    approx::assert_abs_diff_ne!(plan.table(3).unwrap(), table, epsilon = 1.0);
    assert!(plan.table(0).is_err());
}

#[test]
#[should_panic(expected = "coefficients: expected length 9, got 8")]
fn coefficients_of_another_size_panic() {
    Lights::<f64>::new(3).unwrap().eval(&Light::Ambient, [1.0], [&mut [0.0; 8]]);
}

#[test]
#[should_panic(expected = "irradiances: expected length 1, got 2")]
fn irradiances_of_another_number_panic() {
    Irradiance::<f64, 1>::new([&[1.0]]).eval_batch([&[1.0], &[0.0], &[0.0]], [&mut [0.0; 2]]);
}

fn diffuse_batches_have_the_bits_of_one<T: Real>([bands, cosine, out]: [usize; 3], count: usize) {
    let light = |seed| DiffuseLight::new(&narrow::<T>(&random(bands * bands, seed)), cosine, out).unwrap();
    let channels = [light(1), light(2), light(3)];
    let normals: Vec<_> = fibonacci_directions(count.max(1)).into_iter().take(count).collect();
    let [x, y, z] = [0, 1, 2].map(|k| normals.iter().map(|n| T::of(n[k])).collect::<Vec<T>>());
    let visibility = narrow::<T>(&random(out * out * count, 9));
    let mut scratch = vec![T::nan(); channels[0].batch_scratch_len()];
    let mut single = vec![T::nan(); channels[0].scratch_len()];
    let mut many = vec![T::nan(); out * out * count];
    let mut rgb = [0; 3].map(|_| vec![T::nan(); count]);
    let [r, g, b] = &mut rgb;
    let all = channels.each_ref();
    DiffuseLight::integral_batch(all, [&x, &y, &z], &visibility, [r, g, b], &mut scratch);
    for (channel, integrals) in channels.iter().zip(&rgb) {
        channel.eval_batch([&x, &y, &z], &mut many, &mut scratch);
        for v in 0..count {
            let normal = Vector3::new(x[v], y[v], z[v]);
            let pick = |all: &[T]| all.iter().skip(v).step_by(count).copied().collect::<Vec<T>>();
            let mut one = vec![T::nan(); out * out];
            channel.eval(&normal, &mut one, &mut single);
            assert_eq!(pick(&many), one, "{bands} {cosine} {out} {count} {v}");
            let own = pick(&visibility);
            assert_eq!(integrals[v], channel.integral(&normal, &own, &mut scratch));
            let (terms, dot) = wide(&one)
                .iter()
                .zip(wide(&own))
                .fold((0.0, 0.0), |(terms, dot), (a, b)| (terms + (a * b).abs(), dot + a * b));
            let eps = T::epsilon().widen();
            assert_close(integrals[v].widen(), dot, eps * (out * out) as f64 * terms, "dot product");
        }
    }
    // The twin, of the first channel.
    for v in 0..count.min(2) {
        let h = naive::diffuse_light(&wide(&narrow::<T>(&random(bands * bands, 1))), cosine, &normals[v], out);
        let own = visibility.iter().skip(v).step_by(count).map(|x| x.widen());
        let want: f64 = h.iter().zip(own).map(|(h, v)| h * v).sum();
        let tolerance = 8.0 * T::epsilon().widen() * (bands * out * out) as f64;
        assert_close(rgb[0][v].widen(), want, tolerance, "twin");
    }
}

#[test]
fn diffuse_light_in_batches() {
    for bands in [[1, 1, 1], [3, 3, 3], [4, 6, 3], [6, 6, 6], [3, 2, 5]] {
        for count in [0, 1, 2, 15, 16, 17, 40] {
            diffuse_batches_have_the_bits_of_one::<f32>(bands, count);
            diffuse_batches_have_the_bits_of_one::<f64>(bands, count);
        }
    }
    DiffuseLight::<f32>::integral_batch([], [&[]; 3], &[], [], &mut []);
}

#[test]
#[should_panic(expected = "bands of the result: expected length 2, got 3")]
fn channels_have_the_same_bands() {
    let [a, b] = [2, 3].map(|out| DiffuseLight::<f32>::new(&[1.0], 1, out).unwrap());
    DiffuseLight::integral_batch([&a, &b], [&[]; 3], &[], [&mut [], &mut []], &mut [0.0; 16]);
}
