//! Whose values a lobe has: a model that brings its kernel, or a BRDF of which only values are known.

use std::sync::Arc;

use nalgebra::Vector3;

use crate::scene::{Axes, Brdf, Kernel, KernelVisitor, Lobe, Shape, Structure, narrow};

/// Whose values a lobe has.
#[derive(Debug, Clone)]
pub(super) enum LobeSource {
    Known(Lobe),
    /// Nothing is known but its values.
    Opaque(Arc<dyn Brdf>),
}

impl LobeSource {
    pub(super) fn is_opaque(&self) -> bool {
        matches!(self, Self::Opaque(_))
    }

    /// Hands the kernel for a viewer to `visitor`; None if the viewer is below the horizon.
    #[inline(always)]
    pub(super) fn visit<V: KernelVisitor>(&self, axes: &Axes, wo: &Vector3<f64>, visitor: V) -> Option<V::Output> {
        match self {
            Self::Known(lobe) => lobe.visit(axes, wo, visitor),
            Self::Opaque(brdf) => Some(visitor.visit(Eval { brdf: brdf.as_ref(), axes, wo: axes.to_local(wo) })),
        }
    }

    /// The exponent of a Phong lobe about as wide, for the fixed rule; None: as smooth as a cosine.
    pub(super) fn equivalent_exponent(&self) -> Option<f64> {
        let Self::Known(lobe) = self else { return None };
        match lobe.shape() {
            Shape::Cosine => None,
            Shape::Mirror { exponent } => Some(exponent),
            // A half vector turns half as far as the direction: exponents are four times as large for the same width.
            Shape::Half { exponent } => Some(exponent / 4.0),
            Shape::Microfacets { alpha, .. } => Some(0.5 / alpha[0].min(alpha[1]).powi(2)),
        }
    }
}

/// Any BRDF as a kernel, in `f64`.
#[derive(Clone, Copy)]
struct Eval<'a> {
    brdf: &'a dyn Brdf,
    axes: &'a Axes,
    /// The direction to the viewer in the frame of `axes`.
    wo: Vector3<f64>,
}

impl Kernel<3> for Eval<'_> {
    const APART: bool = true;

    #[inline(always)]
    fn at(&self, d: [f32; 3], up: f32, z: f32) -> [f32; 3] {
        if up < 0.0 {
            return [0.0; 3];
        }
        let wi = self.axes.to_local(&Vector3::from(d).cast());
        // What a closure is asked for lies above the horizon.
        let lifted = if wi.z > 0.0 { wi } else { Vector3::new(wi.x, wi.y, 1e-6).normalize() };
        narrow(&(self.brdf.eval(&lifted, &self.wo) * f64::from(z)))
    }
}

/// Whether a BRDF of which only values are known is finite wherever some thousands of them are asked for; the others
/// are.
pub(super) fn is_finite(brdf: &dyn Brdf) -> bool {
    if !matches!(brdf.structure(), Structure::Opaque | Structure::Sum(_)) {
        return true;
    }
    // Rings from the zenith to just above the horizon, of odd numbers of directions: no plane of symmetry holds all.
    let rings = |rings: usize, around: usize| {
        (0..rings * around).map(move |i| {
            let z = 1.0 - (i / around) as f64 / rings as f64 * 0.999;
            let (sin, cos) = ((i % around) as f64 / around as f64 * std::f64::consts::TAU + 0.1).sin_cos();
            let flat = (1.0 - z * z).sqrt();
            Vector3::new(flat * cos, flat * sin, z)
        })
    };
    rings(4, 7).all(|wo| rings(10, 15).all(|wi| brdf.eval(&wi, &wo).iter().all(|c| c.is_finite())))
}

/// Whether a BRDF says that it is isotropic, or is so wherever it is looked at: a closure says nothing.
pub(super) fn is_isotropic(brdf: &dyn Brdf) -> bool {
    const PAIRS: usize = 2048;
    let direction = |i: usize| {
        // Points of the golden spiral, of equal solid angle each.
        let (z, azimuth) = ((i % PAIRS) as f64 + 0.5, i as f64 * 2.399_963_229_728_653);
        let z = 1.0 - z / PAIRS as f64;
        let flat = (1.0 - z * z).sqrt();
        Vector3::new(flat * azimuth.cos(), flat * azimuth.sin(), z)
    };
    let is_same = |i: usize| {
        let (wi, wo) = (direction(i), direction(i * 1_237 + 511));
        let (s, c) = (1.0 + i as f64).sin_cos();
        let turned = |d: &Vector3<f64>| Vector3::new(c * d.x - s * d.y, s * d.x + c * d.y, d.z);
        let mirrored = |d: &Vector3<f64>| Vector3::new(d.x, -d.y, d.z);
        let value = brdf.eval(&wi, &wo);
        let is_near = |other: Vector3<f64>| (other - value).amax() <= 1e-9 * value.amax();
        is_near(brdf.eval(&turned(&wi), &turned(&wo))) && is_near(brdf.eval(&mirrored(&wi), &mirrored(&wo)))
    };
    brdf.is_isotropic() || (0..PAIRS).all(is_same)
}
