//! What game engines keep of an environment for diffuse light.

use std::f64::consts::{FRAC_1_PI, PI};

use crate::Real;
use crate::sphere::Axes;

/// An engine's nine coefficients a channel for diffuse light, which are *not* those of radiance.
///
/// An engine wants E/π, the irradiance over π, of a normal n (so that radiance 1 from everywhere gives 1 and the shader
/// multiplies by the albedo alone). In this crate's coefficients c of radiance
///
/// ```math
/// E(n)/π = Σ a_l c_{l,m} y_{l,m}(n),   a_0, a_1, a_2 = 1, 2/3, 1/4   [Ramamoorthi & Hanrahan 2001]
/// ```
///
/// With y_{l,m} = k_{l,m} p_{l,m}, where p are the polynomials 1; y, z, x; xy, yz, 3z² − 1, xz, x² − y², engines keep:
///
/// | engine | keeps | its shader |
/// |---|---|---|
/// | [`Filament`](Self::Filament) | a k c | Σ s p |
/// | [`Unity`](Self::Unity) | a k c, z backwards | Σ s p |
/// | [`Godot`](Self::Godot) | c/π | Σ π a k s p |
///
/// Order: l(l+1) + m in all of them. three.js keeps c itself: [`Convention::THREE_JS`](super::Convention::THREE_JS).
/// One channel at a time; colours are three of them.
///
/// # Example
/// ```
/// use haarmonic::sh::DiffuseProbe;
/// // Radiance 1 from everywhere: Unity's first coefficient is the ambient colour.
/// let mut radiance = [0.0; 9];
/// radiance[0] = (4.0 * std::f64::consts::PI).sqrt();
/// let stored = DiffuseProbe::Unity.from_radiance(&radiance);
/// assert!((stored[0] - 1.0).abs() < 1e-15);
/// ```
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DiffuseProbe {
    /// Filament's `IndirectLight` after its constants were multiplied in: `cmgen --sh-shader`,
    /// `CubemapSH::computeIrradianceSH3Bands`.
    Filament,
    /// Unity's `SphericalHarmonicsL2`, indices (channel, 0…8), as `LightProbes` and `RenderSettings.ambientProbe` hold
    /// it. In Unity's axes, [`Axes::LEFT_HANDED_Y_UP`].
    Unity,
    /// Godot 4's light probes (`LightmapGIData`, captures).
    Godot,
}

impl DiffuseProbe {
    /// Coefficients of radiance in this crate → what the engine keeps.
    pub fn from_radiance<T: Real>(self, radiance: &[T; 9]) -> [T; 9] {
        std::array::from_fn(|i| radiance[i] * T::of(self.factor(i)))
    }

    /// What the engine keeps → coefficients of radiance in this crate. Inverse of
    /// [`from_radiance`](Self::from_radiance).
    pub fn to_radiance<T: Real>(self, stored: &[T; 9]) -> [T; 9] {
        std::array::from_fn(|i| stored[i] * T::of(1.0 / self.factor(i)))
    }

    /// The axes of the engine's world.
    pub const fn axes(self) -> Axes {
        match self {
            Self::Unity => Axes::LEFT_HANDED_Y_UP,
            Self::Filament | Self::Godot => Axes::RIGHT_HANDED_Y_UP,
        }
    }

    fn factor(self, i: usize) -> f64 {
        // k²·4π: 1; 3, 3, 3; 15, 15, 5/4, 15, 15/4.
        let squared = [1.0, 3.0, 3.0, 3.0, 15.0, 15.0, 1.25, 15.0, 3.75][i];
        let cosine = [1.0, 2.0 / 3.0, 0.25][i.isqrt()];
        let folded = cosine * (squared / (4.0 * PI)).sqrt();
        match self {
            Self::Filament => folded,
            // z backwards: y_{l,m} of odd l + m, which are z, yz and xz.
            Self::Unity if matches!(i, 2 | 5 | 7) => -folded,
            Self::Unity => folded,
            Self::Godot => FRAC_1_PI,
        }
    }
}
