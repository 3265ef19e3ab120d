//! How a texel stands for its piece of the sphere.

use crate::numeric::GaussLegendre;
use crate::{Error, Result};

/// What a texel's value is, and with it the rule of projection; the solid angles are exact by both.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum TexelRule {
    /// The value at its centre: Σ f y_i(centre) Ω, and y_i(centre) in reconstruction. The common choice.
    #[default]
    Centre,
    /// The mean over the texel: Σ f ∫_texel y_i, the exact projection of the piecewise-constant function that the map
    /// is, and the mean of y_i over each texel in reconstruction.
    Mean,
}

/// The largest `bands` of the plans for maps.
pub(super) const MAX_BANDS: usize = 128;

pub(super) fn check_bands(bands: usize) -> Result<()> {
    if (1..=MAX_BANDS).contains(&bands) {
        Ok(())
    } else {
        Err(Error::OutOfRange { what: "bands", got: bands as f64, allowed: "in 1…128 for maps" })
    }
}

impl TexelRule {
    /// Nodes on [−1, 1] and weights that sum to 1, for a texel of this half width in radians and functions of so many
    /// waves around the sphere: one node, or as many as make the mean exact to `tolerance`.
    ///
    /// Gauss–Legendre with q nodes errs by (κh)^{2q} 2^{2q} q!⁴/((2q+1) (2q)!³) on e^{iκx}, κ = waves + 3. The edges of
    /// a cube's texels are singular functions of their longitude, at distance 1 or more from real ones: another
    /// ρ^{−2q}, ρ = 1/h + √(1 + 1/h²).
    pub(super) fn nodes(self, waves: f64, half_width: f64, tolerance: f64) -> Result<Vec<(f64, f64)>> {
        if self == Self::Centre {
            return Ok(vec![(0.0, 1.0)]);
        }
        let phase = (waves + 3.0) * half_width;
        let rho = 1.0 / half_width + (1.0 + half_width.powi(-2)).sqrt();
        let (mut count, mut wave) = (1, phase * phase / 6.0);
        let mut density = rho.powi(-2);
        while wave > tolerance || density > tolerance {
            let q = count as f64;
            // The ratio of the bound at q + 1 to that at q.
            wave *= (2.0 * phase).powi(2) * (q + 1.0).powi(4) * (2.0 * q + 1.0)
                / ((2.0 * q + 3.0) * ((2.0 * q + 1.0) * (2.0 * q + 2.0)).powi(3));
            density /= rho * rho;
            count += 1;
        }
        let rule = GaussLegendre::new(count)?;
        Ok(rule.nodes().iter().zip(rule.weights()).map(|(&x, &w)| (x, 0.5 * w)).collect())
    }
}

/// What the mean over a texel is computed to.
pub(super) const fn tolerance<T>() -> f64 {
    if size_of::<T>() == 4 { 1e-9 } else { 1e-15 }
}
