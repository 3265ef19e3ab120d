//! The mildest curvature window that keeps an expansion above a bound.

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

/// Removes ringing: the window 1/(1 + λ l²(l+1)²) with the smallest λ that keeps the expansion's minimum at a bound.
///
/// A bright light in few bands rings: its expansion is negative in places, and so is the irradiance made of it. [Sloan 2008, 2017]
/// fades the high bands just as far as needed; here the minimum is the certified one of [`Extrema`], and λ comes from bisection
/// with secants between a λ that fails and one that suffices by the bound |Σ_m c y| ≤ ‖c_l‖ √((2l+1)/4π) in every degree.
///
/// Accuracy: λ to 1e-6 of itself, from above: the minimum found is not below the bound, and none on the sphere is by more than
/// 1e-6 of half the range. λ is taken from the largest interval of sufficient ones, within factors of 4; no expansion is
/// known where a smaller λ suffices again.
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
}

impl Deringing {
    /// The plan for `bands`.
    ///
    /// # Errors
    /// As [`Extrema::new`].
    pub fn new(bands: usize) -> Result<Self> {
        Ok(Self { extrema: Extrema::new(bands)? })
    }

    /// The λ of [`Window::Curvature`] that brings the minimum of an expansion up to `bound`; 0 if it is not below.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if the expansion is below `bound` somewhere and `bound` is not below its mean c_0/√4π, which no window
    /// moves; [`Error::NotFinite`] as [`Extrema::minimum`].
    ///
    /// # Panics
    /// If `coefficients.len()` is not bands².
    #[track_caller]
    pub fn lambda<T: Real>(&self, coefficients: &[T], bound: f64) -> Result<f64> {
        let c: Vec<f64> = coefficients.iter().map(|c| c.widen()).collect();
        let mut windowed = c.clone();
        let mut excess = |lambda: f64| {
            windowed.copy_from_slice(&c);
            Window::Curvature { lambda }.apply(&mut windowed);
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
        let mut high = sufficient(&c) / room;
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

    /// Windows the channels in place; returns the λ of each.
    ///
    /// # Errors
    /// As [`lambda`](Self::lambda); the channels are then as they were.
    ///
    /// # Panics
    /// If a channel's length is not bands².
    #[track_caller]
    pub fn apply<T: Real, const C: usize>(
        &self,
        channels: [&mut [T]; C],
        bound: f64,
        by: DeringBy<C>,
    ) -> Result<[f64; C]> {
        let mut lambdas = [0.0; C];
        match by {
            DeringBy::EachChannel | DeringBy::AllChannels => {
                for (lambda, channel) in lambdas.iter_mut().zip(&channels) {
                    *lambda = self.lambda(channel, bound)?;
                }
            }
            DeringBy::Luminance(weights) => {
                let mut sum = vec![0.0; coefficient_count(self.extrema.bands())];
                for (weight, channel) in weights.iter().zip(&channels) {
                    crate::error::check_length("coefficients", sum.len(), channel.len());
                    sum.iter_mut().zip(channel.iter()).for_each(|(sum, c)| *sum += weight * c.widen());
                }
                lambdas = [self.lambda(&sum, bound)?; C];
            }
        }
        if by == DeringBy::AllChannels {
            lambdas = [lambdas.iter().copied().fold(0.0, f64::max); C];
        }
        for (channel, &lambda) in channels.into_iter().zip(&lambdas) {
            Window::Curvature { lambda }.apply(channel);
        }
        Ok(lambdas)
    }
}

/// λ·(mean − bound) that certainly suffices: Σ_l w_l ‖c_l‖ √((2l+1)/4π) with w_l < 1/(λ l²(l+1)²).
fn sufficient(c: &[f64]) -> f64 {
    let bands = c.len().isqrt();
    (1..bands)
        .map(|l| {
            let norm = c[l * l..(l + 1) * (l + 1)].iter().fold(0.0f64, |norm, c| norm.hypot(*c));
            let degree = l as f64;
            norm * ((2.0 * degree + 1.0) / (4.0 * std::f64::consts::PI)).sqrt() / (degree * (degree + 1.0)).powi(2)
        })
        .sum()
}

/// The upper end of a bracket of the root of an increasing function, narrowed to 1e-6 of itself by secants that halve the value at
/// an end which stays (the Illinois rule), and by halving where that is slow.
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
