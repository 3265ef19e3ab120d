//! Coefficient vectors in other people's conventions, and back.

use nalgebra::{Complex, Matrix3, Rotation3};

use super::Rotation;
use super::index::{coefficient_count, index};
use crate::Real;
use crate::error::check_length;
use crate::sphere::Axes;

/// The sign of the odd orders.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Phase {
    /// None: y_{1,·} = c·(y, z, x). This crate.
    #[default]
    Plain,
    /// (−1)^m on every order: y_{1,·} = c·(−y, z, −x). Sloan's tables, DirectXMath.
    CondonShortley,
}

/// The scale of a basis function.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Normalization {
    /// ∫ y² dω = 1. This crate.
    #[default]
    Orthonormal,
    /// ∫ y² dω = 4π: geodesy; ambisonics' N3D; e3nn's `component`.
    FourPi,
    /// ∫ y² dω = 4π/(2l+1): Schmidt's semi-normalisation, geomagnetism; also Racah's C_lm, ambisonics' SN3D and
    /// e3nn's `norm`.
    Schmidt,
    /// Ambisonics' maxN with W divided by √2, as Furse and Malham have it: the greatest value of a function is 1, that
    /// of y_{0,0} is 1/√2. Defined up to degree 3, that is for at most 4 bands.
    FurseMalham,
}

/// Where a coefficient lies in its vector.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Layout {
    /// l(l+1) + m. This crate; ambisonics' ACN.
    #[default]
    ByDegree,
    /// m = 0, 1, −1, 2, −2, …; within an order, l = |m|, …, bands − 1.
    ByOrder,
    /// By degree, and within a degree m = 0, 1, …, l (cosines), then −1, …, −l (sines): the vectors of SHTOOLS'
    /// `SHCilmToVector`, whose `cilm[i, l, m]` is at l² + i·l + m.
    CosinesFirst,
    /// By degree, and within a degree m = 0, 1, −1, 2, −2, …, but X, Y, Z (m = 1, −1, 0) in degree 1: the letters
    /// W XYZ RSTUV KLMNOPQ of Furse and Malham.
    FurseMalham,
}

/// A convention for the coefficients of a real function in a real basis.
///
/// Their basis functions are ours times a constant, taken in their coordinates of the direction:
///
/// ```math
/// y'_{l,m}(ω) = k(l, m) y_{l,m}(A ω)
/// ```
///
/// k comes from `phase` and `normalization`, A from `axes`. A vector can hold two things, which scale inversely:
///
/// - *coefficients* c' with f = Σ c' y'. They go through [`export`](Self::export) and [`import`](Self::import).
/// - *values* of the basis functions y', and *projections* ∫ f y' dω. They go through
///   [`export_values`](Self::export_values) and [`import_values`](Self::import_values). The channels of an ambisonic
///   signal are of this kind: a source in direction ω has the channels y'(ω).
///
/// Where the basis is orthonormal, coefficients and projections are the same.
///
/// # Presets
///
/// | project | vector | preset |
/// |---|---|---|
/// | Sloan's tables, DirectXMath and D3DX (`XMSHEvalDirection`) | coefficients | [`SLOAN`](Self::SLOAN), [`DIRECTX_MATH`](Self::DIRECTX_MATH) |
/// | three.js (`SphericalHarmonics3`, `LightProbe`) | coefficients of radiance | [`THREE_JS`](Self::THREE_JS) |
/// | Filament: `cmgen --sh` | coefficients of radiance | [`FILAMENT`](Self::FILAMENT) |
/// | Filament's shader, Unity, Godot | radiance that was divided by π or convolved with the cosine and scaled | [`DiffuseProbe`](super::DiffuseProbe), not a convention |
/// | Bevy | none: its irradiance volumes hold ambient cubes, six values a voxel; its world has our axes | |
/// | 3D Gaussian splatting | coefficients of colour − ½ | [`GAUSSIAN_SPLATTING`](Self::GAUSSIAN_SPLATTING) |
/// | SciPy (`sph_harm_y`) | complex coefficients | [`to_complex`], [`from_complex`] |
/// | e3nn (`spherical_harmonics`) | values | [`E3NN_INTEGRAL`](Self::E3NN_INTEGRAL), [`E3NN_COMPONENT`](Self::E3NN_COMPONENT), [`E3NN_NORM`](Self::E3NN_NORM) |
/// | SHTOOLS (`SHCilmToVector`) | coefficients | [`SHTOOLS`](Self::SHTOOLS) |
/// | ambisonics: AmbiX (ACN, SN3D); ACN, N3D; FuMa | projections | [`AMBIX`](Self::AMBIX), [`AMBISONIC_N3D`](Self::AMBISONIC_N3D), [`FUMA`](Self::FUMA) |
///
/// # Cost
/// One pass over the vector where the pole stays on the z axis, for any number of bands and without rounding but for
/// the scale. Where `axes` move the pole (e3nn, ambisonics), a [`Rotation`] is built for each call, in Θ(bands⁴).
///
/// # Example
/// ```
/// use haarmonic::sh::Convention;
/// assert_eq!(Convention::DIRECTX_MATH.export(2, &[1.0, 2.0, 3.0, 4.0]), [1.0, -2.0, 3.0, -4.0]);
/// // A source of sound in front of the listener, along −z: only W and X of AmbiX, channels 0 and 3.
/// let front = haarmonic::sh::eval(2, &-haarmonic::nalgebra::Vector3::<f64>::z_axis())?;
/// let channels = Convention::AMBIX.export_values(2, &front);
/// assert!(channels.iter().zip([1.0, 0.0, 0.0, 1.0]).all(|(a, b)| (a - b).abs() < 1e-15));
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Convention {
    /// The sign of the odd orders.
    pub phase: Phase,
    /// The scale of a basis function.
    pub normalization: Normalization,
    /// The order of the vector.
    pub layout: Layout,
    /// The coordinates in which their basis functions are written.
    pub axes: Axes,
}

impl Convention {
    /// This crate.
    const OURS: Self = Self {
        phase: Phase::Plain,
        normalization: Normalization::Orthonormal,
        layout: Layout::ByDegree,
        axes: Axes::RIGHT_HANDED_Y_UP,
    };

    /// The polynomials of Sloan, *Stupid Spherical Harmonics Tricks*, appendix A2: orthonormal, with (−1)^m.
    ///
    /// The basis is of the coordinates as they are given; that Direct3D's world is left-handed is the caller's to
    /// convert, by `axes`.
    pub const SLOAN: Self = Self { phase: Phase::CondonShortley, ..Self::OURS };

    /// DirectXMath's `XMSHEvalDirection` and D3DX' `D3DXSHEvalDirection`: [`SLOAN`](Self::SLOAN).
    pub const DIRECTX_MATH: Self = Self::SLOAN;

    /// three.js' `SphericalHarmonics3`: this crate's, 3 bands. `LightProbe.sh` holds radiance; `getIrradianceAt`
    /// multiplies by the cosine's factors when it evaluates.
    pub const THREE_JS: Self = Self::OURS;

    /// Filament's `cmgen --sh` and `CubemapSH::computeSH` without `irradiance`: [`SLOAN`](Self::SLOAN).
    ///
    /// With `irradiance` every degree is multiplied by A_l/π (1, 2/3, 1/4, …), the cosine's factor over π, as
    /// [`Irradiance`](super::Irradiance) over π; what Filament's shader reads is
    /// [`DiffuseProbe::Filament`](super::DiffuseProbe::Filament).
    pub const FILAMENT: Self = Self::SLOAN;

    /// 3D Gaussian splatting (`eval_sh`, `SH_C0` to `SH_C3`): [`SLOAN`](Self::SLOAN), up to 4 bands.
    ///
    /// The function is the colour less ½: colour = max(0, ½ + Σ c y). The world is that of the reconstruction, of
    /// which nothing says what is up.
    pub const GAUSSIAN_SPLATTING: Self = Self::SLOAN;

    /// e3nn's `spherical_harmonics(…, normalization='integral')`, its default: the pole is y.
    pub const E3NN_INTEGRAL: Self = Self { axes: Axes::POLE_Y, ..Self::OURS };

    /// e3nn's `normalization='component'`: Σ_m y² = 2l + 1.
    pub const E3NN_COMPONENT: Self = Self { normalization: Normalization::FourPi, ..Self::E3NN_INTEGRAL };

    /// e3nn's `normalization='norm'`: Σ_m y² = 1.
    pub const E3NN_NORM: Self = Self { normalization: Normalization::Schmidt, ..Self::E3NN_INTEGRAL };

    /// SHTOOLS' defaults, normalization `4pi` and csphase 1, as a vector of `SHCilmToVector`.
    pub const SHTOOLS: Self = Self { normalization: Normalization::FourPi, layout: Layout::CosinesFirst, ..Self::OURS };

    /// Ambisonics in AmbiX: channels by ACN, SN3D. Their x is forwards, y to the left, z up.
    pub const AMBIX: Self = Self { normalization: Normalization::Schmidt, axes: Axes::AMBISONIC, ..Self::OURS };

    /// Ambisonics, channels by ACN, N3D.
    pub const AMBISONIC_N3D: Self = Self { normalization: Normalization::FourPi, ..Self::AMBIX };

    /// Ambisonics of Furse and Malham, W first, then XYZ, RSTUV, KLMNOPQ: at most 4 bands.
    pub const FUMA: Self =
        Self { normalization: Normalization::FurseMalham, layout: Layout::FurseMalham, ..Self::AMBIX };

    /// Coefficients of this crate → coefficients of the convention.
    ///
    /// # Panics
    /// If `coefficients.len()` is not bands²; if there are more bands than the convention has: 4 with
    /// [`Normalization::FurseMalham`], 128 where `axes` move the pole.
    #[track_caller]
    pub fn export<T: Real>(&self, bands: usize, coefficients: &[T]) -> Vec<T> {
        check_length("coefficients", coefficient_count(bands), coefficients.len());
        self.leave(bands, coefficients, |k| 1.0 / k)
    }

    /// Coefficients of the convention → coefficients of this crate. Inverse of [`export`](Self::export).
    ///
    /// # Panics
    /// As [`export`](Self::export).
    #[track_caller]
    pub fn import<T: Real>(&self, bands: usize, coefficients: &[T]) -> Vec<T> {
        check_length("coefficients", coefficient_count(bands), coefficients.len());
        self.enter(bands, coefficients, |k| k)
    }

    /// Values of this crate's basis functions (or projections on them) → those of the convention's.
    ///
    /// # Panics
    /// If `values.len()` is not bands², or as [`export`](Self::export).
    #[track_caller]
    pub fn export_values<T: Real>(&self, bands: usize, values: &[T]) -> Vec<T> {
        check_length("values", coefficient_count(bands), values.len());
        self.leave(bands, values, |k| k)
    }

    /// Values of the convention's basis functions (or projections on them) → those of this crate's. Inverse of
    /// [`export_values`](Self::export_values).
    ///
    /// # Panics
    /// If `values.len()` is not bands², or as [`export`](Self::export).
    #[track_caller]
    pub fn import_values<T: Real>(&self, bands: usize, values: &[T]) -> Vec<T> {
        check_length("values", coefficient_count(bands), values.len());
        self.enter(bands, values, |k| 1.0 / k)
    }

    /// To their axes, then scale, then order. Coefficients and values turn alike, as the matrix is orthogonal.
    #[track_caller]
    fn leave<T: Real>(&self, bands: usize, ours: &[T], factor: impl Fn(f64) -> f64) -> Vec<T> {
        self.check_bands(bands);
        let turned = turned(self.axes, bands, ours.to_vec());
        self.order(bands).map(|(l, m)| turned[index(l, m)] * T::of(factor(self.scale(l, m)))).collect()
    }

    /// The way back.
    #[track_caller]
    fn enter<T: Real>(&self, bands: usize, theirs: &[T], factor: impl Fn(f64) -> f64) -> Vec<T> {
        self.check_bands(bands);
        let mut out = vec![T::zero(); theirs.len()];
        for ((l, m), &c) in self.order(bands).zip(theirs) {
            out[index(l, m)] = c * T::of(factor(self.scale(l, m)));
        }
        turned(self.axes.inverse(), bands, out)
    }

    #[track_caller]
    fn check_bands(&self, bands: usize) {
        let few = self.normalization != Normalization::FurseMalham || bands <= FURSE_MALHAM.len();
        assert!(few, "bands: at most 4 expected with the weights of Furse and Malham, got {bands}");
    }

    /// The convention's basis function over this crate's.
    fn scale(&self, l: usize, m: isize) -> f64 {
        let four_pi = 4.0 * std::f64::consts::PI;
        let size = match self.normalization {
            Normalization::Orthonormal => 1.0,
            Normalization::FourPi => four_pi.sqrt(),
            Normalization::Schmidt => (four_pi / (2 * l + 1) as f64).sqrt(),
            Normalization::FurseMalham => (four_pi / FURSE_MALHAM[l][m.unsigned_abs()]).sqrt(),
        };
        match self.phase {
            Phase::CondonShortley if m % 2 != 0 => -size,
            _ => size,
        }
    }

    /// The (l, m) of the convention's vector, from its start.
    fn order(&self, bands: usize) -> impl Iterator<Item = (usize, isize)> {
        let layout = self.layout;
        let by_order = layout == Layout::ByOrder;
        (0..if by_order { 2 * bands.max(1) - 1 } else { bands }).flat_map(move |outer| {
            let inner = if by_order { bands.saturating_sub(outer.div_ceil(2)) } else { 2 * outer + 1 };
            (0..inner).map(move |k| match layout {
                Layout::ByDegree => (outer, k as isize - outer as isize),
                Layout::ByOrder => (outer.div_ceil(2) + k, alternating(outer)),
                Layout::CosinesFirst => (outer, if k <= outer { k as isize } else { outer as isize - k as isize }),
                Layout::FurseMalham if outer == 1 => (1, [1, -1, 0][k]),
                Layout::FurseMalham => (outer, alternating(k)),
            })
        })
    }
}

/// 0, 1, −1, 2, −2, …
fn alternating(k: usize) -> isize {
    let m = k.div_ceil(2) as isize;
    if k % 2 == 1 { m } else { -m }
}

/// The squared ratios of N3D to FuMa's weights, by degree and |m|: 2 for W, so that W is 1/√2, and for the others the
/// squared maximum of the N3D function (√3; √5, √15/2; √7, √(224/45), √35/3, √(35/8) in the usual tables).
const FURSE_MALHAM: [&[f64]; 4] =
    [&[2.0], &[3.0, 3.0], &[5.0, 15.0 / 4.0, 15.0 / 4.0], &[7.0, 224.0 / 45.0, 35.0 / 9.0, 35.0 / 8.0]];

/// The coefficients of f(A⁻¹ ω), A the change to those axes.
///
/// A = S C W: W swaps x and y or does nothing, C moves the axes round in a ring or does nothing, S changes signs. W and
/// S permute and negate coefficients:
///
/// ```math
/// x → −x: φ → π − φ;  y → −y: φ → −φ;  z → −z: (−1)^{l+m};  x ↔ y: φ → π/2 − φ
/// ```
///
/// and only C, which moves the pole, needs a rotation.
#[track_caller]
fn turned<T: Real>(axes: Axes, bands: usize, mut f: Vec<T>) -> Vec<T> {
    if axes == Axes::default() {
        return f;
    }
    let parts = axes.parts();
    let places = parts.map(|(place, _)| place);
    let odd = matches!(places, [1, 0, 2] | [0, 2, 1] | [2, 1, 0]);
    if odd {
        swap_x_y(bands, &mut f);
    }
    // (C v)_i = v_{ring_i}, so that (C W v)_i = v_{places_i}.
    let ring = if odd { places.map(|place| [1, 0, 2][place]) } else { places };
    if ring != [0, 1, 2] && bands > 0 {
        let matrix = Matrix3::from_fn(|i, j| if ring[i] == j { 1.0 } else { 0.0 });
        let rotation = Rotation::<T>::new(bands, &Rotation3::from_matrix_unchecked(matrix));
        let rotation = rotation.unwrap_or_else(|error| panic!("axes that move the pole: {error}"));
        let mut out = vec![T::zero(); f.len()];
        rotation.apply(&f, &mut out);
        f = out;
    }
    let [x, y, z] = parts.map(|(_, negative)| negative);
    for l in 0..bands {
        for m in -(l as isize)..=l as isize {
            let (sine, odd) = (m < 0, m % 2 != 0);
            let flips = [x && (odd != sine), y && sine, z && ((l % 2 == 1) != odd)];
            if flips.into_iter().fold(false, |a, b| a != b) {
                f[index(l, m)] = -f[index(l, m)];
            }
        }
    }
    f
}

/// cos m(π/2 − φ) and sin m(π/2 − φ) in terms of cos mφ and sin mφ.
fn swap_x_y<T: Real>(bands: usize, f: &mut [T]) {
    for l in 1..bands {
        for m in 1..=l as isize {
            let (cosine, sine) = (f[index(l, m)], f[index(l, -m)]);
            let (cosine, sine) = if m % 2 == 0 { (cosine, -sine) } else { (sine, cosine) };
            let negative = (m / 2) % 2 == 1;
            f[index(l, m)] = if negative { -cosine } else { cosine };
            f[index(l, -m)] = if negative { -sine } else { sine };
        }
    }
}

/// Coefficients of a real function in the complex orthonormal basis with Condon–Shortley phase (SciPy's `sph_harm_y`,
/// quantum mechanics), index l(l+1) + m. SciPy's θ is the angle to +z, its φ runs from +x to +y.
///
/// ```math
/// a_{l,0} = c_{l,0},  a_{l,m} = (−1)^m (c_{l,m} − i c_{l,−m})/√2,  a_{l,−m} = (−1)^m conj(a_{l,m})  (m > 0)
/// ```
///
/// from y_{l,±m} = √2 (−1)^m {Re, Im} Y_{l,m}; then Σ a Y = Σ c y.
///
/// # Panics
/// If `coefficients.len()` is not bands².
#[track_caller]
pub fn to_complex<T: Real>(bands: usize, coefficients: &[T]) -> Vec<Complex<T>> {
    check_length("coefficients", coefficient_count(bands), coefficients.len());
    let mut out = vec![Complex::new(T::zero(), T::zero()); coefficients.len()];
    for l in 0..bands {
        let centre = l * (l + 1);
        out[centre].re = coefficients[centre];
        for m in 1..=l {
            let half = T::of(sign(m) * 0.5f64.sqrt());
            let (even, odd) = (coefficients[centre + m], coefficients[centre - m]);
            out[centre + m] = Complex::new(half * even, -half * odd);
            let plain = T::of(0.5f64.sqrt());
            out[centre - m] = Complex::new(plain * even, plain * odd);
        }
    }
    out
}

/// Coefficients of the real part of Σ a Y, from those in the complex basis of [`to_complex`], whose inverse it is.
///
/// ```math
/// c_{l,m} = Re((−1)^m a_{l,m} + a_{l,−m})/√2,  c_{l,−m} = Im(a_{l,−m} − (−1)^m a_{l,m})/√2
/// ```
///
/// # Panics
/// If `coefficients.len()` is not bands².
#[track_caller]
pub fn from_complex<T: Real>(bands: usize, coefficients: &[Complex<T>]) -> Vec<T> {
    check_length("coefficients", coefficient_count(bands), coefficients.len());
    let mut out = vec![T::zero(); coefficients.len()];
    let half = T::of(0.5f64.sqrt());
    for l in 0..bands {
        let centre = l * (l + 1);
        out[centre] = coefficients[centre].re;
        for m in 1..=l {
            let (up, down) = (coefficients[centre + m], coefficients[centre - m]);
            let sign = T::of(sign(m));
            out[centre + m] = half * (sign * up.re + down.re);
            out[centre - m] = half * (down.im - sign * up.im);
        }
    }
    out
}

fn sign(m: usize) -> f64 {
    if m % 2 == 0 { 1.0 } else { -1.0 }
}
