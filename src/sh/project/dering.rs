//! The mildest window of a family that keeps an expansion above a bound.

use super::{Extrema, Window};
use crate::sh::coefficient_count;
use crate::{Error, Real, Result};

/// Which expansions must stay above the bound, and which share a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DeringBy<const C: usize> {
    /// Each channel has its own window: least blur, but edges may take on colour.
    EachChannel,
    /// All channels share the strongest window that one of them needs: no channel is below the bound, hues stay.
    AllChannels,
    /// All channels share the window that their sum with these weights needs; single channels may be below the bound.
    Luminance([f64; C]),
}

/// The family from which the window is taken.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum DeringWindow {
    /// [`Window::Curvature`] [Sloan 2008, 2017]: the mildest where the light is dim everywhere and rings a little. Its
    /// own kernel is negative in places, so a bright light over black needs much of it, however many the bands.
    Curvature,
    /// [`Window::Gaussian`], the default: the flow of heat, whose kernel is positive, so only the cut at `bands` rings.
    /// For bright lights over black it needs the less blur the more bands there are (docs/sh.md has the errors of
    /// both).
    #[default]
    Gaussian,
}

impl DeringWindow {
    /// The member of this strength: λ, or σ².
    fn window(self, strength: f64) -> Window {
        match self {
            Self::Curvature => Window::Curvature { lambda: strength },
            Self::Gaussian => Window::Gaussian { deviation: strength.sqrt() },
        }
    }

    /// k with w_l ≤ k/strength.
    fn fall(self, l: usize) -> f64 {
        let x = (l * (l + 1)) as f64;
        match self {
            Self::Curvature => 1.0 / (x * x),
            // e^{−y} ≤ 1/(e y), y = σ² x/2.
            Self::Gaussian => 2.0 / (std::f64::consts::E * x),
        }
    }
}

/// Removes ringing by the mildest window of a family that keeps the expansion's minimum at a bound.
///
/// A bright light in few bands rings: its expansion is negative in places, and so is the irradiance made of it. [Sloan
/// 2008, 2017] fades the high bands just as far as needed; here the minimum is the certified one of [`Extrema`], and
/// the strength comes from bisection with secants between one that fails and one that suffices by the bound |Σ_m c y| ≤
/// ‖c_l‖ √((2l+1)/4π) in every degree.
///
/// Accuracy: λ (or σ²) to 1e-6 of itself, from above: the minimum found is not below the bound, and none on the sphere
/// is by more than 1e-6 of half the range. Heat flow lifts the minimum steadily, so σ is the smallest there is; λ is
/// taken from the largest interval of sufficient ones, within factors of 4; no expansion is known where a smaller λ
/// suffices again.
/// Cost: about fifteen calls of [`Extrema::minimum`].
///
/// # Example
/// ```
/// use haarmonic::sh::{DeringBy, Deringing, Extrema, eval};
/// let lamp = haarmonic::nalgebra::Vector3::new(0.6, 0.0, 0.8);
/// let mut c = eval(4, &lamp)?; // a point of light: its expansion rings
/// assert!(Extrema::new(4)?.minimum(&c)?.value < -0.2);
/// Deringing::new(4)?.apply([&mut c], 0.0, DeringBy::EachChannel)?;
/// assert!(Extrema::new(4)?.minimum(&c)?.value.abs() < 1e-5);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Deringing {
    extrema: Extrema,
    family: DeringWindow,
}

impl Deringing {
    /// The plan for `bands`.
    ///
    /// # Errors
    /// As [`Extrema::new`].
    pub fn new(bands: usize) -> Result<Self> {
        Ok(Self { extrema: Extrema::new(bands)?, family: DeringWindow::default() })
    }

    /// This plan with windows of `family`.
    pub fn with_window(mut self, family: DeringWindow) -> Self {
        self.family = family;
        self
    }

    /// The window that brings the minimum of an expansion up to `bound`; of strength 0 if it is not below.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if the expansion is below `bound` somewhere and `bound` is not below its mean c_0/√4π,
    /// which no window moves; [`Error::NotFinite`] as [`Extrema::minimum`].
    ///
    /// # Panics
    /// If `coefficients.len()` is not bands².
    #[track_caller]
    pub fn window<T: Real>(&self, coefficients: &[T], bound: f64) -> Result<Window> {
        Ok(self.family.window(self.strength(coefficients, bound)?))
    }

    #[track_caller]
    fn strength<T: Real>(&self, coefficients: &[T], bound: f64) -> Result<f64> {
        let c: Vec<f64> = coefficients.iter().map(|c| c.widen()).collect();
        let mut windowed = c.clone();
        let mut excess = |strength: f64| {
            windowed.copy_from_slice(&c);
            self.family.window(strength).apply(&mut windowed);
            Ok::<f64, Error>(self.extrema.minimum(&windowed)?.value - bound)
        };
        let mut below = excess(0.0)?;
        if below >= 0.0 {
            return Ok(0.0);
        }
        let room = c[0] * (0.25 / std::f64::consts::PI).sqrt() - bound;
        if !(room > 0.0) {
            return Err(Error::OutOfRange { what: "bound of deringing", got: bound, allowed: "below the mean" });
        }
        let mut high = sufficient(&c, self.family) / room;
        let mut above = excess(high)?;
        let mut low = 0.0;
        while high > 0.0 {
            let next = excess(0.25 * high)?;
            if !(next >= 0.0) {
                (low, below) = (0.25 * high, next);
                break;
            }
            (high, above) = (0.25 * high, next);
        }
        bracketed([low, high], [below, above], excess)
    }

    /// Windows the channels in place; returns the window of each.
    ///
    /// # Errors
    /// As [`window`](Self::window); the channels are then as they were.
    ///
    /// # Panics
    /// If a channel's length is not bands².
    #[track_caller]
    pub fn apply<T: Real, const C: usize>(
        &self,
        channels: [&mut [T]; C],
        bound: f64,
        by: DeringBy<C>,
    ) -> Result<[Window; C]> {
        let mut strengths = [0.0; C];
        match by {
            DeringBy::EachChannel | DeringBy::AllChannels => {
                for (strength, channel) in strengths.iter_mut().zip(&channels) {
                    *strength = self.strength(channel, bound)?;
                }
            }
            DeringBy::Luminance(weights) => {
                let mut sum = vec![0.0; coefficient_count(self.extrema.bands())];
                for (weight, channel) in weights.iter().zip(&channels) {
                    crate::error::check_length("coefficients", sum.len(), channel.len());
                    sum.iter_mut().zip(channel.iter()).for_each(|(sum, c)| *sum += weight * c.widen());
                }
                strengths = [self.strength(&sum, bound)?; C];
            }
        }
        if by == DeringBy::AllChannels {
            strengths = [strengths.iter().copied().fold(0.0, f64::max); C];
        }
        let windows = strengths.map(|strength| self.family.window(strength));
        for (channel, window) in channels.into_iter().zip(&windows) {
            window.apply(channel);
        }
        Ok(windows)
    }
}

/// strength·(mean − bound) that certainly suffices: Σ_l w_l ‖c_l‖ √((2l+1)/4π) with w_l ≤ fall/strength.
fn sufficient(c: &[f64], family: DeringWindow) -> f64 {
    let bands = c.len().isqrt();
    (1..bands)
        .map(|l| {
            let norm = c[l * l..(l + 1) * (l + 1)].iter().fold(0.0f64, |norm, c| norm.hypot(*c));
            norm * ((2.0 * l as f64 + 1.0) / (4.0 * std::f64::consts::PI)).sqrt() * family.fall(l)
        })
        .sum()
}

/// The upper end of a bracket of the root of an increasing function, narrowed to 1e-6 of itself by secants that halve
/// the value at an end which stays (the Illinois rule), and by halving where that is slow.
fn bracketed(
    [mut low, mut high]: [f64; 2],
    [mut below, mut above]: [f64; 2],
    mut excess: impl FnMut(f64) -> Result<f64>,
) -> Result<f64> {
    for step in 0..60 {
        if high - low <= 1e-6 * high || above == 0.0 {
            break;
        }
        let secant = (low * above - high * below) / (above - below);
        // Aim a little above the root, so that both ends move.
        let margin = 2.5e-7 * high;
        let at = if step % 4 == 3 || !secant.is_finite() {
            0.5 * (low + high)
        } else {
            (secant + margin).clamp(low + margin, high - margin)
        };
        let value = excess(at)?;
        if value >= 0.0 {
            (high, above, below) = (at, value, 0.5 * below);
        } else {
            (low, below, above) = (at, value, 0.5 * above);
        }
    }
    Ok(high)
}
