//! Rotation of spherical harmonic expansions against golden values, its naive twin and its theorems.

use haarmonic::Real;
use haarmonic::nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use haarmonic::reference::sh as naive;
use haarmonic::sh::{Product, Rotation, Rotator, degree_order, eval, rotate_z, rotate_z_batch};
use haarmonic::strategies::{direction, rotation};
use proptest::prelude::*;
use serde_json::Value;

use crate::support::{HARMONICS, assert_below, cases, golden, narrow, numbers, worst};

/// No zeros, no pattern, norm about 1 a degree.
fn coefficients(bands: usize) -> Vec<f64> {
    (0..bands * bands).map(|i| (1.0 + 2.3 * i as f64).sin() / (1.0 + degree_order(i).0 as f64).sqrt()).collect()
}

fn apply<T: Real>(plan: &Rotation<T>, f: &[f64]) -> Vec<T> {
    let mut out = vec![T::nan(); f.len()];
    plan.apply(&narrow::<T>(f), &mut out);
    out
}

fn rotated(f: &[f64], turn: &Rotation3<f64>) -> Vec<f64> {
    let mut out = vec![f64::NAN; f.len()];
    Rotator::new(f.len().isqrt()).unwrap().apply(turn, f, &mut out);
    out
}

/// M f by the blocks of the file.
fn golden_rotated(item: &Value, f: &[f64]) -> Vec<f64> {
    let mut out = Vec::new();
    for (l, block) in item["blocks_rowmajor"].as_array().unwrap().iter().enumerate().take(f.len().isqrt()) {
        let rows = numbers(block);
        let f = &f[l * l..(l + 1) * (l + 1)];
        out.extend(rows.chunks_exact(2 * l + 1).map(|row| row.iter().zip(f).map(|(m, f)| m * f).sum::<f64>()));
    }
    out
}

fn golden_errors<T: Real>() -> f64 {
    let (f, mut error) = (coefficients(7), 0f64);
    for item in golden(HARMONICS, "sh_rotation")["items"].as_array().unwrap() {
        let q = numbers(&item["quat_wxyz"]);
        let quaternion = UnitQuaternion::new_unchecked(Quaternion::new(q[0], q[1], q[2], q[3]));
        let matrix = Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(&numbers(&item["R_rowmajor"])));
        for plan in [Rotation::<T>::new(7, &matrix), Rotation::from_quaternion(7, &quaternion)].map(Result::unwrap) {
            for (l, block) in item["blocks_rowmajor"].as_array().unwrap().iter().enumerate() {
                error = error.max(worst(plan.block(l), &numbers(block)));
            }
        }
        for bands in 1..=7 {
            let f = &f[..bands * bands];
            let want = golden_rotated(item, f);
            let (rotator, f) = (Rotator::<T>::new(bands).unwrap(), narrow::<T>(f));
            let mut out = vec![T::nan(); bands * bands];
            rotator.apply(&Rotation3::from_matrix_unchecked(matrix.matrix().map(T::of)), &f, &mut out);
            error = error.max(worst(&out, &want));
            let narrow = UnitQuaternion::new_unchecked(Quaternion::from(quaternion.coords.map(T::of)));
            rotator.apply_quaternion(&narrow, &f, &mut out);
            error = error.max(worst(&out, &want));
        }
    }
    error
}

#[test]
fn golden_rotation() {
    // The golden matrices and quaternions are rounded: l eps/2 and a little arithmetic.
    assert_below(golden_errors::<f64>(), 1e-14, "f64");
    assert_below(golden_errors::<f32>(), 4e-6, "f32");
}

/// Every block against quadrature, degenerate rotations included; and the sums of a Rotator.
fn twin_errors<T: Real>(bands: usize) -> f64 {
    let (f, mut error) = (coefficients(bands), 0f64);
    for turn in turns() {
        // The rotation as T knows it.
        let known = turn.matrix().map(|x| T::of(x));
        let exact = Rotation3::from_matrix_unchecked(known.map(|x| x.widen()));
        let want = naive::rotation(bands, &exact);
        let plan = Rotation::<T>::new(bands, &exact).unwrap();
        for (l, want) in want.iter().enumerate() {
            error = error.max(worst(plan.block(l), want));
        }
        let want: Vec<f64> = (0..bands * bands)
            .map(|i| {
                let l = degree_order(i).0;
                let row = &want[l][(i - l * l) * (2 * l + 1)..][..2 * l + 1];
                row.iter().zip(&f[l * l..]).map(|(m, f)| m * f).sum()
            })
            .collect();
        let mut out = vec![T::nan(); f.len()];
        Rotator::<T>::new(bands).unwrap().apply(&Rotation3::from_matrix_unchecked(known), &narrow::<T>(&f), &mut out);
        error = error.max(worst(&out, &want)).max(worst(&apply(&plan, &f), &want));
    }
    error
}

/// Ordinary rotations, none, half turns, quarter turns, and those whose axis of the second turn is all but lost.
fn turns() -> Vec<Rotation3<f64>> {
    let about = |axis: [f64; 3], angle: f64| Rotation3::new(Vector3::from(axis).normalize() * angle);
    let mut all = vec![
        Rotation3::identity(),
        about([1.0, 2.0, -0.5], 1.1),
        about([-0.3, 0.1, 0.9], 2.9),
        about([1.0, 1.0, 0.0], std::f64::consts::PI),
        about([1e-3, 0.0, 1.0], 2.0),
    ];
    for k in 0..3 {
        let axis = std::array::from_fn(|i| f64::from(u8::from(i == k)));
        all.extend([0.5, 1.0, 1.5].map(|halves| about(axis, halves * std::f64::consts::PI)));
        let half = Matrix3::from_diagonal(&Vector3::from_fn(|i, _| if i == k { 1.0 } else { -1.0 }));
        all.push(Rotation3::from_matrix_unchecked(half));
    }
    for tilt in [1e-300, 1e-20, 1e-12, 1e-7, 1e-4] {
        let turn = about([0.0, 0.0, 1.0], 0.7);
        all.push(about([0.6, -0.8, 0.0], tilt) * turn);
        all.push(about([0.6, -0.8, 0.0], std::f64::consts::PI - tilt) * turn);
    }
    all
}

#[test]
fn twin() {
    for bands in [1, 2, 3, 4, 5, 6, 7, 13] {
        let errors = [twin_errors::<f64>(bands), twin_errors::<f32>(bands)];
        // The twin's own rounding of the direction, l eps/2 times a slope; a f32 matrix is orthogonal to 1e-7 only.
        assert_below(errors[0], 1e-15 * bands as f64, &format!("f64, bands {bands}"));
        assert_below(errors[1], 4e-7 * bands as f64, &format!("f32, bands {bands}"));
    }
}

fn multiply(a: &[f64], b: &[f64], size: usize) -> Vec<f64> {
    (0..size * size).map(|k| (0..size).map(|j| a[k / size * size + j] * b[j * size + k % size]).sum()).collect()
}

/// M(R₁R₂) = M(R₁) M(R₂) and M Mᵀ = 1.
#[test]
fn group_law_and_inverse() {
    for (bands, tolerance, own) in [(16, 1e-14, 1e-14), (64, 3e-14, 4e-14), (128, 8e-14, 8e-14)] {
        let (a, b) = (turns()[1], turns()[2]);
        let [ma, mb, mab] = [a, b, a * b].map(|r| Rotation::<f64>::new(bands, &r).unwrap());
        let back = ma.inverse();
        let (mut law, mut unit) = (0f64, 0f64);
        for l in [bands / 3, bands - 1] {
            let size = 2 * l + 1;
            law = law.max(worst(&multiply(ma.block(l), mb.block(l), size), mab.block(l)));
            let one: Vec<f64> = (0..size * size).map(|k| f64::from(u8::from(k / size == k % size))).collect();
            unit = unit.max(worst(&multiply(ma.block(l), back.block(l), size), &one));
        }
        // Rounding of a, b and a·b moves degree l by l eps or so, as does that of the powers of each turn. Measured:
        // 1.7e-15, 4.1e-15, 1.9e-14; inverse 3.6e-15, 1.2e-14, 2.0e-14.
        assert_below(law, tolerance, "group law");
        assert_below(unit, own, "inverse");
    }
}

/// No rounding where there is nothing to compute.
#[test]
fn identity_and_half_turns_are_exact() {
    for bands in [1, 2, 4, 6, 9, 20] {
        let f = coefficients(bands);
        for k in 0..4 {
            let diagonal = Vector3::from_fn(|i, _| if i == k || k == 3 { 1.0 } else { -1.0 });
            let turn = Rotation3::from_matrix_unchecked(Matrix3::from_diagonal(&diagonal));
            let mut q = [0.0; 4];
            q[k] = 1.0;
            let quaternion = UnitQuaternion::new_unchecked(Quaternion::from(q));
            let mut out = vec![f64::NAN; f.len()];
            Rotator::new(bands).unwrap().apply_quaternion(&quaternion, &f, &mut out);
            assert_eq!(out, rotated(&f, &turn));
            assert_eq!(out, apply::<f64>(&Rotation::new(bands, &turn).unwrap(), &f));
            for i in 0..f.len() {
                let (l, m) = degree_order(i);
                // The parity of y_{lm} in x, in y and in z: the axes that are not kept.
                let odd = [(m < 0) != (m % 2 != 0), m < 0, (l as isize + m) % 2 != 0];
                let flips = (0..3).filter(|&axis| diagonal[axis] < 0.0 && odd[axis]).count();
                assert_eq!(out[i], if flips % 2 == 1 { -f[i] } else { f[i] }, "axis {k}, l {l}, m {m}");
            }
        }
    }
}

/// Rotations of a batch: degenerate ones among ordinary ones.
fn poses(count: usize) -> Vec<Rotation3<f64>> {
    turns().into_iter().cycle().take(count).collect()
}

/// The largest difference in eps between a rotation each and single calls.
fn batch_forms<T: Real>() -> f64 {
    let mut worst = 0f64;
    for bands in [1, 2, 3, 4, 5, 6, 7, 8, 17] {
        let n = bands * bands;
        let (rotator, plan) = (Rotator::<T>::new(bands).unwrap(), Rotation::<T>::new(bands, &turns()[1]).unwrap());
        for count in [0, 1, 3, 4, 7, 8, 9, 15, 16, 17, 33, 40] {
            let f: Vec<T> = (0..n * count).map(|i| T::of((0.1 + 1.7 * i as f64).sin())).collect();
            let rotations: Vec<_> = poses(count).iter().map(|r| r.matrix().map(|x| T::of(x))).collect();
            let quaternions: Vec<_> =
                poses(count).iter().map(|r| UnitQuaternion::from_rotation_matrix(r).coords.map(|x| T::of(x))).collect();
            let q: [Vec<T>; 4] = std::array::from_fn(|k| quaternions.iter().map(|q| q[k]).collect());
            let r: [Vec<T>; 9] = std::array::from_fn(|k| rotations.iter().map(|r| r[(k / 3, k % 3)]).collect());
            let angles: Vec<T> = (0..count).map(|i| T::of(0.3 * i as f64 - 2.0)).collect();
            let [cos, sin] =
                [f64::cos, f64::sin].map(|g| angles.iter().map(|a| T::of(g(a.widen()))).collect::<Vec<T>>());
            let mut outs: [Vec<T>; 4] = std::array::from_fn(|_| vec![T::nan(); n * count]);
            outs[3].copy_from_slice(&f);
            rotator.apply_quaternion_batch(count, q.each_ref().map(|c| &c[..]), &f, &mut outs[0]);
            rotator.apply_batch(count, r.each_ref().map(|c| &c[..]), &f, &mut outs[1]);
            plan.apply_batch(count, &f, &mut outs[2]);
            rotate_z_batch(&cos, &sin, &mut outs[3]);
            for v in 0..count {
                let one: Vec<T> = (0..n).map(|i| f[i * count + v]).collect();
                let mut want: [Vec<T>; 4] = std::array::from_fn(|_| one.clone());
                let quaternion = UnitQuaternion::new_unchecked(Quaternion::from(quaternions[v]));
                rotator.apply_quaternion(&quaternion, &one, &mut want[0]);
                rotator.apply(&Rotation3::from_matrix_unchecked(rotations[v]), &one, &mut want[1]);
                plan.apply(&one, &mut want[2]);
                rotate_z(angles[v], &mut want[3]);
                for (k, (out, want)) in outs.iter().zip(&want).enumerate() {
                    for i in 0..n {
                        let (got, want) = (out[i * count + v], want[i]);
                        // Up to six bands a single rotation takes another way, of a matrix that is one to rounding
                        // only.
                        if k < 2 {
                            worst = worst.max((got - want).abs().widen() / T::epsilon().widen());
                        } else {
                            assert_eq!(got, want, "form {k}, bands {bands}, vector {v} of {count}, {i}");
                        }
                    }
                }
            }
        }
    }
    worst
}

/// Vector by vector, or many at once with padded ends and flat rotations among others.
#[test]
fn every_form_agrees() {
    for (what, off) in [("f32", batch_forms::<f32>()), ("f64", batch_forms::<f64>())] {
        // Measured: 36, of f32 matrices that are orthogonal to rounding, and 19.
        assert_below(off, 100.0, what);
    }
}

/// Of single calls against the twin, in eps of the largest coefficient: by matrix and by quaternion.
fn single_errors<T: Real>(bands: usize) -> [f64; 2] {
    let (f, mut errors) = (coefficients(bands), [0f64; 2]);
    let rotator = Rotator::<T>::new(bands).unwrap();
    let known: Vec<T> = narrow(&f);
    let f: Vec<f64> = known.iter().map(|f| f.widen()).collect();
    let want = |turn: &Rotation3<f64>| -> Vec<f64> {
        let blocks = naive::rotation(bands, turn);
        let row = |i: usize| &blocks[degree_order(i).0][(i - degree_order(i).0.pow(2)) * (2 * degree_order(i).0 + 1)..];
        (0..f.len())
            .map(|i| {
                row(i)
                    .iter()
                    .zip(&f[degree_order(i).0.pow(2)..])
                    .take(2 * degree_order(i).0 + 1)
                    .map(|(m, f)| m * f)
                    .sum()
            })
            .collect()
    };
    for turn in turns() {
        let mut out = vec![T::nan(); f.len()];
        let matrix = turn.matrix().map(|x| T::of(x));
        rotator.apply(&Rotation3::from_matrix_unchecked(matrix), &known, &mut out);
        errors[0] = errors[0].max(worst(&out, &want(&turn)));
        let q = UnitQuaternion::from_rotation_matrix(&turn).coords.map(|x| T::of(x));
        let exact = UnitQuaternion::new_normalize(Quaternion::from(q.map(|x| x.widen())));
        rotator.apply_quaternion(&UnitQuaternion::new_unchecked(Quaternion::from(q)), &known, &mut out);
        errors[1] = errors[1].max(worst(&out, &want(&exact.to_rotation_matrix())));
    }
    errors.map(|error| error / T::epsilon().widen())
}

#[test]
fn singles_are_as_good_as_their_conditions() {
    for bands in 2..=6 {
        let [narrow, wide] = [single_errors::<f32>(bands), single_errors::<f64>(bands)];
        for (what, error) in [("f32", narrow), ("f64", wide)] {
            // Measured: 2 to 7.
            assert_below(error[0], 20.0, &format!("{what}, matrix, bands {bands}"));
            assert_below(error[1], 20.0, &format!("{what}, quaternion, bands {bands}"));
        }
    }
}

/// Beside the rotations that are done without rounding: nothing jumps.
#[test]
fn nearly_flat() {
    let f = coefficients(6);
    let rotator = Rotator::<f32>::new(6).unwrap();
    let narrow: Vec<f32> = narrow(&f);
    for [w, y] in [[0.8f32, 0.0], [0.0, 0.8]] {
        let by = |tilt: f32| {
            // Turns about z and half turns about another axis, tilted.
            let q = if y == 0.0 { [tilt, 0.0, 0.6, w] } else { [0.6, y, tilt, 0.0] };
            let mut out = vec![f32::NAN; f.len()];
            rotator.apply_quaternion(&UnitQuaternion::new_unchecked(Quaternion::from(q)), &narrow, &mut out);
            out
        };
        let flat: Vec<f64> = by(0.0).into_iter().map(f64::from).collect();
        for tilt in [1e-30, 1e-18, 1e-13, 5e-13, 1e-12, 2e-12, 1e-9] {
            assert_below(worst(&by(tilt), &flat), 3e-6, &format!("tilt {tilt:e}"));
        }
    }
}

#[test]
fn input_that_is_not_quite_a_rotation() {
    let f = coefficients(6);
    let rotator = Rotator::<f64>::new(6).unwrap();
    let turn = turns()[1];
    let q = UnitQuaternion::from_rotation_matrix(&turn).into_inner();
    let want = rotated(&f, &turn);
    let by = |q: Quaternion<f64>| {
        let mut out = vec![f64::NAN; f.len()];
        rotator.apply_quaternion(&UnitQuaternion::new_unchecked(q), &f, &mut out);
        out
    };
    for scale in [1e-3, 0.5, -1.0, 7.0, 1e6] {
        assert_below(worst(&by(q * scale), &want), 5e-15, "scaled quaternion");
    }
    assert_eq!(by(Quaternion::new(0.0, 0.0, 0.0, 0.0)), f);
    // A matrix off by δ: a result off by as much, up to the degree.
    for delta in [1e-9, 1e-3, 0.05] {
        let off = turn.matrix() + Matrix3::from_fn(|i, j| delta * ((5 * i + 3 * j) as f64).sin());
        let out = rotated(&f, &Rotation3::from_matrix_unchecked(off));
        assert_below(worst(&out, &want), 20.0 * delta, "matrix");
        assert!(worst(&out, &want) > 0.1 * delta);
        // The plan, and more bands, take some rotation near by: lengths are kept.
        let (f, plan) = (coefficients(8), Rotation::<f64>::new(8, &Rotation3::from_matrix_unchecked(off)).unwrap());
        let (planned, out) = (apply::<f64>(&plan, &f), rotated(&f, &Rotation3::from_matrix_unchecked(off)));
        for l in 0..8 {
            let norm = |c: &[f64]| c[l * l..(l + 1) * (l + 1)].iter().map(|c| c * c).sum::<f64>().sqrt();
            assert_below((norm(&planned) - norm(&f)).abs(), 4e-15, "norm, plan");
            assert_below((norm(&out) - norm(&f)).abs(), if l < 6 { 20.0 * delta } else { 4e-15 }, "norm");
        }
    }
    // Nothing to turn by is no turn.
    let zero = Rotation3::from_matrix_unchecked(Matrix3::zeros());
    assert_eq!(rotated(&f, &zero), f);
}

#[test]
fn nan_is_seen() {
    let f = coefficients(4);
    for k in 0..4 {
        let mut q = [0.5; 4];
        q[k] = f64::NAN;
        let mut out = [0.0; 16];
        let quaternion = UnitQuaternion::new_unchecked(Quaternion::from(q));
        Rotator::new(4).unwrap().apply_quaternion(&quaternion, &f, &mut out);
        assert_eq!(out[0], f[0]);
        assert!(out[1..].iter().all(|c| c.is_nan()));
        assert!(Rotation::<f64>::from_quaternion(4, &quaternion).is_err());
    }
    assert!(Rotation::<f32>::new(4, &Rotation3::from_matrix_unchecked(Matrix3::repeat(f64::INFINITY))).is_err());
    let mut bad = f.clone();
    bad[5] = f64::NAN;
    for (i, c) in rotated(&bad, &turns()[1]).iter().enumerate() {
        assert_eq!(c.is_nan(), degree_order(i).0 == 2);
    }
}

#[test]
fn wrong_sizes_are_refused() {
    for bands in [0, 129] {
        assert!(Rotation::<f64>::new(bands, &Rotation3::identity()).is_err());
        assert!(Rotator::<f32>::new(bands).is_err());
    }
    let (plan, rotator) = (Rotation::<f64>::new(2, &Rotation3::identity()).unwrap(), Rotator::<f64>::new(2).unwrap());
    let fails = |f: &dyn Fn()| std::panic::catch_unwind(std::panic::AssertUnwindSafe(f)).is_err();
    assert!(fails(&|| plan.apply(&[0.0; 3], &mut [0.0; 4])));
    assert!(fails(&|| plan.apply_batch(2, &[0.0; 8], &mut [0.0; 4])));
    assert!(fails(&|| {
        plan.block(2);
    }));
    assert!(fails(&|| rotator.apply(&Rotation3::identity(), &[0.0; 4], &mut [0.0; 9])));
    assert!(fails(&|| rotator.apply_quaternion_batch(1, [&[0.0], &[0.0], &[0.0], &[]], &[0.0; 4], &mut [0.0; 4])));
    assert!(fails(&|| rotator.apply_batch(2, [&[0.0; 2]; 9], &[0.0; 4], &mut [0.0; 8])));
    assert!(fails(&|| rotate_z(1.0, &mut [0.0; 5])));
    assert!(fails(&|| rotate_z_batch(&[1.0], &[], &mut [0.0; 4])));
    assert!(fails(&|| rotate_z_batch(&[1.0; 3], &[0.0; 3], &mut [0.0; 13])));
}

proptest! {
    #![proptest_config(cases(48))]

    /// (Rf)(ω) = f(R⁻¹ω).
    #[test]
    fn moves_the_function(f in (1usize..12).prop_flat_map(haarmonic::strategies::sh_vector::<f64>), turn in rotation(), d in direction()) {
        let bands = f.len().isqrt();
        let value = |f: &[f64], d: &Vector3<f64>| f.iter().zip(eval(bands, d).unwrap()).map(|(f, y)| f * y).sum::<f64>();
        let got = value(&rotated(&f, &turn), &d);
        let want = value(&f, &(turn.inverse() * d.into_inner()));
        // l² eps of the directions' lengths, in a value of at most ‖f‖ bands/√4π.
        let size = f.iter().map(|f| f.abs()).fold(0.0, f64::max) * (bands * bands) as f64;
        prop_assert!((got - want).abs() <= 1e-15 * bands as f64 * size, "{} {}", got, want);
    }

    #[test]
    fn keeps_the_norm_of_every_degree(f in (1usize..20).prop_flat_map(haarmonic::strategies::sh_vector::<f32>), turn in rotation()) {
        let bands = f.len().isqrt();
        let mut out = vec![f32::NAN; f.len()];
        let narrow = Rotation3::from_matrix_unchecked(turn.matrix().map(|x| x as f32));
        Rotator::new(bands).unwrap().apply(&narrow, &f, &mut out);
        let mut by_plan = out.clone();
        Rotation::new(bands, &turn).unwrap().apply(&f, &mut by_plan);
        for l in 0..bands {
            let norm = |c: &[f32]| c[l * l..(l + 1) * (l + 1)].iter().map(|&c| f64::from(c).powi(2)).sum::<f64>().sqrt();
            // Measured: two thirds of it. Tiny ones lose digits below the smallest normal number.
            let tolerance = 5e-7 * (1.0 + l as f64).sqrt() * norm(&f) + 4e-45 * l as f64;
            for out in [&out, &by_plan] {
                prop_assert!((norm(out) - norm(&f)).abs() <= tolerance, "degree {}: {} {}", l, norm(out), norm(&f));
            }
        }
    }

    #[test]
    fn composes_and_returns(a in rotation(), b in rotation(), bands in 1usize..=16) {
        let f = coefficients(bands);
        let plans = [a, b, a * b].map(|r| Rotation::<f64>::new(bands, &r).unwrap());
        let once: Vec<f64> = apply(&plans[2], &f);
        let tolerance = 1.5e-15 * bands as f64;
        prop_assert!(worst(&apply::<f64>(&plans[0], &apply::<f64>(&plans[1], &f)), &once) <= tolerance);
        // Sampling, up to six bands: 6e-15 measured for two rotations.
        let sampled = tolerance + 6e-15;
        prop_assert!(worst(&rotated(&rotated(&f, &b), &a), &once) <= sampled);
        prop_assert!(worst(&apply::<f64>(&plans[0].inverse(), &apply::<f64>(&plans[0], &f)), &f) <= tolerance);
        prop_assert!(worst(&rotated(&rotated(&f, &a), &a.inverse()), &f) <= sampled);
    }

    /// A product that loses nothing can be rotated before or after.
    #[test]
    fn goes_through_products(turn in rotation(), bands in 1usize..6) {
        let out = 2 * bands - 1;
        let product = Product::new(bands, bands, out).unwrap();
        let (f, g) = (coefficients(bands), coefficients(bands + 1)[..bands * bands].to_vec());
        let (mut before, mut after) = (vec![0.0; out * out], vec![0.0; out * out]);
        product.apply(&f, &g, &mut after);
        product.apply(&rotated(&f, &turn), &rotated(&g, &turn), &mut before);
        prop_assert!(worst(&rotated(&after, &turn), &before) <= 2e-15 * bands as f64);
    }

    #[test]
    fn about_z_is_a_rotation(angle in -7.0..7.0f64, bands in 1usize..20) {
        let f = coefficients(bands);
        let mut turned = f.clone();
        rotate_z(angle, &mut turned);
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
        prop_assert!(worst(&turned, &rotated(&f, &turn)) <= 5e-16 * bands as f64);
    }
}
