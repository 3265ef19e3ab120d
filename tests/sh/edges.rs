//! Numbers at the ends of their range: what goes in NaN comes out NaN or is refused, what is finite stays so, sizes are
//! checked before memory is taken.

use std::f64::consts::PI;

use haarmonic::nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use haarmonic::sh::*;
use haarmonic::sphere::{CubeGrid, LatLongGrid};
use haarmonic::{Error, Real};

use crate::support::{coefficients, worst};

/// f with a pattern, its largest coefficient `x`.
fn patterns(bands: usize, x: f64) -> [Vec<f64>; 4] {
    let n = bands * bands;
    let f = |value: fn(usize, usize) -> f64| (0..n).map(|i| x * value(i, n)).collect();
    [
        f(|_, _| 1.0),
        f(|i, _| if i % 2 == 0 { 1.0 } else { -1.0 }),
        f(|i, n| if i + 1 == n { 1.0 } else { 0.0 }),
        f(|i, _| if i == 0 { -1.0 } else { 0.5 }),
    ]
}

#[test]
fn exponentials_of_any_finite_logarithm_are_finite() {
    fn check<T: Real>(bands: usize, method: ExpMethod, f: &[f64]) {
        let f: Vec<T> = f.iter().map(|&x| T::of(x)).collect();
        if f.iter().any(|x| !x.is_finite()) {
            return;
        }
        let exp = Exponential::<T>::new(bands, method).unwrap();
        let mut out = vec![T::nan(); f.len()];
        exp.apply(&f, &mut out);
        assert!(out.iter().all(|x| x.is_finite()), "{bands} {method:?} {f:?}: {out:?}");
        // And the same of three at once, the middle one.
        let many: Vec<T> = f.iter().flat_map(|&x| [T::zero(), x, T::one()]).collect();
        let (mut all, mut scratch) = (vec![T::nan(); 3 * f.len()], vec![T::zero(); exp.scratch_len()]);
        exp.apply_batch(3, &many, &mut all, &mut scratch);
        assert!(all.iter().skip(1).step_by(3).eq(out.iter()), "{bands} {method:?} {f:?}");
    }
    let methods =
        [ExpMethod::OptimalLinear, ExpMethod::Hybrid, ExpMethod::Eigen, ExpMethod::Grid, ExpMethod::default()];
    for bands in [1, 2, 4] {
        for method in methods {
            for x in [5e-324, 1e-310, 1e10, 1e30, f64::from(f32::MAX), 1e200, 1e307, f64::MAX] {
                for f in patterns(bands, x) {
                    check::<f64>(bands, method, &f);
                    check::<f32>(bands, method, &f);
                }
            }
        }
    }
}

#[test]
fn exponentials_are_held_at_the_largest_number_and_not_below() {
    let one = (4.0 * PI).sqrt();
    // e^707 times √4π is a number; e^709 times it, and all beyond, is not.
    for method in [ExpMethod::OptimalLinear, ExpMethod::Eigen, ExpMethod::Hybrid, ExpMethod::default()] {
        let exp = Exponential::<f64>::new(2, method).unwrap();
        let constant = |log: f64| {
            let mut out = [0.0; 4];
            exp.apply(&[log * one, 0.0, 0.0, 0.0], &mut out);
            out[0]
        };
        for log in [690.0f64, 704.0, 707.0] {
            let want = (log - 700.0).exp() * one * 700f64.exp();
            // The rounding of the argument times its size.
            assert!((constant(log) / want - 1.0).abs() < 1e-12, "{method:?} {log}");
        }
        assert_eq!([710.0, 1e4, 1e300].map(constant), [f64::MAX; 3], "{method:?}");
    }
    // f̂ is not swallowed by a large factor either: b f̂ e^{f_0} beside a e^{f_0}.
    let linear = Exponential::<f64>::new(2, ExpMethod::OptimalLinear).unwrap();
    let (mut small, mut large) = ([0.0; 4], [0.0; 4]);
    linear.apply(&[0.0, 0.1, 0.0, 0.0], &mut small);
    linear.apply(&[706.0 * one, 0.1, 0.0, 0.0], &mut large);
    assert!((large[1] / large[0] / (small[1] / small[0]) - 1.0).abs() < 1e-14);
}

#[test]
fn optimal_factors_are_numbers_for_any_norm() {
    let linear = OptimalLinear::new(4).unwrap();
    assert_eq!([-0.0, -1.0, -1e300, f64::NEG_INFINITY].map(|x| linear.factors(x)), [[1.0; 2]; 4]);
    let end = linear.factors(linear.end());
    assert_eq!([1e300, f64::MAX, f64::INFINITY].map(|x| linear.factors(x)), [end; 3]);
    assert!(linear.factors(f64::NAN).iter().all(|x| x.is_nan()));
}

#[test]
fn scaled_norms_that_lose_digits_are_refused() {
    let plan = || Exponential::<f64>::new(3, ExpMethod::default()).unwrap();
    for norm in [5e-324, 1e-300, 1e-6, 0.000_999, 8.001, f64::INFINITY, f64::NAN, -0.0] {
        assert!(matches!(plan().with_scaled_norm(norm), Err(Error::OutOfRange { .. })), "{norm}");
    }
    // The least that is allowed keeps the digits that it should: eps ‖f̂‖/norm.
    let f = coefficients(3);
    let (mut out, mut want) = (vec![0.0; 9], vec![0.0; 9]);
    Exponential::new(3, ExpMethod::ScaledSeries { degree: 9 })
        .unwrap()
        .with_scaled_norm(0.001)
        .unwrap()
        .apply(&f, &mut out);
    Exponential::new(3, ExpMethod::ScaledSeries { degree: 9 }).unwrap().apply(&f, &mut want);
    // The truncations of the products differ with the number of squarings: a part in thousand of what each leaves out.
    assert!(worst(&out, &want) < 2e-3, "{}", worst(&out, &want));
}

#[test]
fn windows_of_any_parameter() {
    let kinds: [fn(f64) -> Window; 4] = [
        |width| Window::Hanning { width },
        |width| Window::Lanczos { width },
        |deviation| Window::Gaussian { deviation },
        |lambda| Window::Curvature { lambda },
    ];
    for kind in kinds {
        for x in [0.0, -0.0, 5e-324, 1e-300, 1e-9, 0.5, 1.0, 3.0, 1e9, 1e300, f64::MAX, f64::INFINITY, -1.0, -1e300] {
            for l in [0, 1, 2, 7, 1000, usize::MAX >> 8] {
                let factor = kind(x).factor(l);
                assert!((0.0..=1.0).contains(&factor), "{:?} {l}: {factor}", kind(x));
            }
        }
        // A width of NaN counts as 0; a deviation or λ shows.
        let shows = matches!(kind(1.0), Window::Gaussian { .. } | Window::Curvature { .. });
        assert_eq!(kind(f64::NAN).factor(0), 1.0);
        let mut c = [1.0f32; 9];
        kind(f64::NAN).apply(&mut c);
        assert!(c[0] == 1.0 && c[1..].iter().all(|&c| if shows { c.is_nan() } else { c == 0.0 }));
    }
    for l in 0..40 {
        let wide = [Window::Hanning { width: f64::INFINITY }, Window::Lanczos { width: f64::INFINITY }];
        assert_eq!(wide.map(|w| w.factor(l)), [1.0; 2]);
        // Next to infinite is next to it.
        assert_eq!(Window::Lanczos { width: f64::MAX }.factor(l), 1.0);
        let none = [Window::Gaussian { deviation: 0.0 }, Window::Curvature { lambda: -2.0 }];
        assert_eq!(none.map(|w| w.factor(l)), [1.0; 2]);
    }
}

/// Axes and half turns, about which methods read least of a rotation, and one of no symmetry.
fn rotations() -> Vec<Rotation3<f64>> {
    let turn = |axis: Vector3<f64>, angle: f64| Rotation3::new(axis.normalize() * angle);
    vec![
        Rotation3::identity(),
        turn(Vector3::z(), 0.7),
        turn(Vector3::x(), PI),
        turn(Vector3::y(), PI / 2.0),
        turn(Vector3::new(1.0, -2.0, 0.5), 1.1),
    ]
}

#[test]
fn nan_anywhere_in_a_rotation_is_seen() {
    for bands in [1, 2, 5, 8] {
        let (f, rotator) = (coefficients(bands), Rotator::<f64>::new(bands).unwrap());
        let poisoned = |out: &[f64]| out[0] == f[0] && out[1..].iter().all(|c| c.is_nan());
        for turn in rotations() {
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                for entry in 0..9 {
                    let mut matrix = *turn.matrix();
                    matrix[entry] = bad;
                    let mut out = vec![0.0; f.len()];
                    rotator.apply(&Rotation3::from_matrix_unchecked(matrix), &f, &mut out);
                    assert!(poisoned(&out), "{bands} {matrix}: {out:?}");
                    // In a batch the neighbours do not notice.
                    for count in [1, 3, 11] {
                        let entries: Vec<Vec<f64>> = (0..9)
                            .map(|k| {
                                (0..count)
                                    .map(|v| if v == 1 % count { matrix } else { *turn.matrix() }[(k / 3, k % 3)])
                                    .collect()
                            })
                            .collect();
                        let many: Vec<f64> = f.iter().flat_map(|&x| vec![x; count]).collect();
                        let mut all = vec![0.0; many.len()];
                        rotator.apply_batch(count, std::array::from_fn(|k| &entries[k][..]), &many, &mut all);
                        let of = |v: usize| all.iter().skip(v).step_by(count).copied().collect::<Vec<_>>();
                        assert!(poisoned(&of(1 % count)), "{bands} {matrix}");
                        assert!((0..count).filter(|&v| v != 1 % count).all(|v| of(v).iter().all(|c| c.is_finite())));
                    }
                    assert!(Rotation::<f64>::new(bands, &Rotation3::from_matrix_unchecked(matrix)).is_err());
                }
                let q = UnitQuaternion::from_rotation_matrix(&turn).into_inner().coords;
                for component in 0..4 {
                    let mut coords = q;
                    coords[component] = bad;
                    let mut out = vec![0.0; f.len()];
                    rotator.apply_quaternion(&UnitQuaternion::new_unchecked(Quaternion { coords }), &f, &mut out);
                    assert!(poisoned(&out), "{bands} {coords}: {out:?}");
                    let count = 9;
                    let columns: Vec<Vec<f64>> =
                        (0..4).map(|k| (0..count).map(|v| if v == 4 { coords[k] } else { q[k] }).collect()).collect();
                    let many: Vec<f64> = f.iter().flat_map(|&x| vec![x; count]).collect();
                    let mut all = vec![0.0; many.len()];
                    rotator.apply_quaternion_batch(count, std::array::from_fn(|k| &columns[k][..]), &many, &mut all);
                    let of = |v: usize| all.iter().skip(v).step_by(count).copied().collect::<Vec<_>>();
                    assert!(poisoned(&of(4)), "{bands} {coords}");
                    assert!((0..count).filter(|&v| v != 4).all(|v| of(v).iter().all(|c| c.is_finite())));
                }
            }
        }
    }
}

#[test]
fn quaternions_of_any_length_are_the_same_rotation() {
    fn check<T: Real + haarmonic::nalgebra::RealField>(scales: &[f64], tolerance: f64) {
        for bands in [2, 4, 8] {
            let rotator = Rotator::<T>::new(bands).unwrap();
            let f: Vec<T> = coefficients(bands).into_iter().map(<T as Real>::of).collect();
            for turn in rotations() {
                let q = UnitQuaternion::from_rotation_matrix(&turn).into_inner().coords;
                let by = |scale: f64| {
                    let coords = q.map(|c| <T as Real>::of(c * scale));
                    let mut out = vec![<T as Real>::of(f64::NAN); f.len()];
                    rotator.apply_quaternion(&UnitQuaternion::new_unchecked(Quaternion { coords }), &f, &mut out);
                    let mut batch = out.clone();
                    rotator.apply_quaternion_batch(
                        1,
                        [0, 1, 2, 3].map(|k| std::slice::from_ref(&coords[k])),
                        &f,
                        &mut batch,
                    );
                    [out, batch]
                };
                let want: Vec<f64> = by(1.0)[0].iter().map(|x| Real::widen(*x)).collect();
                for &scale in scales {
                    for out in by(scale) {
                        assert!(worst(&out, &want) <= tolerance, "{bands} {turn} {scale:e}: {}", worst(&out, &want));
                    }
                }
            }
        }
    }
    check::<f64>(&[1e-300, 1e-160, 1e-80, 1e-20, 1e-3, 7.0, 1e6, 1e20, 1e80, 1e160, 1e300], 2e-14);
    check::<f32>(&[1e-30, 1e-20, 1e-10, 1e-3, 7.0, 1e6, 1e10, 1e20, 1e30], 1e-5);
}

#[test]
fn a_matrix_of_zeros_is_still_no_turn() {
    let f = coefficients(4);
    let mut out = vec![f64::NAN; 16];
    Rotator::new(4).unwrap().apply(&Rotation3::from_matrix_unchecked(Matrix3::zeros()), &f, &mut out);
    assert_eq!(out, f);
}

/// A square of directions, its corners at these distances from the origin.
fn square(distances: [f64; 4]) -> [Vector3<f64>; 4] {
    let corners = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
    std::array::from_fn(|k| Vector3::new(corners[k][0], corners[k][1], 1.0) * distances[k])
}

fn polygon<T: Real>(bands: usize, vertices: &[Vector3<T>], horizon: Option<&Vector3<T>>) -> (Vec<T>, T) {
    let light = PolygonLight::new(bands).unwrap();
    let mut out = vec![T::nan(); bands * bands];
    let angle = light.eval(vertices, horizon, &mut out, &mut light.scratch());
    (out, angle)
}

#[test]
fn polygons_with_vertices_at_any_distance_are_the_same() {
    let bands = 5;
    let (want, angle) = polygon(bands, &square([1.0; 4]), None);
    assert!((angle - 2.0 * PI / 3.0).abs() < 1e-14);
    let tilted = Vector3::new(0.3, 0.9, 0.2);
    let (cut, _) = polygon(bands, &square([1.0; 4]), Some(&tilted));
    let far: [[f64; 4]; 12] = [
        [1e200; 4],
        [1e-200; 4],
        [1e300, 1e300, 1e-300, 1e-300],
        [1.0, 1e80, 1e80, 1.0],
        [1.0, 1e160, 1e-160, 1.0],
        [1e-90, 1.0, 1e-90, 1.0],
        [1e-90, 1e-90, 1.0, 1e90],
        [1e308, 1.0, 1.0, 1.0],
        [5e-300, 1.0, 1.0, 1e300],
        [1e30, 1.0, 1e-30, 1.0],
        [1e31, 1.0, 1e-31, 1.0],
        [3.0, 1e-15, 0.5, 1e15],
    ];
    for distances in far {
        let vertices = square(distances);
        let (got, _) = polygon(bands, &vertices, None);
        // Edges of unlike distances round as their cross product does.
        assert!(worst(&got, &want) < 4e-15, "{distances:?}: {}", worst(&got, &want));
        for length in [1e-300, 1e-20, 1.0, 1e20, 1e300] {
            let (got, _) = polygon(bands, &vertices, Some(&(tilted * length)));
            assert!(worst(&got, &cut) < 4e-15, "{distances:?} {length:e}: {}", worst(&got, &cut));
        }
    }
    // In f32, and from many points, one of which overflows the difference.
    let narrow: Vec<Vector3<f32>> = square([1e30, 1e-30, 1.0, 1e38]).iter().map(|v| v.cast()).collect();
    assert!(worst(&polygon(bands, &narrow, None).0, &want) < 1e-6);
    let light = PolygonLight::new(bands).unwrap();
    let points = [Vector3::zeros(), Vector3::new(0.0, 0.0, -1.2e308)];
    let mut out = vec![f64::NAN; 2 * bands * bands];
    let vertices = square([1.0; 4]).map(|v| v.component_mul(&Vector3::new(1.2e308, 1.2e308, 1.0)));
    light.eval_batch(&vertices, &points, None, &mut out, &mut light.scratch());
    assert!(out.iter().all(|x| x.is_finite()));
    // Seen from (0, 0, −h): the same square at the distance of its half side.
    let below: Vec<f64> = out.iter().skip(1).step_by(2).copied().collect();
    assert!(worst(&below, &want) < 4e-15, "{}", worst(&below, &want));
}

#[test]
fn polygons_that_are_none_have_no_light_and_nan_shows() {
    let line = [Vector3::new(1.0, 0.0, 1.0), Vector3::new(0.0, 0.0, 1.0), Vector3::new(-1.0, 0.0, 1.0)];
    let degenerate: [&[Vector3<f64>]; 8] = [
        &[],
        &line[..1],
        &line[..2],
        &line,
        &[line[0]; 5],
        &[Vector3::zeros(); 4],
        &[Vector3::zeros(), line[0], line[2]],
        &[line[0] * 1e200, line[1] * 1e-200, line[2]],
    ];
    let up = Vector3::z();
    for vertices in degenerate {
        for horizon in [None, Some(&up)] {
            let (out, angle) = polygon(4, vertices, horizon);
            assert!(angle.abs() < 1e-15 && out.iter().all(|x| x.abs() < 1e-15), "{vertices:?}: {out:?}");
        }
    }
    // Seen from a vertex: the vertex is left out, what remains is a triangle.
    let from_vertex = [Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
    assert!((polygon::<f64>(4, &from_vertex, None).1 - PI / 2.0).abs() < 1e-15);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for k in 0..12 {
            let mut vertices = square([1.0; 4]);
            vertices[k / 3][k % 3] = bad;
            for horizon in [None, Some(&up), Some(&-up)] {
                let (out, angle) = polygon(3, &vertices, horizon);
                assert!(angle.is_nan() && out.iter().all(|x| x.is_nan()), "{bad} {k}: {out:?}");
            }
        }
        for k in 0..3 {
            let mut horizon = Vector3::new(0.2, 0.3, 0.9);
            horizon[k] = bad;
            let (out, angle) = polygon(3, &square([1.0; 4]), Some(&horizon));
            assert!(angle.is_nan() && out.iter().all(|x| x.is_nan()), "{bad} {k}: {out:?}");
        }
        let light = PolygonLight::new(3).unwrap();
        let mut out = vec![0.0; 18];
        let points = [Vector3::new(0.0, bad, 0.0), Vector3::zeros()];
        light.eval_batch(&square([1.0; 4]), &points, None, &mut out, &mut light.scratch());
        assert!(out.iter().step_by(2).all(|x| x.is_nan()) && out.iter().skip(1).step_by(2).all(|x| x.is_finite()));
    }
    // A normal of no length cuts nothing.
    assert_eq!(polygon(3, &square([1.0; 4]), Some(&Vector3::zeros())), polygon(3, &square([1.0; 4]), None));
}

type Plan = Box<dyn Fn(usize) -> haarmonic::Result<()>>;

fn plan<P>(make: impl Fn(usize) -> haarmonic::Result<P> + 'static) -> Plan {
    Box::new(move |n| make(n).map(drop))
}

/// Every plan whose size is a number of bands, by name.
fn plans() -> Vec<(&'static str, Plan)> {
    let grid = CubeGrid::new(4).unwrap();
    let images = LatLongGrid::new(8, 4).unwrap();
    let light = [1.0f64, 0.5, 0.25, 0.0];
    vec![
        ("Basis", plan(Basis::<f64>::new)),
        ("Basis f32", plan(Basis::<f32>::new)),
        ("eval", plan(|n| eval::<f64>(n, &Vector3::z()))),
        ("Product a", plan(|n| Product::<f64>::new(n, 1, 1))),
        ("Product b", plan(|n| Product::<f32>::new(1, n, 1))),
        ("Product out", plan(|n| Product::<f64>::new(1, 1, n))),
        ("Product all", plan(|n| Product::<f64>::new(n, n, n))),
        ("Square", plan(|n| Square::<f64>::new(n, 1))),
        ("Square out", plan(|n| Square::<f64>::new(1, n))),
        ("TripleTensor", plan(TripleTensor::new)),
        ("Rotator", plan(Rotator::<f64>::new)),
        ("Rotation", plan(|n| Rotation::<f64>::new(n, &Rotation3::identity()))),
        ("Exponential", plan(|n| Exponential::<f64>::new(n, ExpMethod::default()))),
        ("Logarithm", plan(|n| Logarithm::new(n, LogMethod::default()))),
        ("CapLog", plan(|n| CapLog::new(n, CapFit::default()))),
        ("OptimalLinear", plan(OptimalLinear::new)),
        ("GridFunction", plan(GridFunction::<f64>::new)),
        ("GridFunction rings", plan(|n| GridFunction::<f64>::with_rings(2, n))),
        ("ProductSeries", plan(|n| ProductSeries::<f64>::new(n, &[1.0, 1.0], Powers::EvenOdd))),
        ("Zonal cap", plan(|n| Zonal::<f64>::cap(n, 0.3))),
        ("Zonal delta", plan(Zonal::<f64>::delta)),
        ("Zonal outside", plan(|n| Zonal::<f32>::outside_cap(n, 0.3))),
        ("Zonal cosine", plan(Zonal::<f64>::clamped_cosine)),
        ("Zonal power", plan(|n| Zonal::<f64>::cosine_power(n, 3.0))),
        ("Zonal project", plan(|n| Zonal::<f64>::project(n, 4, &[], |t| t))),
        ("Zonal von Mises–Fisher", plan(|n| Zonal::<f64>::von_mises_fisher(n, &VonMisesFisher::new(3.0)?))),
        ("Lights", plan(Lights::<f64>::new)),
        ("PolygonLight", plan(PolygonLight::new)),
        ("DiffuseLight cosine", plan(move |n| DiffuseLight::<f64>::new(&light, n, 2))),
        ("DiffuseLight out", plan(move |n| DiffuseLight::<f64>::new(&light, 2, n))),
        ("CubeProjection", plan(move |n| CubeProjection::<f64>::new(grid, n, TexelRule::Centre))),
        ("CubeReconstruction", plan(move |n| CubeReconstruction::<f64>::new(grid, n, TexelRule::Mean))),
        ("LatLongProjection", plan(move |n| LatLongProjection::<f64>::new(images, n, TexelRule::Mean))),
        ("LatLongReconstruction", plan(move |n| LatLongReconstruction::<f64>::new(images, n, TexelRule::Centre))),
        ("Extrema", plan(Extrema::new)),
        ("Deringing", plan(Deringing::new)),
        ("ScatteredFit", plan(|n| ScatteredFit::new(n, &haarmonic::sphere::fibonacci_directions(8), None, 1e-3))),
        ("monte_carlo", plan(|n| monte_carlo(n, 16, 1, |_| [1.0]))),
    ]
}

#[test]
fn sizes_are_refused_before_memory_is_taken() {
    for (name, make) in plans() {
        let huge = [1 << 17, 1 << 31, (1 << 32) - 1, 1 << 32, usize::MAX / 2, usize::MAX - 1, usize::MAX];
        for n in [0].into_iter().chain(huge) {
            let result = make(n);
            assert!(matches!(result, Err(Error::OutOfRange { .. } | Error::Empty { .. })), "{name} of {n}: {result:?}");
        }
        let small = if name == "GridFunction rings" { 2 } else { 1 };
        assert!(make(small).is_ok(), "{name}: {:?}", make(small));
    }
    let endless = std::iter::repeat(1.0);
    assert!(Zonal::<f64>::from_factors(endless.clone()).is_err() && Zonal::<f64>::from_coefficients(endless).is_err());
    assert!(DiffuseLight::<f64>::new(&[1.0], 1, 64).unwrap().table(CubeGrid::MAX_SIDE).is_err());
    assert!(DiffuseLight::<f64>::new(&[1.0; 4], 100, 100).is_err());
    assert_eq!(coefficient_count(usize::MAX), usize::MAX);
    assert_eq!(degree_order(usize::MAX).0, usize::MAX.isqrt());
}

/// Lengths whose product overflows are lengths that do not fit, in every build profile.
#[test]
fn counts_that_overflow_are_wrong_lengths() {
    let fails = |f: &dyn Fn()| std::panic::catch_unwind(std::panic::AssertUnwindSafe(f)).is_err();
    // Four coefficients each: 2^64 in all, which is 0 if it wraps.
    let count = 1 << (usize::BITS - 2);
    assert!(fails(&|| Product::<f64>::new(2, 2, 2).unwrap().apply_batch(count, &[], &[], &mut [])));
    assert!(fails(&|| Square::<f64>::new(2, 2).unwrap().apply_batch(count, &[], &mut [])));
    assert!(fails(&|| Rotation::<f64>::new(2, &Rotation3::identity()).unwrap().apply_batch(count, &[], &mut [])));
    assert!(fails(&|| Exponential::<f64>::new(2, ExpMethod::Grid).unwrap().apply_batch(count, &[], &mut [], &mut [])));
    assert!(fails(&|| GridFunction::<f64>::new(2).unwrap().apply_batch(count, &[], |x| x, &mut [])));
    assert!(fails(&|| Zonal::<f64>::delta(2).unwrap().convolve_batch(count, &mut [])));
    assert!(fails(&|| drop(Convention::default().export::<f64>(1 << (usize::BITS / 2), &[]))));
    assert!(fails(&|| assert_eq!(index(usize::MAX, 0), 0)));
}

#[test]
fn glowing_spheres_of_any_scale_are_the_same() {
    let lights = Lights::<f64>::new(4).unwrap();
    let at = |scale: f64| {
        let centre = Vector3::new(0.9, 0.9, -0.3) * scale;
        let mut out = [f64::NAN; 16];
        lights.eval(&Light::Sphere { centre, radius: 0.5 * scale }, [1.0], [&mut out]);
        out
    };
    for scale in [1e-300, 1e-160, 1e160, 1e300, 1e308, 1.79e308] {
        assert!(worst(&at(scale), &at(1.0)) < 1e-15, "{scale:e}");
    }
    for bad in [f64::NAN, f64::INFINITY] {
        let mut out = [0.0; 16];
        lights.eval(&Light::Sphere { centre: Vector3::new(bad, 1.0, 0.0), radius: 0.5 }, [1.0], [&mut out]);
        assert!(out.iter().any(|c| c.is_nan()), "{bad}");
        lights.eval(&Light::Cone { axis: Vector3::z(), half_angle: f64::NAN }, [1.0], [&mut out]);
        assert!(out.iter().any(|c| c.is_nan()));
    }
}

#[test]
fn three_bands_of_irradiance_are_off_by_what_the_page_says() {
    let direction = Vector3::new(0.48, -0.6, 0.64);
    let mut light = vec![0.0; 9];
    Lights::<f64>::new(3).unwrap().eval(&Light::Directional { direction }, [1.0], [&mut light]);
    let irradiance = Irradiance::new([&light[..]]);
    let across = direction.cross(&Vector3::z()).normalize();
    let error = |degrees: f64| {
        let normal = Rotation3::new(across * degrees.to_radians()) * direction;
        irradiance.eval(&normal)[0] - normal.dot(&direction).max(0.0)
    };
    // 1/4 + t/2 + 5/32 (3t² − 1) − max(t, 0), t = cos.
    for (degrees, want) in [(0.0, 0.0625), (90.0, 0.09375), (180.0, 0.0625)] {
        assert!((error(degrees) - want).abs() < 1e-14, "{degrees}: {}", error(degrees));
    }
    let least = (8.0f64 / 15.0).acos().to_degrees();
    for degrees in [least, 180.0 - least] {
        assert!((error(degrees) + 0.039_583_333_333_333_33).abs() < 1e-14, "{degrees}: {}", error(degrees));
        assert!((57.5..58.5).contains(&degrees) || (121.5..122.5).contains(&degrees));
    }
    let all = (0..=1800).map(|i| error(0.1 * f64::from(i)));
    let (low, high) = all.fold((0.0f64, 0.0f64), |(low, high), e| (low.min(e), high.max(e)));
    assert!((high - 0.09375).abs() < 1e-9 && (low + 0.039_583_3).abs() < 1e-5, "{low} {high}");
}
