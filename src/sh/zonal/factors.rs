//! Factors of closed form, one degree after the other.

use std::f64::consts::PI;

/// 2π ∫_0^1 t^s P_l dt.
///
///   √π 2^{−s−1} Γ(s+1) / (Γ(1 + (s−l)/2) Γ((s+l+3)/2)): two degrees up, the first Γ loses and the second gains a factor.
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
/// From (l(l+1)) P_l = −((1 − t²) P_l′)′:  ∫_c^1 P_l = (1 − c²) P_l′(c)/(l(l+1)), where (1 − c²) is known as sin² and nothing is
/// subtracted.
#[derive(Debug, Clone, Copy)]
pub(in crate::sh) struct CapFactors {
    cos: f64,
    /// k_0, and k_0 of the complement.
    first: [f64; 2],
    /// 2π sin²θ, or what stands for it.
    scale: f64,
    l: f64,
    p: [f64; 2],
    slope: [f64; 2],
}

impl CapFactors {
    /// From the angle: below 0 as 0, above π as π.
    pub(in crate::sh) fn from_half_angle(half_angle: f64) -> Self {
        // clamp keeps NaN.
        let half_angle = half_angle.clamp(0.0, PI);
        let (sin, cos) = half_angle.sin_cos();
        let (half_sin, half_cos) = (0.5 * half_angle).sin_cos();
        Self::new(cos, [half_sin, half_cos].map(|x| 4.0 * PI * x * x), sin * sin)
    }

    /// From the sine of an angle in [0, π/2].
    pub(in crate::sh) fn from_sine(sin: f64) -> Self {
        let square = sin * sin;
        let cos = ((1.0 - sin) * (1.0 + sin)).sqrt();
        Self::new(cos, [square / (1.0 + cos), 1.0 + cos].map(|x| 2.0 * PI * x), square)
    }

    fn new(cos: f64, first: [f64; 2], sin_squared: f64) -> Self {
        Self { cos, first, scale: 2.0 * PI * sin_squared, l: 0.0, p: [1.0, 0.0], slope: [0.0, 0.0] }
    }

    /// The factors over π sin²θ, finite for no angle at all: those of the delta. θ ≤ π/2.
    pub(in crate::sh) fn per_facing_irradiance(self) -> Self {
        Self { first: [2.0 / (1.0 + self.cos), 0.0], scale: 2.0, ..self }
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
        let value = if l == 0.0 { self.first[0] } else { self.scale * self.slope[0] / (l * (l + 1.0)) };
        self.slope = [self.slope[1] + (2.0 * l + 1.0) * self.p[0], self.slope[0]];
        let up = self.cos * self.p[0];
        self.p = [up + l / (l + 1.0) * (up - self.p[1]), self.p[0]];
        self.l = l + 1.0;
        Some(value)
    }
}
