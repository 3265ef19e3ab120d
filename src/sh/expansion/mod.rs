//! Expansions of a fixed size, as arrays.

#[rustfmt::skip]
mod basis;

use std::sync::OnceLock;

use nalgebra::{Rotation3, UnitQuaternion, Vector3};

use super::product::{Product, Square, straight};
use super::rotate::Rotator;
use crate::Real;

mod sealed {
    pub trait Sealed {}
}

/// An expansion of 1 to 8 bands as an array: `[T; 1]`, `[T; 4]`, `[T; 9]`, `[T; 16]`, `[T; 25]`, `[T; 36]`, `[T; 49]`,
/// `[T; 64]` of `f32` or `f64`.
///
/// For code that has one vector at a time, as a shader has: no plan to keep, no lengths to go wrong. Where there are
/// many vectors, [`Basis::eval_batch`](super::Basis::eval_batch), [`Product::apply_batch`],
/// [`Rotation`](super::Rotation) and [`Rotator::apply_quaternion_batch`] take a fraction of the time for each.
///
/// Values of any size, and products, squares and rotations by matrices of up to three bands, are inlined: in a loop
/// over arrays the compiler may put several vectors side by side. From four bands on they keep constants, which the
/// first call computes and allocates; later calls do not allocate. Only rotations, and products of seven and eight
/// bands, choose between instruction sets when called.
///
/// Layout, signs and scale are those of the module: index l(l+1) + m, orthonormal, no Condon–Shortley phase.
/// Sealed, so that it can grow.
///
/// # Example
/// ```
/// use haarmonic::nalgebra::Vector3;
/// use haarmonic::sh::Expansion;
/// // A lobe about z, lit from above; what the two have in common, and how much.
/// let lobe = <[f32; 9]>::eval(&Vector3::new(0.0, 0.0, 1.0));
/// let light = <[f32; 9]>::eval(&Vector3::new(0.6, 0.0, 0.8));
/// let both = lobe.product(&light);
/// // ∫ f g = ∫ (f g) · 1, and 1 is √4π y_00.
/// assert!((lobe.dot(&light) - both[0] * (4.0 * std::f32::consts::PI).sqrt()).abs() < 1e-6);
/// ```
pub trait Expansion: Copy + Send + Sync + sealed::Sealed + 'static {
    /// `f32` or `f64`.
    type Scalar: Real;

    /// The number of bands: the array has BANDS² coefficients.
    const BANDS: usize;

    /// All y_i at a direction, a unit vector, which is neither checked nor normalised.
    ///
    /// Accuracy, worst over the sphere and beside the poles: `f32` 7e-7 at 6 bands, 1.4e-6 at 8; `f64` 2e-15 and 3e-15.
    /// [`Basis::eval`](super::Basis::eval) has the same values, up to rounding, by more multiplications.
    fn eval(direction: &Vector3<Self::Scalar>) -> Self;

    /// The product, truncated to as many bands.
    ///
    /// ```math
    /// h_k = Σ_ij a_i b_j Γ_ijk                                                [Sun 2008, §2.4]
    /// ```
    ///
    /// The same bits as [`Product::apply`], where its accuracy is given.
    fn product(&self, other: &Self) -> Self;

    /// The product with itself in less time; the same bits as [`Square::apply`].
    fn square(&self) -> Self;

    /// (Rf)(ω) = f(R⁻¹ω): a lobe about d becomes the lobe about Rd.
    ///
    /// Up to three bands R itself is applied, to a vector and to a quadratic form, whose degree is rounded even where R
    /// is 1. From four on it is [`Rotator::apply`], with its bits; there is what becomes of matrices that are not quite
    /// orthogonal.
    fn rotate(&self, rotation: &Rotation3<Self::Scalar>) -> Self;

    /// [`rotate`](Self::rotate) by a quaternion; the same bits as [`Rotator::apply_quaternion`].
    fn rotate_by_quaternion(&self, rotation: &UnitQuaternion<Self::Scalar>) -> Self;

    /// ∫ f g over the sphere, Σ_i a_i b_i: four sums side by side.
    ///
    /// Accuracy: (BANDS²/8 + 2) eps Σ |a_i b_i|.
    fn dot(&self, other: &Self) -> Self::Scalar;

    /// ∫ f g h over the sphere, Σ_ijk a_i b_j c_k Γ_ijk; the same bits as [`Product::integral`].
    fn integral(&self, b: &Self, c: &Self) -> Self::Scalar;
}

/// R (x, y, z), where coefficients 1, 2, 3 belong to y, z, x.
#[inline(always)]
fn rotate_vector<T: Real>(rotation: &Rotation3<T>, f: &[T; 4]) -> [T; 4] {
    let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = rotation.matrix().data.0;
    let [mean, y, z, x] = *f;
    [mean, yx * x + yy * y + yz * z, zx * x + zy * y + zz * z, xx * x + xy * y + xz * z]
}

/// Two bands by [`rotate_vector`], and degree 2 as the quadratic form ½ k xᵀMx, which becomes R M Rᵀ:
///
/// ```math
/// M = [[c₂ − u, c₋₂, c₁], [c₋₂, −c₂ − u, c₋₁], [c₁, c₋₁, 2u]],  u = c₀/√3,  k = √(15/4π)
/// ```
///
/// M keeps its trace, 0, so M_xx need not be formed.
#[inline(always)]
fn rotate_form<T: Real>(rotation: &Rotation3<T>, f: &[T; 9]) -> [T; 9] {
    let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = rotation.matrix().data.0;
    let [mean, y, z, x, a, b, c, d, e] = *f;
    let u = T::of(3f64.sqrt().recip()) * c;
    let form =
        |[x, y, z]: [T; 3]| [(e - u) * x + a * y + d * z, a * x - (e + u) * y + b * z, d * x + b * y + (u + u) * z];
    let dot = |[x, y, z]: [T; 3], [u, v, w]: [T; 3]| x * u + y * v + z * w;
    let rows = [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]];
    let [with_y, with_z] = [form(rows[1]), form(rows[2])];
    let (middle, last) = (dot(rows[1], with_y), dot(rows[2], with_z));
    let [mean, y, z, x] = rotate_vector(rotation, &[mean, y, z, x]);
    let (half, scale) = (T::of(0.5), T::of(0.5 * 3f64.sqrt()));
    [
        mean,
        y,
        z,
        x,
        dot(rows[0], with_y),
        dot(rows[1], with_z),
        scale * last,
        dot(rows[0], with_z),
        -(middle + half * last),
    ]
}

#[inline(always)]
fn dot<T: Real, const N: usize>(a: &[T; N], b: &[T; N]) -> T {
    let (a, a_rest) = a.as_chunks::<4>();
    let (b, b_rest) = b.as_chunks::<4>();
    let mut sums = [T::zero(); 4];
    for (a, b) in a.iter().zip(b) {
        for i in 0..4 {
            sums[i] += a[i] * b[i];
        }
    }
    let rest = a_rest.iter().zip(b_rest).map(|(a, b)| *a * *b).fold(T::zero(), |sum, term| sum + term);
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// The plan of a size, made when it is first wanted.
macro_rules! plan {
    ($plan: ty, $($bands: expr),*) => {{
        static PLAN: OnceLock<$plan> = OnceLock::new();
        PLAN.get_or_init(|| <$plan>::new($($bands),*).expect("bands in range"))
    }};
}

macro_rules! multiply {
    (straight, $scalar: ty, $bands: literal, $size: literal) => {
        #[inline]
        fn product(&self, other: &Self) -> Self {
            let mut out = [0.0; $size];
            straight::product(self, other, &mut out);
            out
        }

        #[inline]
        fn square(&self) -> Self {
            let mut out = [0.0; $size];
            straight::square(self, &mut out);
            out
        }
    };
    (planned, $scalar: ty, $bands: literal, $size: literal) => {
        fn product(&self, other: &Self) -> Self {
            let mut out = [0.0; $size];
            plan!(Product<$scalar>, $bands, $bands, $bands).apply(self, other, &mut out);
            out
        }

        fn square(&self) -> Self {
            let mut out = [0.0; $size];
            plan!(Square<$scalar>, $bands, $bands).apply(self, &mut out);
            out
        }
    };
}

macro_rules! rotate {
    (constant, $scalar: ty, $bands: literal, $size: literal) => {
        #[inline]
        fn rotate(&self, _: &Rotation3<$scalar>) -> Self {
            *self
        }

        #[inline]
        fn rotate_by_quaternion(&self, _: &UnitQuaternion<$scalar>) -> Self {
            *self
        }
    };
    (planned, $scalar: ty, $bands: literal, $size: literal) => {
        fn rotate(&self, rotation: &Rotation3<$scalar>) -> Self {
            let mut out = [0.0; $size];
            plan!(Rotator<$scalar>, $bands).apply(rotation, self, &mut out);
            out
        }

        rotate!(by_quaternion, $scalar, $bands, $size);
    };
    (by_quaternion, $scalar: ty, $bands: literal, $size: literal) => {
        fn rotate_by_quaternion(&self, rotation: &UnitQuaternion<$scalar>) -> Self {
            let mut out = [0.0; $size];
            plan!(Rotator<$scalar>, $bands).apply_quaternion(rotation, self, &mut out);
            out
        }
    };
    ($direct: ident, $scalar: ty, $bands: literal, $size: literal) => {
        #[inline]
        fn rotate(&self, rotation: &Rotation3<$scalar>) -> Self {
            $direct(rotation, self)
        }

        rotate!(by_quaternion, $scalar, $bands, $size);
    };
}

macro_rules! expansions {
    ($($scalar: ty: $($bands: literal $size: literal $eval: ident $multiply: ident $rotate: ident),*;)*) => {$($(
        impl sealed::Sealed for [$scalar; $size] {}

        impl Expansion for [$scalar; $size] {
            type Scalar = $scalar;
            const BANDS: usize = $bands;

            #[inline]
            fn eval(direction: &Vector3<$scalar>) -> Self {
                let mut out = [0.0; $size];
                basis::$eval([direction.x, direction.y, direction.z], &mut out);
                out
            }

            multiply!($multiply, $scalar, $bands, $size);
            rotate!($rotate, $scalar, $bands, $size);

            #[inline]
            fn dot(&self, other: &Self) -> $scalar {
                dot(self, other)
            }

            fn integral(&self, b: &Self, c: &Self) -> $scalar {
                let product = self.product(b);
                <$scalar>::of(product.iter().zip(c).map(|(p, c)| p.widen() * c.widen()).sum())
            }
        }
    )*)*};
}

expansions! {
    f32:
        1 1 eval_1 straight constant, 2 4 eval_2 straight rotate_vector, 3 9 eval_3 straight rotate_form, 4 16 eval_4 planned planned,
        5 25 eval_5 planned planned, 6 36 eval_6 planned planned, 7 49 eval_7 planned planned, 8 64 eval_8 planned planned;
    f64:
        1 1 eval_1 straight constant, 2 4 eval_2 straight rotate_vector, 3 9 eval_3 straight rotate_form, 4 16 eval_4 planned planned,
        5 25 eval_5 planned planned, 6 36 eval_6 planned planned, 7 49 eval_7 planned planned, 8 64 eval_8 planned planned;
}
