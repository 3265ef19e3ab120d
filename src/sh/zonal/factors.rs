//! Factors of closed form, one degree after the other.

use std::f64::consts::PI;

use crate::numeric::LegendreSteps;

/// 2π ∫_0^1 t^s P_l dt.
///
/// ```math
/// √π 2^{−s−1} Γ(s+1) / (Γ(1 + (s−l)/2) Γ((s+l+3)/2))
/// ```
///
/// Two degrees up, the first Γ loses and the second gains a factor.
pub(super) fn cosine_power(s: f64) -> impl Iterator<Item = f64> {
    let (mut here, mut next) = (2.0 * PI / (s + 1.0), 2.0 * PI / (s + 2.0));
    (0..).map(move |l| {
        let l = f64::from(l);
        let value = here;
        (here, next) = (next, here * ((s - l) / (s + l + 3.0)));
        value
    })
}

/// The factors of a cap of light.
///
/// From (l(l+1)) P_l = −((1 − t²) P_l′)′:  ∫_c^1 P_l = (1 − c²) P_l′(c)/(l(l+1)), where (1 − c²) is known as sin² and
/// nothing is subtracted.
#[derive(Debug, Clone, Copy)]
pub(in crate::sh) struct CapFactors {
    steps: LegendreSteps<f64>,
    l: f64,
    /// k_0, and k_0 of the complement.
    first: [f64; 2],
    /// 2π sin²θ, or what stands for it.
    scale: f64,
}

impl CapFactors {
    /// From the angle: below 0 as 0, above π as π.
    pub(in crate::sh) fn from_half_angle(half_angle: f64) -> Self {
        // clamp keeps NaN.
        let half_angle = half_angle.clamp(0.0, PI);
        let sin = half_angle.sin();
        let (half_sin, half_cos) = (0.5 * half_angle).sin_cos();
        // 1 − cos and 1 + cos.
        Self::new([half_sin, half_cos].map(|x| 2.0 * x * x), sin * sin)
    }

    /// From the sine of an angle in [0, π/2].
    pub(in crate::sh) fn from_sine(sin: f64) -> Self {
        let square = sin * sin;
        let cos = ((1.0 - sin) * (1.0 + sin)).sqrt();
        Self::new([square / (1.0 + cos), 1.0 + cos], square)
    }

    /// From 1 − cos θ, 1 + cos θ and sin²θ.
    fn new([down, up]: [f64; 2], sin_squared: f64) -> Self {
        let steps = LegendreSteps::from_defect(if down < up { down } else { up }, up < down);
        Self { steps, l: 0.0, first: [2.0 * PI * down, 2.0 * PI * up], scale: 2.0 * PI * sin_squared }
    }

    /// The factors over π sin²θ, finite for no angle at all: those of the delta. θ ≤ π/2.
    pub(in crate::sh) fn per_facing_irradiance(self) -> Self {
        // 2 (1 − cos)/sin² = 2/(1 + cos).
        Self { first: [4.0 * PI / self.first[1], 0.0], scale: 2.0, ..self }
    }

    /// Those of 1 − cap.
    pub(super) fn complement(self) -> Self {
        Self { first: [self.first[1], self.first[0]], scale: -self.scale, ..self }
    }
}

impl Iterator for CapFactors {
    type Item = f64;

    #[inline]
    fn next(&mut self) -> Option<f64> {
        let l = self.l;
        let value = if l == 0.0 { self.first[0] } else { self.scale * self.steps.slope() / (l * (l + 1.0)) };
        self.steps.advance();
        self.l = l + 1.0;
        Some(value)
    }
}
