//! Which part of the plane above a point is cut into cells.

use nalgebra::{Vector2, Vector3};

use crate::affine::AffineMap;

/// Which part of the plane above a point is cut into cells.
///
/// The plane lies at distance 1 above the point and along the light's; the face is the square of it that
/// [`TopFace`](crate::sphere::TopFace) has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Window {
    /// The whole face, wherever the light is [Sun 2008, §4.6.1]. A light that is small or far away has few cells.
    Face,
    /// The part of the face in which the upright rectangle around the light lies, and all of that rectangle if no part
    /// of it is in the face.
    #[default]
    Light,
}

/// A rectangle of the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rectangle {
    low: Vector2<f64>,
    size: Vector2<f64>,
}

impl Rectangle {
    /// The window towards a light of an extent whose centre lies at `to`, and the maps of the light in it: coordinate w
    /// of the window sees s w + o of the extent.
    ///
    /// ```math
    /// s = z size/W,  o = ½ + (z low − x)/W            (low = −size/2: [Sun 2008, eq. 4.34])
    /// ```
    pub(super) fn new(
        window: Window,
        face: f64,
        extent: [f64; 2],
        to: &Vector3<f64>,
    ) -> Option<(Self, [AffineMap; 2])> {
        if !(to.z > 0.0) {
            return None;
        }
        let half = 0.5 * face;
        let ends = [0, 1].map(|axis| {
            let light = [-0.5, 0.5].map(|side| (to[axis] + side * extent[axis]) / to.z);
            match window {
                Window::Face => ([-half, half], None),
                Window::Light => (light.map(|end| end.clamp(-half, half)), Some(light)),
            }
        });
        let outside = ends.iter().any(|(window, _)| window[0] >= window[1]);
        let mut maps = [AffineMap::IDENTITY; 2];
        let mut rectangle = Self { low: Vector2::zeros(), size: Vector2::zeros() };
        for (axis, (window, light)) in ends.into_iter().enumerate() {
            let window = if outside { light.unwrap_or(window) } else { window };
            (rectangle.low[axis], rectangle.size[axis]) = (window[0], window[1] - window[0]);
            if light != Some(window) {
                let scale = to.z * rectangle.size[axis] / extent[axis];
                maps[axis] = AffineMap::new(scale, 0.5 + (to.z * window[0] - to[axis]) / extent[axis]).ok()?;
            }
        }
        let is_sound =
            |r: &Self| r.size.iter().all(|w| *w > 0.0 && w.is_finite()) && r.low.iter().all(|w| w.is_finite());
        is_sound(&rectangle).then_some((rectangle, maps))
    }

    /// The point v of the plane at a coordinate w ∈ [0, 1]².
    #[inline(always)]
    pub(super) fn point(&self, w: [f64; 2]) -> Vector2<f64> {
        self.low + self.size.component_mul(&Vector2::from(w))
    }

    /// The coordinate w of a point of the plane.
    pub(super) fn coordinate(&self, v: &Vector2<f64>) -> [f64; 2] {
        (v - self.low).component_div(&self.size).into()
    }

    /// dω/dw at a point of the plane.
    pub(super) fn solid_angle(&self, v: &Vector2<f64>) -> f64 {
        self.size.x * self.size.y * (1.0 + v.norm_squared()).powf(-1.5)
    }
}
