//! Windows against ringing: factors that fall with the degree.

use crate::Real;
use crate::error::length_mismatch;
use crate::sh::bands_of;

/// Factors w_l that fade the high degrees of an expansion, so that it rings less around edges and small bright lights.
///
/// Each is a convolution with a zonal kernel and has w_0 = 1: the mean stays. The other factors are in [0, 1] (Lanczos'
/// too), at an infinite width all 1, at an infinite σ or λ all 0. A width that is NaN counts as 0; a σ or λ that is NaN
/// makes them NaN. What it costs is sharpness: small widths (large λ, σ) blur, large ones leave the ringing.
///
/// | window | w_l | how much |
/// |---|---|---|
/// | `Hanning` | (1 + cos πl/h)/2, 0 from l = h | strong; h = bands ends just beyond the last band |
/// | `Lanczos` | sin(πl/h)/(πl/h), 0 from l = h | mild |
/// | `Gaussian` | e^{−σ² l(l+1)/2}, blur by σ radians: heat flow for time σ²/2 | never makes a non-negative *function* negative, but the cut at `bands` stays; [`Deringing`](super::Deringing) finds σ |
/// | `Curvature` | 1/(1 + λ l²(l+1)²) | least Σ (c − c′)² + λ∫(Δf)² [Sloan 2008]; [`Deringing`](super::Deringing) finds λ |
///
/// # Example
/// ```
/// use haarmonic::sh::Window;
/// let mut c = [1.0, 0.0, 0.5, 0.0];
/// Window::Hanning { width: 2.0 }.apply(&mut c);
/// assert!(c[0] == 1.0 && (c[2] - 0.25f64).abs() < 1e-16);
/// ```
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Window {
    /// (1 + cos πl/h)/2 for l < h, else 0.
    Hanning {
        /// h, the first degree that vanishes; need not be an integer. At most 0 leaves l = 0 alone.
        width: f64,
    },
    /// sin(πl/h)/(πl/h) for l < h, else 0: Lanczos' σ factors.
    Lanczos {
        /// h, as in `Hanning`.
        width: f64,
    },
    /// e^{−σ² l(l+1)/2}.
    Gaussian {
        /// σ, the blur in radians (along each tangent, while small).
        deviation: f64,
    },
    /// 1/(1 + λ l²(l+1)²).
    Curvature {
        /// λ, the weight of the squared Laplacian; below 0 counts as 0.
        lambda: f64,
    },
}

impl Window {
    /// w_l.
    pub fn factor(&self, l: usize) -> f64 {
        let degree = l as f64;
        let x = degree * (degree + 1.0);
        match *self {
            _ if l == 0 => 1.0,
            Self::Hanning { width } | Self::Lanczos { width } if !(degree < width) => 0.0,
            // cos² of the half angle keeps its digits where it vanishes.
            Self::Hanning { width } => (0.5 * std::f64::consts::PI * degree / width).cos().powi(2),
            Self::Lanczos { width } => {
                let x = std::f64::consts::PI * degree / width;
                if x == 0.0 { 1.0 } else { x.sin() / x }
            }
            Self::Gaussian { deviation } => (-0.5 * deviation * deviation * x).exp(),
            Self::Curvature { lambda } if lambda < 0.0 => 1.0,
            Self::Curvature { lambda } => 1.0 / (1.0 + lambda * x * x),
        }
    }

    /// Multiplies each coefficient of degree l by w_l.
    ///
    /// # Panics
    /// If the number of coefficients is not a square.
    #[track_caller]
    pub fn apply<T: Real>(&self, coefficients: &mut [T]) {
        let Some(bands) = bands_of(coefficients.len()) else {
            length_mismatch("coefficients, a square", coefficients.len().isqrt().pow(2), coefficients.len())
        };
        for l in 0..bands {
            let factor = self.factor(l);
            for c in &mut coefficients[l * l..(l + 1) * (l + 1)] {
                *c = T::of(c.widen() * factor);
            }
        }
    }
}
