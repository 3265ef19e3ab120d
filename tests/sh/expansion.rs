//! Expansions as arrays against naive twins and against the plans.

use haarmonic::Real;
use haarmonic::nalgebra::{Matrix3, Rotation3, UnitQuaternion, UnitVector3, Vector3};
use haarmonic::reference::sh as naive;
use haarmonic::sh::{Expansion, Product, Rotator, Square};
use haarmonic::sphere::fibonacci_directions;

use crate::support::{self, assert_below, wide, worst};

/// Runs a generic function for every array that there is.
macro_rules! for_all {
    ($check: ident) => {
        for_all!($check: f32 f64)
    };
    ($check: ident: $($scalar: ty)*) => {$(
        $check::<$scalar, 1>();
        $check::<$scalar, 4>();
        $check::<$scalar, 9>();
        $check::<$scalar, 16>();
        $check::<$scalar, 25>();
        $check::<$scalar, 36>();
        $check::<$scalar, 49>();
        $check::<$scalar, 64>();
    )*};
}

/// No zeros, no pattern.
fn array<T: Real, const N: usize>(seed: f64) -> [T; N] {
    std::array::from_fn(|i| T::of((seed + 2.3 * i as f64).sin()))
}

fn norm<T: Real, const N: usize>(a: &[T; N]) -> f64 {
    support::norm(&wide(a))
}

fn eps<T: Real>() -> f64 {
    T::epsilon().widen()
}

/// Everywhere, at the poles and on the axes; as `T` has them, of length 1 to rounding.
fn directions<T: Real>() -> Vec<Vector3<T>> {
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let beside = [Vector3::new(1e-4, 0.0, 1.0), Vector3::new(0.0, -1e-3, -1.0)].map(|d: Vector3<f64>| d.normalize());
    let all = axes.into_iter().flat_map(|d| [d, -d]).chain(beside);
    all.chain(fibonacci_directions(500).into_iter().map(UnitVector3::into_inner)).map(|d| d.map(T::of)).collect()
}

fn turns() -> Vec<Rotation3<f64>> {
    let axes = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.1], [std::f64::consts::PI, 0.0, 0.0], [0.3, -1.0, 2.0], [0.0, 0.7, 0.0]];
    axes.into_iter().map(|axis| Rotation3::new(Vector3::from(axis))).collect()
}

#[test]
fn values_are_the_twins() {
    fn check<T: Real, const N: usize>()
    where
        [T; N]: Expansion<Scalar = T>,
    {
        let bands = <[T; N]>::BANDS;
        assert_eq!(bands * bands, N);
        let mut error = 0f64;
        for d in directions::<T>() {
            let exact = UnitVector3::new_normalize(d.map(|x| x.widen()));
            error = error.max(worst(&<[T; N]>::eval(&d), &naive::basis(bands, &exact)));
        }
        assert_below(error, EVAL[bands - 1] * eps::<T>(), &format!("{bands} bands"));
    }
    for_all!(check);
}

/// Twice the error that was measured, in eps: .1, .8, 1.5, 4.1, 4.5, 8, 11.5, 14. It grows as the slope of y, for what
/// is rounded first is the direction.
const EVAL: [f64; 8] = [0.25, 1.5, 3.0, 8.0, 9.0, 16.0, 23.0, 28.0];

#[test]
fn products_and_squares_are_the_twins() {
    fn check<T: Real, const N: usize>()
    where
        [T; N]: Expansion<Scalar = T>,
    {
        for seed in 0..20 {
            let (a, b) = (array::<T, N>(f64::from(seed)), array::<T, N>(0.7 - f64::from(seed)));
            let tolerance = 3.0 * eps::<T>() * norm(&a) * norm(&b).max(norm(&a)) + 3e-15;
            let want = naive::product(&wide(&a), &wide(&b), <[T; N]>::BANDS);
            assert_below(worst(&a.product(&b), &want), tolerance, &format!("product of {N}"));
            let want = naive::product(&wide(&a), &wide(&a), <[T; N]>::BANDS);
            assert_below(worst(&a.square(), &want), tolerance, &format!("square of {N}"));
        }
    }
    for_all!(check);
}

#[test]
fn products_and_integrals_have_the_bits_of_plans() {
    fn check<T: Real, const N: usize>()
    where
        [T; N]: Expansion<Scalar = T>,
    {
        let bands = <[T; N]>::BANDS;
        let (product, square) =
            (Product::<T>::new(bands, bands, bands).unwrap(), Square::<T>::new(bands, bands).unwrap());
        for seed in 0..10 {
            let [a, b, c] = [0.0, 0.4, 0.9].map(|x| array::<T, N>(x + f64::from(seed)));
            let mut out = [T::nan(); N];
            product.apply(&a, &b, &mut out);
            assert_eq!(a.product(&b), out);
            square.apply(&a, &mut out);
            assert_eq!(a.square(), out);
            assert_eq!(a.integral(&b, &c), product.integral(&a, &b, &c));
        }
    }
    for_all!(check);
}

#[test]
fn rotations_are_the_twins_and_have_the_bits_of_plans() {
    fn check<T: Real, const N: usize>()
    where
        [T; N]: Expansion<Scalar = T>,
    {
        let bands = <[T; N]>::BANDS;
        let (rotator, f) = (Rotator::<T>::new(bands).unwrap(), array::<T, N>(0.2));
        for turn in turns() {
            let quaternion = UnitQuaternion::from_rotation_matrix(&turn);
            let want = naive::rotate(&wide(&f), &turn);
            let matrix = Rotation3::from_matrix_unchecked(turn.matrix().map(T::of));
            let quaternion = UnitQuaternion::new_unchecked(quaternion.quaternion().coords.map(T::of).into());
            let (by_matrix, by_quaternion) = (f.rotate(&matrix), f.rotate_by_quaternion(&quaternion));
            // A matrix or quaternion that is rounded turns degree l by l eps more or less, sampling adds its condition
            // number, 5.
            let tolerance = 5.0 * bands as f64 * eps::<T>() * norm(&f);
            assert_below(worst(&by_matrix, &want), tolerance, &format!("{N} by {turn}"));
            assert_below(worst(&by_quaternion, &want), tolerance, &format!("{N} by quaternion of {turn}"));
            let mut out = [T::nan(); N];
            if !(2..=3).contains(&bands) {
                rotator.apply(&matrix, &f, &mut out);
                assert_eq!(by_matrix, out);
            }
            rotator.apply_quaternion(&quaternion, &f, &mut out);
            assert_eq!(by_quaternion, out);
        }
        let identity = Rotation3::from_matrix_unchecked(Matrix3::identity().map(T::of));
        if bands == 3 {
            // Degree 2 goes through √3 and back, and through a sum whose parts cancel.
            assert_below(worst(&f.rotate(&identity), &wide(&f)), 2.0 * eps::<T>() * norm(&f), "identity");
        } else {
            assert_eq!(f.rotate(&identity), f);
        }
    }
    for_all!(check);
}

#[test]
fn dot_products_are_sums() {
    fn check<T: Real, const N: usize>()
    where
        [T; N]: Expansion<Scalar = T>,
    {
        let (a, b) = (array::<T, N>(0.3), array::<T, N>(1.9));
        let terms = || wide(&a).into_iter().zip(wide(&b)).map(|(a, b)| a * b);
        let (want, size) = (terms().sum::<f64>(), terms().map(f64::abs).sum::<f64>());
        let tolerance = (N as f64 / 8.0 + 2.0) * eps::<T>() * size;
        assert_below((a.dot(&b).widen() - want).abs(), tolerance, &format!("{N}"));
        // Each term once.
        for i in 0..N {
            let mut one = [T::zero(); N];
            one[i] = T::of(3.0);
            assert_eq!(one.dot(&b), T::of(3.0) * b[i]);
        }
    }
    for_all!(check);
}

#[test]
fn integrals_are_those_of_the_truncated_product() {
    fn check<T: Real, const N: usize>()
    where
        [T; N]: Expansion<Scalar = T>,
    {
        let [a, b, c] = [0.1, 0.5, 0.8].map(array::<T, N>);
        let product = naive::product(&wide(&a), &wide(&b), <[T; N]>::BANDS);
        let want: f64 = product.iter().zip(wide(&c)).map(|(p, c)| p * c).sum();
        let tolerance = (3.0 * eps::<T>() + 3e-15) * norm(&a) * norm(&b) * norm(&c);
        assert_below((a.integral(&b, &c).widen() - want).abs(), tolerance, &format!("{N}"));
    }
    for_all!(check);
}

/// What is not a number, infinite, huge or tiny goes through as IEEE arithmetic has it: no panic, and nothing is made
/// up.
#[test]
fn odd_numbers() {
    fn check<T: Real, const N: usize>()
    where
        [T; N]: Expansion<Scalar = T>,
    {
        let (f, zero) = (array::<T, N>(0.6), [T::zero(); N]);
        assert_eq!((f.product(&zero), zero.square(), f.dot(&zero)), (zero, zero, T::zero()));
        let mut odd = f;
        odd[N - 1] = T::nan();
        for value in [T::nan(), T::infinity(), T::neg_infinity()] {
            odd[N - 1] = value;
            assert!(odd.product(&f).iter().any(|x| !x.is_finite()));
            assert!(odd.square().iter().any(|x| !x.is_finite()));
            assert!(!odd.dot(&f).is_finite() && !odd.integral(&f, &f).is_finite());
        }
        let huge = f.map(|x| x * T::max_value().sqrt() * T::of(2f64.powi(-12)));
        assert!(huge.square().iter().all(|x| x.is_finite()));
        let tiny = f.map(|x| x * T::min_positive_value());
        assert!(tiny.product(&f).iter().all(|x| x.is_finite()));
        let y = <[T; N]>::eval(&Vector3::new(T::zero(), T::zero(), T::nan()));
        // Those with l = |m| do not read z.
        assert!((0..N).all(|i| {
            let l = i.isqrt();
            let ends_the_band = i == l * l || i == l * l + 2 * l;
            y[i].is_nan() != ends_the_band
        }));
    }
    for_all!(check);
}
